//! What a controller remembers between samples: its compensator's memory, the torque commanded
//! last, and the period that has begun and not ended yet.

use super::front::FrontMemory;
use super::{Applied, Sample};
use crate::error::{Result, within};
use crate::math::Vector;

/// Measurements, set-points and torques beyond this are impossible for an arm, as in MuJoCo.
pub(super) const IMPOSSIBLE: f64 = 1e10;

/// What a controller remembers between samples.
///
/// A step decides the torque of a period. The period ends when the next step tells what acted in
/// it; until then it is pending, and the compensator has not learnt from it yet.
/// [`Controller::settle`](super::Controller::settle) ends it and gives the compensator's state.
#[derive(Clone, Debug, PartialEq)]
pub struct State<const N: usize, S = ()> {
    /// The compensator's state, at the start of the pending period.
    pub(crate) compensator: S,
    /// The torque commanded last, or that was on the robot at take-over [N·m]: what the rate limit
    /// counts from. At most 1e10. `None`: the law's resting torque at the first sample.
    pub last_tau: Option<Vector<N>>,
    /// Number of samples accepted.
    pub steps: u64,
    /// The period that the last step decided on; `None` if it has ended.
    pub(crate) pending: Option<Pending<N>>,
    /// What stands before the law remembers.
    pub(crate) front: FrontMemory<N>,
}

impl<const N: usize, S> State<N, S> {
    /// A controller's state before its first sample.
    pub fn new(compensator: S) -> Self {
        let front = FrontMemory::new();
        Self { compensator, last_tau: None, steps: 0, pending: None, front }
    }

    /// Hands over anew at the next sample, as for another reference; see
    /// [`Front::hand_over`](super::Front::hand_over).
    pub fn hand_over(&mut self) {
        self.front.begin();
    }

    /// States the torque that is on the robot when the controller takes over [N·m]. The first
    /// sample's torque is then within the rate limit of it.
    ///
    /// # Errors
    /// `last_tau`: not finite, or beyond 1e10.
    pub fn take_over(&mut self, last_tau: &Vector<N>) -> Result<()> {
        check_torque("last_tau", last_tau)?;
        self.last_tau = Some(*last_tau);
        Ok(())
    }

    /// The compensator's state as the last step used it: at the start of the period that is
    /// pending. [`Controller::settle`](super::Controller::settle) gives the one at its end.
    pub fn compensator(&self) -> &S {
        &self.compensator
    }

    /// What the controller saw when it decided on the period that is pending.
    #[cfg(feature = "std")]
    pub(crate) fn seen(&self) -> Option<&Sample<N>> {
        self.pending.as_ref().map(|pending| &pending.sample)
    }
}

/// A period that has begun and not ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pending<const N: usize> {
    /// What the controller saw when it decided.
    pub sample: Sample<N>,
    /// What the law asked for, and what was commanded [N·m].
    pub applied: Applied<N>,
    /// Length \[s\].
    pub dt: f64,
}

/// Refuses a torque that no arm can have.
pub(super) fn check_torque<const N: usize>(name: &'static str, tau: &Vector<N>) -> Result<()> {
    let wanted = "a torque an arm can have (at most 1e10)";
    within(name, tau.as_slice(), |x| x.abs() <= IMPOSSIBLE, wanted)
}

//! What a guard remembers between samples.

use super::{Cause, Event, Events};
use crate::control::state::check_torque;
use crate::error::Result;
use crate::math::Vector;
use crate::reference::Setpoint;

/// What a guard remembers between samples, beside the state of its controller.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GuardMemory<const N: usize> {
    pub(super) last_tau: Option<Vector<N>>,
    /// Position and velocity of the last good sample.
    pub(super) last_good: Option<[Vector<N>; 2]>,
    /// Time from it to the last call \[s\].
    pub(super) since_good: f64,
    /// Time since the last call that was not early \[s\].
    pub(super) since_call: f64,
    /// Periods since the last good sample.
    pub(super) lost: u64,
    pub(super) stopped: Option<Cause>,
    /// The set-point that slows down, once the guard has stopped.
    pub(super) slowing: Option<Setpoint<N>>,
    pub(super) counts: [u64; Event::ALL.len()],
}

impl<const N: usize> GuardMemory<N> {
    /// A memory before the first sample, around a controller whose last torque is `last_tau`.
    pub(crate) fn new(last_tau: Option<Vector<N>>) -> Self {
        Self { last_tau, ..Self::default() }
    }

    /// States the torque that is on the robot when the guard takes over [N·m]: the first torque is
    /// within the rate limit of it. Without it that is the law's resting torque at the first good
    /// sample. Until then zero is sent, from which nothing counts.
    ///
    /// # Errors
    /// `last_tau`: not finite, or beyond 1e10.
    pub fn take_over(&mut self, last_tau: &Vector<N>) -> Result<()> {
        check_torque("last_tau", last_tau)?;
        self.last_tau = Some(*last_tau);
        Ok(())
    }

    /// The torque commanded last [N·m].
    pub fn last_tau(&self) -> Option<&Vector<N>> {
        self.last_tau.as_ref()
    }

    /// Why the guard has stopped; `None` while it runs.
    pub fn stopped(&self) -> Option<Cause> {
        self.stopped
    }

    /// Periods in a row without a good sample.
    pub fn lost(&self) -> u64 {
        self.lost
    }

    /// How many calls an event happened in; of [`Event::Missed`], how many periods.
    pub fn count(&self, event: Event) -> u64 {
        self.counts[event as usize]
    }

    /// Lets a guard that has stopped run again from the next sample on. That sample may be
    /// anywhere; the set-point should be near it.
    pub fn rearm(&mut self) {
        let Self { last_tau, counts, .. } = *self;
        *self = Self { last_tau, counts, ..Self::default() };
    }

    /// Counts from zero again.
    #[cfg(feature = "python")]
    pub(crate) fn recount(&mut self) {
        self.counts = [0; Event::ALL.len()];
    }

    /// Whether the latest call brought a good sample, so that its velocity is known.
    pub(super) fn sees(&self) -> Option<&[Vector<N>; 2]> {
        self.last_good.as_ref().filter(|_| self.since_good == 0.0)
    }

    pub(super) fn add(&mut self, events: Events) {
        for event in events.iter() {
            let count = &mut self.counts[event as usize];
            *count = count.saturating_add(1);
        }
    }
}

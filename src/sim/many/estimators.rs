//! The compensators of eight runs, each as it is, one after the other.

use super::Case;
use super::abreast::{lane, side_by_side};
use crate::control::{Applied, Compensator, Law, Sample, Stage};
use crate::math::{Abreast, LANES, Vector};
use crate::reference::Setpoint;

/// The compensators of eight runs with their states.
pub(super) struct Estimators<'a, const N: usize, C, S> {
    each: [(&'a C, S); LANES],
}

impl<'a, const N: usize, C: Compensator<N, S>, S: Clone> Estimators<'a, N, C, S> {
    /// Those of these runs, at their start.
    pub fn new<A, D, L: Law<N>, R>(cases: [&'a Case<'a, N, A, D, L, C, R, S>; LANES]) -> Self {
        let each = cases.map(|case| {
            let mut state = case.state.clone();
            (&case.controller.compensator, case.controller.settle(&mut state).clone())
        });
        Self { each }
    }
}

impl<const N: usize, C: Compensator<N, S>, S> Estimators<'_, N, C, S> {
    /// ρ̂ of each at a stage.
    #[inline(always)]
    pub fn estimate(&mut self, stage: &Stage<'_>, seen: &Sample<N, Abreast>) -> Vector<N, Abreast> {
        let mut estimates = [Vector::zeros(); LANES];
        for (i, (compensator, state)) in self.each.iter_mut().enumerate() {
            estimates[i] = compensator.estimate(state, stage, &sample(seen, i));
        }
        side_by_side(&estimates)
    }

    /// Tells each the torque that acts at a stage, and the one that was asked for.
    #[inline(always)]
    pub fn acted(
        &mut self,
        index: usize,
        seen: &Sample<N, Abreast>,
        asked: &Vector<N, Abreast>,
        applied: &Vector<N, Abreast>,
    ) {
        for (i, (compensator, state)) in self.each.iter_mut().enumerate() {
            let acted = Applied::new(lane(asked, i), lane(applied, i));
            compensator.acted(state, index, &sample(seen, i), &acted);
        }
    }

    /// Moves each to the end of a step; one that cannot is `lost`.
    #[inline(always)]
    pub fn advance(&mut self, end: &Stage<'_>, lost: &mut Abreast) {
        for (i, (compensator, state)) in self.each.iter_mut().enumerate() {
            if compensator.advance(state, end).is_err() {
                lost.0[i] = f64::NAN;
            }
        }
    }
}

/// What the controller in a lane sees.
#[inline(always)]
fn sample<const N: usize>(seen: &Sample<N, Abreast>, i: usize) -> Sample<N> {
    let Sample { q, dq, desired, e, de } = seen;
    let Setpoint { q: q_d, dq: dq_d, ddq: ddq_d } = desired;
    let desired = Setpoint { q: lane(q_d, i), dq: lane(dq_d, i), ddq: lane(ddq_d, i) };
    Sample { q: lane(q, i), dq: lane(dq, i), desired, e: lane(e, i), de: lane(de, i) }
}

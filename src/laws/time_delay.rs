//! Time-delay control: what the model left out in the last period is left out in this one too,
//! `τ = τ_a + M̄(v − (q̇ − q̇₋₁)/h)`, that is `ρ̂ = (q̇ − q̇₋₁)/h − M̄⁻¹τ_a` for computed torque on
//! an arm that has the inertia M̄ alone.
//!
//! τ_a is the torque that acted. Sampled only. Stable where ‖I − M⁻¹M̄‖ < 1; of order 1 in the
//! period. Source: Youcef-Toumi and Ito 1990; Hsia 1989.

use crate::arm::{Arm, Factor};
use crate::control::{Applied, Audit, Compensator, Sample, Stage};
use crate::error::Result;
use crate::math::Vector;

/// The memory of one sample as a compensator.
#[derive(Clone, Copy, Debug)]
pub struct TimeDelay<A> {
    /// What is known of the inertia.
    pub arm: A,
}

/// What was seen in the last period, and what acted in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeDelayState<const N: usize> {
    past: Option<Past<N>>,
    dq: Vector<N>,
    tau: Vector<N>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Past<const N: usize> {
    dq: Vector<N>,
    tau: Vector<N>,
    dt: f64,
}

impl<const N: usize> TimeDelayState<N> {
    /// The memory before the first sample.
    pub fn new() -> Self {
        Self { past: None, dq: Vector::zeros(), tau: Vector::zeros() }
    }
}

impl<const N: usize> Default for TimeDelayState<N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const N: usize, A: Arm<N>> Compensator<N, TimeDelayState<N>> for TimeDelay<A> {
    fn estimate(
        &self,
        state: &mut TimeDelayState<N>,
        _: &Stage<'_>,
        seen: &Sample<N>,
    ) -> Vector<N> {
        state.dq = seen.dq;
        let Some(Past { dq, tau, dt }) = &state.past else { return Vector::zeros() };
        (seen.dq - dq) / *dt - Factor::of(&self.arm.mass_matrix(&seen.q)).solve(tau)
    }

    fn acted(&self, state: &mut TimeDelayState<N>, _: usize, _: &Sample<N>, applied: &Applied<N>) {
        state.tau = applied.tau;
    }

    fn advance(&self, state: &mut TimeDelayState<N>, end: &Stage<'_>) -> Result<()> {
        state.past = Some(Past { dq: state.dq, tau: state.tau, dt: end.step });
        Ok(())
    }

    fn reset(&self, state: &mut TimeDelayState<N>) {
        *state = TimeDelayState::new();
    }

    fn sampled_only(&self) -> bool {
        true
    }

    fn audit(&self, _: &TimeDelayState<N>, _: usize, _: &Sample<N>) -> Option<Audit<N>> {
        None
    }
}

//! Control laws: a base law for the nominal arm plus a compensator for what the model leaves out,
//! `τ = M₀(v − ρ̂) + H₀` (eqs. 7, 11, 12).

mod adaptation;
mod channel;
mod computed_torque;
mod fuzzy_compensator;
mod inputs;
mod kernel_compensator;
mod law;
mod limits;
mod memory;
#[cfg(feature = "std")]
mod saved;
mod stages;

pub use adaptation::Adaptation;
pub use channel::{Channel, Width};
#[cfg(feature = "std")]
pub(crate) use computed_torque::check_period;
pub use computed_torque::{Command, ComputedTorque, Gains, State};
pub use fuzzy_compensator::{FuzzyCompensator, FuzzyParameters, FuzzyState};
pub use inputs::{Inputs, Signal};
pub use kernel_compensator::{KernelCompensator, KernelParameters, KernelState};
pub use limits::Limits;
pub use memory::Buffer;
pub use stages::MAX_STAGES;

use crate::error::Result;
use crate::math::{Vector, around};
use crate::reference::Setpoint;

/// What a controller sees at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample<const N: usize> {
    /// Measured position q [rad].
    pub q: Vector<N>,
    /// Measured velocity q̇ [rad/s].
    pub dq: Vector<N>,
    /// Where the arm should be.
    pub desired: Setpoint<N>,
    /// Tracking error e = q − q_d [rad], in [−π, π) for a joint that turns without an end.
    pub e: Vector<N>,
    /// ė = q̇ − q̇_d [rad/s].
    pub de: Vector<N>,
}

impl<const N: usize> Sample<N> {
    /// Measurement and set-point, with their difference, for an arm none of whose joints turns without an end.
    #[inline]
    pub fn new(q: Vector<N>, dq: Vector<N>, desired: Setpoint<N>) -> Self {
        Self { q, dq, desired, e: q - desired.q, de: dq - desired.dq }
    }

    /// As [`new`](Self::new), with the error of the joints that [`Arm::wraps`](crate::arm::Arm::wraps) names taken around
    /// the circle: −π ≤ e < π. q and q_d stay as they are.
    #[inline]
    pub fn wrapped(q: Vector<N>, dq: Vector<N>, desired: Setpoint<N>, wraps: &[bool; N]) -> Self {
        let mut e = q - desired.q;
        // Asked of all joints at once: most arms have none.
        if wraps.iter().fold(false, |any, wraps| any | wraps) {
            e = around_where(wraps, &e);
        }
        Self { q, dq, desired, e, de: dq - desired.dq }
    }
}

/// The error of the joints that wrap around the circle. Out of the way of arms without such joints.
#[inline(never)]
fn around_where<const N: usize>(wraps: &[bool; N], e: &Vector<N>) -> Vector<N> {
    Vector::from_fn(|n, _| if wraps[n] { around(e[n]) } else { e[n] })
}

/// One row of a Runge-Kutta tableau: `z = z₀ + h Σ aⱼ żⱼ` at time `t₀ + c h`.
///
/// A compensator's state z never enters an integrator: it is told the row and keeps its own rates żⱼ.
#[derive(Clone, Copy, Debug)]
pub struct Stage<'a> {
    /// Number of the stage, below [`MAX_STAGES`].
    pub index: usize,
    /// Step h [s].
    pub step: f64,
    /// c, as a fraction of the step.
    pub node: f64,
    /// aⱼ for the stages j before this one.
    pub coefficients: &'a [f64],
    /// cⱼ of those stages.
    pub nodes: &'a [f64],
}

impl Stage<'_> {
    /// The sampled controller's only stage: now.
    pub const NOW: Stage<'static> =
        Stage { index: 0, step: 0.0, node: 0.0, coefficients: &[], nodes: &[] };

    /// The end of a sampled controller's period `dt` [s]: one Euler step from [`NOW`](Self::NOW).
    pub fn after(dt: f64) -> Stage<'static> {
        Stage { index: 1, step: dt, node: 1.0, coefficients: &[1.0], nodes: &[0.0] }
    }
}

/// A way to produce ρ̂ [rad/s²], the estimate of what the nominal model leaves out.
///
/// Configuration is `&self`; all that changes is in the state `S`, which the caller owns.
pub trait Compensator<const N: usize, S> {
    /// ρ̂ at a stage; records there the rate of change of the state.
    fn estimate(&self, state: &mut S, stage: &Stage<'_>, sample: &Sample<N>) -> Vector<N>;

    /// Sets the recorded rate of stage `index` to zero (the torque was limited: nothing is to be learnt).
    fn hold(&self, state: &mut S, index: usize);

    /// Moves the state to the end of the step, from the recorded rates.
    ///
    /// # Errors
    /// When the new state would not be finite; the state is then as before.
    fn advance(&self, state: &mut S, end: &Stage<'_>) -> Result<()>;

    /// After [`advance`](Self::advance): makes stage `last`, which was at the end of the step, stage 0 of the next step.
    /// False, as by default, if it cannot, or the state is not what it was there: the stage is then evaluated again.
    fn carry(&self, _state: &mut S, _last: usize) -> bool {
        false
    }

    /// Forgets everything: the state is then as a new one, to the bit, and adapts.
    fn reset(&self, state: &mut S);

    /// The terms of the dissipation identity at stage `index`; `None` for a compensator without a proof.
    fn audit(&self, state: &S, index: usize, sample: &Sample<N>) -> Option<Audit<N>>;

    /// Signals of its own, which enter a record beside those that every record has; none by default.
    fn channels(&self) -> &'static [Channel] {
        &[]
    }

    /// Writes their values, finite, at the stage that was estimated last: one channel after the other
    /// into a `row` that is as long as they are wide.
    fn signals(&self, _state: &S, _sample: &Sample<N>, _row: &mut [f64]) {}
}

/// The dissipation identity at one stage: `V̇ = 2 s·ρ − loss`, exact for the law (18) with (19) and W* = W₀.
///
/// With `x = [e; ė]`, `s = BᵀPx` and `D = W − W₀`: `V = xᵀPx + Σₙ |Dₙ|²/gainₙ` and
/// `loss = xᵀQx + γ⁻²|s|² + 2 s·W₀ξ + (what the robust modifications take)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Audit<const N: usize> {
    /// V at this stage.
    pub value: f64,
    /// xᵀQx.
    pub state_cost: f64,
    /// s = BᵀPx.
    pub s: Vector<N>,
    /// W₀ξ, the part of ρ̂ that was there before the run [rad/s²].
    pub prior: Vector<N>,
    /// 2 s·ρ − V̇.
    pub loss: f64,
    /// γ of (19).
    pub gamma: f64,
    /// |W − W₀|, Frobenius.
    pub weights_norm: f64,
}

/// No compensation: ρ̂ = 0, plain computed torque.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NoCompensation;

impl<const N: usize> Compensator<N, ()> for NoCompensation {
    fn estimate(&self, (): &mut (), _: &Stage<'_>, _: &Sample<N>) -> Vector<N> {
        Vector::zeros()
    }

    fn hold(&self, (): &mut (), _: usize) {}

    fn advance(&self, (): &mut (), _: &Stage<'_>) -> Result<()> {
        Ok(())
    }

    fn carry(&self, (): &mut (), _: usize) -> bool {
        true
    }

    fn reset(&self, (): &mut ()) {}

    fn audit(&self, (): &(), _: usize, _: &Sample<N>) -> Option<Audit<N>> {
        None
    }
}

//! What a compensator is: `ρ̂` at the stages of a Runge-Kutta step, and a memory that moves with
//! the step.

use super::{Applied, Channel, Learns, Sample};
use crate::error::Result;
use crate::math::Vector;

/// One row of a Runge-Kutta tableau: `z = z₀ + h Σ aⱼ żⱼ` at time `t₀ + c h`.
///
/// A compensator's state z never enters an integrator. The compensator is told the row, and keeps
/// its own rates żⱼ.
#[derive(Clone, Copy, Debug)]
pub struct Stage<'a> {
    /// Number of the stage, below [`MAX_STAGES`](super::MAX_STAGES).
    pub index: usize,
    /// Step h \[s\].
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

    /// The end of a sampled controller's period `dt` \[s\]: one Euler step from
    /// [`NOW`](Self::NOW).
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

    /// After [`estimate`](Self::estimate): tells what acted at stage `index`. An observer uses the
    /// torque. A compensator that learns from the error sets the recorded rate to zero where the
    /// torque was [limited](Applied::limited).
    fn acted(&self, state: &mut S, index: usize, sample: &Sample<N>, applied: &Applied<N>);

    /// Before anything of a sampled controller's step changes: whether the state can be finite at
    /// the end of a period of `dt` \[s\] that starts with this sample. By default it can.
    ///
    /// # Errors
    /// Naming what would not be finite, such as `weights`.
    #[inline]
    fn admit(&self, _state: &S, _sample: &Sample<N>, _dt: f64) -> Result<()> {
        Ok(())
    }

    /// Moves the state to the end of the step, from the recorded rates.
    ///
    /// # Errors
    /// When the new state would not be finite; the state is then as before.
    fn advance(&self, state: &mut S, end: &Stage<'_>) -> Result<()>;

    /// In place of [`advance`](Self::advance) while learning is stopped: moves what is no memory of
    /// learning, such as filters and observers. The default moves nothing.
    ///
    /// # Errors
    /// As [`advance`](Self::advance).
    fn coast(&self, _state: &mut S, _end: &Stage<'_>) -> Result<()> {
        Ok(())
    }

    /// After [`advance`](Self::advance): makes stage `last`, at the end of the step, stage 0 of the
    /// next step. False if it cannot, or if the state has changed since that stage. The stage is
    /// then evaluated again. The default is false.
    fn carry(&self, _state: &mut S, _last: usize) -> bool {
        false
    }

    /// Forgets everything: the state is then as a new one, to the bit, and adapts.
    fn reset(&self, state: &mut S);

    /// The terms of the dissipation identity at stage `index`; `None` for a compensator without a
    /// proof.
    fn audit(&self, state: &S, index: usize, sample: &Sample<N>) -> Option<Audit<N>>;

    /// What of it is put beside others, from this state on, for many runs at a time; `None` where
    /// it cannot be: it is then asked by itself.
    fn learns<'a>(&'a self, _state: &'a S) -> Option<Learns<'a, N>> {
        None
    }

    /// Whether it works from sample to sample alone: simulation in continuous time is refused then.
    /// The default is false.
    fn sampled_only(&self) -> bool {
        false
    }

    /// Its gains and what it has learnt, as named numbers to look at; what has several rows is put
    /// row by row. None by default.
    fn describe(&self, _state: &S, _put: &mut dyn FnMut(&'static str, &[f64])) {}

    /// Signals of its own, which enter a record beside those that every record has; none by
    /// default.
    fn channels(&self) -> &'static [Channel] {
        &[]
    }

    /// Writes their values at the stage that was estimated last, finite, one channel after the
    /// other. `row` is as long as all channels together.
    fn signals(&self, _state: &S, _sample: &Sample<N>, _row: &mut [f64]) {}
}

/// The dissipation identity at one stage: `V̇ = 2 s·ρ − loss`, exact for the update law (18) with
/// (19) and W* = W₀.
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
    fn learns<'a>(&'a self, (): &'a ()) -> Option<Learns<'a, N>> {
        Some(Learns::NOTHING)
    }

    fn estimate(&self, (): &mut (), _: &Stage<'_>, _: &Sample<N>) -> Vector<N> {
        Vector::zeros()
    }

    #[inline]
    fn acted(&self, (): &mut (), _: usize, _: &Sample<N>, _: &Applied<N>) {}

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

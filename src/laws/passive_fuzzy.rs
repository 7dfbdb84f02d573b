//! The passivity form of the fuzzy law: `τ = M₀a_r + C₀v_r + G₀ + f₀ − K_D s − Wξ(z)`,
//! `Ẇ = g s ξᵀ`, for the law [`Passive`](super::Passive) with the same Λ.
//!
//! Wξ is a torque, so that no inverse of the real M comes between error and weights: with what no
//! weights can do, ε, `V = ½sᵀMs + ½ Σ |W̃ₙ|²/gₙ` has `V̇ = −sᵀK_D s + sᵀε`. W holds while the
//! torque is limited. Source: Lewis, Yeşildirek, Liu 1996.

use super::bandwidth::{inertia_weights, sliding_weights};
use crate::arm::{Arm, Factor};
use crate::control::{
    Adaptation, Applied, Audit, Buffer, Compensator, FuzzyCompensator, FuzzyParameters, Gains,
    Inputs, KernelCompensator, KernelParameters, Sample, Saves, Stage,
};
use crate::error::{Result, positive};
use crate::fuzzy::{FuzzyBasis, KernelBasis};
use crate::math::Vector;

/// A fuzzy or kernel compensator whose estimate is a torque.
#[derive(Clone, Debug)]
pub struct PassiveFuzzy<A, C> {
    arm: A,
    approximator: C,
}

impl<const N: usize, A: Arm<N>, T: Buffer> PassiveFuzzy<A, FuzzyCompensator<N, T>> {
    /// The weights of a fuzzy basis over these inputs, with Λ = `lambda` [1/s] of the law; g is the
    /// gain of `adaptation`.
    ///
    /// # Errors
    /// `lambda`: not finite or not > 0. What [`FuzzyCompensator::new`] names.
    pub fn new(
        arm: A,
        basis: FuzzyBasis<T>,
        lambda: [f64; N],
        inputs: Inputs,
        adaptation: Adaptation<N>,
    ) -> Result<Self> {
        let (gains, parameters) = sliding_parameters(lambda, inputs, adaptation)?;
        Ok(Self { arm, approximator: FuzzyCompensator::new(basis, &gains, parameters)? })
    }

    /// The same from the bandwidth p [rad/s] of [`Passive::with_bandwidth`]: Λ = p, and
    /// g = p²D/4|ξ|² of the largest |ξ|, D the mean of M₀'s diagonal. Where M = D, both poles of s
    /// are at −p/2 at the fastest.
    ///
    /// # Errors
    /// `bandwidth`, `mass_matrix`: not finite or not > 0. What [`FuzzyCompensator::new`] names.
    ///
    /// [`Passive::with_bandwidth`]: super::Passive::with_bandwidth
    pub fn with_bandwidth(
        arm: A,
        basis: FuzzyBasis<T>,
        bandwidth: [f64; N],
        inputs: Inputs,
    ) -> Result<Self> {
        positive("bandwidth", &bandwidth)?;
        let (weights, largest) = (inertia_weights(&arm)?, basis.xi_bound());
        let share = |n: usize| bandwidth[n] / largest;
        let gain = core::array::from_fn(|n| 0.25 * weights[n] * share(n) * share(n));
        Self::new(arm, basis, bandwidth, inputs, Adaptation { gain, ..Adaptation::default() })
    }
}

impl<const N: usize, A: Arm<N>, T: Buffer> PassiveFuzzy<A, KernelCompensator<N, T>> {
    /// The same with the product grid in kernel form.
    ///
    /// # Errors
    /// As [`new`](PassiveFuzzy::new). What [`KernelCompensator::new`] names.
    pub fn kernel(
        arm: A,
        basis: KernelBasis<T>,
        lambda: [f64; N],
        inputs: Inputs,
        adaptation: Adaptation<N>,
        kernel: KernelParameters,
    ) -> Result<Self> {
        let (gains, parameters) = sliding_parameters(lambda, inputs, adaptation)?;
        Ok(Self { arm, approximator: KernelCompensator::new(basis, &gains, parameters, kernel)? })
    }
}

impl<A, C> PassiveFuzzy<A, C> {
    /// The weights, and how they move. Its state is that of this compensator.
    pub fn approximator(&self) -> &C {
        &self.approximator
    }
}

/// Gains and Q with which BᵀPx = s.
fn sliding_parameters<const N: usize>(
    lambda: [f64; N],
    inputs: Inputs,
    adaptation: Adaptation<N>,
) -> Result<(Gains<N>, FuzzyParameters<N>)> {
    let gains = Gains::with_bandwidth(lambda).map_err(|error| error.named("lambda"))?;
    let [q_position, q_velocity] = sliding_weights(&lambda);
    let gamma = f64::INFINITY;
    Ok((gains, FuzzyParameters { inputs, q_position, q_velocity, gamma, adaptation }))
}

impl<const N: usize, A: Arm<N>, S, C: Compensator<N, S>> Compensator<N, S> for PassiveFuzzy<A, C> {
    /// ρ̂ = M₀⁻¹Wξ.
    fn estimate(&self, state: &mut S, stage: &Stage<'_>, seen: &Sample<N>) -> Vector<N> {
        let torque = self.approximator.estimate(state, stage, seen);
        Factor::of(&self.arm.mass_matrix(&seen.q)).solve(&torque)
    }

    fn acted(&self, state: &mut S, index: usize, seen: &Sample<N>, applied: &Applied<N>) {
        self.approximator.acted(state, index, seen, applied);
    }

    fn admit(&self, state: &S, seen: &Sample<N>, dt: f64) -> Result<()> {
        self.approximator.admit(state, seen, dt)
    }

    fn advance(&self, state: &mut S, end: &Stage<'_>) -> Result<()> {
        self.approximator.advance(state, end)
    }

    fn carry(&self, state: &mut S, last: usize) -> bool {
        self.approximator.carry(state, last)
    }

    fn reset(&self, state: &mut S) {
        self.approximator.reset(state);
    }

    /// None: (19) has no part in this form.
    fn audit(&self, _: &S, _: usize, _: &Sample<N>) -> Option<Audit<N>> {
        None
    }
}

impl<const N: usize, A: Arm<N>, S, C: Saves<N, S>> Saves<N, S> for PassiveFuzzy<A, C> {
    fn known_flags(&self) -> u64 {
        self.approximator.known_flags()
    }

    fn entries(&self) -> &'static str {
        self.approximator.entries()
    }

    fn size(&self) -> usize {
        self.approximator.size()
    }

    fn fingerprints(&self) -> [u64; 2] {
        self.approximator.fingerprints()
    }

    fn flags(&self, state: &S) -> u64 {
        self.approximator.flags(state)
    }

    fn has_counter(&self) -> bool {
        self.approximator.has_counter()
    }

    fn advances(&self, state: &S) -> u64 {
        self.approximator.advances(state)
    }

    fn write(&self, state: &S, put: &mut dyn FnMut(&[u8])) {
        self.approximator.write(state, put);
    }

    fn check(&self, flags: u64, part: &[u8]) -> Result<()> {
        self.approximator.check(flags, part)
    }

    fn take(&self, state: &mut S, flags: u64, advances: u64, part: &[u8]) {
        self.approximator.take(state, flags, advances, part);
    }
}

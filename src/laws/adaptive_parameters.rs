//! Slotine and Li's adaptation of inertial parameters: `τ_c = Y(q, q̇, v_r, a_r) θ̃`,
//! `θ̃' = −Γ Yᵀs`, for the law [`Passive`](super::Passive) with the same Λ; θ̃ is what is added to
//! the nominal parameters.
//!
//! With the true parameters `V = ½sᵀMs + ½(θ̃ − θ̃*)ᵀΓ⁻¹(θ̃ − θ̃*)` falls at the rate sᵀK_D s. θ̃
//! holds while the torque is limited. Source: Slotine and Li, 1987.

use super::bandwidth::{Pace, adaptation_gain, joint_scales};
use super::sliding;
use crate::arm::{Factor, Parametric, Regressor};
use crate::control::{Applied, Dynamic, Sample};
use crate::error::{Result, positive};
use crate::math::{FNV_START, Vector, fnv_of};

/// The adaptation of the nominal arm's parameters.
#[derive(Clone, Copy, Debug)]
pub struct AdaptiveParameters<const N: usize, const K: usize, A> {
    arm: A,
    lambda: [f64; N],
    gain: [f64; K],
}

impl<const N: usize, const K: usize, A: Parametric<N, K>> AdaptiveParameters<N, K, A> {
    /// The adaptation with Λ = `lambda` [1/s] of the law and Γ = diag(`gain`).
    ///
    /// # Errors
    /// `lambda`, `gain`: not finite or not > 0.
    pub fn new(arm: A, lambda: [f64; N], gain: [f64; K]) -> Result<Self> {
        positive("lambda", &lambda)?;
        positive("gain", &gain)?;
        Ok(Self { arm, lambda, gain })
    }

    /// One gain for all parameters, for the bandwidth p [rad/s] of [`Passive::with_bandwidth`] and
    /// a pace: 4 Γ Σₙ |Yₙ|²/pₙ²Dₙ = 1 at the one of 24 poses where it acts most, Yₙ a row of Y.
    /// Where M = D, both poles of s are then at −p/2 at the fastest.
    ///
    /// # Errors
    /// `bandwidth`, `mass_matrix`: not finite or not > 0. `speed`, `acceleration`: not finite,
    /// negative, or nothing acts at this pace.
    ///
    /// [`Passive::with_bandwidth`]: super::Passive::with_bandwidth
    pub fn with_bandwidth(arm: A, bandwidth: [f64; N], pace: &Pace<N>) -> Result<Self> {
        positive("bandwidth", &bandwidth)?;
        let scales = joint_scales(&arm, &bandwidth)?;
        let strengths = pace
            .regressors(&arm)?
            .map(|(_, y)| (0..N).map(|n| scales[n] * y.row(n).norm_squared()).sum());
        let gain = adaptation_gain(strengths)?;
        Self::new(arm, bandwidth, [gain; K])
    }
}

impl<const N: usize, const K: usize, A: Parametric<N, K>> Dynamic<N, K>
    for AdaptiveParameters<N, K, A>
{
    /// ρ̂ = −M₀⁻¹ Y θ̃.
    fn estimate(&self, z: &Vector<K>, seen: &Sample<N>) -> Vector<N> {
        let (regressor, _) = passive_regressor(&self.arm, &self.lambda, seen);
        -Factor::of(&self.arm.mass_matrix(&seen.q)).solve(&(regressor * z))
    }

    fn rate(&self, _: &Vector<K>, seen: &Sample<N>, applied: &Applied<N>) -> Vector<K> {
        if applied.limited() {
            return Vector::zeros();
        }
        let (regressor, s) = passive_regressor(&self.arm, &self.lambda, seen);
        let shares = regressor.tr_mul(&s);
        Vector::from_fn(|k, _| -self.gain[k] * shares[k])
    }

    fn tuning(&self) -> u64 {
        fnv_of(fnv_of(FNV_START, self.lambda), self.gain)
    }
}

/// Y(q, q̇, v_r, a_r) with v_r = q̇_d − Λe, a_r = q̈_d − Λė; and s.
pub(super) fn passive_regressor<const N: usize, const K: usize>(
    arm: &impl Parametric<N, K>,
    lambda: &[f64; N],
    seen: &Sample<N>,
) -> (Regressor<N, K>, Vector<N>) {
    let Sample { q, dq, desired, e, de } = seen;
    let v_r = Vector::from_fn(|n, _| desired.dq[n] - lambda[n] * e[n]);
    let a_r = Vector::from_fn(|n, _| desired.ddq[n] - lambda[n] * de[n]);
    (arm.slotine_li_regressor(q, dq, &v_r, &a_r), sliding(lambda, seen))
}

//! Slotine and Li's adaptation of inertial parameters: `τ_c = Y(q, q̇, v_r, a_r) θ̃`,
//! `θ̃' = −Γ Yᵀs`, for the law [`Passive`](super::Passive) with the same Λ; θ̃ is what is added to
//! the nominal parameters.
//!
//! With the true parameters `V = ½sᵀMs + ½(θ̃ − θ̃*)ᵀΓ⁻¹(θ̃ − θ̃*)` falls at the rate sᵀK_D s. θ̃
//! holds while the torque is limited. Source: Slotine and Li, 1987.

use super::sliding;
use crate::arm::{Factor, Parametric, Regressor};
use crate::control::{Applied, Dynamic, Sample};
use crate::error::{Result, positive};
use crate::math::Vector;

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

    /// Y(q, q̇, v_r, a_r).
    fn regressor(&self, seen: &Sample<N>) -> Regressor<N, K> {
        let Sample { q, dq, desired, e, de } = seen;
        let v_r = Vector::from_fn(|n, _| desired.dq[n] - self.lambda[n] * e[n]);
        let a_r = Vector::from_fn(|n, _| desired.ddq[n] - self.lambda[n] * de[n]);
        self.arm.slotine_li_regressor(q, dq, &v_r, &a_r)
    }
}

impl<const N: usize, const K: usize, A: Parametric<N, K>> Dynamic<N, K>
    for AdaptiveParameters<N, K, A>
{
    /// ρ̂ = −M₀⁻¹ Y θ̃.
    fn estimate(&self, z: &Vector<K>, seen: &Sample<N>) -> Vector<N> {
        -Factor::of(&self.arm.mass_matrix(&seen.q)).solve(&(self.regressor(seen) * z))
    }

    fn rate(&self, _: &Vector<K>, seen: &Sample<N>, applied: &Applied<N>) -> Vector<K> {
        if applied.limited() {
            return Vector::zeros();
        }
        let shares = self.regressor(seen).tr_mul(&sliding(&self.lambda, seen));
        Vector::from_fn(|k, _| -self.gain[k] * shares[k])
    }
}

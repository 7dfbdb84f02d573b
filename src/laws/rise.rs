//! Robust integral of the sign of the error (RISE): with `e₂ = −(ė + α₁e)`,
//! `v = q̈_d + μ`, `μ = (k_s + 1)(e₂ − e₂(0)) + ∫ [(k_s + 1) α₂ e₂ + β sgn e₂] dt`.
//!
//! Continuous, and asymptotic for pushes that are smooth; of order 1 in the period. The integral
//! holds while the torque is limited. Source: Xian, Dawson, de Queiroz, Chen 2004.

use super::sliding_mode::Mismatch;
use super::{sign, sliding};
use crate::control::{Applied, Dynamic, Feedback, Sample, keeps_up};
use crate::error::{Result, positive, within};
use crate::math::{FNV_START, Vector, fnv_of};

/// The feedback (k_s + 1) e₂ and, as a memory, what is integrated and −(k_s + 1) e₂(0).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rise<const N: usize> {
    alpha: [[f64; N]; 2],
    ks: [f64; N],
    beta: [f64; N],
}

impl<const N: usize> Rise<N> {
    /// α₁ and α₂ [1/s], k_s [1/s], β [rad/s³].
    ///
    /// # Errors
    /// `alpha1`, `alpha2`: not finite or not > ½; `ks`, `beta`: not finite or not > 0.
    pub fn new(alpha1: [f64; N], alpha2: [f64; N], ks: [f64; N], beta: [f64; N]) -> Result<Self> {
        let half = "a number > 1/2";
        within("alpha1", &alpha1, |alpha| alpha > 0.5, half)?;
        within("alpha2", &alpha2, |alpha| alpha > 0.5, half)?;
        positive("ks", &ks)?;
        positive("beta", &beta)?;
        Ok(Self { alpha: [alpha1, alpha2], ks, beta })
    }

    /// Gains from a bandwidth p [rad/s]: α₁ = α₂ = p/2 and k_s + 1 = 3p, which feeds back ė with
    /// 3p, e with 3p² and its integral with ¾p³. What the mismatch asks for, at up to p, changes at
    /// up to L = p (a v̄ + d̄)/(1 − a) and that at up to pL; β = L + pL/α₂ = 3L is taken a tenth
    /// larger.
    ///
    /// # Errors
    /// `bandwidth`: not finite or not > 1, `beta`: not > 0, as without a mismatch; what
    /// [`Mismatch::needed`] names.
    pub fn with_bandwidth(bandwidth: [f64; N], mismatch: &Mismatch) -> Result<Self> {
        within("bandwidth", &bandwidth, |p| p > 1.0, "a number > 1: alpha = bandwidth/2 is > 1/2")?;
        let (alpha, beta) = (bandwidth.map(|p| 0.5 * p), 3.0 * mismatch.covered()?);
        Self::new(alpha, alpha, bandwidth.map(|p| 3.0 * p - 1.0), bandwidth.map(|p| p * beta))
    }

    /// Refuses gains that are too fast for a period \[s\] and a delay in samples:
    /// (k_s + 1) (½ + d) h ≤ 0.35.
    ///
    /// # Errors
    /// `ks`.
    pub fn suits(&self, period: f64, delay: f64) -> Result<()> {
        keeps_up("ks", &self.ks.map(|ks| ks + 1.0), period, delay)
    }

    /// (k_s + 1) e₂.
    fn pushed(&self, seen: &Sample<N>) -> Vector<N> {
        let s = sliding(&self.alpha[0], seen);
        Vector::from_fn(|n, _| -(self.ks[n] + 1.0) * s[n])
    }
}

impl<const N: usize> Feedback<N> for Rise<N> {
    fn acceleration(&self, seen: &Sample<N>) -> Vector<N> {
        seen.desired.ddq + self.pushed(seen)
    }

    fn tuning(&self) -> u64 {
        let of_alpha = self.alpha.iter().fold(FNV_START, |hash, of| fnv_of(hash, *of));
        fnv_of(fnv_of(of_alpha, self.ks), self.beta)
    }
}

impl<const N: usize> Dynamic<N, N> for Rise<N> {
    /// ρ̂ = (k_s + 1) e₂(0): the law starts without a jump.
    fn start(&self, seen: &Sample<N>) -> Vector<N> {
        self.pushed(seen)
    }

    fn estimate(&self, z: &Vector<N>, _: &Sample<N>) -> Vector<N> {
        *z
    }

    fn rate(&self, _: &Vector<N>, seen: &Sample<N>, applied: &Applied<N>) -> Vector<N> {
        if applied.limited() {
            return Vector::zeros();
        }
        let s = sliding(&self.alpha[0], seen);
        let pushed = self.pushed(seen);
        Vector::from_fn(|n, _| -self.alpha[1][n] * pushed[n] + self.beta[n] * sign(s[n]))
    }

    fn tuning(&self) -> u64 {
        Feedback::tuning(self)
    }
}

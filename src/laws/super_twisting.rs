//! Super-twisting on computed torque: `v = q̈_d − Λė − k₁ √|s| sgn s + w`, `ẇ = −k₂ sgn s`,
//! `s = ė + Λe`.
//!
//! s reaches 0 in finite time if the lumped acceleration changes by at most L: k₁ > 1.5 √L,
//! k₂ > 1.1 L. Sampled, the error is of order 2 in the period. w holds while the torque is limited.
//! Source: Levant 1993; Moreno and Osorio 2012.

use super::sliding_mode::Mismatch;
use super::{sign, sliding};
use crate::control::{Applied, Dynamic, Feedback, Sample, keeps_up};
use crate::error::{Result, non_negative, positive, within};
use crate::math::{FNV_START, Vector, fnv_of, sqrt};

/// The feedback and, as a memory, −w: one goes with the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SuperTwisting<const N: usize> {
    lambda: [f64; N],
    k1: [f64; N],
    k2: [f64; N],
}

impl<const N: usize> SuperTwisting<N> {
    /// `lambda` Λ [1/s], `k1` [√rad/s^1.5], `k2` [rad/s³].
    ///
    /// # Errors
    /// `lambda`, `k1`, `k2`: not finite or not > 0.
    pub fn new(lambda: [f64; N], k1: [f64; N], k2: [f64; N]) -> Result<Self> {
        positive("lambda", &lambda)?;
        positive("k1", &k1)?;
        positive("k2", &k2)?;
        Ok(Self { lambda, k1, k2 })
    }

    /// Gains from a bandwidth p [rad/s]: Λ = p. What the mismatch asks for, at up to p, changes at
    /// up to L = p (a v̄ + d̄)/(1 − a), and k₁ = 1.5 √L, k₂ = 1.1 L are taken a tenth larger.
    ///
    /// # Errors
    /// `bandwidth`, `k1`: not finite or not > 0, as without a mismatch; what [`Mismatch::needed`]
    /// names.
    pub fn with_bandwidth(bandwidth: [f64; N], mismatch: &Mismatch) -> Result<Self> {
        positive("bandwidth", &bandwidth)?;
        let needed = mismatch.needed()?;
        let rate = bandwidth.map(|p| p * needed);
        Self::new(bandwidth, rate.map(|l| 1.65 * sqrt(l)), rate.map(|l| 1.21 * l))
    }

    /// Refuses gains that are too fast for a period \[s\] and a delay in samples. With the lag
    /// δ = (½ + d) h the acceleration chatters by k₁√k₂ δ, and that is to be at most 0.35 of what w
    /// gains in 1/Λ: (k₁Λ/√k₂) δ ≤ 0.35.
    ///
    /// # Errors
    /// `k1`.
    pub fn suits(&self, period: f64, delay: f64) -> Result<()> {
        let rates: [f64; N] =
            core::array::from_fn(|n| self.k1[n] * self.lambda[n] / sqrt(self.k2[n]));
        keeps_up("k1", &rates, period, delay)
    }

    /// Refuses gains that do not reach over a lumped acceleration whose rate is up to `rate` L
    /// [rad/s³].
    ///
    /// # Errors
    /// `rate`: negative or not finite. `k1`, `k2`: not above 1.5 √L, 1.1 L.
    pub fn covers(&self, rate: f64) -> Result<()> {
        non_negative("rate", &[rate])?;
        let (k1, k2) = (1.5 * sqrt(rate), 1.1 * rate);
        within("k1", &self.k1, |k| k > k1, "more than 1.5 √rate")?;
        within("k2", &self.k2, |k| k > k2, "more than 1.1 rate")
    }
}

impl<const N: usize> Feedback<N> for SuperTwisting<N> {
    fn acceleration(&self, seen: &Sample<N>) -> Vector<N> {
        let s = sliding(&self.lambda, seen);
        Vector::from_fn(|n, _| {
            let root = self.k1[n] * sqrt(s[n].abs()) * sign(s[n]);
            seen.desired.ddq[n] - self.lambda[n] * seen.de[n] - root
        })
    }

    fn tuning(&self) -> u64 {
        [&self.lambda, &self.k1, &self.k2].into_iter().fold(FNV_START, |hash, of| fnv_of(hash, *of))
    }
}

impl<const N: usize> Dynamic<N, N> for SuperTwisting<N> {
    /// ρ̂ = −w.
    fn estimate(&self, z: &Vector<N>, _: &Sample<N>) -> Vector<N> {
        *z
    }

    fn rate(&self, _: &Vector<N>, seen: &Sample<N>, applied: &Applied<N>) -> Vector<N> {
        if applied.limited() {
            return Vector::zeros();
        }
        let s = sliding(&self.lambda, seen);
        Vector::from_fn(|n, _| self.k2[n] * sign(s[n]))
    }

    fn tuning(&self) -> u64 {
        Feedback::tuning(self)
    }
}

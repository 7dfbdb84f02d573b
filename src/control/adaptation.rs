//! How the weights move: the update law (18) and its robust modifications.
//!
//! ```text
//! Ẇₙ = m gainₙ sₙ ξᵀ − (leak_rate + kₙ)(Wₙ − W₀ₙ),     s = BᵀPx
//! m  = max(0, 1 − d₀/|s|) / (1 + ν|ξ|²)                dead zone, normalisation
//! kₙ = gainₙ (κ_e |s| + κ_p)                           e-modification, projection
//! ```
//!
//! Every modification scales the drive or pulls the weights along themselves. The change over a
//! step stays a sum of rank-one terms, and the weights never enter an integrator.

use super::Stage;
use crate::error::{Result, accepted, non_negative, positive};
use crate::math::{Real, Vector, decay, dot, sqrt};

/// The projection starts to act at this fraction of its radius (Pomet and Praly 1992).
const PROJECTION_ONSET: f64 = 0.9;

/// Gain and robust modifications of the update law. By default all modifications are off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Adaptation<const N: usize> {
    /// gain = Γ⁻¹ of each joint. The paper's Γ = diag(7, 7) is a gain of 1/7.
    pub gain: [f64; N],
    /// σ-modification as a rate [1/s]: the weights return to their prior like exp(−leak_rate t).
    pub leak_rate: f64,
    /// e-modification κ_e: as the leak, at the rate gain κ_e |s|.
    pub error_modification: f64,
    /// Radius of the ball that |W − W₀| stays in (the paper's Ω_f); infinite = none.
    pub projection_radius: f64,
    /// d₀: nothing is learnt while |s| is smaller.
    pub dead_zone: f64,
    /// ν: makes the gain independent of the number of rules that fire.
    pub normalization: f64,
}

impl<const N: usize> Default for Adaptation<N> {
    fn default() -> Self {
        Self {
            gain: [1.0; N],
            leak_rate: 0.0,
            error_modification: 0.0,
            projection_radius: f64::INFINITY,
            dead_zone: 0.0,
            normalization: 0.0,
        }
    }
}

impl<const N: usize> Adaptation<N> {
    /// Refuses what is not finite, a gain ≤ 0, negative rates.
    pub fn validate(&self) -> Result<()> {
        positive("gain", &self.gain)?;
        non_negative("leak_rate", &[self.leak_rate])?;
        non_negative("error_modification", &[self.error_modification])?;
        non_negative("dead_zone", &[self.dead_zone])?;
        non_negative("normalization", &[self.normalization])?;
        let wanted = "a radius > 0 (infinite for none)";
        accepted("projection_radius", &[self.projection_radius], |radius| radius > 0.0, wanted)
    }

    /// k_I = gain |ξ|² / (1 + ν |ξ|²) of each joint: the strength of the integrator that the law is
    /// where ξ stands still.
    #[cfg(feature = "std")]
    pub(crate) fn integral_gains(&self, xi_squared: &[f64; N]) -> [f64; N] {
        let weakened = |n: usize| xi_squared[n] / (1.0 + self.normalization * xi_squared[n]);
        core::array::from_fn(|n| self.gain[n] * weakened(n))
    }

    /// The e-modification at this |s| as a leak [1/s], of the joint where it is weakest.
    #[cfg(feature = "std")]
    pub(crate) fn slowest_pull(&self, s_norm: f64) -> f64 {
        let least = self.gain.iter().copied().fold(f64::INFINITY, f64::min);
        least * self.error_modification * s_norm
    }

    /// Whether anything pulls the weights back to their prior.
    #[inline]
    pub(super) fn pulls(&self) -> bool {
        self.leak_rate > 0.0 || self.pulls_by_state()
    }

    /// Whether that pull depends on the state (the leak does not).
    #[inline]
    pub(super) fn pulls_by_state(&self) -> bool {
        self.error_modification > 0.0 || self.projection_radius.is_finite()
    }

    /// Whether m, the factor of the drive, is anything but 1.
    #[inline]
    pub(super) fn weakens_drive(&self) -> bool {
        self.dead_zone > 0.0 || self.normalization > 0.0
    }

    /// m, the factor of the drive, for |ξ|² of the joint's rules.
    #[inline]
    pub(crate) fn drive_factor(&self, s_norm: f64, xi_squared: f64) -> f64 {
        weakened(self.dead_zone, self.normalization, s_norm, xi_squared)
    }

    /// κ_e |s| + κ_p, for the squared row norms |Dₙ|² and the growth Σ driveₙ (Dξ)ₙ of ½|D|².
    #[inline]
    pub(super) fn pull(&self, s_norm: f64, row_norms: &Vector<N>, growth: f64) -> f64 {
        let mut pull = self.error_modification * s_norm;
        if self.projection_radius.is_finite() && growth > 0.0 {
            let outer = self.projection_radius * self.projection_radius;
            let inner = PROJECTION_ONSET * PROJECTION_ONSET * outer;
            let depth = (row_norms.sum() - inner) / (outer - inner);
            if depth > 0.0 {
                let weighted: f64 = (0..N).map(|n| self.gain[n] * row_norms[n]).sum();
                pull += depth * growth / weighted;
            }
        }
        pull
    }

    /// The factor that brings a weight matrix of this squared norm back into the projection's ball.
    #[inline]
    pub(super) fn retraction(&self, norm_squared: f64) -> f64 {
        let radius = self.projection_radius;
        if norm_squared > radius * radius { radius / sqrt(norm_squared) } else { 1.0 }
    }
}

/// m of a dead zone and a normalisation, for |s| and |ξ|².
#[inline(always)]
pub(super) fn weakened<T: Real>(dead_zone: T, normalization: T, s_norm: T, xi_squared: T) -> T {
    let (zero, one) = (s_norm.like(0.0), s_norm.like(1.0));
    let zone = dead_zone.if_less(s_norm, one - dead_zone / s_norm, zero);
    zone / (one + normalization * xi_squared)
}

/// |s|.
#[inline(always)]
pub(super) fn size<const N: usize, T: Real>(s: &Vector<N, T>) -> T {
    dot(s, s).sqrt()
}

/// What is left at a stage of what was there at the fraction `from` of the step.
#[inline(always)]
pub(super) fn left(leak_rate: f64, stage: &Stage<'_>, from: f64) -> f64 {
    let leak = leak_rate * stage.step;
    if leak == 0.0 { 1.0 } else { decay(leak * (stage.node - from)) }
}

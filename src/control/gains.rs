//! Gains of a feedback, the same at all times: v = q̈_d − K_v ė − K_p e.

use super::Sample;
use crate::error::{Result, positive, within};
use crate::math::{Real, Vector};

/// Feedback gains of each joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gains<const N: usize> {
    /// K_p [1/s²].
    pub kp: [f64; N],
    /// K_v [1/s].
    pub kv: [f64; N],
}

impl<const N: usize> Gains<N> {
    /// Diagonal gains; the error dynamics ë + K_v ė + K_p e = 0 (8) are stable exactly when all are
    /// > 0.
    ///
    /// # Errors
    /// `kp`, `kv`: not finite or not > 0.
    pub fn new(kp: [f64; N], kv: [f64; N]) -> Result<Self> {
        positive("kp", &kp)?;
        positive("kv", &kv)?;
        Ok(Self { kp, kv })
    }

    /// Gains with both poles at −`bandwidth` p [rad/s]: K_p = p², K_v = 2p.
    ///
    /// # Errors
    /// `bandwidth`: not finite or not > 0.
    pub fn with_bandwidth(bandwidth: [f64; N]) -> Result<Self> {
        positive("bandwidth", &bandwidth)?;
        Self::new(bandwidth.map(|p| p * p), bandwidth.map(|p| 2.0 * p))
    }

    /// Refuses gains that are too fast for a period \[s\] and a delay in samples: what a period
    /// holds and a delay adds is late by (½ + d) h, and K_v (½ + d) h ≤ 0.35 leaves the loop its
    /// damping.
    ///
    /// # Errors
    /// `kv`.
    pub fn suits(&self, period: f64, delay: f64) -> Result<()> {
        keeps_up("kv", &self.kv, period, delay)
    }
}

/// Refuses a feedback of the velocity \[1/s\] that is too fast for a period \[s\] and a delay in
/// samples. At the crossover, near k_v, the lag k_v (½ + d) h takes so many radians of phase: 0.35
/// of the 1.3 that two poles in one place have.
pub(crate) fn keeps_up(
    parameter: &'static str,
    rates: &[f64],
    period: f64,
    delay: f64,
) -> Result<()> {
    let wanted = "a loop whose fastest rate [1/s], the number here, is at most 0.35 / ((1/2 + \
                  delay) · period): a lower bandwidth or a shorter period";
    within(parameter, rates, |rate| rate * (0.5 + delay) * period <= 0.35, wanted)
}

/// v = q̈_d − K_v ė − K_p e.
#[inline(always)]
pub(super) fn feedback<const N: usize, T: Real>(
    kp: &[T; N],
    kv: &[T; N],
    Sample { desired, e, de, .. }: &Sample<N, T>,
) -> Vector<N, T> {
    let mut v = desired.ddq;
    for n in 0..N {
        v[n] = desired.ddq[n] - kv[n] * de[n] - kp[n] * e[n];
    }
    v
}

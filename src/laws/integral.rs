//! The integral of computed torque with PID: `ρ̂ = K_I z`, `ż = e`, so that
//! `v = q̈_d − K_v ė − K_p e − K_I ∫e`.
//!
//! z holds while the torque is limited. A constant push leaves no error. Stable where
//! `k_v k_p > k_i`. Source: Lewis, Dawson, Abdallah, Robot Manipulator Control, 4.4.

use super::sliding_mode::Mismatch;
use crate::control::{Applied, Dynamic, Gains, Moved, Sample};
use crate::error::{Error, Result, positive};
use crate::math::{FNV_START, Vector, fnv_of};

/// The integral of each joint, for computed torque with these gains.
#[derive(Clone, Copy, Debug)]
pub struct Integral<const N: usize> {
    ki: [f64; N],
}

impl<const N: usize> Integral<N> {
    /// The integral with the gains `ki` [1/s³], for the others.
    ///
    /// # Errors
    /// `ki`: not finite, not > 0, or not below k_p k_v, where s³ + k_v s² + k_p s + k_i is stable.
    pub fn new(ki: [f64; N], gains: &Gains<N>) -> Result<Self> {
        positive("ki", &ki)?;
        match (0..N).find(|&n| ki[n] >= gains.kp[n] * gains.kv[n]) {
            None => Ok(Self { ki }),
            Some(n) => {
                let wanted = "less than kp·kv of the joint, else the loop is not stable";
                Err(Error::out_of_range("ki", ki[n], wanted).at(n))
            }
        }
    }

    /// Gains with all three poles at −`bandwidth` [rad/s]: (s + p)³, the honest PID.
    ///
    /// # Errors
    /// `bandwidth`: not finite or not > 0.
    pub fn with_bandwidth(bandwidth: [f64; N]) -> Result<(Gains<N>, Self)> {
        positive("bandwidth", &bandwidth)?;
        let gains = Gains::new(bandwidth.map(|p| 3.0 * p * p), bandwidth.map(|p| 3.0 * p))?;
        let integral = Self::new(bandwidth.map(|p| p * p * p), &gains)?;
        Ok((gains, integral))
    }

    /// Refuses an integral for which these gains are too weak on an arm whose inertia the model
    /// misses by up to a of [`Mismatch`]: (1 − a) k_v k_p > k_i.
    ///
    /// # Errors
    /// `ki`; what [`Mismatch::needed`] names.
    pub fn covers(&self, gains: &Gains<N>, mismatch: &Mismatch) -> Result<()> {
        mismatch.needed()?;
        let share = 1.0 - mismatch.inertia;
        match (0..N).find(|&n| self.ki[n] >= share * gains.kp[n] * gains.kv[n]) {
            None => Ok(()),
            Some(n) => {
                let wanted = "less than (1 - inertia) · kp · kv of the joint";
                Err(Error::out_of_range("ki", self.ki[n], wanted).at(n))
            }
        }
    }
}

impl<const N: usize> Dynamic<N, N> for Integral<N> {
    fn estimate(&self, z: &Vector<N>, _: &Sample<N>) -> Vector<N> {
        Vector::from_fn(|n, _| self.ki[n] * z[n])
    }

    fn rate(&self, _: &Vector<N>, seen: &Sample<N>, applied: &Applied<N>) -> Vector<N> {
        if applied.limited() { Vector::zeros() } else { seen.e }
    }

    fn moved(&self) -> Option<Moved<'_, N>> {
        Some(Moved::by_error(self.ki))
    }

    fn tuning(&self) -> u64 {
        fnv_of(FNV_START, self.ki)
    }
}

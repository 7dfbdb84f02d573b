//! Disturbance observer: `d̂ = z − Yq̇`, `ż = Y M₀⁻¹(τ_a − H₀ − d̂)`, which the law adds to its
//! torque: `ρ̂ = −M₀⁻¹d̂`.
//!
//! τ_a is the torque that acted, so it goes on while the torque is limited. Where M₀ is the arm's
//! the error falls like exp(−Y M₀⁻¹ t). Source: Chen and others 2000; Mohammadi and others 2013.

use super::believed;
use crate::arm::{Arm, Factor};
use crate::control::{Applied, Dynamic, Sample};
use crate::error::{Error, Result, positive, within};
use crate::math::Vector;

/// The observer on the nominal arm.
#[derive(Clone, Copy, Debug)]
pub struct DisturbanceObserver<const N: usize, A> {
    arm: A,
    gain: [f64; N],
}

impl<const N: usize, A: Arm<N>> DisturbanceObserver<N, A> {
    /// The observer with Y = diag(`gain`) [N·m·s/rad].
    ///
    /// # Errors
    /// `gain`: not finite or not > 0.
    pub fn new(arm: A, gain: [f64; N]) -> Result<Self> {
        positive("gain", &gain)?;
        Ok(Self { arm, gain })
    }

    /// Refuses a period \[s\] in which z would overshoot at the pose `q`: h λmax(Y M₀⁻¹) < 1. The
    /// largest eigenvalue is at most the trace.
    ///
    /// # Errors
    /// `control_period`.
    pub fn suits(&self, q: &Vector<N>, period: f64) -> Result<()> {
        let factor = Factor::of(&self.arm.mass_matrix(q));
        let fastest: f64 = (0..N)
            .map(|n| {
                let unit = Vector::from_fn(|i, _| if i == n { self.gain[n] } else { 0.0 });
                factor.solve(&unit)[n]
            })
            .sum();
        if !fastest.is_finite() {
            return Err(Error::not_finite("gain", fastest));
        }
        let wanted = "less than one over the sum of the observer's poles; lower its gain";
        within("control_period", &[period], |h| h * fastest < 1.0, wanted)
    }

    /// d̂ [N·m].
    fn disturbance(&self, z: &Vector<N>, seen: &Sample<N>) -> Vector<N> {
        Vector::from_fn(|n, _| z[n] - self.gain[n] * seen.dq[n])
    }
}

impl<const N: usize, A: Arm<N>> Dynamic<N, N> for DisturbanceObserver<N, A> {
    /// d̂ = 0.
    fn start(&self, seen: &Sample<N>) -> Vector<N> {
        Vector::from_fn(|n, _| self.gain[n] * seen.dq[n])
    }

    fn estimate(&self, z: &Vector<N>, seen: &Sample<N>) -> Vector<N> {
        -Factor::of(&self.arm.mass_matrix(&seen.q)).solve(&self.disturbance(z, seen))
    }

    fn rate(&self, z: &Vector<N>, seen: &Sample<N>, applied: &Applied<N>) -> Vector<N> {
        let rest = applied.tau - self.disturbance(z, seen);
        let rate = believed(&self.arm, seen, &rest);
        Vector::from_fn(|n, _| self.gain[n] * rate[n])
    }
}

//! Disturbance observer: `d̂ = z − Yq̇`, `ż = Y M₀⁻¹(τ_a − H₀ − d̂)`, which the law adds to its
//! torque: `ρ̂ = −M₀⁻¹d̂`.
//!
//! τ_a is the torque that acted, so it goes on while the torque is limited. Where M₀ is the arm's
//! the error falls like exp(−Y M₀⁻¹ t). Source: Chen and others 2000; Mohammadi and others 2013.

use super::bandwidth::{fastest_pole, inertia_weights};
use super::believed;
use crate::arm::{Arm, Factor};
use crate::control::{Applied, Dynamic, Moved, Sample, pushed};
use crate::error::{Result, positive, within};
use crate::math::{Vector, fnv_of};

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

    /// The observer with Y = pD for a bandwidth p [rad/s], D the mean of M₀'s diagonal over 24
    /// poses spread over the joints' ranges. Its poles are at −p where M₀ = D.
    ///
    /// # Errors
    /// `bandwidth`, `mass_matrix`: not finite or not > 0.
    pub fn with_bandwidth(arm: A, bandwidth: [f64; N]) -> Result<Self> {
        positive("bandwidth", &bandwidth)?;
        let weights = inertia_weights(&arm)?;
        Self::new(arm, core::array::from_fn(|n| bandwidth[n] * weights[n]))
    }

    /// Refuses a gain with which z would overshoot in a period \[s\] with a delay in samples, at
    /// these poses: λmax(M₀⁻¹Y) h (1 + d) < 1.
    ///
    /// # Errors
    /// `gain`.
    pub fn suits(&self, period: f64, delay: f64) -> Result<()> {
        let wanted = "a lower gain or a shorter period: pole · period · (1 + delay) < 1";
        let fastest = fastest_pole(&self.arm, &self.gain)?;
        within("gain", &[fastest], |pole| pole * period * (1.0 + delay) < 1.0, wanted)
    }

    /// d̂ [N·m].
    fn disturbance(&self, z: &Vector<N>, seen: &Sample<N>) -> Vector<N> {
        pushed(z, &self.gain, &seen.dq)
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

    fn moved(&self) -> Option<Moved<'_, N>> {
        Some(Moved::by_acceleration(self.arm.side()?, self.gain))
    }

    fn tuning(&self) -> u64 {
        fnv_of(self.arm.fingerprint(), self.gain)
    }
}

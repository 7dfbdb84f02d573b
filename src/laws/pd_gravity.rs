//! PD with gravity compensation: `τ = G₀(q) − K_P e − K_D ė − M₀ρ̂` with gains in torque.
//!
//! On a set-point ½q̇ᵀMq̇ + ½eᵀK_P e falls, whatever the inertia. Between set-points it lags.
//! Source: Takegaki and Arimoto, 1981.

use super::bandwidth::{fastest_pole, inertia_weights};
use crate::arm::{Arm, JointFriction};
use crate::control::{Demand, Gains, Law, Sample, keeps_up};
use crate::error::{Result, positive};
use crate::math::{FNV_START, Vector, fnv_of};

/// The law: what holds the arm against gravity, and gains of each joint.
#[derive(Clone, Copy, Debug)]
pub struct PdGravity<const N: usize, A> {
    arm: A,
    stiffness: [f64; N],
    damping: [f64; N],
}

impl<const N: usize, A: Arm<N>> PdGravity<N, A> {
    /// The law for this arm.
    ///
    /// # Errors
    /// `stiffness` [N·m/rad], `damping` [N·m·s/rad]: not finite or not > 0.
    pub fn new(arm: A, stiffness: [f64; N], damping: [f64; N]) -> Result<Self> {
        positive("stiffness", &stiffness)?;
        positive("damping", &damping)?;
        Ok(Self { arm, stiffness, damping })
    }

    /// Gains from a bandwidth p [rad/s]: K_P = p²D, K_D = 2pD, D the mean of M₀'s diagonal over 24
    /// poses spread over the joints' ranges. Both poles are at −p where M = D.
    ///
    /// # Errors
    /// `bandwidth`, `mass_matrix`: not finite or not > 0.
    pub fn with_bandwidth(arm: A, bandwidth: [f64; N]) -> Result<Self> {
        let Gains { kp, kv } = Gains::with_bandwidth(bandwidth)?;
        let weights = inertia_weights(&arm)?;
        let weighted = |gains: [f64; N]| core::array::from_fn(|n| gains[n] * weights[n]);
        Self::new(arm, weighted(kp), weighted(kv))
    }

    /// Refuses a damping that is too fast for a period \[s\] and a delay in samples, at these
    /// poses: λmax(M₀⁻¹K_D) (½ + d) h ≤ 0.35.
    ///
    /// # Errors
    /// `damping`.
    pub fn suits(&self, period: f64, delay: f64) -> Result<()> {
        keeps_up("damping", &[fastest_pole(&self.arm, &self.damping)?], period, delay)
    }
}

impl<const N: usize, A: Arm<N>> Law<N> for PdGravity<N, A> {
    fn torque(&self, seen: &Sample<N>, rho_hat: &Vector<N>) -> Demand<N> {
        let Sample { q, e, de, desired, .. } = seen;
        let feedback = Vector::from_fn(|n, _| self.stiffness[n] * e[n] + self.damping[n] * de[n]);
        let compensation = -(self.arm.mass_matrix(q) * rho_hat);
        Demand { model: self.arm.gravity(q) - feedback, compensation, v: desired.ddq }
    }

    /// G₀(q).
    fn resting_torque(&self, q: &Vector<N>) -> Vector<N> {
        self.arm.gravity(q)
    }

    /// M₀(q) a.
    fn inertia_torque(&self, q: &Vector<N>, acceleration: &Vector<N>) -> Vector<N> {
        self.arm.mass_matrix(q) * acceleration
    }

    /// None: friction is not cancelled.
    fn joint_friction(&self, _joint: usize) -> JointFriction {
        JointFriction::default()
    }

    #[inline]
    fn wraps(&self) -> [bool; N] {
        self.arm.wraps()
    }

    fn fingerprint(&self) -> u64 {
        self.arm.fingerprint()
    }

    fn tuning(&self) -> u64 {
        fnv_of(fnv_of(FNV_START, self.stiffness), self.damping)
    }
}

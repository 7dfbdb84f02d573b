//! PD with gravity compensation: `τ = G₀(q) − K_P e − K_D ė − M₀ρ̂` with gains in torque.
//!
//! On a set-point ½q̇ᵀMq̇ + ½eᵀK_P e falls, whatever the inertia. Between set-points it lags.
//! Source: Takegaki and Arimoto, 1981.

use crate::arm::{Arm, JointFriction};
use crate::control::{Demand, Law, Sample};
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

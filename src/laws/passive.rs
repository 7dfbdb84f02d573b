//! Slotine and Li's law: `τ = M₀ a_r + C₀ v_r + G₀ + f₀ − K_D s − M₀ρ̂` with `v_r = q̇_d − Λe`,
//! `a_r = q̈_d − Λė`, `s = ė + Λe`.
//!
//! C₀ is Christoffel's, so that with the right model ½sᵀMs falls at the rate sᵀK_D s: no inverse of
//! M is needed. Source: Slotine and Li, 1987.

use super::{believed, sliding};
use crate::arm::{Arm, JointFriction};
use crate::control::{Demand, Law, Sample};
use crate::error::{Result, positive};
use crate::math::{FNV_START, Vector, fnv_of};

/// The law on the nominal arm.
#[derive(Clone, Copy, Debug)]
pub struct Passive<const N: usize, A> {
    arm: A,
    lambda: [f64; N],
    damping: [f64; N],
}

impl<const N: usize, A: Arm<N>> Passive<N, A> {
    /// Λ [1/s] and K_D [N·m·s/rad] of each joint.
    ///
    /// # Errors
    /// `lambda`, `damping`: not finite or not > 0.
    pub fn new(arm: A, lambda: [f64; N], damping: [f64; N]) -> Result<Self> {
        positive("lambda", &lambda)?;
        positive("damping", &damping)?;
        Ok(Self { arm, lambda, damping })
    }
}

impl<const N: usize, A: Arm<N>> Law<N> for Passive<N, A> {
    fn torque(&self, seen: &Sample<N>, rho_hat: &Vector<N>) -> Demand<N> {
        let Sample { q, dq, desired, e, de } = seen;
        let s = sliding(&self.lambda, seen);
        let v_r = Vector::from_fn(|n, _| desired.dq[n] - self.lambda[n] * e[n]);
        let a_r = Vector::from_fn(|n, _| desired.ddq[n] - self.lambda[n] * de[n]);
        let mass = self.arm.mass_matrix(q);
        let feedforward = mass * a_r + self.arm.coriolis(q, dq) * v_r + self.arm.gravity(q);
        let damped = Vector::from_fn(|n, _| self.damping[n] * s[n]);
        let model = feedforward + self.arm.friction(dq) - damped;
        let v = believed(&self.arm, seen, &model);
        Demand { model, compensation: -(mass * rho_hat), v }
    }

    /// G₀(q).
    fn resting_torque(&self, q: &Vector<N>) -> Vector<N> {
        self.arm.gravity(q)
    }

    /// M₀(q) a.
    fn inertia_torque(&self, q: &Vector<N>, acceleration: &Vector<N>) -> Vector<N> {
        self.arm.mass_matrix(q) * acceleration
    }

    fn joint_friction(&self, joint: usize) -> JointFriction {
        self.arm.joint_friction(joint)
    }

    #[inline]
    fn wraps(&self) -> [bool; N] {
        self.arm.wraps()
    }

    fn fingerprint(&self) -> u64 {
        self.arm.fingerprint()
    }

    fn tuning(&self) -> u64 {
        fnv_of(fnv_of(FNV_START, self.lambda), self.damping)
    }
}

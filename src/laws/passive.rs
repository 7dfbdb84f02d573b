//! Slotine and Li's law: `τ = M₀ a_r + C₀ v_r + G₀ + f₀ − K_D s − M₀ρ̂` with `v_r = q̇_d − Λe`,
//! `a_r = q̈_d − Λė`, `s = ė + Λe`.
//!
//! C₀ is Christoffel's, so that with the right model ½sᵀMs falls at the rate sᵀK_D s: no inverse of
//! M is needed. Source: Slotine and Li, 1987.

use super::bandwidth::{fastest_pole, inertia_weights};
use super::{believed, sliding};
use crate::arm::{Arm, JointFriction};
use crate::control::{Demand, Law, Sample, keeps_up};
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

    /// Gains from a bandwidth p [rad/s]: Λ = p, K_D = pD, D the mean of M₀'s diagonal over 24 poses
    /// spread over the joints' ranges. Both poles are at −p where M = D.
    ///
    /// # Errors
    /// `bandwidth`, `mass_matrix`: not finite or not > 0.
    pub fn with_bandwidth(arm: A, bandwidth: [f64; N]) -> Result<Self> {
        positive("bandwidth", &bandwidth)?;
        let weights = inertia_weights(&arm)?;
        Self::new(arm, bandwidth, core::array::from_fn(|n| bandwidth[n] * weights[n]))
    }

    /// Refuses gains that are too fast for a period \[s\] and a delay in samples, at these poses:
    /// (λmax(M₀⁻¹K_D) + Λ) (½ + d) h ≤ 0.35.
    ///
    /// # Errors
    /// `damping`.
    pub fn suits(&self, period: f64, delay: f64) -> Result<()> {
        let pole = fastest_pole(&self.arm, &self.damping)?;
        keeps_up("damping", &self.lambda.map(|lambda| lambda + pole), period, delay)
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

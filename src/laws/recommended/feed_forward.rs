//! The law: the nominal arm on the desired motion, and a PD weighted with a mass matrix,
//! `τ = ID₀(q_d, q̇_d, q̈_d) − D(q_d)(2p (ė + w(e)) + ρ̂)`, w(e) = ½pe near the path.
//!
//! D is the mass matrix of an arm between the lightest and the heaviest that is declared. With M₀
//! in its place the loop with [`LearnedTorque`](super::LearnedTorque) is unstable for M > 9 D.

use super::pull::Pull;
use crate::arm::Arm;
use crate::control::{Demand, Law, Sample};
use crate::error::Result;
use crate::math::{Vector, fnv_of};

/// The law on the nominal arm.
#[derive(Clone, Copy, Debug)]
pub struct FeedForward<const N: usize, A> {
    arm: A,
    weight: A,
    pull: Pull<N>,
}

impl<const N: usize, A: Arm<N>> FeedForward<N, A> {
    /// The law for what is believed of the arm, with the mass matrix of `weight` for D.
    ///
    /// # Errors
    /// `bandwidth`, `braking`: not finite or not > 0.
    pub fn new(arm: A, weight: A, pull: Pull<N>) -> Result<Self> {
        pull.validate()?;
        Ok(Self { arm, weight, pull })
    }
}

impl<const N: usize, A: Arm<N>> Law<N> for FeedForward<N, A> {
    fn torque(&self, seen: &Sample<N>, rho_hat: &Vector<N>) -> Demand<N> {
        let Sample { desired, e, de, .. } = seen;
        let (mass, bias) = self.arm.mass_matrix_and_bias(&desired.q, &desired.dq);
        let weight = self.weight.mass_matrix(&desired.q);
        let back = self.pull.acceleration(e, de);
        let model = mass * desired.ddq + bias + weight * back;
        Demand { model, compensation: -(weight * rho_hat), v: desired.ddq + back }
    }

    /// G₀(q).
    fn resting_torque(&self, q: &Vector<N>) -> Vector<N> {
        self.arm.gravity(q)
    }

    /// M₀(q) a.
    fn inertia_torque(&self, q: &Vector<N>, acceleration: &Vector<N>) -> Vector<N> {
        self.arm.mass_matrix(q) * acceleration
    }

    #[inline]
    fn wraps(&self) -> [bool; N] {
        self.arm.wraps()
    }

    fn fingerprint(&self) -> u64 {
        self.arm.fingerprint()
    }

    fn tuning(&self) -> u64 {
        fnv_of(self.pull.fingerprint(), [f64::from_bits(self.weight.fingerprint())])
    }
}

//! The law: the nominal arm on the desired motion, and a PD weighted with a mass matrix,
//! `τ = ID₀(q_d, q̇_d, q̈_d) − D(q_d)(2p (ė + w(e)) + ρ̂)`, w(e) = ½pe near the path.
//!
//! D is the mass matrix of an arm between the lightest and the heaviest that is declared. With M₀
//! in its place the loop with [`LearnedTorque`](super::LearnedTorque) is unstable for M > 9 D.

use super::pull::Pull;
use crate::arm::Arm;
#[cfg(feature = "std")]
use crate::control::Beliefs;
use crate::control::{Demand, Law, Sample};
use crate::error::Result;
use crate::math::{Matrix, Real, Vector, fnv_of, product};
use crate::reference::Setpoint;

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

impl<const N: usize, T: Real> Pull<N, T> {
    /// The torque, from M₀ and H₀ of the desired motion and D there.
    #[inline(always)]
    pub(super) fn torque(
        &self,
        (mass, bias): (&Matrix<N, T>, &Vector<N, T>),
        weight: &Matrix<N, T>,
        Sample { desired, e, de, .. }: &Sample<N, T>,
        rho_hat: &Vector<N, T>,
    ) -> Demand<N, T> {
        let back = self.acceleration(e, de);
        let (mut model, mut v) = (product(mass, &desired.ddq), desired.ddq);
        let (weighted, mut compensation) = (product(weight, &back), product(weight, rho_hat));
        for n in 0..N {
            model[n] = model[n] + bias[n] + weighted[n];
            compensation[n] = -compensation[n];
            v[n] += back[n];
        }
        Demand { model, compensation, v }
    }
}

impl<const N: usize, A: Arm<N>> Law<N> for FeedForward<N, A> {
    fn torque(&self, seen: &Sample<N>, rho_hat: &Vector<N>) -> Demand<N> {
        let Setpoint { q, dq, .. } = &seen.desired;
        let (mass, bias) = self.arm.mass_matrix_and_bias(q, dq);
        let weight = self.weight.mass_matrix(q);
        self.pull.torque((&mass, &bias), &weight, seen, rho_hat)
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

    #[cfg(feature = "std")]
    fn beliefs(&self) -> Option<Beliefs<'_, N>> {
        Some(Beliefs { arms: [self.arm.side()?, self.weight.side()?], numbers: &self.pull })
    }

    fn fingerprint(&self) -> u64 {
        self.arm.fingerprint()
    }

    fn tuning(&self) -> u64 {
        fnv_of(self.pull.fingerprint(), [f64::from_bits(self.weight.fingerprint())])
    }
}

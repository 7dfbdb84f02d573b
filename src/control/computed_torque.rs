//! Computed torque for the nominal arm:
//!
//! ```text
//! v = q̈_d − K_v ė − K_p e
//! τ = M₀(q)(v − ρ̂) + H₀(q, q̇) = (M₀ v + H₀) − M₀ ρ̂        (7), (11), (12)
//! ```
//!
//! v is the paper's feedback. With another [`Feedback`] the law is another one of the same family.

use super::gains::feedback;
use super::{Demand, Gains, Law, Sample};
use crate::arm::{Arm, JointFriction, Side};
use crate::math::{FNV_START, Matrix, Real, Vector, fnv_of, product};

/// What computed torque asks the arm to do: the acceleration v for a sample. It remembers nothing;
/// an integrator is a [`Dynamic`](super::Dynamic) that adds its share to ρ̂.
pub trait Feedback<const N: usize> {
    /// v [rad/s²].
    fn acceleration(&self, seen: &Sample<N>) -> Vector<N>;

    /// It, where it is the paper's feedback with constant gains.
    fn constant(&self) -> Option<&Gains<N>> {
        None
    }

    /// A number for its parameters: see [`Law::tuning`].
    fn tuning(&self) -> u64;
}

impl<const N: usize> Feedback<N> for Gains<N> {
    /// v = q̈_d − K_v ė − K_p e [rad/s²].
    #[inline]
    fn acceleration(&self, seen: &Sample<N>) -> Vector<N> {
        feedback(&self.kp, &self.kv, seen)
    }

    fn constant(&self) -> Option<&Gains<N>> {
        Some(self)
    }

    /// FNV-1a of the gains.
    fn tuning(&self) -> u64 {
        fnv_of(fnv_of(FNV_START, self.kp), self.kv)
    }
}

/// The law: nominal arm and feedback. Immutable.
#[derive(Clone, Copy, Debug)]
pub struct ComputedTorque<const N: usize, A, F = Gains<N>> {
    /// What the law believes of the arm.
    pub arm: A,
    /// Feedback, by default with constant gains.
    pub gains: F,
}

impl<const N: usize, A: Arm<N>, F: Feedback<N>> ComputedTorque<N, A, F> {
    /// Computed torque for this arm; [`Controller::new`](super::Controller::new) makes a controller
    /// of it.
    pub fn new(arm: A, gains: F) -> Self {
        Self { arm, gains }
    }
}

/// (M₀ v + H₀) − M₀ ρ̂.
#[inline(always)]
pub(super) fn computed<const N: usize, T: Real>(
    (mass, bias): (&Matrix<N, T>, &Vector<N, T>),
    v: Vector<N, T>,
    rho_hat: &Vector<N, T>,
) -> Demand<N, T> {
    let (mut model, mut compensation) = (product(mass, &v), product(mass, rho_hat));
    for n in 0..N {
        model[n] += bias[n];
        compensation[n] = -compensation[n];
    }
    Demand { model, compensation, v }
}

impl<const N: usize, A: Arm<N>, F: Feedback<N>> Law<N> for ComputedTorque<N, A, F> {
    #[inline(always)]
    fn torque(&self, seen: &Sample<N>, rho_hat: &Vector<N>) -> Demand<N> {
        self.torque_by(&self.arm.mass_matrix_and_bias(&seen.q, &seen.dq), seen, rho_hat)
    }

    fn model(&self) -> Option<Side<'_, N>> {
        self.arm.side()
    }

    #[inline(always)]
    fn torque_by(
        &self,
        (mass, bias): &(Matrix<N>, Vector<N>),
        seen: &Sample<N>,
        rho_hat: &Vector<N>,
    ) -> Demand<N> {
        computed((mass, bias), self.gains.acceleration(seen), rho_hat)
    }

    fn constant_gains(&self) -> Option<&Gains<N>> {
        self.gains.constant()
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

    /// That of the nominal arm. Gains may differ: ρ does not depend on them.
    fn fingerprint(&self) -> u64 {
        self.arm.fingerprint()
    }

    fn tuning(&self) -> u64 {
        self.gains.tuning()
    }
}

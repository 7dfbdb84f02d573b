//! Rigid-body dynamics of a serial arm: `M(q) q̈ + H(q, q̇) = τ`, `H = C q̇ + G + f(q̇)` (eq. 6), within the joints' ranges.

mod friction;
mod serial;
mod two_link;

pub use friction::{Friction, JointFriction};
#[cfg(feature = "std")]
pub(crate) use serial::{Flaw, SYMMETRIC};
pub use serial::{
    Inertia, JointKind, JointLimits, JointStop, Link, Perturbation, Pose, Serial, SerialParameters,
    Unphysical,
};
pub use two_link::{TwoLink, TwoLinkParameters};

use crate::math::{Matrix, Vector};

/// The dynamics of an arm with `N` joints. Angles in rad, torques in N·m, SI throughout.
///
/// Implement the first five; the rest follows from them, and may be overridden where a closed form is faster.
pub trait Arm<const N: usize> {
    /// Mass matrix M(q) [kg·m²], symmetric positive definite.
    fn mass_matrix(&self, q: &Vector<N>) -> Matrix<N>;

    /// Coriolis matrix C(q, q̇) [N·m·s] in the Christoffel form, for which Ṁ − 2C is skew-symmetric.
    fn coriolis(&self, q: &Vector<N>, dq: &Vector<N>) -> Matrix<N>;

    /// Gravity torque G(q) [N·m].
    fn gravity(&self, q: &Vector<N>) -> Vector<N>;

    /// Friction torque f(q̇) [N·m]; it opposes the motion, q̇ᵀf ≥ 0.
    fn friction(&self, dq: &Vector<N>) -> Vector<N>;

    /// Potential energy U(q) [J], with G = ∂U/∂q.
    fn potential_energy(&self, q: &Vector<N>) -> f64;

    /// Torque s(q, q̇) that drives the joints on into their stops [N·m], positive beyond an upper end; zero for an arm
    /// without stops, and within the joints' ranges.
    ///
    /// It is part of the inverse and forward dynamics, and not of the bias: a controller that counted on a stop would push
    /// through it.
    fn stops(&self, _q: &Vector<N>, _dq: &Vector<N>) -> Vector<N> {
        Vector::zeros()
    }

    /// Bias torque H(q, q̇) = C q̇ + G + f [N·m].
    fn bias(&self, q: &Vector<N>, dq: &Vector<N>) -> Vector<N> {
        self.coriolis(q, dq) * dq + self.gravity(q) + self.friction(dq)
    }

    /// M(q) and H(q, q̇) in one pass.
    fn mass_matrix_and_bias(&self, q: &Vector<N>, dq: &Vector<N>) -> (Matrix<N>, Vector<N>) {
        (self.mass_matrix(q), self.bias(q, dq))
    }

    /// The torque that produces q̈: τ = M q̈ + H + s [N·m].
    fn inverse_dynamics(&self, q: &Vector<N>, dq: &Vector<N>, ddq: &Vector<N>) -> Vector<N> {
        let (mass, bias) = self.mass_matrix_and_bias(q, dq);
        mass * ddq + bias + self.stops(q, dq)
    }

    /// The acceleration that τ produces: q̈ = M⁻¹(τ − H − s) [rad/s²]; NaN where M is not positive definite.
    fn forward_dynamics(&self, q: &Vector<N>, dq: &Vector<N>, tau: &Vector<N>) -> Vector<N> {
        let (mass, bias) = self.mass_matrix_and_bias(q, dq);
        match mass.cholesky() {
            Some(factor) => factor.solve(&(tau - bias - self.stops(q, dq))),
            None => Vector::repeat(f64::NAN),
        }
    }

    /// Kinetic energy ½ q̇ᵀ M q̇ [J].
    fn kinetic_energy(&self, q: &Vector<N>, dq: &Vector<N>) -> f64 {
        0.5 * dq.dot(&(self.mass_matrix(q) * dq))
    }
}

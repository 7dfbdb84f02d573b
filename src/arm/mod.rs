//! Rigid-body dynamics of a serial arm: `M(q) q̈ + H(q, q̇) = τ`, `H = C q̇ + G + f(q̇)` (eq. 6),
//! within the joints' ranges.
//!
//! The way through: `two_link`, `serial/` are the arms; `friction` and `serial/stop` say what
//! opposes the motion of one joint, and `resistance` puts both together. `implicit` solves M v = …
//! − λ, with λ as these allow; `factor` is M = LᵀDL.

#[cfg(feature = "std")]
mod abreast;
mod factor;
mod friction;
mod implicit;
#[cfg(feature = "std")]
mod models;
mod parametric;
mod planar;
mod posed;
mod resistance;
mod serial;
mod side;
mod single;
mod two_link;

#[cfg(feature = "std")]
pub(crate) use abreast::{Alike, ArmsAbreast, Dynamics, Frictions, Kind};
pub(crate) use factor::Factor;
pub use friction::{Friction, JointFriction};
pub(crate) use implicit::Implicit;
#[cfg(feature = "std")]
pub(crate) use models::ModelsAbreast;
pub use parametric::{Parametric, Regressor};
pub(crate) use posed::Posed;
pub(crate) use resistance::Resistance;
#[cfg(feature = "std")]
pub(crate) use serial::{Flaw, Frame, Frames, MAX_ABREAST, SYMMETRIC};
pub use serial::{
    Inertia, JointKind, JointLimits, JointStop, Link, Perturbation, Pose, Serial, SerialParameters,
    Unphysical,
};
pub use side::Side;
pub(crate) use single::SingleArm;
pub use two_link::{TwoLink, TwoLinkParameters};

use nalgebra::SMatrix;

use crate::math::{FNV_START, Matrix, Vector, fnv_of};

/// An arm whose tip is known.
pub trait Tip<const N: usize> {
    /// Jacobian of the tip in the axes of the base: q̇ to its velocity [m/s] (rows 0 to 2) and
    /// angular velocity [rad/s] (rows 3 to 5).
    fn jacobian(&self, q: &Vector<N>) -> SMatrix<f64, 6, N>;
}

/// The dynamics of an arm with `N` joints. Angles in rad, torques in N·m, SI throughout.
///
/// Implement the first two methods; the rest follows from them. Override others where a closed form
/// is faster. Friction and stops may be stiff: they are given joint by joint, and simulation solves
/// for them.
pub trait Arm<const N: usize> {
    /// Mass matrix M(q) [kg·m²], symmetric positive definite.
    fn mass_matrix(&self, q: &Vector<N>) -> Matrix<N>;

    /// C(q, q̇) q̇ + G(q) [N·m]: the bias without friction.
    fn rigid_bias(&self, q: &Vector<N>, dq: &Vector<N>) -> Vector<N>;

    /// Coriolis matrix C(q, q̇) [N·m·s] in the Christoffel form, for which Ṁ − 2C is
    /// skew-symmetric.
    ///
    /// C(q, u) w is then bilinear and symmetric in u and w, so that its columns are
    /// `C(q, q̇) eⱼ = ¼ (r(q, q̇ + eⱼ) − r(q, q̇ − eⱼ))` of r = C q̇ + G: exact, whatever the arm.
    fn coriolis(&self, q: &Vector<N>, dq: &Vector<N>) -> Matrix<N> {
        let mut coriolis = Matrix::<N>::zeros();
        for (joint, mut column) in coriolis.column_iter_mut().enumerate() {
            let unit = Vector::from_fn(|i, _| if i == joint { 1.0 } else { 0.0 });
            let change = self.rigid_bias(q, &(dq + unit)) - self.rigid_bias(q, &(dq - unit));
            column.copy_from(&(change * 0.25));
        }
        coriolis
    }

    /// Gravity torque G(q) [N·m].
    fn gravity(&self, q: &Vector<N>) -> Vector<N> {
        self.rigid_bias(q, &Vector::zeros())
    }

    /// Friction of a joint; none by default.
    fn joint_friction(&self, _joint: usize) -> JointFriction {
        JointFriction::default()
    }

    /// Stops of a joint, and the range at whose ends they are; none by default.
    fn joint_stop(&self, _joint: usize) -> (JointStop, JointLimits) {
        (JointStop::default(), JointLimits::default())
    }

    /// Whether any joint has friction or a stop.
    fn resists(&self) -> bool {
        (0..N).any(|joint| {
            !self.joint_friction(joint).is_none() || !self.joint_stop(joint).0.is_none()
        })
    }

    /// Friction torque f(q̇) [N·m]; it opposes the motion, q̇ᵀf ≥ 0. Zero at rest, where dry
    /// friction may be anything up to the torque at which the joint breaks away.
    fn friction(&self, dq: &Vector<N>) -> Vector<N> {
        Vector::from_fn(|joint, _| self.joint_friction(joint).torque(dq[joint]))
    }

    /// Torque s(q, q̇) that drives the joints on into their stops [N·m], positive beyond an upper
    /// end; zero for an arm without stops, and within the joints' ranges.
    ///
    /// It is part of the inverse and forward dynamics, but not of the bias. A controller that
    /// counted on a stop would push through it.
    fn stops(&self, q: &Vector<N>, dq: &Vector<N>) -> Vector<N> {
        Vector::from_fn(|joint, _| {
            let (stop, limits) = self.joint_stop(joint);
            stop.torque(&limits, q[joint], dq[joint])
        })
    }

    /// M(q), the velocity q̇ that `choose` returns when it is given M, and C q̇ + G at that
    /// velocity. All without friction and stops, in one pass.
    fn rigid_dynamics(
        &self,
        q: &Vector<N>,
        choose: &mut dyn FnMut(&Matrix<N>) -> Vector<N>,
    ) -> (Matrix<N>, Vector<N>, Vector<N>) {
        let mass = self.mass_matrix(q);
        let dq = choose(&mass);
        (mass, dq, self.rigid_bias(q, &dq))
    }

    /// Which joints turn without an end. Their tracking error is taken around the circle, in
    /// [−π, π), so positions a turn apart are the same. None by default.
    #[inline]
    fn wraps(&self) -> [bool; N] {
        [false; N]
    }

    /// Bias torque H(q, q̇) = C q̇ + G + f [N·m].
    fn bias(&self, q: &Vector<N>, dq: &Vector<N>) -> Vector<N> {
        self.rigid_bias(q, dq) + self.friction(dq)
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

    /// The acceleration that τ produces: q̈ = M⁻¹(τ − H − s) [rad/s²]; NaN where M is not positive
    /// definite. A joint at rest that dry friction can hold stays at rest: q̈ = 0 there.
    fn forward_dynamics(&self, q: &Vector<N>, dq: &Vector<N>, tau: &Vector<N>) -> Vector<N> {
        Posed::of(self, q, dq).acceleration(self, (q, dq), tau)
    }

    /// Kinetic energy ½ q̇ᵀ M q̇ \[J\].
    fn kinetic_energy(&self, q: &Vector<N>, dq: &Vector<N>) -> f64 {
        0.5 * dq.dot(&(self.mass_matrix(q) * dq))
    }

    /// What of it is put beside other arms, for many runs at a time; `None` where it cannot be.
    fn side(&self) -> Option<Side<'_, N>> {
        None
    }

    /// A number for the arm that a controller believes in: FNV-1a of the bits of M and H in two
    /// poses, in motion. An arm has the same number on every machine. Arms that differ in M or H
    /// have different numbers, except by accident.
    fn fingerprint(&self) -> u64 {
        [1.0, -0.6].into_iter().fold(FNV_START, |hash, sign| {
            let q = Vector::from_fn(|joint, _| sign * (0.3 + 0.4 * joint as f64));
            let (mass, bias) = self.mass_matrix_and_bias(&q, &q.map(|x| 1.1 - x));
            fnv_of(hash, mass.iter().chain(bias.iter()).copied())
        })
    }
}

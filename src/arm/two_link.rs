//! The paper's planar arm of two links, in closed form (section 4):
//!
//! ```text
//! M = [θ₁ + θ₃ + 2θ₂ cos q₂   θ₃ + θ₂ cos q₂]    H = [−θ₂ (2 q̇₁q̇₂ + q̇₂²) sin q₂]  + G + f
//!     [θ₃ + θ₂ cos q₂         θ₃            ]        [ θ₂ q̇₁² sin q₂             ]
//! ```
//!
//! θ₁ = I₁ + (m₁/4 + m₂) l₁², θ₂ = m₂ l₁ l₂/2, θ₃ = I₂ + m₂ l₂²/4 [kg·m²]. Centres of mass are at
//! mid-link. q₁ is measured from the horizontal axis, q₂ from the first link. The paper's arm lies
//! flat (G = 0) and has no friction; both can be added.

use nalgebra::SMatrix;

use super::Side;
use super::planar::Planar;
use super::{Arm, Friction, JointFriction, Pose, Posed, Tip};
use crate::error::{Result, finite, positive, within};
use crate::math::{Matrix, Vector, columns, sin_cos};

/// Masses and sizes of a [`TwoLink`]. The default is the paper's nominal arm: horizontal, without
/// friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoLinkParameters {
    /// m, mass of each link \[kg\], > 0.
    pub mass: [f64; 2],
    /// l, length of each link \[m\], > 0.
    pub length: [f64; 2],
    /// I, moment of inertia of each link about its centre of mass [kg·m²], > 0.
    pub inertia: [f64; 2],
    /// g [m/s²], pulling along the negative vertical axis; 0 for an arm in the horizontal plane.
    pub gravity: f64,
    /// Friction of the two joints.
    pub friction: Friction<2>,
}

impl Default for TwoLinkParameters {
    fn default() -> Self {
        Self {
            mass: [4.0; 2],
            length: [0.5; 2],
            inertia: [0.2; 2],
            gravity: 0.0,
            friction: Friction::default(),
        }
    }
}

/// The planar two-link arm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoLink {
    parameters: TwoLinkParameters,
    pub(super) planar: Planar,
    has_friction: bool,
    /// Whether the friction of a joint is dry.
    sticks: bool,
}

impl TwoLink {
    /// Checks the parameters. M is then positive definite everywhere: θ₃ > 0, and
    /// `det M = (I₁ + m₁l₁²/4) θ₃ + m₂l₁² I₂ + θ₂² sin² q₂` is a sum of terms ≥ 0 of which the
    /// first two are > 0.
    ///
    /// # Errors
    /// `NotFinite` or `OutOfRange`, naming `mass`, `length`, `inertia`, `gravity` or `friction.…`;
    /// or `mass_matrix.det` and `gravity_torque` if numbers that are valid one by one overflow or
    /// underflow together.
    pub fn new(parameters: TwoLinkParameters) -> Result<Self> {
        let TwoLinkParameters { mass, length, inertia, gravity, friction } = parameters;
        positive("mass", &mass)?;
        positive("length", &length)?;
        positive("inertia", &inertia)?;
        finite("gravity", &[gravity])?;
        friction.validate()?;

        let link_1 = inertia[0] + mass[0] / 4.0 * length[0] * length[0];
        let tip_1 = mass[1] * length[0] * length[0];
        let theta_1 = link_1 + tip_1;
        let theta_2 = mass[1] * length[0] * length[1] / 2.0;
        let theta_3 = inertia[1] + mass[1] * length[1] * length[1] / 4.0;
        let det_0 = link_1 * theta_3 + tip_1 * inertia[1];
        let normal = |det: f64| det >= f64::MIN_POSITIVE;
        within("mass_matrix.det", &[det_0], normal, "at least 2.3e-308 kg^2 m^4")?;
        finite("mass_matrix.det", &[det_0 + theta_2 * theta_2])?;
        finite("mass_matrix.det", &[theta_1 * theta_3])?;

        let weight =
            [(mass[0] / 2.0 + mass[1]) * length[0] * gravity, mass[1] * length[1] / 2.0 * gravity];
        finite("gravity_torque", &weight)?;

        let theta = [theta_1, theta_2, theta_3];
        Ok(Self {
            parameters,
            planar: Planar { theta, det_0, weight, has_gravity: gravity != 0.0 },
            has_friction: !friction.is_none(),
            sticks: (0..2).any(|joint| friction.joint(joint).hold().is_some()),
        })
    }

    /// The same arm with this friction in place of its own.
    ///
    /// # Errors
    /// As [`Friction::validate`].
    pub fn with_friction(&self, friction: Friction<2>) -> Result<Self> {
        Self::new(TwoLinkParameters { friction, ..self.parameters })
    }

    /// The same arm under another gravity [m/s²]; 0 for an arm that lies flat.
    ///
    /// # Errors
    /// `NotFinite`, naming `gravity` or `gravity_torque`.
    pub fn with_gravity(&self, gravity: f64) -> Result<Self> {
        Self::new(TwoLinkParameters { gravity, ..self.parameters })
    }

    /// The parameters it was built from.
    pub fn parameters(&self) -> &TwoLinkParameters {
        &self.parameters
    }

    /// θ₁, θ₂, θ₃ [kg·m²].
    pub fn theta(&self) -> [f64; 3] {
        self.planar.theta
    }

    /// Gravity torques [N·m]: of the first link with the second one's mass at its tip, and of the
    /// second link.
    pub fn weight(&self) -> [f64; 2] {
        self.planar.weight
    }

    /// Poses of the joints' frames in the base: x along the link, z along the joints' axes.
    pub fn link_poses(&self, q: &Vector<2>) -> [Pose; 2] {
        let shoulder = planar(q[0], Vector::<3>::zeros());
        [shoulder, planar(q[0] + q[1], ahead(&shoulder, self.parameters.length[0]))]
    }

    /// Pose of the tip in the base, with the axes of the second link.
    pub fn pose(&self, q: &Vector<2>) -> Pose {
        let [_, elbow] = self.link_poses(q);
        Pose { translation: ahead(&elbow, self.parameters.length[1]), ..elbow }
    }

    /// Potential energy, U = (m₁/2 + m₂) l₁ g sin q₁ + m₂ l₂/2 g sin(q₁ + q₂) \[J\]; G = ∂U/∂q.
    pub fn potential_energy(&self, q: &Vector<2>) -> f64 {
        let [inner, outer] = self.weight();
        inner * sin_cos(q[0]).0 + outer * sin_cos(q[0] + q[1]).0
    }

    /// H from q₁, sin q₂, cos q₂.
    #[inline(always)]
    fn bias_at(&self, q1: f64, trig: (f64, f64), dq: &Vector<2>) -> Vector<2> {
        let mut bias = self.planar.rigid_at(self.planar.first(q1), trig, dq);
        if self.has_friction {
            bias += self.parameters.friction.torque(dq);
        }
        bias
    }
}

impl Arm<2> for TwoLink {
    #[inline]
    fn mass_matrix(&self, q: &Vector<2>) -> Matrix<2> {
        self.planar.mass(sin_cos(q[1]).1)
    }

    #[inline]
    fn rigid_bias(&self, q: &Vector<2>, dq: &Vector<2>) -> Vector<2> {
        self.planar.rigid_at(self.planar.first(q[0]), sin_cos(q[1]), dq)
    }

    #[inline]
    fn coriolis(&self, q: &Vector<2>, dq: &Vector<2>) -> Matrix<2> {
        columns(self.planar.coriolis(sin_cos(q[1]).0, dq))
    }

    #[inline]
    fn gravity(&self, q: &Vector<2>) -> Vector<2> {
        let first = self.planar.first(q[0]);
        first.map_or_else(Vector::<2>::zeros, |first| self.planar.gravity_at(first, sin_cos(q[1])))
    }

    fn joint_friction(&self, joint: usize) -> JointFriction {
        self.parameters.friction.joint(joint)
    }

    fn resists(&self) -> bool {
        self.has_friction
    }

    fn side(&self) -> Option<Side<'_, 2>> {
        let friction = [0, 1].map(|joint| self.joint_friction(joint));
        let smooth = !self.sticks;
        smooth.then(|| Side::two_link(&self.planar, self.has_friction.then_some(friction)))
    }

    fn rigid_dynamics(
        &self,
        q: &Vector<2>,
        choose: &mut dyn FnMut(&Matrix<2>) -> Vector<2>,
    ) -> (Matrix<2>, Vector<2>, Vector<2>) {
        let trig = sin_cos(q[1]);
        let mass = self.planar.mass(trig.1);
        let dq = choose(&mass);
        (mass, dq, self.planar.rigid_at(self.planar.first(q[0]), trig, &dq))
    }

    #[inline]
    fn bias(&self, q: &Vector<2>, dq: &Vector<2>) -> Vector<2> {
        self.bias_at(q[0], sin_cos(q[1]), dq)
    }

    #[inline(always)]
    fn mass_matrix_and_bias(&self, q: &Vector<2>, dq: &Vector<2>) -> (Matrix<2>, Vector<2>) {
        let trig = sin_cos(q[1]);
        (self.planar.mass(trig.1), self.bias_at(q[0], trig, dq))
    }

    /// q̈ = M⁻¹(τ − H).
    #[inline(always)]
    fn forward_dynamics(&self, q: &Vector<2>, dq: &Vector<2>, tau: &Vector<2>) -> Vector<2> {
        if self.sticks {
            return Posed::of(self, q, dq).acceleration(self, (q, dq), tau);
        }
        let trig = sin_cos(q[1]);
        let net = tau - self.bias_at(q[0], trig, dq);
        self.planar.solve(trig, net.into())
    }
}

impl Tip<2> for TwoLink {
    fn jacobian(&self, q: &Vector<2>) -> SMatrix<f64, 6, 2> {
        let tip = self.pose(q).translation;
        let mut jacobian = SMatrix::<f64, 6, 2>::zeros();
        for (j, frame) in self.link_poses(q).iter().enumerate() {
            // About z: ẑ × r, and ẑ.
            let r = tip - frame.translation;
            jacobian.set_column(j, &Vector::from([-r[1], r[0], 0.0, 0.0, 0.0, 1.0]));
        }
        jacobian
    }
}

/// The pose of a frame turned by `angle` \[rad\] about z.
fn planar(angle: f64, translation: Vector<3>) -> Pose {
    let (sin, cos) = sin_cos(angle);
    Pose { rotation: Matrix::<3>::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0), translation }
}

/// The place `length` \[m\] along the x axis of a frame.
fn ahead(frame: &Pose, length: f64) -> Vector<3> {
    frame.translation + frame.rotation.column(0) * length
}

//! Frames and mass distributions: how they combine.

use super::place::{InertiaNames, PoseNames};
use super::validate::validate_pose;
use super::{Inertia, JointKind, JointLimits, JointStop, Link, Pose, Unphysical};
use crate::arm::JointFriction;
use crate::error::Result;
use crate::math::Matrix;

type Vector3 = nalgebra::Vector3<f64>;

/// Inertial parameters of a link.
pub(super) const PER_LINK: usize = 10;

impl Pose {
    /// The outer frame itself.
    pub const IDENTITY: Self = Self {
        rotation: Matrix::<3>::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
        translation: Vector3::new(0.0, 0.0, 0.0),
    };

    /// x_outer = R x_inner + p.
    pub const fn new(rotation: Matrix<3>, translation: Vector3) -> Self {
        Self { rotation, translation }
    }

    /// A frame with the outer one's axes, p away.
    pub const fn at(translation: Vector3) -> Self {
        Self { rotation: Self::IDENTITY.rotation, translation }
    }

    /// Refuses what is not finite, and a matrix that is not a rotation.
    ///
    /// # Errors
    /// `NotFinite` or `OutOfRange`, naming `rotation` or `translation`.
    pub fn validate(&self) -> Result<()> {
        validate_pose(self, PoseNames { rotation: "rotation", translation: "translation" }, None)
    }

    /// `inner`, which is given in this frame, in the outer one.
    #[must_use]
    pub fn then(&self, inner: &Self) -> Self {
        Self {
            rotation: self.rotation * inner.rotation,
            translation: self.point(&inner.translation),
        }
    }

    /// The outer frame in this one.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.transpose();
        Self { rotation, translation: -(rotation * self.translation) }
    }

    /// R x + p \[m\].
    pub fn point(&self, x: &Vector3) -> Vector3 {
        self.rotation * x + self.translation
    }
}

impl Default for Pose {
    fn default() -> Self {
        Self::IDENTITY
    }
}

impl Inertia {
    /// No mass.
    pub const NONE: Self = Self {
        mass: 0.0,
        com: Vector3::new(0.0, 0.0, 0.0),
        moments: Matrix::<3>::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    };

    /// A mass \[kg\] in one point \[m\].
    pub const fn point_mass(mass: f64, com: Vector3) -> Self {
        Self { mass, com, moments: Self::NONE.moments }
    }

    /// Refuses a mass distribution that no rigid body can have.
    ///
    /// # Errors
    /// `NotFinite` or `OutOfRange`, naming `mass`, `com` or `moments`.
    pub fn validate(&self) -> Result<()> {
        Unphysical::Refuse.take(self, InertiaNames::ALONE, None).map(drop)
    }

    /// Both together, as one rigid body: `I = I₁ + I₂ + m₁m₂/(m₁ + m₂) (|d|² 1 − d dᵀ)` with d
    /// between the centres of mass.
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        let mass = self.mass + other.mass;
        if self.mass == 0.0 && other.mass == 0.0 {
            return Self { mass, com: self.com, moments: self.moments + other.moments };
        }
        let share = other.mass / mass;
        let apart = other.com - self.com;
        Self {
            mass,
            com: self.com + apart * share,
            moments: self.moments + other.moments + of_point(self.mass * share, &apart),
        }
    }

    /// The same body in the frame in which this one's frame is `pose`. Moments that are not
    /// symmetric stay so, to be refused.
    #[must_use]
    pub fn transformed(&self, pose: &Pose) -> Self {
        let turned = pose.rotation * self.moments * pose.rotation.transpose();
        let is_symmetric = self.moments == self.moments.transpose();
        let moments = if is_symmetric { symmetric(&turned) } else { turned };
        Self { mass: self.mass, com: pose.point(&self.com), moments }
    }

    /// The ten inertial parameters, of which dynamics are linear: m, m c_x, m c_y, m c_z, I_xx,
    /// I_xy, I_yy, I_xz, I_yz, I_zz, moments about the frame's origin.
    pub fn parameters(&self) -> [f64; PER_LINK] {
        let (h, i) = (self.com * self.mass, self.moments_about_origin());
        let about = |a: usize, b: usize| 0.5 * (i[(a, b)] + i[(b, a)]);
        let (xy, xz, yz) = (about(0, 1), about(0, 2), about(1, 2));
        [self.mass, h[0], h[1], h[2], i[(0, 0)], xy, i[(1, 1)], xz, yz, i[(2, 2)]]
    }

    /// The way back from [`parameters`](Self::parameters). First moments without mass have no
    /// centre of mass: it is then not finite.
    pub fn from_parameters(parameters: &[f64; PER_LINK]) -> Self {
        let [mass, hx, hy, hz, xx, xy, yy, xz, yz, zz] = *parameters;
        let h = Vector3::new(hx, hy, hz);
        let com = if h == Vector3::zeros() { h } else { h / mass };
        let about_origin = Matrix::<3>::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        Self { mass, com, moments: about_origin - of_point(mass, &com) }
    }

    /// Moments about the frame's origin [kg·m²].
    pub fn moments_about_origin(&self) -> Matrix<3> {
        self.moments + of_point(self.mass, &self.com)
    }
}

/// Bodies of one frame as one.
impl core::iter::Sum for Inertia {
    fn sum<I: Iterator<Item = Self>>(bodies: I) -> Self {
        bodies.reduce(|one, other| one.plus(&other)).unwrap_or_default()
    }
}

impl Default for Inertia {
    fn default() -> Self {
        Self::NONE
    }
}

impl JointLimits {
    /// None at all.
    pub const NONE: Self = Self {
        lower: f64::NEG_INFINITY,
        upper: f64::INFINITY,
        velocity: f64::INFINITY,
        effort: f64::INFINITY,
    };
}

impl Default for JointLimits {
    fn default() -> Self {
        Self::NONE
    }
}

impl JointLimits {
    /// Whether the position is within the range.
    #[cfg(feature = "std")]
    pub(crate) fn contain(&self, q: f64) -> bool {
        self.lower <= q && q <= self.upper
    }
}

impl Link {
    /// A joint without friction, armature, limits and stops, and its link.
    pub fn new(kind: JointKind, placement: Pose, axis: Vector3, inertia: Inertia) -> Self {
        let (friction, limits) = (JointFriction::default(), JointLimits::NONE);
        let (armature, stop) = (0.0, JointStop::default());
        Self { kind, placement, axis, inertia, friction, armature, limits, stop }
    }
}

/// m (|d|² 1 − d dᵀ).
fn of_point(mass: f64, d: &Vector3) -> Matrix<3> {
    let [x, y, z] = [d[0], d[1], d[2]];
    let (xy, xz, yz) = (-(x * y), -(x * z), -(y * z));
    Matrix::<3>::new(y * y + z * z, xy, xz, xy, x * x + z * z, yz, xz, yz, x * x + y * y) * mass
}

pub(super) fn symmetric(a: &Matrix<3>) -> Matrix<3> {
    (a + a.transpose()) * 0.5
}

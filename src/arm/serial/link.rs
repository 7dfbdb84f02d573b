//! What a serial arm is made of: one joint and the link that it moves, N times over.

use super::body::{Inertia, Pose};
use super::limits::JointLimits;
use super::stop::JointStop;
use crate::arm::JointFriction;

/// How a joint moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointKind {
    /// Turns about its axis: positions a turn apart are different.
    Revolute,
    /// Turns about its axis without an end, as URDF's `continuous`. Positions a turn apart are the
    /// same, and a tracking error is taken around the circle.
    Continuous,
    /// Slides along its axis; position \[m\], velocity [m/s], force \[N\].
    Prismatic,
}

impl JointKind {
    /// Its name in files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Revolute => "revolute",
            Self::Continuous => "continuous",
            Self::Prismatic => "prismatic",
        }
    }

    /// Whether it turns, rather than slides.
    #[inline]
    pub const fn turns(self) -> bool {
        !matches!(self, Self::Prismatic)
    }
}

/// A joint and the link that it moves. The link's frame is the joint's. At q = 0 it is `placement`
/// in the frame of the link before. The joint moves it about or along `axis`, which is given in the
/// link's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Link {
    /// How the joint moves.
    pub kind: JointKind,
    /// The joint's frame at q = 0 in the frame of the link before (the base for the first).
    pub placement: Pose,
    /// Unit vector in the joint's frame.
    pub axis: nalgebra::Vector3<f64>,
    /// Mass distribution, in the joint's frame. Links fixed to it are part of it.
    pub inertia: Inertia,
    /// Friction of the joint.
    pub friction: JointFriction,
    /// Inertia of the rotor, seen through the gear: gear² · rotor inertia [kg·m²], or \[kg\] for a
    /// prismatic joint, ≥ 0.
    pub armature: f64,
    /// Limits, infinite for none.
    pub limits: JointLimits,
    /// Stops at the ends of the range.
    pub stop: JointStop,
}

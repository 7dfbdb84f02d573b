//! What a joint and its link must be: finite, of unit axis and proper rotation, and a mass
//! distribution that matter can have.

use super::body::Pose;
use super::limits::JointLimits;
use super::link::{JointKind, Link};
use super::place::{InertiaNames, Of, PoseNames};
use super::unphysical::Unphysical;
use crate::error::Result;
use crate::math::{Matrix, sqrt};

/// Lengths of axes and columns of rotations may be off by this, as numbers printed with six
/// decimals are.
const UNIT: f64 = 1e-6;

const PLACEMENT: PoseNames =
    PoseNames { rotation: "placement.rotation", translation: "placement.translation" };

impl Link {
    /// Refuses an impossible link. Errors carry `joint` as their index.
    ///
    /// Axes and rotations may be off by 1e-6, principal moments by 1e-6 of the largest, or by
    /// the mass times a square micrometre: published figures are rounded.
    ///
    /// # Errors
    /// `NotFinite` or `OutOfRange`, naming `placement.…`, `axis`, `inertia.…`, `friction.…`,
    /// `armature`, `limits.…` or `stop.…`.
    pub fn validate(&self, joint: usize) -> Result<()> {
        self.taken(joint, Unphysical::Refuse).map(drop)
    }

    /// The link as it is taken. `unphysical` says what is done about a mass distribution that no
    /// rigid body can have; all else is refused as by [`validate`](Self::validate).
    pub(crate) fn taken(&self, joint: usize, unphysical: Unphysical) -> Result<Self> {
        let of = |parameter| Of { parameter, joint: Some(joint) };
        validate_pose(&self.placement, PLACEMENT, Some(joint))?;
        of("axis").finite(self.axis.as_slice())?;
        let length = sqrt(self.axis.dot(&self.axis));
        of("axis").within(length, (length - 1.0).abs() <= UNIT, "a vector of length 1")?;
        let inertia = unphysical.take(&self.inertia, InertiaNames::LINK, Some(joint))?;
        self.friction.validate(joint)?;
        of("armature").within(self.armature, self.armature >= 0.0, "a number >= 0")?;
        self.limits.validate(joint)?;
        if self.kind == JointKind::Continuous {
            let JointLimits { lower, upper, .. } = self.limits;
            let wanted = "none, as a continuous joint has no end; a revolute one may have";
            of("limits.lower").accept(lower, lower.is_infinite(), wanted)?;
            of("limits.upper").accept(upper, upper.is_infinite(), wanted)?;
        }
        self.stop.validate(joint)?;
        Ok(Self { inertia, ..*self })
    }
}

/// Refuses what is not finite, or not a rotation.
pub(super) fn validate_pose(pose: &Pose, names: PoseNames, joint: Option<usize>) -> Result<()> {
    let rotation = Of { parameter: names.rotation, joint };
    let r = &pose.rotation;
    rotation.finite(r.as_slice())?;
    Of { parameter: names.translation, joint }.finite(pose.translation.as_slice())?;
    let off = (r.transpose() * r - Matrix::<3>::identity()).amax();
    rotation.within(off, off <= 2.0 * UNIT, "a rotation matrix, of orthonormal columns")?;
    let determinant = r.determinant();
    rotation.within(determinant, determinant > 0.0, "a rotation matrix, of determinant +1")
}

//! What a joint and its link must be: finite, of unit axis and proper rotation, and a mass distribution that matter can have.

use super::{JointKind, JointLimits, Link, Pose, Unphysical};
use crate::error::{Error, Result, finite};
use crate::math::{Matrix, sqrt};

/// Lengths of axes and columns of rotations may be off by this, as numbers printed with six decimals are.
const UNIT: f64 = 1e-6;

/// A parameter of one joint.
#[derive(Clone, Copy)]
pub(super) struct Of {
    pub parameter: &'static str,
    pub joint: Option<usize>,
}

impl Of {
    /// Refuses what is not finite.
    pub fn finite(self, values: &[f64]) -> Result<()> {
        finite(self.parameter, values).map_err(|error| error.at(self.joint))
    }

    /// Refuses what is not finite or not accepted.
    pub fn within(self, got: f64, accepted: bool, wanted: &'static str) -> Result<()> {
        self.finite(&[got])?;
        self.accept(got, accepted, wanted)
    }

    /// Refuses what is not accepted; infinities may be.
    pub fn accept(self, got: f64, accepted: bool, wanted: &'static str) -> Result<()> {
        if accepted {
            return Ok(());
        }
        Err(Error::out_of_range(self.parameter, got, wanted).at(self.joint))
    }
}

/// Names of an inertia's parameters.
#[derive(Clone, Copy)]
pub(super) struct InertiaNames {
    pub mass: &'static str,
    pub com: &'static str,
    pub moments: &'static str,
}

impl InertiaNames {
    /// Of a mass distribution by itself.
    pub const ALONE: Self = Self { mass: "mass", com: "com", moments: "moments" };
    const LINK: Self =
        Self { mass: "inertia.mass", com: "inertia.com", moments: "inertia.moments" };
}

/// Names of a pose's parameters.
#[derive(Clone, Copy)]
pub(super) struct PoseNames {
    pub rotation: &'static str,
    pub translation: &'static str,
}

const PLACEMENT: PoseNames =
    PoseNames { rotation: "placement.rotation", translation: "placement.translation" };

impl Link {
    /// Refuses a link that cannot be; errors carry `joint` as their index.
    ///
    /// Axes and rotations may be off by 1e-6, principal moments by 1e-6 of the largest, or by
    /// the mass times a square micrometre: published figures are rounded.
    ///
    /// # Errors
    /// `NotFinite` or `OutOfRange`, naming `placement.…`, `axis`, `inertia.…`, `friction.…`, `armature`, `limits.…` or
    /// `stop.…`.
    pub fn validate(&self, joint: usize) -> Result<()> {
        self.taken(joint, Unphysical::Refuse).map(drop)
    }

    /// The link as it is taken: a mass distribution that no body has is what `unphysical` makes of it, all else is refused
    /// as by [`validate`](Self::validate).
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

impl JointLimits {
    /// Refuses NaN, limits that no position can meet, and a speed or effort that is not > 0.
    ///
    /// # Errors
    /// `NotFinite` or `OutOfRange`, naming `limits.lower`, `limits.upper`, `limits.velocity` or `limits.effort`.
    pub fn validate(&self, joint: usize) -> Result<()> {
        let of = |parameter| Of { parameter, joint: Some(joint) };
        let number = |parameter, got: f64| {
            let nan = Error::not_finite(parameter, got).at(joint);
            if got.is_nan() { Err(nan) } else { Ok(()) }
        };
        number("limits.lower", self.lower)?;
        number("limits.upper", self.upper)?;
        number("limits.velocity", self.velocity)?;
        number("limits.effort", self.effort)?;
        let below_infinity = self.lower < f64::INFINITY;
        of("limits.lower").accept(self.lower, below_infinity, "less than +infinity")?;
        let reachable = self.upper >= self.lower && self.upper > f64::NEG_INFINITY;
        of("limits.upper").accept(self.upper, reachable, "at least limits.lower")?;
        of("limits.velocity").accept(self.velocity, self.velocity > 0.0, "a number > 0")?;
        of("limits.effort").accept(self.effort, self.effort > 0.0, "a number > 0")
    }
}

/// Refuses what is not finite or no rotation.
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

//! What a joint and its link must be: finite, of unit axis and proper rotation, and a mass distribution that matter can have.

use super::{Inertia, JointKind, JointLimits, Link, Pose};
use crate::eigen::symmetric_eigenvalues;
use crate::error::{Error, Result};
use crate::math::{Matrix, sqrt};

/// Lengths of axes and columns of rotations may be off by this, as numbers printed with six decimals are.
const UNIT: f64 = 1e-6;
/// Entries of the moments across the diagonal may differ by this share of the largest.
const SYMMETRY: f64 = 1e-9;
/// The principal moments may miss zero, and the triangle inequality, by this share of the largest.
const MOMENTS: f64 = 1e-6;
/// They may also miss them by what moving the mass by a micrometre changes [m²].
const SPECK: f64 = 1e-12;

/// A parameter of one joint.
#[derive(Clone, Copy)]
pub(super) struct Of {
    pub parameter: &'static str,
    pub joint: Option<usize>,
}

impl Of {
    /// Refuses what is not finite.
    pub fn finite(self, values: &[f64]) -> Result<()> {
        match values.iter().find(|value| !value.is_finite()) {
            None => Ok(()),
            Some(&got) => {
                Err(Error::NotFinite { parameter: self.parameter, index: self.joint, got })
            }
        }
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
        Err(Error::OutOfRange { parameter: self.parameter, index: self.joint, got, wanted })
    }
}

/// Names of an inertia's parameters.
#[derive(Clone, Copy)]
pub(super) struct InertiaNames {
    pub mass: &'static str,
    pub com: &'static str,
    pub moments: &'static str,
}

const LINK_INERTIA: InertiaNames =
    InertiaNames { mass: "inertia.mass", com: "inertia.com", moments: "inertia.moments" };

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
        let of = |parameter| Of { parameter, joint: Some(joint) };
        validate_pose(&self.placement, PLACEMENT, Some(joint))?;
        of("axis").finite(self.axis.as_slice())?;
        let length = sqrt(self.axis.dot(&self.axis));
        of("axis").within(length, (length - 1.0).abs() <= UNIT, "a vector of length 1")?;
        validate_inertia(&self.inertia, LINK_INERTIA, Some(joint))?;
        self.friction.validate(joint)?;
        of("armature").within(self.armature, self.armature >= 0.0, "a number >= 0")?;
        self.limits.validate(joint)?;
        if self.kind == JointKind::Continuous {
            let JointLimits { lower, upper, .. } = self.limits;
            let wanted = "none, as a continuous joint has no end; a revolute one may have";
            of("limits.lower").accept(lower, lower.is_infinite(), wanted)?;
            of("limits.upper").accept(upper, upper.is_infinite(), wanted)?;
        }
        self.stop.validate(joint)
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
            let nan = Error::NotFinite { parameter, index: Some(joint), got };
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
    rotation.within(off, off <= 2.0 * UNIT, "orthonormal columns")?;
    let determinant = r.determinant();
    rotation.within(determinant, determinant > 0.0, "a determinant of +1")
}

/// Refuses a mass distribution that matter cannot have.
pub(super) fn validate_inertia(
    inertia: &Inertia,
    names: InertiaNames,
    joint: Option<usize>,
) -> Result<()> {
    let moments = Of { parameter: names.moments, joint };
    let i = &inertia.moments;
    Of { parameter: names.mass, joint }.within(
        inertia.mass,
        inertia.mass >= 0.0,
        "a number >= 0",
    )?;
    Of { parameter: names.com, joint }.finite(inertia.com.as_slice())?;
    moments.finite(i.as_slice())?;
    let off = (i - i.transpose()).amax();
    moments.within(off, off <= SYMMETRY * i.amax(), "a symmetric matrix")?;
    let mut principal = symmetric_eigenvalues(&((i + i.transpose()) * 0.5))?;
    principal.sort_unstable_by(f64::total_cmp);
    let [least, middle, most] = principal;
    let allowed = (MOMENTS * most).max(SPECK * inertia.mass);
    moments.within(least, least >= -allowed, "principal moments >= 0")?;
    let slack = least + middle - most;
    let wanted = "no principal moment larger than the sum of the other two";
    moments.within(slack, slack >= -allowed, wanted)
}

//! What every description must be, whatever it was read from: finite, with real rotations, and physically possible.

use std::collections::BTreeSet;

use super::error::quoted;
use super::{Description, JointDescription};
use crate::arm::{Inertia, JointFriction, JointLimits, Pose};
use crate::eigen::symmetric_eigenvalues;
use crate::math::Matrix;

/// Largest entry of RᵀR − 1 and of |axis| − 1: figures with nine digits pass, a typing error does not.
const ORTHONORMAL: f64 = 1e-8;
/// Principal moments may miss the triangle inequality by this share of the largest: figures of six digits, rounded.
const TRIANGLE: f64 = 1e-6;
/// They may also miss it by what moving the mass by a micrometre changes [m²]: files have −1e-20 for none.
const SPECK: f64 = 1e-12;

/// What is wrong, and at which joint.
pub(super) struct Problem {
    pub joint: Option<usize>,
    pub message: String,
}

/// Refuses a description that no arm can have.
pub(super) fn check(description: &Description) -> Result<(), Problem> {
    let of_arm = |message| Problem { joint: None, message };
    if description.joints.is_empty() {
        return Err(of_arm("joints: got none, wants at least one that moves".to_owned()));
    }
    finite("gravity", &description.gravity).map_err(of_arm)?;
    pose("tip", &description.tip).map_err(of_arm)?;
    let mut names = BTreeSet::new();
    for (index, joint) in description.joints.iter().enumerate() {
        let of_joint = |message: String| Problem {
            joint: Some(index),
            message: format!("joint {}, {message}", quoted(&joint.name)),
        };
        if !names.insert(joint.name.as_str()) {
            return Err(of_joint("name: given twice, wants a name of its own".to_owned()));
        }
        check_joint(joint).map_err(of_joint)?;
    }
    Ok(())
}

fn check_joint(joint: &JointDescription) -> Result<(), String> {
    let link = &joint.link;
    pose("placement", &link.placement)?;
    finite("axis", link.axis.as_slice())?;
    if (link.axis.norm() - 1.0).abs() > ORTHONORMAL {
        let [x, y, z]: [f64; 3] = link.axis.into();
        return Err(format!("axis: got [{x}, {y}, {z}], wants a vector of length 1"));
    }
    inertia(&link.inertia)?;
    friction(&link.friction)?;
    at_least_zero("armature", link.armature)?;
    limits(&link.limits)?;
    at_least_zero("stop.stiffness", link.stop.stiffness)?;
    at_least_zero("stop.dissipation", link.stop.dissipation)
}

fn finite(what: &str, values: &[f64]) -> Result<(), String> {
    match values.iter().find(|value| !value.is_finite()) {
        None => Ok(()),
        Some(value) => Err(format!("{what}: got {value}, wants finite numbers")),
    }
}

fn at_least_zero(what: &str, value: f64) -> Result<(), String> {
    match value >= 0.0 && value.is_finite() {
        true => Ok(()),
        false => Err(format!("{what}: got {value}, wants a finite number >= 0")),
    }
}

fn above_zero(what: &str, value: f64) -> Result<(), String> {
    match value > 0.0 && value.is_finite() {
        true => Ok(()),
        false => Err(format!("{what}: got {value}, wants a finite number > 0")),
    }
}

fn pose(what: &str, pose: &Pose) -> Result<(), String> {
    finite(&format!("{what}.translation"), pose.translation.as_slice())?;
    finite(&format!("{what}.rotation"), pose.rotation.as_slice())?;
    let r = &pose.rotation;
    let off = (r.transpose() * r - Matrix::<3>::identity()).amax();
    let orthonormal = off <= ORTHONORMAL && r.determinant() > 0.0;
    match orthonormal {
        true => Ok(()),
        false => Err(format!(
            "{what}.rotation: got columns that are {off:.1e} from orthonormal (determinant {:.3}), wants a rotation matrix",
            r.determinant()
        )),
    }
}

/// Refuses a negative mass, and moments that no body has: the largest principal moment is at most the sum of the others.
pub(super) fn inertia(inertia: &Inertia) -> Result<(), String> {
    at_least_zero("mass", inertia.mass)?;
    finite("com", inertia.com.as_slice())?;
    finite("moments", inertia.moments.as_slice())?;
    let moments = &inertia.moments;
    if *moments != moments.transpose() {
        return Err("moments: got a matrix that is not symmetric, wants a symmetric one".to_owned());
    }
    let mut principal = symmetric_eigenvalues(moments).map_err(|error| error.to_string())?;
    principal.sort_by(f64::total_cmp);
    let [a, b, c] = principal;
    let allowed = (TRIANGLE * c.abs().max(a.abs())).max(SPECK * inertia.mass);
    if a < -allowed {
        return Err(format!(
            "moments: got principal moments {a:e}, {b:e}, {c:e} kg m^2, wants none negative"
        ));
    }
    if c - (a + b) > allowed {
        return Err(format!(
            "moments: got principal moments {a:e}, {b:e}, {c:e} kg m^2, wants the largest at most the sum of the other \
             two (the triangle inequality of every rigid body)"
        ));
    }
    match inertia.mass == 0.0 && c > 0.0 {
        true => Err("mass: got 0 with moments of inertia, wants a mass > 0".to_owned()),
        false => Ok(()),
    }
}

fn friction(friction: &JointFriction) -> Result<(), String> {
    at_least_zero("friction.viscous", friction.viscous)?;
    at_least_zero("friction.coulomb", friction.coulomb[0])?;
    at_least_zero("friction.coulomb", friction.coulomb[1])?;
    at_least_zero("friction.stribeck", friction.stribeck)?;
    above_zero("friction.stribeck_speed", friction.stribeck_speed)?;
    at_least_zero("friction.smoothing", friction.smoothing)
}

/// Refuses limits that leave no motion; infinite ones are none.
pub(super) fn limits(limits: &JointLimits) -> Result<(), String> {
    let JointLimits { lower, upper, velocity, effort } = *limits;
    let range = lower < upper && lower < f64::INFINITY && upper > f64::NEG_INFINITY;
    if !range {
        return Err(format!("limits: got lower {lower} and upper {upper}, wants lower < upper"));
    }
    for (what, value) in [("velocity", velocity), ("effort", effort)] {
        let allowed = value > 0.0;
        if !allowed {
            return Err(format!("limits.{what}: got {value}, wants a number > 0"));
        }
    }
    Ok(())
}

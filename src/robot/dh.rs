//! Denavit-Hartenberg tables, in the two conventions of the field:
//!
//! ```text
//! standard   ⁱ⁻¹Tᵢ = R_z(θᵢ) T_z(dᵢ) T_x(aᵢ) R_x(αᵢ)           frame i at the far end of link i
//! modified   ⁱ⁻¹Tᵢ = R_x(αᵢ₋₁) T_x(aᵢ₋₁) R_z(θᵢ) T_z(dᵢ)     frame i on joint i
//!            row i holds aᵢ₋₁, αᵢ₋₁, dᵢ, θᵢ
//! ```
//!
//! A link of ours has its frame on its joint, so a standard table's mass distributions are moved by
//! T_x(a) R_x(α).
//! Sources: Denavit and Hartenberg 1955; Craig, Introduction to Robotics, 3rd ed., eq. 3.6.

use nalgebra::Vector3;

use super::frames::{about_x, about_z};
use super::{Description, JointDescription, ReadError, checks};
use crate::arm::{
    Inertia, JointFriction, JointKind, JointLimits, JointStop, Link, Pose, Unphysical,
};

/// Which of the two conventions a table follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Convention {
    /// Denavit and Hartenberg's: a and α follow the joint.
    Standard,
    /// Craig's: a and α precede the joint.
    Modified,
}

/// A row of the table, with what moves. The default is a massless revolute joint without friction
/// or limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DhRow {
    /// How the joint moves: one that turns adds q to θ, a prismatic one to d.
    pub kind: JointKind,
    /// a, along x \[m\].
    pub a: f64,
    /// α, about x \[rad\].
    pub alpha: f64,
    /// d, along z \[m\].
    pub d: f64,
    /// θ at q = 0, about z \[rad\].
    pub theta_offset: f64,
    /// Mass distribution of link i, in the table's frame i.
    pub inertia: Inertia,
    /// Friction of the joint.
    pub friction: JointFriction,
    /// Rotor inertia seen through the gear [kg·m² or kg].
    pub armature: f64,
    /// Limits, infinite for none.
    pub limits: JointLimits,
}

impl Default for DhRow {
    fn default() -> Self {
        Self {
            kind: JointKind::Revolute,
            a: 0.0,
            alpha: 0.0,
            d: 0.0,
            theta_offset: 0.0,
            inertia: Inertia::NONE,
            friction: JointFriction::default(),
            armature: 0.0,
            limits: JointLimits::NONE,
        }
    }
}

impl Description {
    /// The arm of a Denavit-Hartenberg table. Joints and links are called `joint1`, `link1` and so
    /// on; the tip is the table's last frame.
    ///
    /// # Errors
    /// If there is no row, a number is not finite, or no rigid body can have a mass distribution.
    pub fn from_dh(
        name: &str,
        rows: &[DhRow],
        convention: Convention,
        gravity: [f64; 3],
    ) -> Result<Self, ReadError> {
        Self::from_dh_taking(name, rows, convention, gravity, Unphysical::Refuse)
    }

    /// [`Description::from_dh`], with a choice of what is done about a mass distribution that no
    /// rigid body can have.
    ///
    /// # Errors
    /// As there, except for what is taken.
    pub fn from_dh_taking(
        name: &str,
        rows: &[DhRow],
        convention: Convention,
        gravity: [f64; 3],
        unphysical: Unphysical,
    ) -> Result<Self, ReadError> {
        let mut before = Pose::IDENTITY;
        let mut joints = Vec::with_capacity(rows.len());
        for (index, row) in rows.iter().enumerate() {
            finite(index, row)?;
            let along_x = Pose::at(Vector3::new(row.a, 0.0, 0.0)).then(&about_x(row.alpha));
            let along_z = about_z(row.theta_offset).then(&Pose::at(Vector3::new(0.0, 0.0, row.d)));
            let (placement, frame) = match convention {
                Convention::Standard => (before.then(&along_z), along_x),
                Convention::Modified => (along_x.then(&along_z), Pose::IDENTITY),
            };
            joints.push(JointDescription {
                name: joint_name(index),
                link_name: format!("link{}", index + 1),
                link: link(row, placement, &frame),
            });
            before = frame;
        }
        let (name, notes) = (name.to_owned(), Vec::new());
        let mut description = Self { name, joints, tip: before, gravity, notes, unphysical };
        checks::take(&mut description)?;
        Ok(description)
    }
}

/// Refuses a row with NaN or infinity.
fn finite(index: usize, row: &DhRow) -> Result<(), ReadError> {
    let columns =
        [("a", row.a), ("alpha", row.alpha), ("d", row.d), ("theta_offset", row.theta_offset)];
    match columns.iter().find(|(_, value)| !value.is_finite()) {
        None => Ok(()),
        Some((column, value)) => Err(ReadError::new(format!(
            "joint \"{}\", {column}: got {value}, wants a finite number",
            joint_name(index)
        ))),
    }
}

/// The link of a row, whose table's frame is `frame` in the joint's.
fn link(row: &DhRow, placement: Pose, frame: &Pose) -> Link {
    Link {
        kind: row.kind,
        placement,
        axis: Vector3::z(),
        inertia: row.inertia.transformed(frame),
        friction: row.friction,
        armature: row.armature,
        limits: row.limits,
        stop: JointStop::default(),
    }
}

fn joint_name(index: usize) -> String {
    format!("joint{}", index + 1)
}

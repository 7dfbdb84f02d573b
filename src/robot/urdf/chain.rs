//! From the tree to the chain: every link belongs to the last joint before it that lies between
//! base and tip.

use super::elements::Document;
use super::joint::{Drive, JointPart, JointType};
use super::layout::{Layout, Part};
use super::options::UrdfOptions;
use super::path::Path;
use super::transmission::Rotors;
use super::tree::Tree;
use super::{remarks, size};
use crate::arm::{Inertia, JointFriction, JointKind, JointStop, Link, Pose};
use crate::robot::checks::{self, Refusal};
use crate::robot::error::{first_of, quoted};
use crate::robot::{Description, JointDescription, ReadError};

/// The chain of a path; its name and the notes on unused elements are for the caller.
pub(super) fn description(
    source: &Document,
    tree: &Tree,
    path: &Path,
    rotors: &Rotors,
    options: &UrdfOptions,
) -> Result<Description, ReadError> {
    let mut layout = Layout::of(source, tree, path)?;
    if layout.moving.is_empty() {
        return Err(ReadError::new(format!(
            "joints: got none that moves between {} and {}, wants at least one",
            quoted(tree.links[path.base].name),
            quoted(tree.links[path.tip].name)
        )));
    }
    let bodies = layout.bodies(source, tree, path, options)?;
    refuse_massless(source, tree, &layout, &bodies)?;
    let mut description = Description {
        name: String::new(),
        joints: Vec::with_capacity(layout.moving.len()),
        tip: layout.places[path.tip].map_or(Pose::IDENTITY, |place| place.pose),
        gravity: options.gravity,
        notes: Vec::new(),
        unphysical: options.unphysical,
    };
    for (moving, parts) in layout.moving.iter().zip(&bodies) {
        let joint = &tree.joints[moving.joint];
        let mut drive = joint.drive(source)?;
        description.notes.append(&mut drive.notes);
        let armature = rotors.armatures.get(joint.name).copied().unwrap_or(0.0);
        let inertia: Inertia = parts.iter().map(|part| part.inertia).sum();
        description.joints.push(JointDescription {
            name: joint.name.to_owned(),
            link_name: joint.child.to_owned(),
            link: link(joint, moving.placement, &drive, inertia, armature),
        });
    }
    checks::take(&mut description)
        .map_err(|refusal| located(source, tree, (&layout, &bodies), refusal, options))?;
    let joints = description.joints.iter().zip(&bodies);
    let parts = joints.flat_map(|(joint, parts)| part_notes(tree, parts, joint)).collect();
    remarks::add(source, tree, path, &layout, &mut description)?;
    let moved = |name: &str| tree.named("", name).is_ok_and(|link| layout.moves(link));
    let unmoved = options.unmoved(moved);
    let notes = &mut description.notes;
    notes.append(&mut layout.given);
    notes.extend(unmoved);
    notes.extend(first_of(parts));
    notes.extend(first_of(layout.notes));
    notes.extend(first_of(rotors.notes.clone()));
    notes.extend(first_of(description.joints.iter().filter_map(size::note).collect()));
    Ok(description)
}

/// Refuses a last link without mass. Those before it need none, as what hangs on them has mass:
/// whether the mass matrix is positive definite is for the arm to judge.
fn refuse_massless(
    source: &Document,
    tree: &Tree,
    layout: &Layout,
    bodies: &[Vec<Part>],
) -> Result<(), ReadError> {
    let (Some(moving), Some(parts)) = (layout.moving.last(), bodies.last()) else { return Ok(()) };
    if parts.iter().any(|part| part.inertia.mass != 0.0) {
        return Ok(());
    }
    let link = &tree.links[tree.ends[moving.joint].1];
    let name = quoted(link.name);
    let message = match parts.is_empty() {
        true => format!(
            "link {name}: got no <inertial>, wants one, as it moves and is the last; state mass, \
             centre of mass and inertia, \
             or give them in inertials"
        ),
        false => format!("link {name}, <mass value>: got 0, wants a number > 0, as it moves"),
    };
    Err(source.error(link.at, message))
}

fn link(
    joint: &JointPart,
    placement: Pose,
    drive: &Drive,
    inertia: Inertia,
    armature: f64,
) -> Link {
    Link {
        kind: match joint.joint_type {
            JointType::Prismatic => JointKind::Prismatic,
            JointType::Continuous => JointKind::Continuous,
            _ => JointKind::Revolute,
        },
        placement,
        axis: drive.axis,
        inertia,
        friction: JointFriction {
            viscous: drive.damping,
            coulomb: [drive.friction; 2],
            ..JointFriction::default()
        },
        armature,
        limits: drive.limits,
        stop: JointStop::default(),
    }
}

/// Parts that are no body by themselves, of a body that is one.
fn part_notes(tree: &Tree, parts: &[Part], body: &JointDescription) -> Vec<String> {
    let whole = &body.link.inertia;
    if parts.len() < 2 || checks::how_far(whole).is_some() {
        return Vec::new();
    }
    let flaws = parts.iter().filter_map(|part| Some((part.link, checks::how_far(&part.inertia)?)));
    let carrier = quoted(&body.link_name);
    flaws
        .map(|(link, how_far)| {
            let link = quoted(tree.links[link].name);
            format!(
                "link {link}: no body has {how_far}; with all that moves with {carrier} it is one"
            )
        })
        .collect()
}

/// A refusal with its line: of the first link that is no body, or of the joint.
fn located(
    source: &Document,
    tree: &Tree,
    (layout, bodies): (&Layout, &[Vec<Part>]),
    refusal: Refusal,
    options: &UrdfOptions,
) -> ReadError {
    let at = refusal.joint.and_then(|at| Some((at, layout.moving.get(at)?)));
    let Some((joint, moving)) = at else { return refusal.into() };
    let parts = bodies.get(joint).filter(|_| refusal.of_body).into_iter().flatten();
    let more = checks::way_on(options.unphysical);
    let of_part = |part: &Part| tree.links[part.link].problem(source, &part.stated, more);
    let first = parts.filter_map(of_part).next();
    first.unwrap_or_else(|| source.error(tree.joints[moving.joint].at, refusal.message))
}

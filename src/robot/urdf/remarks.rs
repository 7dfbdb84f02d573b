//! What a user must know of the chain that was cut out of a file: notes, and gravity in the base's
//! axes.

use nalgebra::Vector3;

use super::elements::Document;
use super::joint::JointType;
use super::layout::{Layout, left_out};
use super::path::Path;
use super::tree::Tree;
use crate::math::Matrix;
use crate::robot::error::{first_of, listed, quoted};
use crate::robot::{Description, ReadError};

/// Longer strokes than this are no gripper's [m]: parallel grippers open by 0.05 to 0.2 m, half of
/// it a finger.
const STROKE: f64 = 0.11;
/// Words in the names of a gripper's joints and links.
const GRIPPER: [&str; 6] = ["finger", "gripper", "jaw", "knuckle", "thumb", "claw"];

/// Turns gravity into the base's axes and notes what is not as one would think.
pub(super) fn add(
    source: &Document,
    tree: &Tree,
    path: &Path,
    layout: &Layout,
    description: &mut Description,
) -> Result<(), ReadError> {
    let stands = |joint: &&usize| tree.joints[**joint].moves();
    let before: Vec<_> = path.before.iter().filter(stands).collect();
    let names = |joints: Vec<&usize>| {
        let names: Vec<_> = joints.into_iter().map(|&joint| tree.joints[joint].name).collect();
        listed(names.into_iter())
    };
    let turned = gravity(source, tree, path, description)?;
    let last = path.joints.iter().rev().copied().find(|&joint| tree.joints[joint].moves());
    let gripper = last.filter(|_| path.found).and_then(|joint| gripper(tree, joint, description));
    let notes = &mut description.notes;
    notes.extend(turned);
    if !before.is_empty() {
        notes.push(format!("joints before the base stand at 0: {}", names(before)));
    }
    if !layout.held.is_empty() {
        notes.push(format!(
            "joints beside or beyond the chain are held at 0, their links' mass is part of the \
             link that carries them: {}",
            names(layout.held.iter().collect())
        ));
    }
    notes.extend(massless(tree, path, layout));
    notes.extend(other_roots(tree, path));
    notes.extend(first_of(tree.faults.iter().map(left_out).collect()));
    notes.extend(gripper);
    if description.joints.iter().all(|joint| joint.link.armature == 0.0) {
        description.notes.push(NO_ROTOR.to_owned());
    }
    Ok(())
}

const NO_ROTOR: &str = "no rotor inertia in this file: behind a gear, gear² · rotor is often most \
    of what a wrist's joint moves; without it the inertia of the last joints, and the stiffness of \
    gains and stops that is reckoned from it, mean little";

/// Gravity is given in the root's axes: g_base = Rᵀ g_root.
fn gravity(
    source: &Document,
    tree: &Tree,
    path: &Path,
    description: &mut Description,
) -> Result<Option<String>, ReadError> {
    let mut rotation = Matrix::<3>::identity();
    for &joint in &path.before {
        rotation *= tree.joints[joint].origin(source)?.rotation;
    }
    if rotation == Matrix::<3>::identity() {
        return Ok(None);
    }
    // Without the sign of zeros.
    let turned = (rotation.transpose() * Vector3::from(description.gravity)).add_scalar(0.0);
    description.gravity = turned.into();
    let [x, y, z] = description.gravity;
    let (root, base) = (quoted(tree.links[path.root].name), quoted(tree.links[path.base].name));
    Ok(Some(format!(
        "the base {base} is turned against the root {root}: gravity, given in the root's axes, \
         is [{x:.4}, {y:.4}, {z:.4}] \
         m/s^2 in the base's"
    )))
}

/// Links that should have mass, as they move on a joint, and have none.
fn massless(tree: &Tree, path: &Path, layout: &Layout) -> Option<String> {
    // Frames that are fixed to others need none.
    let moves = |link: usize| tree.carrier[link].is_some_and(|joint| tree.joints[joint].moves());
    let names: Vec<_> = layout
        .massless
        .iter()
        .filter(|&&link| link != path.tip && moves(link))
        .map(|&link| tree.links[link].name)
        .collect();
    (!names.is_empty())
        .then(|| format!("links without mass taken as massless: {}", listed(names.into_iter())))
}

/// Links that hang on nothing, beside the root.
fn other_roots(tree: &Tree, path: &Path) -> Option<String> {
    let other = |link: &usize| tree.carrier[*link].is_none() && *link != path.root;
    let names: Vec<_> =
        (0..tree.links.len()).filter(other).map(|link| tree.links[link].name).collect();
    (!names.is_empty()).then(|| {
        let (root, names) = (quoted(tree.links[path.root].name), listed(names.into_iter()));
        format!("what does not hang on the root {root} is left out: {names}")
    })
}

/// A note if the last joint of a chain whose tip was not named looks like a gripper's.
fn gripper(tree: &Tree, joint: usize, description: &Description) -> Option<String> {
    let last = description.joints.last()?;
    let named = [&last.name, &last.link_name]
        .iter()
        .any(|name| GRIPPER.iter().any(|word| name.to_lowercase().contains(word)));
    let limits = last.link.limits;
    let short = tree.joints[joint].joint_type == JointType::Prismatic
        && limits.upper - limits.lower <= STROKE
        && description.joints.len() > 1;
    (named || short).then(|| {
        let parent = tree.ends[joint].0;
        format!(
            "joint {} is the last of the chain, as no tip was named, and looks like a gripper's; \
             name the tip, such as {}, \
             if it is none of the arm's",
            quoted(&last.name),
            quoted(tree.links[parent].name)
        )
    })
}

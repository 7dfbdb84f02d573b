//! From the tree to the chain: every link belongs to the last joint before it that lies between base and tip.

use super::elements::Source;
use super::joint::{JointPart, Motion};
use super::tree::{Path, Tree};
use crate::arm::{Inertia, JointFriction, JointKind, JointStop, Link, Pose, Unphysical};
use crate::robot::checks::Problem;
use crate::robot::error::{listed, quoted};
use crate::robot::{Description, JointDescription, ReadError, checks};

/// A link that moves with a joint of the chain, or with the base.
#[derive(Clone, Copy)]
struct Place {
    /// How many joints of the chain lie before it.
    body: usize,
    /// Its frame in that of the last of them.
    pose: Pose,
}

/// A link that moves with a joint of the chain, in the joint's frame.
#[derive(Clone, Copy)]
struct Part {
    link: usize,
    inertia: Inertia,
}

/// A joint of the chain with its frame in that of the one before.
struct Moving {
    joint: usize,
    placement: Pose,
}

/// The chain of a path; its name and the notes on unused elements are for the caller.
pub(super) fn description(
    source: &Source,
    tree: &Tree,
    path: &Path,
    gravity: [f64; 3],
    unphysical: Unphysical,
) -> Result<Description, ReadError> {
    let (places, moving, held) = places(tree, path);
    if moving.is_empty() {
        return Err(ReadError::new(format!(
            "joints: got none that moves between {} and {}, wants at least one",
            quoted(&tree.links[path.base].name),
            quoted(&tree.links[path.tip].name)
        )));
    }
    let bodies = bodies(tree, &places, moving.len());
    let mut description = Description {
        name: String::new(),
        joints: Vec::with_capacity(moving.len()),
        tip: places[path.tip].map_or(Pose::IDENTITY, |place| place.pose),
        gravity,
        notes: Vec::new(),
        unphysical,
    };
    for (moving, parts) in moving.iter().zip(&bodies) {
        let joint = &tree.joints[moving.joint];
        description.notes.extend_from_slice(&joint.notes);
        let link_at = tree.ends[moving.joint].1;
        let inertia = merged(source, tree, link_at, parts)?;
        let armature = tree.armatures.get(&joint.name).copied().unwrap_or(0.0);
        description.joints.push(JointDescription {
            name: joint.name.clone(),
            link_name: joint.child.clone(),
            link: link(joint, moving.placement, inertia, armature),
        });
    }
    description.notes.extend(held_note(tree, &held));
    description.notes.extend(massless_note(tree, &places, path, &held));
    checks::take(&mut description)
        .map_err(|problem| located(source, tree, (&moving, &bodies), problem, unphysical))?;
    for (joint, parts) in description.joints.iter().zip(&bodies) {
        description.notes.extend(part_notes(tree, parts, joint));
    }
    Ok(description)
}

/// Where every link beyond the base stands, the joints of the chain, and the joints that move but are held at 0.
fn places(tree: &Tree, path: &Path) -> (Vec<Option<Place>>, Vec<Moving>, Vec<usize>) {
    let mut on_path = vec![false; tree.joints.len()];
    path.joints.iter().for_each(|&joint| on_path[joint] = true);
    let mut places = vec![None; tree.links.len()];
    let (mut moving, mut held) = (Vec::new(), Vec::new());
    let mut waiting = vec![(path.base, Place { body: 0, pose: Pose::IDENTITY })];
    while let Some((link, place)) = waiting.pop() {
        places[link] = Some(place);
        for &index in tree.carried[link].iter().rev() {
            let joint = &tree.joints[index];
            let pose = place.pose.then(&joint.origin);
            let child = tree.ends[index].1;
            if joint.moves() && on_path[index] {
                // The joints of the path come one after another, as each hangs on the one before.
                moving.push(Moving { joint: index, placement: pose });
                waiting.push((child, Place { body: place.body + 1, pose: Pose::IDENTITY }));
                continue;
            }
            if joint.moves() && place.body > 0 {
                held.push(index);
            }
            waiting.push((child, Place { body: place.body, pose }));
        }
    }
    held.sort_unstable();
    (places, moving, held)
}

/// The links with a mass distribution that each joint of the chain moves, in the joint's frame.
fn bodies(tree: &Tree, places: &[Option<Place>], joints: usize) -> Vec<Vec<Part>> {
    let mut bodies = vec![Vec::new(); joints];
    for (link, (stated, place)) in tree.links.iter().zip(places).enumerate() {
        let (Some(inertial), Some(place)) = (&stated.inertial, place) else { continue };
        let body = place.body.checked_sub(1).and_then(|body| bodies.get_mut(body));
        if let Some(parts) = body {
            parts.push(Part { link, inertia: inertial.inertia.transformed(&place.pose) });
        }
    }
    bodies
}

/// One mass distribution of several; a link that moves must have mass.
fn merged(source: &Source, tree: &Tree, link: usize, parts: &[Part]) -> Result<Inertia, ReadError> {
    let inertias = parts.iter().map(|part| part.inertia);
    let inertia = inertias.reduce(|body, part| body.plus(&part)).unwrap_or_default();
    if inertia.mass != 0.0 {
        return Ok(inertia);
    }
    let link = &tree.links[link];
    let name = quoted(&link.name);
    let message = match parts.is_empty() {
        true => format!(
            "link {name}: got no <inertial>, wants one, as it moves; state mass, centre of mass and inertia"
        ),
        false => format!("link {name}, <mass value>: got 0, wants a number > 0, as it moves"),
    };
    Err(source.error(link.at, message))
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
            let link = quoted(&tree.links[link].name);
            format!(
                "link {link}: no body has {how_far}; with all that moves with {carrier} it is one"
            )
        })
        .collect()
}

fn link(joint: &JointPart, placement: Pose, inertia: Inertia, armature: f64) -> Link {
    Link {
        kind: match joint.motion {
            Motion::Prismatic => JointKind::Prismatic,
            _ => JointKind::Revolute,
        },
        placement,
        axis: joint.axis,
        inertia,
        friction: JointFriction {
            viscous: joint.damping,
            coulomb: [joint.friction; 2],
            ..JointFriction::default()
        },
        armature,
        limits: joint.limits,
        stop: JointStop::default(),
    }
}

fn held_note(tree: &Tree, held: &[usize]) -> Option<String> {
    let names = held.iter().map(|&joint| tree.joints[joint].name.as_str());
    (!held.is_empty()).then(|| {
        format!(
            "joints beside or beyond the chain are held at 0, their links' mass is part of the link that carries them: {}",
            listed(names)
        )
    })
}

/// Links of joints held at 0 that state no mass: they would move, and so should have one.
fn massless_note(
    tree: &Tree,
    places: &[Option<Place>],
    path: &Path,
    held: &[usize],
) -> Option<String> {
    let children = held.iter().map(|&joint| tree.ends[joint].1);
    let massless: Vec<_> = children
        .filter(|&link| places[link].is_some() && link != path.tip)
        .filter(|&link| tree.links[link].inertial.is_none())
        .map(|link| tree.links[link].name.as_str())
        .collect();
    (!massless.is_empty()).then(|| {
        format!("links without <inertial> taken as massless: {}", listed(massless.into_iter()))
    })
}

/// A problem with its line: of the first link that is no body, or of the joint.
fn located(
    source: &Source,
    tree: &Tree,
    (moving, bodies): (&[Moving], &[Vec<Part>]),
    problem: Problem,
    unphysical: Unphysical,
) -> ReadError {
    let Some((joint, moving)) = problem.joint.and_then(|at| Some((at, moving.get(at)?))) else {
        return problem.into();
    };
    let parts = bodies.get(joint).filter(|_| problem.of_body).into_iter().flatten();
    let more = checks::way_on(unphysical);
    let of_part = |part: &Part| tree.links[part.link].problem(source, more);
    parts
        .filter_map(of_part)
        .next()
        .unwrap_or_else(|| source.error(tree.joints[moving.joint].at, problem.message))
}

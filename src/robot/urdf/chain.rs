//! From the tree to the chain: every link belongs to the last joint before it that lies between base and tip.

use super::elements::Source;
use super::joint::{Drive, JointPart, Motion};
use super::options::UrdfOptions;
use super::path::Path;
use super::transmission::Rotors;
use super::tree::Tree;
use super::{remarks, size};
use crate::arm::{Inertia, JointFriction, JointKind, JointStop, Link, Pose};
use crate::robot::error::{first_of, quoted};
use crate::robot::{Description, JointDescription, ReadError, checks, frames};

/// A link that moves with a joint of the chain, or with the base.
#[derive(Clone, Copy)]
pub(super) struct Place {
    /// How many joints of the chain lie before it.
    pub body: usize,
    /// Its frame in that of the last of them.
    pub pose: Pose,
}

/// A joint of the chain with its frame in that of the one before.
struct Moving {
    joint: usize,
    placement: Pose,
}

/// Where everything stands.
#[derive(Default)]
pub(super) struct Layout {
    /// Every link beyond the base.
    pub places: Vec<Option<Place>>,
    /// The joints of the chain.
    moving: Vec<Moving>,
    /// The joints that move but are held at 0.
    pub held: Vec<usize>,
    /// Links that move and state no mass, or none that can be read.
    pub massless: Vec<usize>,
    /// What given masses replaced.
    given: Vec<String>,
    /// What was left out.
    notes: Vec<String>,
}

/// The chain of a path; its name and the notes on unused elements are for the caller.
pub(super) fn description(
    source: &Source,
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
        tip: layout.places[path.tip].map_or(frames::identity(), |place| place.pose),
        gravity: options.gravity,
        notes: Vec::new(),
    };
    for (moving, parts) in layout.moving.iter().zip(&bodies) {
        let joint = &tree.joints[moving.joint];
        let mut drive = joint.drive(source)?;
        description.notes.append(&mut drive.notes);
        let armature = rotors.armatures.get(joint.name).copied().unwrap_or(0.0);
        description.joints.push(JointDescription {
            name: joint.name.to_owned(),
            link_name: joint.child.to_owned(),
            link: link(joint, moving.placement, &drive, frames::merged(parts), armature),
        });
    }
    remarks::add(source, tree, path, &layout, &mut description)?;
    let moved = |name: &str| tree.named("", name).is_ok_and(|link| layout.moves(link));
    let unmoved = options.unmoved(moved);
    let notes = &mut description.notes;
    notes.append(&mut layout.given);
    notes.extend(unmoved);
    notes.extend(first_of(layout.notes));
    notes.extend(first_of(rotors.notes.clone()));
    notes.extend(first_of(description.joints.iter().filter_map(size::note).collect()));
    check(source, tree, &layout.moving, &description)?;
    Ok(description)
}

impl Layout {
    fn of(source: &Source, tree: &Tree, path: &Path) -> Result<Self, ReadError> {
        let mut on_path = vec![false; tree.joints.len()];
        path.joints.iter().for_each(|&joint| on_path[joint] = true);
        let mut layout = Self { places: vec![None; tree.links.len()], ..Self::default() };
        let mut waiting = vec![(path.base, Place { body: 0, pose: frames::identity() })];
        while let Some((link, place)) = waiting.pop() {
            layout.places[link] = Some(place);
            for &index in tree.carried[link].iter().rev() {
                let joint = &tree.joints[index];
                let child = tree.ends[index].1;
                // Beside the base nothing moves.
                if place.body == 0 && !on_path[index] {
                    continue;
                }
                let origin = match joint.origin(source) {
                    Ok(origin) => origin,
                    Err(error) if on_path[index] => return Err(error),
                    Err(error) => {
                        layout.notes.push(left_out(&error));
                        continue;
                    }
                };
                let pose = frames::compose(&place.pose, &origin);
                if joint.moves() && on_path[index] {
                    // The joints of the path come one after another, as each hangs on the one
                    // before.
                    layout.moving.push(Moving { joint: index, placement: pose });
                    let place = Place { body: place.body + 1, pose: frames::identity() };
                    waiting.push((child, place));
                    continue;
                }
                if joint.moves() {
                    layout.held.push(index);
                }
                waiting.push((child, Place { body: place.body, pose }));
            }
        }
        layout.held.sort_unstable();
        Ok(layout)
    }

    /// True for a link that moves with a joint of the chain.
    fn moves(&self, link: usize) -> bool {
        self.places[link].is_some_and(|place| place.body > 0)
    }

    /// The mass distributions that each joint of the chain moves, in the joint's frame.
    fn bodies(
        &mut self,
        source: &Source,
        tree: &Tree,
        path: &Path,
        options: &UrdfOptions,
    ) -> Result<Vec<Vec<Inertia>>, ReadError> {
        let mut bodies = vec![Vec::new(); self.moving.len()];
        let mut on_path = vec![false; tree.links.len()];
        path.joints.iter().for_each(|&joint| on_path[tree.ends[joint].1] = true);
        for (index, link) in tree.links.iter().enumerate() {
            let Some(Place { body, pose }) = self.places[index] else { continue };
            let Some(parts) = body.checked_sub(1).and_then(|body| bodies.get_mut(body)) else {
                continue;
            };
            let read = options.inertial(source, link, &mut self.given);
            match read {
                Ok(Some(inertial)) => {
                    link.check(source, &inertial)?;
                    parts.push(frames::carried(&inertial.inertia, &pose));
                    if inertial.inertia.mass == 0.0 {
                        self.massless.push(index);
                    }
                }
                Ok(None) => self.massless.push(index),
                Err(error) if on_path[index] || options.gives(link) => return Err(error),
                Err(error) => {
                    self.notes.push(left_out(&error));
                    self.massless.push(index);
                }
            }
        }
        Ok(bodies)
    }
}

/// A note on what stands outside base and tip and cannot be read.
pub(super) fn left_out(error: &ReadError) -> String {
    format!("{error}; left out, as it is not between base and tip")
}

/// Refuses a last link without mass. Those before it need none, as what hangs on them has mass:
/// whether the mass matrix is positive definite is for the arm to judge.
fn refuse_massless(
    source: &Source,
    tree: &Tree,
    layout: &Layout,
    bodies: &[Vec<Inertia>],
) -> Result<(), ReadError> {
    let (Some(moving), Some(parts)) = (layout.moving.last(), bodies.last()) else { return Ok(()) };
    if parts.iter().any(|part| part.mass != 0.0) {
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
        kind: match joint.motion {
            Motion::Prismatic => JointKind::Prismatic,
            Motion::Continuous => JointKind::Continuous,
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

/// The checks of every description, here against numbers that are each finite but not together.
fn check(
    source: &Source,
    tree: &Tree,
    moving: &[Moving],
    description: &Description,
) -> Result<(), ReadError> {
    checks::check(description).map_err(|problem| {
        match problem.joint.and_then(|joint| moving.get(joint)) {
            Some(moving) => source.error(tree.joints[moving.joint].at, problem.message),
            None => ReadError::new(problem.message),
        }
    })
}

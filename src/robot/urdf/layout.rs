//! Which links move with which joint of a chain, and what mass they have.

use super::elements::Document;
use super::link::Inertial;
use super::options::UrdfOptions;
use super::path::Path;
use super::tree::Tree;
use crate::arm::{Inertia, Pose};
use crate::robot::ReadError;

/// A link that moves with a joint of the chain, or with the base.
#[derive(Clone, Copy)]
pub(super) struct Place {
    /// How many joints of the chain lie before it.
    pub body: usize,
    /// Its frame in that of the last of them.
    pub pose: Pose,
}

/// A link that moves with a joint of the chain.
pub(super) struct Part {
    pub link: usize,
    pub stated: Inertial,
    /// In the joint's frame.
    pub inertia: Inertia,
}

/// A joint of the chain with its frame in that of the one before.
pub(super) struct Moving {
    pub joint: usize,
    pub placement: Pose,
}

/// Where everything stands.
#[derive(Default)]
pub(super) struct Layout {
    /// Every link beyond the base.
    pub places: Vec<Option<Place>>,
    /// The joints of the chain.
    pub moving: Vec<Moving>,
    /// The joints that move but are held at 0.
    pub held: Vec<usize>,
    /// Links that move and state no mass, or none that can be read.
    pub massless: Vec<usize>,
    /// What given masses replaced.
    pub given: Vec<String>,
    /// What was left out.
    pub notes: Vec<String>,
}

impl Layout {
    pub fn of(source: &Document, tree: &Tree, path: &Path) -> Result<Self, ReadError> {
        let mut on_path = vec![false; tree.joints.len()];
        path.joints.iter().for_each(|&joint| on_path[joint] = true);
        let mut layout = Self { places: vec![None; tree.links.len()], ..Self::default() };
        let mut waiting = vec![(path.base, Place { body: 0, pose: Pose::IDENTITY })];
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
                let pose = place.pose.then(&origin);
                if joint.moves() && on_path[index] {
                    // The joints of the path come one after another, as each hangs on the one
                    // before.
                    layout.moving.push(Moving { joint: index, placement: pose });
                    let place = Place { body: place.body + 1, pose: Pose::IDENTITY };
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
    pub fn moves(&self, link: usize) -> bool {
        self.places[link].is_some_and(|place| place.body > 0)
    }

    /// The mass distributions that each joint of the chain moves, in the joint's frame.
    pub fn bodies(
        &mut self,
        source: &Document,
        tree: &Tree,
        path: &Path,
        options: &UrdfOptions,
    ) -> Result<Vec<Vec<Part>>, ReadError> {
        let mut bodies: Vec<_> = self.moving.iter().map(|_| Vec::new()).collect();
        let mut on_path = vec![false; tree.links.len()];
        path.joints.iter().for_each(|&joint| on_path[tree.ends[joint].1] = true);
        for (index, link) in tree.links.iter().enumerate() {
            let Some(Place { body, pose }) = self.places[index] else { continue };
            let Some(parts) = body.checked_sub(1).and_then(|body| bodies.get_mut(body)) else {
                continue;
            };
            let read = options.inertial(source, link, &mut self.given);
            match read {
                Ok(Some(stated)) => {
                    let inertia = stated.inertia.transformed(&pose);
                    if inertia.mass == 0.0 {
                        self.massless.push(index);
                    }
                    parts.push(Part { link: index, stated, inertia });
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

//! URDF: the chain from a base link to a tip link, its fixed links merged.
//!
//! Joints that move but do not lie between base and tip are held at 0, their mass is part of the link that carries them.

mod chain;
mod elements;
mod joint;
mod link;
mod scan;
mod transmission;
mod tree;
mod unused;

use std::path::Path;

use super::error::quoted;
use super::{Description, ReadError};
use crate::arm::Unphysical;
use elements::Source;
use tree::Tree;

impl Description {
    /// The chain from the link `base` (by default the root) to the link `tip` (by default the only end of the robot) of
    /// a URDF, with `gravity` in the base's frame [m/s²].
    ///
    /// Fixed joints are merged. `<dynamics>` gives viscous and Coulomb friction, `<limit>` the limits (0 for none),
    /// `<transmission>` the rotor's inertia where it states one. What is not used is said in `notes`.
    ///
    /// # Errors
    /// With the line: what is not XML or not URDF, has a DTD, is too large or too deep; loops, two parents, names given
    /// twice, unknown base or tip, several ends to choose from; between base and tip `mimic`, floating and planar joints,
    /// and links without mass; numbers that are none, and mass distributions that no body has.
    pub fn from_urdf(
        text: &str,
        base: Option<&str>,
        tip: Option<&str>,
        gravity: [f64; 3],
    ) -> Result<Self, ReadError> {
        Self::from_urdf_taking(text, base, tip, gravity, Unphysical::Refuse)
    }

    /// [`Description::from_urdf`], with a say in what is done about a link that no body is: all that moves with a joint,
    /// together. What is no body by itself but part of one is noted in any case.
    ///
    /// # Errors
    /// As there, but for what is to be taken.
    pub fn from_urdf_taking(
        text: &str,
        base: Option<&str>,
        tip: Option<&str>,
        gravity: [f64; 3],
        unphysical: Unphysical,
    ) -> Result<Self, ReadError> {
        scan::check(text)?;
        let options = roxmltree::ParsingOptions {
            allow_dtd: false,
            nodes_limit: scan::MOST_NODES,
            ..Default::default()
        };
        let document = roxmltree::Document::parse_with_options(text, options)
            .map_err(|error| not_xml(text, &error))?;
        let source = Source { text };
        let robot = document.root_element();
        if robot.tag_name().name() != "robot" {
            let name = quoted(robot.tag_name().name());
            let message = format!("got the element {name} at the top, wants <robot>");
            return Err(source.error(robot.range().start, message));
        }
        source.refuse_macros(robot)?;
        let tree = Tree::read(&source, robot)?;
        let path = tree.path(&source, base, tip)?;
        let mut description = chain::description(&source, &tree, &path, gravity, unphysical)?;
        description.name = robot.attribute("name").unwrap_or("robot").to_owned();
        description.notes.extend(unused::notes(&source, robot));
        Ok(description)
    }

    /// [`Description::from_urdf`] of a file. No other file is opened, whatever the URDF names.
    ///
    /// # Errors
    /// As there, and if the file cannot be read.
    pub fn from_urdf_file(
        path: impl AsRef<Path>,
        base: Option<&str>,
        tip: Option<&str>,
        gravity: [f64; 3],
    ) -> Result<Self, ReadError> {
        Self::from_file(path, |text| Self::from_urdf(text, base, tip, gravity))
    }
}

/// The XML reader's complaint; its own words end with the position, which the line says already.
fn not_xml(text: &str, error: &roxmltree::Error) -> ReadError {
    use roxmltree::Error::{NodesLimitReached, UnclosedRootNode};
    let mut complaint = error.to_string();
    let position = format!(" at {}", error.pos());
    if let Some(short) = complaint.strip_suffix(&position) {
        complaint = short.to_owned();
    }
    let shown = quoted(&complaint);
    let message = format!("not well-formed XML: {}", shown.trim_matches('"'));
    match error {
        NodesLimitReached => ReadError::new(format!(
            "got more than {} elements and texts, wants fewer",
            scan::MOST_NODES
        )),
        UnclosedRootNode => ReadError::at(text, text.len(), message),
        _ => ReadError { line: Some(error.pos().row as usize), ..ReadError::new(message) },
    }
}

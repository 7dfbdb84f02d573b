//! URDF: the chain from a base link to a tip link, its fixed links merged.
//!
//! Joints that move but do not lie between base and tip are held at 0, their mass is part of the
//! link that carries them.

mod chain;
mod elements;
mod joint;
mod layout;
mod lenient;
mod link;
mod names;
mod options;
mod path;
mod remarks;
mod scan;
mod size;
mod solid;
mod transmission;
mod tree;
mod unused;

use std::collections::BTreeSet;

pub use options::UrdfOptions;

use super::error::quoted;
use super::{Description, ReadError, files};
use elements::Document;
use path::Path;
use transmission::Rotors;
use tree::Tree;

impl Description {
    /// The chain from the link `base` to the link `tip` of a URDF: [`Description::from_urdf_with`],
    /// nothing put in the place of what the file states.
    ///
    /// # Errors
    /// As there.
    pub fn from_urdf(
        text: &str,
        base: Option<&str>,
        tip: Option<&str>,
        gravity: [f64; 3],
    ) -> Result<Self, ReadError> {
        Self::from_urdf_with(text, &options(base, tip, gravity))
    }

    /// The chain from a base link to a tip link of a URDF, as `options` say.
    ///
    /// Fixed joints are merged, other joints stand at 0. `<dynamics>` gives viscous and Coulomb
    /// friction, `<limit>` the limits (0 for none), `<transmission>` the rotor's inertia where it
    /// states one: gear_ratio² · rotor_inertia where one of these tags of Drake's stands, else
    /// mechanicalReduction² · motorInertia. What is not used, or not as one would think, is said in
    /// `notes`.
    ///
    /// XML is read as the common readers of URDF take it: prefixes need not be declared, comments
    /// may hold dashes, declarations stand anywhere, leftover definitions of xacro are skipped.
    ///
    /// # Errors
    /// With the line: what is not XML or not URDF, has a DTD, is too large or too deep, or is still
    /// to be expanded by xacro; unknown names; between base and tip loops, two parents, names given
    /// twice, `mimic`, floating and planar joints, numbers that are none, mass distributions that
    /// no body has, and a last joint that moves no mass. If no tip is named, two roots and several
    /// ends to choose from, and loops and faulty names anywhere.
    pub fn from_urdf_with(text: &str, options: &UrdfOptions) -> Result<Self, ReadError> {
        scan::check(text)?;
        let parsing = roxmltree::ParsingOptions {
            allow_dtd: false,
            nodes_limit: scan::MOST_NODES,
            ..Default::default()
        };
        let lenient = lenient::lenient(text);
        let document = roxmltree::Document::parse_with_options(&lenient, parsing)
            .map_err(|error| not_xml(text, &error))?;
        let source = Document::new(text);
        let robot = document.root_element();
        if source.name(robot) != "robot" {
            let message =
                format!("got the element {} at the top, wants <robot>", quoted(source.name(robot)));
            return Err(source.error(robot.range().start, message));
        }
        source.refuse_macros(robot)?;
        let tree = Tree::read(&source, robot)?;
        options.check(&tree)?;
        let path = Path::of(&source, &tree, options.base.as_deref(), options.tip.as_deref())?;
        let chain: BTreeSet<_> = path.joints.iter().map(|&joint| tree.joints[joint].name).collect();
        let rotors = Rotors::read(&source, robot, |name| chain.contains(name))?;
        let mut description = chain::description(&source, &tree, &path, &rotors, options)?;
        description.name = robot.attribute("name").unwrap_or("robot").to_owned();
        description.notes.extend(unused::notes(&source, robot));
        Ok(description)
    }

    /// [`Description::from_urdf`] of a file.
    ///
    /// # Errors
    /// As [`Description::from_urdf_file_with`].
    pub fn from_urdf_file(
        path: impl AsRef<std::path::Path>,
        base: Option<&str>,
        tip: Option<&str>,
        gravity: [f64; 3],
    ) -> Result<Self, ReadError> {
        Self::from_urdf_file_with(path, &options(base, tip, gravity))
    }

    /// [`Description::from_urdf_with`] of a file. No other file is opened, whatever the URDF names.
    /// Bytes that are not UTF-8 are taken as Latin-1.
    ///
    /// # Errors
    /// As there, and if the file cannot be read.
    pub fn from_urdf_file_with(
        path: impl AsRef<std::path::Path>,
        options: &UrdfOptions,
    ) -> Result<Self, ReadError> {
        let path = path.as_ref();
        let (text, note) = files::read_any(path)?;
        let read = Self::from_urdf_with(&text, options);
        let mut description = read.map_err(|error| error.in_file(path))?;
        description.notes.extend(note);
        Ok(description)
    }
}

fn options(base: Option<&str>, tip: Option<&str>, gravity: [f64; 3]) -> UrdfOptions {
    let (base, tip) = (base.map(str::to_owned), tip.map(str::to_owned));
    UrdfOptions { base, tip, gravity, ..UrdfOptions::default() }
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
        _ => ReadError::new(message).on_line(error.pos().row as usize),
    }
}

//! Descriptions of serial arms: from URDF, from Denavit-Hartenberg tables, from our own TOML, and a
//! few that ship.
//!
//! A [`Description`] is what was read; [`Description::links`] turns it into the array that a serial
//! arm is built from. Files are taken for hostile: sizes and depths are limited, nothing but the
//! file named is opened, and every error says the line. Source of the format:
//! wiki.ros.org/urdf/XML.
// Without files, tables need only a part of the checks and turns.
#![cfg_attr(not(feature = "urdf"), allow(dead_code))]

mod checks;
mod dh;
mod error;
#[cfg(feature = "urdf")]
mod files;
mod frames;
#[cfg(feature = "urdf")]
mod shipped;
#[cfg(feature = "urdf")]
mod toml;
#[cfg(feature = "urdf")]
mod urdf;

pub use dh::{Convention, DhRow};
pub use error::ReadError;
#[cfg(feature = "urdf")]
pub(crate) use files::limited;
#[cfg(feature = "urdf")]
pub use shipped::{SHIPPED, shipped};
#[cfg(feature = "urdf")]
pub use urdf::UrdfOptions;

use std::collections::BTreeSet;

use crate::arm::{Link, Pose, Serial, SerialParameters, Unphysical};
use error::quoted;

/// Gravity where nothing else is said [m/s²]: down the base's z axis.
pub const GRAVITY: [f64; 3] = [0.0, 0.0, -9.81];

/// A serial chain of any length.
#[derive(Clone, Debug, PartialEq)]
pub struct Description {
    /// What the robot is called.
    pub name: String,
    /// The joints that move, from the base outwards, each with its link.
    pub joints: Vec<JointDescription>,
    /// The tip in the frame of the last link.
    pub tip: Pose,
    /// Gravity in the base's frame [m/s²].
    pub gravity: [f64; 3],
    /// What the file says that was not used, or not taken as it stands; each said once.
    pub notes: Vec<String>,
    /// What was done about links that no rigid body can be; each is in the notes.
    pub unphysical: Unphysical,
}

/// A joint of a [`Description`].
#[derive(Clone, Debug, PartialEq)]
pub struct JointDescription {
    /// Name of the joint.
    pub name: String,
    /// Name of the link that it moves.
    pub link_name: String,
    /// The joint and its link; fixed links are merged into it.
    pub link: Link,
}

impl Description {
    /// What `read` makes of the text of a file of limited size; its errors name the file.
    ///
    /// # Errors
    /// As `read`, and if the file cannot be read.
    #[cfg(feature = "urdf")]
    pub(crate) fn from_file(
        path: impl AsRef<std::path::Path>,
        read: impl FnOnce(&str) -> Result<Self, ReadError>,
    ) -> Result<Self, ReadError> {
        let path = path.as_ref();
        let text = files::read(path)?;
        read(&text).map_err(|error| error.in_file(path))
    }

    /// The links as an array, for an arm of `N` joints.
    ///
    /// # Errors
    /// If the chain does not have `N` joints.
    pub fn links<const N: usize>(&self) -> Result<[Link; N], ReadError> {
        let links: Vec<Link> = self.joints.iter().map(|joint| joint.link).collect();
        let got = links.len();
        <[Link; N]>::try_from(links).map_err(|_| {
            ReadError::new(format!(
                "joints: {} has {got} between base and tip, wants {N}; choose another base or \
                 tip, or an arm of {got} joints",
                quoted(&self.name)
            ))
        })
    }

    /// The arm, with `N` joints. It keeps the policy for links that no rigid body can be.
    ///
    /// # Errors
    /// If the chain does not have `N` joints, or as [`Serial::new_with`], with the joint by name.
    pub fn arm<const N: usize>(&self) -> Result<Serial<N>, ReadError> {
        let Self { tip, gravity, unphysical, .. } = *self;
        let parameters = SerialParameters { links: self.links()?, tip, gravity };
        Serial::new_with(parameters, unphysical)
            .map_err(|error| ReadError::new(checks::of_arm(self, error)))
    }

    /// The same robot with other links, its notes brought up to date.
    ///
    /// # Errors
    /// As reading it.
    pub fn with_links(&self, links: impl IntoIterator<Item = Link>) -> Result<Self, ReadError> {
        let mut other = self.clone();
        let of_old: BTreeSet<String> = checks::as_stated(self).into_iter().collect();
        other.notes.retain(|note| !of_old.contains(note));
        for (joint, link) in other.joints.iter_mut().zip(links) {
            joint.link = link;
        }
        checks::take(&mut other)?;
        Ok(other)
    }
}

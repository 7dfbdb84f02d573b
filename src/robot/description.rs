//! What a file or a table says of a robot.

use super::ReadError;
use super::error::quoted;
#[cfg(feature = "urdf")]
use super::files;
use crate::arm::{Link, Pose, Unphysical};

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
}

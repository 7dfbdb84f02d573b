//! The arm of a description, and the description of an arm with other links.

use std::collections::BTreeSet;

use super::{Description, ReadError, checks};
use crate::arm::{Link, Serial, SerialParameters};

impl Description {
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

//! What a serial arm is made of.

use super::{Link, Pose};

/// What a serial arm is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SerialParameters<const N: usize> {
    /// Joints and links from the base on.
    pub links: [Link; N],
    /// The tip in the last link's frame.
    pub tip: Pose,
    /// Gravity in the axes of the base [m/s²], as `[0.0, 0.0, -9.81]`.
    pub gravity: [f64; 3],
}

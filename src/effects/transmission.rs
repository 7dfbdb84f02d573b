//! What is between motor and link: gears that give, and on which side of them the encoders are.

use crate::plant::Elastic;

/// Gears that give.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transmission<const N: usize> {
    /// Stiffness, damping, rotors and play. The plant's own rotors are to be left out.
    pub gears: Elastic<N>,
    /// Where the encoders are.
    pub encoders: Side,
}

/// A side of the gears.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// At the motors, as in most robots.
    Motor,
    /// At the links.
    Link,
}

//! What compensates, as one of several that stand side by side.

use super::Inputs;
use crate::fuzzy::Spaced;

/// What of a compensator and its state is put beside others, for many runs at a time.
#[derive(Clone, Copy, Debug)]
pub struct Learns<'a, const N: usize>(pub(super) Kind<'a, N>);

impl<const N: usize> Learns<'_, N> {
    /// Nothing: ρ̂ = 0.
    pub const NOTHING: Self = Self(Kind::Nothing);
}

/// What it is.
#[derive(Clone, Copy, Debug)]
pub(super) enum Kind<'a, const N: usize> {
    /// ρ̂ = 0.
    Nothing,
    /// A grid a joint over two inputs, whose weights nothing pulls but a leak.
    PerJoint(PerJointSide<'a, N>),
}

/// A grid a joint, and its weights.
#[derive(Clone, Copy, Debug)]
pub(super) struct PerJointSide<'a, const N: usize> {
    pub inputs: Inputs,
    /// The sets of both inputs of each joint.
    pub sets: [[Spaced; 2]; N],
    pub normalized: bool,
    /// The last row and column of P, and the gain.
    pub p12: [f64; N],
    pub p22: [f64; N],
    pub gain: [f64; N],
    pub leak_rate: f64,
    pub dead_zone: f64,
    pub normalization: f64,
    /// The rows of weights, of this length, rule after rule.
    pub weights: &'a [f64],
    pub row: usize,
    #[cfg(feature = "std")]
    pub advances: u64,
}

impl<const N: usize> PerJointSide<'_, N> {
    /// Whether they move by the law (18) alone.
    pub fn is_plain(&self) -> bool {
        [self.leak_rate, self.dead_zone, self.normalization] == [0.0; 3]
    }
}

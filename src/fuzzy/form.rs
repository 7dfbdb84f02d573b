//! How sets combine to rules, and how many of each a basis may have.

/// Most inputs of a basis: seven signals of eight joints fit.
pub const MAX_INPUTS: usize = 64;

/// Most sets of a basis, over all its inputs.
pub const MAX_SETS: usize = 512;

/// Most rules of a basis.
pub const MAX_RULES: usize = 1 << 20;

/// How sets combine to rules.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Every combination of one set per input.
    Grid,
    /// Rule j uses set j on every input; all inputs have equally many sets.
    Shared,
    /// Every set of every input is a rule of its own, normalised input by input.
    Concat,
    /// A grid for each joint over its own inputs; input k belongs to joint k mod `joints`.
    PerJoint {
        /// Number of joints.
        joints: usize,
    },
}

impl Form {
    #[inline]
    pub(super) fn is_product(self) -> bool {
        matches!(self, Self::Grid | Self::PerJoint { .. })
    }
}

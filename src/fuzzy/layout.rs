//! Sizes of an evaluated basis.

use super::basis::{Form, MAX_RULES, length};
use super::kernels::LANES;
use crate::error::{Error, Result};

/// The trailing factor v of ξ = u ⊗ v takes inputs until it is this long: little of it is then padding, and it is soon made.
const MIN_INNER: usize = 3 * LANES;

/// Sizes of the factors of ξ = u ⊗ v.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layout {
    /// Independent vectors ξ: one, or one a joint.
    pub blocks: usize,
    /// Inputs of a block.
    pub inputs: usize,
    /// Those that make up u.
    pub leading: usize,
    /// Length of u.
    pub outer: usize,
    /// Length of v.
    pub inner: usize,
    /// Length of v with its padding to whole lanes.
    pub stride: usize,
    /// Length of an evaluated block: v, u, each with room for one more run of lanes.
    pub block: usize,
    /// Start of the memberships that the blocks are made of.
    pub memberships: usize,
    /// Length of an evaluated basis: its blocks, and the memberships.
    pub total: usize,
}

impl Layout {
    /// The layout of a basis whose inputs have so many sets; their memberships take `memberships` entries.
    pub fn new(form: Form, sets: &[usize], memberships: usize) -> Result<Self> {
        match form {
            Form::Grid => Self::grid(1, sets, memberships),
            Form::PerJoint { joints } => {
                if joints == 0 {
                    return Err(Error::WrongLength { parameter: "joints", got: 0, wanted: 1 });
                }
                if !sets.len().is_multiple_of(joints) {
                    let (got, wanted) = (sets.len(), sets.len().next_multiple_of(joints));
                    return Err(Error::WrongLength { parameter: "inputs", got, wanted });
                }
                for (input, own) in sets.iter().enumerate() {
                    length("centers", *own, sets[input - input % joints])?;
                }
                Self::grid(joints, sets, memberships)
            }
            Form::Shared => {
                for own in sets {
                    length("centers", *own, sets[0])?;
                }
                Ok(Self::sized(1, sets.len(), 0, (1, sets[0]), memberships))
            }
            Form::Concat => Ok(Self::sized(1, sets.len(), 0, (1, sets.iter().sum()), memberships)),
        }
    }

    fn sized(
        blocks: usize,
        inputs: usize,
        leading: usize,
        (outer, inner): (usize, usize),
        memberships: usize,
    ) -> Self {
        let stride = inner.next_multiple_of(LANES);
        let block = stride + outer.next_multiple_of(LANES) + 2 * LANES;
        let (memberships, total) = (blocks * block, blocks * block + memberships);
        Self { blocks, inputs, leading, outer, inner, stride, block, memberships, total }
    }

    fn grid(blocks: usize, sets: &[usize], memberships: usize) -> Result<Self> {
        let own = || sets.iter().step_by(blocks).copied();
        let rules = own().try_fold(blocks, usize::checked_mul);
        if rules.is_none_or(|rules| rules > MAX_RULES) {
            return Err(Error::TooMany { parameter: "rules", got: rules, limit: MAX_RULES });
        }
        let inputs = sets.len() / blocks;
        let (mut leading, mut inner) = (inputs, 1);
        while leading > 0 && inner < MIN_INNER {
            leading -= 1;
            inner *= sets[leading * blocks];
        }
        let outer = own().take(leading).product();
        Ok(Self::sized(blocks, inputs, leading, (outer, inner), memberships))
    }
}

//! Sizes of an evaluated basis.

use super::form::{Form, MAX_RULES};
use super::places::{Dyad, Dyads, Span};
use crate::error::{Error, Result, length, not_empty};
use crate::math::LANES;

/// The trailing factor v of ξ = u ⊗ v takes inputs until it is this long: little of it is then
/// padding, and it is soon made.
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
    /// The order of a weight matrix, u by v: the columns that fill no whole lanes, column by
    /// column, if less of them is then padding; and the others, row by row.
    pub dyads: Dyads,
    /// Length of an evaluated block: v, u, each with room for one more run of lanes.
    pub block: usize,
    /// Start of the memberships that the blocks are made of.
    pub memberships: usize,
    /// Length of an evaluated basis: its blocks, and the memberships.
    pub total: usize,
}

impl Layout {
    /// The layout of a basis whose inputs have so many sets; their memberships take `memberships`
    /// entries.
    pub fn new(form: Form, sets: &[usize], memberships: usize) -> Result<Self> {
        match form {
            Form::Grid => Self::grid(1, sets, memberships),
            Form::PerJoint { joints } => {
                not_empty("joints", joints)?;
                length("inputs", sets.len(), sets.len().next_multiple_of(joints))?;
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
        let (stride, height) = (inner.next_multiple_of(LANES), outer.next_multiple_of(LANES));
        let (u, v) = (Span { first: stride + LANES, len: outer }, Span { first: 0, len: stride });
        let left_over = inner % LANES;
        let dyads = if left_over > 0 && left_over * height < outer * LANES {
            let (whole, rest) =
                (inner - left_over, Span { first: inner - left_over, len: left_over });
            let column = Span { len: height, ..u };
            [Dyad { u: rest, v: column }, Dyad { u, v: Span { len: whole, ..v } }]
        } else {
            [Dyad::EMPTY, Dyad { u, v }]
        };
        let block = stride + height + 2 * LANES;
        let (memberships, total) = (blocks * block, blocks * block + memberships);
        Self { blocks, inputs, leading, outer, inner, stride, dyads, block, memberships, total }
    }

    /// Where the weights of all rules stand in their matrix.
    pub fn places(self) -> impl Iterator<Item = usize> {
        let row = move |row| (0..self.inner).map(move |column| self.place(row, column));
        (0..self.outer).flat_map(row)
    }

    /// Where the weight of a rule stands.
    fn place(&self, row: usize, column: usize) -> usize {
        let [columns, rows] = &self.dyads;
        match column.checked_sub(rows.v.len) {
            None => columns.len() + row * rows.v.len + column,
            Some(left_over) => left_over * columns.v.len + row,
        }
    }

    fn grid(blocks: usize, sets: &[usize], memberships: usize) -> Result<Self> {
        let own = || sets.iter().step_by(blocks).copied();
        let rules = own().try_fold(blocks, usize::checked_mul);
        if rules.is_none_or(|rules| rules > MAX_RULES) {
            return Err(Error::too_many("rules", rules, MAX_RULES));
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

#[cfg(test)]
#[cfg(feature = "std")]
mod tests {
    use super::*;

    #[test]
    fn every_rule_has_a_place_of_its_own_where_its_factors_meet() {
        for sets in [&[5, 5, 5, 5][..], &[4, 3], &[7, 7, 7, 7], &[3; 6], &[6, 6, 6], &[9, 2], &[1]]
        {
            let layout = Layout::grid(1, sets, 0).unwrap();
            let mut block = vec![0.0; layout.block];
            let u_first = layout.stride + LANES;
            (0..layout.outer).for_each(|row| block[u_first + row] = 1.0 + row as f64);
            (0..layout.inner).for_each(|column| block[column] = 1000.0 * (1.0 + column as f64));
            let products: Vec<f64> = layout
                .dyads
                .iter()
                .flat_map(|dyad| dyad.u.of(&block).iter().map(|u| (u, dyad.v.of(&block))))
                .flat_map(|(u, v)| v.iter().map(move |v| u * v))
                .collect();
            let places: Vec<usize> = layout.places().collect();
            for rule in 0..layout.outer * layout.inner {
                let (row, column) = (rule / layout.inner, rule % layout.inner);
                let wanted = 1000.0 * (1.0 + row as f64) * (1.0 + column as f64);
                assert_eq!(products[places[rule]], wanted, "{sets:?} {rule}");
            }
            let padding = products.iter().filter(|product| **product == 0.0).count();
            assert_eq!(products.len() - padding, layout.outer * layout.inner, "{sets:?}");
        }
    }

    #[test]
    fn the_625_rules_of_the_paper_have_7_of_padding() {
        let layout = Layout::grid(1, &[5; 4], 0).unwrap();
        assert_eq!(layout.dyads.iter().map(Dyad::len).sum::<usize>(), 632);
    }
}

//! The fuzzy basis ξ(x): firing strengths of the rules, raw or normalised (eq. 4).
//!
//! The paper gives the sets but not the rules. Four readings:
//!
//! | form | rules | ξ |
//! |---|---|---|
//! | grid | one for every combination of one set per input | ξ = ⊗ᵢ pᵢ |
//! | shared | rule j uses set j on every input | ξ_j = ∏ᵢ μ_ij |
//! | concat | one for every set of every input | ξ = [p₁; p₂; …] |
//! | per joint | a grid for each joint, over that joint's inputs | ξⁿ = ⊗ᵢ pⁿᵢ |
//!
//! with pᵢ the memberships of input i. A product grid is never written out: ξ = u ⊗ v with u over
//! the leading and v over the trailing inputs, so that ξ(x)·ξ(y) = (u·u')(v·v'), and W ξ takes one
//! pass over W.

use pulp::{Arch, Simd, WithSimd};

use super::axes::{Axes, Axis};
use super::form::{Form, MAX_INPUTS};
use super::kronecker::{Column, kronecker};
use super::lanes::dot;
use super::lattice::Spaced;
use super::layout::Layout;
use super::membership::exponentials;
use super::memory::{Buffer, Memory, Room};
use super::places::{Dyad, Dyads};
use crate::error::{Result, finite, length};
use crate::math::{FNV_START, LANES, TINY_KERNEL, fnv_of, sqrt, unless_rarely_tiny, unless_tiny};

/// A fuzzy basis over a fixed number of inputs. Immutable; the caller owns the buffers it writes
/// to, and may lend the one that its sets stand in.
#[derive(Clone, Debug)]
pub struct FuzzyBasis<B: Buffer = Room> {
    form: Form,
    axes: Axes,
    numbers: Memory<B>,
    /// The memberships of every input, block after block.
    factors: [Column; MAX_INPUTS],
    layout: Layout,
}

impl FuzzyBasis {
    /// A basis over `axes.len()` inputs.
    ///
    /// # Errors
    /// `centers`, `width`: not finite, empty, of unequal length, or a width outside 1e-9 … 1e9.
    /// `inputs`, `sets`, `rules`: more than [`MAX_INPUTS`], [`MAX_SETS`](super::MAX_SETS),
    /// [`MAX_RULES`](super::MAX_RULES); nothing is allocated before that is known. Without `std`,
    /// `buffer`: more sets than the basis has [`Room`] for; lend memory by
    /// [`new_in`](Self::new_in).
    pub fn new(form: Form, normalized: bool, axes: &[Axis<'_>]) -> Result<Self> {
        Self::over(form, normalized, axes, Memory::own)
    }

    /// Length of the buffer that the sets of these inputs need.
    ///
    /// # Errors
    /// As [`new`](Self::new), for the sets.
    pub fn buffer_len(axes: &[Axis<'_>]) -> Result<usize> {
        Ok(Memory::<Room>::buffer_len(Axes::new(true, axes)?.numbers()))
    }
}

impl<B: Buffer> FuzzyBasis<B> {
    /// A basis over `axes.len()` inputs whose sets stand in a buffer of the caller's: an array, a
    /// slice, a vector.
    ///
    /// # Errors
    /// As [`new`](FuzzyBasis::new). `buffer`: shorter than [`buffer_len`](FuzzyBasis::buffer_len).
    pub fn new_in(form: Form, normalized: bool, axes: &[Axis<'_>], buffer: B) -> Result<Self> {
        Self::over(form, normalized, axes, |len| Memory::new(buffer, len))
    }

    #[inline(never)]
    fn over(
        form: Form,
        normalized: bool,
        sets: &[Axis<'_>],
        memory: impl FnOnce(usize) -> Result<Memory<B>>,
    ) -> Result<Self> {
        let axes = Axes::new(normalized, sets)?;
        let (mut counts, mut factors) = ([0; MAX_INPUTS], [Column::EMPTY; MAX_INPUTS]);
        counts.iter_mut().zip(axes.columns()).for_each(|(to, column)| *to = column.len());
        let layout = Layout::new(form, &counts[..axes.inputs()], axes.len())?;
        for (i, column) in axes.columns().iter().enumerate() {
            factors[i % layout.blocks * layout.inputs + i / layout.blocks] = *column;
        }
        let mut numbers = memory(axes.numbers())?;
        axes.write(sets, numbers.as_mut_slice());
        Ok(Self { form, axes, numbers, factors, layout })
    }

    /// How the sets combine.
    pub fn form(&self) -> Form {
        self.form
    }

    /// Whether ξ is normalised (fuzzy basis functions) or raw (firing strengths).
    pub fn normalized(&self) -> bool {
        self.axes.normalized()
    }

    /// Number of inputs, the length of x.
    pub fn inputs(&self) -> usize {
        self.axes.inputs()
    }

    /// Number of rules, the length of ξ (for a basis per joint: of all joints' together).
    pub fn rules(&self) -> usize {
        self.layout.blocks * self.block_rules()
    }

    /// Length of the `work` buffer of [`evaluate`](Self::evaluate).
    pub fn work_len(&self) -> usize {
        self.activation_len() + self.scratch_len()
    }

    /// Writes ξ(x). First input slowest, so that a grid reshapes to (sets₁, sets₂, …).
    ///
    /// # Errors
    /// `x`: wrong length or not finite. `work`, `xi`: wrong length.
    pub fn evaluate(&self, x: &[f64], work: &mut [f64], xi: &mut [f64]) -> Result<()> {
        length("x", x.len(), self.inputs())?;
        length("work", work.len(), self.work_len())?;
        length("xi", xi.len(), self.rules())?;
        finite("x", x)?;
        let (activation, scratch) = work.split_at_mut(self.activation_len());
        Arch::new().dispatch(Activate { basis: self, x, scratch, activation });
        for (block, out) in xi.chunks_exact_mut(self.block_rules()).enumerate() {
            let (u, v) = self.split(self.block(activation, block));
            for (row, a) in out.chunks_exact_mut(self.layout.inner).zip(u) {
                row.iter_mut().zip(v).for_each(|(y, b)| *y = a * b);
            }
        }
        Ok(())
    }

    /// The sets of an input, if they are on a lattice.
    pub(crate) fn spaced(&self, input: usize) -> Option<Spaced> {
        self.axes.spaced(self.numbers.as_slice(), input)
    }

    /// Whether all rules of a block are in its trailing factor, lane after lane.
    pub(crate) fn is_inner(&self) -> bool {
        self.layout.leading == 0 && self.layout.dyads[0].len() == 0
    }

    /// Rules of one block.
    pub(crate) fn block_rules(&self) -> usize {
        self.layout.outer * self.layout.inner
    }

    /// Number of independent vectors ξ.
    pub(crate) fn blocks(&self) -> usize {
        self.layout.blocks
    }

    /// The one that joint `n` uses.
    #[inline]
    pub(crate) fn block_of(&self, n: usize) -> usize {
        if self.layout.blocks == 1 { 0 } else { n }
    }

    /// Centre and width of each set of each input.
    #[cfg(feature = "std")]
    pub(crate) fn reaches(&self) -> impl Iterator<Item = Vec<(f64, f64)>> {
        self.axes.reaches(self.numbers.as_slice())
    }

    /// An upper bound of |ξ| in a block: a firing strength is at most 1, normalised ones sum to 1
    /// an input.
    pub(crate) fn xi_bound(&self) -> f64 {
        sqrt(self.block_rules() as f64)
    }

    /// Length of a weight row in the order of an evaluated block.
    pub(crate) fn row_len(&self) -> usize {
        self.layout.dyads.iter().map(Dyad::len).sum()
    }

    /// Where a packed weight row has the weights of the rules.
    pub(crate) fn places(&self) -> impl Iterator<Item = usize> {
        self.layout.places()
    }

    /// FNV-1a of all that ξ depends on.
    pub(crate) fn fingerprint(&self) -> u64 {
        let form = match self.form {
            Form::Grid => 0,
            Form::Shared => 1,
            Form::Concat => 2,
            Form::PerJoint { joints } => 3 + joints,
        };
        self.axes.fingerprint(self.numbers.as_slice(), fnv_of(FNV_START, [form as f64]))
    }

    /// Adds a packed weight row to one of [`block_rules`](Self::block_rules) entries.
    pub(crate) fn add_unpacked(&self, packed: &[f64], row: &mut [f64]) {
        self.layout.places().zip(row).for_each(|(place, w)| *w += packed[place]);
    }

    /// Length of an evaluated basis, a whole number of lanes.
    #[inline]
    pub(crate) fn activation_len(&self) -> usize {
        self.layout.total
    }

    /// Length of the scratch memory of [`activate`](Self::activate).
    pub(crate) fn scratch_len(&self) -> usize {
        self.layout.stride.max(self.layout.outer.next_multiple_of(LANES)) + LANES
    }

    /// Block `block` of an evaluated basis.
    #[inline]
    pub(crate) fn block<'a>(&self, activation: &'a [f64], block: usize) -> &'a [f64] {
        let size = self.layout.block;
        &activation[block * size..(block + 1) * size]
    }

    /// Where a block has the factors of its products, in the order of a weight row.
    #[inline]
    pub(crate) fn dyads(&self) -> &Dyads {
        &self.layout.dyads
    }

    /// u of a block, and v with its padding of zeros to whole lanes.
    #[inline]
    fn split<'a>(&self, block: &'a [f64]) -> (&'a [f64], &'a [f64]) {
        let (v, u) = block.split_at(self.layout.stride + LANES);
        (&u[..self.layout.outer], &v[..self.layout.stride])
    }

    /// ξ·ξ' of two evaluated bases for every entry of `out`, which has a block of its own or shares
    /// the only one: for a product, one sum over the sets of each input.
    #[inline(always)]
    pub(crate) fn dots<S: Simd>(&self, simd: S, left: &[f64], right: &[f64], out: &mut [f64]) {
        let Layout { blocks, memberships, .. } = self.layout;
        let tables = (&left[memberships..], &right[memberships..]);
        if blocks > 1 {
            out.fill(1.0);
            self.axes.products(simd, tables, |input, sum| {
                let product = &mut out[input % blocks];
                *product = unless_tiny(*product * sum, TINY_KERNEL);
            });
            return;
        }
        let mut product = 1.0;
        if self.form.is_product() {
            self.axes.products(simd, tables, |_, sum| {
                product = unless_rarely_tiny(product * sum, TINY_KERNEL);
            });
        } else {
            product = dot(simd, self.split(left).1, self.split(right).1);
        }
        out.fill(product);
    }

    /// Evaluates all blocks at a finite x.
    #[inline(always)]
    pub(crate) fn activate<S: Simd>(
        &self,
        simd: S,
        x: &[f64],
        scratch: &mut [f64],
        activation: &mut [f64],
    ) {
        let Layout { blocks, leading, stride, block: size, memberships, .. } = self.layout;
        let (products, memberships) = activation.split_at_mut(memberships);
        if !self.form.is_product() {
            products[stride + LANES] = 1.0;
            return match self.form {
                Form::Shared => self.activate_shared(x, products),
                _ => self.activate_concat(simd, x, memberships, products),
            };
        }
        self.axes.memberships(simd, self.numbers.as_slice(), x, memberships);
        for block in 0..blocks {
            let (leading, trailing) = self.factors(block).split_at(leading);
            let place = &mut products[block * size..(block + 1) * size];
            let (v, u) = place.split_at_mut(stride + LANES);
            kronecker(simd, memberships, leading, u, scratch);
            kronecker(simd, memberships, trailing, v, scratch);
        }
    }

    /// The sets of the inputs of a block.
    #[inline]
    fn factors(&self, block: usize) -> &[Column] {
        &self.factors[block * self.layout.inputs..(block + 1) * self.layout.inputs]
    }

    fn activate_shared(&self, x: &[f64], activation: &mut [f64]) {
        let rules = self.layout.inner;
        let out = &mut activation[..rules];
        out.fill(0.0);
        self.axes.add_exponents(self.numbers.as_slice(), x, out);
        exponentials((out, 1), self.normalized());
    }

    #[inline(always)]
    fn activate_concat<S: Simd>(
        &self,
        simd: S,
        x: &[f64],
        memberships: &mut [f64],
        out: &mut [f64],
    ) {
        self.axes.memberships(simd, self.numbers.as_slice(), x, memberships);
        let all = self.axes.columns().iter().flat_map(|column| column.of(memberships));
        out.iter_mut().zip(all).for_each(|(y, p)| *y = *p);
    }
}

/// Evaluates a basis at a finite x.
pub(crate) struct Activate<'a, B: Buffer> {
    pub basis: &'a FuzzyBasis<B>,
    pub x: &'a [f64],
    pub scratch: &'a mut [f64],
    pub activation: &'a mut [f64],
}

impl<B: Buffer> WithSimd for Activate<'_, B> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.basis.activate(simd, self.x, self.scratch, self.activation);
    }
}

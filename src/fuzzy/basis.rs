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
//! with pᵢ the memberships of input i. A product grid is never written out: ξ = u ⊗ v with u over the leading
//! and v over the trailing inputs, so that ξ(x)·ξ(y) = (u·u')(v·v'), and W ξ takes one pass over W.

use super::kernels::{LANES, dot};
use super::membership::{Lattice, Set, exponentials, memberships};
use crate::error::{Error, Result, finite, within};
use crate::math::sqrt;

/// Most inputs of a basis: seven signals of eight joints fit.
pub const MAX_INPUTS: usize = 64;

/// Most sets of a basis, over all its inputs.
pub const MAX_SETS: usize = 512;

/// Most rules of a basis.
pub const MAX_RULES: usize = 1 << 20;

/// The trailing factor v of ξ = u ⊗ v is at most this long: it stays in the first-level cache.
const MAX_INNER: usize = 256;

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

/// The Gaussian sets of one input.
#[derive(Clone, Copy, Debug)]
pub struct Axis<'a> {
    /// Centres, in the unit of the (scaled) input.
    pub centers: &'a [f64],
    /// Standard deviations σ: one for all sets, or one a set.
    pub widths: &'a [f64],
}

/// A fuzzy basis over a fixed number of inputs. Immutable; the caller owns the buffers it writes to.
#[derive(Clone, Debug)]
pub struct FuzzyBasis {
    form: Form,
    normalized: bool,
    inputs: usize,
    axes: [AxisRecord; MAX_INPUTS],
    sets: [Set; MAX_SETS],
    set_count: usize,
    layout: Layout,
}

/// Sizes of the factors of ξ = u ⊗ v.
#[derive(Clone, Copy, Debug)]
struct Layout {
    /// Independent vectors ξ: one, or one a joint.
    blocks: usize,
    /// Inputs of a block that make up u.
    leading: usize,
    /// Length of u.
    outer: usize,
    /// Length of v.
    inner: usize,
    /// Length of v with its padding to whole lanes.
    stride: usize,
}

#[derive(Clone, Copy, Debug)]
struct AxisRecord {
    first: usize,
    sets: usize,
    lattice: Option<Lattice>,
}

/// One evaluated block of ξ = u ⊗ v; v is padded with zeros to whole lanes.
#[derive(Clone, Copy)]
pub(crate) struct Activation<'a> {
    pub u: &'a [f64],
    pub v: &'a [f64],
}

impl Activation<'_> {
    /// ξ·ξ'.
    #[inline]
    pub fn dot(&self, other: &Activation<'_>) -> f64 {
        dot(self.u, other.u) * dot(self.v, other.v)
    }
}

impl FuzzyBasis {
    /// A basis over `axes.len()` inputs.
    ///
    /// # Errors
    /// `centers`, `width`: not finite, empty, of unequal length, or a width outside 1e-9 … 1e9. `inputs`, `sets`,
    /// `rules`: more than [`MAX_INPUTS`], [`MAX_SETS`], [`MAX_RULES`]; nothing is allocated before that is known.
    pub fn new(form: Form, normalized: bool, axes: &[Axis<'_>]) -> Result<Self> {
        at_most("inputs", axes.len(), MAX_INPUTS)?;
        if axes.is_empty() {
            return Err(Error::WrongLength { parameter: "inputs", got: 0, wanted: 1 });
        }
        let mut records = [AxisRecord { first: 0, sets: 0, lattice: None }; MAX_INPUTS];
        let mut sets = [Set::NONE; MAX_SETS];
        let mut set_count = 0;
        for (axis, record) in axes.iter().zip(&mut records) {
            check_axis(axis)?;
            *record = AxisRecord { first: set_count, sets: axis.centers.len(), lattice: None };
            at_most("sets", set_count.saturating_add(record.sets), MAX_SETS)?;
            let own = &mut sets[set_count..set_count + record.sets];
            for (j, (set, &center)) in own.iter_mut().zip(axis.centers).enumerate() {
                *set = Set::new(center, axis.widths[j.min(axis.widths.len() - 1)]);
            }
            record.lattice = Lattice::recognise(own);
            set_count += record.sets;
        }
        let layout = Layout::new(form, &records[..axes.len()])?;
        let inputs = axes.len();
        Ok(Self { form, normalized, inputs, axes: records, sets, set_count, layout })
    }

    /// How the sets combine.
    pub fn form(&self) -> Form {
        self.form
    }

    /// Whether ξ is normalised (fuzzy basis functions) or raw (firing strengths).
    pub fn normalized(&self) -> bool {
        self.normalized
    }

    /// Number of inputs, the length of x.
    pub fn inputs(&self) -> usize {
        self.inputs
    }

    /// Number of rules, the length of ξ (for a basis per joint: of all joints' together).
    pub fn rules(&self) -> usize {
        self.layout.blocks * self.block_rules()
    }

    /// Length of the `work` buffer of [`evaluate`](Self::evaluate).
    pub fn work_len(&self) -> usize {
        self.activation_len() + self.set_count
    }

    /// Writes ξ(x). First input slowest, so that a grid reshapes to (sets₁, sets₂, …).
    ///
    /// # Errors
    /// `x`: wrong length or not finite. `work`, `xi`: wrong length.
    pub fn evaluate(&self, x: &[f64], work: &mut [f64], xi: &mut [f64]) -> Result<()> {
        length("x", x.len(), self.inputs)?;
        length("work", work.len(), self.work_len())?;
        length("xi", xi.len(), self.rules())?;
        finite("x", x)?;
        let (activation, scratch) = work.split_at_mut(self.activation_len());
        self.activate(x, scratch, activation);
        for (block, out) in xi.chunks_exact_mut(self.block_rules()).enumerate() {
            let Activation { u, v } = self.block(activation, block);
            for (row, a) in out.chunks_exact_mut(self.layout.inner).zip(u) {
                row.iter_mut().zip(v).for_each(|(y, b)| *y = a * b);
            }
        }
        Ok(())
    }

    /// Rules of one block.
    pub(crate) fn block_rules(&self) -> usize {
        self.layout.outer * self.layout.inner
    }

    /// Number of independent vectors ξ.
    pub(crate) fn blocks(&self) -> usize {
        self.layout.blocks
    }

    /// An upper bound of |ξ| in a block: a firing strength is at most 1, normalised ones sum to 1 an input.
    pub(crate) fn xi_bound(&self) -> f64 {
        sqrt(self.block_rules() as f64)
    }

    /// Length of a padded weight row.
    pub(crate) fn row_len(&self) -> usize {
        self.layout.outer * self.layout.stride
    }

    /// Writes a weight row of [`block_rules`](Self::block_rules) entries into its padded place.
    pub(crate) fn pack(&self, row: &[f64], padded: &mut [f64]) {
        let Layout { inner, stride, .. } = self.layout;
        for (from, to) in row.chunks_exact(inner).zip(padded.chunks_exact_mut(stride)) {
            to[..inner].copy_from_slice(from);
        }
    }

    /// Adds a padded weight row to one of [`block_rules`](Self::block_rules) entries.
    pub(crate) fn add_unpacked(&self, padded: &[f64], row: &mut [f64]) {
        let Layout { inner, stride, .. } = self.layout;
        for (from, to) in padded.chunks_exact(stride).zip(row.chunks_exact_mut(inner)) {
            to.iter_mut().zip(from).for_each(|(w, x)| *w += x);
        }
    }

    /// Length of an evaluated basis, all blocks.
    pub(crate) fn activation_len(&self) -> usize {
        self.layout.blocks * (self.layout.outer + self.layout.stride)
    }

    /// Length of the scratch memory of [`activate`](Self::activate).
    pub(crate) fn scratch_len(&self) -> usize {
        self.set_count
    }

    /// Block `block` of an evaluated basis.
    #[inline]
    pub(crate) fn block<'a>(&self, activation: &'a [f64], block: usize) -> Activation<'a> {
        let size = self.layout.outer + self.layout.stride;
        let (u, v) = activation[block * size..(block + 1) * size].split_at(self.layout.outer);
        Activation { u, v }
    }

    /// Evaluates all blocks at a finite x.
    pub(crate) fn activate(&self, x: &[f64], scratch: &mut [f64], activation: &mut [f64]) {
        match self.form {
            Form::Shared => self.activate_shared(x, activation),
            Form::Concat => {
                activation[0] = 1.0;
                self.memberships(x, &mut activation[1..1 + self.set_count]);
            }
            Form::Grid | Form::PerJoint { .. } => {
                self.memberships(x, scratch);
                self.activate_grid(scratch, activation);
            }
        }
    }

    fn memberships(&self, x: &[f64], out: &mut [f64]) {
        for (axis, &x) in self.axes[..self.inputs].iter().zip(x) {
            let range = axis.first..axis.first + axis.sets;
            let (sets, out) = (&self.sets[range.clone()], &mut out[range]);
            memberships(sets, axis.lattice.as_ref(), self.normalized, x, out);
        }
    }

    fn activate_grid(&self, memberships: &[f64], activation: &mut [f64]) {
        let Layout { blocks, leading, outer, stride, .. } = self.layout;
        for block in 0..blocks {
            let own = (block..self.inputs).step_by(blocks).map(|i| &self.axes[i]);
            let factors = own.map(|axis| &memberships[axis.first..axis.first + axis.sets]);
            let size = outer + stride;
            let (u, v) = activation[block * size..(block + 1) * size].split_at_mut(outer);
            kronecker(factors.clone().take(leading), u);
            kronecker(factors.skip(leading), v);
        }
    }

    fn activate_shared(&self, x: &[f64], activation: &mut [f64]) {
        let rules = self.layout.inner;
        activation[0] = 1.0;
        let out = &mut activation[1..1 + rules];
        out.fill(0.0);
        for (axis, &x) in self.axes[..self.inputs].iter().zip(x) {
            for (set, y) in self.sets[axis.first..axis.first + rules].iter().zip(out.iter_mut()) {
                *y += set.exponent(x);
            }
        }
        exponentials(out, self.normalized);
    }
}

impl Layout {
    fn new(form: Form, axes: &[AxisRecord]) -> Result<Self> {
        let sets = |axis: &AxisRecord| axis.sets;
        match form {
            Form::Grid => Self::grid(1, axes),
            Form::PerJoint { joints } => {
                if joints == 0 {
                    return Err(Error::WrongLength { parameter: "joints", got: 0, wanted: 1 });
                }
                if !axes.len().is_multiple_of(joints) {
                    let (got, wanted) = (axes.len(), axes.len().next_multiple_of(joints));
                    return Err(Error::WrongLength { parameter: "inputs", got, wanted });
                }
                for (axis, own) in axes.iter().enumerate() {
                    length("centers", own.sets, axes[axis - axis % joints].sets)?;
                }
                Self::grid(joints, axes)
            }
            Form::Shared => {
                for axis in axes {
                    length("centers", axis.sets, axes[0].sets)?;
                }
                Ok(Self::single(axes[0].sets))
            }
            Form::Concat => Ok(Self::single(axes.iter().map(sets).sum())),
        }
    }

    fn single(rules: usize) -> Self {
        let stride = rules.next_multiple_of(LANES);
        Self { blocks: 1, leading: 0, outer: 1, inner: rules, stride }
    }

    fn grid(blocks: usize, axes: &[AxisRecord]) -> Result<Self> {
        let own = || axes.iter().step_by(blocks).map(|axis| axis.sets);
        let rules = own().try_fold(blocks, usize::checked_mul);
        if rules.is_none_or(|rules| rules > MAX_RULES) {
            return Err(Error::TooMany { parameter: "rules", got: rules, limit: MAX_RULES });
        }
        let (mut leading, mut inner) = (axes.len() / blocks, 1);
        while leading > 0 {
            let sets = axes[(leading - 1) * blocks].sets;
            if inner * sets > MAX_INNER && inner > 1 {
                break;
            }
            inner *= sets;
            leading -= 1;
        }
        let outer = own().take(leading).product();
        Ok(Self { blocks, leading, outer, inner, stride: inner.next_multiple_of(LANES) })
    }
}

/// out[..] = ⊗ factors, from the last factor to the first; entries beyond the product are left alone.
#[inline]
fn kronecker<'a>(factors: impl DoubleEndedIterator<Item = &'a [f64]>, out: &mut [f64]) {
    let mut len = 1;
    out[0] = 1.0;
    for factor in factors.rev() {
        let (old, new) = out[..len * factor.len()].split_at_mut(len);
        for (row, p) in new.chunks_exact_mut(len).zip(&factor[1..]) {
            row.iter_mut().zip(&*old).for_each(|(y, x)| *y = p * x);
        }
        old.iter_mut().for_each(|y| *y *= factor[0]);
        len *= factor.len();
    }
}

fn check_axis(axis: &Axis<'_>) -> Result<()> {
    let sets = axis.centers.len();
    if sets == 0 {
        return Err(Error::WrongLength { parameter: "centers", got: 0, wanted: 1 });
    }
    if axis.widths.len() != 1 {
        length("width", axis.widths.len(), sets)?;
    }
    let reasonable = |c: f64| c.abs() <= 1e9;
    within("centers", axis.centers, reasonable, "centres between -1e9 and 1e9")?;
    let usable = |w: f64| (1e-9..=1e9).contains(&w);
    within("width", axis.widths, usable, "widths > 0, between 1e-9 and 1e9")
}

fn at_most(parameter: &'static str, got: usize, limit: usize) -> Result<()> {
    if got > limit { Err(Error::TooMany { parameter, got: Some(got), limit }) } else { Ok(()) }
}

fn length(parameter: &'static str, got: usize, wanted: usize) -> Result<()> {
    if got == wanted { Ok(()) } else { Err(Error::WrongLength { parameter, got, wanted }) }
}

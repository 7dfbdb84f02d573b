//! The inputs of a basis with their Gaussian sets, and the memberships of all inputs at once.
//!
//! Inputs whose sets share a lattice stand side by side in the lanes of a register; the others go one by one.

use pulp::Simd;

use super::basis::{MAX_INPUTS, MAX_SETS, length};
use super::kernels::Span;
use super::lattice::{self, Lattice};
use super::membership::Sets;
use crate::error::{Error, Result, within};

/// Groups of inputs that are evaluated side by side at the most.
const MAX_LATTICES: usize = 8;

/// Length of the scratch memory of [`Axes::memberships`].
pub(super) const SCRATCH_LEN: usize = lattice::SCRATCH_LEN;

/// The Gaussian sets of one input.
#[derive(Clone, Copy, Debug)]
pub struct Axis<'a> {
    /// Centres, in the unit of the (scaled) input.
    pub centers: &'a [f64],
    /// Standard deviations σ: one for all sets, or one a set.
    pub widths: &'a [f64],
}

/// All inputs of a basis.
#[derive(Clone, Debug)]
pub(super) struct Axes {
    normalized: bool,
    inputs: usize,
    axes: [AxisRecord; MAX_INPUTS],
    sets: Sets,
    lattices: [Lattice; MAX_LATTICES],
    /// Inputs that are in none of them.
    off_lattice: [usize; MAX_INPUTS],
    off_lattice_count: usize,
    /// Length of all memberships.
    len: usize,
}

#[derive(Clone, Copy, Debug)]
struct AxisRecord {
    /// Its sets.
    span: Span,
    /// Start of its memberships.
    out: usize,
}

impl AxisRecord {
    const NONE: Self = Self { span: Span::EMPTY, out: 0 };
}

impl Axes {
    /// `axes.len()` inputs; the memberships of each take a multiple of `unit` places.
    ///
    /// # Errors
    /// `centers`, `width`: not finite, empty, of unequal length, or a width outside 1e-9 … 1e9. `inputs`, `sets`: more
    /// than [`MAX_INPUTS`], [`MAX_SETS`].
    pub fn new(normalized: bool, axes: &[Axis<'_>], unit: usize) -> Result<Self> {
        at_most("inputs", axes.len(), MAX_INPUTS)?;
        if axes.is_empty() {
            return Err(Error::WrongLength { parameter: "inputs", got: 0, wanted: 1 });
        }
        let mut records = [AxisRecord::NONE; MAX_INPUTS];
        let (mut sets, mut lattices) = (Sets::NONE, [Lattice::EMPTY; MAX_LATTICES]);
        let (mut off_lattice, mut off_lattice_count) = ([0; MAX_INPUTS], 0);
        let (mut set_count, mut len) = (0, 0);
        for (input, (axis, record)) in axes.iter().zip(&mut records).enumerate() {
            check_axis(axis)?;
            record.span = Span { first: set_count, len: axis.centers.len() };
            at_most("sets", set_count.saturating_add(record.span.len), MAX_SETS)?;
            sets.write(record.span, axis.centers, axis.widths);
            record.out = len;
            if !lattices.iter_mut().any(|it| it.take(input, len, axis.centers, axis.widths)) {
                off_lattice[off_lattice_count] = input;
                off_lattice_count += 1;
            }
            len += record.span.len.next_multiple_of(unit);
            set_count += record.span.len;
        }
        let (inputs, axes) = (axes.len(), records);
        Ok(Self { normalized, inputs, axes, sets, lattices, off_lattice, off_lattice_count, len })
    }

    /// Whether the memberships of an input are normalised to sum 1.
    pub fn normalized(&self) -> bool {
        self.normalized
    }

    /// Number of inputs, the length of x.
    pub fn inputs(&self) -> usize {
        self.inputs
    }

    /// Length of all memberships.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Where the memberships of each input stand.
    #[inline]
    pub fn spans(&self) -> impl Iterator<Item = Span> + '_ {
        let records = self.axes[..self.inputs].iter();
        records.map(|axis| Span { first: axis.out, len: axis.span.len })
    }

    /// Writes the memberships of a finite x.
    #[inline(always)]
    pub fn memberships<S: Simd>(&self, simd: S, x: &[f64], scratch: &mut [f64], out: &mut [f64]) {
        for lattice in self.lattices.iter().take_while(|it| !it.is_empty()) {
            if !lattice.memberships(simd, x, self.normalized, scratch, out) {
                lattice.beyond(x).for_each(|input| self.general_memberships(input, x, out));
            }
        }
        for &input in &self.off_lattice[..self.off_lattice_count] {
            self.general_memberships(input, x, out);
        }
    }

    fn general_memberships(&self, input: usize, x: &[f64], out: &mut [f64]) {
        let axis = &self.axes[input];
        let out = Span { first: axis.out, len: axis.span.len }.of_mut(out);
        self.sets.memberships(axis.span, self.normalized, x[input], out);
    }

    /// Adds the exponents of every input's sets to `out`, set by set.
    pub fn add_exponents(&self, x: &[f64], out: &mut [f64]) {
        for (axis, &x) in self.axes[..self.inputs].iter().zip(x) {
            self.sets.add_exponents(axis.span, x, out);
        }
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

//! The inputs of a basis with their Gaussian sets, and the memberships of all inputs at once.
//!
//! Memberships stand in tables of [`LANES`] columns, an input a column and a set a row. Inputs
//! whose sets share a lattice share a table, which is filled a register at a time; the others go
//! one by one.

use pulp::Simd;

use super::form::{MAX_INPUTS, MAX_SETS};
use super::kronecker::Column;
use super::lanes::dot_lanes;
use super::lattice::Lattice;
use super::membership::Sets;
use super::places::Span;
use crate::error::{Result, at_most, length, not_empty, within};
use crate::math::{LANES, Line, fnv_of};

/// Tables of inputs that are evaluated side by side at the most.
const MAX_LATTICES: usize = 8;

/// Tables at the most.
const MAX_TABLES: usize = MAX_LATTICES + MAX_INPUTS / LANES;

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
    /// The sets of each input, and where its memberships stand.
    spans: [Span; MAX_INPUTS],
    columns: [Column; MAX_INPUTS],
    sets: Sets,
    lattices: [Lattice; MAX_LATTICES],
    /// Those of the lattices, in their order, then those of the other inputs.
    tables: [Table; MAX_TABLES],
    lattice_count: usize,
    table_count: usize,
    /// Length of all tables.
    len: usize,
}

/// Inputs side by side, one a lane.
#[derive(Clone, Copy, Debug)]
struct Table {
    inputs: [usize; LANES],
    used: usize,
    /// Its memory, a row of lanes a set.
    span: Span,
}

impl Table {
    const EMPTY: Self = Self { inputs: [0; LANES], used: 0, span: Span::EMPTY };

    #[inline]
    fn inputs(&self) -> &[usize] {
        &self.inputs[..self.used]
    }

    /// Puts an input into the next lane.
    fn take(&mut self, input: usize) {
        self.inputs[self.used] = input;
        self.used += 1;
    }
}

impl Axes {
    /// `axes.len()` inputs.
    ///
    /// # Errors
    /// `centers`, `width`: not finite, empty, of unequal length, or a width outside 1e-9 … 1e9.
    /// `inputs`, `sets`: more than [`MAX_INPUTS`], [`MAX_SETS`].
    pub fn new(normalized: bool, axes: &[Axis<'_>]) -> Result<Self> {
        at_most("inputs", axes.len(), MAX_INPUTS)?;
        not_empty("inputs", axes.len())?;
        let mut new = Self {
            normalized,
            inputs: axes.len(),
            spans: [Span::EMPTY; MAX_INPUTS],
            columns: [Column::EMPTY; MAX_INPUTS],
            sets: Sets::NONE,
            lattices: [Lattice::EMPTY; MAX_LATTICES],
            tables: [Table::EMPTY; MAX_TABLES],
            lattice_count: 0,
            table_count: 0,
            len: 0,
        };
        let mut set_count = 0;
        let (mut loose, mut loose_count) = ([0; MAX_INPUTS], 0);
        for (input, axis) in axes.iter().enumerate() {
            check_axis(axis)?;
            let span = Span { first: set_count, len: axis.centers.len() };
            set_count = set_count.saturating_add(span.len);
            at_most("sets", set_count, MAX_SETS)?;
            new.spans[input] = span;
            new.sets.write(span, axis.centers, axis.widths);
            let takes = |it: &mut Lattice| it.take(axis.centers, axis.widths);
            match new.lattices.iter_mut().position(takes) {
                Some(lattice) => new.tables[lattice].take(input),
                None => {
                    loose[loose_count] = input;
                    loose_count += 1;
                }
            }
        }
        new.lattice_count = new.tables.iter().take_while(|table| table.used > 0).count();
        for (place, &input) in loose[..loose_count].iter().enumerate() {
            new.tables[new.lattice_count + place / LANES].take(input);
        }
        new.lay_out();
        Ok(new)
    }

    /// Gives every table its memory and every input its column.
    fn lay_out(&mut self) {
        for table in self.tables.iter_mut().take_while(|table| table.used > 0) {
            let rows = table.inputs().iter().map(|&input| self.spans[input].len).max().unwrap_or(0);
            table.span = Span { first: self.len, len: rows * LANES };
            for (lane, &input) in table.inputs().iter().enumerate() {
                self.columns[input] = Column { first: self.len + lane, len: self.spans[input].len };
            }
            self.len += rows * LANES;
            self.table_count += 1;
        }
    }

    /// Whether the memberships of an input are normalised to sum 1.
    pub fn normalized(&self) -> bool {
        self.normalized
    }

    /// Number of inputs, the length of x.
    pub fn inputs(&self) -> usize {
        self.inputs
    }

    /// The smallest and the largest centre of each input, and its largest width.
    #[cfg(feature = "std")]
    pub fn reaches(&self) -> impl Iterator<Item = (f64, f64, f64)> {
        self.spans[..self.inputs].iter().map(|span| self.sets.reach(*span))
    }

    /// Number of sets of all inputs.
    pub fn sets(&self) -> usize {
        self.columns().iter().map(|column| column.len).sum()
    }

    /// Length of all tables of memberships, a whole number of lanes.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Where the memberships of each input stand.
    #[inline]
    pub fn columns(&self) -> &[Column] {
        &self.columns[..self.inputs]
    }

    /// FNV-1a of the sets of all inputs, from `start` on.
    pub fn fingerprint(&self, start: u64) -> u64 {
        let start = fnv_of(start, [f64::from(u8::from(self.normalized))]);
        self.spans[..self.inputs]
            .iter()
            .fold(start, |hash, span| self.sets.fingerprint(hash, *span))
    }

    /// Writes the memberships of a finite x.
    #[inline(always)]
    pub fn memberships<S: Simd>(&self, simd: S, x: &[f64], out: &mut [f64]) {
        let (on_lattices, loose) = self.tables[..self.table_count].split_at(self.lattice_count);
        for (lattice, table) in self.lattices.iter().zip(on_lattices) {
            let rows = table.span.of_mut(out);
            let beyond = lattice.memberships(simd, x, table.inputs(), self.normalized, rows);
            if beyond != 0 {
                self.one_by_one(table, beyond, x, out);
            }
        }
        for table in loose {
            table.span.of_mut(out).fill(0.0);
            self.one_by_one(table, u8::MAX, x, out);
        }
    }

    /// Writes the memberships of the inputs of a table in these lanes, bit by bit.
    #[cold]
    fn one_by_one(&self, table: &Table, lanes: u8, x: &[f64], out: &mut [f64]) {
        for (lane, &input) in table.inputs().iter().enumerate() {
            if lanes >> lane & 1 != 0 {
                let column = self.columns[input].span().of_mut(out);
                self.sets.memberships(
                    self.spans[input],
                    self.normalized,
                    x[input],
                    (column, LANES),
                );
            }
        }
    }

    /// Tells `visit` every input and p·p', the product of its memberships in two evaluations.
    #[inline(always)]
    pub fn products<S: Simd>(
        &self,
        simd: S,
        (left, right): (&[f64], &[f64]),
        mut visit: impl FnMut(usize, f64),
    ) {
        for table in &self.tables[..self.table_count] {
            let Line(sums) = dot_lanes(simd, table.span.of(left), table.span.of(right));
            table.inputs().iter().zip(sums).for_each(|(&input, sum)| visit(input, sum));
        }
    }

    /// Adds the exponents of every input's sets to `out`, set by set.
    pub fn add_exponents(&self, x: &[f64], out: &mut [f64]) {
        for (span, &x) in self.spans[..self.inputs].iter().zip(x) {
            self.sets.add_exponents(*span, x, (out, 1));
        }
    }
}

fn check_axis(axis: &Axis<'_>) -> Result<()> {
    let sets = axis.centers.len();
    not_empty("centers", sets)?;
    if axis.widths.len() != 1 {
        length("width", axis.widths.len(), sets)?;
    }
    let reasonable = |c: f64| c.abs() <= 1e9;
    within("centers", axis.centers, reasonable, "centres between -1e9 and 1e9")?;
    let usable = |w: f64| (1e-9..=1e9).contains(&w);
    within("width", axis.widths, usable, "widths > 0, between 1e-9 and 1e9")
}

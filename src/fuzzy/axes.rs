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
use super::lattice::Spaced;
use super::membership::Sets;
use super::places::Span;
use crate::error::{Result, at_most, length, not_empty, within};
use crate::math::{LANES, Line, fnv_of};

/// Tables of inputs that are evaluated side by side at the most.
const MAX_LATTICES: usize = 8;

/// Tables at the most.
const MAX_TABLES: usize = MAX_LATTICES + MAX_INPUTS / LANES;

/// The Gaussian sets of one input.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis<'a> {
    /// Centres, in the unit of the (scaled) input.
    pub centers: &'a [f64],
    /// Standard deviations σ: one for all sets, or one a set.
    pub widths: &'a [f64],
}

/// All inputs of a basis. Their numbers stand in memory, those of the lattices first, then the
/// sets; inputs with the same sets share them.
#[derive(Clone, Debug)]
pub(super) struct Axes {
    normalized: bool,
    inputs: usize,
    /// Where the numbers of the sets of each input begin, and where its memberships stand.
    sets: [u16; MAX_INPUTS],
    columns: [Column; MAX_INPUTS],
    lattices: [Lattice; MAX_LATTICES],
    /// Those of the lattices, in their order, then those of the other inputs.
    tables: [Table; MAX_TABLES],
    lattice_count: usize,
    table_count: usize,
    /// Length of all tables.
    len: usize,
    /// How many numbers there are.
    numbers: usize,
}

/// Inputs side by side, one a lane.
#[derive(Clone, Copy, Debug)]
struct Table {
    inputs: [u8; LANES],
    used: u8,
    /// Its memory, so many rows of lanes, one a set.
    first: u16,
    rows: u16,
}

impl Table {
    const EMPTY: Self = Self { inputs: [0; LANES], used: 0, first: 0, rows: 0 };

    #[inline]
    fn inputs(&self) -> &[u8] {
        &self.inputs[..self.used.into()]
    }

    #[inline]
    fn span(&self) -> Span {
        Span { first: self.first.into(), len: usize::from(self.rows) * LANES }
    }

    /// Puts an input into the next lane.
    fn take(&mut self, input: usize) {
        self.inputs[usize::from(self.used)] = input as u8;
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
            sets: [0; MAX_INPUTS],
            columns: [Column::EMPTY; MAX_INPUTS],
            lattices: [Lattice::EMPTY; MAX_LATTICES],
            tables: [Table::EMPTY; MAX_TABLES],
            lattice_count: 0,
            table_count: 0,
            len: 0,
            numbers: 0,
        };
        let mut set_count: usize = 0;
        let (mut loose, mut loose_count) = ([0; MAX_INPUTS], 0);
        for (input, axis) in axes.iter().enumerate() {
            check_axis(axis)?;
            set_count = set_count.saturating_add(axis.centers.len());
            at_most("sets", set_count, MAX_SETS)?;
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
        new.lay_out(axes);
        Ok(new)
    }

    /// Gives every table its memory, every input its column, and all numbers their places.
    fn lay_out(&mut self, axes: &[Axis<'_>]) {
        let sets = |input: u8| axes[usize::from(input)].centers.len();
        for table in self.tables.iter_mut().take_while(|table| table.used > 0) {
            let rows = table.inputs().iter().map(|&input| sets(input)).max().unwrap_or(0);
            (table.first, table.rows) = (self.len as u16, rows as u16);
            for (lane, &input) in table.inputs().iter().enumerate() {
                self.columns[usize::from(input)] = Column::new(self.len + lane, sets(input));
            }
            self.len += rows * LANES;
            self.table_count += 1;
        }
        self.numbers = self.lattices[..self.lattice_count].iter().map(Lattice::numbers).sum();
        for (input, axis) in axes.iter().enumerate() {
            self.sets[input] = match axes[..input].iter().position(|other| other == axis) {
                Some(other) => self.sets[other],
                None => {
                    self.numbers += 2 * axis.centers.len();
                    (self.numbers - 2 * axis.centers.len()) as u16
                }
            };
        }
    }

    /// How many numbers it has.
    pub fn numbers(&self) -> usize {
        self.numbers
    }

    /// Writes the numbers of these axes, from which it was made.
    pub fn write(&self, axes: &[Axis<'_>], numbers: &mut [f64]) {
        let mut rest = &mut *numbers;
        for (lattice, table) in self.lattices[..self.lattice_count].iter().zip(&self.tables) {
            let (own, others) = rest.split_at_mut(lattice.numbers());
            Lattice::clear(own);
            for (lane, &input) in table.inputs().iter().enumerate() {
                let Axis { centers, widths } = axes[usize::from(input)];
                Lattice::write(lane, centers, widths, own);
            }
            rest = others;
        }
        for (input, axis) in axes.iter().enumerate() {
            Sets::write(axis.centers, axis.widths, self.place(input).of_mut(numbers));
        }
    }

    /// Where the numbers of the sets of an input stand.
    #[inline]
    fn place(&self, input: usize) -> Span {
        Span { first: self.sets[input].into(), len: 2 * self.columns[input].len() }
    }

    #[inline]
    fn sets_of<'a>(&self, numbers: &'a [f64], input: usize) -> Sets<'a> {
        Sets::of(self.place(input).of(numbers))
    }

    /// The sets of an input, if they are on a lattice.
    pub fn spaced(&self, numbers: &[f64], input: usize) -> Option<Spaced> {
        let mut rest = numbers;
        for (lattice, table) in self.lattices[..self.lattice_count].iter().zip(&self.tables) {
            let (own, others) = rest.split_at(lattice.numbers());
            let lane = table.inputs().iter().position(|&it| usize::from(it) == input);
            if let Some(lane) = lane {
                return Some(lattice.spaced(own, lane));
            }
            rest = others;
        }
        None
    }

    /// Whether the memberships of an input are normalised to sum 1.
    pub fn normalized(&self) -> bool {
        self.normalized
    }

    /// Number of inputs, the length of x.
    pub fn inputs(&self) -> usize {
        self.inputs
    }

    /// Centre and width of each set of each input.
    #[cfg(feature = "std")]
    pub fn reaches(&self, numbers: &[f64]) -> impl Iterator<Item = Vec<(f64, f64)>> {
        (0..self.inputs).map(|input| self.sets_of(numbers, input).reach())
    }

    /// Number of sets of all inputs.
    pub fn sets(&self) -> usize {
        self.columns().iter().map(Column::len).sum()
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
    pub fn fingerprint(&self, numbers: &[f64], start: u64) -> u64 {
        let start = fnv_of(start, [f64::from(u8::from(self.normalized))]);
        let inputs = 0..self.inputs;
        inputs.fold(start, |hash, input| self.sets_of(numbers, input).fingerprint(hash))
    }

    /// Writes the memberships of a finite x.
    #[inline(always)]
    pub fn memberships<S: Simd>(&self, simd: S, numbers: &[f64], x: &[f64], out: &mut [f64]) {
        let (on_lattices, loose) = self.tables[..self.table_count].split_at(self.lattice_count);
        let mut rest = numbers;
        for (lattice, table) in self.lattices.iter().zip(on_lattices) {
            let (own, others) = rest.split_at(lattice.numbers());
            let (rows, inputs) = (table.span().of_mut(out), table.inputs());
            let beyond = lattice.memberships(simd, own, (x, inputs), self.normalized, rows);
            if beyond != 0 {
                self.one_by_one(numbers, table, beyond, x, out);
            }
            rest = others;
        }
        for table in loose {
            table.span().of_mut(out).fill(0.0);
            self.one_by_one(numbers, table, u8::MAX, x, out);
        }
    }

    /// Writes the memberships of the inputs of a table in these lanes, bit by bit.
    #[cold]
    fn one_by_one(&self, numbers: &[f64], table: &Table, lanes: u8, x: &[f64], out: &mut [f64]) {
        for (lane, &input) in table.inputs().iter().enumerate() {
            if lanes >> lane & 1 != 0 {
                let input = usize::from(input);
                let column = self.columns[input].span().of_mut(out);
                let sets = self.sets_of(numbers, input);
                sets.memberships(self.normalized, x[input], (column, LANES));
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
            let Line(sums) = dot_lanes(simd, table.span().of(left), table.span().of(right));
            table.inputs().iter().zip(sums).for_each(|(&input, sum)| visit(input.into(), sum));
        }
    }

    /// Adds the exponents of every input's sets to `out`, set by set.
    pub fn add_exponents(&self, numbers: &[f64], x: &[f64], out: &mut [f64]) {
        for (input, &x) in x[..self.inputs].iter().enumerate() {
            self.sets_of(numbers, input).add_exponents(x, (out, 1));
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

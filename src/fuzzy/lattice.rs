//! Gaussian sets of equal width whose centres lie on a lattice: one exponential for all sets of an
//! input, and the inputs side by side, one a lane.
//!
//! With p the first centre, c = p + k d and σ the width,
//!
//! ```text
//! μ_c(x) = μ_p(x) · exp(−(k d)²/2σ²) · tᵏ,   t = exp(d (x − p)/σ²)
//! ```
//!
//! where the middle factor is a constant of the set, and μ_p(x) cancels on normalising.

use pulp::Simd;

use crate::math::{LANES, Line, Real, TINY_MEMBERSHIP, exp, exponential, lanes_unless_tiny, sqrt};

/// Centres count as evenly stepped when they are this close to a common lattice, in steps.
const LATTICE_TOL: f64 = 1e-12;

/// Lattice steps from the first centre to the last at the most, 4 binary digits.
const MAX_STEPS: usize = 15;

/// Sets on a lattice at the most.
const MAX_SETS: usize = MAX_STEPS + 1;

/// Largest exponent on the lattice: e^±600 and their products with the constants are normal floats.
const MAX_EXPONENT: f64 = 600.0;

/// The same in single precision.
const MAX_SINGLE: f64 = 80.0;

/// Lattices span at most this exponent, so that they reach beyond their last centre.
const MAX_SPAN: f64 = 0.25 * MAX_EXPONENT;

type Lanes = [f64; LANES];

/// What inputs must share to stand side by side: the lattice steps k of their sets.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Pattern {
    sets: u8,
    steps: [u8; MAX_SETS],
}

/// Inputs whose sets share a pattern. Their numbers stand in memory, a row of lanes each: p, d/σ²,
/// 1/2σ², the |x − p| up to which the powers of t, and μ_p, are normal floats, and then
/// exp(−(k d)²/2σ²) of each set.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lattice {
    pattern: Pattern,
    /// Lanes in use.
    used: u8,
}

/// Rows of numbers before those of the sets.
const HEAD: usize = 4;

/// Those in the lanes without an input.
const UNUSED: [f64; HEAD] = [0.0, 0.0, 0.0, f64::INFINITY];

impl Lattice {
    pub const EMPTY: Self = Self { pattern: Pattern { sets: 0, steps: [0; MAX_SETS] }, used: 0 };

    /// Takes an input into the next lane; false if there is none, or its sets are on no lattice, or
    /// on another.
    pub fn take(&mut self, centers: &[f64], widths: &[f64]) -> bool {
        let Some((pattern, _)) = Pattern::recognise(centers, widths) else { return false };
        if usize::from(self.used) == LANES || self.used > 0 && self.pattern != pattern {
            return false;
        }
        let span = centers[centers.len() - 1] - centers[0];
        if span * span * half_precision(widths) > MAX_SPAN {
            return false;
        }
        self.pattern = pattern;
        self.used += 1;
        true
    }

    /// How many numbers it has.
    pub fn numbers(&self) -> usize {
        (HEAD + usize::from(self.pattern.sets)) * LANES
    }

    /// Writes the numbers of lanes without an input.
    pub fn clear(numbers: &mut [f64]) {
        let (head, decays) = numbers.split_at_mut(HEAD * LANES);
        head.chunks_exact_mut(LANES).zip(UNUSED).for_each(|(row, x)| row.fill(x));
        decays.fill(1.0);
    }

    /// Writes the numbers of the input in this lane.
    pub fn write(lane: usize, centers: &[f64], widths: &[f64], numbers: &mut [f64]) {
        let Some((_, step)) = Pattern::recognise(centers, widths) else { return };
        let (center, half_precision) = (centers[0], half_precision(widths));
        let span = centers[centers.len() - 1] - center;
        let reach =
            (MAX_EXPONENT / (2.0 * half_precision * span)).min(sqrt(MAX_EXPONENT / half_precision));
        let head = [center, 2.0 * step * half_precision, half_precision, reach];
        let decay = |c: &f64| exp(-(c - center) * (c - center) * half_precision);
        let all = head.into_iter().chain(centers.iter().map(decay));
        numbers.chunks_exact_mut(LANES).zip(all).for_each(|(row, x)| row[lane] = x);
    }

    /// The sets of the input in a lane.
    pub fn spaced(&self, numbers: &[f64], lane: usize) -> Spaced {
        let rows = numbers.as_chunks::<LANES>().0;
        let (mut head, mut decays) = (UNUSED, [1.0; MAX_SETS]);
        let all = head.iter_mut().chain(&mut decays[..self.pattern.sets.into()]);
        all.zip(rows).for_each(|(x, row)| *x = row[lane]);
        Spaced { head, decays, pattern: self.pattern }
    }

    /// Writes the memberships of these `inputs` of x, one a lane, a row of lanes a set. Those
    /// beyond reach, in the lanes of the bits that are set in the result, are to be written again.
    #[inline(always)]
    pub fn memberships<S: Simd>(
        &self,
        simd: S,
        numbers: &[f64],
        (x, inputs): (&[f64], &[u8]),
        normalized: bool,
        rows: &mut [f64],
    ) -> u8 {
        let rows = &mut rows.as_chunks_mut::<LANES>().0[..self.pattern.sets.into()];
        let Some((head, decays)) = numbers.as_chunks::<LANES>().0.split_first_chunk() else {
            return 0;
        };
        let mut within = true;
        for (part, inputs) in inputs.chunks(S::F64_LANES).enumerate() {
            let x = gather(simd, x, inputs);
            within &= self.part(simd, part, x, (head, decays), normalized, rows);
        }
        if within { 0 } else { beyond(head, x, inputs) }
    }

    /// The memberships of the inputs in the lanes of one register; whether all are within reach.
    #[inline(always)]
    fn part<S: Simd>(
        &self,
        simd: S,
        part: usize,
        x: S::f64s,
        ([centers, slopes, half_precisions, reaches], decays): (&[Lanes; HEAD], &[Lanes]),
        normalized: bool,
        rows: &mut [Lanes],
    ) -> bool {
        let lanes = |x: &Lanes| S::as_simd_f64s(x).0[part];
        let offset = simd.sub_f64s(x, lanes(centers));
        let beyond = simd.less_than_f64s(lanes(reaches), simd.abs_f64s(offset));
        let square = |x| simd.mul_f64s(x, x);
        let t = exponential(simd, simd.mul_f64s(lanes(slopes), offset));
        let t2 = square(t);
        let (mut power, mut k) = (simd.splat_f64s(1.0), 0);
        let mut sum = simd.splat_f64s(0.0);
        for (row, (decays, &step)) in rows.iter_mut().zip(decays.iter().zip(&self.pattern.steps)) {
            while k + 2 <= step {
                power = simd.mul_f64s(power, t2);
                k += 2;
            }
            if k < step {
                power = simd.mul_f64s(power, t);
                k += 1;
            }
            let strength = simd.mul_f64s(lanes(decays), power);
            S::as_mut_simd_f64s(row).0[part] = strength;
            sum = simd.add_f64s(sum, strength);
        }
        let scale = if normalized {
            simd.div_f64s(simd.splat_f64s(1.0), sum)
        } else {
            let exponent = simd.mul_f64s(square(offset), lanes(half_precisions));
            exponential(simd, simd.neg_f64s(exponent))
        };
        for row in rows {
            let strength = &mut S::as_mut_simd_f64s(row).0[part];
            let scaled = simd.mul_f64s(*strength, scale);
            *strength = lanes_unless_tiny(simd, scaled, TINY_MEMBERSHIP);
        }
        simd.first_true_m64s(beyond) == S::F64_LANES
    }
}

/// The sets of one input on a lattice, for inputs of several runs side by side, and for one in
/// single precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Spaced<X = f64> {
    /// First centre, slope of the exponent, half precision, reach.
    head: [X; HEAD],
    decays: [X; MAX_SETS],
    pattern: Pattern,
}

/// Sets at the most of one that is [`Spaced`].
pub(crate) const MOST_SPACED: usize = MAX_SETS;

impl Spaced {
    pub const NONE: Self =
        Self { head: UNUSED, decays: [1.0; MAX_SETS], pattern: Lattice::EMPTY.pattern };

    /// The same in single precision, within the reach of that; `None` if the sets are too far apart
    /// for it.
    pub fn single(&self) -> Option<Spaced<f32>> {
        let Self { mut head, decays, pattern } = *self;
        let [_, slope, half_precision, reach] = &mut head;
        let span = *slope * f64::from(pattern.steps[self.len().max(1) - 1]);
        *reach = reach.min(MAX_SINGLE / span).min(sqrt(MAX_SINGLE / *half_precision));
        let spans = -libm::log(decays[self.len().max(1) - 1]);
        let close = 4.0 * spans <= MAX_SINGLE;
        let (head, decays) = (head.map(|x| x as f32), decays.map(|x| x as f32));
        close.then_some(Spaced { head, decays, pattern })
    }
}

impl Spaced<f32> {
    pub const NOTHING: Self =
        Self { head: [0.0; HEAD], decays: [1.0; MAX_SETS], pattern: Lattice::EMPTY.pattern };
}

impl<X: Copy> Spaced<X> {
    /// Number of sets.
    #[inline(always)]
    pub fn len(&self) -> usize {
        self.pattern.sets.into()
    }

    /// The lattice steps k of the sets.
    #[inline(always)]
    pub fn steps(&self) -> &[u8] {
        &self.pattern.steps[..self.len()]
    }

    /// ln t at x, and NaN where x is beyond the reach of the lattice, or 0.
    #[inline(always)]
    pub fn exponent<T: Real<Number = X>>(&self, x: T) -> (T, T) {
        let [center, slope, _, reach] = self.head;
        let offset = x - x.all(center);
        let beyond = x.all(reach).if_less(offset.abs(), x.like(f64::NAN), x.like(0.0));
        (x.all(slope) * offset, beyond)
    }

    /// The place next to x within the reach of the lattice.
    pub fn within<T: Real<Number = X>>(&self, x: T) -> T {
        let [center, _, _, reach] = self.head.map(|number| x.all(number));
        let (low, high) = (center - reach, center + reach);
        x.if_less(low, low, high.if_less(x, high, x))
    }

    /// The memberships in sets of these `steps`, `L` at the most, as [`Lattice::part`] makes them
    /// of one run.
    #[inline(always)]
    pub fn memberships<const L: usize, T: Real<Number = X>>(
        &self,
        (x, t): (T, T),
        steps: &[u8],
        normalized: bool,
    ) -> [T; L] {
        let (t2, mut power, mut sum) = (t * t, x.like(1.0), x.like(0.0));
        let (sets, mut out) = (steps.len().min(L), [sum; L]);
        for set in 0..sets {
            if set > 0 {
                let gap = steps[set] - steps[set - 1];
                for _ in 0..gap / 2 {
                    power = power * t2;
                }
                if gap % 2 == 1 {
                    power = power * t;
                }
            }
            out[set] = x.all(self.decays[set]) * power;
            sum += out[set];
        }
        let scale = if normalized {
            x.like(1.0) / sum
        } else {
            let [center, _, half_precision, _] = self.head;
            let offset = x - x.all(center);
            (-(offset * offset * x.all(half_precision))).series_exp()
        };
        for set in 0..sets {
            out[set] = (out[set] * scale).positive_unless_tiny(TINY_MEMBERSHIP);
        }
        out
    }
}

/// The lanes that are too far out, bit by bit.
#[cold]
fn beyond([centers, .., reaches]: &[Lanes; HEAD], x: &[f64], inputs: &[u8]) -> u8 {
    let far =
        |lane: usize, input: u8| (x[usize::from(input)] - centers[lane]).abs() > reaches[lane];
    let lanes = inputs.iter().enumerate().filter(|&(lane, &input)| far(lane, input));
    lanes.fold(0, |bits, (lane, _)| bits | 1 << lane)
}

/// 1/2σ² of sets of one width.
fn half_precision(widths: &[f64]) -> f64 {
    0.5 / (widths[0] * widths[0])
}

/// These entries of x in the first lanes of a register, 0 in the others. Numbers that are written
/// one by one could not be read soon as a register, so each is put into all lanes and kept in the
/// one that is its own.
#[inline(always)]
fn gather<S: Simd>(simd: S, x: &[f64], inputs: &[u8]) -> S::f64s {
    const NUMBERS: Line = Line([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
    let numbers = S::as_simd_f64s(&NUMBERS.0).0[0];
    let mut gathered = simd.splat_f64s(0.0);
    for (lane, &input) in inputs.iter().enumerate() {
        let before = simd.less_than_f64s(numbers, simd.splat_f64s(NUMBERS.0[lane]));
        gathered = simd.select_f64s(before, gathered, simd.splat_f64s(x[usize::from(input)]));
    }
    let used = simd.less_than_f64s(numbers, simd.splat_f64s(inputs.len() as f64));
    simd.select_f64s(used, gathered, simd.splat_f64s(0.0))
}

impl Pattern {
    /// The pattern of sets on a lattice, and its step d; `None` where there is none.
    fn recognise(centers: &[f64], widths: &[f64]) -> Option<(Self, f64)> {
        let sets = centers.len();
        if sets > MAX_SETS || widths.iter().any(|width| *width != widths[0]) {
            return None;
        }
        let step = smallest_gap(centers)?;
        let mut pattern = Self { sets: sets as u8, steps: [0; MAX_SETS] };
        for (k, center) in pattern.steps.iter_mut().zip(centers) {
            let steps = (center - centers[0]) / step;
            let whole = libm::round(steps);
            if (steps - whole).abs() > LATTICE_TOL || whole > MAX_STEPS as f64 {
                return None;
            }
            *k = whole as u8;
        }
        Some((pattern, step))
    }
}

fn smallest_gap(centers: &[f64]) -> Option<f64> {
    let mut smallest = f64::INFINITY;
    for pair in centers.windows(2) {
        let gap = pair[1] - pair[0];
        if gap <= 0.0 {
            return None;
        }
        smallest = smallest.min(gap);
    }
    smallest.is_finite().then_some(smallest)
}

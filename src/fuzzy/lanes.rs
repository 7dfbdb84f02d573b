//! The inner loops over rules, for whatever vector registers the machine has.
//!
//! Sums run over 8 lanes, however many a register holds; the lanes are added in a fixed order and
//! nothing is fused, so every instruction set gives the same bits.

use pulp::{Simd, WithSimd};

use super::places::{Dyad, Dyads};
use crate::math::{LANES, Line, Runs, Shared, TINY_WEIGHT, lanes_unless_tiny, unless_tiny};

/// Terms that are added side by side.
const BATCH: usize = 5;

/// Runs of lanes that are worked on side by side.
pub(super) const BLOCK: usize = 4;

/// A sum of 8 lanes, in as many registers as they take: the first 8 / `F64_LANES` entries.
#[derive(Clone, Copy)]
struct Sum<S: Simd>([S::f64s; LANES]);

impl<S: Simd> Sum<S> {
    /// Registers that hold 8 lanes.
    const PARTS: usize = LANES / S::F64_LANES;

    #[inline(always)]
    fn zero(simd: S) -> Self {
        Self([simd.splat_f64s(0.0); LANES])
    }

    /// Adds a b to the lanes of register `part`.
    #[inline(always)]
    fn add(&mut self, simd: S, part: usize, a: S::f64s, b: S::f64s) {
        self.0[part] = simd.add_f64s(self.0[part], simd.mul_f64s(a, b));
    }

    /// The lanes.
    #[inline(always)]
    fn lanes(&self) -> Line {
        let mut x = Line([0.0; LANES]);
        S::as_mut_simd_f64s(&mut x.0).0.copy_from_slice(&self.0[..Self::PARTS]);
        x
    }

    /// Adds the lanes in a fixed order.
    #[inline(always)]
    fn total(&self) -> f64 {
        let Line(x) = self.lanes();
        ((x[0] + x[4]) + (x[2] + x[6])) + ((x[1] + x[5]) + (x[3] + x[7]))
    }
}

/// w·ξ for `J` rows of weights w.
#[inline(always)]
pub(crate) fn contract<S: Simd, const J: usize>(
    simd: S,
    mut weights: [&[f64]; J],
    dyads: &Dyads,
    xi: &[f64],
) -> [f64; J] {
    let mut sums = [Sum::zero(simd); J];
    for dyad in dyads {
        let factors = (dyad.u.of(xi), dyad.v.of(xi));
        let mut first = 0;
        while first < dyad.v.len {
            first += match (dyad.v.len - first) / LANES {
                1 => columns::<S, J, 1>(simd, &weights, first, factors, &mut sums),
                2 => columns::<S, J, 2>(simd, &weights, first, factors, &mut sums),
                3 => columns::<S, J, 3>(simd, &weights, first, factors, &mut sums),
                _ if J * Sum::<S>::PARTS > 2 => {
                    // More would not stay in 16 registers.
                    columns::<S, J, 2>(simd, &weights, first, factors, &mut sums)
                }
                _ => columns::<S, J, BLOCK>(simd, &weights, first, factors, &mut sums),
            };
        }
        for row in &mut weights {
            *row = &row[dyad.len()..];
        }
    }
    let mut totals = [0.0; J];
    for (total, sum) in totals.iter_mut().zip(&sums) {
        *total = sum.total();
    }
    totals
}

/// Adds the share of `C` runs of columns from column `first` on, for matrices with the shape of a
/// product: first over the rows, then over the columns. Returns the number of columns.
#[inline(always)]
fn columns<S: Simd, const J: usize, const C: usize>(
    simd: S,
    matrices: &[&[f64]; J],
    first: usize,
    (u, v): (&[f64], &[f64]),
    sums: &mut [Sum<S>; J],
) -> usize {
    let mut rows = [[Sum::zero(simd); C]; J];
    let mut rest = *matrices;
    for u in u {
        let u = simd.splat_f64s(*u);
        for j in 0..J {
            let (row, others) = rest[j].split_at(v.len());
            let w = runs::<S, C>(row, first);
            for c in 0..C {
                for part in 0..Sum::<S>::PARTS {
                    rows[j][c].add(simd, part, u, w[c * Sum::<S>::PARTS + part]);
                }
            }
            rest[j] = others;
        }
    }
    let v = runs::<S, C>(v, first);
    for j in 0..J {
        for c in 0..C {
            for part in 0..Sum::<S>::PARTS {
                sums[j].add(simd, part, rows[j][c].0[part], v[c * Sum::<S>::PARTS + part]);
            }
        }
    }
    C * LANES
}

/// The registers of `C` runs of a row from column `first` on.
#[inline(always)]
fn runs<S: Simd, const C: usize>(row: &[f64], first: usize) -> &[S::f64s] {
    S::as_simd_f64s(&row[first..first + C * LANES]).0
}

/// Where a step keeps less than this of the weights, tiny ones are set to zero at once. Otherwise
/// it is enough once in 256 steps: what was not tiny then is still larger than 1e-140.
pub(crate) const FADES_FAST: f64 = 0.85;

/// w ← keep w + Σ c ξ for equally many c and ξ; returns |w|² of the result.
#[inline(always)]
pub(crate) fn accumulate<S: Simd>(
    simd: S,
    weights: &mut [f64],
    keep: f64,
    dyads: &Dyads,
    coefficients: &[f64],
    terms: &[&[f64]],
) -> f64 {
    if keep != 1.0 {
        let factor = simd.splat_f64s(keep);
        let weights = S::as_mut_simd_f64s(&mut *weights).0;
        let least = if keep < FADES_FAST { TINY_WEIGHT } else { 0.0 };
        // No closure: it would not be compiled for the registers at hand.
        for w in weights {
            *w = lanes_unless_tiny(simd, simd.mul_f64s(factor, *w), least);
        }
    }
    let mut squares = None;
    for (c, xi) in coefficients.chunks(BATCH).zip(terms.chunks(BATCH)) {
        squares = match xi.len() {
            5 => Some(add::<S, 5>(simd, weights, dyads, c, xi)),
            4 => Some(add::<S, 4>(simd, weights, dyads, c, xi)),
            3 => Some(add::<S, 3>(simd, weights, dyads, c, xi)),
            2 => Some(add::<S, 2>(simd, weights, dyads, c, xi)),
            _ => Some(add::<S, 1>(simd, weights, dyads, c, xi)),
        };
    }
    squares.unwrap_or_else(|| dot(simd, weights, weights))
}

/// Adds K terms; returns the squared norm of the result.
#[inline(always)]
fn add<S: Simd, const K: usize>(
    simd: S,
    mut weights: &mut [f64],
    dyads: &Dyads,
    coefficients: &[f64],
    terms: &[&[f64]],
) -> f64 {
    let (Some(c), Some(terms)) = (coefficients.first_chunk(), terms.first_chunk()) else {
        return 0.0;
    };
    let mut squares = Sum::zero(simd);
    for dyad in dyads {
        let (matrix, others) = weights.split_at_mut(dyad.len());
        let mut first = 0;
        while first < dyad.v.len {
            first += match (dyad.v.len - first) / LANES {
                1 => add_columns::<S, K, 1>(simd, matrix, first, dyad, c, terms, &mut squares),
                2 => add_columns::<S, K, 2>(simd, matrix, first, dyad, c, terms, &mut squares),
                3 => add_columns::<S, K, 3>(simd, matrix, first, dyad, c, terms, &mut squares),
                _ => add_columns::<S, K, BLOCK>(simd, matrix, first, dyad, c, terms, &mut squares),
            };
        }
        weights = others;
    }
    squares.total()
}

/// Adds the terms to `C` runs of columns from column `first` on, and the squares of the result to
/// `squares`; returns the number of columns.
#[inline(always)]
fn add_columns<S: Simd, const K: usize, const C: usize>(
    simd: S,
    matrix: &mut [f64],
    first: usize,
    dyad: &Dyad,
    coefficients: &[f64; K],
    terms: &[&[f64]; K],
    squares: &mut Sum<S>,
) -> usize {
    let (mut u, mut v) = ([&[][..]; K], [[[simd.splat_f64s(0.0); LANES]; C]; K]);
    for k in 0..K {
        u[k] = dyad.u.of(terms[k]);
        let c = simd.splat_f64s(coefficients[k]);
        let registers = runs::<S, C>(dyad.v.of(terms[k]), first);
        for run in 0..C {
            for part in 0..Sum::<S>::PARTS {
                v[k][run][part] = simd.mul_f64s(c, registers[run * Sum::<S>::PARTS + part]);
            }
        }
    }
    let mut sums = [Sum::zero(simd); C];
    let mut rest = matrix;
    for a in 0..dyad.u.len {
        let (row, others) = rest.split_at_mut(dyad.v.len);
        let mut scales = [simd.splat_f64s(0.0); K];
        for k in 0..K {
            scales[k] = simd.splat_f64s(u[k][a]);
        }
        let row = S::as_mut_simd_f64s(&mut row[first..first + C * LANES]).0;
        for (c, sum) in sums.iter_mut().enumerate() {
            for part in 0..Sum::<S>::PARTS {
                let i = c * Sum::<S>::PARTS + part;
                let mut w = row[i];
                for k in 0..K {
                    w = simd.add_f64s(w, simd.mul_f64s(scales[k], v[k][c][part]));
                }
                row[i] = w;
                sum.add(simd, part, w, w);
            }
        }
        rest = others;
    }
    for sum in sums {
        for part in 0..Sum::<S>::PARTS {
            squares.0[part] = simd.add_f64s(squares.0[part], sum.0[part]);
        }
    }
    C * LANES
}

/// Tiny weights are looked for once in so many steps.
pub(crate) const FLUSH_EVERY: u64 = 256;

/// Sets tiny weights to zero.
pub(crate) fn flush(weights: &mut [f64]) {
    weights.iter_mut().for_each(|w| *w = unless_tiny(*w, TINY_WEIGHT));
}

/// Σ x_i y_i over whole lanes.
#[inline(always)]
pub(crate) fn dot<S: Simd>(simd: S, left: &[f64], right: &[f64]) -> f64 {
    products(simd, left, right).total()
}

/// The products x_i y_i, added up lane by lane.
#[inline(always)]
fn products<S: Simd>(simd: S, left: &[f64], right: &[f64]) -> Sum<S> {
    let mut sum = Sum::zero(simd);
    let (left, right) = (S::as_simd_f64s(left).0, S::as_simd_f64s(right).0);
    let parts = Sum::<S>::PARTS;
    for (x, y) in left.chunks_exact(parts).zip(right.chunks_exact(parts)) {
        for part in 0..parts {
            sum.add(simd, part, x[part], y[part]);
        }
    }
    sum
}

/// Σ x_i y_i in every lane.
#[inline(always)]
pub(crate) fn dot_lanes<S: Simd>(simd: S, left: &[f64], right: &[f64]) -> Line {
    products(simd, left, right).lanes()
}

/// |W|² as [`accumulate`] returns it.
pub(crate) fn norm_squared(weights: &[f64]) -> f64 {
    Shared.run(Dot { left: weights, right: weights })
}

/// Σ x_i y_i over whole lanes.
pub(crate) struct Dot<'a> {
    pub left: &'a [f64],
    pub right: &'a [f64],
}

impl WithSimd for Dot<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        dot(simd, self.left, self.right)
    }
}

#[cfg(test)]
#[cfg(feature = "std")]
mod tests {
    use approx::{assert_abs_diff_eq, assert_relative_eq};
    use pulp::Scalar;

    use super::*;
    use crate::fuzzy::places::Span;

    fn some(len: usize, seed: usize) -> Vec<f64> {
        (0..len).map(|k| ((k * 37 + seed) % 101) as f64 / 101.0 - 0.3).collect()
    }

    /// A product of `columns` numbers by 8, and one of `rows` by `whole`, in blocks of this length.
    fn dyads(columns: usize, rows: usize, whole: usize) -> (Dyads, usize) {
        let spans = [columns, LANES, rows, whole].map(|len| Span { first: 0, len });
        let [u, mut v, mut x, mut y] = spans;
        v.first = u.len.next_multiple_of(LANES);
        x.first = v.first + v.len;
        y.first = x.first + x.len.next_multiple_of(LANES);
        ([Dyad { u, v }, Dyad { u: x, v: y }], y.first + y.len)
    }

    /// Every loop on weights for a product of so many rows: the numbers that it returns, and all
    /// that it writes.
    struct All(usize);

    impl WithSimd for All {
        type Output = Vec<f64>;

        fn with_simd<S: Simd>(self, simd: S) -> Vec<f64> {
            let (dyads, block) = dyads(2, self.0, 5 * LANES);
            let len = dyads.iter().map(Dyad::len).sum();
            let (mut weights, xi) = (some(2 * len, 1), some(8 * block, 2));
            let (first, second) = weights.split_at(len);
            let mut results = contract(simd, [first, second], &dyads, &xi[..block]).to_vec();
            results.extend(contract(simd, [first], &dyads, &xi[..block]));
            let terms: Vec<&[f64]> = xi.chunks_exact(block).collect();
            let coefficients: Vec<f64> = (0..8).map(|k| 0.1 + k as f64).collect();
            for count in 0..=terms.len() {
                let (c, xi) = (&coefficients[..count], &terms[..count]);
                results.push(accumulate(simd, &mut weights[len..], 0.9, &dyads, c, xi));
            }
            results.push(dot(simd, &weights, &weights));
            results.extend(weights);
            results
        }
    }

    #[test]
    fn every_instruction_set_gives_the_same_bits() {
        for rows in [1, 7] {
            let scalar = All(rows).with_simd(Scalar);
            assert_eq!(scalar, Shared.run(All(rows)));
            #[cfg(target_arch = "x86_64")]
            if let Some(v3) = pulp::x86::V3::try_new() {
                assert_eq!(scalar, Simd::vectorize(v3, All(rows)));
            }
        }
    }

    #[test]
    fn contraction_and_accumulation_are_those_of_the_written_out_product() {
        for (columns, rows, whole) in
            [(0, 1, 8), (1, 4, 16), (3, 25, 24), (0, 25, 32), (7, 3, 13 * LANES)]
        {
            let (dyads, block) = dyads(columns, rows, whole);
            let len = dyads.iter().map(Dyad::len).sum();
            let (mut weights, xi, c) = (some(2 * len, 1), some(6 * block, 2), some(6, 4));
            let terms: Vec<&[f64]> = xi.chunks_exact(block).collect();
            let written: Vec<Vec<f64>> = terms
                .iter()
                .map(|xi| {
                    let rows =
                        dyads.iter().flat_map(|dyad| dyad.u.of(xi).iter().map(move |u| (u, dyad)));
                    rows.flat_map(|(u, dyad)| dyad.v.of(xi).iter().map(move |v| u * v)).collect()
                })
                .collect();
            let product = |w: &[f64]| w.iter().zip(&written[0]).map(|(w, x)| w * x).sum::<f64>();
            let (first, second) = weights.split_at(len);
            let both = contract(Scalar, [first, second], &dyads, terms[0]);
            assert_abs_diff_eq!(both[0], product(first), epsilon = 1e-12);
            assert_abs_diff_eq!(both[1], product(second), epsilon = 1e-12);
            assert_eq!(contract(Scalar, [first], &dyads, terms[0]), [both[0]]);
            assert_eq!(contract(Scalar, [second], &dyads, terms[0]), [both[1]]);

            weights.truncate(len);
            let mut wanted: Vec<f64> = weights.iter().map(|w| 0.9 * w).collect();
            for (c, xi) in c.iter().zip(&written) {
                wanted.iter_mut().zip(xi).for_each(|(w, x)| *w += c * x);
            }
            let squares = accumulate(Scalar, &mut weights, 0.9, &dyads, &c, &terms);
            let norm: f64 = weights.iter().map(|w| w * w).sum();
            assert_relative_eq!(squares, norm, max_relative = 1e-13);
            for (w, wanted) in weights.iter().zip(&wanted) {
                assert_abs_diff_eq!(w, wanted, epsilon = 1e-14);
            }
        }
    }
}

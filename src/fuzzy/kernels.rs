//! The inner loops over rules, for whatever vector registers the machine has.
//!
//! Sums run over 8 lanes, however many a register holds; the lanes are added in a fixed order and nothing is fused,
//! so every instruction set gives the same bits.

use pulp::{Arch, Simd, WithSimd};

/// Rows of weights are whole multiples of this long.
pub(crate) const LANES: usize = 8;

/// Terms that are added side by side.
const BATCH: usize = 5;

/// Runs of lanes that are worked on side by side.
pub(super) const BLOCK: usize = 4;

/// Weights smaller than this are set to zero: denormal numbers would slow every later step.
const FLUSH_BELOW: f64 = 1e-300;

/// Start of the first whole lane in a buffer: cache lines are read whole from there.
pub(crate) fn first_lane(buffer: &[f64]) -> usize {
    match buffer.as_ptr().align_offset(LANES * size_of::<f64>()) {
        offset if offset < LANES => offset,
        _ => 0,
    }
}

/// A vector ξ = u ⊗ v; v is padded with zeros to whole lanes.
#[derive(Clone, Copy)]
pub(crate) struct Activation<'a> {
    pub u: &'a [f64],
    pub v: &'a [f64],
}

impl Activation<'_> {
    pub const NONE: Self = Self { u: &[], v: &[] };
}

/// A stretch of a longer array.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Span {
    pub first: usize,
    pub len: usize,
}

impl Span {
    pub const EMPTY: Self = Self { first: 0, len: 0 };

    #[inline]
    pub fn of<'a, T>(&self, array: &'a [T]) -> &'a [T] {
        &array[self.first..self.first + self.len]
    }

    #[inline]
    pub fn of_mut<'a, T>(&self, array: &'a mut [T]) -> &'a mut [T] {
        &mut array[self.first..self.first + self.len]
    }
}

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
    fn lanes(&self) -> [f64; LANES] {
        let mut x = [0.0; LANES];
        S::as_mut_simd_f64s(&mut x).0.copy_from_slice(&self.0[..Self::PARTS]);
        x
    }

    /// Adds the lanes in a fixed order.
    #[inline(always)]
    fn total(&self) -> f64 {
        let x = self.lanes();
        ((x[0] + x[4]) + (x[2] + x[6])) + ((x[1] + x[5]) + (x[3] + x[7]))
    }
}

/// uᵀ W v for ξ = u ⊗ v and a matrix W, row-major with `v.len()` columns.
#[inline(always)]
pub(crate) fn contract<S: Simd>(simd: S, weights: &[f64], xi: Activation<'_>) -> f64 {
    let mut sum = Sum::zero(simd);
    let mut first = 0;
    while first < xi.v.len() {
        first += match (xi.v.len() - first) / LANES {
            1 => columns::<S, 1>(simd, weights, first, xi, &mut sum),
            2 => columns::<S, 2>(simd, weights, first, xi, &mut sum),
            3 => columns::<S, 3>(simd, weights, first, xi, &mut sum),
            _ => columns::<S, BLOCK>(simd, weights, first, xi, &mut sum),
        };
    }
    sum.total()
}

/// Adds the share of `C` runs of columns from column `first` on: first over the rows, then over the columns. Returns the
/// number of columns.
#[inline(always)]
fn columns<S: Simd, const C: usize>(
    simd: S,
    weights: &[f64],
    first: usize,
    xi: Activation<'_>,
    sum: &mut Sum<S>,
) -> usize {
    let mut rows = [Sum::zero(simd); C];
    let mut rest = weights;
    for u in xi.u {
        let (row, others) = rest.split_at(xi.v.len());
        let (u, w) = (simd.splat_f64s(*u), runs::<S, C>(row, first));
        for (c, row) in rows.iter_mut().enumerate() {
            for part in 0..Sum::<S>::PARTS {
                row.add(simd, part, u, w[c * Sum::<S>::PARTS + part]);
            }
        }
        rest = others;
    }
    let v = runs::<S, C>(xi.v, first);
    for (c, row) in rows.iter().enumerate() {
        for part in 0..Sum::<S>::PARTS {
            sum.add(simd, part, row.0[part], v[c * Sum::<S>::PARTS + part]);
        }
    }
    C * LANES
}

/// The registers of `C` runs of a row from column `first` on.
#[inline(always)]
fn runs<S: Simd, const C: usize>(row: &[f64], first: usize) -> &[S::f64s] {
    S::as_simd_f64s(&row[first..first + C * LANES]).0
}

/// W ← keep W + Σ c ξᵀ for equally many c and ξ = u ⊗ v, row-major; returns |W|² of the result.
#[inline(always)]
pub(crate) fn accumulate<S: Simd>(
    simd: S,
    weights: &mut [f64],
    keep: f64,
    coefficients: &[f64],
    terms: &[Activation<'_>],
) -> f64 {
    if keep != 1.0 {
        let factor = simd.splat_f64s(keep);
        for w in S::as_mut_simd_f64s(weights).0 {
            *w = simd.mul_f64s(factor, *w);
        }
    }
    let mut squares = None;
    for (c, xi) in coefficients.chunks(BATCH).zip(terms.chunks(BATCH)) {
        squares = match xi.len() {
            5 => Some(add::<S, 5>(simd, weights, c, xi)),
            4 => Some(add::<S, 4>(simd, weights, c, xi)),
            3 => Some(add::<S, 3>(simd, weights, c, xi)),
            2 => Some(add::<S, 2>(simd, weights, c, xi)),
            _ => Some(add::<S, 1>(simd, weights, c, xi)),
        };
    }
    squares.unwrap_or_else(|| dot(simd, weights, weights))
}

/// Adds K terms; returns the squared norm of the result.
#[inline(always)]
fn add<S: Simd, const K: usize>(
    simd: S,
    weights: &mut [f64],
    coefficients: &[f64],
    terms: &[Activation<'_>],
) -> f64 {
    let (Some(coefficients), Some(terms)) = (coefficients.first_chunk(), terms.first_chunk())
    else {
        return 0.0;
    };
    let stride = terms[0].v.len();
    let mut squares = Sum::zero(simd);
    let mut first = 0;
    while first < stride {
        first += match (stride - first) / LANES {
            1 => add_columns::<S, K, 1>(simd, weights, first, coefficients, terms, &mut squares),
            2 => add_columns::<S, K, 2>(simd, weights, first, coefficients, terms, &mut squares),
            3 => add_columns::<S, K, 3>(simd, weights, first, coefficients, terms, &mut squares),
            _ => {
                add_columns::<S, K, BLOCK>(simd, weights, first, coefficients, terms, &mut squares)
            }
        };
    }
    squares.total()
}

/// Adds the terms to `C` runs of columns from column `first` on, and the squares of the result to `squares`; returns the
/// number of columns.
#[inline(always)]
fn add_columns<S: Simd, const K: usize, const C: usize>(
    simd: S,
    weights: &mut [f64],
    first: usize,
    coefficients: &[f64; K],
    terms: &[Activation<'_>; K],
    squares: &mut Sum<S>,
) -> usize {
    let (rows, stride) = (terms[0].u.len(), terms[0].v.len());
    let (mut u, mut v) = ([&[][..]; K], [[[simd.splat_f64s(0.0); LANES]; C]; K]);
    for k in 0..K {
        u[k] = &terms[k].u[..rows];
        let c = simd.splat_f64s(coefficients[k]);
        let registers = runs::<S, C>(terms[k].v, first);
        for run in 0..C {
            for part in 0..Sum::<S>::PARTS {
                v[k][run][part] = simd.mul_f64s(c, registers[run * Sum::<S>::PARTS + part]);
            }
        }
    }
    let mut sums = [Sum::zero(simd); C];
    let mut rest = weights;
    for a in 0..rows {
        let (row, others) = rest.split_at_mut(stride);
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

/// Sets denormal weights, and those that are about to be, to zero.
pub(crate) fn flush(weights: &mut [f64]) {
    for w in weights {
        if w.abs() < FLUSH_BELOW {
            *w = 0.0;
        }
    }
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
pub(crate) fn dot_lanes<S: Simd>(simd: S, left: &[f64], right: &[f64]) -> [f64; LANES] {
    products(simd, left, right).lanes()
}

/// |W|² as [`accumulate`] returns it.
pub(crate) fn norm_squared(weights: &[f64]) -> f64 {
    Arch::new().dispatch(NormSquared(weights))
}

struct NormSquared<'a>(&'a [f64]);

impl WithSimd for NormSquared<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        dot(simd, self.0, self.0)
    }
}

#[cfg(test)]
#[cfg(feature = "std")]
mod tests {
    use approx::{assert_abs_diff_eq, assert_relative_eq};
    use pulp::Scalar;

    use super::*;

    /// Every loop on a matrix of 7 rows, and on one of 1: the numbers that it returns, and all that it writes.
    struct All(usize);

    impl WithSimd for All {
        type Output = Vec<f64>;

        fn with_simd<S: Simd>(self, simd: S) -> Vec<f64> {
            const COLUMNS: usize = 3 * LANES;
            let rows = self.0;
            let some = |len: usize, seed: usize| -> Vec<f64> {
                (0..len).map(|k| ((k * 37 + seed) % 101) as f64 / 101.0 - 0.3).collect()
            };
            let mut weights = some(2 * rows * COLUMNS, 1);
            let (u, v) = (some(8 * rows, 2), some(8 * COLUMNS, 3));
            let xi = Activation { u: &u[..rows], v: &v[..COLUMNS] };
            let mut results = vec![contract(simd, &weights[..rows * COLUMNS], xi)];
            let terms: Vec<Activation<'_>> = (0..8)
                .map(|k| Activation {
                    u: &u[k * rows..(k + 1) * rows],
                    v: &v[k * COLUMNS..(k + 1) * COLUMNS],
                })
                .collect();
            let coefficients: Vec<f64> = (0..8).map(|k| 0.1 + k as f64).collect();
            for count in 0..=terms.len() {
                let row = &mut weights[rows * COLUMNS..];
                let (c, xi) = (&coefficients[..count], &terms[..count]);
                results.push(accumulate(simd, row, 0.9, c, xi));
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
            assert_eq!(scalar, Arch::new().dispatch(All(rows)));
            #[cfg(target_arch = "x86_64")]
            if let Some(v3) = pulp::x86::V3::try_new() {
                assert_eq!(scalar, Simd::vectorize(v3, All(rows)));
            }
        }
    }

    #[test]
    fn contraction_and_accumulation_are_those_of_the_written_out_product() {
        for (rows, columns) in [(1, LANES), (4, 2 * LANES), (25, 4 * LANES), (3, 13 * LANES)] {
            let some = |len: usize, seed: usize| -> Vec<f64> {
                (0..len).map(|k| ((k * 29 + seed) % 97) as f64 / 97.0 - 0.4).collect()
            };
            let (mut weights, u, v) =
                (some(rows * columns, 1), some(6 * rows, 2), some(6 * columns, 3));
            let terms: Vec<Activation<'_>> = (0..6)
                .map(|k| Activation { u: &u[k * rows..][..rows], v: &v[k * columns..][..columns] })
                .collect();
            let c = some(6, 4);
            let written: f64 =
                (0..rows * columns).map(|k| weights[k] * u[k / columns] * v[k % columns]).sum();
            assert_abs_diff_eq!(contract(Scalar, &weights, terms[0]), written, epsilon = 1e-13);

            let mut wanted: Vec<f64> = weights.iter().map(|w| 0.9 * w).collect();
            for (c, xi) in c.iter().zip(&terms) {
                for (k, w) in wanted.iter_mut().enumerate() {
                    *w += c * xi.u[k / columns] * xi.v[k % columns];
                }
            }
            let squares = accumulate(Scalar, &mut weights, 0.9, &c, &terms);
            let norm: f64 = weights.iter().map(|w| w * w).sum();
            assert_relative_eq!(squares, norm, max_relative = 1e-13);
            for (w, wanted) in weights.iter().zip(&wanted) {
                assert_abs_diff_eq!(w, wanted, epsilon = 1e-14);
            }
        }
    }
}

//! The inner loops over rules, for whatever vector registers the machine has.
//!
//! Sums run over 8 lanes, however many a register holds; the lanes are added in a fixed order and nothing is fused,
//! so every instruction set gives the same bits.

use core::array;

use pulp::{Arch, Simd, WithSimd};

/// Rows of weights are whole multiples of this long.
pub(crate) const LANES: usize = 8;

/// Rows of weights that are summed, and terms that are added, side by side.
const BATCH: usize = 5;

/// Weights smaller than this are set to zero: denormal numbers would slow every later step.
const FLUSH_BELOW: f64 = 1e-300;

/// Start of the first whole lane in a buffer: cache lines are read whole from there.
pub(crate) fn first_lane(buffer: &[f64]) -> usize {
    match buffer.as_ptr().align_offset(LANES * size_of::<f64>()) {
        offset if offset < LANES => offset,
        _ => 0,
    }
}

/// One term c u vᵀ of a change of weights.
#[derive(Clone, Copy)]
pub(crate) struct Term<'a> {
    pub coefficient: f64,
    pub u: &'a [f64],
    pub v: &'a [f64],
}

/// A stretch of a longer array.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Span {
    pub first: usize,
    pub len: usize,
}

impl Span {
    pub const EMPTY: Self = Self { first: 0, len: 0 };

    /// The same, up to whole lanes.
    #[inline]
    pub fn lanes(&self) -> Self {
        Self { first: self.first, len: self.len.next_multiple_of(LANES) }
    }

    #[inline]
    pub fn of<'a, T>(&self, array: &'a [T]) -> &'a [T] {
        &array[self.first..self.first + self.len]
    }

    #[inline]
    pub fn of_mut<'a, T>(&self, array: &'a mut [T]) -> &'a mut [T] {
        &mut array[self.first..self.first + self.len]
    }
}

/// out[..] = ⊗ factors, from the last factor to the first. Long rows are written in whole lanes; what a row writes too
/// far, the next one, or the padding, covers. Zeros after it up to the length `padded`.
///
/// `out` and `scratch` have room for one more run of lanes.
#[inline(always)]
pub(crate) fn kronecker<S: Simd>(
    simd: S,
    memberships: &[f64],
    factors: &[Span],
    padded: usize,
    out: &mut [f64],
    scratch: &mut [f64],
) {
    let Some((last, others)) = factors.split_last() else {
        out[0] = 1.0;
        return;
    };
    let (mut from, mut to) = if others.len() % 2 == 0 { (out, scratch) } else { (scratch, out) };
    let mut len = last.len;
    from[..len].iter_mut().zip(last.of(memberships)).for_each(|(y, p)| *y = *p);
    for factor in others.iter().rev() {
        let width = if len < LANES { len } else { len.next_multiple_of(LANES) };
        for (row, p) in factor.of(memberships).iter().enumerate() {
            scale(simd, *p, &from[..width], &mut to[row * len..row * len + width]);
        }
        len *= factor.len;
        (from, to) = (to, from);
    }
    from[len..padded].fill(0.0);
}

/// y = p x. What does not fill a register goes one by one: it was just written so, and a register could not yet be
/// read from there.
#[inline(always)]
fn scale<S: Simd>(simd: S, p: f64, x: &[f64], y: &mut [f64]) {
    if x.len() < LANES {
        return y.iter_mut().zip(x).for_each(|(y, x)| *y = p * x);
    }
    let p = simd.splat_f64s(p);
    for (x, y) in S::as_simd_f64s(x).0.iter().zip(S::as_mut_simd_f64s(y).0) {
        *y = simd.mul_f64s(p, *x);
    }
}

/// A sum of 8 lanes, in as many registers as they take: the first 8 / `F64_LANES` entries.
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

    /// Adds the lanes in a fixed order.
    #[inline(always)]
    fn total(&self) -> f64 {
        let mut x = [0.0; LANES];
        S::as_mut_simd_f64s(&mut x).0.copy_from_slice(&self.0[..Self::PARTS]);
        ((x[0] + x[4]) + (x[2] + x[6])) + ((x[1] + x[5]) + (x[3] + x[7]))
    }
}

/// out_n = Σ_a u_a Σ_b W_nab v_b for the matrices W_n, row-major with `v.len()` columns, one after the other.
#[inline(always)]
pub(crate) fn contract<S: Simd>(
    simd: S,
    weights: &[f64],
    (u, v): (&[f64], &[f64]),
    out: &mut [f64],
) {
    let (mut weights, v) = (S::as_simd_f64s(weights).0, S::as_simd_f64s(v).0);
    for out in out {
        let mut sum = Sum::zero(simd);
        for u in u.chunks(BATCH) {
            weights = match *u {
                [a, b, c, d, e] => rows(simd, weights, [a, b, c, d, e], v, &mut sum),
                [a, b, c, d] => rows(simd, weights, [a, b, c, d], v, &mut sum),
                [a, b, c] => rows(simd, weights, [a, b, c], v, &mut sum),
                [a, b] => rows(simd, weights, [a, b], v, &mut sum),
                [a] => rows(simd, weights, [a], v, &mut sum),
                _ => weights,
            };
        }
        *out = sum.total();
    }
}

/// Adds the share of the first `R` rows; returns the others.
#[inline(always)]
fn rows<'a, S: Simd, const R: usize>(
    simd: S,
    weights: &'a [S::f64s],
    u: [f64; R],
    v: &[S::f64s],
    sum: &mut Sum<S>,
) -> &'a [S::f64s] {
    let u = u.map(|u| simd.splat_f64s(u));
    let mut rest = weights;
    let rows: [&[S::f64s]; R] = array::from_fn(|_| {
        let (row, others) = rest.split_at(v.len());
        rest = others;
        row
    });
    for i in 0..v.len() / Sum::<S>::PARTS {
        for part in 0..Sum::<S>::PARTS {
            let i = i * Sum::<S>::PARTS + part;
            let mut column = simd.mul_f64s(u[0], rows[0][i]);
            for r in 1..R {
                column = simd.add_f64s(column, simd.mul_f64s(u[r], rows[r][i]));
            }
            sum.add(simd, part, column, v[i]);
        }
    }
    rest
}

/// W ← keep W + Σ c u vᵀ, row-major; returns |W|² of the result.
#[inline(always)]
pub(crate) fn accumulate<S: Simd>(
    simd: S,
    weights: &mut [f64],
    keep: f64,
    terms: &[Term<'_>],
) -> f64 {
    if keep != 1.0 {
        let factor = simd.splat_f64s(keep);
        for w in S::as_mut_simd_f64s(weights).0 {
            *w = simd.mul_f64s(factor, *w);
        }
    }
    let mut squares = None;
    for terms in terms.chunks(BATCH) {
        squares = match *terms {
            [a, b, c, d, e] => Some(add(simd, weights, [a, b, c, d, e])),
            [a, b, c, d] => Some(add(simd, weights, [a, b, c, d])),
            [a, b, c] => Some(add(simd, weights, [a, b, c])),
            [a, b] => Some(add(simd, weights, [a, b])),
            [a] => Some(add(simd, weights, [a])),
            _ => None,
        };
    }
    squares.unwrap_or_else(|| dot(simd, weights, weights))
}

/// Adds K terms; returns the squared norm of the result.
#[inline(always)]
fn add<S: Simd, const K: usize>(simd: S, weights: &mut [f64], terms: [Term<'_>; K]) -> f64 {
    let (rows, columns) = (terms[0].u.len(), terms[0].v.len());
    let u = terms.map(|term| &term.u[..rows]);
    let v = terms.map(|term| S::as_simd_f64s(&term.v[..columns]).0);
    let mut rest = S::as_mut_simd_f64s(weights).0;
    let mut squares = Sum::zero(simd);
    for a in 0..rows {
        let (row, others) = rest.split_at_mut(v[0].len());
        rest = others;
        let scales: [S::f64s; K] =
            array::from_fn(|k| simd.splat_f64s(terms[k].coefficient * u[k][a]));
        for i in 0..v[0].len() / Sum::<S>::PARTS {
            for part in 0..Sum::<S>::PARTS {
                let i = i * Sum::<S>::PARTS + part;
                let mut w = row[i];
                for k in 0..K {
                    w = simd.add_f64s(w, simd.mul_f64s(scales[k], v[k][i]));
                }
                row[i] = w;
                squares.add(simd, part, w, w);
            }
        }
    }
    squares.total()
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
    let mut sum = Sum::zero(simd);
    let (left, right) = (S::as_simd_f64s(left).0, S::as_simd_f64s(right).0);
    let parts = Sum::<S>::PARTS;
    for (x, y) in left.chunks_exact(parts).zip(right.chunks_exact(parts)) {
        for part in 0..parts {
            sum.add(simd, part, x[part], y[part]);
        }
    }
    sum.total()
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
            let mut results = vec![0.0; 2];
            contract(simd, &weights, (&u[..rows], &v[..COLUMNS]), &mut results);
            let terms: Vec<Term<'_>> = (0..8)
                .map(|k| Term {
                    coefficient: 0.1 + k as f64,
                    u: &u[k * rows..(k + 1) * rows],
                    v: &v[k * COLUMNS..(k + 1) * COLUMNS],
                })
                .collect();
            for count in 0..=terms.len() {
                let row = &mut weights[rows * COLUMNS..];
                results.push(accumulate(simd, row, 0.9, &terms[..count]));
            }
            let factors = [(0, 3), (8, 5), (16, 4), (24, 2)];
            let factors = factors.map(|(first, len)| Span { first, len });
            let (mut out, mut scratch) = (vec![0.0; 136], vec![0.0; 136]);
            kronecker(simd, &some(32, 4), &factors, 120, &mut out, &mut scratch);
            results.push(dot(simd, &weights, &weights));
            results.extend(weights);
            results.extend(&out[..120]);
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
    fn kronecker_is_the_product_of_its_factors_first_slowest() {
        let memberships = [1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 5.0, 7.0];
        let memberships = [&memberships[..], &[0.0; 6]].concat();
        let factors = [Span { first: 0, len: 3 }, Span { first: 8, len: 2 }];
        let (mut out, mut scratch) = ([9.0; 16], [9.0; 16]);
        kronecker(Scalar, &memberships, &factors, 8, &mut out, &mut scratch);
        assert_eq!(out[..8], [5.0, 7.0, 10.0, 14.0, 15.0, 21.0, 0.0, 0.0]);
    }
}

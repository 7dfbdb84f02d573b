//! The inner loops over rules: plain loops of 8 lanes, compiled for several instruction sets.
//!
//! The lanes are added in a fixed order and nothing is fused, so every instruction set gives the same bits.

use core::array;

use multiversion::multiversion;

/// Rows of weights are whole multiples of this long.
pub(crate) const LANES: usize = 8;

/// Rows of weights that are summed side by side.
const ROWS: usize = 5;

/// Weights smaller than this are set to zero: denormal numbers would slow every later step.
const FLUSH_BELOW: f64 = 1e-300;

type Lanes = [f64; LANES];

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

/// out_j = scale tᵏ decay_j for the first `len` entries, zeros after them; without a scale, normalised to sum 1.
///
/// `steps` holds 2|k|, plus 1 where k < 0, with `digits` binary digits in |k|. All slices are whole lanes.
#[multiversion(targets("x86_64+avx2"))]
pub(crate) fn powers(
    (steps, decays): (&[u64], &[f64]),
    digits: u32,
    t: f64,
    scale: Option<f64>,
    (len, out): (usize, &mut [f64]),
) {
    let inverse = 1.0 / t;
    let chunks = steps.as_chunks::<LANES>().0.iter().zip(decays.as_chunks::<LANES>().0);
    for (i, ((steps, decays), out)) in chunks.zip(out.as_chunks_mut::<LANES>().0).enumerate() {
        let mut base = [t; LANES];
        for lane in 0..LANES {
            base[lane] = select(steps[lane] & 1, inverse, t);
        }
        let mut power = *decays;
        for digit in 1..=digits {
            for lane in 0..LANES {
                power[lane] *= select(steps[lane] >> digit & 1, base[lane], 1.0);
                base[lane] *= base[lane];
            }
        }
        for lane in 0..LANES {
            out[lane] = if i * LANES + lane < len { power[lane] } else { 0.0 };
        }
    }
    let scale = scale.unwrap_or_else(|| {
        let mut sum = [0.0; LANES];
        for out in out.as_chunks::<LANES>().0 {
            for lane in 0..LANES {
                sum[lane] += out[lane];
            }
        }
        1.0 / sum_lanes(&sum)
    });
    for out in out.as_chunks_mut::<LANES>().0 {
        for lane in 0..LANES {
            out[lane] *= scale;
        }
    }
}

/// `one` for the digit 1, `zero` for 0, without a branch.
#[inline(always)]
fn select(digit: u64, one: f64, zero: f64) -> f64 {
    let mask = digit.wrapping_neg();
    f64::from_bits(one.to_bits() & mask | zero.to_bits() & !mask)
}

/// u and v, the products of the leading and of the trailing factors, each with its length; zeros up to that length.
///
/// `u`, `v` and `scratch` have room for one more run of lanes.
#[multiversion(targets("x86_64+avx2"))]
pub(crate) fn expand(
    memberships: &[f64],
    (leading, trailing): (&[Span], &[Span]),
    (outer, u): (usize, &mut [f64]),
    (stride, v): (usize, &mut [f64]),
    scratch: &mut [f64],
) {
    kronecker(memberships, leading, outer, u, scratch);
    kronecker(memberships, trailing, stride, v, scratch);
}

/// out[..] = ⊗ factors, from the last factor to the first. Rows are written in whole lanes; what a row writes too far,
/// the next one, or the padding, covers.
#[inline(always)]
fn kronecker(
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
    let (mut from, mut to) =
        if others.len().is_multiple_of(2) { (out, scratch) } else { (scratch, out) };
    let mut len = last.len;
    let width = last.lanes().len;
    scale(1.0, last.lanes().of(memberships), &mut from[..width]);
    for factor in others.iter().rev() {
        let width = len.next_multiple_of(LANES);
        for (row, p) in factor.of(memberships).iter().enumerate() {
            scale(*p, &from[..width], &mut to[row * len..row * len + width]);
        }
        len *= factor.len;
        (from, to) = (to, from);
    }
    from[len..padded].fill(0.0);
}

/// y = p x, in whole lanes.
#[inline(always)]
fn scale(p: f64, x: &[f64], y: &mut [f64]) {
    for (x, y) in x.as_chunks::<LANES>().0.iter().zip(y.as_chunks_mut::<LANES>().0) {
        for lane in 0..LANES {
            y[lane] = p * x[lane];
        }
    }
}

/// out_n = Σ_a u_a Σ_b W_nab v_b for the matrices W_n, row-major with `v.len()` columns, one after the other.
#[multiversion(targets("x86_64+avx2"))]
pub(crate) fn contract(weights: &[f64], u: &[f64], v: &[f64], out: &mut [f64]) {
    let (weights, v) = (weights.as_chunks::<LANES>().0, v.as_chunks::<LANES>().0);
    for (w, out) in weights.chunks_exact(u.len() * v.len()).zip(out) {
        let mut total = [0.0; LANES];
        let (groups, rest) = u.as_chunks::<ROWS>();
        let (blocks, last) = w.split_at(groups.len() * ROWS * v.len());
        for (block, u) in blocks.chunks_exact(ROWS * v.len()).zip(groups) {
            rows(block, u, v, &mut total);
        }
        for (row, u) in last.chunks_exact(v.len()).zip(rest) {
            rows(row, &[*u], v, &mut total);
        }
        *out = add_lanes(&total);
    }
}

/// Adds the share of `R` rows.
#[inline(always)]
fn rows<const R: usize>(w: &[Lanes], u: &[f64; R], v: &[Lanes], total: &mut Lanes) {
    let w: [&[Lanes]; R] = array::from_fn(|r| &w[r * v.len()..(r + 1) * v.len()]);
    let mut sums = [[0.0; LANES]; R];
    for (i, x) in v.iter().enumerate() {
        for (sum, row) in sums.iter_mut().zip(&w) {
            for lane in 0..LANES {
                sum[lane] += row[i][lane] * x[lane];
            }
        }
    }
    for (sum, scale) in sums.iter().zip(u) {
        for lane in 0..LANES {
            total[lane] += scale * sum[lane];
        }
    }
}

/// W ← keep W + Σ c u vᵀ, row-major; returns |W|² of the result.
#[multiversion(targets("x86_64+avx2"))]
pub(crate) fn accumulate(weights: &mut [f64], keep: f64, terms: &[Term<'_>]) -> f64 {
    if keep != 1.0 {
        weights.iter_mut().for_each(|w| *w *= keep);
    }
    if terms.is_empty() {
        return norm_squared(weights);
    }
    let mut squares = [0.0; LANES];
    for terms in terms.chunks(4) {
        squares = match *terms {
            [a, b, c, d] => add(weights, &[a, b, c, d]),
            [a, b, c] => add(weights, &[a, b, c]),
            [a, b] => add(weights, &[a, b]),
            [a] => add(weights, &[a]),
            _ => squares,
        };
    }
    add_lanes(&squares)
}

/// Adds K terms, two rows of W at a time; returns the sums of squares of the result.
#[inline(always)]
fn add<const K: usize>(weights: &mut [f64], terms: &[Term<'_>; K]) -> Lanes {
    let columns = terms[0].v.len();
    let v = terms.map(|term| &term.v[..columns]);
    let scales = |a: usize| terms.map(|term| term.coefficient * term.u[a]);
    let mut squares = [0.0; LANES];
    let mut rows = weights.chunks_exact_mut(columns).enumerate();
    while let Some((a, row)) = rows.next() {
        if let Some((b, other)) = rows.next() {
            add_rows(row, other, [scales(a), scales(b)], &v, &mut squares);
        } else {
            add_row(row, scales(a), &v);
            square(row, &mut squares);
        }
    }
    squares
}

#[inline(always)]
fn add_rows<const K: usize>(
    row: &mut [f64],
    other: &mut [f64],
    scales: [[f64; K]; 2],
    v: &[&[f64]; K],
    squares: &mut Lanes,
) {
    let v = v.map(|v| v.as_chunks::<LANES>().0);
    let mut rows = [row, other].map(|row| row.as_chunks_mut::<LANES>().0);
    for i in 0..v[0].len() {
        for (row, scales) in rows.iter_mut().zip(&scales) {
            let mut w = row[i];
            for k in 0..K {
                for lane in 0..LANES {
                    w[lane] += scales[k] * v[k][i][lane];
                }
            }
            row[i] = w;
            for lane in 0..LANES {
                squares[lane] += w[lane] * w[lane];
            }
        }
    }
}

#[inline(always)]
fn add_row<const K: usize>(row: &mut [f64], scales: [f64; K], v: &[&[f64]; K]) {
    for (i, entry) in row.iter_mut().enumerate() {
        let mut w = *entry;
        for k in 0..K {
            w += scales[k] * v[k][i];
        }
        *entry = w;
    }
}

/// Adds squares, lane by lane.
#[inline(always)]
fn square(row: &[f64], sums: &mut Lanes) {
    for w in row.as_chunks::<LANES>().0 {
        for lane in 0..LANES {
            sums[lane] += w[lane] * w[lane];
        }
    }
}

/// |W|².
#[multiversion(targets("x86_64+avx2"))]
pub(crate) fn norm_squared(weights: &[f64]) -> f64 {
    let mut sum = [0.0; LANES];
    square(weights, &mut sum);
    add_lanes(&sum)
}

/// Sets denormal weights, and those that are about to be, to zero.
pub(crate) fn flush(weights: &mut [f64]) {
    for w in weights {
        if w.abs() < FLUSH_BELOW {
            *w = 0.0;
        }
    }
}

/// ξ·ξ' of two products: one sum over the sets of an input for each factor.
#[multiversion(targets("x86_64+avx2"))]
pub(crate) fn product_of_dots(left: &[f64], right: &[f64], factors: &[Span]) -> f64 {
    let mut product = 1.0;
    for factor in factors {
        let lanes = factor.lanes();
        product *= dot(lanes.of(left), lanes.of(right));
    }
    product
}

/// Σ x_i y_i over whole lanes.
#[inline(always)]
pub(crate) fn dot(x: &[f64], y: &[f64]) -> f64 {
    let mut sum = [0.0; LANES];
    for (a, b) in x.as_chunks::<LANES>().0.iter().zip(y.as_chunks::<LANES>().0) {
        for lane in 0..LANES {
            sum[lane] += a[lane] * b[lane];
        }
    }
    sum_lanes(&sum)
}

/// Sums lanes. A call of its own, so that they stay in whole registers up to here.
#[inline(never)]
fn add_lanes(x: &Lanes) -> f64 {
    sum_lanes(x)
}

/// Sums lanes in a fixed order.
#[inline(always)]
fn sum_lanes(x: &Lanes) -> f64 {
    ((x[0] + x[4]) + (x[2] + x[6])) + ((x[1] + x[5]) + (x[3] + x[7]))
}

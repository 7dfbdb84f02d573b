//! The inner loops over rules: plain loops of 8 lanes, compiled for several instruction sets.
//!
//! The lanes are added in a fixed order and nothing is fused, so every instruction set gives the same bits.

use core::array;

use multiversion::multiversion;

/// Rows of weights are whole multiples of this long.
pub(crate) const LANES: usize = 8;

/// Lanes of columns that are summed side by side.
const GROUP: usize = 4;

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

/// Σ_a u_a Σ_b W_ab v_b for a row-major W with `v.len()` columns.
#[multiversion(targets("x86_64+avx2"))]
pub(crate) fn contract(weights: &[f64], u: &[f64], v: &[f64]) -> f64 {
    let (weights, v) = (weights.as_chunks::<LANES>().0, v.as_chunks::<LANES>().0);
    let mut total = [0.0; LANES];
    let mut first = 0;
    while first + GROUP <= v.len() {
        columns::<GROUP>(weights, u, v, first, &mut total);
        first += GROUP;
    }
    while first < v.len() {
        columns::<1>(weights, u, v, first, &mut total);
        first += 1;
    }
    add_lanes(&total)
}

/// Adds the share of `G` lanes of columns.
#[inline(always)]
fn columns<const G: usize>(w: &[Lanes], u: &[f64], v: &[Lanes], first: usize, total: &mut Lanes) {
    let mut sums = [[0.0; LANES]; G];
    for (row, scale) in w.chunks_exact(v.len()).zip(u) {
        for (sum, w) in sums.iter_mut().zip(&row[first..first + G]) {
            for lane in 0..LANES {
                sum[lane] += scale * w[lane];
            }
        }
    }
    for (sum, x) in sums.iter().zip(&v[first..first + G]) {
        for lane in 0..LANES {
            total[lane] += sum[lane] * x[lane];
        }
    }
}

/// W ← keep W + Σ c u vᵀ, row-major; returns |W|² of the result.
#[multiversion(targets("x86_64+avx2"))]
pub(crate) fn accumulate(weights: &mut [f64], keep: f64, terms: &[Term<'_>]) -> f64 {
    if keep != 1.0 {
        weights.iter_mut().for_each(|w| *w *= keep);
    }
    let (fours, rest) = terms.as_chunks::<4>();
    for terms in fours {
        add_four(weights, terms);
    }
    for term in rest {
        add_one(weights, term);
    }
    squares(weights)
}

#[inline(always)]
fn add_four(weights: &mut [f64], terms: &[Term<'_>; 4]) {
    let v = terms.map(|term| term.v);
    for (a, row) in weights.chunks_exact_mut(v[0].len()).enumerate() {
        let s = terms.map(|term| term.coefficient * term.u[a]);
        for ((((w, x), y), z), t) in row.iter_mut().zip(v[0]).zip(v[1]).zip(v[2]).zip(v[3]) {
            *w = *w + s[0] * x + s[1] * y + s[2] * z + s[3] * t;
        }
    }
}

#[inline(always)]
fn add_one(weights: &mut [f64], term: &Term<'_>) {
    for (row, u) in weights.chunks_exact_mut(term.v.len()).zip(term.u) {
        let scale = term.coefficient * u;
        row.iter_mut().zip(term.v).for_each(|(w, x)| *w += scale * x);
    }
}

#[inline(always)]
fn squares(weights: &[f64]) -> f64 {
    let (groups, rest) = weights.as_chunks::<LANES>().0.as_chunks::<GROUP>();
    let mut sums = [[0.0; LANES]; GROUP];
    for group in groups {
        for (sum, w) in sums.iter_mut().zip(group) {
            for lane in 0..LANES {
                sum[lane] += w[lane] * w[lane];
            }
        }
    }
    for (sum, w) in sums.iter_mut().zip(rest) {
        for lane in 0..LANES {
            sum[lane] += w[lane] * w[lane];
        }
    }
    let pair = |a: &Lanes, b: &Lanes| -> Lanes { array::from_fn(|lane| a[lane] + b[lane]) };
    add_lanes(&pair(&pair(&sums[0], &sums[1]), &pair(&sums[2], &sums[3])))
}

/// |W|².
#[multiversion(targets("x86_64+avx2"))]
pub(crate) fn norm_squared(weights: &[f64]) -> f64 {
    squares(weights)
}

/// Sets denormal weights, and those that are about to be, to zero.
pub(crate) fn flush(weights: &mut [f64]) {
    for w in weights {
        if w.abs() < FLUSH_BELOW {
            *w = 0.0;
        }
    }
}

/// Σ x_i y_i.
#[inline]
pub(crate) fn dot(x: &[f64], y: &[f64]) -> f64 {
    let ((xs, x), (ys, y)) = (x.as_chunks::<LANES>(), y.as_chunks::<LANES>());
    let mut sum = [0.0; LANES];
    for (a, b) in xs.iter().zip(ys) {
        for lane in 0..LANES {
            sum[lane] += a[lane] * b[lane];
        }
    }
    add_lanes(&sum) + x.iter().zip(y).map(|(a, b)| a * b).sum::<f64>()
}

#[inline]
fn add_lanes(x: &Lanes) -> f64 {
    ((x[0] + x[4]) + (x[2] + x[6])) + ((x[1] + x[5]) + (x[3] + x[7]))
}

//! The loops over rules: what a step does with the weights, whatever the joint count.
//!
//! Each is a task for the instruction set at hand. A compensator of one or two joints has them in
//! line, in a stage that is compiled as a whole; beyond that, where a stage takes a microsecond and
//! more, all joint counts share one copy of each.

use pulp::{Simd, WithSimd};

use super::MAX_STAGES;
use crate::fuzzy::lanes::{accumulate, contract};
use crate::fuzzy::{Buffer, FuzzyBasis};
use crate::math::{TINY_ESTIMATE, TINY_TERM, unless_rarely_tiny, unless_tiny};

/// ξᵢ·ξⱼ of each joint's rules.
pub(super) struct Dots<'a, T: Buffer> {
    pub basis: &'a FuzzyBasis<T>,
    pub activations: [&'a [f64]; 2],
    pub out: &'a mut [f64],
}

impl<T: Buffer> WithSimd for Dots<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let [left, right] = self.activations;
        self.basis.dots(simd, left, right, self.out);
    }
}

/// The products of a matrix, a row a joint, with an evaluated basis; tiny ones are zero.
pub(super) struct Products<'a, T: Buffer> {
    pub basis: &'a FuzzyBasis<T>,
    pub matrix: &'a [f64],
    pub activation: &'a [f64],
    pub out: &'a mut [f64],
}

impl<T: Buffer> WithSimd for Products<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { basis, matrix, activation, out } = self;
        let (dyads, len) = (basis.dyads(), basis.row_len());
        let row = |n: usize| &matrix[n * len..(n + 1) * len];
        if basis.blocks() > 1 {
            for (n, out) in out.iter_mut().enumerate() {
                let xi = basis.block(activation, n);
                [*out] = contract(simd, [row(n)], dyads, xi).map(whole);
            }
            return;
        }
        let xi = basis.block(activation, 0);
        let (pairs, last) = out.as_chunks_mut();
        for (k, pair) in pairs.iter_mut().enumerate() {
            *pair = contract(simd, [row(2 * k), row(2 * k + 1)], dyads, xi).map(whole);
        }
        for out in last {
            [*out] = contract(simd, [row(2 * pairs.len())], dyads, xi).map(whole);
        }
    }
}

/// An estimate, without tiny ones.
#[inline(always)]
fn whole(estimate: f64) -> f64 {
    unless_rarely_tiny(estimate, TINY_ESTIMATE)
}

/// D ← keep D + Σ cⱼ ξⱼᵀ, row by row, and |Dₙ|².
pub(super) struct WriteRows<'a, T: Buffer> {
    pub basis: &'a FuzzyBasis<T>,
    pub weights: &'a mut [f64],
    pub norms: &'a mut [f64],
    pub keep: &'a [f64],
    /// The terms that are used: cⱼ of each joint, and the evaluated basis.
    pub coefficients: &'a [&'a [f64]],
    pub activations: &'a [&'a [f64]],
}

impl<T: Buffer> WithSimd for WriteRows<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { basis, weights, norms, keep, coefficients, activations } = self;
        let used = coefficients.len();
        let (mut terms, mut factors) = ([&[][..]; MAX_STAGES], [0.0; MAX_STAGES]);
        let rows = weights.chunks_exact_mut(basis.row_len());
        for (n, row) in rows.enumerate() {
            for (k, (c, xi)) in coefficients.iter().zip(activations).enumerate() {
                let c = unless_tiny(c[n], TINY_TERM);
                (factors[k], terms[k]) = (c, basis.block(xi, basis.block_of(n)));
            }
            if used > 0 || keep[n] != 1.0 {
                let (factors, terms) = (&factors[..used], &terms[..used]);
                norms[n] = accumulate(simd, row, keep[n], basis.dyads(), factors, terms);
            }
        }
    }
}

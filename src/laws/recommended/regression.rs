//! Regularised recursive least squares of `y = φθ`, a row at a time, with forgetting towards the
//! prior P₀:
//!
//! ```text
//! s = φPφᵀ    g = Pφᵀ/(max(r², ρs) + s)    θ ← θ + g (y − φθ)    P ← P − gφP
//! P ← P + share (P₀ − P)
//! ```
//!
//! A row is in units of its joint's torque. With ρ = 1 a row never takes more than half of what it
//! sees, however certain it looks. P is changed by products that are the same in both triangles,
//! so it stays symmetric to the bit, and no larger than P₀.

use pulp::{Simd, WithSimd};

use crate::math::{LANES, Runs, Shared, sqrt};

/// r, what a row cannot say, as a share of the joint's torque.
const NOISE: f64 = 0.01;
/// ρ.
const CAUTION: f64 = 1.0;
/// What is smaller is zero: no product is a subnormal number then.
pub(super) const TINY: f64 = 1e-140;

/// θ, P and room for Pφᵀ; rows of P are whole lanes long.
pub(super) struct Regression<'a> {
    pub theta: &'a mut [f64],
    pub p: &'a mut [f64],
    pub gain: &'a mut [f64],
}

/// A row of the regressor where it is not zero: two stretches of it.
pub(super) struct Row<'a> {
    pub first: [usize; 2],
    pub entries: [&'a [f64]; 2],
}

impl Row<'_> {
    fn each(&self) -> impl Iterator<Item = (usize, f64)> {
        let stretches = self.first.iter().zip(&self.entries);
        stretches.flat_map(|(first, entries)| {
            entries.iter().enumerate().map(move |(j, entry)| (first + j, *entry))
        })
    }

    /// φx.
    pub fn dot(&self, x: &[f64]) -> f64 {
        self.each().map(|(j, entry)| entry * x[j]).sum()
    }
}

/// Length of a row of P for so many parameters.
pub(super) fn stride(parameters: usize) -> usize {
    parameters.next_multiple_of(LANES)
}

impl Regression<'_> {
    /// θ = 0, P = P₀.
    pub fn reset(&mut self, prior: impl Iterator<Item = f64>) {
        self.theta.fill(0.0);
        self.p.fill(0.0);
        let stride = self.gain.len();
        prior.enumerate().for_each(|(j, variance)| self.p[j * stride + j] = variance);
    }

    /// Learns `y = φθ`, both divided by the joint's torque `unit` [N·m].
    pub fn learn(&mut self, row: &Row<'_>, y: f64, unit: f64) {
        let Self { theta, p, gain } = self;
        Shared.run(Learn { regression: Regression { theta, p, gain }, row, y, unit });
    }

    /// Lets a share of what was learnt of the spread go.
    pub fn forget(&mut self, share: f64, prior: impl Iterator<Item = f64>) {
        Shared.run(Fade { cells: &mut *self.p, left: 1.0 - share });
        let stride = self.gain.len();
        for (j, variance) in prior.enumerate() {
            let cell = &mut self.p[j * stride + j];
            *cell = (*cell + share * variance).min(variance);
        }
    }
}

/// A row that is learnt. Compiled for the instruction set at hand: P has thousands of entries.
struct Learn<'a, 'r> {
    regression: Regression<'a>,
    row: &'a Row<'r>,
    y: f64,
    unit: f64,
}

impl WithSimd for Learn<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { regression: Regression { theta, p, gain }, row, y, unit } = self;
        let stride = gain.len();
        let inverse = 1.0 / unit;
        gain.fill(0.0);
        for (j, entry) in row.each().filter(|(_, entry)| *entry != 0.0) {
            add(gain, entry * inverse, &p[j * stride..][..stride]);
        }
        let spread = row.dot(gain) * inverse;
        let certain = 1.0 / ((NOISE * NOISE).max(CAUTION * spread) + spread);
        let surprise = (y - row.dot(theta)) * inverse;
        add(theta, surprise * certain, gain);
        let root = sqrt(certain);
        gain.iter_mut().for_each(|g| *g = unless_tiny(*g * root));
        for (cells, share) in p.chunks_exact_mut(stride).zip(gain.iter()) {
            add(cells, -share, gain);
        }
    }
}

/// P, of which a share is left.
struct Fade<'a> {
    cells: &'a mut [f64],
    left: f64,
}

impl WithSimd for Fade<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.cells.iter_mut().for_each(|cell| *cell = unless_tiny(*cell * self.left));
    }
}

/// y ← y + ax.
#[inline(always)]
pub(super) fn add(y: &mut [f64], a: f64, x: &[f64]) {
    y.iter_mut().zip(x).for_each(|(y, x)| *y += a * x);
}

/// x, or 0 where it is too small to mean anything.
#[inline(always)]
pub(super) fn unless_tiny(x: f64) -> f64 {
    crate::math::unless_tiny(x, TINY)
}

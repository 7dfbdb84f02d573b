//! What a fuzzy compensator remembers: its weights, and what each stage of the current step recorded.

use crate::math::{Vector, sqrt};

/// Most stages of a step: seven of Dormand-Prince and one for its dense output.
pub const MAX_STAGES: usize = 8;

/// Memory for a [`FuzzyState`].
pub trait Buffer: AsRef<[f64]> + AsMut<[f64]> {}

impl<B: AsRef<[f64]> + AsMut<[f64]>> Buffer for B {}

/// Weights and scratch memory of a fuzzy compensator.
#[derive(Clone, Debug)]
pub struct FuzzyState<const N: usize, B> {
    /// W − W₀, W₀ if there is one, the evaluated basis of every stage, scratch.
    pub(super) buffer: B,
    /// Squared norms |Dₙ|² of the rows of W − W₀.
    pub(super) norms: Vector<N>,
    /// Whether W₀ is not zero.
    pub(in crate::control) prior: bool,
    pub(in crate::control) frozen: bool,
    /// Steps taken, to flush denormal weights once in a while.
    pub(in crate::control) advances: u64,
    pub(super) stages: Stages<N>,
}

impl<const N: usize, B: Buffer> FuzzyState<N, B> {
    pub(super) fn over(buffer: B) -> Self {
        let norms = Vector::zeros();
        Self { buffer, norms, prior: false, frozen: false, advances: 0, stages: Stages::default() }
    }

    /// Stops adaptation; the weights stay in use as they are.
    pub fn freeze(&mut self) {
        self.frozen = true;
    }

    /// Lets adaptation go on.
    pub fn unfreeze(&mut self) {
        self.frozen = false;
    }

    /// Whether adaptation is stopped.
    pub fn frozen(&self) -> bool {
        self.frozen
    }

    /// |W − W₀|, Frobenius; W₀ is zero but for a warm start.
    pub fn weights_norm(&self) -> f64 {
        sqrt(self.norms.sum())
    }

    /// |Dₙ|² for the weights of `mix`, which has terms of the stages before `count`.
    pub(super) fn norm_squared(&self, mix: &Mix, count: usize, n: usize) -> f64 {
        let mut sum = mix.keep * mix.keep * self.norms[n];
        for i in 0..count {
            let mut inner =
                2.0 * mix.keep * self.stages.own[i][n] + mix.terms[i] * self.stages.gram[i][i][n];
            for j in 0..i {
                inner += 2.0 * mix.terms[j] * self.stages.gram[i][j][n];
            }
            sum += mix.terms[i] * inner;
        }
        sum.max(0.0)
    }

    /// An upper bound of |Dₙ| for the weights of `mix`, where |ξ| is at most `xi_bound`.
    pub(super) fn norm_bound(&self, mix: &Mix, xi_bound: f64, n: usize) -> f64 {
        let terms: f64 = mix.terms.iter().map(|c| c.abs()).sum();
        mix.keep * sqrt(self.norms[n]) + terms * xi_bound
    }

    pub(super) fn clear(&mut self) {
        self.buffer.as_mut().fill(0.0);
        self.norms = Vector::zeros();
        self.prior = false;
        self.advances = 0;
    }
}

/// What each stage of the current step recorded.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stages<const N: usize> {
    /// (W(t) − W₀) ξ.
    pub own: [Vector<N>; MAX_STAGES],
    /// W₀ ξ.
    pub prior: [Vector<N>; MAX_STAGES],
    /// (W − W₀) ξ with the weights of the stage.
    pub learnt: [Vector<N>; MAX_STAGES],
    /// |Dₙ|² with the weights of the stage, where something needs it.
    pub norms: [Vector<N>; MAX_STAGES],
    /// m, drive m gain s, and pull rate kₙ.
    pub factor: [Vector<N>; MAX_STAGES],
    pub drive: [Vector<N>; MAX_STAGES],
    pub pull: [Vector<N>; MAX_STAGES],
    /// ξᵢ·ξⱼ of each joint's rules.
    pub gram: [[Vector<N>; MAX_STAGES]; MAX_STAGES],
    /// The weights of the stage, where a pull depends on the state.
    pub mixes: [[Mix; N]; MAX_STAGES],
}

impl<const N: usize> Default for Stages<N> {
    fn default() -> Self {
        let zeros = [Vector::zeros(); MAX_STAGES];
        Self {
            own: zeros,
            prior: zeros,
            learnt: zeros,
            norms: zeros,
            factor: zeros,
            drive: zeros,
            pull: zeros,
            gram: [zeros; MAX_STAGES],
            mixes: [[Mix::START; N]; MAX_STAGES],
        }
    }
}

/// A joint's weights at a stage: D = keep D(t) + Σ terms_j ξ_jᵀ.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mix {
    pub keep: f64,
    pub terms: [f64; MAX_STAGES],
}

impl Mix {
    pub const START: Self = Self { keep: 1.0, terms: [0.0; MAX_STAGES] };

    /// self ← factor · self.
    pub fn scale(&mut self, factor: f64) {
        self.keep *= factor;
        self.terms.iter_mut().for_each(|c| *c *= factor);
    }

    /// self ← self − factor · past, where `past` has terms of the stages before `count`.
    #[inline]
    pub fn subtract(&mut self, factor: f64, past: &Self, count: usize) {
        self.keep = (self.keep - factor * past.keep).max(0.0);
        for j in 0..count {
            self.terms[j] -= factor * past.terms[j];
        }
    }
}

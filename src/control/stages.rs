//! What the stages of one step record: a compensator's weights change by a sum of rank-one terms,
//! one per stage.

use super::Applied;
use crate::math::{Vector, sqrt};

/// Most stages of a step: seven of Dormand-Prince and one for its dense output. Without `std` there
/// are no integrators, and the state of a compensator has room for a sampled loop's one stage.
pub const MAX_STAGES: usize = if cfg!(feature = "std") { 8 } else { 1 };

/// Those of Runge and Kutta's method, by which alone runs go side by side.
#[cfg(feature = "std")]
pub(super) const STAGES: usize = 4;

/// The stage of the dense output, whose record is read between steps.
pub(super) const DENSE: usize = 7;

/// Of the stages but that one, and of the end of the step, which follows its last stage.
const MIXES: usize = if MAX_STAGES > 1 { MAX_STAGES } else { 2 };

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
    /// ξᵢ·ξⱼ of each joint's rules, j ≤ i, where it is known: bit j of `known[i]`.
    pub gram: [[Vector<N>; MAX_STAGES]; MAX_STAGES],
    pub known: [u8; MAX_STAGES],
    /// The weights of the stage, and those at the end of the step after its last stage.
    pub mixes: [Mix<N>; MIXES],
    /// Whether the projection changed those at the end of the last step.
    pub retracted: bool,
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
            known: [0; MAX_STAGES],
            mixes: [Mix { keep: Vector::zeros(), terms: zeros }; MIXES],
            retracted: false,
        }
    }
}

impl<const N: usize> Stages<N> {
    /// Nothing is learnt from a torque that was limited.
    #[inline]
    pub fn acted(&mut self, i: usize, applied: &Applied<N>) {
        if applied.limited() {
            self.hold(i);
        }
    }

    /// Nothing is learnt at stage i.
    pub fn hold(&mut self, i: usize) {
        self.factor[i] = Vector::zeros();
        self.drive[i] = Vector::zeros();
        self.pull[i] = Vector::zeros();
    }

    /// Makes stage `last`, at the end of the step, stage 0 of the next, whose weights have the
    /// squared norms `norms`.
    pub fn carry(&mut self, last: usize, norms: &Vector<N>) {
        self.own[0] = self.learnt[last];
        self.prior[0] = self.prior[last];
        self.learnt[0] = self.learnt[last];
        self.norms[0] = *norms;
        self.factor[0] = self.factor[last];
        self.drive[0] = self.drive[last];
        self.pull[0] = self.pull[last];
        self.gram[0][0] = self.gram[last][last];
        self.known[0] = self.known[last] >> last & 1;
    }

    /// |Dₙ|² for the weights of `mix`, a sum over the stages before `count`, from |Dₙ|² at the
    /// start of the step.
    pub fn norms_squared(&self, mix: &Mix<N>, count: usize, start: &Vector<N>) -> Vector<N> {
        let mut norms = mix.keep.component_mul(&mix.keep).component_mul(start);
        for n in 0..N {
            for i in 0..count {
                let mut inner =
                    2.0 * mix.keep[n] * self.own[i][n] + mix.terms[i][n] * self.gram[i][i][n];
                for j in 0..i {
                    inner += 2.0 * mix.terms[j][n] * self.gram[i][j][n];
                }
                norms[n] += mix.terms[i][n] * inner;
            }
            norms[n] = norms[n].max(0.0);
        }
        norms
    }
}

/// The weights at a stage: Dₙ = keepₙ Dₙ(t) + Σ terms_jn ξ_jᵀ over the stages j before it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mix<const N: usize> {
    pub keep: Vector<N>,
    pub terms: [Vector<N>; MAX_STAGES],
}

impl<const N: usize> Mix<N> {
    /// self ← factor · self.
    pub fn scale(&mut self, factor: f64) {
        self.keep *= factor;
        self.terms.iter_mut().for_each(|c| *c *= factor);
    }

    /// self ← self − factor · past, where `past` has terms of the stages before `count`.
    #[inline]
    pub fn subtract(&mut self, factor: &Vector<N>, past: &Self, count: usize) {
        for n in 0..N {
            self.keep[n] = (self.keep[n] - factor[n] * past.keep[n]).max(0.0);
        }
        for j in 0..count {
            self.terms[j] -= factor.component_mul(&past.terms[j]);
        }
    }

    /// An upper bound of Σₙ |Dₙ|, where |ξ| is at most `xi_bound`.
    #[inline]
    pub fn norm_bound(&self, count: usize, start: &Vector<N>, xi_bound: f64) -> f64 {
        let mut bound = 0.0;
        for n in 0..N {
            let terms: f64 = self.terms[..count].iter().map(|c| c[n].abs()).sum();
            bound += self.keep[n] * sqrt(start[n]) + terms * xi_bound;
        }
        bound
    }
}

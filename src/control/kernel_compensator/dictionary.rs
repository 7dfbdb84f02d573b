//! Terms into the dictionary: merged into the nearest atom, or an atom of their own; with |W|² and
//! the error bound.
//!
//! Whatever changes the coefficients of an atom a by δ changes `|Wₙ|²` by
//! `δₙ (2 Wₙξₐ + δₙ k(a, a))` and `Wₙξ` by `δₙ k(a, x)`, all of it known: the kernels of the atoms
//! with each other are kept.

use super::{KernelCompensator, KernelState, Places};
use crate::control::Buffer;
use crate::fuzzy::Nearest;
use crate::fuzzy::lanes::{Dot, flush};
use crate::math::{
    Runs, TINY_ESTIMATE, TINY_KERNEL, TINY_SQUARE, TINY_TERM, Vector, sqrt, unless_tiny,
};

/// Where k(x, x) is smaller, no rule fires: such a term is added to the error bound and makes no
/// atom.
pub(super) const SMALLEST_SIZE: f64 = TINY_KERNEL;

/// An atom's coefficient below this counts as zero: its square times the smallest size is normal.
const TINY_ATOM: f64 = 1e-90;

/// A scale below this goes into the coefficients.
const SMALLEST_SCALE: f64 = 1e-50;

/// A term c ξⱼ of a step of `count` stages.
struct Term<'a, const N: usize> {
    stage: usize,
    count: usize,
    coefficient: &'a Vector<N>,
    /// k(xⱼ, xⱼ).
    size: f64,
}

impl<const N: usize, T: Buffer> KernelCompensator<N, T> {
    /// W ← keep W + Σ cⱼ ξⱼᵀ over the stages before `count`.
    pub(super) fn write<B: Buffer>(
        &self,
        tasks: impl Runs,
        state: &mut KernelState<N, B>,
        count: usize,
    ) {
        for j in 0..count {
            (0..=j).for_each(|k| self.product(tasks, state, j, k));
        }
        let mix = state.stages.mixes[count];
        self.fade(state, count, &mix.keep);
        for (stage, coefficient) in mix.terms[..count].iter().enumerate() {
            let coefficient = &coefficient.map(|c| unless_tiny(c, TINY_TERM));
            if coefficient.iter().any(|c| *c != 0.0) {
                let size = state.stages.gram[stage][stage][0];
                self.add(tasks, state, &Term { stage, count, coefficient, size });
            }
        }
        state.norms.apply(|norm| *norm = unless_tiny(norm.max(0.0), TINY_SQUARE));
        let retraction = self.update.parameters.adaptation.retraction(state.norms.sum());
        if retraction != 1.0 {
            self.fade(state, 0, &Vector::repeat(retraction));
        }
    }

    /// W ← keep W.
    fn fade<B: Buffer>(&self, state: &mut KernelState<N, B>, count: usize, keep: &Vector<N>) {
        state.scale.component_mul_assign(keep);
        state.errors.component_mul_assign(keep);
        state.norms.component_mul_assign(&keep.component_mul(keep));
        state.errors.apply(|error| *error = unless_tiny(*error, TINY_SQUARE));
        state.norms.apply(|norm| *norm = unless_tiny(*norm, TINY_SQUARE));
        for own in &mut state.stages.own[..count] {
            own.component_mul_assign(keep);
            own.apply(|x| *x = unless_tiny(*x, TINY_ESTIMATE));
        }
        let Places { row, coefficients, .. } = self.places;
        for n in 0..N {
            let scale = state.scale[n];
            if scale < SMALLEST_SCALE {
                let own = &mut state.memory.as_mut_slice()[coefficients + n * row..][..row];
                own.iter_mut().for_each(|c| *c *= scale);
                flush(own);
                state.scale[n] = 1.0;
            }
        }
    }

    fn add<B: Buffer>(&self, tasks: impl Runs, state: &mut KernelState<N, B>, term: &Term<'_, N>) {
        let Places { row, inverses, kernels, .. } = self.places;
        let (used, length) = (Self::used_row(state.atoms), sqrt(term.size));
        if term.size < SMALLEST_SIZE {
            state.errors += term.coefficient.abs() * length;
            return;
        }
        let memory = state.memory.as_slice();
        let own = &memory[kernels + term.stage * row..][..used];
        let inverses_of = &memory[inverses..][..used];
        let (atom, ratio) = tasks.run(Nearest { kernels: own, inverses: inverses_of });
        let lost = (1.0 - ratio / term.size).max(0.0) + self.basis.rounding();
        if lost < self.kernel.merge_tolerance * self.kernel.merge_tolerance {
            let delta = term.coefficient * (own[atom] * memory[inverses + atom]);
            state.errors += term.coefficient.abs() * (length * sqrt(lost));
            state.merged += 1;
            self.change(tasks, state, atom, &delta, (term.stage + 1, term.count));
            return;
        }
        let atom = if state.atoms < self.kernel.capacity {
            state.atoms += 1;
            state.atoms - 1
        } else {
            self.drop_least(tasks, state, term)
        };
        self.insert(state, atom, term);
    }

    /// Adds δ to the coefficients of an atom; the stages in `pending` follow.
    fn change<B: Buffer>(
        &self,
        tasks: impl Runs,
        state: &mut KernelState<N, B>,
        atom: usize,
        delta: &Vector<N>,
        pending: (usize, usize),
    ) {
        let Places { row, coefficients, gram, gram_row, sizes, kernels, .. } = self.places;
        let used = Self::used_row(state.atoms);
        let memory = state.memory.as_mut_slice();
        let size = memory[sizes + atom];
        for n in 0..N {
            let place = coefficients + n * row;
            let (left, right) = (&memory[place..], &memory[gram + atom * gram_row..]);
            let along = tasks.run(Dot { left: &left[..used], right: &right[..used] });
            state.norms[n] += delta[n] * (2.0 * state.scale[n] * along + delta[n] * size);
            memory[place + atom] += delta[n] / state.scale[n];
        }
        for i in pending.0..pending.1 {
            state.stages.own[i] += delta * memory[kernels + i * row + atom];
        }
    }

    /// Makes a term an atom, in a free slot.
    fn insert<B: Buffer>(&self, state: &mut KernelState<N, B>, atom: usize, term: &Term<'_, N>) {
        let Places {
            row,
            coefficients,
            gram,
            gram_row,
            sizes,
            inverses,
            kernels,
            stages,
            stage,
            ..
        } = self.places;
        let Term { stage: j, count, coefficient, size } = *term;
        let (atoms, used) = (state.atoms, Self::used_row(state.atoms));
        let memory = state.memory.as_mut_slice();
        let own = kernels + j * row;
        memory[own + atom] = size;
        memory.copy_within(own..own + used, gram + atom * gram_row);
        for k in 0..atoms {
            memory[gram + k * gram_row + atom] = memory[own + k];
        }
        memory[sizes + atom] = size;
        memory[inverses + atom] = 1.0 / size;
        let (dictionary, rest) = memory.split_at_mut(stages);
        self.basis.write_atom(dictionary, atom, &rest[j * stage..][..stage]);
        for n in 0..N {
            let c = coefficient[n];
            state.norms[n] += c * (2.0 * state.stages.own[j][n] + c * size);
            memory[coefficients + n * row + atom] = c / state.scale[n];
        }
        for i in j + 1..count {
            let k = state.stages.gram[i][j][0];
            memory[kernels + i * row + atom] = k;
            state.stages.own[i] += coefficient * k;
        }
    }

    /// Drops the atom with the smallest |c_k|² k(x_k, x_k); returns its place.
    fn drop_least<B: Buffer>(
        &self,
        tasks: impl Runs,
        state: &mut KernelState<N, B>,
        term: &Term<'_, N>,
    ) -> usize {
        let Places { row, coefficients, sizes, stages, .. } = self.places;
        let (atoms, scale) = (state.atoms, state.scale);
        let (rest, squares) = state.memory.as_mut_slice()[..stages].split_at_mut(stages - row);
        squares.fill(0.0);
        for n in 0..N {
            for (square, c) in squares.iter_mut().zip(&rest[coefficients + n * row..]) {
                let c = unless_tiny(scale[n] * c, TINY_ATOM);
                *square += c * c;
            }
        }
        let mut least = (0, f64::INFINITY);
        for (atom, (square, size)) in squares[..atoms].iter().zip(&rest[sizes..]).enumerate() {
            if square * size < least.1 {
                least = (atom, square * size);
            }
        }
        let (atom, length) = (least.0, sqrt(rest[sizes + least.0]));
        let coefficient = self.coefficient(state, atom);
        state.errors += coefficient.abs() * length;
        state.dropped += 1;
        self.change(tasks, state, atom, &-coefficient, (term.stage, term.count));
        atom
    }

    /// c_k of an atom.
    #[inline]
    pub(super) fn coefficient<B: Buffer>(
        &self,
        state: &KernelState<N, B>,
        atom: usize,
    ) -> Vector<N> {
        let Places { row, coefficients, .. } = self.places;
        let memory = state.memory.as_slice();
        let of = |n: usize| state.scale[n] * memory[coefficients + n * row + atom];
        Vector::from_fn(|n, _| unless_tiny(of(n), TINY_ATOM))
    }
}

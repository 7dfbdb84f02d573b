//! A step over weights that are written out: `Wξ = W₀ξ + keep Dξ + Σ cⱼ (ξⱼ·ξ)`, with the law of
//! every stage in between.

use pulp::{Arch, Simd, WithSimd};

use super::{FuzzyCompensator, FuzzyState, Places};
use crate::control::{Applied, Audit, Buffer, Compensator, MAX_STAGES, Sample, Stage};
use crate::error::Result;
use crate::fuzzy::lanes::{accumulate, contract, flush};
use crate::math::Vector;

/// Denormal weights are looked for once in so many steps.
const FLUSH_EVERY: u64 = 256;

impl<const N: usize, B: Buffer> Compensator<N, FuzzyState<N, B>> for FuzzyCompensator<N> {
    fn estimate(
        &self,
        state: &mut FuzzyState<N, B>,
        stage: &Stage<'_>,
        sample: &Sample<N>,
    ) -> Vector<N> {
        Arch::new().dispatch(Estimate { compensator: self, state, stage, sample })
    }

    #[inline]
    fn acted(
        &self,
        state: &mut FuzzyState<N, B>,
        index: usize,
        _: &Sample<N>,
        applied: &Applied<N>,
    ) {
        state.stages.acted(index, applied);
    }

    fn advance(&self, state: &mut FuzzyState<N, B>, end: &Stage<'_>) -> Result<()> {
        state.stages.retracted = false;
        if state.frozen {
            return Ok(());
        }
        let count = end.index;
        let stages = &mut state.stages;
        self.update.finish(stages, &state.norms, end, self.basis.xi_bound())?;
        let adaptation = &self.update.parameters.adaptation;
        if adaptation.projection_radius.is_finite() {
            let mix = stages.mixes[count];
            let norms = stages.norms_squared(&mix, count, &state.norms);
            let retraction = adaptation.retraction(norms.sum());
            stages.mixes[count].scale(retraction);
            stages.retracted = retraction != 1.0;
        }
        Arch::new().dispatch(WriteWeights { compensator: self, state, count });
        Ok(())
    }

    fn carry(&self, state: &mut FuzzyState<N, B>, last: usize) -> bool {
        if state.stages.retracted {
            return false;
        }
        let Places { stages, stage, .. } = self.places;
        let activations = &mut state.memory.as_mut_slice()[stages..];
        activations.copy_within(last * stage..(last + 1) * stage, 0);
        state.stages.carry(last, &state.norms);
        true
    }

    fn reset(&self, state: &mut FuzzyState<N, B>) {
        state.clear();
        state.unfreeze();
    }

    #[inline(always)]
    fn audit(&self, state: &FuzzyState<N, B>, i: usize, sample: &Sample<N>) -> Option<Audit<N>> {
        Some(self.update.audit(&state.stages, i, sample, state.frozen))
    }
}

/// A stage, compiled as a whole for the instruction set at hand.
struct Estimate<'a, const N: usize, B: Buffer> {
    compensator: &'a FuzzyCompensator<N>,
    state: &'a mut FuzzyState<N, B>,
    stage: &'a Stage<'a>,
    sample: &'a Sample<N>,
}

impl<const N: usize, B: Buffer> WithSimd for Estimate<'_, N, B> {
    type Output = Vector<N>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Vector<N> {
        let Self { compensator, state, stage, sample } = self;
        let i = stage.index;
        compensator.activate(simd, state, i, sample);
        compensator.correlate(simd, state, stage);
        let (update, frozen) = (&compensator.update, state.frozen);
        update.mix(&mut state.stages, stage, update.leak_rate(frozen));
        compensator.contract(simd, state, i);
        update.learn(&mut state.stages, &state.norms, i, sample, frozen);
        state.stages.prior[i] + state.stages.learnt[i]
    }
}

struct WriteWeights<'a, const N: usize, B: Buffer> {
    compensator: &'a FuzzyCompensator<N>,
    state: &'a mut FuzzyState<N, B>,
    count: usize,
}

impl<const N: usize, B: Buffer> WithSimd for WriteWeights<'_, N, B> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.compensator.write_weights(simd, self.state, self.count);
    }
}

impl<const N: usize> FuzzyCompensator<N> {
    /// Evaluates the basis into the place of stage i.
    #[inline(always)]
    fn activate<S: Simd, B: Buffer>(
        &self,
        simd: S,
        state: &mut FuzzyState<N, B>,
        i: usize,
        sample: &Sample<N>,
    ) {
        let Places { stages, stage, x, scratch, .. } = self.places;
        let memory = state.memory.as_mut_slice();
        let (activations, rest) = memory[stages..].split_at_mut(x - stages);
        let (x, scratch) = rest.split_at_mut(scratch - x);
        self.update.parameters.inputs.gather(sample, x);
        self.basis.activate(simd, x, scratch, &mut activations[i * stage..(i + 1) * stage]);
        state.stages.known[i] = 0;
    }

    /// The products of both weight matrices with the basis of stage i.
    #[inline(always)]
    fn contract<S: Simd, B: Buffer>(&self, simd: S, state: &mut FuzzyState<N, B>, i: usize) {
        let memory = state.memory.as_slice();
        let activation = self.activation(memory, i);
        self.products(simd, memory, activation, &mut state.stages.own[i]);
        if state.prior {
            self.products(
                simd,
                &memory[self.places.matrix..],
                activation,
                &mut state.stages.prior[i],
            );
        }
    }

    #[inline(always)]
    fn products<S: Simd>(&self, simd: S, memory: &[f64], activation: &[f64], out: &mut Vector<N>) {
        let (dyads, len) = (self.basis.dyads(), self.basis.row_len());
        let row = |n: usize| &memory[n * len..(n + 1) * len];
        let mut products = Vector::<N>::zeros();
        let (together, mut n) = (self.basis.blocks() == 1, 0);
        while n < N {
            let xi = self.basis.block(activation, self.block_of(n));
            if together && n + 1 < N {
                [products[n], products[n + 1]] = contract(simd, [row(n), row(n + 1)], dyads, xi);
                n += 2;
            } else {
                [products[n]] = contract(simd, [row(n)], dyads, xi);
                n += 1;
            }
        }
        *out = products;
    }

    /// ξᵢ·ξⱼ with itself and with every earlier stage, where the law or a record needs it.
    #[inline(always)]
    fn correlate<S: Simd, B: Buffer>(
        &self,
        simd: S,
        state: &mut FuzzyState<N, B>,
        stage: &Stage<'_>,
    ) {
        let i = stage.index;
        if self.update.needs_norms(i) {
            for j in 0..=i {
                self.products_with(simd, state, j, |_| true);
            }
        } else {
            let squared = self.update.parameters.adaptation.normalization > 0.0;
            let used = |j: usize| stage.coefficients.get(j).map_or(squared, |a| *a != 0.0);
            self.products_with(simd, state, i, used);
        }
    }

    /// ξᵢ·ξⱼ for the stages j ≤ i that are `used`, unless it is known.
    #[inline(always)]
    fn products_with<S: Simd, B: Buffer>(
        &self,
        simd: S,
        state: &mut FuzzyState<N, B>,
        i: usize,
        used: impl Fn(usize) -> bool,
    ) {
        let Places { stages, stage, .. } = self.places;
        let activations = &state.memory.as_slice()[stages..][..(i + 1) * stage];
        let own = self.slot(activations, i);
        let mut known = state.stages.known[i];
        for (j, gram) in state.stages.gram[i][..=i].iter_mut().enumerate() {
            if known >> j & 1 == 0 && used(j) {
                self.basis.dots(simd, own, self.slot(activations, j), gram.as_mut_slice());
                known |= 1 << j;
            }
        }
        state.stages.known[i] = known;
    }

    /// D ← keep D + Σ cⱼ ξⱼᵀ over the stages before `count`, row by row.
    #[inline(always)]
    fn write_weights<S: Simd, B: Buffer>(
        &self,
        simd: S,
        state: &mut FuzzyState<N, B>,
        count: usize,
    ) {
        let Places { matrix, stages, .. } = self.places;
        let (weights, rest) = state.memory.as_mut_slice().split_at_mut(matrix);
        let activations = &rest[stages - matrix..];
        let mix = &state.stages.mixes[count];
        let (mut stages, mut terms) = ([0; MAX_STAGES], [&[][..]; MAX_STAGES]);
        let mut used = 0;
        for j in 0..count {
            if mix.terms[j].iter().any(|c| *c != 0.0) {
                (stages[used], terms[used]) = (j, self.basis.block(self.slot(activations, j), 0));
                used += 1;
            }
        }
        let (stages, terms) = (&stages[..used], &mut terms[..used]);
        let mut rest = &mut weights[..];
        for n in 0..N {
            let (row, others) = rest.split_at_mut(self.basis.row_len());
            let mut coefficients = [0.0; MAX_STAGES];
            for (k, &j) in stages.iter().enumerate() {
                coefficients[k] = mix.terms[j][n];
                if self.block_of(n) > 0 {
                    terms[k] = self.basis.block(self.slot(activations, j), n);
                }
            }
            if used > 0 || mix.keep[n] != 1.0 {
                let coefficients = &coefficients[..used];
                state.norms[n] =
                    accumulate(simd, row, mix.keep[n], self.basis.dyads(), coefficients, terms);
            }
            rest = others;
        }
        state.advances += 1;
        if state.advances.is_multiple_of(FLUSH_EVERY) {
            flush(weights);
        }
    }

    /// The evaluated basis of stage i.
    #[inline]
    fn activation<'a>(&self, memory: &'a [f64], i: usize) -> &'a [f64] {
        self.slot(&memory[self.places.stages..], i)
    }

    #[inline]
    fn slot<'a>(&self, activations: &'a [f64], i: usize) -> &'a [f64] {
        &activations[i * self.places.stage..][..self.places.stage]
    }
}

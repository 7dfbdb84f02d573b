//! A step over weights that are written out: `Wξ = W₀ξ + keep Dξ + Σ cⱼ (ξⱼ·ξ)`, with the law of
//! every stage in between.

use pulp::{Arch, Simd, WithSimd};

use super::tasks::{Dots, Products, WriteRows};
use super::{FuzzyCompensator, FuzzyState, Places};
use crate::control::{Applied, Audit, Buffer, Compensator, Learns, MAX_STAGES, Sample, Stage};
use crate::error::Result;
use crate::fuzzy::Activate;
use crate::fuzzy::lanes::{FLUSH_EVERY, flush};
use crate::math::{Runs, Shared, Vector, WHOLE};

impl<const N: usize, T: Buffer, B: Buffer> Compensator<N, FuzzyState<N, B>>
    for FuzzyCompensator<N, T>
{
    fn estimate(
        &self,
        state: &mut FuzzyState<N, B>,
        stage: &Stage<'_>,
        sample: &Sample<N>,
    ) -> Vector<N> {
        let task = Estimate { compensator: self, state, stage, sample };
        if N <= WHOLE { Arch::new().dispatch(task) } else { task.with(Shared) }
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

    #[inline]
    fn admit(&self, state: &FuzzyState<N, B>, sample: &Sample<N>, dt: f64) -> Result<()> {
        if state.frozen {
            return Ok(());
        }
        self.update.admit(&state.norms, sample, dt)
    }

    fn advance(&self, state: &mut FuzzyState<N, B>, end: &Stage<'_>) -> Result<()> {
        state.stages.retracted = false;
        if state.frozen {
            return Ok(());
        }
        let count = end.index;
        let stages = &mut state.stages;
        self.update.finish(stages, &state.norms, end)?;
        let adaptation = &self.update.parameters.adaptation;
        if adaptation.projection_radius.is_finite() {
            let mix = stages.mixes[count];
            let norms = stages.norms_squared(&mix, count, &state.norms);
            let retraction = adaptation.retraction(norms.sum());
            stages.mixes[count].scale(retraction);
            stages.retracted = retraction != 1.0;
        }
        let task = WriteWeights { compensator: self, state, count };
        if N <= WHOLE {
            Arch::new().dispatch(task)
        } else {
            task.with(Shared)
        }
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

    fn learns<'a>(&'a self, state: &'a FuzzyState<N, B>) -> Option<Learns<'a, N>> {
        self.per_joint_side(state)
    }

    #[inline(always)]
    fn audit(&self, state: &FuzzyState<N, B>, i: usize, sample: &Sample<N>) -> Option<Audit<N>> {
        Some(self.update.audit(&state.stages, i, sample, state.frozen))
    }
}

/// A stage.
struct Estimate<'a, const N: usize, T: Buffer, B: Buffer> {
    compensator: &'a FuzzyCompensator<N, T>,
    state: &'a mut FuzzyState<N, B>,
    stage: &'a Stage<'a>,
    sample: &'a Sample<N>,
}

impl<const N: usize, T: Buffer, B: Buffer> Estimate<'_, N, T, B> {
    #[inline(always)]
    fn with(self, tasks: impl Runs) -> Vector<N> {
        let Self { compensator, state, stage, sample } = self;
        let i = stage.index;
        compensator.activate(tasks, state, i, sample);
        compensator.correlate(tasks, state, stage);
        let (update, frozen) = (&compensator.update, state.frozen);
        update.mix(&mut state.stages, stage, update.leak_rate(frozen));
        compensator.contract(tasks, state, i);
        update.learn(&mut state.stages, &state.norms, i, sample, frozen);
        state.stages.prior[i] + state.stages.learnt[i]
    }
}

impl<const N: usize, T: Buffer, B: Buffer> WithSimd for Estimate<'_, N, T, B> {
    type Output = Vector<N>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Vector<N> {
        self.with(simd)
    }
}

/// The end of a step.
struct WriteWeights<'a, const N: usize, T: Buffer, B: Buffer> {
    compensator: &'a FuzzyCompensator<N, T>,
    state: &'a mut FuzzyState<N, B>,
    count: usize,
}

impl<const N: usize, T: Buffer, B: Buffer> WriteWeights<'_, N, T, B> {
    #[inline(always)]
    fn with(self, tasks: impl Runs) {
        self.compensator.write_weights(tasks, self.state, self.count);
    }
}

impl<const N: usize, T: Buffer, B: Buffer> WithSimd for WriteWeights<'_, N, T, B> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.with(simd);
    }
}

impl<const N: usize, T: Buffer> FuzzyCompensator<N, T> {
    /// Evaluates the basis into the place of stage i.
    #[inline(always)]
    fn activate<B: Buffer>(
        &self,
        tasks: impl Runs,
        state: &mut FuzzyState<N, B>,
        i: usize,
        sample: &Sample<N>,
    ) {
        let Places { stages, stage, x, scratch, .. } = self.places;
        let memory = state.memory.as_mut_slice();
        let (activations, rest) = memory[stages..].split_at_mut(x - stages);
        let (x, scratch) = rest.split_at_mut(scratch - x);
        self.update.parameters.inputs.gather(sample, x);
        let activation = &mut activations[i * stage..(i + 1) * stage];
        tasks.run(Activate { basis: &self.basis, x, scratch, activation });
        state.stages.known[i] = 0;
    }

    /// The products of both weight matrices with the basis of stage i.
    #[inline(always)]
    fn contract<B: Buffer>(&self, tasks: impl Runs, state: &mut FuzzyState<N, B>, i: usize) {
        let FuzzyState { memory, stages, prior, .. } = state;
        let memory = memory.as_slice();
        let (basis, activation) = (&self.basis, self.activation(memory, i));
        let out = stages.own[i].as_mut_slice();
        tasks.run(Products { basis, matrix: memory, activation, out });
        if *prior {
            let (matrix, out) = (&memory[self.places.matrix..], stages.prior[i].as_mut_slice());
            tasks.run(Products { basis, matrix, activation, out });
        }
    }

    /// ξᵢ·ξⱼ with itself and with every earlier stage, where the law or a record needs it.
    #[inline(always)]
    fn correlate<B: Buffer>(
        &self,
        tasks: impl Runs,
        state: &mut FuzzyState<N, B>,
        stage: &Stage<'_>,
    ) {
        let i = stage.index;
        if self.update.needs_norms(i) {
            for j in 0..=i {
                self.products_with(tasks, state, j, |_| true);
            }
        } else {
            let squared = self.update.parameters.adaptation.normalization > 0.0;
            let used = |j: usize| stage.coefficients.get(j).map_or(squared, |a| *a != 0.0);
            self.products_with(tasks, state, i, used);
        }
    }

    /// ξᵢ·ξⱼ for the stages j ≤ i that are `used`, unless it is known.
    #[inline(always)]
    fn products_with<B: Buffer>(
        &self,
        tasks: impl Runs,
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
                let activations = [own, self.slot(activations, j)];
                tasks.run(Dots { basis: &self.basis, activations, out: gram.as_mut_slice() });
                known |= 1 << j;
            }
        }
        state.stages.known[i] = known;
    }

    /// D ← keep D + Σ cⱼ ξⱼᵀ over the stages before `count`, row by row.
    #[inline(always)]
    fn write_weights<B: Buffer>(
        &self,
        tasks: impl Runs,
        state: &mut FuzzyState<N, B>,
        count: usize,
    ) {
        let Places { matrix, stages, .. } = self.places;
        let (weights, rest) = state.memory.as_mut_slice().split_at_mut(matrix);
        let slots = &rest[stages - matrix..];
        let mix = &state.stages.mixes[count];
        let (mut coefficients, mut activations) = ([&[][..]; MAX_STAGES], [&[][..]; MAX_STAGES]);
        let mut used = 0;
        for j in 0..count {
            if mix.terms[j].iter().any(|c| *c != 0.0) {
                coefficients[used] = mix.terms[j].as_slice();
                activations[used] = self.slot(slots, j);
                used += 1;
            }
        }
        tasks.run(WriteRows {
            basis: &self.basis,
            weights: &mut *weights,
            norms: state.norms.as_mut_slice(),
            keep: mix.keep.as_slice(),
            coefficients: &coefficients[..used],
            activations: &activations[..used],
        });
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

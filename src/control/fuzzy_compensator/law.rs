//! The adaptive law, stage by stage: `Wξ = W₀ξ + keep Dξ + Σ cⱼ (ξⱼ·ξ)`, `Ẇ = drive ξᵀ − pull D`.

use pulp::{Arch, Simd, WithSimd};

use super::state::{MAX_STAGES, Stages};
use super::{Buffer, FuzzyCompensator, FuzzyState, MAX_WEIGHT, Places};
use crate::control::{Audit, Compensator, Sample, Stage};
use crate::error::{Error, Result};
use crate::fuzzy::kernels::{Term, accumulate, contract, flush};
use crate::math::{Vector, exp, sqrt};

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

    fn hold(&self, state: &mut FuzzyState<N, B>, index: usize) {
        state.stages.factor[index] = Vector::zeros();
        state.stages.drive[index] = Vector::zeros();
        state.stages.pull[index] = Vector::zeros();
    }

    fn advance(&self, state: &mut FuzzyState<N, B>, end: &Stage<'_>) -> Result<()> {
        if state.frozen {
            return Ok(());
        }
        let count = end.index;
        self.mix(state, end);
        let mix = &mut state.stages.mixes[count];
        let bound = mix.norm_bound(count, &state.norms, self.basis.xi_bound());
        if bound > MAX_WEIGHT || bound.is_nan() {
            let wanted = "weights of at most 1e150; lower the gain";
            return Err(Error::OutOfRange {
                parameter: "weights",
                index: None,
                got: bound,
                wanted,
            });
        }
        if self.parameters.adaptation.projection_radius.is_finite() {
            let mix = state.stages.mixes[count];
            let norms = state.stages.norms_squared(&mix, count, &state.norms);
            let retraction = self.parameters.adaptation.retraction(norms.sum());
            state.stages.mixes[count].scale(retraction);
            state.stages.retracted = retraction != 1.0;
        }
        Arch::new().dispatch(WriteWeights { compensator: self, state, count });
        Ok(())
    }

    fn carry(&self, state: &mut FuzzyState<N, B>, last: usize) -> bool {
        let Places { stages, stage, .. } = self.places;
        let activations = &mut state.buffer.as_mut()[state.offset + stages..];
        activations.copy_within(last * stage..(last + 1) * stage, 0);
        state.stages.carry(last, &state.norms)
    }

    fn reset(&self, state: &mut FuzzyState<N, B>) {
        state.clear();
    }

    #[inline(always)]
    fn audit(&self, state: &FuzzyState<N, B>, i: usize, sample: &Sample<N>) -> Option<Audit<N>> {
        let stages = &state.stages;
        let s = self.s(sample);
        let leak = self.leak_rate(state);
        let inverse_gamma = 1.0 / self.parameters.gamma;
        let mut audit = Audit {
            value: 0.0,
            state_cost: 0.0,
            s,
            prior: stages.prior[i],
            loss: 0.0,
            gamma: self.parameters.gamma,
            weights_norm: 0.0,
        };
        for n in 0..N {
            let (e, de, p) = (sample.e[n], sample.de[n], &self.p[n]);
            let stored = stages.norms[i][n] / self.parameters.adaptation.gain[n];
            let pulled = (leak + stages.pull[i][n]) * stored;
            let withheld = (1.0 - stages.factor[i][n]) * s[n] * stages.learnt[i][n];
            audit.value += (p.p11 * e + 2.0 * p.p12 * de) * e + p.p22 * de * de + stored;
            audit.state_cost +=
                self.parameters.q_position[n] * e * e + self.parameters.q_velocity[n] * de * de;
            audit.loss += inverse_gamma * inverse_gamma * s[n] * s[n]
                + 2.0 * (s[n] * stages.prior[i][n] + withheld + pulled);
        }
        audit.loss += audit.state_cost;
        audit.weights_norm = sqrt(stages.norms[i].sum());
        Some(audit)
    }
}

/// A stage, compiled as a whole for the instruction set at hand.
struct Estimate<'a, const N: usize, B> {
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
        compensator.contract(simd, state, i);
        compensator.correlate(simd, state, stage);
        compensator.mix(state, stage);
        compensator.learn(state, i, &compensator.s(sample));
        state.stages.prior[i] + state.stages.learnt[i]
    }
}

struct WriteWeights<'a, const N: usize, B> {
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
        let memory = &mut state.buffer.as_mut()[state.offset..];
        let (activations, rest) = memory[stages..].split_at_mut(x - stages);
        let (x, scratch) = rest.split_at_mut(scratch - x);
        self.parameters.inputs.gather(sample, x);
        self.basis.activate(simd, x, scratch, &mut activations[i * stage..(i + 1) * stage]);
        state.stages.known[i] = 0;
    }

    /// The products of both weight matrices with the basis of stage i.
    #[inline(always)]
    fn contract<S: Simd, B: Buffer>(&self, simd: S, state: &mut FuzzyState<N, B>, i: usize) {
        let memory = &state.buffer.as_ref()[state.offset..];
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
        let (weights, out) = (&memory[..self.places.matrix], out.as_mut_slice());
        if self.basis.blocks() == 1 {
            let xi = self.basis.block(activation, 0);
            return contract(simd, weights, (xi.u, xi.v), out);
        }
        let rows = weights.chunks_exact(self.basis.row_len());
        for (n, (row, out)) in rows.zip(out.chunks_exact_mut(1)).enumerate() {
            let xi = self.basis.block(activation, n);
            contract(simd, row, (xi.u, xi.v), out);
        }
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
        if self.needs_norms(i) {
            for j in 0..=i {
                for k in 0..=j {
                    self.product(simd, state, j, k);
                }
            }
            return;
        }
        for (j, a) in stage.coefficients.iter().enumerate() {
            if *a != 0.0 {
                self.product(simd, state, i, j);
            }
        }
        if self.parameters.adaptation.normalization > 0.0 {
            self.product(simd, state, i, i);
        }
    }

    /// Whether the size of the weights matters at stage i: to the law, or to a record between steps.
    #[inline]
    fn needs_norms(&self, i: usize) -> bool {
        i == MAX_STAGES - 1 || self.parameters.adaptation.pulls()
    }

    /// ξᵢ·ξⱼ, unless it is known.
    #[inline(always)]
    fn product<S: Simd, B: Buffer>(
        &self,
        simd: S,
        state: &mut FuzzyState<N, B>,
        i: usize,
        j: usize,
    ) {
        let memory = &state.buffer.as_ref()[state.offset..];
        let stages = &mut state.stages;
        if stages.known[i] >> j & 1 != 0 {
            return;
        }
        let (left, right) = (self.activation(memory, i), self.activation(memory, j));
        let mut gram = Vector::repeat(self.basis.dot(simd, left, right, 0));
        for n in 1..self.basis.blocks() {
            gram[n] = self.basis.dot(simd, left, right, n);
        }
        stages.gram[i][j] = gram;
        stages.known[i] |= 1 << j;
    }

    /// (W − W₀)ξ at the stage, and the rates of the law there.
    #[inline(always)]
    fn learn<B: Buffer>(&self, state: &mut FuzzyState<N, B>, i: usize, s: &Vector<N>) {
        let stages = &mut state.stages;
        let mix = &stages.mixes[i];
        let mut learnt = mix.keep.component_mul(&stages.own[i]);
        for (j, terms) in mix.terms[..i].iter().enumerate() {
            if stages.known[i] >> j & 1 != 0 {
                learnt += terms.component_mul(&stages.gram[i][j]);
            }
        }
        stages.learnt[i] = learnt;
        if i == 0 || self.needs_norms(i) {
            stages.norms[i] = stages.norms_squared(mix, i, &state.norms);
        }
        self.record_rates(state, i, s);
    }

    #[inline(always)]
    fn record_rates<B: Buffer>(&self, state: &mut FuzzyState<N, B>, i: usize, s: &Vector<N>) {
        if state.frozen {
            return self.hold(state, i);
        }
        let adaptation = &self.parameters.adaptation;
        let stages = &mut state.stages;
        let s_norm = sqrt(s.norm_squared());
        for n in 0..N {
            stages.factor[i][n] = adaptation.drive_factor(s_norm, stages.gram[i][i][n]);
            stages.drive[i][n] = stages.factor[i][n] * adaptation.gain[n] * s[n];
        }
        if adaptation.pulls_by_state() {
            let growth = stages.drive[i].dot(&stages.learnt[i]);
            let pull = adaptation.pull(s_norm, &stages.norms[i], growth);
            stages.pull[i] = Vector::from_fn(|n, _| adaptation.gain[n] * pull);
        }
    }

    /// The weights of every joint at a stage, in terms of those at the start of the step.
    #[inline(always)]
    fn mix<B: Buffer>(&self, state: &mut FuzzyState<N, B>, stage: &Stage<'_>) {
        let leak = self.leak_rate(state) * stage.step;
        let fade = |from: f64| if leak == 0.0 { 1.0 } else { exp(-leak * (stage.node - from)) };
        let Stages { drive, pull, mixes, .. } = &mut state.stages;
        let (past, rest) = mixes.split_at_mut(stage.index);
        let mix = &mut rest[0];
        mix.keep = Vector::repeat(fade(0.0));
        for (j, (a, &node)) in stage.coefficients.iter().zip(stage.nodes).enumerate() {
            let weight = if *a == 0.0 { 0.0 } else { stage.step * a * fade(node) };
            mix.terms[j] = drive[j] * weight;
            if self.parameters.adaptation.pulls_by_state() {
                mix.subtract(&(pull[j] * weight), &past[j], j);
            }
        }
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
        let (weights, rest) = state.buffer.as_mut()[state.offset..].split_at_mut(matrix);
        let activations = &rest[stages - matrix..];
        let mix = &state.stages.mixes[count];
        for (n, row) in weights.chunks_exact_mut(self.basis.row_len()).enumerate() {
            let mut terms = [Term { coefficient: 0.0, u: &[], v: &[] }; MAX_STAGES];
            let mut used = 0;
            for j in (0..count).filter(|&j| mix.terms[j][n] != 0.0) {
                let xi = self.basis.block(self.slot(activations, j), self.block_of(n));
                terms[used] = Term { coefficient: mix.terms[j][n], u: xi.u, v: xi.v };
                used += 1;
            }
            if used > 0 || mix.keep[n] != 1.0 {
                state.norms[n] = accumulate(simd, row, mix.keep[n], &terms[..used]);
            }
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
        &activations[i * self.places.stage..(i + 1) * self.places.stage]
    }

    #[inline]
    fn leak_rate<B: Buffer>(&self, state: &FuzzyState<N, B>) -> f64 {
        if state.frozen { 0.0 } else { self.parameters.adaptation.leak_rate }
    }
}

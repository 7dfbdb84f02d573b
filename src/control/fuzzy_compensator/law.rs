//! The adaptive law, stage by stage: `Wξ = W₀ξ + keep Dξ + Σ cⱼ (ξⱼ·ξ)`, `Ẇ = drive ξᵀ − pull D`.

use super::state::{MAX_STAGES, Mix};
use super::{Buffer, FuzzyCompensator, FuzzyState, MAX_WEIGHT};
use crate::control::{Audit, Compensator, Sample, Stage};
use crate::error::{Error, Result};
use crate::fuzzy::FuzzyBasis;
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
        let i = stage.index;
        self.activate(state, i, sample);
        self.contract(state, i);
        self.correlate(state, stage);
        self.learn(state, stage, &self.s(sample));
        state.stages.prior[i] + state.stages.learnt[i]
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
        let mut mixes = self.mixes(state, end);
        let joints = || mixes.iter().enumerate();
        let bound: f64 =
            joints().map(|(n, mix)| state.norm_bound(mix, self.basis.xi_bound(), n)).sum();
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
            let norm = joints().map(|(n, mix)| state.norm_squared(mix, end.index, n)).sum();
            let retraction = self.parameters.adaptation.retraction(norm);
            mixes.iter_mut().for_each(|mix| mix.scale(retraction));
        }
        self.write_weights(state, &mixes, end.index);
        Ok(())
    }

    fn reset(&self, state: &mut FuzzyState<N, B>) {
        state.clear();
    }

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

impl<const N: usize> FuzzyCompensator<N> {
    /// Evaluates the basis into the place of stage i.
    #[inline]
    fn activate<B: Buffer>(&self, state: &mut FuzzyState<N, B>, i: usize, sample: &Sample<N>) {
        let (_, rest) = state.buffer.as_mut().split_at_mut(self.matrices() * self.matrix_len());
        let length = self.basis.activation_len();
        let (activations, scratch) = rest.split_at_mut(MAX_STAGES * length);
        let place = &mut activations[i * length..(i + 1) * length];
        let (x, scratch) = scratch.split_at_mut(self.basis.inputs());
        self.parameters.inputs.gather(sample, x);
        self.basis.activate(x, scratch, place);
    }

    /// The products of both weight matrices with the basis of stage i.
    #[inline]
    fn contract<B: Buffer>(&self, state: &mut FuzzyState<N, B>, i: usize) {
        let buffer = state.buffer.as_ref();
        let (row, matrix) = (self.basis.row_len(), self.matrix_len());
        for n in 0..N {
            let xi = self.basis.block(self.activation(buffer, i), self.block_of(n));
            state.stages.own[i][n] = contract(&buffer[n * row..(n + 1) * row], xi.u, xi.v);
            if state.prior {
                let place = matrix + n * row..matrix + (n + 1) * row;
                state.stages.prior[i][n] = contract(&buffer[place], xi.u, xi.v);
            }
        }
    }

    /// Whether the law needs |ξ|².
    #[inline]
    fn normalizes(&self) -> bool {
        self.parameters.adaptation.normalization > 0.0
    }

    /// Whether the size of the weights matters at stage i: to the law, or to a record between steps.
    #[inline]
    fn needs_norms(&self, i: usize) -> bool {
        i == MAX_STAGES - 1 || self.parameters.adaptation.pulls()
    }

    /// ξᵢ·ξⱼ with itself and with every earlier stage that matters.
    #[inline]
    fn correlate<B: Buffer>(&self, state: &mut FuzzyState<N, B>, stage: &Stage<'_>) {
        let i = stage.index;
        let all = self.needs_norms(i);
        for j in 0..=i {
            let matters = if j < i { stage.coefficients[j] != 0.0 } else { self.normalizes() };
            if !(matters || all) {
                continue;
            }
            let buffer = state.buffer.as_ref();
            let (left, right) = (self.activation(buffer, i), self.activation(buffer, j));
            for block in 0..self.basis.blocks() {
                let product = self.basis.block(left, block).dot(&self.basis.block(right, block));
                state.stages.gram[i][j][block] = product;
            }
            if self.basis.blocks() == 1 {
                state.stages.gram[i][j] = Vector::repeat(state.stages.gram[i][j][0]);
            }
        }
    }

    /// (W − W₀)ξ at the stage, and the rates of the law there.
    #[inline]
    fn learn<B: Buffer>(&self, state: &mut FuzzyState<N, B>, stage: &Stage<'_>, s: &Vector<N>) {
        let i = stage.index;
        let mixes = self.mixes(state, stage);
        for (n, mix) in mixes.iter().enumerate() {
            let stages = &mut state.stages;
            let past = (0..i).map(|j| mix.terms[j] * stages.gram[i][j][n]);
            stages.learnt[i][n] = mix.keep * stages.own[i][n] + past.sum::<f64>();
            if i == 0 || self.needs_norms(i) {
                state.stages.norms[i][n] = state.norm_squared(mix, i, n);
            }
        }
        if self.parameters.adaptation.pulls_by_state() {
            state.stages.mixes[i] = mixes;
        }
        self.record_rates(state, i, s);
    }

    #[inline]
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
    #[inline]
    fn mixes<B: Buffer>(&self, state: &FuzzyState<N, B>, stage: &Stage<'_>) -> [Mix; N] {
        let leak = self.leak_rate(state) * stage.step;
        let fade = |from: f64| if leak == 0.0 { 1.0 } else { exp(-leak * (stage.node - from)) };
        let mut mixes = [Mix { keep: fade(0.0), ..Mix::START }; N];
        for (j, (a, &node)) in stage.coefficients.iter().zip(stage.nodes).enumerate() {
            if *a == 0.0 {
                continue;
            }
            let weight = stage.step * a * fade(node);
            for (n, mix) in mixes.iter_mut().enumerate() {
                mix.terms[j] += weight * state.stages.drive[j][n];
                if self.parameters.adaptation.pulls_by_state() {
                    let pull = weight * state.stages.pull[j][n];
                    mix.subtract(pull, &state.stages.mixes[j][n], j);
                }
            }
        }
        mixes
    }

    /// D ← keep D + Σ cⱼ ξⱼᵀ over the stages before `count`, row by row.
    #[inline]
    fn write_weights<B: Buffer>(
        &self,
        state: &mut FuzzyState<N, B>,
        mixes: &[Mix; N],
        count: usize,
    ) {
        let row = self.basis.row_len();
        let (weights, rest) = state.buffer.as_mut().split_at_mut(self.matrix_len());
        let activations = &rest[(self.matrices() - 1) * self.matrix_len()..];
        for (n, mix) in mixes.iter().enumerate() {
            let mut terms = [Term { coefficient: 0.0, u: &[], v: &[] }; MAX_STAGES];
            let mut used = 0;
            for j in (0..count).filter(|&j| mix.terms[j] != 0.0) {
                let xi = self.basis.block(slot(&self.basis, activations, j), self.block_of(n));
                terms[used] = Term { coefficient: mix.terms[j], u: xi.u, v: xi.v };
                used += 1;
            }
            let place = &mut weights[n * row..(n + 1) * row];
            if used > 0 || mix.keep != 1.0 {
                state.norms[n] = accumulate(place, mix.keep, &terms[..used]);
            }
        }
        state.advances += 1;
        if state.advances.is_multiple_of(FLUSH_EVERY) {
            flush(weights);
        }
    }

    /// The evaluated basis of stage i.
    #[inline]
    fn activation<'a>(&self, buffer: &'a [f64], i: usize) -> &'a [f64] {
        slot(&self.basis, &buffer[self.matrices() * self.matrix_len()..], i)
    }

    #[inline]
    fn leak_rate<B: Buffer>(&self, state: &FuzzyState<N, B>) -> f64 {
        if state.frozen { 0.0 } else { self.parameters.adaptation.leak_rate }
    }
}

#[inline]
fn slot<'a>(basis: &FuzzyBasis, activations: &'a [f64], i: usize) -> &'a [f64] {
    let length = basis.activation_len();
    &activations[i * length..(i + 1) * length]
}

//! The adaptive law, stage by stage, in terms of kernels: `Wξ = keep W(t)ξ + Σ cⱼ k(xⱼ, x)`, `Ẇ = drive ξᵀ − pull W`.

use pulp::{Arch, Simd, WithSimd};

use super::{KernelCompensator, KernelState, Places};
use crate::control::fuzzy_compensator::{MAX_WEIGHT, Stages};
use crate::control::{
    Audit, Buffer, Compensator, FuzzyParameters, Gains, MAX_STAGES, Sample, Stage,
};
use crate::error::{Error, Result};
use crate::fuzzy::kernels::dot;
use crate::math::{Vector, exp, sqrt};
use crate::riccati::{JointSolution, joint};

/// The parameters of the law (18), with P solved for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Law<const N: usize> {
    pub parameters: FuzzyParameters<N>,
    pub p: [JointSolution; N],
}

impl<const N: usize> Law<N> {
    pub fn new(gains: &Gains<N>, parameters: FuzzyParameters<N>) -> Result<Self> {
        parameters.adaptation.validate()?;
        let mut p = [JointSolution::default(); N];
        for (n, solution) in p.iter_mut().enumerate() {
            let (q1, q2) = (parameters.q_position[n], parameters.q_velocity[n]);
            *solution = joint(gains.kp[n], gains.kv[n], q1, q2, parameters.gamma)?;
        }
        Ok(Self { parameters, p })
    }

    /// s = BᵀPx [the unit of Q over 1/s²].
    #[inline]
    fn s(&self, sample: &Sample<N>) -> Vector<N> {
        Vector::from_fn(|n, _| self.p[n].p12 * sample.e[n] + self.p[n].p22 * sample.de[n])
    }

    /// Whether the size of the weights matters at stage i: to the law, or to a record between steps.
    #[inline]
    fn needs_norms(&self, i: usize) -> bool {
        i == MAX_STAGES - 1 || self.parameters.adaptation.pulls()
    }

    /// The weights of every joint at a stage, in terms of those at the start of the step.
    #[inline(always)]
    fn mix(&self, stages: &mut Stages<N>, stage: &Stage<'_>, leak_rate: f64) {
        let leak = leak_rate * stage.step;
        let fade = |from: f64| if leak == 0.0 { 1.0 } else { exp(-leak * (stage.node - from)) };
        let Stages { drive, pull, mixes, .. } = stages;
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

    /// The rates of the law at stage i.
    #[inline(always)]
    fn record_rates(&self, stages: &mut Stages<N>, i: usize, s: &Vector<N>) {
        let adaptation = &self.parameters.adaptation;
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

    /// The terms of the dissipation identity at stage i.
    #[inline(always)]
    fn audit(&self, stages: &Stages<N>, i: usize, sample: &Sample<N>, leak: f64) -> Audit<N> {
        let s = self.s(sample);
        let FuzzyParameters { gamma, q_position, q_velocity, adaptation, .. } = &self.parameters;
        let (mut value, mut state_cost, mut loss) = (0.0, 0.0, 0.0);
        for n in 0..N {
            let (e, de, p) = (sample.e[n], sample.de[n], &self.p[n]);
            let stored = stages.norms[i][n] / adaptation.gain[n];
            let pulled = (leak + stages.pull[i][n]) * stored;
            let withheld = (1.0 - stages.factor[i][n]) * s[n] * stages.learnt[i][n];
            value += (p.p11 * e + 2.0 * p.p12 * de) * e + p.p22 * de * de + stored;
            state_cost += q_position[n] * e * e + q_velocity[n] * de * de;
            loss += s[n] * s[n] / (gamma * gamma) + 2.0 * (withheld + pulled);
        }
        let weights_norm = sqrt(stages.norms[i].sum());
        let (gamma, prior, loss) = (*gamma, Vector::zeros(), loss + state_cost);
        Audit { value, state_cost, s, prior, loss, gamma, weights_norm }
    }
}

impl<const N: usize, B: Buffer> Compensator<N, KernelState<N, B>> for KernelCompensator<N> {
    fn estimate(
        &self,
        state: &mut KernelState<N, B>,
        stage: &Stage<'_>,
        sample: &Sample<N>,
    ) -> Vector<N> {
        Arch::new().dispatch(Estimate { compensator: self, state, stage, sample })
    }

    fn hold(&self, state: &mut KernelState<N, B>, index: usize) {
        state.stages.factor[index] = Vector::zeros();
        state.stages.drive[index] = Vector::zeros();
        state.stages.pull[index] = Vector::zeros();
    }

    fn advance(&self, state: &mut KernelState<N, B>, end: &Stage<'_>) -> Result<()> {
        if state.frozen {
            return Ok(());
        }
        let count = self.prepare(state, end)?;
        Arch::new().dispatch(Write { compensator: self, state, count });
        Ok(())
    }

    fn reset(&self, state: &mut KernelState<N, B>) {
        state.clear();
    }

    fn audit(&self, state: &KernelState<N, B>, i: usize, sample: &Sample<N>) -> Option<Audit<N>> {
        Some(self.law.audit(&state.stages, i, sample, self.leak_rate(state)))
    }
}

/// A stage, compiled as a whole for the instruction set at hand.
pub(super) struct Estimate<'a, const N: usize, B> {
    pub compensator: &'a KernelCompensator<N>,
    pub state: &'a mut KernelState<N, B>,
    pub stage: &'a Stage<'a>,
    pub sample: &'a Sample<N>,
}

impl<const N: usize, B: Buffer> WithSimd for Estimate<'_, N, B> {
    type Output = Vector<N>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Vector<N> {
        let Self { compensator, state, stage, sample } = self;
        let i = stage.index;
        compensator.evaluate(simd, state, i, sample);
        compensator.correlate(state, stage);
        let leak_rate = compensator.leak_rate(state);
        compensator.law.mix(&mut state.stages, stage, leak_rate);
        compensator.learn(state, i, &compensator.law.s(sample));
        state.stages.learnt[i]
    }
}

/// The end of a step, compiled in the same way.
pub(super) struct Write<'a, const N: usize, B> {
    pub compensator: &'a KernelCompensator<N>,
    pub state: &'a mut KernelState<N, B>,
    pub count: usize,
}

impl<const N: usize, B: Buffer> WithSimd for Write<'_, N, B> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.compensator.write(simd, self.state, self.count);
    }
}

impl<const N: usize> KernelCompensator<N> {
    /// The change of the weights over the step, unless it is too large; returns the number of its stages.
    pub(super) fn prepare<B: Buffer>(
        &self,
        state: &mut KernelState<N, B>,
        end: &Stage<'_>,
    ) -> Result<usize> {
        let (count, leak_rate) = (end.index, self.leak_rate(state));
        let stages = &mut state.stages;
        self.law.mix(stages, end, leak_rate);
        let got = stages.mixes[count].norm_bound(count, &state.norms, self.basis.xi_bound());
        if got > MAX_WEIGHT || got.is_nan() {
            let wanted = "weights of at most 1e150; lower the gain";
            return Err(Error::OutOfRange { parameter: "weights", index: None, got, wanted });
        }
        for j in 0..count {
            (0..=j).for_each(|k| self.product(state, j, k));
        }
        Ok(count)
    }

    /// The memberships, the kernels with all atoms, and W(t)ξ, at stage i.
    #[inline(always)]
    fn evaluate<S: Simd, B: Buffer>(
        &self,
        simd: S,
        state: &mut KernelState<N, B>,
        i: usize,
        sample: &Sample<N>,
    ) {
        let Places { row, coefficients, kernels, stages, stage, x, scratch, .. } = self.places;
        let used = Self::used_row(state.atoms);
        let memory = &mut state.buffer.as_mut()[state.offset..];
        let (dictionary, rest) = memory.split_at_mut(kernels);
        let (rows, rest) = rest.split_at_mut(stages - kernels);
        let (memberships, rest) = rest.split_at_mut(x - stages);
        let (x, scratch) = rest.split_at_mut(scratch - x);
        let x = &mut x[..self.basis.inputs()];
        self.law.parameters.inputs.gather(sample, x);
        let memberships = &mut memberships[i * stage..(i + 1) * stage];
        self.basis.activate(simd, x, scratch, memberships);
        let out = &mut rows[i * row..][..used];
        self.basis.compare(simd, memberships, &dictionary[..used * self.basis.sets()], out);
        for n in 0..N {
            let own = &dictionary[coefficients + n * row..][..used];
            state.stages.own[i][n] = state.scale[n] * dot(simd, own, out);
        }
        state.stages.known[i] = 0;
    }

    /// ξᵢ·ξⱼ with itself and with every earlier stage, where the law or a record needs it.
    #[inline(always)]
    fn correlate<B: Buffer>(&self, state: &mut KernelState<N, B>, stage: &Stage<'_>) {
        let i = stage.index;
        if self.law.needs_norms(i) {
            for j in 0..=i {
                (0..=j).for_each(|k| self.product(state, j, k));
            }
            return;
        }
        for (j, a) in stage.coefficients.iter().enumerate() {
            if *a != 0.0 {
                self.product(state, i, j);
            }
        }
        self.product(state, i, i);
    }

    /// ξᵢ·ξⱼ, unless it is known.
    #[inline]
    fn product<B: Buffer>(&self, state: &mut KernelState<N, B>, i: usize, j: usize) {
        if state.stages.known[i] >> j & 1 != 0 {
            return;
        }
        let k = self.basis.dot(self.memberships(state, i), self.memberships(state, j));
        state.stages.gram[i][j] = Vector::repeat(k);
        state.stages.known[i] |= 1 << j;
    }

    /// The memberships of stage i.
    #[inline]
    fn memberships<'a, B: Buffer>(&self, state: &'a KernelState<N, B>, i: usize) -> &'a [f64] {
        let Places { stages, stage, .. } = self.places;
        &state.memory()[stages + i * stage..][..stage]
    }

    /// Wξ at the stage, and the rates of the law there.
    #[inline(always)]
    fn learn<B: Buffer>(&self, state: &mut KernelState<N, B>, i: usize, s: &Vector<N>) {
        let stages = &mut state.stages;
        let mix = &stages.mixes[i];
        let mut learnt = mix.keep.component_mul(&stages.own[i]);
        for (j, terms) in mix.terms[..i].iter().enumerate() {
            if stages.known[i] >> j & 1 != 0 {
                learnt += terms.component_mul(&stages.gram[i][j]);
            }
        }
        stages.learnt[i] = learnt;
        if i == 0 || self.law.needs_norms(i) {
            stages.norms[i] = stages.norms_squared(mix, i, &state.norms);
        }
        if state.frozen {
            return self.hold(state, i);
        }
        self.law.record_rates(stages, i, s);
    }

    #[inline]
    fn leak_rate<B: Buffer>(&self, state: &KernelState<N, B>) -> f64 {
        if state.frozen { 0.0 } else { self.law.parameters.adaptation.leak_rate }
    }
}

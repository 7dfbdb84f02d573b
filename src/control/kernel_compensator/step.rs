//! A step in terms of kernels: `Wξ = keep W(t)ξ + Σ cⱼ k(xⱼ, x)`, with the law of every stage in
//! between.

use pulp::{Arch, Simd, WithSimd};

use super::{KernelCompensator, KernelState, Places};
use crate::control::{Applied, Audit, Buffer, Channel, Compensator, Sample, Stage, Width};
use crate::error::Result;
use crate::fuzzy::lanes::dot;
use crate::math::Vector;

/// What a record shows of the dictionary: in sampled control, after the step of its row.
const CHANNELS: [Channel; 2] = [
    Channel { name: "atoms", unit: "1", width: Width::One, doc: "Atoms in the dictionary" },
    Channel {
        name: "error_bound",
        unit: "rad/s²",
        width: Width::Joints,
        doc: "Bound of |W − W_exact|, of what the dictionary lost",
    },
];

impl<const N: usize, B: Buffer> Compensator<N, KernelState<N, B>> for KernelCompensator<N> {
    fn estimate(
        &self,
        state: &mut KernelState<N, B>,
        stage: &Stage<'_>,
        sample: &Sample<N>,
    ) -> Vector<N> {
        Arch::new().dispatch(Estimate { compensator: self, state, stage, sample })
    }

    #[inline]
    fn acted(
        &self,
        state: &mut KernelState<N, B>,
        index: usize,
        _: &Sample<N>,
        applied: &Applied<N>,
    ) {
        state.stages.acted(index, applied);
    }

    fn advance(&self, state: &mut KernelState<N, B>, end: &Stage<'_>) -> Result<()> {
        if state.frozen {
            return Ok(());
        }
        let count = end.index;
        self.update.finish(&mut state.stages, &state.norms, end, self.basis.xi_bound())?;
        Arch::new().dispatch(Write { compensator: self, state, count });
        Ok(())
    }

    fn reset(&self, state: &mut KernelState<N, B>) {
        state.clear();
        state.unfreeze();
    }

    fn audit(&self, state: &KernelState<N, B>, i: usize, sample: &Sample<N>) -> Option<Audit<N>> {
        Some(self.update.audit(&state.stages, i, sample, state.frozen))
    }

    fn channels(&self) -> &'static [Channel] {
        &CHANNELS
    }

    fn signals(&self, state: &KernelState<N, B>, _: &Sample<N>, row: &mut [f64]) {
        row[0] = state.atoms as f64;
        row[1..].copy_from_slice(state.errors.as_slice());
    }
}

/// A stage, compiled as a whole for the instruction set at hand.
pub(super) struct Estimate<'a, const N: usize, B: Buffer> {
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
        compensator.correlate(simd, state, stage);
        let (update, frozen) = (&compensator.update, state.frozen);
        update.mix(&mut state.stages, stage, update.leak_rate(frozen));
        update.learn(&mut state.stages, &state.norms, i, sample, frozen);
        state.stages.learnt[i]
    }
}

/// The end of a step, compiled in the same way.
pub(super) struct Write<'a, const N: usize, B: Buffer> {
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
    /// The memberships, the kernels with all atoms, and W(t)ξ, at stage i.
    #[inline(always)]
    fn evaluate<S: Simd, B: Buffer>(
        &self,
        simd: S,
        state: &mut KernelState<N, B>,
        i: usize,
        sample: &Sample<N>,
    ) {
        let Places { row, coefficients, kernels, stages, stage, x, .. } = self.places;
        let used = Self::used_row(state.atoms);
        let memory = state.memory.as_mut_slice();
        let (dictionary, rest) = memory.split_at_mut(kernels);
        let (rows, rest) = rest.split_at_mut(stages - kernels);
        let (memberships, x) = rest.split_at_mut(x - stages);
        let x = &mut x[..self.basis.inputs()];
        self.update.parameters.inputs.gather(sample, x);
        let memberships = &mut memberships[i * stage..(i + 1) * stage];
        self.basis.activate(simd, x, memberships);
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
    fn correlate<S: Simd, B: Buffer>(
        &self,
        simd: S,
        state: &mut KernelState<N, B>,
        stage: &Stage<'_>,
    ) {
        let i = stage.index;
        if self.update.needs_norms(i) {
            for j in 0..=i {
                (0..=j).for_each(|k| self.product(simd, state, j, k));
            }
            return;
        }
        for (j, a) in stage.coefficients.iter().enumerate() {
            if *a != 0.0 {
                self.product(simd, state, i, j);
            }
        }
        self.product(simd, state, i, i);
    }

    /// ξᵢ·ξⱼ, unless it is known.
    #[inline(always)]
    pub(super) fn product<S: Simd, B: Buffer>(
        &self,
        simd: S,
        state: &mut KernelState<N, B>,
        i: usize,
        j: usize,
    ) {
        if state.stages.known[i] >> j & 1 != 0 {
            return;
        }
        let k = self.basis.dot(simd, self.memberships(state, i), self.memberships(state, j));
        state.stages.gram[i][j] = Vector::repeat(k);
        state.stages.known[i] |= 1 << j;
    }

    /// The memberships of stage i.
    #[inline]
    fn memberships<'a, B: Buffer>(&self, state: &'a KernelState<N, B>, i: usize) -> &'a [f64] {
        let Places { stages, stage, .. } = self.places;
        &state.memory.as_slice()[stages + i * stage..][..stage]
    }
}

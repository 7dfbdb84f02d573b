//! A step in terms of kernels: `Wξ = keep W(t)ξ + Σ cⱼ k(xⱼ, x)`, with the law of every stage in
//! between.

use super::{KernelCompensator, KernelState, Places};
use crate::control::{Applied, Audit, Buffer, Channel, Compensator, Sample, Stage, Width};
use crate::error::Result;
use crate::fuzzy::lanes::Dot;
use crate::fuzzy::{Compare, Kernel, Memberships};
use crate::math::{Runs, Shared, TINY_ESTIMATE, Vector, unless_tiny};

/// What a record shows of the dictionary: in sampled control, what the torque of its row was
/// decided from.
const CHANNELS: [Channel; 2] = [
    Channel { name: "atoms", unit: "1", width: Width::One, doc: "Atoms in the dictionary" },
    Channel {
        name: "error_bound",
        unit: "rad/s²",
        width: Width::Joints,
        doc: "Bound of |W − W_exact|, of what the dictionary lost",
    },
];

impl<const N: usize, T: Buffer, B: Buffer> Compensator<N, KernelState<N, B>>
    for KernelCompensator<N, T>
{
    fn estimate(
        &self,
        state: &mut KernelState<N, B>,
        stage: &Stage<'_>,
        sample: &Sample<N>,
    ) -> Vector<N> {
        Estimate { compensator: self, state, stage, sample }.with(Shared)
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

    #[inline]
    fn admit(&self, state: &KernelState<N, B>, sample: &Sample<N>, dt: f64) -> Result<()> {
        if state.frozen {
            return Ok(());
        }
        self.update.admit(&state.norms, sample, dt)
    }

    fn advance(&self, state: &mut KernelState<N, B>, end: &Stage<'_>) -> Result<()> {
        if state.frozen {
            return Ok(());
        }
        let count = end.index;
        self.update.finish(&mut state.stages, &state.norms, end)?;
        self.write(Shared, state, count);
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

/// A stage.
pub(super) struct Estimate<'a, const N: usize, T: Buffer, B: Buffer> {
    pub compensator: &'a KernelCompensator<N, T>,
    pub state: &'a mut KernelState<N, B>,
    pub stage: &'a Stage<'a>,
    pub sample: &'a Sample<N>,
}

impl<const N: usize, T: Buffer, B: Buffer> Estimate<'_, N, T, B> {
    pub fn with(self, tasks: impl Runs) -> Vector<N> {
        let Self { compensator, state, stage, sample } = self;
        let i = stage.index;
        compensator.evaluate(tasks, state, i, sample);
        compensator.correlate(tasks, state, stage);
        let (update, frozen) = (&compensator.update, state.frozen);
        update.mix(&mut state.stages, stage, update.leak_rate(frozen));
        update.learn(&mut state.stages, &state.norms, i, sample, frozen);
        state.stages.learnt[i]
    }
}

impl<const N: usize, T: Buffer> KernelCompensator<N, T> {
    /// The memberships, the kernels with all atoms, and W(t)ξ, at stage i.
    fn evaluate<B: Buffer>(
        &self,
        tasks: impl Runs,
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
        tasks.run(Memberships { basis: &self.basis, x, memberships: &mut *memberships });
        let out = &mut rows[i * row..][..used];
        let atoms = &dictionary[..used * self.basis.sets()];
        tasks.run(Compare { basis: &self.basis, memberships, atoms, out: &mut *out });
        for n in 0..N {
            let own = &dictionary[coefficients + n * row..][..used];
            let own = state.scale[n] * tasks.run(Dot { left: own, right: out });
            state.stages.own[i][n] = unless_tiny(own, TINY_ESTIMATE);
        }
        state.stages.known[i] = 0;
    }

    /// ξᵢ·ξⱼ with itself and with every earlier stage, where the law or a record needs it.
    fn correlate<B: Buffer>(
        &self,
        tasks: impl Runs,
        state: &mut KernelState<N, B>,
        stage: &Stage<'_>,
    ) {
        let i = stage.index;
        if self.update.needs_norms(i) {
            for j in 0..=i {
                (0..=j).for_each(|k| self.product(tasks, state, j, k));
            }
            return;
        }
        for (j, a) in stage.coefficients.iter().enumerate() {
            if *a != 0.0 {
                self.product(tasks, state, i, j);
            }
        }
        self.product(tasks, state, i, i);
    }

    /// ξᵢ·ξⱼ, unless it is known.
    pub(super) fn product<B: Buffer>(
        &self,
        tasks: impl Runs,
        state: &mut KernelState<N, B>,
        i: usize,
        j: usize,
    ) {
        if state.stages.known[i] >> j & 1 != 0 {
            return;
        }
        let (left, right) = (self.memberships(state, i), self.memberships(state, j));
        let k = tasks.run(Kernel { basis: &self.basis, left, right });
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

//! What a fuzzy compensator remembers: its weights, and what each stage of the current step
//! recorded.

use crate::control::stages::Stages;
use crate::fuzzy::{Buffer, Memory};
use crate::math::{Vector, sqrt};

/// Weights and scratch memory of a fuzzy compensator.
#[derive(Clone, Debug)]
pub struct FuzzyState<const N: usize, B: Buffer> {
    /// W − W₀, W₀ if there is one, the evaluated basis of every stage, scratch.
    pub(super) memory: Memory<B>,
    /// Squared norms |Dₙ|² of the rows of W − W₀.
    pub(in crate::control) norms: Vector<N>,
    /// Whether W₀ is not zero.
    pub(in crate::control) prior: bool,
    pub(in crate::control) frozen: bool,
    /// Steps taken, to set tiny weights to zero once in a while.
    pub(in crate::control) advances: u64,
    pub(super) stages: Stages<N>,
}

impl<const N: usize, B: Buffer> FuzzyState<N, B> {
    pub(super) fn over(memory: Memory<B>) -> Self {
        let (norms, stages) = (Vector::zeros(), Stages::default());
        Self { memory, norms, prior: false, frozen: false, advances: 0, stages }
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

    /// The padded rows of W − W₀ (matrix 0) or W₀ (matrix 1); matrices of length `len`.
    pub(super) fn rows(
        &self,
        matrix: usize,
        len: usize,
        row: usize,
    ) -> impl Iterator<Item = &[f64]> {
        self.memory.as_slice()[matrix * len..][..len].chunks_exact(row)
    }

    /// A new state's weights and records; only whether adaptation is stopped stays.
    pub(super) fn clear(&mut self) {
        let Self { memory, norms, prior, frozen: _, advances, stages } = self;
        memory.as_mut_slice().fill(0.0);
        *norms = Vector::zeros();
        *prior = false;
        *advances = 0;
        *stages = Stages::default();
    }
}

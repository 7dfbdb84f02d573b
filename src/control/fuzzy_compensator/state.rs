//! What a fuzzy compensator remembers: its weights, and what each stage of the current step recorded.

use crate::control::stages::Stages;
use crate::fuzzy::kernels::first_lane;
use crate::math::{Vector, sqrt};

/// Memory for a [`FuzzyState`].
pub trait Buffer: AsRef<[f64]> + AsMut<[f64]> {}

impl<B: AsRef<[f64]> + AsMut<[f64]>> Buffer for B {}

/// Weights and scratch memory of a fuzzy compensator.
#[derive(Clone, Debug)]
pub struct FuzzyState<const N: usize, B> {
    /// W − W₀, W₀ if there is one, the evaluated basis of every stage, scratch.
    pub(super) buffer: B,
    /// Start of the first whole lane in the buffer: cache lines are read whole from there.
    pub(super) offset: usize,
    /// Squared norms |Dₙ|² of the rows of W − W₀.
    pub(super) norms: Vector<N>,
    /// Whether W₀ is not zero.
    pub(in crate::control) prior: bool,
    pub(in crate::control) frozen: bool,
    /// Steps taken, to flush denormal weights once in a while.
    pub(in crate::control) advances: u64,
    pub(super) stages: Stages<N>,
}

impl<const N: usize, B: Buffer> FuzzyState<N, B> {
    pub(super) fn over(buffer: B) -> Self {
        let offset = first_lane(buffer.as_ref());
        let (norms, stages) = (Vector::zeros(), Stages::default());
        Self { buffer, offset, norms, prior: false, frozen: false, advances: 0, stages }
    }

    /// The buffer from its first whole lane on.
    #[inline]
    pub(super) fn memory(&self) -> &[f64] {
        &self.buffer.as_ref()[self.offset..]
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

    pub(super) fn clear(&mut self) {
        self.buffer.as_mut().fill(0.0);
        self.norms = Vector::zeros();
        self.prior = false;
        self.advances = 0;
    }
}

//! What a kernel compensator remembers: its dictionary, and what each stage of the current step
//! recorded.

use crate::control::stages::Stages;
use crate::fuzzy::{Buffer, Memory};
use crate::math::{Vector, sqrt};

/// Dictionary and scratch memory of a kernel compensator.
#[derive(Clone, Debug)]
pub struct KernelState<const N: usize, B: Buffer> {
    /// Atoms, coefficients, kernels of the atoms, kernels and memberships of every stage, scratch.
    pub(super) memory: Memory<B>,
    /// Number of atoms.
    pub(super) atoms: usize,
    /// What the coefficients of each joint are multiplied by: they all fade alike.
    pub(super) scale: Vector<N>,
    /// Squared norms |Wₙ|² of the rows.
    pub(super) norms: Vector<N>,
    /// Bounds of |Wₙ_exact − Wₙ|.
    pub(super) errors: Vector<N>,
    pub(super) merged: u64,
    pub(super) dropped: u64,
    pub(super) frozen: bool,
    pub(super) stages: Stages<N>,
}

impl<const N: usize, B: Buffer> KernelState<N, B> {
    pub(super) fn over(memory: Memory<B>) -> Self {
        let (zeros, stages) = (Vector::zeros(), Stages::default());
        Self {
            memory,
            atoms: 0,
            scale: Vector::repeat(1.0),
            norms: zeros,
            errors: zeros,
            merged: 0,
            dropped: 0,
            frozen: false,
            stages,
        }
    }

    /// Number of atoms in the dictionary.
    pub fn atoms(&self) -> usize {
        self.atoms
    }

    /// Terms that were merged into an atom that was there.
    pub fn merged(&self) -> u64 {
        self.merged
    }

    /// Atoms that went because the dictionary was full.
    pub fn dropped(&self) -> u64 {
        self.dropped
    }

    /// A bound of |Wₙ_exact − Wₙ| for each joint, where W_exact has taken the same terms and lost
    /// nothing. The error of ρ̂ₙ(x) is at most this times |ξ(x)|, which is at most 1 for a
    /// normalised basis [rad/s²].
    pub fn error_bound(&self) -> Vector<N> {
        self.errors
    }

    /// |W|, Frobenius.
    pub fn weights_norm(&self) -> f64 {
        sqrt(self.norms.sum())
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

    /// A new state's dictionary and records; only whether adaptation is stopped stays.
    pub(super) fn clear(&mut self) {
        let Self { memory, atoms, scale, norms, errors, merged, dropped, frozen: _, stages } = self;
        memory.as_mut_slice().fill(0.0);
        (*atoms, *merged, *dropped) = (0, 0, 0);
        *scale = Vector::repeat(1.0);
        (*norms, *errors) = (Vector::zeros(), Vector::zeros());
        *stages = Stages::default();
    }
}

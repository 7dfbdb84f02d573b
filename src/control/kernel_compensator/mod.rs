//! The fuzzy compensator ρ̂ = W ξ(x) on a product grid of any size, in kernel form.
//!
//! ```text
//! W = Σ_k c_k ξ(x_k)ᵀ,    ρ̂(x) = Σ_k c_k k(x_k, x),    k(x, y) = ξ(x)·ξ(y) = ∏ᵢ pᵢ(x)·pᵢ(y)
//! ```
//!
//! The update law (18) adds a coefficient at the present state and lets the others fade, so W never
//! needs the rules: a dictionary of atoms x_k, each with its memberships pᵢ and its coefficients
//! c_k, holds all of it. It has a capacity:
//!
//! - a term `c ξ(x)` whose nearest atom is close becomes `c k(x, x_k)/k(x_k, x_k) ξ(x_k)`, its
//!   projection. What is lost has the square `|c|²(k(x, x) − k(x, x_k)²/k(x_k, x_k))`;
//! - when the dictionary is full, the least useful atom, with the smallest `|c_k|² k(x_k, x_k)`,
//!   makes room.
//!
//! Both are counted. Their sizes add up to a bound of |W_exact − W|, which fades as the weights do.
//! While nothing is merged and no atom goes, the weights are those of
//! [`FuzzyCompensator`](super::FuzzyCompensator), whose basis is written out, to rounding. Every
//! modification of [`Adaptation`](super::Adaptation) is exact in this form.

mod dictionary;
mod saved;
mod state;
mod step;
#[cfg(test)]
#[cfg(feature = "std")]
mod tests;

pub use state::KernelState;

use super::update::Update;
use super::{FuzzyParameters, Gains, MAX_STAGES};
use crate::error::{Result, at_most, length, not_empty, within};
use crate::fuzzy::{Buffer, KernelBasis, Memory, Room};
use crate::math::LANES;
use crate::riccati::JointSolution;

/// Atoms at the most: their kernels with each other then take 128 MiB.
const MAX_CAPACITY: usize = 4096;

/// How much a kernel compensator remembers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KernelParameters {
    /// Atoms at the most, 1 … 4096. Memory grows with its square.
    pub capacity: usize,
    /// A term is merged into its nearest atom where that loses less than this part of its norm. 0
    /// merges nothing, and neither does a value below the rounding of a kernel, near 1e-7.
    pub merge_tolerance: f64,
}

impl Default for KernelParameters {
    /// 256 atoms, and 5 %.
    fn default() -> Self {
        Self { capacity: 256, merge_tolerance: 0.05 }
    }
}

impl KernelParameters {
    /// Refuses what is out of range.
    ///
    /// # Errors
    /// `capacity`: 0, or more than 4096. `merge_tolerance`: not in [0, 1).
    pub fn validate(&self) -> Result<()> {
        let Self { capacity, merge_tolerance } = *self;
        not_empty("capacity", capacity)?;
        at_most("capacity", capacity, MAX_CAPACITY)?;
        let part = |tolerance: f64| (0.0..1.0).contains(&tolerance);
        within("merge_tolerance", &[merge_tolerance], part, "a part of the norm, 0 <= part < 1")
    }
}

/// The compensator's configuration, with P solved for. Immutable.
#[derive(Clone, Debug)]
pub struct KernelCompensator<const N: usize, T: Buffer = Room> {
    basis: KernelBasis<T>,
    update: Update<N>,
    kernel: KernelParameters,
    places: Places,
}

/// Where things lie in a state's buffer, from its first whole lane on. The memberships of the atoms
/// come first.
#[derive(Clone, Copy, Debug)]
struct Places {
    /// Length of a row over all atoms.
    row: usize,
    /// Start of the coefficients, a row a joint, to be multiplied by the state's scale.
    coefficients: usize,
    /// Start of the kernels of the atoms with each other, a row an atom, and the distance of the
    /// rows: an odd number of cache lines, so that a column does not fall on the same few places of
    /// the cache.
    gram: usize,
    gram_row: usize,
    /// Start of k(x_k, x_k), and of 1/k(x_k, x_k).
    sizes: usize,
    inverses: usize,
    /// Start of the kernels of each stage with the atoms, a row a stage; one more row is scratch
    /// memory.
    kernels: usize,
    /// Start of the memberships of each stage, and the length of one.
    stages: usize,
    stage: usize,
    /// Start of the inputs x.
    x: usize,
    end: usize,
}

impl<const N: usize, T: Buffer> KernelCompensator<N, T> {
    /// A compensator for these feedback gains; solves (19) for P.
    ///
    /// # Errors
    /// `inputs`: the basis has another number of inputs. `capacity`: 0, or more than 4096.
    /// `merge_tolerance`: not in [0, 1). `gain`, `leak_rate`, …: see
    /// [`Adaptation`](super::Adaptation). `q`, `gamma`: out of range, or
    /// [`NoStabilizingSolution`](crate::Problem::NoStabilizingSolution) where (19) has none.
    pub fn new(
        basis: KernelBasis<T>,
        gains: &Gains<N>,
        parameters: FuzzyParameters<N>,
        kernel: KernelParameters,
    ) -> Result<Self> {
        length("inputs", basis.inputs(), parameters.inputs.len(N))?;
        kernel.validate()?;
        let update = Update::new(gains, parameters, basis.xi_bound())?;
        let places = Places::new(&basis, N, kernel.capacity);
        Ok(Self { basis, update, kernel, places })
    }

    /// The basis ξ.
    pub fn basis(&self) -> &KernelBasis<T> {
        &self.basis
    }

    /// The parameters of the update law.
    pub fn parameters(&self) -> &FuzzyParameters<N> {
        &self.update.parameters
    }

    /// The parameters of the dictionary.
    pub fn kernel_parameters(&self) -> &KernelParameters {
        &self.kernel
    }

    /// P, joint by joint.
    pub fn p(&self) -> &[JointSolution; N] {
        &self.update.p
    }

    /// Length of the buffer that a [`KernelState`] needs.
    pub fn buffer_len(&self) -> usize {
        Memory::<&mut [f64]>::buffer_len(self.places.end)
    }

    /// A state with an empty dictionary on the heap.
    #[cfg(feature = "std")]
    pub fn state(&self) -> KernelState<N, Vec<f64>> {
        KernelState::over(Memory::on_heap(self.places.end))
    }

    /// A state with an empty dictionary in a buffer of the caller's: an array, a slice, a vector.
    ///
    /// # Errors
    /// `buffer`: shorter than [`buffer_len`](Self::buffer_len).
    pub fn state_in<B: Buffer>(&self, buffer: B) -> Result<KernelState<N, B>> {
        Memory::new(buffer, self.places.end).map(KernelState::over)
    }

    /// Reads atom `k` of [`KernelState::atoms`]: writes the memberships of x_k, input after input,
    /// and returns c_k; `None` if there is no such atom.
    ///
    /// # Errors
    /// `memberships`: not [`KernelBasis::sets`] long.
    pub fn read_atom<B: Buffer>(
        &self,
        state: &KernelState<N, B>,
        atom: usize,
        memberships: &mut [f64],
    ) -> Result<Option<crate::math::Vector<N>>> {
        length("memberships", memberships.len(), self.basis.sets())?;
        if atom >= state.atoms {
            return Ok(None);
        }
        let memory = state.memory.as_slice();
        memberships.iter_mut().zip(self.basis.atom(memory, atom)).for_each(|(p, own)| *p = own);
        Ok(Some(self.coefficient(state, atom)))
    }

    /// The length of the atoms' rows that is in use: whole blocks.
    #[inline]
    fn used_row(atoms: usize) -> usize {
        atoms.next_multiple_of(LANES)
    }
}

impl Places {
    fn new<T: Buffer>(basis: &KernelBasis<T>, joints: usize, capacity: usize) -> Self {
        let row = capacity.next_multiple_of(LANES);
        let coefficients = row * basis.sets();
        let gram = coefficients + joints * row;
        let gram_row = ((row / LANES) | 1) * LANES;
        let sizes = gram + capacity * gram_row;
        let inverses = sizes + row;
        let kernels = inverses + row;
        let stages = kernels + (MAX_STAGES + 1) * row;
        let stage = basis.activation_len();
        let x = stages + MAX_STAGES * stage;
        let end = x + basis.inputs();
        Self { row, coefficients, gram, gram_row, sizes, inverses, kernels, stages, stage, x, end }
    }
}

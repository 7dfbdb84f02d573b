//! The fuzzy compensator ρ̂ = W ξ(x) (12)-(13) with the update law (18).
//!
//! Over a step the weights change by a sum of rank-one terms,
//! `W = W₀ + keep (W(t) − W₀) + Σ cⱼ ξⱼᵀ`, so a stage needs `Wξ = W₀ξ + keep Dξ + Σ cⱼ (ξⱼ·ξ)`: the
//! weights are read once a stage and written once a step.

#[cfg(feature = "std")]
mod abreast;
mod saved;
mod state;
mod step;
mod tasks;

#[cfg(feature = "std")]
pub(super) use abreast::PerJoint;
pub(super) use saved::FROZEN;
pub use state::FuzzyState;

use super::learns::{Kind, Learns, PerJointSide};
use super::update::{FuzzyParameters, MAX_WEIGHT, Update};
use super::{Gains, MAX_STAGES};
use crate::error::{Result, length, within};
use crate::fuzzy::Spaced;
use crate::fuzzy::lanes::norm_squared;
use crate::fuzzy::{Buffer, Form, FuzzyBasis, Memory, Room};
use crate::math::{TINY_WEIGHT, unless_tiny};
use crate::riccati::JointSolution;

/// The compensator's configuration, with P solved for. Immutable.
#[derive(Clone, Debug)]
pub struct FuzzyCompensator<const N: usize, T: Buffer = Room> {
    basis: FuzzyBasis<T>,
    update: Update<N>,
    places: Places,
}

/// Where things lie in a state's buffer, from its first whole lane on.
#[derive(Clone, Copy, Debug)]
struct Places {
    /// Length of W − W₀, which comes first, and of W₀, which follows if it is needed.
    matrix: usize,
    /// Start of the evaluated bases of the stages, and the length of each.
    stages: usize,
    stage: usize,
    /// Start of the inputs x, and of scratch memory.
    x: usize,
    scratch: usize,
    end: usize,
}

impl<const N: usize, T: Buffer> FuzzyCompensator<N, T> {
    /// A compensator for these feedback gains; solves (19) for P.
    ///
    /// # Errors
    /// `inputs`: the basis has another number of inputs, or of joints. `gain`, `leak_rate`, …: see
    /// [`Adaptation`](super::Adaptation). `q`, `gamma`: out of range, or
    /// [`NoStabilizingSolution`](crate::Problem::NoStabilizingSolution) where (19) has none.
    pub fn new(
        basis: FuzzyBasis<T>,
        gains: &Gains<N>,
        parameters: FuzzyParameters<N>,
    ) -> Result<Self> {
        length("inputs", basis.inputs(), parameters.inputs.len(N))?;
        if let Form::PerJoint { joints } = basis.form() {
            length("joints", joints, N)?;
        }
        let update = Update::new(gains, parameters, basis.xi_bound())?;
        let places = Places::new(&basis, N, parameters.adaptation.pulls());
        Ok(Self { basis, update, places })
    }

    /// What of it is put beside others: a grid for each joint over two inputs on lattices, whose
    /// weights nothing pulls but a leak, to zero.
    fn per_joint_side<'a, B: Buffer>(
        &'a self,
        state: &'a FuzzyState<N, B>,
    ) -> Option<Learns<'a, N>> {
        let FuzzyParameters { inputs, adaptation, .. } = &self.update.parameters;
        let per_joint = self.basis.form() == Form::PerJoint { joints: N };
        let small = state.norms.iter().all(|norm| *norm < MOST_NORM);
        let free = !adaptation.pulls_by_state() && !state.frozen && !state.prior && small;
        if !per_joint || !free || inputs.signals().len() != 2 || !self.basis.is_inner() {
            return None;
        }
        let mut sets = [[Spaced::NONE; 2]; N];
        for (n, own) in sets.iter_mut().enumerate() {
            *own = [self.basis.spaced(n)?, self.basis.spaced(N + n)?];
        }
        let side = PerJointSide {
            inputs: *inputs,
            sets,
            normalized: self.basis.normalized(),
            p12: self.update.p.each_ref().map(|p| p.p12),
            p22: self.update.p.each_ref().map(|p| p.p22),
            gain: adaptation.gain,
            leak_rate: adaptation.leak_rate,
            dead_zone: adaptation.dead_zone,
            normalization: adaptation.normalization,
            weights: state.memory.as_slice(),
            row: self.basis.row_len(),
            #[cfg(feature = "std")]
            advances: state.advances,
        };
        Some(Learns(Kind::PerJoint(side)))
    }

    /// The basis ξ.
    pub fn basis(&self) -> &FuzzyBasis<T> {
        &self.basis
    }

    /// The parameters it was made from.
    pub fn parameters(&self) -> &FuzzyParameters<N> {
        &self.update.parameters
    }

    /// P, joint by joint.
    pub fn p(&self) -> &[JointSolution; N] {
        &self.update.p
    }

    /// Number of weights, N × rules (per-joint bases: N × rules of a joint).
    pub fn weights_len(&self) -> usize {
        N * self.basis.block_rules()
    }

    /// Length of the buffer that a [`FuzzyState`] needs.
    pub fn buffer_len(&self) -> usize {
        Memory::<&mut [f64]>::buffer_len(self.places.end)
    }

    /// A state with zero weights on the heap.
    #[cfg(feature = "std")]
    pub fn state(&self) -> FuzzyState<N, Vec<f64>> {
        FuzzyState::over(Memory::on_heap(self.places.end))
    }

    /// A state with zero weights in a buffer of the caller's: an array, a slice, a vector.
    ///
    /// # Errors
    /// `buffer`: shorter than [`buffer_len`](Self::buffer_len).
    pub fn state_in<B: Buffer>(&self, buffer: B) -> Result<FuzzyState<N, B>> {
        Memory::new(buffer, self.places.end).map(FuzzyState::over)
    }

    /// Writes W, row-major (N × rules).
    ///
    /// # Errors
    /// `weights`: wrong length.
    pub fn read_weights<B: Buffer>(
        &self,
        state: &FuzzyState<N, B>,
        weights: &mut [f64],
    ) -> Result<()> {
        self.check_length(weights)?;
        weights.fill(0.0);
        (0..self.matrices()).for_each(|matrix| self.read_matrix(state, matrix, weights));
        Ok(())
    }

    /// Replaces W by known weights, row-major (N × rules); adaptation goes on from there.
    ///
    /// # Errors
    /// `weights`: wrong length, not finite, or larger than 1e150; farther from zero than the
    /// projection's radius, which would draw them back within a step. The state is then as before.
    pub fn load_weights<B: Buffer>(
        &self,
        state: &mut FuzzyState<N, B>,
        weights: &[f64],
    ) -> Result<()> {
        self.check_weights(weights, false)?;
        state.clear();
        self.write_matrix(state, settable(weights), 0);
        Ok(())
    }

    /// As [`load_weights`](Self::load_weights), and makes them W₀: what leak, e-modification and
    /// projection pull to.
    ///
    /// # Errors
    /// As `load_weights`, but that no radius bounds W₀.
    pub fn warm_start<B: Buffer>(
        &self,
        state: &mut FuzzyState<N, B>,
        weights: &[f64],
    ) -> Result<()> {
        self.check_weights(weights, true)?;
        state.clear();
        self.write_matrix(state, settable(weights), self.matrices() - 1);
        Ok(())
    }

    /// Adds W − W₀ (matrix 0) or W₀ (matrix 1) to `weights`.
    pub(super) fn read_matrix<B: Buffer>(
        &self,
        state: &FuzzyState<N, B>,
        matrix: usize,
        weights: &mut [f64],
    ) {
        let rows = state.rows(matrix, self.places.matrix, self.basis.row_len());
        for (padded, row) in rows.zip(weights.chunks_exact_mut(self.basis.block_rules())) {
            self.basis.add_unpacked(padded, row);
        }
    }

    /// Sets W − W₀ (matrix 0) or W₀ (matrix 1).
    fn write_matrix<B: Buffer>(
        &self,
        state: &mut FuzzyState<N, B>,
        mut weights: impl Iterator<Item = f64>,
        matrix: usize,
    ) {
        state.prior |= matrix == 1;
        let FuzzyState { memory, norms, .. } = state;
        let len = self.places.matrix;
        let place = &mut memory.as_mut_slice()[matrix * len..][..len];
        for (padded, norm) in place.chunks_exact_mut(self.basis.row_len()).zip(norms.iter_mut()) {
            self.basis.places().zip(&mut weights).for_each(|(place, w)| padded[place] = w);
            if matrix == 0 {
                *norm = norm_squared(padded);
            }
        }
    }

    /// Refuses what cannot become the weights, or with `prior` W₀.
    pub(crate) fn check_weights(&self, weights: &[f64], prior: bool) -> Result<()> {
        self.check_length(weights)?;
        within("weights", weights, usable, USABLE)?;
        if prior && self.matrices() > 1 {
            return Ok(());
        }
        self.update.check_radius(weights.iter().map(|w| w * w).sum())
    }

    fn check_length(&self, weights: &[f64]) -> Result<()> {
        length("weights", weights.len(), self.weights_len())
    }

    /// W − W₀, and W₀ where something pulls the weights to it.
    pub(super) fn matrices(&self) -> usize {
        if self.update.parameters.adaptation.pulls() { 2 } else { 1 }
    }
}

/// What a weight may be.
/// Weights whose squares add up to more do not go side by side with others: they might come to be
/// refused.
const MOST_NORM: f64 = 1e200;

const USABLE: &str = "weights of at most 1e150";

/// Weights as they are set, without tiny ones.
fn settable(weights: &[f64]) -> impl Iterator<Item = f64> {
    weights.iter().map(|w| unless_tiny(*w, TINY_WEIGHT))
}

fn usable(weight: f64) -> bool {
    weight.abs() <= MAX_WEIGHT
}

impl Places {
    fn new<T: Buffer>(basis: &FuzzyBasis<T>, joints: usize, prior: bool) -> Self {
        let matrix = joints * basis.row_len();
        let stages = if prior { 2 * matrix } else { matrix };
        let stage = basis.activation_len();
        let x = stages + MAX_STAGES * stage;
        let scratch = x + basis.inputs();
        Self { matrix, stages, stage, x, scratch, end: scratch + basis.scratch_len() }
    }
}

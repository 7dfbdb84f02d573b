//! What [`LearnedTorque`] remembers, and where it stands in the memory that the caller lends.

use super::learned_torque::LearnedTorque;
use super::regression::Regression;
use crate::arm::Parametric;
use crate::control::MAX_DELAY;
use crate::error::Result;
use crate::fuzzy::{Buffer, Memory};
use crate::math::{Matrix, Vector};

/// What it remembers.
#[derive(Clone, Debug)]
pub struct LearnedTorqueState<const N: usize, B: Buffer> {
    /// θ, P, room for a gain, LP[Φ], the columns of the last samples, scratch.
    pub(super) memory: Memory<B>,
    pub(super) filtered: Filtered<N>,
    /// What was decided in the last samples, in turn.
    pub(super) decided: [Decided<N>; MAX_DELAY + 1],
    /// Periods that ended.
    pub(super) periods: u64,
    pub(super) frozen: bool,
    pub(super) now: Now<N>,
}

/// Signals through filters, after the last period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Filtered<const N: usize> {
    /// ė' [rad/s], and the same through the filter of friction.
    pub velocity: Vector<N>,
    pub slow: Vector<N>,
    /// ζ [rad/s²].
    pub zeta: Vector<N>,
    /// LP[τ_a − ID₀] [N·m], and LP[Dė'] [N·m·s].
    pub torque: Vector<N>,
    pub momentum: Vector<N>,
    /// LP of whether a joint rests, and of whether the arm is far off or its torque limited.
    pub rest: Vector<N>,
    pub astray: f64,
    /// Length of the last period, and time since P last forgot \[s\].
    pub period: f64,
    pub since: f64,
}

/// What was decided for a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Decided<const N: usize> {
    /// Φθ + Dv [N·m].
    pub torque: Vector<N>,
    /// v [rad/s²].
    pub v: Vector<N>,
    /// q̇_d [rad/s].
    pub dq: Vector<N>,
}

/// What the sample at hand gave, worked out again for one that is pending after a load.
#[derive(Clone, Copy, Debug)]
pub(super) struct Now<const N: usize> {
    /// ė' [rad/s].
    pub velocity: Vector<N>,
    /// α [rad/s²].
    pub alpha: Vector<N>,
    pub weight: Matrix<N>,
    /// τ_a − τ_asked [N·m].
    pub cut: Vector<N>,
    pub far: bool,
    pub decided: Decided<N>,
    /// Φθ and Dα [N·m].
    pub learned: Vector<N>,
    pub observed: Vector<N>,
}

/// The parts of the memory.
pub(super) struct Parts<'a> {
    pub regression: Regression<'a>,
    /// LP[Φ]: `N` rows of K, and `N` of a joint's own.
    pub inertial: &'a mut [f64],
    pub own: &'a mut [f64],
    /// Columns of the last samples, in turn.
    pub columns: &'a mut [f64],
    pub work: &'a mut [f64],
}

impl<const N: usize> Filtered<N> {
    fn new() -> Self {
        let zeros = Vector::zeros();
        Self {
            velocity: zeros,
            slow: zeros,
            zeta: zeros,
            torque: zeros,
            momentum: zeros,
            rest: zeros,
            astray: 0.0,
            period: 0.0,
            since: 0.0,
        }
    }
}

impl<const N: usize> Decided<N> {
    pub fn nothing() -> Self {
        let zeros = Vector::zeros();
        Self { torque: zeros, v: zeros, dq: zeros }
    }
}

impl<const N: usize> Now<N> {
    fn new() -> Self {
        let zeros = Vector::zeros();
        let (weight, decided) = (Matrix::zeros(), Decided::nothing());
        Self {
            velocity: zeros,
            alpha: zeros,
            weight,
            cut: zeros,
            far: false,
            decided,
            learned: zeros,
            observed: zeros,
        }
    }
}

impl<const N: usize, B: Buffer> LearnedTorqueState<N, B> {
    /// Stops learning; what was learnt stays in use, and the observer goes on.
    pub fn freeze(&mut self) {
        self.frozen = true;
    }

    /// Lets learning go on.
    pub fn unfreeze(&mut self) {
        self.frozen = false;
    }

    /// Whether learning is stopped.
    pub fn frozen(&self) -> bool {
        self.frozen
    }
}

impl<const N: usize, const K: usize, A: Parametric<N, K>> LearnedTorque<N, K, A> {
    /// Length of the buffer of [`state_in`](Self::state_in).
    pub fn buffer_len(&self) -> usize {
        Memory::<&mut [f64]>::buffer_len(self.len())
    }

    /// A state before the first sample, in memory that the caller lends.
    ///
    /// # Errors
    /// `buffer`: shorter than [`buffer_len`](Self::buffer_len).
    pub fn state_in<B: Buffer>(&self, buffer: B) -> Result<LearnedTorqueState<N, B>> {
        Ok(self.over(Memory::new(buffer, self.len())?))
    }

    /// A state before the first sample.
    #[cfg(feature = "std")]
    pub fn state(&self) -> LearnedTorqueState<N, Vec<f64>> {
        self.over(Memory::on_heap(self.len()))
    }

    fn over<B: Buffer>(&self, memory: Memory<B>) -> LearnedTorqueState<N, B> {
        let mut state = LearnedTorqueState {
            memory,
            filtered: Filtered::new(),
            decided: [Decided::nothing(); MAX_DELAY + 1],
            periods: 0,
            frozen: false,
            now: Now::new(),
        };
        self.begin(&mut state);
        state
    }

    fn len(&self) -> usize {
        self.sizes().iter().sum()
    }

    /// Of θ, P, a gain, LP[Φ] in two parts, columns, scratch.
    fn sizes(&self) -> [usize; 7] {
        let it = &self.features;
        let (stride, rows) = (it.stride(), it.parameters());
        let turns = self.gains.delay + 1;
        [stride, stride * rows, stride, N * K, N * it.own(), turns * it.columns(), it.work()]
    }

    pub(super) fn parts<'s>(&self, mut rest: &'s mut [f64]) -> Parts<'s> {
        let [theta, p, gain, inertial, own, columns, work] = self.sizes().map(|size| {
            let (part, more) = core::mem::take(&mut rest).split_at_mut(size);
            rest = more;
            part
        });
        Parts { regression: Regression { theta, p, gain }, inertial, own, columns, work }
    }

    /// θ, P, and the filtered and last columns: what is saved of the memory.
    pub(super) fn kept<'s>(&self, memory: &'s [f64]) -> [&'s [f64]; 3] {
        let [stride, cells, gain, ..] = self.sizes();
        let (theta, rest) = memory.split_at(stride);
        let (p, rest) = rest.split_at(cells);
        [&theta[..self.features.parameters()], p, &rest[gain..][..self.columns_kept()]]
    }

    /// Length of the last of them.
    pub(super) fn columns_kept(&self) -> usize {
        self.sizes()[3..6].iter().sum()
    }

    /// As before the first sample.
    pub(super) fn begin<B: Buffer>(&self, state: &mut LearnedTorqueState<N, B>) {
        state.memory.as_mut_slice().fill(0.0);
        self.parts(state.memory.as_mut_slice()).regression.reset(self.features.prior());
        state.filtered = Filtered::new();
        state.decided = [Decided::nothing(); MAX_DELAY + 1];
        (state.periods, state.frozen, state.now) = (0, false, Now::new());
    }
}

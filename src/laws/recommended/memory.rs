//! What [`LearnedTorque`] remembers, and where it stands in the memory that the caller lends.

use super::learned_torque::LearnedTorque;
use super::regression::Regression;
use crate::arm::Parametric;
use crate::control::MAX_DELAY;
use crate::error::Result;
use crate::fuzzy::{Buffer, Memory};
use crate::math::{Matrix, Vector, column};

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
    /// D at the sample at hand, and Dα [N·m].
    pub(super) weight: Matrix<N>,
    pub(super) observed: Vector<N>,
}

/// Signals through filters, after the last period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Filtered<const N: usize, T = f64> {
    /// ė' [rad/s], and the same through the filter of friction.
    pub velocity: Vector<N, T>,
    pub slow: Vector<N, T>,
    /// ζ [rad/s²].
    pub zeta: Vector<N, T>,
    /// LP[τ_a − ID₀] [N·m], and LP[Dė'] [N·m·s].
    pub torque: Vector<N, T>,
    pub momentum: Vector<N, T>,
    /// LP of whether a joint rests, and of whether the arm is far off or its torque limited.
    pub rest: Vector<N, T>,
    pub astray: T,
    /// Length of the last period, and time since P last forgot \[s\].
    pub period: f64,
    pub since: f64,
}

/// What was decided for a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Decided<const N: usize, T = f64> {
    /// Φθ + Dv [N·m].
    pub torque: Vector<N, T>,
    /// v [rad/s²].
    pub v: Vector<N, T>,
    /// q̇_d [rad/s].
    pub dq: Vector<N, T>,
}

/// What the sample at hand gave, worked out again for one that is pending after a load.
#[derive(Clone, Copy, Debug)]
pub(super) struct Now<const N: usize, T = f64> {
    /// ė' [rad/s].
    pub velocity: Vector<N, T>,
    /// α [rad/s²].
    pub alpha: Vector<N, T>,
    /// τ_a − τ_asked [N·m].
    pub cut: Vector<N, T>,
    /// 1 where a joint is far from the desired motion, and 0 elsewhere.
    pub far: T,
    pub decided: Decided<N, T>,
    /// Φθ [N·m].
    pub learned: Vector<N, T>,
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

impl<const N: usize, T: Copy> Filtered<N, T> {
    /// Before the first period.
    pub fn of(zero: T) -> Self {
        let zeros = column([zero; N]);
        Self {
            velocity: zeros,
            slow: zeros,
            zeta: zeros,
            torque: zeros,
            momentum: zeros,
            rest: zeros,
            astray: zero,
            period: 0.0,
            since: 0.0,
        }
    }
}

impl<const N: usize, T: Copy> Decided<N, T> {
    pub fn nothing(zero: T) -> Self {
        let zeros = column([zero; N]);
        Self { torque: zeros, v: zeros, dq: zeros }
    }
}

impl<const N: usize, T: Copy> Now<N, T> {
    /// Before the first sample.
    pub fn of(zero: T) -> Self {
        let (zeros, decided) = (column([zero; N]), Decided::nothing(zero));
        Self { velocity: zeros, alpha: zeros, cut: zeros, far: zero, decided, learned: zeros }
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
            filtered: Filtered::of(0.0),
            decided: [Decided::nothing(0.0); MAX_DELAY + 1],
            periods: 0,
            frozen: false,
            now: Now::of(0.0),
            weight: Matrix::zeros(),
            observed: Vector::zeros(),
        };
        self.begin(&mut state);
        state
    }

    fn len(&self) -> usize {
        self.sizes().iter().sum()
    }

    /// Of θ, P, a gain, LP[Φ] in two parts, columns, scratch.
    fn sizes(&self) -> [usize; 7] {
        let it = &self.features.shape;
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
        [&theta[..self.features.shape.parameters()], p, &rest[gain..][..self.columns_kept()]]
    }

    /// Length of the last of them.
    pub(super) fn columns_kept(&self) -> usize {
        self.sizes()[3..6].iter().sum()
    }

    /// As before the first sample.
    pub(super) fn begin<B: Buffer>(&self, state: &mut LearnedTorqueState<N, B>) {
        state.memory.as_mut_slice().fill(0.0);
        self.parts(state.memory.as_mut_slice()).regression.reset(self.features.prior());
        state.filtered = Filtered::of(0.0);
        state.decided = [Decided::nothing(0.0); MAX_DELAY + 1];
        (state.periods, state.frozen, state.now) = (0, false, Now::of(0.0));
        (state.weight, state.observed) = (Matrix::zeros(), Vector::zeros());
    }
}

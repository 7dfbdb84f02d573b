//! Which signals a compensator sees.

use super::Sample;
use crate::error::{Error, Result, at_most, not_empty, within};
use crate::math::Vector;

/// A signal of `N` joints.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Signal {
    /// Tracking error e = q − q_d \[rad\], in [−π, π) for a joint that turns without an end.
    E,
    /// ė [rad/s].
    De,
    /// Measured position \[rad\], as it was measured. A turn more is another input, even for a
    /// continuous joint.
    Q,
    /// Measured velocity [rad/s].
    Dq,
    /// Desired position \[rad\].
    QDesired,
    /// Desired velocity [rad/s].
    DqDesired,
    /// Desired acceleration [rad/s²].
    DdqDesired,
}

/// Number of different signals.
const SIGNALS: usize = 7;

impl Signal {
    /// All of them, in order.
    pub const ALL: [Self; SIGNALS] =
        [Self::E, Self::De, Self::Q, Self::Dq, Self::QDesired, Self::DqDesired, Self::DdqDesired];

    /// It in a sample, of all joints.
    #[inline(always)]
    pub(crate) fn of<const N: usize, T>(self, sample: &Sample<N, T>) -> &Vector<N, T> {
        match self {
            Self::E => &sample.e,
            Self::De => &sample.de,
            Self::Q => &sample.q,
            Self::Dq => &sample.dq,
            Self::QDesired => &sample.desired.q,
            Self::DqDesired => &sample.desired.dq,
            Self::DdqDesired => &sample.desired.ddq,
        }
    }

    /// Its name in files and in Python.
    pub const fn name(self) -> &'static str {
        match self {
            Self::E => "e",
            Self::De => "de",
            Self::Q => "q",
            Self::Dq => "dq",
            Self::QDesired => "q_d",
            Self::DqDesired => "dq_d",
            Self::DdqDesired => "ddq_d",
        }
    }
}

/// An ordered choice of signals, each multiplied by a scale before it reaches the sets.
///
/// The inputs are joint after joint within a signal: `[e₁, e₂, ė₁, ė₂]` for two joints and
/// [`Inputs::error`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inputs {
    chosen: [(Signal, f64); SIGNALS],
    count: usize,
}

impl Inputs {
    /// Signals in this order, each with its scale.
    ///
    /// # Errors
    /// `inputs`: none, more than seven, or one twice. `scale`: not finite, or zero.
    pub fn new(signals: &[(Signal, f64)]) -> Result<Self> {
        let count = signals.len();
        not_empty("inputs", count)?;
        at_most("inputs", count, SIGNALS)?;
        let mut chosen = [(Signal::E, 1.0); SIGNALS];
        for (i, &(signal, scale)) in signals.iter().enumerate() {
            within("scale", &[scale], |s| s != 0.0, "a number other than 0")?;
            if signals[..i].iter().any(|(other, _)| *other == signal) {
                return Err(Error::out_of_range("inputs", i as f64, "each signal once").at(i));
            }
            chosen[i] = (signal, scale);
        }
        Ok(Self { chosen, count })
    }

    /// (e, ė), the paper's choice: the compensator then acts as an integrator.
    pub fn error() -> Self {
        Self::unscaled(&[Signal::E, Signal::De])
    }

    /// (q, q̇): what is learnt belongs to a place, and stays right when learning stops.
    pub fn state() -> Self {
        Self::unscaled(&[Signal::Q, Signal::Dq])
    }

    /// (q_d, q̇_d): as `state`, without measurement noise.
    pub fn reference() -> Self {
        Self::unscaled(&[Signal::QDesired, Signal::DqDesired])
    }

    /// (q_d, q̇_d, q̈_d): a wrong inertia becomes learnable too.
    pub fn trajectory() -> Self {
        Self::unscaled(&[Signal::QDesired, Signal::DqDesired, Signal::DdqDesired])
    }

    fn unscaled(signals: &[Signal]) -> Self {
        let mut chosen = [(Signal::E, 1.0); SIGNALS];
        for (slot, &signal) in chosen.iter_mut().zip(signals) {
            slot.0 = signal;
        }
        Self { chosen, count: signals.len() }
    }

    /// The chosen signals with their scales.
    pub fn signals(&self) -> &[(Signal, f64)] {
        &self.chosen[..self.count]
    }

    /// Number of scalar inputs for `joints` joints.
    pub fn len(&self, joints: usize) -> usize {
        self.count * joints
    }

    /// Writes the scaled inputs of a sample to an `x` of [`len`](Self::len).
    #[inline]
    pub(crate) fn gather<const N: usize>(&self, sample: &Sample<N>, x: &mut [f64]) {
        for ((signal, scale), out) in self.signals().iter().zip(x.chunks_exact_mut(N)) {
            let values = signal.of(sample);
            for n in 0..N {
                out[n] = scale * values[n];
            }
        }
    }
}

//! When a controller acts: samples that come early or late, samples that are lost, torques that
//! arrive late.

use super::random::Random;
use crate::control::MAX_DELAY;
use crate::error::{Error, Result, within};

/// When a controller acts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Timing {
    /// Samples between a torque and the period in which it acts, at most [`MAX_DELAY`].
    pub delay: usize,
    /// By how much a period may differ from its length, as a share of it: sample k comes at
    /// (k + u) h with u even in ± jitter/2.
    pub jitter: f64,
    /// Probability that a sample is lost: the torque before it is held on.
    pub drop: f64,
}

/// The stream of random numbers of each.
const JITTER: u64 = 1;
const DROP: u64 = 2;

impl Timing {
    /// Refuses what makes no sense.
    ///
    /// # Errors
    /// `delay`: beyond [`MAX_DELAY`]. `jitter`: not in 0 … 0.9. `drop`: not in 0 … 0.9.
    pub fn validate(&self) -> Result<()> {
        if self.delay > MAX_DELAY {
            return Err(Error::too_many("delay", Some(self.delay), MAX_DELAY));
        }
        let share = |x: f64| (0.0..=0.9).contains(&x);
        within("jitter", &[self.jitter], share, "a share of the period, 0 to 0.9")?;
        within("drop", &[self.drop], share, "a probability, 0 to 0.9")
    }
}

/// Tells when the samples of a run come.
pub(crate) struct Clock {
    timing: Timing,
    period: f64,
    /// Number and time \[s\] of the next sample.
    number: u64,
    next: f64,
    jitter: Random,
    drop: Random,
}

impl Clock {
    /// The clock of a run. The first sample comes at time 0.
    pub fn new(timing: Timing, period: f64, seed: u64) -> Self {
        let (jitter, drop) = (Random::new(seed, JITTER), Random::new(seed, DROP));
        Self { timing, period, number: 0, next: 0.0, jitter, drop }
    }

    /// The time of the next sample \[s\].
    pub fn next(&self) -> f64 {
        self.next
    }

    /// Takes the sample that was next; false if it is lost. The first one never is.
    pub fn take(&mut self) -> bool {
        let kept = self.number == 0 || self.drop.uniform() >= self.timing.drop;
        self.number += 1;
        let off = match self.timing.jitter {
            0.0 => 0.0,
            jitter => jitter * (self.jitter.uniform() - 0.5),
        };
        self.next = (self.number as f64 + off) * self.period;
        kept
    }
}

//! What a joint can do: the ends of its range, its largest speed and torque.

use super::place::Of;
use crate::error::{Error, Result};

/// What a joint can do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointLimits {
    /// Smallest position [rad or m].
    pub lower: f64,
    /// Largest position [rad or m].
    pub upper: f64,
    /// Largest speed [rad/s or m/s].
    pub velocity: f64,
    /// Largest torque [N·m] or force \[N\].
    pub effort: f64,
}

impl JointLimits {
    /// Refuses NaN, limits that no position can meet, and a speed or effort that is not > 0.
    ///
    /// # Errors
    /// `NotFinite` or `OutOfRange`, naming `limits.lower`, `limits.upper`, `limits.velocity` or
    /// `limits.effort`.
    pub fn validate(&self, joint: usize) -> Result<()> {
        let of = |parameter| Of { parameter, joint: Some(joint) };
        let number = |parameter, got: f64| {
            let nan = Error::not_finite(parameter, got).at(joint);
            if got.is_nan() { Err(nan) } else { Ok(()) }
        };
        number("limits.lower", self.lower)?;
        number("limits.upper", self.upper)?;
        number("limits.velocity", self.velocity)?;
        number("limits.effort", self.effort)?;
        let below_infinity = self.lower < f64::INFINITY;
        of("limits.lower").accept(self.lower, below_infinity, "less than +infinity")?;
        let reachable = self.upper >= self.lower && self.upper > f64::NEG_INFINITY;
        of("limits.upper").accept(self.upper, reachable, "at least limits.lower")?;
        of("limits.velocity").accept(self.velocity, self.velocity > 0.0, "a number > 0")?;
        of("limits.effort").accept(self.effort, self.effort > 0.0, "a number > 0")
    }
}

//! How a run ended.

use core::fmt;

use super::doubt::Doubt;
use crate::error::Error;

/// Why a run ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Status {
    /// It reached its duration.
    Finished,
    /// It reached its duration, in steps too long to be believed.
    Unresolved(Doubt),
    /// It was stopped from outside at this time \[s\].
    Interrupted {
        /// Time of the last step \[s\].
        t: f64,
    },
    /// It could not go on.
    Diverged {
        /// Time at which that was noticed \[s\].
        t: f64,
        /// What happened.
        cause: Cause,
        /// Steps that were too long before that, which may be why.
        doubt: Option<Doubt>,
    },
}

/// Why a run could not go on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cause {
    /// The reference is not finite.
    Reference,
    /// The disturbance, or the acceleration it leads to, is not finite.
    Acceleration,
    /// A position or velocity passed 1e6.
    Motion,
    /// The error control asked for steps too short to advance the time.
    StepTooShort,
    /// The controller refused the sample.
    Rejected(Error),
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Reference => f.write_str("the reference is not finite"),
            Self::Acceleration => {
                f.write_str("the torque, disturbance or acceleration is not finite")
            }
            Self::Motion => f.write_str("a position or velocity passed 1e6 rad or rad/s"),
            Self::StepTooShort => {
                f.write_str("the error control asked for steps too short to advance the time")
            }
            Self::Rejected(error) => write!(f, "the controller refused the sample: {error}"),
        }
    }
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Finished => f.write_str("finished"),
            Self::Unresolved(doubt) => write!(f, "finished, but not resolved: {doubt}"),
            Self::Interrupted { t } => write!(f, "interrupted at t = {t:.6} s"),
            Self::Diverged { t, cause, doubt } => {
                write!(f, "diverged at t = {t:.6} s because {cause}")?;
                doubt.map_or(Ok(()), |doubt| write!(f, "; before that, {doubt}"))
            }
        }
    }
}

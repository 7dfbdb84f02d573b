//! What can be known before a run: the linear model of one joint, its poles, its accuracy and its
//! sampling limits, and a report with a verdict; and whether a reference stays within an arm's
//! limits.

mod limits;
mod linear_model;
#[cfg(feature = "std")]
mod report;
#[cfg(feature = "std")]
mod subject;

pub use limits::{Bound, Excess, LimitCheck, check_limits};
pub use linear_model::{LinearModel, MAX_DELAY};
#[cfg(feature = "std")]
pub use report::{Conditions, Finding, JointReport, Report};
#[cfg(feature = "std")]
pub use subject::Subject;

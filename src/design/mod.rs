//! What can be known before a run: the linear model of one joint, its poles, its accuracy and its
//! sampling limits, and a report with a verdict; and whether a reference stays within an arm's
//! limits.
//!
//! The way through: `Conditions` say for what; `LinearModel` is one joint; `Course` is a path with
//! the arms along it, which `sampled_loop` makes one loop of, and `loops` several: on the path and
//! away from it, as `excursions` has the rules there; `learning` says what they can hold;
//! `joint_design` judges a joint, `choices` what was chosen, in the words of `Finding`; `Report` is
//! all of it.

#[cfg(feature = "std")]
mod choices;
#[cfg(feature = "std")]
mod conditions;
#[cfg(feature = "std")]
mod course;
#[cfg(feature = "std")]
mod excursions;
#[cfg(feature = "std")]
mod figure;
#[cfg(feature = "std")]
mod finding;
#[cfg(feature = "std")]
mod joint_design;
#[cfg(feature = "std")]
mod learning;
mod limits;
mod linear_model;
#[cfg(feature = "std")]
mod loops;
#[cfg(feature = "std")]
mod report;
#[cfg(feature = "std")]
mod sampled_loop;
#[cfg(feature = "std")]
mod spectrum;
#[cfg(feature = "std")]
mod subject;

#[cfg(feature = "std")]
pub use choices::Choices;
#[cfg(feature = "std")]
pub use conditions::Conditions;
#[cfg(feature = "std")]
pub use course::{Course, Local, Point};
#[cfg(feature = "std")]
pub use finding::Finding;
#[cfg(feature = "std")]
pub use joint_design::JointReport;
#[cfg(feature = "std")]
pub use learning::Learning;
pub use limits::{Bound, Excess, LimitCheck, check_limits};
pub use linear_model::{LinearModel, MAX_DELAY};
#[cfg(feature = "std")]
pub use report::{ArmFacts, Report};
#[cfg(feature = "std")]
pub use subject::Subject;

//! The controller that we recommend: the torque that the arm was seen to need, learnt and fed
//! forward.
//!
//! The way through: `feed_forward` is the law, `pull` its way back to the path. `learned_torque`
//! goes with it: `features` says what a torque is made of, `estimate` gives it for a sample,
//! `learning` takes a row a period to `regression`, which learns how much of each; `memory` is what
//! is remembered, `saved` writes it. `rule` chooses the `gains`: `frozen_loop` has the roots of the
//! sampled loop, `condition` whether what is learnt converges. `abreast/` has eight of these
//! controllers side by side.

#[cfg(feature = "std")]
mod abreast;
#[cfg(feature = "std")]
mod condition;
mod estimate;
mod features;
mod feed_forward;
#[cfg(feature = "std")]
mod frozen_loop;
mod gains;
mod learned_torque;
mod learning;
mod memory;
mod pull;
mod regression;
#[cfg(feature = "std")]
mod rule;
mod saved;

pub use features::Learns;
pub use feed_forward::FeedForward;
pub use gains::LearningGains;
pub use learned_torque::LearnedTorque;
pub use memory::LearnedTorqueState;
pub use pull::Pull;
#[cfg(feature = "std")]
pub use rule::{Circumstances, Rule};

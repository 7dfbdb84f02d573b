//! The controller that we recommend: the torque that the arm was seen to need, learnt and fed
//! forward.
//!
//! `feed_forward` is the law, `pull` its way back to the path, `learned_torque` what goes with it: `features` says what a torque is
//! made of, `regression` learns how much of each, `saved` writes what it remembers. `rule` chooses
//! all gains: `frozen_loop` has the roots of the sampled loop, `condition` whether what is learnt
//! converges.

#[cfg(feature = "std")]
mod condition;
mod features;
mod feed_forward;
#[cfg(feature = "std")]
mod frozen_loop;
mod learned_torque;
mod pull;
mod regression;
#[cfg(feature = "std")]
mod rule;
mod saved;

pub use feed_forward::FeedForward;
pub use learned_torque::{LearnedTorque, LearnedTorqueState, LearningGains, Learns};
pub use pull::Pull;
#[cfg(feature = "std")]
pub use rule::{Circumstances, Rule};

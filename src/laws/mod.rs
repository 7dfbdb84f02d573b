//! Rivals: the control laws of the paper and of the field, one file each, for any arm.
//!
//! Each is a [`Feedback`](crate::control::Feedback) of computed torque, a
//! [`Law`](crate::control::Law) of its own, a [`Dynamic`](crate::control::Dynamic) that goes with
//! either, or a [`Compensator`](crate::control::Compensator).
//!
//! | law | goes with | memory | take it when |
//! |---|---|---|---|
//! | [`FeedForward`] | [`LearnedTorque`] | θ, P, ζ | masses are known roughly: take it first |
//! | [`PdGravity`] | itself | – | no mass matrix is known; slow motions |
//! | [`Integral`] | computed torque | ∫e | constant pushes and gravity that is off |
//! | [`SlidingMode`] | computed torque | – | a bound of the mismatch is known, noise is low |
//! | [`Robust`] | computed torque | – | as above, with a proof for all joints at once |
//! | [`HInfinity`] | computed torque | – | the paper's feedback with the robust term it left out |
//! | [`SuperTwisting`] | computed torque | ∫sgn s | pushes of bounded rate, low noise |
//! | [`Rise`] | computed torque | ∫ | as above, smooth pushes, no noise |
//! | [`RbfNetwork`] | computed torque | W | Feng's network, the paper's refs. 3 and 4 |
//! | [`AdaptiveComputedTorque`] | computed torque | θ̃ | quiet velocities; slow changes |
//! | [`Passive`] | itself | – | no inverse of M is wanted; proofs |
//! | [`AdaptiveParameters`] | passive law | θ̃ | loads that change slowly; a proof |
//! | [`NaturalParameters`] | passive law | F of P | as above; bodies stay possible |
//! | [`PassiveFuzzy`] | passive law | W | what no parameter describes; a proof |
//! | [`DisturbanceObserver`] | any | d̂ | a good first addition to computed torque |
//! | [`MomentumObserver`] | any | p̂ | as above, the same pole at every joint |
//! | [`TimeDelay`] | the same, on [`Inertia`] | τ, q̇ | a rough inertia, quiet velocities |
//!
//! The first has its gains from a `Rule`. Every other one has gains from a bandwidth p [rad/s],
//! `with_bandwidth`, and nothing to tune beside it
//! but what is declared: a [`Mismatch`] of the model, a [`Pace`] of what is to come. Where a law
//! has a condition, `suits(period, delay)` refuses gains that are too fast for a sampled loop, and
//! `covers` those that do not reach over the mismatch. What is learnt on computed torque or on the
//! passive law is slower than that law, whose `suits` then counts. With one p, and where M₀ hardly
//! changes, computed torque with a momentum observer is the PID of [`Integral`]; inside their
//! layers [`SlidingMode`], [`Robust`] and [`HInfinity`] are one and the same linear law.
//!
//! `bandwidth` has what these rules share; `believed` is the acceleration that a torque gives the
//! arm, as far as is known.

mod adaptive_computed_torque;
mod adaptive_parameters;
mod bandwidth;
mod disturbance_observer;
mod h_infinity;
mod inertia;
mod integral;
mod momentum_observer;
mod natural_parameters;
mod passive;
mod passive_fuzzy;
mod pd_gravity;
mod rbf_network;
mod recommended;
mod rise;
mod robust;
mod sliding_mode;
mod super_twisting;
mod time_delay;

pub use adaptive_computed_torque::{AdaptiveComputedTorque, AdaptiveComputedTorqueState};
pub use adaptive_parameters::AdaptiveParameters;
pub use bandwidth::Pace;
pub use disturbance_observer::DisturbanceObserver;
pub use h_infinity::HInfinity;
pub use inertia::Inertia;
pub use integral::Integral;
pub use momentum_observer::MomentumObserver;
pub use natural_parameters::NaturalParameters;
pub use passive::Passive;
pub use passive_fuzzy::PassiveFuzzy;
pub use pd_gravity::PdGravity;
pub use rbf_network::RbfNetwork;
#[cfg(feature = "std")]
pub use recommended::{Circumstances, Rule};
pub use recommended::{
    FeedForward, LearnedTorque, LearnedTorqueState, LearningGains, Learns, Pull,
};
pub use rise::Rise;
pub use robust::Robust;
pub use sliding_mode::{Mismatch, SlidingMode};
pub use super_twisting::SuperTwisting;
pub use time_delay::{TimeDelay, TimeDelayState};

use crate::arm::{Arm, Factor};
use crate::control::Sample;
use crate::math::Vector;

/// M₀⁻¹(τ − H₀) at the measured state: the acceleration that τ gives the arm as the law knows it.
fn believed<const N: usize>(arm: &impl Arm<N>, seen: &Sample<N>, tau: &Vector<N>) -> Vector<N> {
    let (mass, bias) = arm.mass_matrix_and_bias(&seen.q, &seen.dq);
    Factor::of(&mass).solve(&(tau - bias))
}

/// s = ė + Λe [rad/s].
fn sliding<const N: usize>(lambda: &[f64; N], seen: &Sample<N>) -> Vector<N> {
    Vector::from_fn(|n, _| seen.de[n] + lambda[n] * seen.e[n])
}

/// sgn x, with sgn 0 = 0.
fn sign(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.signum() }
}

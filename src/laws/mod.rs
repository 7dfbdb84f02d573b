//! Rivals: the control laws of the paper and of the field, one file each, for any arm.
//!
//! Each is a [`Feedback`](crate::control::Feedback) of computed torque, a
//! [`Law`](crate::control::Law) of its own, or a [`Dynamic`](crate::control::Dynamic) that goes
//! with either. `believed` is the acceleration that a torque gives the arm, as far as is known.
//!
//! | law | feedback or law | memory | take it when |
//! |---|---|---|---|
//! | [`PdGravity`] | law | – | no mass matrix is known; slow motions |
//! | [`Integral`] on computed torque | gains | ∫e | constant pushes and gravity that is off |
//! | [`SlidingMode`] | feedback | – | a bound of the mismatch is known, noise is low |
//! | [`Robust`] | feedback | – | as above, with a proof for all joints at once |
//! | [`HInfinity`] | feedback | – | the paper's feedback with the robust term it left out |
//! | [`SuperTwisting`] | feedback | ∫sgn s | pushes of bounded rate, low noise |
//! | [`Rise`] | feedback | ∫ | as above, smooth pushes, no noise |
//! | [`Passive`] | law | – | no inverse of M is wanted; proofs |
//! | [`AdaptiveParameters`] on the passive law | law | θ̃ | loads that change slowly; a proof |
//! | [`DisturbanceObserver`] | any | d̂ | a good first addition to computed torque |
//! | [`MomentumObserver`] | any | p̂ | as above, the same pole at every joint |
//! | [`TimeDelay`] | [`Inertia`] | τ, q̇ | no model but a rough inertia; quiet velocities |

mod adaptive_parameters;
mod disturbance_observer;
mod h_infinity;
mod inertia;
mod integral;
mod momentum_observer;
mod passive;
mod pd_gravity;
mod rise;
mod robust;
mod sliding_mode;
mod super_twisting;
mod time_delay;

pub use adaptive_parameters::AdaptiveParameters;
pub use disturbance_observer::DisturbanceObserver;
pub use h_infinity::HInfinity;
pub use inertia::Inertia;
pub use integral::Integral;
pub use momentum_observer::MomentumObserver;
pub use passive::Passive;
pub use pd_gravity::PdGravity;
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

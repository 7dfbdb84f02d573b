//! Tracking control of robot arms whose dynamics nobody knows exactly: computed torque for the arm
//! you believe in, and an adaptive fuzzy compensator for what that model leaves out.
//!
//! ```text
//! τ = M₀(q)(v − ρ̂) + H₀(q, q̇)        v = q̈_d − K_v ė − K_p e,   ρ̂ = W ξ(x)
//! Ẇ = gain · BᵀPx ξᵀ                   AᵀP + PA + γ⁻² P B Bᵀ P + Q = 0
//! ```
//!
//! Configuration is immutable, state is separate, the caller owns both, one function advances time:
//!
//! ```
//! use steadyarm::{control::State, paper, reference::Reference};
//!
//! # fn main() -> steadyarm::Result<()> {
//! let controller = paper::controller(paper::CLAIMED)?;
//! let mut state = State::new(controller.compensator.state());
//! let (q, dq) = ([0.0; 2].into(), [0.0; 2].into());
//! let command = controller.step(&mut state, &q, &dq, &paper::reference()?.at(0.0), 1e-3)?;
//! assert!(command.tau.iter().all(|tau| tau.is_finite()));
//! # Ok(())
//! # }
//! ```
//!
//! | module | what |
//! |---|---|
//! | [`arm`] | dynamics: [`arm::Arm`], [`arm::TwoLink`], [`arm::Serial`] for any chain |
//! | [`control`] | [`control::Controller`]: a law, a compensator, limits |
//! | [`laws`] | rivals: the control laws of the field, for any arm |
//! | [`fuzzy`] | the basis ξ(x), and as a plain function approximator |
//! | [`riccati`] | the equations for P, certified or refused |
//! | [`design`] | what a design will do, before it runs |
//! | [`plant`], [`mod@reference`] | what is really there, and where it should go |
//! | `robot` | serial arms from URDF, DH tables, TOML (feature `std`, files `urdf`) |
//! | `scenario` | every parameter under one name, read from TOML (feature `urdf`) |
//! | `sim` | closed-loop simulation with its record and certificate (feature `std`) |
//! | [`paper`] | the paper's three simulations |
//!
//! Without `std` (`default-features = false, features = ["libm"]`) the crate needs no allocator:
//! give [`control::FuzzyCompensator::state_in`] a buffer, and [`fuzzy::FuzzyBasis::new_in`] another
//! where the basis has more sets than its own [`fuzzy::Room`].
#![cfg_attr(not(feature = "std"), no_std)]
#![forbid(unsafe_code)]

#[cfg(not(any(feature = "std", feature = "libm")))]
compile_error!(
    "without `std` the crate needs the feature `libm`: default-features = false, features = \
     [\"libm\"]"
);

pub mod arm;
pub mod control;
pub mod design;
#[cfg(feature = "std")]
pub mod effects;
pub mod eigen;
pub mod error;
pub mod fuzzy;
pub mod laws;
pub mod math;
pub mod paper;
pub mod plant;
#[cfg(feature = "python")]
mod python;
pub mod reference;
pub mod riccati;
#[cfg(feature = "std")]
pub mod robot;
#[cfg(feature = "urdf")]
pub mod scenario;
#[cfg(feature = "std")]
pub mod sim;

pub use error::{Error, Problem, Result};

/// Runs the examples of README and manual as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
#[doc = include_str!("../docs/rust.md")]
#[doc = include_str!("../docs/real_loop.md")]
struct Manual;

//! Tracking control of robot arms whose dynamics nobody knows exactly.
#![cfg_attr(not(feature = "std"), no_std)]
#![forbid(unsafe_code)]
// Units stand in brackets, `[rad]`, and would be taken for links.
#![allow(rustdoc::broken_intra_doc_links)]

#[cfg(not(any(feature = "std", feature = "libm")))]
compile_error!(
    "without `std` the crate needs the feature `libm`: default-features = false, features = [\"libm\"]"
);

pub mod arm;
pub mod control;
pub mod design;
pub mod eigen;
pub mod error;
pub mod fuzzy;
pub mod math;
pub mod paper;
pub mod plant;
#[cfg(feature = "python")]
mod python;
pub mod reference;
pub mod riccati;
#[cfg(feature = "std")]
pub mod sim;

pub use error::{Error, Result};

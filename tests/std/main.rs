//! All tests that need std: simulations, tables on the heap, saved states, files. A module is named
//! after its room in src.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stdout,
    missing_docs
)]

#[path = "../common/chains.rs"]
#[allow(dead_code, unused_imports, unused_macros)]
mod chains;
#[path = "../common/mod.rs"]
mod common;
#[path = "../common/counting.rs"]
mod counting;
#[cfg(feature = "urdf")]
#[path = "../common/panda_numbers.rs"]
mod panda_numbers;
#[path = "../common/random.rs"]
mod random;
#[path = "../common/soak.rs"]
mod soak;

mod control;
mod design;
mod determinism;
mod effects;
mod elastic;
#[cfg(feature = "urdf")]
mod examples;
mod fuzzy;
mod golden;
mod kernel;
mod laws;
mod no_std_twin;
mod plant;
mod reference;
mod riccati;
#[cfg(feature = "urdf")]
mod robot;
#[cfg(feature = "urdf")]
mod scenario;
#[cfg(feature = "urdf")]
mod settings;
mod sim;
#[cfg(feature = "urdf")]
mod single;

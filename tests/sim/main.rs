//! Simulation: integrators, the loop a user would write, the dissipation identity, what was learnt, and runs that end.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

mod carry;
#[allow(dead_code, unused_imports, unused_macros)]
#[path = "../serial/chains.rs"]
mod chains;
#[path = "../common/mod.rs"]
mod common;
mod endings;
mod friction;
mod identity;
mod integrators;
mod learning;
mod loops;
#[path = "../common/random.rs"]
mod random;

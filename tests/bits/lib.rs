//! See `run.sh`.

#[cfg(test)]
#[path = "../common/mod.rs"]
mod common;
#[cfg(test)]
#[path = "../std/determinism.rs"]
mod determinism;
#[cfg(test)]
#[path = "../std/sim/many.rs"]
mod many;

//! See `run.sh`.

#[cfg(test)]
#[path = "../determinism.rs"]
mod determinism;

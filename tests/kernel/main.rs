//! The kernel form of the product grid: against the grid that is written out, what merging and dropping lose, and the
//! contract of a step.
#![allow(clippy::unwrap_used, missing_docs)]

#[path = "../common/mod.rs"]
mod common;
mod contract;
#[path = "../common/counting.rs"]
mod counting;
mod grid;
mod merging;
mod scene;

//! The kernel form of the product grid: against the grid that is written out, what merging and
//! dropping lose, and the contract of a step.

mod contract;
mod grid;
mod merging;
pub mod scene;

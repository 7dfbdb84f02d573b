//! Dynamics of serial chains: against Lagrange's equations, against themselves, against the closed form of two links, against
//! published numbers; and the refusals.
#![allow(missing_docs, clippy::unwrap_used, clippy::panic)]

#[path = "../common/random.rs"]
mod random;

mod bodies;
mod chains;
mod changes;
mod dynamics;
mod energy;
mod published;
mod refusals;
mod stops;

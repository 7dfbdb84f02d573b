//! Dynamics of serial chains: against Lagrange's equations, against themselves, against the closed
//! form of two links, against published numbers; and the refusals.

mod allocations;
mod bodies;
mod changes;
mod dynamics;
mod energy;
mod published;
mod refusals;
mod stops;

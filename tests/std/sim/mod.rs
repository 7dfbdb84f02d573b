//! Simulation: integrators, the loop a user would write, the dissipation identity, what was learnt,
//! and runs that end.

mod carry;
mod channels;
mod circle;
mod endings;
mod friction;
mod identity;
mod integrators;
mod learning;
mod loops;
mod many;

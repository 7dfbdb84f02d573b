//! Fuzzy systems with Gaussian sets and a linear output, y(x) = W ξ(x) (eqs. 1-4).

#[cfg(feature = "std")]
mod approximator;
mod axes;
mod basis;
mod form;
mod kernel_basis;
mod kronecker;
pub(crate) mod lanes;
mod lattice;
mod layout;
mod membership;
mod memory;
mod places;

#[cfg(feature = "std")]
pub use approximator::FuzzyApproximator;
pub use axes::Axis;
pub(crate) use basis::Activate;
pub use basis::FuzzyBasis;
pub use form::{Form, MAX_INPUTS, MAX_RULES, MAX_SETS};
pub use kernel_basis::KernelBasis;
pub(crate) use kernel_basis::{Compare, Kernel, Memberships, Nearest};
pub(crate) use lattice::{MOST_SPACED, Spaced};
pub(crate) use memory::Memory;
pub use memory::{Buffer, Room};

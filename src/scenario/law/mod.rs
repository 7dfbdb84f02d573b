//! The laws by name, with their gains: said one by one, or as a bandwidth for all.
//!
//! `settings` has the parameters of each law, as a file or a call says them; `build` makes the law
//! from them, with what it remembers, `adaptive` those that learn,
//! `recommended` the one whose gains follow from a rule; `adapts` is what of an arm
//! adaptation needs.

mod adaptive;
mod adapts;
mod build;
mod recommended;
mod settings;

#[cfg(feature = "python")]
pub(crate) use adapts::no_bodies;
pub use adapts::{Adapts, Natural, Uses};
pub use build::{Around, BuiltLaw};
pub use settings::*;

//! The arms that come with the crate and the wheel; each file names the publication of its figures.

use super::error::{listed, quoted};
use super::{Description, ReadError};

/// Names and texts, in the order of [`SHIPPED`].
const TEXTS: [&str; 3] = [
    include_str!("../../python/steadyarm/arms/panda.toml"),
    include_str!("../../python/steadyarm/arms/puma560.toml"),
    include_str!("../../python/steadyarm/arms/ur5e.toml"),
];

/// The names that [`shipped`] knows.
pub const SHIPPED: [&str; 3] = ["panda", "puma560", "ur5e"];

/// A shipped arm, by name.
///
/// # Errors
/// If there is none of that name.
pub fn shipped(name: &str) -> Result<Description, ReadError> {
    let known = SHIPPED.iter().position(|shipped| *shipped == name);
    match known.and_then(|index| TEXTS.get(index)) {
        Some(text) => Description::from_toml(text),
        None => Err(ReadError::new(format!(
            "shipped arm: got {}, wants one of {}",
            quoted(name),
            listed(SHIPPED.into_iter())
        ))),
    }
}

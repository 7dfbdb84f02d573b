//! Robot descriptions: URDF, Denavit-Hartenberg tables, TOML, and the arms that ship.
#![allow(clippy::unwrap_used, missing_docs)]

mod bodies;
mod broken;
mod chains;
mod dh;
mod dynamics;
mod hostile;
mod shipped;
mod tables;
mod toml;
mod valid;

#[path = "../common/random.rs"]
mod random;

//! Robot descriptions: URDF, Denavit-Hartenberg tables, TOML, and the arms that ship.

mod aside;
mod bodies;
mod broken;
mod chains;
mod dh;
mod dynamics;
mod hostile;
mod lenient;
mod masses;
mod rotors;
mod shipped;
mod tables;
mod toml;
mod valid;

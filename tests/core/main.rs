//! The tests of what works without std and without an allocator; and of the shape of the source.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

#[path = "../common/chains.rs"]
mod chains;
#[path = "../common/counting.rs"]
mod counting;
#[path = "../common/random.rs"]
mod random;

mod arm;
mod design;
mod eigen;
mod layers;
mod limits;
mod riccati;
mod room;
mod serial;
mod single;

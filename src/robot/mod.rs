//! Descriptions of serial arms: from URDF, from Denavit-Hartenberg tables, from our own TOML, and a
//! few that ship.
//!
//! A [`Description`] is what was read; [`Description::links`] turns it into the array that a serial
//! arm is built from. Files are taken for hostile: sizes and depths are limited, nothing but the
//! file named is opened, and every error says the line. Source of the format:
//! wiki.ros.org/urdf/XML.
// Without files, tables need only a part of the checks and turns.
#![cfg_attr(not(feature = "urdf"), allow(dead_code))]

mod build;
mod checks;
mod description;
mod dh;
mod error;
#[cfg(feature = "urdf")]
mod files;
mod frames;
#[cfg(feature = "urdf")]
mod shipped;
#[cfg(feature = "urdf")]
mod toml;
#[cfg(feature = "urdf")]
mod urdf;

pub use description::{Description, GRAVITY, JointDescription};
pub use dh::{Convention, DhRow};
pub use error::ReadError;
#[cfg(feature = "urdf")]
pub(crate) use files::limited;
#[cfg(feature = "urdf")]
pub use shipped::{SHIPPED, shipped};
#[cfg(feature = "urdf")]
pub use urdf::UrdfOptions;

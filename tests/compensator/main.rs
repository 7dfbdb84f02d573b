//! The adaptive law: rank-one updates against a dense integration, the robust modifications, what may be done to the
//! weights, and the refusals.
#![allow(clippy::unwrap_used, missing_docs)]

#[path = "../common/mod.rs"]
mod common;
mod dense;
mod histories;
mod saving;
mod weights;

//! What can be known before a run: the linear model of one joint, its poles, its accuracy and its sampling limits.

mod linear_model;

pub use linear_model::{LinearModel, MAX_DELAY};

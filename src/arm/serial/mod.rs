//! Any fixed-base chain of revolute and prismatic joints.

mod link;

pub use link::{Inertia, JointKind, JointLimits, Link, Pose};

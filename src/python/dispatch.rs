//! The joint count of the wheel.

use crate::math::{Matrix, Vector};

/// Number of joints.
pub(super) const JOINTS: usize = 2;

/// One value a joint.
pub(super) type JointVector = Vector<JOINTS>;

/// One value a pair of joints.
pub(super) type JointMatrix = Matrix<JOINTS>;

/// A joint matrix, row-major.
pub(super) fn rows(matrix: &JointMatrix) -> Vec<f64> {
    matrix.transpose().as_slice().to_vec()
}

//! Where a body is, and how its mass is distributed.

use crate::math::Matrix;

/// A frame in another one: x_outer = R x_inner + p.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// R, a rotation.
    pub rotation: Matrix<3>,
    /// p \[m\].
    pub translation: nalgebra::Vector3<f64>,
}

/// Mass distribution of a link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inertia {
    /// m \[kg\], ≥ 0.
    pub mass: f64,
    /// Centre of mass in the link's frame \[m\].
    pub com: nalgebra::Vector3<f64>,
    /// Moments about the centre of mass, in the axes of the link's frame [kg·m²].
    pub moments: Matrix<3>,
}

//! Turns about the axes.

use crate::arm::Pose;
use crate::math::{Matrix, sin_cos};

/// (sin, cos), exact at whole quarter turns: π/2 as a number of 53 bits means a right angle.
fn turn(angle: f64) -> (f64, f64) {
    use std::f64::consts::{FRAC_PI_2, PI};
    match angle {
        a if a == FRAC_PI_2 => (1.0, 0.0),
        a if a == -FRAC_PI_2 => (-1.0, 0.0),
        a if a == PI || a == -PI => (0.0, -1.0),
        a => sin_cos(a),
    }
}

/// A turn about x.
pub(super) fn about_x(angle: f64) -> Pose {
    let (s, c) = turn(angle);
    let rotation = Matrix::<3>::new(1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c);
    Pose { rotation, ..Pose::IDENTITY }
}

/// A turn about y.
fn about_y(angle: f64) -> Pose {
    let (s, c) = turn(angle);
    let rotation = Matrix::<3>::new(c, 0.0, s, 0.0, 1.0, 0.0, -s, 0.0, c);
    Pose { rotation, ..Pose::IDENTITY }
}

/// A turn about z.
pub(super) fn about_z(angle: f64) -> Pose {
    let (s, c) = turn(angle);
    let rotation = Matrix::<3>::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0);
    Pose { rotation, ..Pose::IDENTITY }
}

/// R = R_z(yaw) R_y(pitch) R_x(roll).
pub(super) fn roll_pitch_yaw([roll, pitch, yaw]: [f64; 3]) -> Matrix<3> {
    about_z(yaw).rotation * about_y(pitch).rotation * about_x(roll).rotation
}

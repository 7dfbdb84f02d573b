//! Poses one after another, and mass distributions seen from another frame.

use nalgebra::Vector3;

use crate::arm::{Inertia, Pose};
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

/// The frame itself.
pub(super) fn identity() -> Pose {
    Pose { rotation: Matrix::<3>::identity(), translation: Vector3::zeros() }
}

/// A shift by `translation`.
pub(super) fn shift(translation: [f64; 3]) -> Pose {
    Pose { translation: translation.into(), ..identity() }
}

/// A turn about x.
pub(super) fn about_x(angle: f64) -> Pose {
    let (s, c) = turn(angle);
    let rotation = Matrix::<3>::new(1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c);
    Pose { rotation, ..identity() }
}

/// A turn about y.
fn about_y(angle: f64) -> Pose {
    let (s, c) = turn(angle);
    let rotation = Matrix::<3>::new(c, 0.0, s, 0.0, 1.0, 0.0, -s, 0.0, c);
    Pose { rotation, ..identity() }
}

/// A turn about z.
pub(super) fn about_z(angle: f64) -> Pose {
    let (s, c) = turn(angle);
    let rotation = Matrix::<3>::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0);
    Pose { rotation, ..identity() }
}

/// R = R_z(yaw) R_y(pitch) R_x(roll).
pub(super) fn roll_pitch_yaw([roll, pitch, yaw]: [f64; 3]) -> Matrix<3> {
    about_z(yaw).rotation * about_y(pitch).rotation * about_x(roll).rotation
}

/// `inner` in the frame in which `outer` is given.
pub(super) fn compose(outer: &Pose, inner: &Pose) -> Pose {
    Pose {
        rotation: outer.rotation * inner.rotation,
        translation: outer.rotation * inner.translation + outer.translation,
    }
}

/// A mass distribution given in the frame `pose`, in the frame in which `pose` is given: c = R c' + p, I = R I' Rᵀ.
pub(super) fn carried(inertia: &Inertia, pose: &Pose) -> Inertia {
    Inertia {
        mass: inertia.mass,
        com: pose.rotation * inertia.com + pose.translation,
        moments: symmetric(pose.rotation * inertia.moments * pose.rotation.transpose()),
    }
}

/// Several bodies of one frame as one: I = Σ Iₖ + mₖ (dₖᵀdₖ 1 − dₖdₖᵀ), dₖ = cₖ − c.
pub(super) fn merged(parts: &[Inertia]) -> Inertia {
    match parts {
        [] => return Inertia::NONE,
        [one] => return *one,
        _ => {}
    }
    let mass: f64 = parts.iter().map(|part| part.mass).sum();
    let com = match mass > 0.0 {
        true => parts.iter().map(|part| part.com * part.mass).sum::<Vector3<f64>>() / mass,
        false => Vector3::zeros(),
    };
    let about = |part: &Inertia| {
        let d = part.com - com;
        part.moments + (Matrix::<3>::identity() * d.dot(&d) - d * d.transpose()) * part.mass
    };
    Inertia { mass, com, moments: symmetric(parts.iter().map(about).sum()) }
}

/// Without the rounding that tells the two halves of a symmetric matrix apart.
fn symmetric(m: Matrix<3>) -> Matrix<3> {
    (m + m.transpose()) * 0.5
}

//! Whether what is learnt converges: a sufficient condition at a pose, with θ slow beside the loop.
//!
//! ```text
//! Δ = LP (I − cDM⁻¹) S     S = Ms² (Ms² + D(3ps + 3p² + p³/s))⁻¹      s = jω
//! ```
//!
//! in units of each joint's torque. y − φθ is then (I − Δ) φθ̃, and `V = θ̃ᵀP⁻¹θ̃` falls if
//! |Δ (I − Δ)⁻¹| < √(ρ/(1 + ρ)) at every frequency. Without c the loop learns its own transients.

use nalgebra::DMatrix;

use super::gains::LearningGains;
use crate::eigen::symmetric_spectrum;
use crate::error::Result;
use crate::math::{Matrix, exp, sqrt};
use core::f64::consts::TAU;

/// Frequencies, from this share of the slowest p to this multiple of the fastest.
const FREQUENCIES: usize = 40;
const LOWEST: f64 = 0.05;
const HIGHEST: f64 = 20.0;

/// The largest |Δ (I − Δ)⁻¹| over the frequencies; infinite where I − Δ has no inverse.
///
/// # Errors
/// As [`symmetric_spectrum`].
pub(super) fn gain<const N: usize>(
    gains: &LearningGains<N>,
    weight: &Matrix<N>,
    mass: &Matrix<N>,
) -> Result<f64> {
    let slowest =
        gains.pull.bandwidth.iter().fold(f64::INFINITY, |least, p| least.min(*p)) * LOWEST;
    let fastest = gains.pull.bandwidth.iter().fold(0.0, |most: f64, p| most.max(*p)) * HIGHEST;
    let ratio = libm::log(fastest / slowest) / (FREQUENCIES - 1) as f64;
    let mut largest: f64 = 0.0;
    for k in 0..FREQUENCIES {
        let omega = slowest * exp(ratio * k as f64);
        let Some(delta) = mismatch(gains, weight, mass, omega) else {
            return Ok(f64::INFINITY);
        };
        let square = delta.transpose() * &delta;
        let values = symmetric_spectrum(&square)?;
        largest = values.iter().fold(largest, |most, x| most.max(*x));
    }
    Ok(sqrt(largest))
}

/// Δ (I − Δ)⁻¹ at a frequency [rad/s], a complex matrix X + jY as [X −Y; Y X].
fn mismatch<const N: usize>(
    gains: &LearningGains<N>,
    weight: &Matrix<N>,
    mass: &Matrix<N>,
    omega: f64,
) -> Option<DMatrix<f64>> {
    let inertia = mass * (-omega * omega);
    // D(3ps + 3p² + p³/s)
    let by = |of: fn(f64, f64) -> f64| {
        Matrix::<N>::from_fn(|i, j| weight[(i, j)] * of(gains.pull.bandwidth[j], omega))
    };
    let real = by(|p, _| 3.0 * p * p);
    let imaginary = by(|p, omega| 3.0 * p * omega - p * p * p / omega);
    let closed = complex(&(inertia + real), &imaginary).try_inverse()?;
    let sensitivity = complex(&inertia, &Matrix::<N>::zeros()) * closed;
    let share = Matrix::<N>::identity() - weight * mass.try_inverse()? * gains.acceleration_share;
    let cut = TAU * gains.learning;
    // 1/(1 + jω/ω_l)
    let size = 1.0 / (1.0 + omega * omega / (cut * cut));
    let low_pass = complex(
        &(Matrix::<N>::identity() * size),
        &(Matrix::<N>::identity() * (-omega / cut * size)),
    );
    let scaled = Matrix::<N>::from_fn(|i, j| share[(i, j)] / gains.unit[i]);
    let back = Matrix::<N>::from_fn(|i, j| if i == j { gains.unit[i] } else { 0.0 });
    let flat = |m: &Matrix<N>| complex(m, &Matrix::<N>::zeros());
    let delta = low_pass * flat(&scaled) * sensitivity * flat(&back);
    let rest = DMatrix::identity(2 * N, 2 * N) - &delta;
    Some(delta * rest.try_inverse()?)
}

fn complex<const N: usize>(real: &Matrix<N>, imaginary: &Matrix<N>) -> DMatrix<f64> {
    DMatrix::from_fn(2 * N, 2 * N, |i, j| match (i < N, j < N) {
        (true, true) => real[(i, j)],
        (false, false) => real[(i - N, j - N)],
        (true, false) => -imaginary[(i, j - N)],
        (false, true) => imaginary[(i - N, j)],
    })
}

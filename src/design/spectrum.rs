//! ρ_d along a path as harmonics: `ρ_d(t) = Σ aₘ sin(2π m t/T + φₘ)`, by a discrete Fourier
//! transform.
//!
//! The mean counts with the amplitude √2 |mean| at frequency 0, so that `Σ aₘ²/2` is the mean
//! square.

use core::f64::consts::TAU;

use super::course::{Course, POINTS};
use super::{LinearModel, Subject};
use crate::control::Gains;
use crate::error::Result;
use crate::math::{sin_cos, sqrt};
use crate::riccati::JointSolution;

/// Harmonics of a joint.
pub(super) struct Spectrum {
    /// Amplitude [rad/s²] and frequency [rad/s].
    pub harmonics: Vec<(f64, f64)>,
}

impl Spectrum {
    /// Of ρ_d of joint `n`.
    pub fn of<const N: usize>(course: &Course<N>, n: usize) -> Self {
        let harmonics = (0..POINTS / 2).map(|m| {
            let (mut sine, mut cosine) = (0.0, 0.0);
            for (k, point) in course.points.iter().enumerate() {
                let (sin, cos) = sin_cos(TAU * (k * m % POINTS) as f64 / POINTS as f64);
                sine += point.rho[n] * sin;
                cosine += point.rho[n] * cos;
            }
            let share = if m == 0 { sqrt(2.0) } else { 2.0 } / POINTS as f64;
            (share * libm::hypot(sine, cosine), TAU * m as f64 / course.duration)
        });
        Self { harmonics: harmonics.collect() }
    }
}

/// What there is to learn from: the largest |BᵀPx| along the path under computed torque alone.
pub(super) fn signal<const N: usize>(
    subject: &dyn Subject<N>,
    gains: &Gains<N>,
    course: &Course<N>,
) -> Result<f64> {
    let mut squares = 0.0;
    for n in 0..N {
        let JointSolution { p12, p22, .. } = subject.p()[n];
        let (kp, kv) = (gains.kp[n], gains.kv[n]);
        let (k_i, leak_rate, inertia_ratio) = (0.0, 0.0, course.ratio(n));
        let alone = LinearModel { kp, kv, p12, p22, k_i, leak_rate, inertia_ratio };
        for &(amplitude, omega) in &Spectrum::of(course, n).harmonics {
            let e = amplitude * alone.gain_at(omega)?;
            squares += e * e * (p12 * p12 + p22 * p22 * omega * omega);
        }
    }
    Ok(sqrt(squares))
}

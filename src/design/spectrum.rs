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

/// Of the search for what a signal settles at.
const BISECTIONS: usize = 20;

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

/// The signal s = BᵀPx that the compensator learns from, along the path.
pub(super) struct Signals<'a, const N: usize> {
    subject: &'a dyn Subject<N>,
    gains: &'a Gains<N>,
    spectra: [Spectrum; N],
    ratios: [f64; N],
}

impl<'a, const N: usize> Signals<'a, N> {
    pub fn new(subject: &'a dyn Subject<N>, gains: &'a Gains<N>, course: &Course<N>) -> Self {
        let spectra = std::array::from_fn(|n| Spectrum::of(course, n));
        Self { subject, gains, spectra, ratios: std::array::from_fn(|n| course.ratio(n)) }
    }

    /// The largest |s| under computed torque alone: what there is to learn from.
    pub fn alone(&self) -> Result<f64> {
        self.largest(&[0.0; N], 0.0)
    }

    /// RMS of |s| once the compensator has settled: a dead zone weakens its drive there, and the
    /// e-modification is a leak. `k_i`: of the law without these.
    pub fn settled(&self, k_i: &[f64; N]) -> Result<f64> {
        let adaptation = &self.subject.parameters().adaptation;
        let (mut low, mut high) = (0.0, self.alone()? / sqrt(2.0));
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            let drive = adaptation.drive_factor(middle, 0.0);
            let leak_rate = adaptation.leak_rate + adaptation.slowest_pull(middle);
            let size = self.largest(&k_i.map(|k_i| drive * k_i), leak_rate)? / sqrt(2.0);
            if size > middle { low = middle } else { high = middle }
        }
        Ok(high)
    }

    fn largest(&self, k_i: &[f64; N], leak_rate: f64) -> Result<f64> {
        let mut squares = 0.0;
        for n in 0..N {
            let JointSolution { p12, p22, .. } = self.subject.p()[n];
            let (kp, kv, k_i) = (self.gains.kp[n], self.gains.kv[n], k_i[n]);
            let inertia_ratio = self.ratios[n];
            // Motions are slow for a velocity filter.
            let velocity_filter = None;
            let model =
                LinearModel { kp, kv, p12, p22, k_i, leak_rate, inertia_ratio, velocity_filter };
            for &(amplitude, omega) in &self.spectra[n].harmonics {
                let e = amplitude * model.gain_at(omega)?;
                squares += e * e * (p12 * p12 + p22 * p22 * omega * omega);
            }
        }
        Ok(sqrt(squares))
    }
}

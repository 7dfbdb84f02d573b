//! Gaussian membership of one input in its sets, μ(x) = exp(−½((x − c)/σ)²) (eq. 1), for any
//! centres and widths.
//!
//! Normalised memberships are taken relative to the strongest set, so that they never become 0/0,
//! however far x is from every centre.

use super::form::MAX_SETS;
use super::places::Span;
use crate::math::{TINY_MEMBERSHIP, decay, fnv_of, unless_tiny};

/// Inputs are clamped here: no signal is farther out, and its square still fits a float.
const FAR: f64 = 1e100;

/// The sets of all inputs, one after the other.
#[derive(Clone, Debug)]
pub(super) struct Sets {
    centers: [f64; MAX_SETS],
    inverse_widths: [f64; MAX_SETS],
}

impl Sets {
    pub const NONE: Self = Self { centers: [0.0; MAX_SETS], inverse_widths: [1.0; MAX_SETS] };

    /// Writes the sets of an input.
    pub fn write(&mut self, place: Span, centers: &[f64], widths: &[f64]) {
        for (j, center) in centers.iter().enumerate() {
            self.centers[place.first + j] = *center;
            self.inverse_widths[place.first + j] = 1.0 / widths[j.min(widths.len() - 1)];
        }
    }

    /// FNV-1a of the sets of `place`, from `start` on.
    pub fn fingerprint(&self, start: u64, place: Span) -> u64 {
        let start = fnv_of(start, [place.len as f64]);
        let centers = fnv_of(start, place.of(&self.centers).iter().copied());
        fnv_of(centers, place.of(&self.inverse_widths).iter().copied())
    }

    /// The smallest and the largest centre of an input, and its largest width.
    #[cfg(feature = "std")]
    pub fn reach(&self, place: Span) -> (f64, f64, f64) {
        let (centers, inverse) = (place.of(&self.centers), place.of(&self.inverse_widths));
        let least = |values: &[f64]| values.iter().copied().fold(f64::INFINITY, f64::min);
        let largest = centers.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        (least(centers), largest, 1.0 / least(inverse))
    }

    /// Writes the memberships of x in the sets of `place`, normalised to sum 1 or raw, to every
    /// `stride`th entry. No NaN for any finite x.
    pub fn memberships(
        &self,
        place: Span,
        normalized: bool,
        x: f64,
        (out, stride): (&mut [f64], usize),
    ) {
        out.iter_mut().step_by(stride).for_each(|y| *y = 0.0);
        self.add_exponents(place, x, (out, stride));
        exponentials((out, stride), normalized);
    }

    /// Adds −½((x − c)/σ)² of each set in `place` to every `stride`th entry.
    pub fn add_exponents(&self, place: Span, x: f64, (out, stride): (&mut [f64], usize)) {
        let x = x.clamp(-FAR, FAR);
        let sets = place.of(&self.centers).iter().zip(place.of(&self.inverse_widths));
        for ((center, inverse_width), y) in sets.zip(out.iter_mut().step_by(stride)) {
            let z = (x - center) * inverse_width;
            *y += -0.5 * z * z;
        }
    }
}

/// Replaces every `stride`th entry, an exponent, by its exponential, normalised to sum 1
/// (log-sum-exp) or raw.
pub(super) fn exponentials((out, stride): (&mut [f64], usize), normalized: bool) {
    if !normalized {
        out.iter_mut().step_by(stride).for_each(|y| *y = strength(*y));
        return;
    }
    let largest = out.iter().step_by(stride).copied().fold(f64::NEG_INFINITY, f64::max);
    let mut sum = 0.0;
    for y in out.iter_mut().step_by(stride) {
        *y = strength(*y - largest);
        sum += *y;
    }
    let scale = 1.0 / sum;
    out.iter_mut().step_by(stride).for_each(|y| *y = unless_tiny(*y * scale, TINY_MEMBERSHIP));
}

/// e^x for x ≤ 0, or 0 where that is tiny.
#[inline]
fn strength(x: f64) -> f64 {
    unless_tiny(decay(-x), TINY_MEMBERSHIP)
}

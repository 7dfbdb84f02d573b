//! Gaussian membership of one input in its sets, μ(x) = exp(−½((x − c)/σ)²) (eq. 1), for any
//! centres and widths.
//!
//! Normalised memberships are taken relative to the strongest set, so that they never become 0/0,
//! however far x is from every centre.

use crate::math::{TINY_MEMBERSHIP, decay, fnv_of, unless_tiny};

/// Inputs are clamped here: no signal is farther out, and its square still fits a float.
const FAR: f64 = 1e100;

/// The sets of one input.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sets<'a> {
    pub centers: &'a [f64],
    /// 1/σ of each.
    pub inverse_widths: &'a [f64],
}

impl<'a> Sets<'a> {
    /// The sets that stand in `numbers`: centres, then inverse widths.
    #[inline]
    pub fn of(numbers: &'a [f64]) -> Self {
        let (centers, inverse_widths) = numbers.split_at(numbers.len() / 2);
        Self { centers, inverse_widths }
    }

    /// Writes sets of these widths, one for all or one a set, to where [`of`](Self::of) finds them.
    pub fn write(centers: &[f64], widths: &[f64], numbers: &mut [f64]) {
        let (own, inverse) = numbers.split_at_mut(centers.len());
        own.copy_from_slice(centers);
        let width = |j: usize| widths[j.min(widths.len() - 1)];
        inverse.iter_mut().enumerate().for_each(|(j, y)| *y = 1.0 / width(j));
    }

    /// FNV-1a of the sets, from `start` on.
    pub fn fingerprint(&self, start: u64) -> u64 {
        let start = fnv_of(start, [self.centers.len() as f64]);
        let centers = fnv_of(start, self.centers.iter().copied());
        fnv_of(centers, self.inverse_widths.iter().copied())
    }

    /// Centre and width of each set.
    #[cfg(feature = "std")]
    pub fn reach(&self) -> Vec<(f64, f64)> {
        let sets = self.centers.iter().zip(self.inverse_widths);
        sets.map(|(center, inverse)| (*center, 1.0 / inverse)).collect()
    }

    /// Writes the memberships of x, normalised to sum 1 or raw, to every `stride`th entry. No NaN
    /// for any finite x.
    pub fn memberships(&self, normalized: bool, x: f64, (out, stride): (&mut [f64], usize)) {
        out.iter_mut().step_by(stride).for_each(|y| *y = 0.0);
        self.add_exponents(x, (out, stride));
        exponentials((out, stride), normalized);
    }

    /// Adds −½((x − c)/σ)² of each set to every `stride`th entry.
    pub fn add_exponents(&self, x: f64, (out, stride): (&mut [f64], usize)) {
        let x = x.clamp(-FAR, FAR);
        let sets = self.centers.iter().zip(self.inverse_widths);
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

//! Gaussian membership of one input in its sets, μ(x) = exp(−½((x − c)/σ)²) (eq. 1).
//!
//! Normalised memberships are taken relative to the strongest set, so that they never become 0/0, however far
//! x is from every centre. Sets of equal width σ whose centres share a step d need one exponential in all:
//! with p a middle centre and c = p + k d,
//!
//! ```text
//! μ_c(x) = μ_p(x) · exp(−(k d)²/2σ²) · tᵏ,   t = exp(d (x − p)/σ²)
//! ```
//!
//! where the middle factor is a constant of the set, and μ_p(x) cancels on normalising.

use super::basis::MAX_SETS;
use super::kernels::{LANES, Span, powers};
use crate::math::exp;

/// Inputs are clamped here: no signal is farther out, and its square still fits a float.
const FAR: f64 = 1e100;

/// Centres count as evenly stepped when they are this close to a common lattice, in steps.
const LATTICE_TOL: f64 = 1e-12;

/// Lattice steps between the outermost centres at the most; sparser sets do not gain from the lattice.
const MAX_STEPS: usize = 64;

/// Largest exponent on the lattice: e^±600 and their products with the constants are normal floats.
const MAX_EXPONENT: f64 = 600.0;

/// The sets of all inputs, one after the other, with room to read whole lanes.
#[derive(Clone, Debug)]
pub(super) struct Sets {
    centers: [f64; MAX_SETS + LANES],
    inverse_widths: [f64; MAX_SETS + LANES],
    /// exp(−(k d)²/2σ²) of a set on a lattice.
    decays: [f64; MAX_SETS + LANES],
    /// 2|k|, plus 1 where k < 0.
    steps: [u64; MAX_SETS + LANES],
}

impl Sets {
    pub const NONE: Self = Self {
        centers: [0.0; MAX_SETS + LANES],
        inverse_widths: [1.0; MAX_SETS + LANES],
        decays: [1.0; MAX_SETS + LANES],
        steps: [0; MAX_SETS + LANES],
    };

    /// Writes the sets of an input; returns its lattice if they are on one.
    pub fn write(&mut self, place: Span, centers: &[f64], widths: &[f64]) -> Option<Lattice> {
        let width = |j: usize| widths[j.min(widths.len() - 1)];
        for (j, center) in centers.iter().enumerate() {
            self.centers[place.first + j] = *center;
            self.inverse_widths[place.first + j] = 1.0 / width(j);
        }
        let even = (0..centers.len()).all(|j| width(j) == widths[0]);
        let (lattice, step) = Lattice::recognise(centers, self.inverse_widths[place.first], even)?;
        for (j, center) in centers.iter().enumerate() {
            let offset = center - lattice.center;
            let steps = libm::round(offset.abs() / step) as u64;
            self.steps[place.first + j] = 2 * steps + u64::from(offset < 0.0);
            self.decays[place.first + j] = exp(-offset * offset * lattice.half_precision);
        }
        Some(lattice)
    }

    /// Adds −½((x − c)/σ)² of each set in `place` to `out`.
    #[inline]
    pub fn add_exponents(&self, place: Span, x: f64, out: &mut [f64]) {
        let x = x.clamp(-FAR, FAR);
        let sets = place.of(&self.centers).iter().zip(place.of(&self.inverse_widths));
        for ((center, inverse_width), y) in sets.zip(out) {
            let z = (x - center) * inverse_width;
            *y += -0.5 * z * z;
        }
    }
}

/// Equal widths and evenly stepped ascending centres.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lattice {
    /// p, the middle centre.
    center: f64,
    /// d/σ².
    slope: f64,
    /// 1/2σ².
    half_precision: f64,
    /// |x − p| up to which the powers of t fit.
    reach: f64,
    /// Binary digits of the largest |k|.
    digits: u32,
}

impl Lattice {
    /// The lattice of these centres and its step d; `None` where there is none.
    fn recognise(centers: &[f64], inverse_width: f64, even: bool) -> Option<(Self, f64)> {
        let step = smallest_gap(centers)?;
        let steps = |c: f64| (c - centers[0]) / step;
        let on_lattice = |c: &f64| (steps(*c) - libm::round(steps(*c))).abs() <= LATTICE_TOL;
        let span = centers[centers.len() - 1] - centers[0];
        let half_precision = 0.5 * inverse_width * inverse_width;
        if !even
            || !centers.iter().all(on_lattice)
            || span > MAX_STEPS as f64 * step
            || span * span * half_precision > MAX_EXPONENT
        {
            return None;
        }
        let center = centers[centers.len() / 2];
        let slope = 2.0 * step * half_precision;
        let reach = MAX_EXPONENT * step / (slope * span);
        let far = (center - centers[0]).max(centers[0] + span - center);
        let digits = u64::BITS - (libm::round(far / step) as u64).leading_zeros();
        Some((Self { center, slope, half_precision, reach, digits }, step))
    }

    /// t; `None` if x is too far out for its powers.
    #[inline]
    fn ratio(&self, x: f64) -> Option<f64> {
        let delta = x - self.center;
        (delta.abs() <= self.reach).then(|| exp(self.slope * delta))
    }

    /// μ_p(x).
    #[inline]
    fn middle(&self, x: f64) -> f64 {
        let delta = x - self.center;
        exp(-delta * delta * self.half_precision)
    }
}

fn smallest_gap(centers: &[f64]) -> Option<f64> {
    let mut smallest = f64::INFINITY;
    for pair in centers.windows(2) {
        let gap = pair[1] - pair[0];
        if gap <= 0.0 {
            return None;
        }
        smallest = smallest.min(gap);
    }
    smallest.is_finite().then_some(smallest)
}

/// Writes the memberships of x in the sets of `place`, normalised to sum 1 or raw, and zeros up to whole lanes.
/// No NaN for any finite x.
#[inline]
pub(super) fn memberships(
    sets: &Sets,
    place: Span,
    lattice: Option<&Lattice>,
    normalized: bool,
    x: f64,
    out: &mut [f64],
) {
    if let Some(lattice) = lattice
        && let Some(t) = lattice.ratio(x)
    {
        let lanes = place.lanes();
        let (steps, decays) = (lanes.of(&sets.steps), lanes.of(&sets.decays));
        let scale = (!normalized).then(|| lattice.middle(x));
        return powers((steps, decays), lattice.digits, t, scale, (place.len, out));
    }
    out.fill(0.0);
    let out = &mut out[..place.len];
    sets.add_exponents(place, x, out);
    exponentials(out, normalized);
}

/// Replaces exponents by their exponentials, normalised to sum 1 (log-sum-exp) or raw.
#[inline]
pub(super) fn exponentials(out: &mut [f64], normalized: bool) {
    if !normalized {
        out.iter_mut().for_each(|y| *y = exp(*y));
        return;
    }
    let largest = out.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let mut sum = 0.0;
    for y in out.iter_mut() {
        *y = exp(*y - largest);
        sum += *y;
    }
    let scale = 1.0 / sum;
    out.iter_mut().for_each(|y| *y *= scale);
}

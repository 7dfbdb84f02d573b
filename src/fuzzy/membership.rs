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

use crate::math::exp;

/// Inputs are clamped here: no signal is farther out, and its square still fits a float.
const FAR: f64 = 1e100;

/// Centres count as evenly stepped when they are this close to a common lattice, in steps.
const LATTICE_TOL: f64 = 1e-12;

/// Lattice steps between the outermost centres at the most; sparser sets do not gain from the lattice.
const MAX_STEPS: usize = 64;

/// Largest exponent on the lattice: e^±600 and their products with the constants are normal floats.
const MAX_EXPONENT: f64 = 600.0;

/// One Gaussian set.
#[derive(Clone, Copy, Debug)]
pub(super) struct Set {
    center: f64,
    inverse_width: f64,
    /// Lattice steps from the neighbour on the middle set's side to this one.
    steps: usize,
    /// exp(−(k d)²/2σ²).
    decay: f64,
}

impl Set {
    pub const NONE: Self = Self { center: 0.0, inverse_width: 1.0, steps: 0, decay: 1.0 };

    pub fn new(center: f64, width: f64) -> Self {
        Self { center, inverse_width: 1.0 / width, ..Self::NONE }
    }

    /// −½((x − c)/σ)².
    #[inline]
    pub fn exponent(&self, x: f64) -> f64 {
        let z = (x.clamp(-FAR, FAR) - self.center) * self.inverse_width;
        -0.5 * z * z
    }
}

/// Equal widths and evenly stepped ascending centres.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lattice {
    /// Index of the middle set.
    pivot: usize,
    /// p, its centre.
    center: f64,
    /// d/σ².
    slope: f64,
    /// 1/2σ².
    half_precision: f64,
    /// |x − p| up to which the powers of t fit.
    reach: f64,
}

impl Lattice {
    /// Recognises a lattice and writes its constants into the sets; `None` where there is none.
    pub fn recognise(sets: &mut [Set]) -> Option<Self> {
        let step = smallest_gap(sets)?;
        let (first, last) = (sets[0], sets[sets.len() - 1]);
        let steps_from_first = |s: &Set| (s.center - first.center) / step;
        let even = sets.iter().all(|s| {
            let k = steps_from_first(s);
            (k - libm::round(k)).abs() <= LATTICE_TOL && s.inverse_width == first.inverse_width
        });
        let span = last.center - first.center;
        let half_precision = 0.5 * first.inverse_width * first.inverse_width;
        if !even || span > MAX_STEPS as f64 * step || span * span * half_precision > MAX_EXPONENT {
            return None;
        }
        let pivot = sets.len() / 2;
        let center = sets[pivot].center;
        let mut previous = 0;
        for j in 0..sets.len() {
            let k = libm::round(steps_from_first(&sets[j])) as usize;
            // Up to the middle, the gap before set j belongs to its left neighbour.
            sets[if j <= pivot { j.saturating_sub(1) } else { j }].steps = k - previous;
            previous = k;
            let offset = sets[j].center - center;
            sets[j].decay = exp(-offset * offset * half_precision);
        }
        let slope = 2.0 * step * half_precision;
        let reach = MAX_EXPONENT * step / (slope * span);
        Some(Self { pivot, center, slope, half_precision, reach })
    }

    /// Memberships relative to that of the middle set; false if x is too far out for that.
    #[inline]
    fn relative(&self, sets: &[Set], x: f64, out: &mut [f64]) -> bool {
        let delta = x - self.center;
        if delta.abs() > self.reach {
            return false;
        }
        let t = exp(self.slope * delta);
        let (below, rest) = out.split_at_mut(self.pivot);
        let (left, right) = sets.split_at(self.pivot);
        if let Some((middle, above)) = rest.split_first_mut() {
            *middle = 1.0;
            powers(t, right[1..].iter().zip(above));
        }
        powers(1.0 / t, left.iter().zip(below).rev());
        true
    }

    /// μ_p(x).
    #[inline]
    fn middle(&self, x: f64) -> f64 {
        let delta = x - self.center;
        exp(-delta * delta * self.half_precision)
    }
}

/// Memberships outward from the middle set, whose own is 1.
#[inline(always)]
fn powers<'a>(t: f64, sets: impl Iterator<Item = (&'a Set, &'a mut f64)>) {
    let mut power = 1.0;
    for (set, y) in sets {
        for _ in 0..set.steps {
            power *= t;
        }
        *y = power * set.decay;
    }
}

fn smallest_gap(sets: &[Set]) -> Option<f64> {
    let mut smallest = f64::INFINITY;
    for pair in sets.windows(2) {
        let gap = pair[1].center - pair[0].center;
        if gap <= 0.0 {
            return None;
        }
        smallest = smallest.min(gap);
    }
    smallest.is_finite().then_some(smallest)
}

/// Writes the memberships of x in `sets`: raw, or up to a common factor. No NaN for any finite x.
#[inline]
pub(super) fn memberships(
    sets: &[Set],
    lattice: Option<&Lattice>,
    normalized: bool,
    x: f64,
    out: &mut [f64],
) {
    if let Some(lattice) = lattice
        && lattice.relative(sets, x, out)
    {
        if !normalized {
            let scale = lattice.middle(x);
            out.iter_mut().for_each(|y| *y *= scale);
        }
        return;
    }
    for (set, y) in sets.iter().zip(out.iter_mut()) {
        *y = set.exponent(x);
    }
    exponentials(out, normalized);
}

/// Replaces exponents by their exponentials: raw, or relative to the largest.
#[inline]
pub(super) fn exponentials(out: &mut [f64], normalized: bool) {
    let largest =
        if normalized { out.iter().copied().fold(f64::NEG_INFINITY, f64::max) } else { 0.0 };
    out.iter_mut().for_each(|y| *y = exp(*y - largest));
}

/// Scales to the sum 1.
#[inline]
pub(super) fn normalize(out: &mut [f64]) {
    let scale = 1.0 / out.iter().sum::<f64>();
    out.iter_mut().for_each(|y| *y *= scale);
}

//! The peak of a frequency response: γ_opt = max over ω of σ(ω), `σ² = λ_max(Bᵀ(−jω − A)⁻ᵀ Q (jω −
//! A)⁻¹B)`.
//!
//! A local maximum is found by golden section; that no other one is higher is then proven by
//! solving the Riccati equation at a level 1e-10 above. If that fails, the imaginary parts of the
//! eigenvalues of the Hamiltonian matrix at this level bracket every interval in which σ exceeds
//! it, and the search goes on in those.
//!
//! Source: Bruinsma and Steinbuch, "A fast algorithm to compute the H∞-norm of a transfer function
//! matrix", Systems and Control Letters 14 (1990).

use nalgebra::{DefaultAllocator, Dim};

use super::dense::{Modes, Room, Square, Tall};
use super::doubling::solve;
use super::hamiltonian;
use super::response::Response;
use super::scaling::{Problem, Scaled};
use crate::eigen::{Complex, modulus};
use crate::error::Result;
use crate::math::sqrt;

/// Accuracy of γ_opt, relative: the proof is made at this distance above it.
const ACCURACY: f64 = 1e-10;
/// Distances at which the proof is tried in turn when no frequency does better.
const LOOSER: [f64; 9] = [1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1];
/// Eigenvalues that name frequencies to look at: those nearest to the axis.
const MOST_POINTS: usize = 32;
/// A frequency is better if it raises σ by this much, relative; less is rounding.
const BETTER: f64 = 1e-13;
/// Rounds of level and search; three are usual.
const ROUNDS: usize = 30;
/// Golden sections of one bracket: 0.618⁴⁰ = 4e-9, and an error of ω enters σ squared.
const SECTIONS: usize = 40;
/// (√5 − 1)/2.
const GOLDEN: f64 = 0.618_033_988_749_894_8;

/// γ_opt, and a γ from which on existence is proven (∞ if rounding hides it everywhere).
pub(super) struct Limit {
    pub(super) gamma_opt: f64,
    pub(super) proven: f64,
}

#[derive(Clone, Copy)]
struct Peak {
    omega: f64,
    sigma: f64,
}

/// γ_opt of a plant with a Hurwitz A that has the eigenvalues `modes`.
pub(super) fn peak<S: Dim, M: Dim>(
    a: &Square<S>,
    b: &Tall<S, M>,
    q: &Square<S>,
    modes: &Modes<S>,
) -> Result<Limit>
where
    DefaultAllocator: Room<S, M> + Room<S, S> + Room<M, M>,
{
    // σ(ω) is the same in balanced units, but for the unit of ω.
    let Scaled { balanced, time, .. } = Scaled::new(a, b, q, true);
    let modes = modes.map(|z| z / time);
    let search = Search { response: Response::new(&balanced), balanced, modes };
    let mut best = search.at_modes();
    for _ in 0..ROUNDS {
        let level = best.sigma * (1.0 + ACCURACY);
        if best.sigma == 0.0 || search.stays_below(level) {
            return Ok(Limit { gamma_opt: best.sigma, proven: level });
        }
        let found = search.above(level, best)?;
        if found.sigma <= best.sigma * (1.0 + BETTER) {
            break;
        }
        best = found;
    }
    let mut levels = LOOSER.iter().map(|distance| best.sigma * (1.0 + distance));
    let proven = levels.find(|&level| search.stays_below(level));
    Ok(Limit { gamma_opt: best.sigma, proven: proven.unwrap_or(f64::INFINITY) })
}

struct Search<S: Dim, M: Dim>
where
    DefaultAllocator: Room<S, M>,
{
    balanced: Problem<S, M>,
    response: Response<S, M>,
    modes: Modes<S>,
}

impl<S: Dim, M: Dim> Search<S, M>
where
    DefaultAllocator: Room<S, M> + Room<S, S> + Room<M, M>,
{
    /// Whether σ(ω) < `level` at every ω, proven.
    fn stays_below(&self, level: f64) -> bool {
        let scaled = self.at_level(level);
        solve(&scaled.balanced, &self.modes.map(|z| z / scaled.time), false).is_some()
    }

    fn at_level(&self, level: f64) -> Scaled<S, M> {
        let Problem { a, f, q, .. } = &self.balanced;
        Scaled::new(a, &(f / level), q, true)
    }

    /// The best of ω = 0 and the frequencies that the modes of A name.
    fn at_modes(&self) -> Peak {
        let (mut points, mut modes) = ([0.0; 3 * MOST_POINTS], self.modes.clone());
        let few = nearest_to_axis(modes.as_mut_slice());
        for (at, z) in points.chunks_exact_mut(3).zip(few) {
            at[0] = modulus(*z);
            at[1] = z.im.abs();
            at[2] = sqrt((z.im * z.im - z.re * z.re).max(0.0));
        }
        let start = Peak { omega: 0.0, sigma: self.response.sigma(0.0) };
        self.search(&mut points[..3 * few.len()], start)
    }

    /// The best of `best` and the frequencies at which σ may cross `level`: |Im λ| of the
    /// Hamiltonian matrix at γ = `level`.
    fn above(&self, level: f64, best: Peak) -> Result<Peak> {
        let scaled = self.at_level(level);
        let mut values = hamiltonian::eigenvalues(&scaled.balanced)?;
        let few = nearest_to_axis(values.as_mut_slice().as_flattened_mut());
        let mut points = [0.0; MOST_POINTS];
        points.iter_mut().zip(few).for_each(|(at, z)| *at = z.im.abs() * scaled.time);
        Ok(self.search(&mut points[..few.len()], best))
    }

    /// The best of `best`, the `points` and the middles between them, after a golden section around
    /// it.
    fn search(&self, points: &mut [f64], best: Peak) -> Peak {
        points.sort_unstable_by(f64::total_cmp);
        let (mut winner, mut bracket) = (best, None);
        let mut left = 0.0;
        for k in 0..points.len() {
            let here = points[k];
            let right = points.get(k + 1).copied().unwrap_or(2.0 * here);
            let middle = 0.5 * (left + here);
            for (omega, from, to) in [(middle, left, here), (here, middle, 0.5 * (here + right))] {
                let sigma = self.response.sigma(omega);
                if sigma > winner.sigma {
                    (winner, bracket) = (Peak { omega, sigma }, Some((from, to)));
                }
            }
            left = here;
        }
        match bracket {
            Some((from, to)) => self.climb(winner, from, to),
            None => winner,
        }
    }

    /// Golden section on `from..to`; the best point seen.
    fn climb(&self, mut best: Peak, mut from: f64, mut to: f64) -> Peak {
        let at = |omega: f64| Peak { omega, sigma: self.response.sigma(omega) };
        let mut low = at(to - GOLDEN * (to - from));
        let mut high = at(from + GOLDEN * (to - from));
        for _ in 0..SECTIONS {
            for peak in [low, high] {
                if peak.sigma > best.sigma {
                    best = peak;
                }
            }
            if low.sigma > high.sigma {
                to = high.omega;
                high = low;
                low = at(to - GOLDEN * (to - from));
            } else {
                from = low.omega;
                low = high;
                high = at(from + GOLDEN * (to - from));
            }
        }
        best
    }
}

/// Sorts `values` by their distance from the imaginary axis; the first few.
fn nearest_to_axis(values: &mut [Complex]) -> &[Complex] {
    values.sort_unstable_by(|x, y| x.re.abs().total_cmp(&y.re.abs()));
    &values[..values.len().min(MOST_POINTS)]
}

//! The peak of a frequency response: γ_opt = max over ω of σ(ω), `σ² = λ_max(Bᵀ(−jω − A)⁻ᵀ Q (jω − A)⁻¹B)`.
//!
//! A local maximum is found by golden section; that no other one is higher is then proven by solving the Riccati equation at a
//! level 1e-10 above. If that fails, the imaginary parts of the eigenvalues of the Hamiltonian matrix at this level bracket
//! every interval in which σ exceeds it, and the search goes on in those.
//!
//! Source: Bruinsma and Steinbuch, "A fast algorithm to compute the H∞-norm of a transfer function matrix", Systems and
//! Control Letters 14 (1990).

use nalgebra::SMatrix;

use super::doubling::solve;
use super::scaling::Scaled;
use crate::eigen::{Complex, eigenvalues_in_place, modulus, symmetric_in_place};
use crate::error::{Error, Result};
use crate::math::{Matrix, sqrt};

/// Accuracy of γ_opt, relative: the proof is made at this distance above it.
const ACCURACY: f64 = 1e-10;
/// Distances at which the proof is tried in turn when no frequency does better, before it is given up.
const LOOSER: [f64; 5] = [1e-9, 1e-8, 1e-7, 1e-6, 1e-5];
/// A frequency is better if it raises σ by this much, relative; less is rounding.
const BETTER: f64 = 1e-13;
/// Rounds of level and search; three are usual.
const ROUNDS: usize = 30;
/// Golden sections of one bracket: 0.618⁴⁰ = 4e-9, and an error of ω enters σ squared.
const SECTIONS: usize = 40;
/// (√5 − 1)/2.
const GOLDEN: f64 = 0.618_033_988_749_894_8;

/// The plant whose response is measured.
pub(super) struct Response<'a, const S: usize, const M: usize> {
    pub(super) a: &'a Matrix<S>,
    pub(super) b: &'a SMatrix<f64, S, M>,
    pub(super) q: &'a Matrix<S>,
}

#[derive(Clone, Copy)]
struct Peak {
    omega: f64,
    sigma: f64,
}

/// γ_opt of a plant with a Hurwitz A that has the eigenvalues `modes`.
pub(super) fn peak<const S: usize, const M: usize>(
    plant: &Response<S, M>,
    modes: &[Complex; S],
) -> Result<f64> {
    let mut points = [[0.0; S]; 3];
    points[0] = modes.map(modulus);
    points[1] = modes.map(|z| z.im.abs());
    points[2] = modes.map(|z| sqrt((z.im * z.im - z.re * z.re).max(0.0)));
    let mut best =
        plant.search(points.as_flattened_mut(), Peak { omega: 0.0, sigma: plant.sigma(0.0) });
    if best.sigma == 0.0 {
        return Ok(0.0);
    }
    for _ in 0..ROUNDS {
        let level = best.sigma * (1.0 + ACCURACY);
        if plant.stays_below(level, modes) {
            return Ok(best.sigma);
        }
        let mut points = plant.crossings(level)?;
        let found = plant.search(points.as_flattened_mut(), best);
        if found.sigma <= best.sigma * (1.0 + BETTER) {
            let proven = |&d: &f64| plant.stays_below(best.sigma * (1.0 + d), modes);
            if LOOSER.iter().any(proven) {
                return Ok(best.sigma);
            }
            break;
        }
        best = found;
    }
    Err(Error::NoConvergence { computing: "gamma_opt" })
}

impl<const S: usize, const M: usize> Response<'_, S, M> {
    /// Whether σ(ω) < `level` at every ω, proven.
    fn stays_below(&self, level: f64, modes: &[Complex; S]) -> bool {
        let scaled = Scaled::new(self.a, &(self.b / level), self.q, true);
        solve(&scaled.balanced, scaled.shift(modes), false).is_some()
    }

    /// |Im λ| of the Hamiltonian matrix [A γ⁻²BBᵀ; −Q −Aᵀ]: among them every ω with σ(ω) = γ = `level`.
    fn crossings(&self, level: f64) -> Result<[[f64; S]; 2]> {
        let scaled = Scaled::new(self.a, &(self.b / level), self.q, true);
        let p = &scaled.balanced;
        let mut h = [[[[0.0; S]; 2]; S]; 2];
        for j in 0..S {
            for i in 0..S {
                h[0][j][0][i] = p.a[(i, j)];
                h[0][j][1][i] = -p.q[(i, j)];
                h[1][j][0][i] = -p.g[(i, j)];
                h[1][j][1][i] = -p.a[(j, i)];
            }
        }
        let mut values = [[Complex::new(0.0, 0.0); S]; 2];
        let entries = h.as_flattened_mut().as_flattened_mut().as_flattened_mut();
        eigenvalues_in_place(2 * S, entries, values.as_flattened_mut())?;
        Ok(values.map(|row| row.map(|z| z.im.abs() * scaled.time)))
    }

    /// The best of `best`, the `points` and the middles between them, after a golden section around it.
    fn search(&self, points: &mut [f64], best: Peak) -> Peak {
        points.sort_unstable_by(f64::total_cmp);
        let (mut winner, mut bracket) = (best, None);
        let mut left = 0.0;
        for k in 0..points.len() {
            let here = points[k];
            let right = points.get(k + 1).copied().unwrap_or(2.0 * here);
            let middle = 0.5 * (left + here);
            for (omega, from, to) in [(middle, left, here), (here, middle, 0.5 * (here + right))] {
                let sigma = self.sigma(omega);
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
        let at = |omega: f64| Peak { omega, sigma: self.sigma(omega) };
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

    /// σ(ω); 0 where it cannot be computed, so that such a frequency never wins.
    fn sigma(&self, omega: f64) -> f64 {
        let Some(x) = self.states(omega) else { return 0.0 };
        // The Hermitian matrix XᴴQX as the real symmetric [Re −Im; Im Re], which has the same eigenvalues, twice.
        let mut k = [[[[0.0; M]; 2]; M]; 2];
        for j in 0..M {
            let qx: [Complex; S] =
                core::array::from_fn(|i| (0..S).map(|l| x[j][l] * self.q[(i, l)]).sum());
            for i in 0..M {
                let entry: Complex = (0..S).map(|l| x[i][l].conj() * qx[l]).sum();
                (k[0][j][0][i], k[1][j][1][i]) = (entry.re, entry.re);
                (k[0][j][1][i], k[1][j][0][i]) = (entry.im, -entry.im);
            }
        }
        let entries = k.as_flattened_mut().as_flattened_mut().as_flattened_mut();
        if entries.iter().any(|x| !x.is_finite()) {
            return 0.0;
        }
        let (mut values, mut off) = ([[0.0; M]; 2], [[0.0; M]; 2]);
        let values = values.as_flattened_mut();
        match symmetric_in_place(2 * M, entries, values, off.as_flattened_mut()) {
            Ok(()) => sqrt(values.iter().fold(0.0, |most: f64, &x| most.max(x))),
            Err(_) => 0.0,
        }
    }

    /// The columns of (jω − A)⁻¹ B.
    fn states(&self, omega: f64) -> Option<[[Complex; S]; M]> {
        let entry =
            |i: usize, j: usize| Complex::new(-self.a[(i, j)], if i == j { omega } else { 0.0 });
        let mut a = core::array::from_fn(|i| core::array::from_fn(|j| entry(i, j)));
        let mut x =
            core::array::from_fn(|j| core::array::from_fn(|i| Complex::new(self.b[(i, j)], 0.0)));
        eliminate(&mut a, &mut x)?;
        for column in &mut x {
            for k in (0..S).rev() {
                for j in k + 1..S {
                    let known = column[j];
                    column[k] -= a[k][j] * known;
                }
                column[k] /= a[k][k];
            }
        }
        Some(x)
    }
}

/// Gaussian elimination with row pivoting on the rows of `a` and on the right sides, the columns `x`.
fn eliminate<const S: usize, const M: usize>(
    a: &mut [[Complex; S]; S],
    x: &mut [[Complex; S]; M],
) -> Option<()> {
    for k in 0..S {
        let mut pivot = k;
        for i in k + 1..S {
            if modulus(a[i][k]) > modulus(a[pivot][k]) {
                pivot = i;
            }
        }
        a.swap(k, pivot);
        x.iter_mut().for_each(|column| column.swap(k, pivot));
        if modulus(a[k][k]) == 0.0 {
            return None;
        }
        let top = a[k];
        for i in k + 1..S {
            let factor = a[i][k] / top[k];
            for j in k + 1..S {
                a[i][j] -= factor * top[j];
            }
            for column in x.iter_mut() {
                let head = column[k];
                column[i] -= factor * head;
            }
        }
    }
    Some(())
}

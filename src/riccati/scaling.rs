//! Scaling by powers of two, exact in floating point, before the doubling.

use nalgebra::SMatrix;

use super::kernels::symmetric;
use crate::eigen::{Complex, balancing_factor, modulus, power_of_two_near};
use crate::math::{Matrix, sqrt};

/// Rounds of balancing; each one that goes on has shrunk some row and column.
const ROUNDS: usize = 20;
/// An eigenvalue of A this far below the fastest does not slow the shift down any more.
const SLOW: f64 = 1e-3;

/// `AᵀP + PA − PGP + Q = 0` with G = FFᵀ, or G = −FFᵀ if `bounded` (the bounded-real sign).
#[derive(Clone, Copy)]
pub(super) struct Problem<const S: usize, const M: usize> {
    pub(super) a: Matrix<S>,
    pub(super) f: SMatrix<f64, S, M>,
    pub(super) g: Matrix<S>,
    pub(super) q: Matrix<S>,
    pub(super) bounded: bool,
}

/// A problem in units in which A, G and Q have entries about 1.
///
/// `A = time · D A' D⁻¹`, `F = (time/size)^½ D F'`, `Q = time · size · D⁻¹ Q' D⁻¹`, then `P = size · D⁻¹ P' D⁻¹`.
pub(super) struct Scaled<const S: usize, const M: usize> {
    /// In new units of time and of P, D = I.
    pub(super) plain: Problem<S, M>,
    /// The same, balanced by D.
    pub(super) balanced: Problem<S, M>,
    pub(super) time: f64,
    pub(super) size: f64,
    d: [f64; S],
}

impl<const S: usize, const M: usize> Scaled<S, M> {
    pub(super) fn new(a: &Matrix<S>, f: &SMatrix<f64, S, M>, q: &Matrix<S>, bounded: bool) -> Self {
        let exponent = |x: f64| libm::frexp(x).1;
        let time = power_of_two_near(a.amax());
        // G' = 4ᵏ G and Q' = Q / (time² 4ᵏ), about equal.
        let k = match (f.amax(), q.amax()) {
            (0.0, 0.0) => 0,
            (0.0, q) => exponent(q) / 2 - exponent(time),
            (f, 0.0) => -exponent(f),
            (f, q) => (exponent(q) - 2 * exponent(f) - 2 * exponent(time)) / 4,
        };
        let f = f.map(|x| libm::ldexp(x, k));
        let g = symmetric(&(f * f.transpose())) * if bounded { -1.0 } else { 1.0 };
        let q = (q / time).map(|x| libm::ldexp(x / time, -2 * k));
        let plain = Problem { a: a / time, f, g, q, bounded };
        let size = libm::ldexp(time, 2 * k);
        let mut scaled = Self { plain, balanced: plain, time, size, d: [1.0; S] };
        scaled.balance();
        scaled
    }

    /// P' in these units, without D.
    pub(super) fn unbalance(&self, p: &Matrix<S>) -> Matrix<S> {
        Matrix::from_fn(|i, j| p[(i, j)] / self.d[i] / self.d[j])
    }

    /// A shift for the Cayley transform: the geometric mean of the slowest and the fastest mode.
    ///
    /// `modes` are the eigenvalues of A; the closed loop has faster ones if G Q is large.
    pub(super) fn shift(&self, modes: &[Complex; S]) -> f64 {
        let sizes = modes.map(|z| modulus(z) / self.time);
        let coupling = sqrt(self.balanced.g.amax() * self.balanced.q.amax());
        let fast = if self.balanced.bounded { 0.0 } else { coupling };
        let fast = sizes.iter().fold(fast, |most, &x| most.max(x));
        let slow = sizes.iter().fold(fast, |least, &x| least.min(x));
        let shift = sqrt(fast * slow.max(SLOW * fast));
        if shift > 0.0 { shift } else { 1.0 }
    }

    /// Makes row i of [A, G] about as large as column i of [A; Q], by one power of two a state.
    fn balance(&mut self) {
        for _ in 0..ROUNDS {
            let mut changed = false;
            for i in 0..S {
                let Problem { a, f, g, q, .. } = &mut self.balanced;
                let (mut row, mut column) = (0.0, 0.0);
                for j in 0..S {
                    let others = if i == j { 0.0 } else { 1.0 };
                    row += others * a[(i, j)].abs() + g[(i, j)].abs();
                    column += others * a[(j, i)].abs() + q[(i, j)].abs();
                }
                let Some(d) = balancing_factor(row, column) else { continue };
                changed = true;
                self.d[i] *= d;
                for j in 0..M {
                    f[(i, j)] /= d;
                }
                for j in 0..S {
                    a[(i, j)] /= d;
                    a[(j, i)] *= d;
                    g[(i, j)] /= d;
                    g[(j, i)] /= d;
                    q[(i, j)] *= d;
                    q[(j, i)] *= d;
                }
            }
            if !changed {
                return;
            }
        }
    }
}

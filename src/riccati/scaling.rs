//! Scaling by powers of two, exact in floating point, before the doubling.

use crate::eigen::{Complex, balancing_factor, modulus, power_of_two_near};
use crate::math::{Matrix, sqrt};

/// Rounds of balancing; each one that goes on has shrunk some row and column.
const ROUNDS: usize = 20;
/// An eigenvalue of A this far below the fastest does not slow the shift down any more.
const SLOW: f64 = 1e-3;

/// `AᵀP + PA − PGP + Q = 0`; `bounded` says that G ≤ 0 (the bounded-real sign).
#[derive(Clone, Copy)]
pub(super) struct Problem<const S: usize> {
    pub(super) a: Matrix<S>,
    pub(super) g: Matrix<S>,
    pub(super) q: Matrix<S>,
    pub(super) bounded: bool,
}

/// A problem in units in which A, G and Q have entries about 1.
///
/// `A = time · D A' D⁻¹`, `G = (time/size) D G' D`, `Q = time · size · D⁻¹ Q' D⁻¹`, then `P = size · D⁻¹ P' D⁻¹`.
pub(super) struct Scaled<const S: usize> {
    /// In new units of time and of P, D = I.
    pub(super) plain: Problem<S>,
    /// The same, balanced by D.
    pub(super) balanced: Problem<S>,
    pub(super) time: f64,
    pub(super) size: f64,
    d: [f64; S],
}

impl<const S: usize> Scaled<S> {
    pub(super) fn new(problem: &Problem<S>) -> Self {
        let Problem { a, g, q, bounded } = *problem;
        let time = power_of_two_near(a.amax());
        let size = match (g.amax(), q.amax()) {
            (0.0, q) => power_of_two_near(q / time),
            (g, 0.0) => 1.0 / power_of_two_near(g / time),
            (g, q) => libm::ldexp(1.0, (libm::frexp(q).1 - libm::frexp(g).1) / 2),
        };
        let plain = Problem { a: a / time, g: g / time * size, q: q / time / size, bounded };
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
                let Problem { a, g, q, .. } = &mut self.balanced;
                let (mut row, mut column) = (0.0, 0.0);
                for j in 0..S {
                    let others = if i == j { 0.0 } else { 1.0 };
                    row += others * a[(i, j)].abs() + g[(i, j)].abs();
                    column += others * a[(j, i)].abs() + q[(i, j)].abs();
                }
                let Some(d) = balancing_factor(row, column) else { continue };
                changed = true;
                self.d[i] *= d;
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

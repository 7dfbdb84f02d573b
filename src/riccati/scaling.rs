//! Scaling by powers of two, exact in floating point, before the doubling.

use nalgebra::{DefaultAllocator, Dim, U1};

use super::dense::{Modes, Room, Square, Tall, mul, plus_diagonal, symmetric};
use crate::eigen::{balancing_factor, modulus, power_of_two_near};
use crate::math::sqrt;

/// Rounds of balancing; each one that goes on has shrunk some row and column.
const ROUNDS: usize = 20;
/// An eigenvalue of A this far below the fastest does not slow the shift down any more.
const SLOW: f64 = 1e-3;

/// `AᵀP + PA − PGP + Q = 0` with G = FFᵀ, or G = −FFᵀ if `bounded` (the bounded-real sign).
#[derive(Clone)]
pub(super) struct Problem<S: Dim, M: Dim>
where
    DefaultAllocator: Room<S, M>,
{
    pub(super) a: Square<S>,
    pub(super) f: Tall<S, M>,
    pub(super) g: Square<S>,
    pub(super) q: Square<S>,
    pub(super) bounded: bool,
}

/// A problem in units in which A, G and Q have entries about 1.
///
/// `A = time · D A' D⁻¹`, `F = (time/size)^½ D F'`, `Q = time · size · D⁻¹ Q' D⁻¹`, then `P = size
/// · D⁻¹ P' D⁻¹`.
pub(super) struct Scaled<S: Dim, M: Dim>
where
    DefaultAllocator: Room<S, M>,
{
    /// In new units of time and of P, D = I.
    pub(super) plain: Problem<S, M>,
    /// The same, balanced by D.
    pub(super) balanced: Problem<S, M>,
    pub(super) time: f64,
    pub(super) size: f64,
    d: Tall<S, U1>,
}

impl<S: Dim, M: Dim> Problem<S, M>
where
    DefaultAllocator: Room<S, M>,
{
    /// The same with a weight Q + c I, which sees every mode and is large enough to move them: `c =
    /// ‖Q‖ + ‖A‖²/‖G‖`.
    pub(super) fn seeing_every_mode(&self) -> Self {
        let (a, g) = (self.a.norm(), self.g.norm());
        let effort = if g > 0.0 { a / g * a } else { 0.0 };
        let weight = self.q.norm() + effort;
        let weight = if weight > 0.0 { weight } else { 1.0 };
        Self { q: plus_diagonal(self.q.clone(), weight), ..self.clone() }
    }

    /// Shifts for the Cayley transform, to be tried in turn. The first is the natural one. A matrix
    /// far from normal, with a large (A − s)⁻¹ for every s that is not, wants the second, and one
    /// that was hit by an eigenvalue of A the others.
    pub(super) fn shifts(&self, modes: &Modes<S>) -> impl Iterator<Item = f64> {
        let natural = self.shift(modes);
        let coupling = if self.bounded { 0.0 } else { self.g.amax() * self.q.amax() };
        let size = self.a.norm_squared() / self.a.nrows() as f64 + coupling;
        let shifts = [natural, sqrt(size), 3.7 * natural, 0.29 * natural];
        // A Hurwitz A is never hit.
        let tried = if self.bounded { 2 } else { shifts.len() };
        shifts.into_iter().take(tried).filter(|&shift| shift > 0.0)
    }

    /// The geometric mean of the slowest and the fastest mode.
    ///
    /// `modes` are the eigenvalues of A; the closed loop has faster ones if G Q is large.
    pub(super) fn shift(&self, modes: &Modes<S>) -> f64 {
        let sizes = modes.iter().map(|&z| modulus(z));
        let coupling = sqrt(self.g.amax() * self.q.amax());
        let fast = if self.bounded { 0.0 } else { coupling };
        let fast = sizes.clone().fold(fast, f64::max);
        let slow = sizes.fold(fast, f64::min);
        let shift = sqrt(fast * slow.max(SLOW * fast));
        if shift > 0.0 { shift } else { 1.0 }
    }
}

impl<S: Dim, M: Dim> Scaled<S, M>
where
    DefaultAllocator: Room<S, M>,
{
    pub(super) fn new(a: &Square<S>, f: &Tall<S, M>, q: &Square<S>, bounded: bool) -> Self {
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
        let g = symmetric(mul(&f, &f.transpose())) * if bounded { -1.0 } else { 1.0 };
        let q = (q / time).map(|x| libm::ldexp(x / time, -2 * k));
        let plain = Problem { a: a / time, f, g, q, bounded };
        let size = libm::ldexp(time, 2 * k);
        let d = Tall::from_element_generic(a.shape_generic().0, U1, 1.0);
        let mut scaled = Self { balanced: plain.clone(), plain, time, size, d };
        scaled.balance();
        scaled
    }

    /// P' in these units, without D.
    pub(super) fn unbalance(&self, p: &Square<S>) -> Square<S> {
        let mut plain = p.clone();
        for j in 0..p.ncols() {
            for i in 0..p.nrows() {
                plain[(i, j)] = p[(i, j)] / self.d[i] / self.d[j];
            }
        }
        plain
    }

    /// |D⁻¹ C D| of a matrix like A, in these units.
    pub(super) fn balanced_norm(&self, c: &Square<S>) -> f64 {
        let mut squares = 0.0;
        for j in 0..c.ncols() {
            for i in 0..c.nrows() {
                let entry = c[(i, j)] / self.d[i] * self.d[j];
                squares += entry * entry;
            }
        }
        sqrt(squares)
    }

    /// Makes row i of [A, G] about as large as column i of [A; Q], by one power of two a state.
    fn balance(&mut self) {
        let (states, inputs) = self.balanced.f.shape();
        for _ in 0..ROUNDS {
            let mut changed = false;
            for i in 0..states {
                let Problem { a, f, g, q, .. } = &mut self.balanced;
                let (mut row, mut column) = (0.0, 0.0);
                for j in 0..states {
                    let others = if i == j { 0.0 } else { 1.0 };
                    row += others * a[(i, j)].abs() + g[(i, j)].abs();
                    column += others * a[(j, i)].abs() + q[(i, j)].abs();
                }
                let Some(d) = balancing_factor(row, column) else { continue };
                changed = true;
                self.d[i] *= d;
                for j in 0..inputs {
                    f[(i, j)] /= d;
                }
                for j in 0..states {
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

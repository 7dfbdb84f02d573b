//! Structure-preserving doubling for `AᵀP + PA − PGP + Q = 0`, either sign of G, with Q ≥ 0.
//!
//! With the Cayley shift s, `A_s = A − sI` and `W = A_s + G A_s⁻ᵀ Q`:
//! `A₀ = I + 2s W⁻¹`, `G₀ = 2s A_s⁻¹ G W⁻ᵀ`, `H₀ = 2s W⁻ᵀ Q A_s⁻¹`, then
//! `A ← A V A`, `G ← G + A V G Aᵀ`, `H ← H + Aᵀ H V A` with `V = (I + G H)⁻¹`.
//! H grows to P, quadratically.
//!
//! Source: Chu, Fan and Lin, "A structure-preserving doubling algorithm for continuous-time
//! algebraic Riccati equations", Linear Algebra and its Applications 396 (2005).

use nalgebra::{DefaultAllocator, Dim};

use super::dense::{Modes, Room, Square, inverse, mul, plus_diagonal, symmetric};
use super::newton::{DOUBLINGS, FADED, Refined, newton};
use super::scaling::Problem;
use crate::math::sqrt;

/// Doubling may stop here, relative to P: one Newton step squares this to the rounding.
const NEAR: f64 = 1e-8;
/// The stabilising solution P of `problem` with Q ≥ 0, or `None`; `modes` are the eigenvalues of
/// its A.
///
/// `exists` says that there is one; else its existence is proven too.
pub(super) fn solve<S: Dim, M: Dim>(
    problem: &Problem<S, M>,
    modes: &Modes<S>,
    exists: bool,
) -> Option<Refined<S>>
where
    DefaultAllocator: Room<S, M>,
{
    let attempt = |shift: f64| {
        let found = newton(problem, limit(problem, shift)?, shift, exists)?;
        found.proven.then_some(found)
    };
    problem.shifts(modes).find_map(attempt)
}

/// The limit of the doubling.
fn limit<S: Dim, M: Dim>(problem: &Problem<S, M>, shift: f64) -> Option<Square<S>>
where
    DefaultAllocator: Room<S, M>,
{
    let shifted = inverse(plus_diagonal(problem.a.clone(), -shift))?;
    let coupling = mul(&problem.g, &mul(&shifted.transpose(), &problem.q));
    let w = inverse(plus_diagonal(&problem.a + coupling, -shift))?;
    let mut g = symmetric(mul(&mul(&shifted, &problem.g), &w.transpose())) * (2.0 * shift);
    let mut h = symmetric(mul(&w.transpose(), &mul(&problem.q, &shifted))) * (2.0 * shift);
    let mut a = plus_diagonal(w * (2.0 * shift), 1.0);
    for _ in 0..DOUBLINGS {
        let v = inverse(plus_diagonal(mul(&g, &h), 1.0))?;
        let va = mul(&v, &a);
        let growth = symmetric(mul(&a.transpose(), &mul(&h, &va)));
        g += symmetric(mul(&mul(&a, &mul(&v, &g)), &a.transpose()));
        h += &growth;
        a = mul(&a, &va);
        let (grown, size) = (growth.norm_squared(), h.norm_squared());
        if grown <= NEAR * NEAR * size && a.norm_squared() <= FADED {
            return Some(h);
        }
        // H only ever grows towards a solution.
        let shrunk = growth.diagonal().min();
        if !grown.is_finite() || shrunk < -NEAR * sqrt(size) {
            return None;
        }
    }
    None
}

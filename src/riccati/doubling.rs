//! Structure-preserving doubling for `AᵀP + PA − PGP + Q = 0`, either sign of G, and the proof that its limit solves it.
//!
//! With the Cayley shift s, `A_s = A − sI` and `W = A_s + G A_s⁻ᵀ Q`:
//! `A₀ = I + 2s W⁻¹`, `G₀ = 2s A_s⁻¹ G W⁻ᵀ`, `H₀ = 2s W⁻ᵀ Q A_s⁻¹`, then
//! `A ← A V A`, `G ← G + A V G Aᵀ`, `H ← H + Aᵀ H V A` with `V = (I + G H)⁻¹`. H grows to P, quadratically.
//!
//! Source: Chu, Fan and Lin, "A structure-preserving doubling algorithm for continuous-time algebraic Riccati
//! equations", Linear Algebra and its Applications 396 (2005).

use super::kernels::{congruence, inverse, mul, symmetric};
use super::scaling::Problem;
use crate::math::{Matrix, sqrt};

/// Doublings allowed. Twelve is usual; each one squares the distance to the limit, or halves it at the limit of γ.
const DOUBLINGS: usize = 60;
/// Doubling may stop here, relative to P: one Newton step squares this to the rounding.
const NEAR: f64 = 1e-8;
/// … once the transition matrix has shrunk so far (squared norm), so that no slow mode is still to come.
const FADED: f64 = 1e-6;
/// A transition matrix that has grown so far (squared norm) leaves no digit: its closed loop is not Hurwitz.
const GROWN: f64 = 1e30;
/// Newton steps allowed; one is usual.
const STEPS: usize = 5;
/// A relative residual of this many roundings cannot be improved.
const ROUNDINGS: f64 = 4.0;
/// The proof must hold by this factor, for the rounding of the residual itself: it is as large as the residual, and as random.
const SAFETY: f64 = 4.0;
/// Shifts tried, in units of the natural one, should a first one hit an eigenvalue of A.
const SHIFTS: [f64; 3] = [1.0, 3.7, 0.29];

/// The stabilising solution P of `problem`, or `None`. `exists` says that there is one; else its existence is proven too.
pub(super) fn solve<const S: usize, const M: usize>(
    problem: &Problem<S, M>,
    shift: f64,
    exists: bool,
) -> Option<Matrix<S>> {
    let attempt = |&factor: &f64| {
        let shift = factor * shift;
        newton(problem, limit(problem, shift)?, shift, exists)
    };
    // With G ≤ 0 and a Hurwitz A any shift is as good as another.
    let attempts = if problem.bounded { &SHIFTS[..1] } else { &SHIFTS[..] };
    attempts.iter().find_map(attempt)
}

/// The limit of the doubling.
fn limit<const S: usize, const M: usize>(problem: &Problem<S, M>, shift: f64) -> Option<Matrix<S>> {
    let identity = Matrix::identity();
    let shifted = inverse(&(problem.a - identity * shift))?;
    let coupling = mul(&problem.g, &mul(&shifted.transpose(), &problem.q));
    let w = inverse(&(problem.a - identity * shift + coupling))?;
    let mut a = identity + w * (2.0 * shift);
    let mut g = symmetric(&mul(&mul(&shifted, &problem.g), &w.transpose())) * (2.0 * shift);
    let mut h = symmetric(&mul(&w.transpose(), &mul(&problem.q, &shifted))) * (2.0 * shift);
    for _ in 0..DOUBLINGS {
        let v = inverse(&(identity + mul(&g, &h)))?;
        let va = mul(&v, &a);
        let growth = symmetric(&mul(&a.transpose(), &mul(&h, &va)));
        g += symmetric(&mul(&mul(&a, &mul(&v, &g)), &a.transpose()));
        h += growth;
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

/// The residual `AᵀP + PA − PGP + Q` and the closed loop `A − GP`.
pub(super) struct Residual<const S: usize> {
    value: Matrix<S>,
    pub(super) closed_loop: Matrix<S>,
    /// |value| over the norms of its four terms: what Newton's method drives down.
    relative: f64,
    /// |value| over 2|A||P| + |PGP| + |Q|: a few roundings, however much cancels in PA.
    pub(super) backward: f64,
}

impl<const S: usize> Residual<S> {
    pub(super) fn of<const M: usize>(problem: &Problem<S, M>, p: &Matrix<S>) -> Self {
        let pa = mul(p, &problem.a);
        // ±(PF)(PF)ᵀ: from the product G = FFᵀ a large P would bring back the rounding of G, squared.
        let sign = if problem.bounded { -1.0 } else { 1.0 };
        let pf = p * problem.f;
        let fp = pf.transpose() * sign;
        let pgp = pf * fp;
        let value = symmetric(&(pa + pa.transpose() - pgp + problem.q));
        let others = pgp.norm() + problem.q.norm();
        let over = |terms: f64| if terms == 0.0 { 0.0 } else { value.norm() / terms };
        Self {
            value,
            closed_loop: problem.a - problem.f * fp,
            relative: over(2.0 * pa.norm() + others),
            backward: over(2.0 * problem.a.norm() * p.norm() + others),
        }
    }
}

/// Newton's method from `p`, ended by the rounding, with a proof that there is a stabilising solution next to the result.
///
/// Proof for G = −FFᵀ, with C the closed loop of P and R its residual: let `CᵀZ + ZC = −I`, `CᵀX + XC = −R`. Then `P + X + tZ`
/// satisfies the strict Riccati inequality if `|Fᵀ(X + tZ)|² < t`, and such a t exists if `4 |FᵀX| |FᵀZ| < 1`. The inequality
/// has a solution iff γ > γ_opt. If that is known, and for G ≥ 0 (Kleinman), a Hurwitz C is enough.
fn newton<const S: usize, const M: usize>(
    problem: &Problem<S, M>,
    mut p: Matrix<S>,
    shift: f64,
    exists: bool,
) -> Option<Matrix<S>> {
    let (mut best, mut least, mut proven) = (p, f64::INFINITY, false);
    for _ in 0..STEPS {
        let residual = Residual::of(problem, &p);
        let relative = residual.relative;
        let improving = relative < 0.5 * least;
        if relative < least {
            (best, least) = (p, relative);
        }
        if proven && (!improving || relative <= ROUNDINGS * f64::EPSILON) {
            return Some(best);
        }
        let (z, x) = lyapunov(&residual.closed_loop, &residual.value, shift)?;
        let product = (problem.f.transpose() * x).norm() * (problem.f.transpose() * z).norm();
        proven = proven || exists || 4.0 * SAFETY * product < 1.0;
        p += x;
    }
    proven.then_some(best)
}

/// (Z, X) with `CᵀZ + ZC + I = 0` and `CᵀX + XC + R = 0`, to about six digits, by Smith's doubling: `E = (C + s)(C − s)⁻¹`,
/// `X ← X + EᵀXE`, `E ← E²`. `None` unless C is Hurwitz.
fn lyapunov<const S: usize>(
    c: &Matrix<S>,
    r: &Matrix<S>,
    shift: f64,
) -> Option<(Matrix<S>, Matrix<S>)> {
    let identity = Matrix::identity();
    let n = inverse(&(c - identity * shift))?;
    let mut e = identity + n * (2.0 * shift);
    let mut z = congruence(&n, &identity) * (2.0 * shift);
    let mut x = congruence(&n, r) * (2.0 * shift);
    for _ in 0..DOUBLINGS {
        z += congruence(&e, &z);
        x += congruence(&e, &x);
        e = mul(&e, &e);
        let left = e.norm_squared();
        if left <= FADED {
            return Some((z, x));
        }
        if !left.is_finite() || left > GROWN {
            return None;
        }
    }
    None
}

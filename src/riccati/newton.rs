//! Newton's method for `AᵀP + PA − PGP + Q = 0`, and the proof that a stabilising solution stands
//! next to its result.
//!
//! A step adds the X of `CᵀX + XC + R = 0`, with C = A − GP Hurwitz and R the residual of P. For G
//! ≥ 0 any P with a Hurwitz C is a start: the steps then fall to the stabilising solution, whatever
//! the signs of Q, if there is one.
//!
//! Source: Kleinman, "On an iterative technique for Riccati equation computations", IEEE
//! Transactions on Automatic Control 13 (1968); Guo and Lancaster, "Analysis and modification of
//! Newton's method for algebraic Riccati equations", Mathematics of Computation 67 (1998).

use nalgebra::{DefaultAllocator, Dim};

use super::dense::{Room, Square, congruence, inverse, mul, plus_diagonal, symmetric};
use super::scaling::Problem;

/// Doublings allowed. Twelve is usual; each one squares the distance to the limit, or halves it at
/// the limit of γ.
pub(super) const DOUBLINGS: usize = 60;
/// A transition matrix that has shrunk so far (squared norm) leaves no slow mode to come.
pub(super) const FADED: f64 = 1e-6;

/// Newton steps allowed: one is usual after doubling, ten from elsewhere, thirty with modes on the
/// imaginary axis.
const STEPS: usize = 60;
/// A step this small, relative to P, is the last: the next would be its square.
const LAST: f64 = 1e-10;
/// Steps larger than this, relative to P, need not shrink: fast modes settle first, and slow ones
/// are still far away.
const FAR: f64 = 1e-6;
/// Nearer, steps that do not shrink by this factor are rounding; with modes on the imaginary axis
/// they halve.
const SHRINKING: f64 = 0.9;
/// Steps that may be made for the proof alone.
const IDLE: usize = 3;
/// The proof must hold by this factor, for the rounding of the residual itself: it is as large as
/// the residual, and as random.
const SAFETY: f64 = 4.0;
/// A transition matrix that has grown so far (squared norm) leaves no digit: its closed loop is not
/// Hurwitz.
const GROWN: f64 = 1e30;

/// The residual `AᵀP + PA − PGP + Q` and the closed loop `A − GP`.
pub(super) struct Residual<S: Dim>
where
    DefaultAllocator: Room<S, S>,
{
    value: Square<S>,
    pub(super) closed_loop: Square<S>,
    /// |value| / (2|A||P| + |G||P|² + |Q|): a few roundings, however much cancels in PA.
    pub(super) backward: f64,
}

impl<S: Dim> Residual<S>
where
    DefaultAllocator: Room<S, S>,
{
    pub(super) fn of<M: Dim>(problem: &Problem<S, M>, p: &Square<S>) -> Self
    where
        DefaultAllocator: Room<S, M>,
    {
        let pa = mul(p, &problem.a);
        // ±(PF)(PF)ᵀ: from the product G = FFᵀ a large P would bring back the rounding of G,
        // squared.
        let sign = if problem.bounded { -1.0 } else { 1.0 };
        let pf = mul(p, &problem.f);
        let fp = pf.transpose() * sign;
        let value = symmetric(&pa + pa.transpose() - mul(&pf, &fp) + &problem.q);
        let [a, g, q] = [&problem.a, &problem.g, &problem.q].map(Square::<S>::norm);
        let size = p.norm();
        let terms = 2.0 * a * size + g * size * size + q;
        // A norm that overflows certifies nothing.
        let over = |terms: f64| if terms < f64::INFINITY { value.norm() / terms } else { f64::NAN };
        Self {
            closed_loop: &problem.a - mul(&problem.f, &fp),
            backward: if terms == 0.0 { 0.0 } else { over(terms) },
            value,
        }
    }
}

/// Where Newton's method ended, with what shift, and whether a stabilising solution is proven to
/// stand next to it.
pub(super) struct Refined<S: Dim>
where
    DefaultAllocator: Room<S, S>,
{
    pub(super) p: Square<S>,
    pub(super) shift: f64,
    pub(super) proven: bool,
}

/// Newton's method from `p`, ended by the rounding; no proof is looked for if a solution is known
/// to exist.
///
/// Proof, with C the closed loop of P and R its residual: let `CᵀZ + ZC = −I`, `CᵀX + XC = −R`.
/// With G = −FFᵀ the matrix `P + X + tZ` satisfies the strict Riccati inequality if `|Fᵀ(X + tZ)|²
/// < t`, and such a t exists if `4 |FᵀX| |FᵀZ| < 1`. The inequality has a solution iff γ > γ_opt.
/// With G = FFᵀ the same holds for `tZ − X` and the equation `CᵀY + YC + YGY − R = 0` of the
/// distance Y from the solution down to P.
pub(super) fn newton<S: Dim, M: Dim>(
    problem: &Problem<S, M>,
    mut p: Square<S>,
    shift: f64,
    exists: bool,
) -> Option<Refined<S>>
where
    DefaultAllocator: Room<S, M>,
{
    let (mut last, mut idle, mut end) = (f64::INFINITY, 0, None);
    let mut proven = exists;
    for _ in 0..STEPS {
        let residual = Residual::of(problem, &p);
        let Some(x) = step(problem, residual, shift, &mut proven) else {
            end.as_ref()?;
            break;
        };
        let (length, size) = (x.norm(), p.norm());
        let shrinking = length < SHRINKING * last || length > FAR * size;
        if shrinking {
            p += x;
        }
        if !shrinking || length <= LAST * size {
            end.get_or_insert_with(|| p.clone());
            if proven || idle == IDLE {
                break;
            }
            idle += 1;
        }
        last = length;
    }
    Some(Refined { p: end.unwrap_or(p), shift, proven })
}

/// The step from a P with this residual; `proven` becomes true if it shows that there is a
/// solution. `None` unless C is Hurwitz.
fn step<S: Dim, M: Dim>(
    problem: &Problem<S, M>,
    Residual { closed_loop: c, value, .. }: Residual<S>,
    shift: f64,
    proven: &mut bool,
) -> Option<Square<S>>
where
    DefaultAllocator: Room<S, M>,
{
    if *proven {
        let [x] = lyapunov(&c, [value], shift)?;
        return Some(x);
    }
    let identity = Square::identity_generic(c.shape_generic().0, c.shape_generic().1);
    let [x, z] = lyapunov(&c, [value, identity], shift)?;
    let f = problem.f.transpose();
    *proven = 4.0 * SAFETY * mul(&f, &x).norm() * mul(&f, &z).norm() < 1.0;
    Some(x)
}

/// The X of `CᵀX + XC + R = 0` for each right side R, to about six digits, by Smith's doubling: `E
/// = (C + s)(C − s)⁻¹`, `X ← X + EᵀXE`, `E ← E²`. `None` unless C is Hurwitz.
fn lyapunov<S: Dim, const K: usize>(
    c: &Square<S>,
    rights: [Square<S>; K],
    shift: f64,
) -> Option<[Square<S>; K]>
where
    DefaultAllocator: Room<S, S>,
{
    let n = inverse(plus_diagonal(c.clone(), -shift))?;
    let mut x = rights.map(|r| congruence(&n, &r) * (2.0 * shift));
    let mut e = plus_diagonal(n * (2.0 * shift), 1.0);
    for _ in 0..DOUBLINGS {
        for x in &mut x {
            *x += congruence(&e, x);
        }
        e = mul(&e, &e);
        let left = e.norm_squared();
        if left <= FADED {
            return Some(x);
        }
        if !left.is_finite() || left > GROWN {
            return None;
        }
    }
    None
}

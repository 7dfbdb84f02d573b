//! Algebraic Riccati equations with a certificate: the bounded-real one of the paper, and the LQR one.
//!
//! `AᵀP + PA + γ⁻² P B BᵀP + Q = 0` (paper (19), γ = 1) and `AᵀP + PA − P B R⁻¹BᵀP + Q = 0`.
//! A: states × states [1/s], B: states × inputs, Q ≥ 0, R > 0; P has the unit of Q times s.
//!
//! The equations have many symmetric solutions. Returned is the stabilising one, which has A + γ⁻²BBᵀP (or A − BR⁻¹BᵀP)
//! Hurwitz, and for the bounded-real sign is the smallest of all. It exists iff `γ > γ_opt`, the peak over all frequencies of
//! the gain from the input to √(xᵀQx). Nothing uncertified is returned: P is finite, symmetric and positive, its residual is
//! below [`RESIDUAL_LIMIT`], the closed loop is Hurwitz, and γ > γ_opt is proven (see `doubling.rs`).
//!
//! Source: structure-preserving doubling (Chu, Fan, Lin 2005), one Newton step.

use nalgebra::{Cholesky, SMatrix};

use crate::eigen::{self, eigenvalues, symmetric_min};
use crate::error::{Error, Result, finite, within};
use crate::math::Matrix;

mod doubling;
mod joint;
mod kernels;
mod peak;
mod scaling;

pub use joint::{JointSolution, joint, joint_gamma_opt, joint_lqr, joint_max_scale};

use doubling::{Residual, solve};
use kernels::symmetric;
use scaling::{Problem, Scaled};

/// The largest relative residual that is returned; 1e-15 is usual.
pub const RESIDUAL_LIMIT: f64 = 1e-10;
/// Entries of Q and R this close, relative to the largest, count as symmetric: what a caller's own products leave.
const SYMMETRY: f64 = 1e-12;
/// An eigenvalue above minus this, relative to the largest, counts as zero: what rounding leaves.
const ZERO: f64 = 1e-13;
/// γ this close above γ_opt, relative, cannot be told from it.
const INDISTINCT: f64 = 1e-9;

/// The stabilising solution and its certificate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution<const S: usize> {
    /// P, symmetric.
    pub p: Matrix<S>,
    /// ‖left side‖ / (2‖A‖‖P‖ + ‖the term in PB‖ + ‖Q‖), Frobenius norms: the relative change of the data that it stands for.
    pub residual: f64,
    /// Smallest eigenvalue of P, to about 1e-15 of the largest. It is 0 up to that rounding, instead of positive, where Q does not
    /// see every mode.
    pub min_eigenvalue: f64,
    /// Largest real part of the closed loop A + γ⁻²BBᵀP or A − BR⁻¹BᵀP [1/s], negative.
    pub max_real: f64,
}

/// The stabilising solution of `AᵀP + PA + γ⁻² P B BᵀP + Q = 0` for a Hurwitz `a`, `q` ≥ 0 and `gamma` > 0.
///
/// `gamma` = ∞ gives the Lyapunov equation.
///
/// # Errors
/// `NotFinite`, `OutOfRange` (gamma), `NotSymmetric`, `NotPositive` (q), `NotHurwitz` (a), and `NoStabilizingSolution` with γ_opt
/// if γ ≤ γ_opt, or above it by less than 1e-9 where rounding hides the difference. `NoConvergence` if the problem is
/// too badly scaled to certify an answer.
pub fn bounded_real<const S: usize, const M: usize>(
    a: &Matrix<S>,
    b: &SMatrix<f64, S, M>,
    q: &Matrix<S>,
    gamma: f64,
) -> Result<Solution<S>> {
    check_gamma(gamma)?;
    let (q, modes) = check_stable(a, b, q)?;
    let scaled = Scaled::new(a, &(b / gamma), &q, true);
    let shift = scaled.shift(&modes);
    if let Some(p) = solve(&scaled.balanced, shift, false) {
        return certify(&scaled, &p);
    }
    let gamma_opt = peak::peak(&peak::Response { a, b, q: &q }, &modes)?;
    if gamma > gamma_opt * (1.0 + INDISTINCT) {
        // So near the limit that rounding hid the proof; the peak supplies it.
        let unsolved = Error::NoConvergence { computing: "riccati solution" };
        return certify(&scaled, &solve(&scaled.balanced, shift, true).ok_or(unsolved)?);
    }
    let max_scale = joint::scale(gamma, gamma_opt);
    Err(Error::NoStabilizingSolution { gamma, gamma_opt, max_scale })
}

/// γ_opt = ‖Q^½ (sI − A)⁻¹ B‖∞ for a Hurwitz `a` and `q` ≥ 0, to 1e-10 relative; 0 for Q = 0.
///
/// # Errors
/// `NotFinite`, `NotSymmetric`, `NotPositive` (q), `NotHurwitz` (a), `NoConvergence`.
pub fn gamma_opt<const S: usize, const M: usize>(
    a: &Matrix<S>,
    b: &SMatrix<f64, S, M>,
    q: &Matrix<S>,
) -> Result<f64> {
    let (q, modes) = check_stable(a, b, q)?;
    peak::peak(&peak::Response { a, b, q: &q }, &modes)
}

/// The stabilising solution of `AᵀP + PA − P B R⁻¹BᵀP + Q = 0` for `q` ≥ 0 and `r` > 0; `a` may be unstable.
///
/// # Errors
/// `NotFinite`, `NotSymmetric`, `NotPositive` (q or r; also for a semidefinite q that does not see a mode on the imaginary
/// axis), `NotStabilizable` (b), `NoConvergence` if the problem is too badly scaled to certify an answer.
pub fn care<const S: usize, const M: usize>(
    a: &Matrix<S>,
    b: &SMatrix<f64, S, M>,
    q: &Matrix<S>,
    r: &SMatrix<f64, M, M>,
) -> Result<Solution<S>> {
    finite("a", a.as_slice())?;
    finite("b", b.as_slice())?;
    let q = semidefinite("q", q)?;
    let r = check_symmetric("r", r)?;
    let Some(factor) = Cholesky::new(r) else {
        let smallest = symmetric_min(&r)?;
        return Err(Error::NotPositive { parameter: "r", smallest, wanted: "positive definite" });
    };
    // B R⁻¹ Bᵀ = (L⁻¹Bᵀ)ᵀ (L⁻¹Bᵀ)
    let mut half = b.transpose();
    factor.l_dirty().solve_lower_triangular_mut(&mut half);
    let modes = eigenvalues(a)?;
    let scaled = Scaled::new(a, &half.transpose(), &q, false);
    let shift = scaled.shift(&modes);
    let refusal = match solve(&scaled.balanced, shift, true).map(|p| certify(&scaled, &p)) {
        Some(Ok(solution)) => return Ok(solution),
        Some(Err(refusal)) => refusal,
        None => Error::NoConvergence { computing: "riccati solution" },
    };
    // With Q > 0 the pair (A, B) alone decides.
    let every_mode = Problem { q: Matrix::identity(), ..scaled.balanced };
    if solve(&every_mode, shift, true).is_none() {
        return Err(Error::NotStabilizable { parameter: "b" });
    }
    let smallest = symmetric_min(&q)?;
    if smallest > ZERO * q.amax() {
        return Err(refusal);
    }
    Err(Error::NotPositive { parameter: "q", smallest, wanted: "positive definite" })
}

/// Accepts P, in the balanced units of `scaled`, or says that the accuracy was not reached.
fn certify<const S: usize, const M: usize>(
    scaled: &Scaled<S, M>,
    balanced: &Matrix<S>,
) -> Result<Solution<S>> {
    let refused = Error::NoConvergence { computing: "riccati solution" };
    let plain = scaled.unbalance(balanced);
    let p = plain * scaled.size;
    if p.iter().any(|x| !x.is_finite()) {
        return Err(refused);
    }
    let residual = Residual::of(&scaled.plain, &plain);
    let max_real = eigen::max_real(&residual.closed_loop)? * scaled.time;
    let positive =
        Cholesky::new(*balanced).is_some() || symmetric_min(balanced)? >= -ZERO * balanced.norm();
    let residual = residual.backward;
    if !(residual <= RESIDUAL_LIMIT && max_real < 0.0 && positive) {
        return Err(refused);
    }
    let min_eigenvalue = symmetric_min(&plain)? * scaled.size;
    Ok(Solution { p, residual, min_eigenvalue, max_real })
}

fn check_gamma(gamma: f64) -> Result<()> {
    if gamma == f64::INFINITY {
        return Ok(());
    }
    within("gamma", &[gamma], |x| x > 0.0, "a number > 0, or infinity")
}

/// Checks A, B and Q of the bounded-real equation; returns Q made exactly symmetric, and the eigenvalues of A.
fn check_stable<const S: usize, const M: usize>(
    a: &Matrix<S>,
    b: &SMatrix<f64, S, M>,
    q: &Matrix<S>,
) -> Result<(Matrix<S>, [eigen::Complex; S])> {
    finite("b", b.as_slice())?;
    let q = semidefinite("q", q)?;
    let modes = eigenvalues(a)?;
    let max_real = modes.iter().fold(f64::NEG_INFINITY, |most, z| most.max(z.re));
    if max_real < 0.0 {
        Ok((q, modes))
    } else {
        Err(Error::NotHurwitz { parameter: "a", max_real })
    }
}

fn semidefinite<const S: usize>(parameter: &'static str, q: &Matrix<S>) -> Result<Matrix<S>> {
    let q = check_symmetric(parameter, q)?;
    if Cholesky::new(q).is_some() {
        return Ok(q);
    }
    let smallest = symmetric_min(&q)?;
    if smallest >= -ZERO * q.amax() {
        return Ok(q);
    }
    Err(Error::NotPositive { parameter, smallest, wanted: "positive semidefinite" })
}

fn check_symmetric<const S: usize>(parameter: &'static str, q: &Matrix<S>) -> Result<Matrix<S>> {
    finite(parameter, q.as_slice())?;
    let (mut row, mut column, mut difference) = (0, 0, 0.0_f64);
    for j in 0..S {
        for i in 0..j {
            let d = q[(i, j)] - q[(j, i)];
            if d.abs() > difference.abs() {
                (row, column, difference) = (i, j, d);
            }
        }
    }
    if difference.abs() > SYMMETRY * q.amax() {
        return Err(Error::NotSymmetric { parameter, row, column, difference });
    }
    Ok(symmetric(q))
}

//! Algebraic Riccati equations with a certificate: the paper's bounded-real one, and the LQR one.
//!
//! `AᵀP + PA + γ⁻² P B BᵀP + Q = 0` (paper (19), γ = 1) and `AᵀP + PA − P B R⁻¹BᵀP + Q = 0`.
//! A: states × states [1/s], B: states × inputs, R > 0, Q symmetric (and ≥ 0 in the first); P has
//! the unit of Q times s.
//!
//! The equations have many symmetric solutions. Returned is the stabilising one, which has A +
//! γ⁻²BBᵀP (or A − BR⁻¹BᵀP) Hurwitz; for the bounded-real sign it is the smallest of all and exists
//! iff `γ > γ_opt`, the peak over all frequencies of the gain from the input to √(xᵀQx). Nothing
//! uncertified is returned: P is finite and symmetric, its residual is at most [`RESIDUAL_LIMIT`],
//! the closed loop is Hurwitz; P ≥ 0 where Q ≥ 0; and γ > γ_opt is proven or, where rounding hides
//! the proof, γ is 1.001 times the largest gain that a search over all frequencies found.
//!
//! Sizes known when compiling need no allocator; `dynamic` (feature `std`) takes any up to 512
//! states. Both are the same text.
//!
//! The way through: checks (`attenuation`, `regulator`) → units (`scaling`) → P (`doubling`) → the
//! last digits and the proof (`newton`) → `certificate`. Where there is no P, these say why: `peak`
//! (over `response`), `reach` (both on `reflector`), `hamiltonian`. Products and inverses are in
//! `dense`, one joint in closed form in `joint`.

use nalgebra::{Const, SMatrix};

use crate::error::Result;
use crate::math::Matrix;

mod attenuation;
mod certificate;
mod dense;
mod doubling;
#[cfg(feature = "std")]
pub mod dynamic;
mod gamma;
mod hamiltonian;
mod joint;
mod newton;
mod peak;
mod reach;
mod reflector;
mod regulator;
mod response;
mod scaling;

pub use certificate::RESIDUAL_LIMIT;
pub use joint::{JointSolution, joint, joint_gamma_opt, joint_lqr, joint_max_scale};

use certificate::Certified;

/// The stabilising solution and its certificate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution<const S: usize> {
    /// P, symmetric.
    pub p: Matrix<S>,
    /// ‖left side‖ / (2‖A‖‖P‖ + ‖G‖‖P‖² + ‖Q‖), Frobenius norms: the relative change of the data
    /// that it stands for.
    pub residual: f64,
    /// Smallest eigenvalue of P, to about 1e-15 of the largest. It is 0 up to that rounding,
    /// instead of positive, where Q does not see every mode, and may be negative where Q is
    /// indefinite.
    pub min_eigenvalue: f64,
    /// Largest real part of the closed loop A + γ⁻²BBᵀP or A − BR⁻¹BᵀP [1/s], negative.
    pub max_real: f64,
}

impl<const S: usize> From<Certified<Const<S>>> for Solution<S> {
    fn from(certified: Certified<Const<S>>) -> Self {
        let Certified { p, residual, min_eigenvalue, max_real } = certified;
        Self { p, residual, min_eigenvalue, max_real }
    }
}

/// The stabilising solution of `AᵀP + PA + γ⁻² P B BᵀP + Q = 0` for a Hurwitz `a`, `q` ≥ 0 and
/// `gamma` > 0.
///
/// `gamma` = ∞ gives the Lyapunov equation.
///
/// # Errors
/// `NotFinite`, `OutOfRange` (gamma), `NotSymmetric`, `NotPositive` (q), `NotHurwitz` (a), and
/// `NoStabilizingSolution` with γ_opt if γ ≤ γ_opt, or above it by less than 1e-9 where rounding
/// hides the difference. `NoConvergence` if the problem is too badly scaled to certify an answer.
pub fn bounded_real<const S: usize, const M: usize>(
    a: &Matrix<S>,
    b: &SMatrix<f64, S, M>,
    q: &Matrix<S>,
    gamma: f64,
) -> Result<Solution<S>> {
    attenuation::bounded_real(a, b, q, gamma).map(Solution::from)
}

/// γ_opt = ‖Q^½ (sI − A)⁻¹ B‖∞ for a Hurwitz `a` and `q` ≥ 0; 0 for Q = 0.
///
/// It is a gain that some frequency has, and where rounding allows the proof, to 1e-10 relative, no
/// frequency has a larger one.
///
/// # Errors
/// `NotFinite`, `NotSymmetric`, `NotPositive` (q), `NotHurwitz` (a), `NoConvergence`.
pub fn gamma_opt<const S: usize, const M: usize>(
    a: &Matrix<S>,
    b: &SMatrix<f64, S, M>,
    q: &Matrix<S>,
) -> Result<f64> {
    attenuation::gamma_opt(a, b, q)
}

/// The stabilising solution of `AᵀP + PA − P B R⁻¹BᵀP + Q = 0` for a symmetric `q` and `r` > 0; `a`
/// may be unstable.
///
/// With `q` ≥ 0 it exists if (A, B) is stabilisable and Q sees the modes of A on the imaginary
/// axis; P is then ≥ 0.
///
/// # Errors
/// `NotFinite`, `NotSymmetric`, `NotPositive` (r), `NotStabilizable` (b), `ModeOnAxis` (q) where no
/// solution is stabilising, `NoConvergence` if the problem is too badly scaled to certify an
/// answer.
pub fn care<const S: usize, const M: usize>(
    a: &Matrix<S>,
    b: &SMatrix<f64, S, M>,
    q: &Matrix<S>,
    r: &SMatrix<f64, M, M>,
) -> Result<Solution<S>> {
    regulator::care(a, b, q, r).map(Solution::from)
}

//! `AᵀP + PA − P B R⁻¹BᵀP + Q = 0` for any symmetric Q.
//!
//! With (A, B) stabilisable the stabilising solution exists iff the Hamiltonian matrix has no eigenvalue on the imaginary axis
//! (Lancaster and Rodman 1995). For Q ≥ 0 doubling finds it, unless Q misses a mode that must be moved. Then, and for an indefinite
//! Q, Newton's method goes down to it from the solution for a larger weight, Q + c I > 0.
//!
//! Source: see `doubling.rs` and `newton.rs`; Lancaster and Rodman, "Algebraic Riccati Equations", theorem 9.3.1.

use nalgebra::{Cholesky, DefaultAllocator, Dim};

use super::certificate::{Certified, Wanted, certify, check_symmetric, definiteness, smallest};
use super::doubling::solve;
use super::hamiltonian;
use super::kernels::{Modes, Room, Square, Tall};
use super::newton::newton;
use super::reach::unreached;
use super::scaling::{Problem, Scaled};
use crate::eigen::{modulus, spectrum};
use crate::error::{Error, Result, finite};

/// With Q indefinite and no proof, the closed loop must stand this far from the axis, relative to its norm: ten times what the
/// rounding of a double eigenvalue can move.
const MARGIN: f64 = 1e-9;
/// A mode that is not reached and stands right of minus this, relative to the norm of A, is not Hurwitz.
const HURWITZ: f64 = 1e-8;
/// An eigenvalue of the Hamiltonian matrix this close to the axis, relative to the largest, cannot be told from one on it: the
/// rounding of a fourfold one.
const AXIS: f64 = 1e-4;

/// See [`super::care`].
pub(super) fn care<S: Dim, M: Dim>(
    a: &Square<S>,
    b: &Tall<S, M>,
    q: &Square<S>,
    r: &Square<M>,
) -> Result<Certified<S>>
where
    DefaultAllocator: Room<S, M> + Room<S, S> + Room<M, M>,
{
    finite("a", a.as_slice())?;
    finite("b", b.as_slice())?;
    let q = check_symmetric("q", q)?;
    let r = check_symmetric("r", r)?;
    let Some(factor) = Cholesky::new(r.clone()) else {
        let smallest = smallest(&r)?;
        return Err(Error::NotPositive { parameter: "r", smallest, wanted: "positive definite" });
    };
    // B R⁻¹ Bᵀ = (L⁻¹Bᵀ)ᵀ (L⁻¹Bᵀ)
    let mut half = b.transpose();
    factor.l_dirty().solve_lower_triangular_mut(&mut half);
    let scaled = Scaled::new(a, &half.transpose(), &q, false);
    let modes = spectrum(&scaled.balanced.a)?;
    let semidefinite = definiteness(&q)? >= 0.0;
    if semidefinite {
        let found = solve(&scaled.balanced, &modes, true);
        if let Some(Ok(found)) = found.map(|found| certify(&scaled, &found.p, Wanted::POSITIVE)) {
            return Ok(found);
        }
    }
    match from_above(&scaled, &modes, semidefinite) {
        Some(found) => Ok(found),
        None => Err(refusal(&scaled)?),
    }
}

/// The stabilising solution by Newton's method, from that for a larger weight.
fn from_above<S: Dim, M: Dim>(
    scaled: &Scaled<S, M>,
    modes: &Modes<S>,
    semidefinite: bool,
) -> Option<Certified<S>>
where
    DefaultAllocator: Room<S, M> + Room<S, S>,
{
    let problem = &scaled.balanced;
    let start = solve(&problem.seeing_every_mode(), modes, true)?;
    let found = newton(problem, start.p, start.shift, false)?;
    let wanted = match (semidefinite, found.proven) {
        (true, true) => Wanted::POSITIVE,
        (true, false) => return None,
        (false, true) => Wanted::STABILIZING,
        (false, false) => Wanted { margin: MARGIN, ..Wanted::STABILIZING },
    };
    certify(scaled, &found.p, wanted).ok()
}

/// Why nothing was found.
fn refusal<S: Dim, M: Dim>(scaled: &Scaled<S, M>) -> Result<Error>
where
    DefaultAllocator: Room<S, M>,
{
    let Problem { a, f, .. } = &scaled.balanced;
    if unreached(a, f)? >= -HURWITZ * a.norm() {
        return Ok(Error::NotStabilizable { parameter: "b" });
    }
    let values = hamiltonian::eigenvalues(&scaled.balanced)?;
    let values = values.as_slice().as_flattened();
    let largest = values.iter().fold(0.0, |most: f64, &z| most.max(modulus(z)));
    let nearest = values.iter().min_by(|x, y| x.re.abs().total_cmp(&y.re.abs()));
    match nearest {
        Some(z) if z.re.abs() <= AXIS * largest => {
            let frequency = z.im.abs() * scaled.time;
            Ok(Error::ModeOnAxis { parameter: "q", frequency })
        }
        _ => Ok(Error::NoConvergence { computing: "riccati solution" }),
    }
}

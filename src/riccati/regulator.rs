//! `AᵀP + PA − P B R⁻¹BᵀP + Q = 0` for any symmetric Q.
//!
//! With (A, B) stabilisable the stabilising solution exists iff the Hamiltonian matrix has no
//! eigenvalue on the imaginary axis (Lancaster and Rodman 1995). For Q ≥ 0 doubling finds it,
//! unless Q misses a mode that must be moved. Then, and for an indefinite Q, Newton's method goes
//! down to it from the solution for a larger weight, Q + c I > 0.
//!
//! Source: see `doubling.rs` and `newton.rs`; Lancaster and Rodman, "Algebraic Riccati Equations",
//! Oxford 1995.

use nalgebra::{Cholesky, DefaultAllocator, Dim};

use super::certificate::{Certified, Wanted, certify, check_symmetric, definiteness, smallest};
use super::dense::{Modes, Room, Square, Tall};
use super::doubling::solve;
use super::hamiltonian;
use super::newton::newton;
use super::reach::unreached;
use super::scaling::{Problem, Scaled};
use crate::eigen::{Complex, largest_real, modulus, spectrum};
use crate::error::{Error, Result, finite};

/// Without a proof the closed loop must stand this far from the axis, relative to its norm: ten
/// times what the rounding of a double eigenvalue can move.
const MARGIN: f64 = 1e-9;
/// A mode that is not reached (not seen) and stands this close to the axis, relative to the norm of
/// A, counts as on it.
const HURWITZ: f64 = 1e-7;
/// A closed loop with a mode this close to the axis, relative to the norm of A, is looked at twice.
const SLOW: f64 = 1e-3;
/// A hidden mode much nearer to the axis than the slowest one of the closed loop was moved by
/// rounding alone.
const UNMOVED: f64 = 0.1;
/// An eigenvalue of the Hamiltonian matrix this close to the axis, relative to the largest, cannot
/// be told from one on it: the rounding of a fourfold one.
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
        return Err(Error::not_positive("r", smallest, "positive definite"));
    };
    // B R⁻¹ Bᵀ = (L⁻¹Bᵀ)ᵀ (L⁻¹Bᵀ)
    let mut half = b.transpose();
    factor.l_dirty().solve_lower_triangular_mut(&mut half);
    let scaled = Scaled::new(a, &half.transpose(), &q, false);
    let modes = spectrum(&scaled.balanced.a)?;
    let semidefinite = definiteness(&q)? >= 0.0;
    let direct =
        || certify(&scaled, &solve(&scaled.balanced, &modes, true)?.p, Wanted::POSITIVE).ok();
    let found = if semidefinite { direct() } else { None };
    let Some(found) = found.or_else(|| from_above(&scaled, &modes, semidefinite)) else {
        return Err(refusal(&scaled, semidefinite)?);
    };
    // Rounding lets a mode on the axis be reached, or seen, and moves it by its root or less.
    let slowest = -found.max_real / scaled.time;
    if slowest > SLOW * scaled.balanced.a.norm() {
        return Ok(found);
    }
    hidden_mode(&scaled, semidefinite, UNMOVED * slowest)?.map_or(Ok(found), Err)
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
    let wanted = if semidefinite { Wanted::POSITIVE } else { Wanted::STABILIZING };
    let wanted = if found.proven { wanted } else { Wanted { margin: MARGIN, ..wanted } };
    if !found.proven && hidden_mode(scaled, semidefinite, f64::INFINITY).ok()?.is_some() {
        return None;
    }
    certify(scaled, &found.p, wanted).ok()
}

/// Why nothing was found.
fn refusal<S: Dim, M: Dim>(scaled: &Scaled<S, M>, semidefinite: bool) -> Result<Error>
where
    DefaultAllocator: Room<S, M> + Room<S, S>,
{
    if let Some(refusal) = hidden_mode(scaled, semidefinite, f64::INFINITY)? {
        return Ok(refusal);
    }
    let values = hamiltonian::eigenvalues(&scaled.balanced)?;
    let values = values.as_slice().as_flattened();
    let largest = values.iter().fold(0.0, |most: f64, &z| most.max(modulus(z)));
    let refusal = on_axis(values, AXIS * largest, scaled.time);
    Ok(refusal.unwrap_or(Error::no_convergence("riccati solution")))
}

/// The refusal for a mode of A that B does not reach, right of the axis or nearly, or that a Q ≥ 0
/// does not see, on the axis or nearly; nearly is within `distance` at most, in balanced units.
fn hidden_mode<S: Dim, M: Dim>(
    scaled: &Scaled<S, M>,
    semidefinite: bool,
    distance: f64,
) -> Result<Option<Error>>
where
    DefaultAllocator: Room<S, M> + Room<S, S>,
{
    let Problem { a, f, q, .. } = &scaled.balanced;
    let distance = distance.min(HURWITZ * a.norm());
    if unreached(a, f, largest_real)? >= -distance {
        return Ok(Some(Error::not_stabilizable("b")));
    }
    if !semidefinite {
        return Ok(None);
    }
    unreached(&a.transpose(), q, |modes| on_axis(modes, distance, scaled.time))
}

/// The refusal for the one of `values` nearest to the imaginary axis, if it is within `distance`.
fn on_axis(values: &[Complex], distance: f64, time: f64) -> Option<Error> {
    let nearest = values.iter().min_by(|x, y| x.re.abs().total_cmp(&y.re.abs()))?;
    let frequency = nearest.im.abs() * time;
    (nearest.re.abs() <= distance).then_some(Error::mode_on_axis("q", frequency))
}

//! What is checked before P is returned: finite, symmetric, a small residual, a Hurwitz closed
//! loop, and P ≥ 0 where Q ≥ 0.

use nalgebra::{Cholesky, DefaultAllocator, Dim};

use super::dense::{Room, Square};
use super::newton::Residual;
use super::scaling::Scaled;
use crate::eigen::{largest_real, spectrum, symmetric_spectrum};
use crate::error::{Error, Result, finite};

/// The largest residual that is returned, relative to `2‖A‖‖P‖ + ‖G‖‖P‖² + ‖Q‖` with G = γ⁻²BBᵀ or
/// BR⁻¹Bᵀ, in Frobenius norms. 1e-16 is usual.
pub const RESIDUAL_LIMIT: f64 = 1e-12;

/// Entries of Q and R this close, relative to the largest, count as symmetric: what a caller's own
/// products leave.
const SYMMETRY: f64 = 1e-12;
/// An eigenvalue above minus this, relative to the largest, counts as zero: what rounding leaves.
const ZERO: f64 = 1e-13;
/// An eigenvalue of P above minus this, relative to the largest, counts as zero. With an accurate P
/// and a Hurwitz closed loop P ≥ 0 follows from Q ≥ 0, but for what rounding leaves where P is
/// ill-conditioned.
const ZERO_OF_P: f64 = 1e-9;
/// A closed loop is Hurwitz if its slowest mode is left of minus this, relative to its norm: what
/// rounding cannot have moved there.
const ROUNDING: f64 = 1e-14;

/// The stabilising solution and its certificate, of any size: see [`super::Solution`].
pub(super) struct Certified<S: Dim>
where
    DefaultAllocator: Room<S, S>,
{
    pub(super) p: Square<S>,
    pub(super) residual: f64,
    pub(super) min_eigenvalue: f64,
    pub(super) max_real: f64,
}

/// What P must be besides accurate.
#[derive(Clone, Copy)]
pub(super) struct Wanted {
    /// P ≥ 0.
    pub(super) positive: bool,
    /// The slowest mode of the closed loop stands this far left, relative to its norm.
    pub(super) margin: f64,
}

impl Wanted {
    pub(super) const POSITIVE: Self = Self { positive: true, margin: ROUNDING };
    pub(super) const STABILIZING: Self = Self { positive: false, margin: ROUNDING };
}

/// Accepts P, in the balanced units of `scaled`, or says that the accuracy was not reached.
pub(super) fn certify<S: Dim, M: Dim>(
    scaled: &Scaled<S, M>,
    balanced: &Square<S>,
    wanted: Wanted,
) -> Result<Certified<S>>
where
    DefaultAllocator: Room<S, M> + Room<S, S>,
{
    let refused = Error::no_convergence("riccati solution");
    let plain = scaled.unbalance(balanced);
    let p = &plain * scaled.size;
    if p.iter().any(|x| !x.is_finite()) {
        return Err(refused);
    }
    let Residual { closed_loop, backward: residual, .. } = Residual::of(&scaled.plain, &plain);
    let max_real = largest_real(spectrum(&closed_loop)?.as_slice());
    let hurwitz = max_real < 0.0 && -max_real > wanted.margin * scaled.balanced_norm(&closed_loop);
    let positive = || -> Result<bool> {
        Ok(Cholesky::new(balanced.clone()).is_some()
            || smallest(balanced)? >= -ZERO_OF_P * balanced.norm())
    };
    if !(residual <= RESIDUAL_LIMIT && hurwitz && (!wanted.positive || positive()?)) {
        return Err(refused);
    }
    let min_eigenvalue = smallest(&plain)? * scaled.size;
    Ok(Certified { p, residual, min_eigenvalue, max_real: max_real * scaled.time })
}

/// The smallest eigenvalue of a symmetric matrix.
pub(super) fn smallest<S: Dim>(a: &Square<S>) -> Result<f64>
where
    DefaultAllocator: Room<S, S>,
{
    Ok(symmetric_spectrum(a)?.iter().fold(f64::INFINITY, |least, &x| least.min(x)))
}

/// The smallest eigenvalue of a symmetric matrix, or 0 if it is not more negative than rounding
/// leaves it; +∞ if it is definite.
pub(super) fn definiteness<S: Dim>(q: &Square<S>) -> Result<f64>
where
    DefaultAllocator: Room<S, S>,
{
    if Cholesky::new(q.clone()).is_some() {
        return Ok(f64::INFINITY);
    }
    let smallest = smallest(q)?;
    Ok(if smallest >= -ZERO * q.amax() { 0.0 } else { smallest })
}

/// `q`, made exactly symmetric.
pub(super) fn check_symmetric<S: Dim>(parameter: &'static str, q: &Square<S>) -> Result<Square<S>>
where
    DefaultAllocator: Room<S, S>,
{
    finite(parameter, q.as_slice())?;
    let (mut row, mut column, mut difference) = (0, 0, 0.0_f64);
    for j in 0..q.ncols() {
        for i in 0..j {
            let d = q[(i, j)] - q[(j, i)];
            if d.abs() > difference.abs() {
                (row, column, difference) = (i, j, d);
            }
        }
    }
    if difference.abs() > SYMMETRY * q.amax() {
        return Err(Error::not_symmetric(parameter, (row, column), difference));
    }
    Ok(super::dense::symmetric(q.clone()))
}

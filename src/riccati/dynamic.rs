//! The same equations for matrices whose size is known when running, up to 512 states, on the heap.

use nalgebra::{DMatrix, Dyn};

use super::certificate::Certified;
use super::{attenuation, regulator};
use crate::error::{Error, Result, at_most, not_empty};

/// Most states, and most inputs.
pub const MOST_STATES: usize = 512;

/// The stabilising solution and its certificate; the fields are those of [`super::Solution`].
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// P, symmetric.
    pub p: DMatrix<f64>,
    /// ‖left side‖ / (2‖A‖‖P‖ + ‖G‖‖P‖² + ‖Q‖), Frobenius norms.
    pub residual: f64,
    /// Smallest eigenvalue of P.
    pub min_eigenvalue: f64,
    /// Largest real part of the closed loop [1/s], negative.
    pub max_real: f64,
}

impl From<Certified<Dyn>> for Solution {
    fn from(certified: Certified<Dyn>) -> Self {
        let Certified { p, residual, min_eigenvalue, max_real } = certified;
        Self { p, residual, min_eigenvalue, max_real }
    }
}

/// [`super::bounded_real`] for any number of states.
///
/// # Errors
/// As there; `TooMany` beyond [`MOST_STATES`], `WrongLength` for a matrix of another shape than A
/// wants.
pub fn bounded_real(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    q: &DMatrix<f64>,
    gamma: f64,
) -> Result<Solution> {
    check_sizes(a, b, q)?;
    attenuation::bounded_real(a, b, q, gamma).map(Solution::from)
}

/// [`super::gamma_opt`] for any number of states.
///
/// # Errors
/// As [`bounded_real`].
pub fn gamma_opt(a: &DMatrix<f64>, b: &DMatrix<f64>, q: &DMatrix<f64>) -> Result<f64> {
    check_sizes(a, b, q)?;
    attenuation::gamma_opt(a, b, q)
}

/// [`super::care`] for any number of states.
///
/// # Errors
/// As there; `TooMany` beyond [`MOST_STATES`], `WrongLength` for a matrix of another shape than A
/// and B want.
pub fn care(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    q: &DMatrix<f64>,
    r: &DMatrix<f64>,
) -> Result<Solution> {
    check_sizes(a, b, q)?;
    let inputs = b.ncols();
    check_shape("r", r, inputs, inputs)?;
    regulator::care(a, b, q, r).map(Solution::from)
}

fn check_sizes(a: &DMatrix<f64>, b: &DMatrix<f64>, q: &DMatrix<f64>) -> Result<()> {
    let states = a.nrows();
    not_empty("a", states)?;
    check_shape("a", a, states, states)?;
    check_shape("q", q, states, states)?;
    check_shape("b", b, states, b.ncols().max(1))?;
    at_most("a", states, MOST_STATES)?;
    at_most("b", b.ncols(), MOST_STATES)
}

fn check_shape(
    parameter: &'static str,
    m: &DMatrix<f64>,
    rows: usize,
    columns: usize,
) -> Result<()> {
    if m.shape() == (rows, columns) {
        return Ok(());
    }
    Err(Error::wrong_length(parameter, m.len(), rows * columns))
}

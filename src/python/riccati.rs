//! The Riccati equations on matrices of any size up to 16 states.

use nalgebra::SMatrix;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use super::convert::{Array2, matrix, matrix_of, owned2, renamed, scalar_or, wrong_shape};
use super::value_error;
use crate::error::{Error, Result};
use crate::riccati;

type Any<'a, 'py> = &'a Bound<'py, PyAny>;

/// Most states.
const MAX_STATES: usize = 16;

/// Calls `$function::<S>` for the runtime size `$size`.
macro_rules! for_size {
    ($size:expr, $function:ident($($argument:expr),*)) => {
        for_size!(@ $size, $function, ($($argument),*), 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16)
    };
    (@ $size:expr, $function:ident, $arguments:tt, $($s:literal)*) => {
        match $size {
            $($s => $function::<$s> $arguments,)*
            _ => Err(too_many($size)),
        }
    };
}

/// The core's error, with the matrices named as here.
fn upper_case(error: Error) -> PyErr {
    value_error(renamed(error, |parameter| match parameter {
        "a" => "A",
        "b" => "B",
        "q" => "Q",
        "r" => "R",
        other => other,
    }))
}

fn too_many(states: usize) -> PyErr {
    PyValueError::new_err(format!("A: got {states} states, wants 1 to {MAX_STATES}"))
}

/// P of a Riccati equation, certified: finite, symmetric, positive, of small residual, and stabilising.
#[pyclass(name = "RiccatiSolution", module = "steadyarm", frozen)]
pub(super) struct PySolution {
    states: usize,
    p: Vec<f64>,
    /// Relative residual of the equation.
    #[pyo3(get)]
    residual: f64,
    /// Smallest eigenvalue of P.
    #[pyo3(get)]
    min_eigenvalue: f64,
    /// Largest real part of the closed-loop matrix [1/s], < 0.
    #[pyo3(get)]
    max_real: f64,
    problem: Problem,
    equation: Equation,
}

/// A, B with its zero columns, Q.
struct Problem {
    states: usize,
    a: Vec<f64>,
    b: Vec<f64>,
    q: Vec<f64>,
}

/// What closes the equation.
enum Equation {
    BoundedReal {
        gamma: f64,
    },
    /// R, with ones for the zero columns of B.
    Care {
        r: Vec<f64>,
    },
}

#[pymethods]
impl PySolution {
    /// P, (S, S).
    #[getter]
    #[pyo3(name = "P")]
    fn p<'py>(&self, py: Python<'py>) -> PyResult<Array2<'py>> {
        owned2(py, self.p.clone(), self.states)
    }

    /// γ that was asked for; None for `care`.
    #[getter]
    fn gamma(&self) -> Option<f64> {
        if let Equation::BoundedReal { gamma } = self.equation { Some(gamma) } else { None }
    }

    /// The smallest γ with a solution (γ must be larger), found when asked for; None for `care`.
    #[getter]
    fn gamma_opt(&self) -> PyResult<Option<f64>> {
        if self.gamma().is_none() {
            return Ok(None);
        }
        for_size!(self.states, smallest_gamma(&self.problem)).map(Some)
    }

    /// Q may be multiplied by less than this, at this γ; None for `care`.
    #[getter]
    fn max_scale(&self) -> PyResult<Option<f64>> {
        let ratio = |(gamma, gamma_opt): (f64, f64)| (gamma / gamma_opt) * (gamma / gamma_opt);
        Ok(self.gamma().zip(self.gamma_opt()?).map(ratio))
    }

    /// Solves again: the same matrices give the same bits.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let (py, Self { states, problem, equation, .. }) = (slf.py(), slf.get());
        let array = |values: &[f64]| owned2(py, values.to_vec(), *states);
        let (a, b, q) = (array(&problem.a)?, array(&problem.b)?, array(&problem.q)?);
        let core = py.import("steadyarm._core")?;
        Ok(match equation {
            Equation::BoundedReal { gamma } => {
                let arguments = (a, b, q, *gamma).into_pyobject(py)?.into_any();
                (core.getattr("bounded_real_riccati")?, arguments)
            }
            Equation::Care { r } => {
                (core.getattr("care")?, (a, b, q, array(r)?).into_pyobject(py)?.into_any())
            }
        })
    }

    fn __repr__(&self) -> String {
        let Self { states, residual, min_eigenvalue, max_real, .. } = self;
        format!(
            "RiccatiSolution({states} states, residual={residual:.1e}, \
             min_eigenvalue={min_eigenvalue:.6}, max_real={max_real:.6})"
        )
    }
}

/// Solve A'P + PA + γ⁻² P B B' P + Q = 0 (eq. 19) for the stabilising P.
///
/// A (S, S) Hurwitz, S up to 16; B (S, m); Q (S, S) symmetric positive semidefinite; gamma > 0. Raises
/// NoStabilizingSolution where there is none, ValueError for anything else that does not fit.
#[pyfunction]
#[pyo3(signature = (A, B, Q, gamma=None), text_signature = "(A, B, Q, gamma=1.0)")]
#[expect(non_snake_case, reason = "the names of the equation")]
pub(super) fn bounded_real_riccati(
    A: Any<'_, '_>,
    B: Any<'_, '_>,
    Q: Any<'_, '_>,
    gamma: Option<Any<'_, '_>>,
) -> PyResult<PySolution> {
    let (problem, _) = problem(A, B, Q)?;
    let gamma = scalar_or(gamma, 1.0, "gamma")?;
    let (p, [residual, min_eigenvalue, max_real]) =
        for_size!(problem.states, solve_bounded_real(&problem, gamma))?;
    let states = problem.states;
    Ok(PySolution {
        states,
        p,
        residual,
        min_eigenvalue,
        max_real,
        problem,
        equation: Equation::BoundedReal { gamma },
    })
}

/// Solve A'P + PA - P B R⁻¹ B' P + Q = 0 for the stabilising P.
///
/// A (S, S), S up to 16; B (S, m) with (A, B) stabilisable; Q (S, S) symmetric positive semidefinite; R (m, m)
/// symmetric positive definite. Raises ValueError for anything that does not fit.
#[pyfunction]
#[expect(non_snake_case, reason = "the names of the equation")]
pub(super) fn care(
    A: Any<'_, '_>,
    B: Any<'_, '_>,
    Q: Any<'_, '_>,
    R: Any<'_, '_>,
) -> PyResult<PySolution> {
    let (problem, inputs) = problem(A, B, Q)?;
    let states = problem.states;
    let r = padded_weight(&matrix_of(R, "R", inputs, inputs)?, inputs, states);
    let (p, [residual, min_eigenvalue, max_real]) = for_size!(states, solve_care(&problem, &r))?;
    let equation = Equation::Care { r };
    Ok(PySolution { states, p, residual, min_eigenvalue, max_real, problem, equation })
}

/// R with ones for the inputs that B does not have.
fn padded_weight(r: &[f64], inputs: usize, states: usize) -> Vec<f64> {
    let entry = |i: usize, j: usize| match (i < inputs && j < inputs, i == j) {
        (true, _) => r[i * inputs + j],
        (false, diagonal) => f64::from(u8::from(diagonal)),
    };
    (0..states * states).map(|k| entry(k / states, k % states)).collect()
}

/// The matrices, with B padded by zero columns to a square one.
fn problem(a: Any<'_, '_>, b: Any<'_, '_>, q: Any<'_, '_>) -> PyResult<(Problem, usize)> {
    let (states, columns, a) = matrix(a, "A", "a square matrix")?;
    if states != columns {
        return Err(wrong_shape("A", &[states, columns], "a square matrix"));
    }
    if states == 0 || states > MAX_STATES {
        return Err(too_many(states));
    }
    let wanted = format!("({states}, m) with m from 1 to {states}");
    let (rows, inputs, b) = matrix(b, "B", &wanted)?;
    if rows != states || inputs == 0 || inputs > states {
        return Err(wrong_shape("B", &[rows, inputs], &wanted));
    }
    let mut padded = vec![0.0; states * states];
    for (from, to) in b.chunks_exact(inputs.max(1)).zip(padded.chunks_exact_mut(states)) {
        to[..inputs].copy_from_slice(from);
    }
    Ok((Problem { states, a, b: padded, q: matrix_of(q, "Q", states, states)? }, inputs))
}

type Certified = (Vec<f64>, [f64; 3]);

fn certified<const S: usize>(solution: Result<riccati::Solution<S>>) -> PyResult<Certified> {
    let riccati::Solution { p, residual, min_eigenvalue, max_real, .. } =
        solution.map_err(upper_case)?;
    Ok((p.as_slice().to_vec(), [residual, min_eigenvalue, max_real]))
}

fn square<const S: usize>(values: &[f64]) -> SMatrix<f64, S, S> {
    SMatrix::from_row_slice(values)
}

fn solve_bounded_real<const S: usize>(problem: &Problem, gamma: f64) -> PyResult<Certified> {
    let Problem { a, b, q, .. } = problem;
    certified::<S>(riccati::bounded_real(&square(a), &square::<S>(b), &square(q), gamma))
}

fn solve_care<const S: usize>(problem: &Problem, r: &[f64]) -> PyResult<Certified> {
    let Problem { a, b, q, .. } = problem;
    certified::<S>(riccati::care(&square(a), &square::<S>(b), &square(q), &square(r)))
}

fn smallest_gamma<const S: usize>(problem: &Problem) -> PyResult<f64> {
    let Problem { a, b, q, .. } = problem;
    riccati::gamma_opt::<S, S>(&square(a), &square(b), &square(q)).map_err(upper_case)
}

//! The Riccati equations on matrices of any size up to 512 states.

use nalgebra::{DMatrix, SMatrix};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use super::convert::{Any, Array, matrix, matrix_of, renamed, scalar_or, wrong_shape};
use super::errors::value_error;
use crate::error::{Error, Result};
use crate::riccati;
use crate::riccati::dynamic::{self, MOST_STATES, Solution};

/// From this size on other threads of Python go on while an equation is solved.
const LARGE: usize = 16;

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

/// P of a Riccati equation, certified: finite, symmetric, accurate, stabilising.
///
/// P is positive semidefinite where Q is.
#[pyclass(name = "RiccatiSolution", module = "steadyarm", frozen)]
pub(super) struct PySolution {
    solution: Solution,
    problem: Problem,
    equation: Equation,
}

/// A, B, Q.
struct Problem {
    a: DMatrix<f64>,
    b: DMatrix<f64>,
    q: DMatrix<f64>,
}

/// What closes the equation.
enum Equation {
    BoundedReal { gamma: f64 },
    Care { r: DMatrix<f64> },
}

#[pymethods]
impl PySolution {
    /// P, (S, S), symmetric.
    #[getter]
    #[pyo3(name = "P")]
    fn p(&self) -> Array<2> {
        array(&self.solution.p)
    }

    /// ‖left side‖ / (2‖A‖‖P‖ + ‖G‖‖P‖² + ‖Q‖), Frobenius norms, at most 1e-12.
    ///
    /// G is γ⁻²BB' or BR⁻¹B'.
    #[getter]
    fn residual(&self) -> f64 {
        self.solution.residual
    }

    /// Smallest eigenvalue of P; negative only where Q is indefinite, or by rounding.
    #[getter]
    fn min_eigenvalue(&self) -> f64 {
        self.solution.min_eigenvalue
    }

    /// Largest real part of the closed-loop matrix (A + γ⁻²BB'P, or A - BR⁻¹B'P) [1/s], < 0.
    #[getter]
    fn max_real(&self) -> f64 {
        self.solution.max_real
    }

    /// γ that was asked for; None for `care`.
    #[getter]
    fn gamma(&self) -> Option<f64> {
        if let Equation::BoundedReal { gamma } = self.equation { Some(gamma) } else { None }
    }

    /// The smallest γ with a solution (γ must be larger), found when read; None for `care`.
    #[getter]
    fn gamma_opt(&self, py: Python<'_>) -> PyResult<Option<f64>> {
        if self.gamma().is_none() {
            return Ok(None);
        }
        let Problem { a, b, q } = &self.problem;
        py.detach(|| dynamic::gamma_opt(a, b, q)).map(Some).map_err(upper_case)
    }

    /// Q times anything smaller than this has a solution at this γ; None for `care`.
    #[getter]
    fn max_scale(&self, py: Python<'_>) -> PyResult<Option<f64>> {
        let ratio = |(gamma, gamma_opt): (f64, f64)| (gamma / gamma_opt) * (gamma / gamma_opt);
        Ok(self.gamma().zip(self.gamma_opt(py)?).map(ratio))
    }

    /// Solves again: the same matrices give the same bits.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let (py, Self { problem, equation, .. }) = (slf.py(), slf.get());
        let Problem { a, b, q } = problem;
        let (a, b, q) = (array(a), array(b), array(q));
        let core = py.import("steadyarm._core")?;
        Ok(match equation {
            Equation::BoundedReal { gamma } => {
                let arguments = (a, b, q, *gamma).into_pyobject(py)?.into_any();
                (core.getattr("bounded_real_riccati")?, arguments)
            }
            Equation::Care { r } => {
                (core.getattr("care")?, (a, b, q, array(r)).into_pyobject(py)?.into_any())
            }
        })
    }

    fn __repr__(&self) -> String {
        let Solution { p, residual, min_eigenvalue, max_real } = &self.solution;
        format!(
            "RiccatiSolution({} states, residual={residual:.1e}, \
             min_eigenvalue={min_eigenvalue:.6}, max_real={max_real:.6})",
            p.nrows()
        )
    }
}

/// Solve ``A'P + PA + γ⁻² P B B' P + Q = 0`` (19) for the stabilising P, with a certificate.
///
/// Parameters
/// ----------
/// A: (S, S), Hurwitz, S up to 512.
/// B: (S, m), m up to S.
/// Q: (S, S), symmetric positive semidefinite.
/// gamma: γ > 0, or infinity: the Lyapunov equation.
///
/// Raises
/// ------
/// NoStabilizingSolution
///     If γ is not larger than γ_opt = ‖Q^½ (sI - A)⁻¹ B‖∞.
/// ValueError, TypeError
///     Naming the argument.
#[pyfunction]
#[pyo3(signature = (A, B, Q, gamma=None), text_signature = "(A, B, Q, gamma=1.0)")]
#[expect(non_snake_case, reason = "the names of the equation")]
pub(super) fn bounded_real_riccati(
    A: Any<'_, '_>,
    B: Any<'_, '_>,
    Q: Any<'_, '_>,
    gamma: Option<Any<'_, '_>>,
) -> PyResult<PySolution> {
    let problem = Problem::new(A, B, Q)?;
    let gamma = scalar_or(gamma, 1.0, "gamma")?;
    PySolution::of(A.py(), problem, Equation::BoundedReal { gamma })
}

/// Solve ``A'P + PA - P B R⁻¹ B' P + Q = 0`` for the stabilising P, with a certificate.
///
/// Parameters
/// ----------
/// A: (S, S), S up to 512.
/// B: (S, m), m up to S, with (A, B) stabilisable.
/// Q: (S, S), symmetric. It may be indefinite, where a stabilising solution exists.
/// R: (m, m), symmetric positive definite.
///
/// Raises
/// ------
/// ValueError, TypeError
///     Naming the argument: B if no input stabilises A; Q if the Hamiltonian matrix
///     ``[A, -BR⁻¹B'; -Q, -A']`` has an eigenvalue on the imaginary axis, with its frequency.
#[pyfunction]
#[expect(non_snake_case, reason = "the names of the equation")]
pub(super) fn care(
    A: Any<'_, '_>,
    B: Any<'_, '_>,
    Q: Any<'_, '_>,
    R: Any<'_, '_>,
) -> PyResult<PySolution> {
    let problem = Problem::new(A, B, Q)?;
    let inputs = problem.b.ncols();
    let r = from_rows(inputs, inputs, &matrix_of(R, "R", inputs, inputs)?);
    PySolution::of(A.py(), problem, Equation::Care { r })
}

impl PySolution {
    fn of(py: Python<'_>, problem: Problem, equation: Equation) -> PyResult<Self> {
        let solve = || problem.solve(&equation);
        let found = if problem.a.nrows() < LARGE { solve() } else { py.detach(solve) };
        let solution = found.map_err(upper_case)?;
        Ok(Self { solution, problem, equation })
    }
}

impl Problem {
    fn new(a: Any<'_, '_>, b: Any<'_, '_>, q: Any<'_, '_>) -> PyResult<Self> {
        let (states, columns, a) = matrix(a, "A", "a square matrix")?;
        if states != columns {
            return Err(wrong_shape("A", &[states, columns], "a square matrix"));
        }
        if states == 0 || states > MOST_STATES {
            let message = format!("A: got {states} states, wants 1 to {MOST_STATES}");
            return Err(PyValueError::new_err(message));
        }
        let wanted = format!("({states}, m) with m from 1 to {states}");
        let (rows, inputs, b) = matrix(b, "B", &wanted)?;
        if rows != states || inputs == 0 || inputs > states {
            return Err(wrong_shape("B", &[rows, inputs], &wanted));
        }
        Ok(Self {
            a: from_rows(states, states, &a),
            b: from_rows(states, inputs, &b),
            q: from_rows(states, states, &matrix_of(q, "Q", states, states)?),
        })
    }

    /// One and two joints are solved on the stack, in a fraction of the time.
    fn solve(&self, equation: &Equation) -> Result<Solution> {
        let Self { a, b, q } = self;
        match (b.shape(), equation) {
            ((2, 1), _) => self.solve_on_stack::<2, 1>(equation),
            ((4, 2), _) => self.solve_on_stack::<4, 2>(equation),
            (_, Equation::BoundedReal { gamma }) => dynamic::bounded_real(a, b, q, *gamma),
            (_, Equation::Care { r }) => dynamic::care(a, b, q, r),
        }
    }

    fn solve_on_stack<const S: usize, const M: usize>(
        &self,
        equation: &Equation,
    ) -> Result<Solution> {
        let square = |m: &DMatrix<f64>| SMatrix::<f64, S, S>::from_column_slice(m.as_slice());
        let (a, q) = (square(&self.a), square(&self.q));
        let b = SMatrix::<f64, S, M>::from_column_slice(self.b.as_slice());
        let found = match equation {
            Equation::BoundedReal { gamma } => riccati::bounded_real(&a, &b, &q, *gamma),
            Equation::Care { r } => {
                let r = SMatrix::<f64, M, M>::from_column_slice(r.as_slice());
                riccati::care(&a, &b, &q, &r)
            }
        };
        let riccati::Solution { p, residual, min_eigenvalue, max_real } = found?;
        let p = DMatrix::from_column_slice(S, S, p.as_slice());
        Ok(Solution { p, residual, min_eigenvalue, max_real })
    }
}

fn from_rows(rows: usize, columns: usize, values: &[f64]) -> DMatrix<f64> {
    DMatrix::from_row_slice(rows, columns, values)
}

fn array(matrix: &DMatrix<f64>) -> Array<2> {
    Array::rows(matrix.transpose().as_slice().to_vec(), matrix.ncols())
}

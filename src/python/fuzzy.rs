//! `FuzzyApproximator`, `FuzzyCompensator`.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use super::basis::{PyFuzzyBasis, basis_of};
use super::convert::{
    Array1, Array2, joints, matrix, numbers, owned1, owned2, scalar_or, wrong_shape,
};
use super::dispatch::JOINTS;
use super::value_error;
use crate::control::{Adaptation, FuzzyParameters};
use crate::error::{non_negative, within};
use crate::fuzzy::FuzzyApproximator;

type Any<'a, 'py> = &'a Bound<'py, PyAny>;

/// A fuzzy system as a function approximator, y(x) = W ξ(x), fitted to samples (eqs. 3, 5).
#[pyclass(name = "FuzzyApproximator", module = "steadyarm", frozen)]
pub(super) struct PyFuzzyApproximator {
    basis: PyFuzzyBasis,
    approximator: FuzzyApproximator,
}

#[pymethods]
impl PyFuzzyApproximator {
    /// Fit W to samples x (T, inputs) and y (T, outputs): least squares with `ridge` T |W|² added.
    #[staticmethod]
    #[pyo3(signature = (basis, x, y, ridge=None), text_signature = "(basis, x, y, ridge=1e-10)")]
    fn fit(
        basis: Any<'_, '_>,
        x: Any<'_, '_>,
        y: Any<'_, '_>,
        ridge: Option<Any<'_, '_>>,
    ) -> PyResult<Self> {
        let basis = basis_of(basis)?;
        let (samples, inputs, x) = matrix(x, "x", "(samples, inputs)")?;
        if samples == 0 || inputs == 0 {
            let wanted = "(samples, inputs) with at least one of each";
            return Err(wrong_shape("x", &[samples, inputs], wanted));
        }
        let (rows, outputs, y) = matrix(y, "y", &format!("({samples}, outputs)"))?;
        if rows != samples || outputs == 0 {
            return Err(wrong_shape("y", &[rows, outputs], &format!("({samples}, outputs)")));
        }
        let ridge = scalar_or(ridge, 1e-10, "ridge")?;
        let rules = basis.build(inputs, JOINTS)?;
        let approximator =
            FuzzyApproximator::fit(rules, &x, &y, outputs, ridge).map_err(value_error)?;
        Ok(Self { basis, approximator })
    }

    /// y(x) = W ξ(x) over this many inputs with known weights (outputs, rules).
    #[staticmethod]
    fn from_weights(basis: Any<'_, '_>, inputs: usize, weights: Any<'_, '_>) -> PyResult<Self> {
        let basis = basis_of(basis)?;
        let rules = basis.build(inputs, JOINTS)?;
        let wanted = format!("(outputs, {})", rules.rules());
        let (outputs, columns, weights) = matrix(weights, "weights", &wanted)?;
        if outputs == 0 || columns != rules.rules() {
            return Err(wrong_shape("weights", &[outputs, columns], &wanted));
        }
        let approximator = FuzzyApproximator::from_weights(rules, weights).map_err(value_error)?;
        Ok(Self { basis, approximator })
    }

    /// W, (outputs, rules).
    #[getter]
    fn weights<'py>(&self, py: Python<'py>) -> PyResult<Array2<'py>> {
        owned2(py, self.approximator.weights().to_vec(), self.rules())
    }

    /// Number of rules.
    #[getter]
    fn rules(&self) -> usize {
        self.approximator.basis().rules()
    }

    fn __call__<'py>(&self, py: Python<'py>, x: Any<'_, 'py>) -> PyResult<Array2<'py>> {
        let inputs = self.approximator.basis().inputs();
        let (rows, columns, x) = matrix(x, "x", &format!("(samples, {inputs})"))?;
        if columns != inputs {
            return Err(wrong_shape("x", &[rows, columns], &format!("(samples, {inputs})")));
        }
        owned2(
            py,
            self.approximator.evaluate(&x).map_err(value_error)?,
            self.approximator.outputs(),
        )
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let (py, this) = (slf.py(), slf.get());
        let basis = Py::new(py, this.basis.clone())?;
        let arguments = (basis, this.approximator.basis().inputs(), this.weights(py)?);
        let make = slf.get_type().getattr("from_weights")?;
        Ok((make, arguments.into_pyobject(py)?.into_any()))
    }
}

/// The fuzzy compensator ρ̂ = W ξ with the adaptive law (18): gain, Q and γ of (19), robust modifications.
///
/// gain = Γ⁻¹: scalar or (2,), > 0. q: diagonal of Q, a scalar, (4,) for [e₁, e₂, de₁, de₂], or a diagonal (4, 4).
/// gamma: the γ of (19). leak_rate [1/s], error_modification, projection_radius, dead_zone, normalization: off by
/// default.
#[pyclass(name = "FuzzyCompensator", module = "steadyarm", frozen)]
#[derive(Clone)]
pub(super) struct PyFuzzyCompensator {
    pub basis: PyFuzzyBasis,
    pub parameters: FuzzyParameters<JOINTS>,
}

#[pymethods]
impl PyFuzzyCompensator {
    #[new]
    #[pyo3(
        signature = (basis, q=None, gain=None, gamma=None, leak_rate=None, error_modification=None,
            projection_radius=None, dead_zone=None, normalization=None),
        text_signature = "(basis, q=10.0, gain=1.0, gamma=1.0, leak_rate=0.0, error_modification=0.0, \
            projection_radius=None, dead_zone=0.0, normalization=0.0)"
    )]
    #[expect(clippy::too_many_arguments, reason = "keyword arguments of a Python class")]
    fn new(
        basis: Any<'_, '_>,
        q: Option<Any<'_, '_>>,
        gain: Option<Any<'_, '_>>,
        gamma: Option<Any<'_, '_>>,
        leak_rate: Option<Any<'_, '_>>,
        error_modification: Option<Any<'_, '_>>,
        projection_radius: Option<Any<'_, '_>>,
        dead_zone: Option<Any<'_, '_>>,
        normalization: Option<Any<'_, '_>>,
    ) -> PyResult<Self> {
        let basis = basis_of(basis)?;
        let (_, inputs) = basis.for_arm()?;
        let gain = gain.map_or(Ok([1.0; JOINTS]), |g| joints(g, "gain"))?;
        let adaptation = Adaptation {
            gain,
            leak_rate: scalar_or(leak_rate, 0.0, "leak_rate")?,
            error_modification: scalar_or(error_modification, 0.0, "error_modification")?,
            projection_radius: scalar_or(projection_radius, f64::INFINITY, "projection_radius")?,
            dead_zone: scalar_or(dead_zone, 0.0, "dead_zone")?,
            normalization: scalar_or(normalization, 0.0, "normalization")?,
        };
        adaptation.validate().map_err(value_error)?;
        let (q_position, q_velocity) = q.map_or(Ok(([10.0; JOINTS], [10.0; JOINTS])), diagonal)?;
        non_negative("q", &[q_position, q_velocity].concat()).map_err(value_error)?;
        let gamma = scalar_or(gamma, 1.0, "gamma")?;
        if gamma != f64::INFINITY {
            within("gamma", &[gamma], |g| g > 0.0, "a number > 0, or infinity")
                .map_err(value_error)?;
        }
        let parameters = FuzzyParameters { inputs, q_position, q_velocity, gamma, adaptation };
        Ok(Self { basis, parameters })
    }

    /// The basis ξ.
    #[getter]
    fn basis(&self, py: Python<'_>) -> PyResult<Py<PyFuzzyBasis>> {
        Py::new(py, self.basis.clone())
    }

    /// gain = Γ⁻¹ of each joint, (2,).
    #[getter]
    fn gain<'py>(&self, py: Python<'py>) -> Array1<'py> {
        owned1(py, self.parameters.adaptation.gain.to_vec())
    }

    /// γ of (19).
    #[getter]
    fn gamma(&self) -> f64 {
        self.parameters.gamma
    }

    /// Diagonal of Q, (4,): [e₁, e₂, de₁, de₂].
    #[getter]
    fn q<'py>(&self, py: Python<'py>) -> Array1<'py> {
        owned1(py, [self.parameters.q_position, self.parameters.q_velocity].concat())
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let py = slf.py();
        let this = slf.get();
        let a = &this.parameters.adaptation;
        let arguments = (
            this.basis(py)?,
            this.q(py),
            this.gain(py),
            this.gamma(),
            a.leak_rate,
            a.error_modification,
            a.projection_radius,
            a.dead_zone,
            a.normalization,
        );
        Ok((slf.get_type().into_any(), arguments.into_pyobject(py)?.into_any()))
    }

    fn __repr__(&self) -> String {
        let (basis, gain) = (self.basis.__repr__(), self.parameters.adaptation.gain);
        format!("FuzzyCompensator({basis}, gain={gain:?}, gamma={})", self.parameters.gamma)
    }
}

/// Q from a scalar, its diagonal (2 n,), or a diagonal matrix (2 n, 2 n).
fn diagonal(value: Any<'_, '_>) -> PyResult<([f64; JOINTS], [f64; JOINTS])> {
    let size = 2 * JOINTS;
    let list = numbers(value, "q")?;
    let entries = match list.shape[..] {
        [] => vec![list.values[0]; size],
        [n] if n == size => list.values,
        [rows, columns] if rows == size && columns == size => {
            let off = |i: usize| i / size != i % size && list.values[i] != 0.0;
            if let Some(i) = (0..size * size).find(|&i| off(i)) {
                let (row, column, got) = (i / size, i % size, list.values[i]);
                let message = format!(
                    "q[{row}, {column}]: got {got}, wants 0: P is solved joint by joint, for a diagonal Q"
                );
                return Err(PyValueError::new_err(message));
            }
            (0..size).map(|i| list.values[i * size + i]).collect()
        }
        _ => {
            return Err(wrong_shape(
                "q",
                &list.shape,
                &format!("a scalar, ({size},) or ({size}, {size})"),
            ));
        }
    };
    let (position, velocity) = entries.split_at(JOINTS);
    let half = |x: &[f64]| std::array::from_fn(|n| x[n]);
    Ok((half(position), half(velocity)))
}

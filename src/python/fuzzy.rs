//! `FuzzyApproximator`, `FuzzyCompensator`.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use super::basis::{PyFuzzyBasis, basis_of};
use super::convert::{
    Any, Array1, Array2, count, matrix, numbers, owned2, renamed, scalar, scalar_or, wrong_shape,
};
use super::dispatch::{DEFAULT_JOINTS, MAX_JOINTS, for_joints};
use super::errors::value_error;
use super::per_joint::{PerJoint, common_joints};
use crate::control::{Adaptation, FuzzyParameters, KernelParameters};
use crate::error::{non_negative, within};
use crate::fuzzy::FuzzyApproximator;

/// A fuzzy system as a function approximator, y(x) = W ξ(x), fitted to samples (eqs. 3, 5).
#[pyclass(name = "FuzzyApproximator", module = "steadyarm", frozen)]
pub(super) struct PyFuzzyApproximator {
    basis: PyFuzzyBasis,
    /// In a box: its tables stand in whole cache lines, and Python places objects at multiples of
    /// 16 bytes.
    approximator: Box<FuzzyApproximator>,
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
        let rules = basis.over(inputs)?;
        let approximator =
            FuzzyApproximator::fit(rules, &x, &y, outputs, ridge).map_err(value_error)?;
        Ok(Self { basis, approximator: approximator.into() })
    }

    /// y(x) = W ξ(x) over this many inputs with known weights (outputs, rules).
    #[staticmethod]
    fn from_weights(basis: Any<'_, '_>, inputs: usize, weights: Any<'_, '_>) -> PyResult<Self> {
        let basis = basis_of(basis)?;
        let rules = basis.over(inputs)?;
        let wanted = format!("(outputs, {})", rules.rules());
        let (outputs, columns, weights) = matrix(weights, "weights", &wanted)?;
        if outputs == 0 || columns != rules.rules() {
            return Err(wrong_shape("weights", &[outputs, columns], &wanted));
        }
        let approximator = FuzzyApproximator::from_weights(rules, weights).map_err(value_error)?;
        Ok(Self { basis, approximator: approximator.into() })
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

/// The fuzzy compensator ρ̂ = W ξ with the adaptive law (18): gain, Q and γ of (19), robust
/// modifications.
///
/// gain = Γ⁻¹: scalar or (n,), > 0. q: diagonal of Q, a scalar, (2n,) for [e₁ … eₙ, de₁ … deₙ], or
/// a diagonal (2n, 2n). gamma: the γ of (19). leak_rate [1/s], error_modification,
/// projection_radius, dead_zone, normalization: off by default. dictionary: None, or a number of
/// atoms, 1 to 4096: a grid of any number of rules in kernel form, of which the compensator
/// remembers so many states. merge_tolerance: a new state is merged into its nearest where that
/// loses less than this part of it, 0 <= part < 1.
#[pyclass(name = "FuzzyCompensator", module = "steadyarm", frozen)]
#[derive(Clone)]
pub(super) struct PyFuzzyCompensator {
    pub basis: PyFuzzyBasis,
    /// Of the arm that it is for; `None`: any.
    pub joints: Option<usize>,
    gain: PerJoint,
    /// Twice as many values.
    q: PerJoint,
    gamma: f64,
    modifications: Modifications,
    /// Of the kernel form; `None`: every rule has its weight.
    pub kernel: Option<KernelParameters>,
}

/// The robust modifications, which are the same for all joints.
#[derive(Clone, Copy)]
struct Modifications {
    leak_rate: f64,
    error_modification: f64,
    projection_radius: f64,
    dead_zone: f64,
    normalization: f64,
}

impl PyFuzzyCompensator {
    /// The core's parameters for `N` joints.
    pub fn parameters<const N: usize>(&self) -> PyResult<FuzzyParameters<N>> {
        let Modifications {
            leak_rate,
            error_modification,
            projection_radius,
            dead_zone,
            normalization,
        } = self.modifications;
        let adaptation = Adaptation {
            gain: self.gain.each("gain")?,
            leak_rate,
            error_modification,
            projection_radius,
            dead_zone,
            normalization,
        };
        let q = self.q.values(2 * N);
        let half = |offset: usize| std::array::from_fn(|n| q[offset + n]);
        let (q_position, q_velocity) = (half(0), half(N));
        let inputs = self.basis.signals();
        Ok(FuzzyParameters { inputs, q_position, q_velocity, gamma: self.gamma, adaptation })
    }

    /// The same for the joints of an arm.
    pub fn of_joints<'py>(&self, py: Python<'py>, joints: usize) -> PyResult<Py<Self>> {
        Py::new(py, Self { joints: Some(joints), ..self.clone() })
    }

    fn joints_or_default(&self) -> usize {
        self.joints.unwrap_or(DEFAULT_JOINTS)
    }
}

/// Refuses parameters that are out of range.
fn check<const N: usize>(compensator: &PyFuzzyCompensator) -> PyResult<()> {
    let FuzzyParameters { adaptation, q_position, q_velocity, gamma, .. } =
        compensator.parameters::<N>()?;
    adaptation.validate().map_err(value_error)?;
    non_negative("q", &[q_position, q_velocity].concat()).map_err(value_error)?;
    if gamma != f64::INFINITY {
        within("gamma", &[gamma], |g| g > 0.0, "a number > 0, or infinity").map_err(value_error)?;
    }
    Ok(())
}

#[pymethods]
impl PyFuzzyCompensator {
    #[new]
    #[pyo3(
        signature = (basis, q=None, gain=None, gamma=None, leak_rate=None, error_modification=None,
            projection_radius=None, dead_zone=None, normalization=None, dictionary=None,
            merge_tolerance=None),
        text_signature = "(basis, q=10.0, gain=1.0, gamma=1.0, leak_rate=0.0, \
            error_modification=0.0, projection_radius=None, dead_zone=0.0, normalization=0.0, dictionary=None, \
            merge_tolerance=0.05)"
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
        dictionary: Option<Any<'_, '_>>,
        merge_tolerance: Option<Any<'_, '_>>,
    ) -> PyResult<Self> {
        let basis = basis_of(basis)?;
        let gain = PerJoint::or(gain, 1.0, "gain")?;
        if let Some(message) = gain.len().and_then(|joints| basis.other_joints(joints, "gain")) {
            return Err(PyValueError::new_err(message));
        }
        let joints = common_joints(basis.joints, [("gain", gain.len())])?;
        let q = q.map_or(Ok(PerJoint::All(10.0)), |q| diagonal(q, &basis, joints))?;
        let joints = joints.or(q.len().map(|entries| entries / 2));
        let modifications = Modifications {
            leak_rate: scalar_or(leak_rate, 0.0, "leak_rate")?,
            error_modification: scalar_or(error_modification, 0.0, "error_modification")?,
            projection_radius: scalar_or(projection_radius, f64::INFINITY, "projection_radius")?,
            dead_zone: scalar_or(dead_zone, 0.0, "dead_zone")?,
            normalization: scalar_or(normalization, 0.0, "normalization")?,
        };
        let gamma = scalar_or(gamma, 1.0, "gamma")?;
        let kernel = kernel_parameters(&basis, dictionary, merge_tolerance)?;
        let this = Self { basis, joints, gain, q, gamma, modifications, kernel };
        for_joints!(this.joints_or_default(), check(&this))?;
        match (this.joints, kernel) {
            (Some(joints), None) => this.basis.for_arm(joints).map(drop)?,
            (Some(joints), Some(_)) => this.basis.check_for_arm(joints)?,
            (None, _) => {}
        }
        Ok(this)
    }

    /// The basis ξ.
    #[getter]
    fn basis(&self, py: Python<'_>) -> PyResult<Py<PyFuzzyBasis>> {
        Py::new(py, self.basis.clone())
    }

    /// gain = Γ⁻¹ of each joint, (n,).
    #[getter]
    fn gain<'py>(&self, py: Python<'py>) -> Array1<'py> {
        self.gain.array(py, self.joints)
    }

    /// γ of (19).
    #[getter]
    fn gamma(&self) -> f64 {
        self.gamma
    }

    /// Diagonal of Q, (2n,): [e₁ … eₙ, de₁ … deₙ].
    #[getter]
    fn q<'py>(&self, py: Python<'py>) -> Array1<'py> {
        self.q.array(py, Some(2 * self.joints_or_default()))
    }

    /// Atoms of the kernel form at the most; None without a dictionary.
    #[getter]
    fn dictionary(&self) -> Option<usize> {
        self.kernel.map(|kernel| kernel.capacity)
    }

    /// The part of a state that a merge may lose; None without a dictionary.
    #[getter]
    fn merge_tolerance(&self) -> Option<f64> {
        self.kernel.map(|kernel| kernel.merge_tolerance)
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let py = slf.py();
        let this = slf.get();
        let Modifications {
            leak_rate,
            error_modification,
            projection_radius,
            dead_zone,
            normalization,
        } = this.modifications;
        // With the joints known, by the basis or by the gain.
        let gain = match this.joints {
            Some(joints) => PerJoint::Each(this.gain.values(joints)),
            None => this.gain.clone(),
        };
        let arguments = (
            this.basis(py)?,
            this.q.to_python(py)?,
            gain.to_python(py)?,
            this.gamma,
            leak_rate,
            error_modification,
            projection_radius,
            dead_zone,
            normalization,
            this.dictionary(),
            this.merge_tolerance(),
        );
        Ok((slf.get_type().into_any(), arguments.into_pyobject(py)?.into_any()))
    }

    fn __repr__(&self) -> String {
        let Self { basis, gain, gamma, .. } = self;
        let form = self.dictionary().map_or_else(String::new, |it| format!(", dictionary={it}"));
        format!("FuzzyCompensator({}, gain={gain:?}, gamma={gamma}{form})", basis.__repr__())
    }
}

/// The kernel form that is asked for, of a basis that has one.
fn kernel_parameters(
    basis: &PyFuzzyBasis,
    dictionary: Option<Any<'_, '_>>,
    merge_tolerance: Option<Any<'_, '_>>,
) -> PyResult<Option<KernelParameters>> {
    let Some(dictionary) = dictionary else {
        if let Some(given) = merge_tolerance {
            let message = format!(
                "merge_tolerance: got {} without a dictionary, wants one: dictionary=256",
                given.str()?
            );
            return Err(PyValueError::new_err(message));
        }
        return Ok(None);
    };
    let capacity = count(dictionary, "dictionary")?;
    let mut kernel = KernelParameters { capacity, ..KernelParameters::default() };
    if let Some(given) = merge_tolerance {
        kernel.merge_tolerance = scalar(given, "merge_tolerance")?;
    }
    let argument = |parameter| if parameter == "capacity" { "dictionary" } else { parameter };
    kernel.validate().map_err(|error| value_error(renamed(error, argument)))?;
    if !basis.is_grid() {
        let message = format!(
            "dictionary: got {capacity} for {}, wants form=\"grid\": no other has a kernel form",
            basis.__repr__()
        );
        return Err(PyValueError::new_err(message));
    }
    Ok(Some(kernel))
}

/// Q from a scalar, its diagonal (2n,), or a diagonal matrix (2n, 2n).
fn diagonal(value: Any<'_, '_>, basis: &PyFuzzyBasis, joints: Option<usize>) -> PyResult<PerJoint> {
    let list = numbers(value, "q")?;
    let possible = |size: usize| size.is_multiple_of(2) && (1..=MAX_JOINTS).contains(&(size / 2));
    let fits = |size: usize| joints.map_or(possible(size), |joints| size == 2 * joints);
    if let Some(&size) = list.shape.first()
        && possible(size)
        && let Some(message) = basis.other_joints(size / 2, "q")
    {
        return Err(PyValueError::new_err(message));
    }
    match list.shape[..] {
        [] => Ok(PerJoint::All(list.values[0])),
        [size] if fits(size) => Ok(PerJoint::Each(list.values)),
        [size, columns] if size == columns && fits(size) => {
            let off = |i: usize| i / size != i % size && list.values[i] != 0.0;
            if let Some(i) = (0..size * size).find(|&i| off(i)) {
                let (row, column, got) = (i / size, i % size, list.values[i]);
                let message = format!(
                    "q[{row}, {column}]: got {got}, wants 0: P is solved joint by joint, for a \
                     diagonal Q"
                );
                return Err(PyValueError::new_err(message));
            }
            Ok(PerJoint::Each((0..size).map(|i| list.values[i * size + i]).collect()))
        }
        _ => {
            let size = joints.map_or("2n".into(), |joints| (2 * joints).to_string());
            let wanted = format!("a scalar, ({size},) or ({size}, {size})");
            Err(wrong_shape("q", &list.shape, &wanted))
        }
    }
}

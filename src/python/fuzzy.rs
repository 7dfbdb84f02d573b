//! `FuzzyApproximator`, `FuzzyCompensator`.

use std::sync::Arc;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use super::basis::{PyFuzzyBasis, basis_of, refused};
use super::convert::{Any, Array, Given, count, matrix, numbers, scalar, scalar_or, wrong_shape};
use super::dispatch::{DEFAULT_JOINTS, MAX_JOINTS};
use super::form::{New, PyForm};
use super::per_joint::{other_count, per_joint};
use crate::control::{FuzzyParameters, KernelParameters};
use crate::fuzzy::FuzzyApproximator;
use crate::scenario::{CompensatorSettings, PerJoint, Rules};

/// A fuzzy system as a function approximator, y(x) = W ξ(x) (3), (5), fitted by `fit`.
///
/// Call it with ``x`` (T, inputs): it gives y at every row, (T, outputs).
#[pyclass(name = "FuzzyApproximator", module = "steadyarm", frozen)]
pub(super) struct PyFuzzyApproximator {
    basis: PyFuzzyBasis,
    /// In a box: its tables stand in whole cache lines, and Python places objects at multiples of
    /// 16 bytes.
    approximator: Box<FuzzyApproximator>,
}

#[pymethods]
impl PyFuzzyApproximator {
    /// Fit W to T samples: min Σ |W ξ(xₖ) - yₖ|² + ridge T |W|².
    ///
    /// ``x`` (T, inputs), ``y`` (T, outputs), ``ridge`` >= 0; at most 4096 rules. Raises ValueError
    /// naming the argument; ``ridge`` if it is too small for the samples to determine W.
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
        let approximator = FuzzyApproximator::fit(rules, &x, &y, outputs, ridge)?;
        Ok(Self { basis, approximator: approximator.into() })
    }

    /// Use known weights (outputs, rules) over this many inputs.
    ///
    /// Raises ValueError for a wrong shape, or weights that are not finite.
    #[staticmethod]
    fn from_weights(basis: Any<'_, '_>, inputs: usize, weights: Any<'_, '_>) -> PyResult<Self> {
        let basis = basis_of(basis)?;
        let rules = basis.over(inputs)?;
        let wanted = format!("(outputs, {})", rules.rules());
        let (outputs, columns, weights) = matrix(weights, "weights", &wanted)?;
        if outputs == 0 || columns != rules.rules() {
            return Err(wrong_shape("weights", &[outputs, columns], &wanted));
        }
        let approximator = FuzzyApproximator::from_weights(rules, weights)?;
        Ok(Self { basis, approximator: approximator.into() })
    }

    /// W, (outputs, rules).
    #[getter]
    fn weights(&self) -> Array<2> {
        Array::rows(self.approximator.weights().to_vec(), self.rules())
    }

    /// Number of rules.
    #[getter]
    fn rules(&self) -> usize {
        self.approximator.basis().rules()
    }

    fn __call__(&self, x: Any<'_, '_>) -> PyResult<Array<2>> {
        let inputs = self.approximator.basis().inputs();
        let (rows, columns, x) = matrix(x, "x", &format!("(samples, {inputs})"))?;
        if columns != inputs {
            return Err(wrong_shape("x", &[rows, columns], &format!("(samples, {inputs})")));
        }
        let y = self.approximator.evaluate(&x)?;
        Ok(Array::rows(y, self.approximator.outputs()))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let (py, this) = (slf.py(), slf.get());
        let basis = &*this.basis.settings;
        let arguments = (basis, this.approximator.basis().inputs(), this.weights());
        let make = slf.get_type().getattr("from_weights")?;
        Ok((make, arguments.into_pyobject(py)?.into_any()))
    }
}

/// The fuzzy compensator ρ̂ = W ξ (12)-(13) with the adaptive law (18); P comes from (19).
///
/// ``dW/dt = gain BᵀP x ξᵀ`` with ``gain = Γ⁻¹``: the paper's Γ = diag(7, 7) is a gain of 1/7.
///
/// Parameters
/// ----------
/// basis: ξ and the signals it sees.
/// q: Q of (19): a scalar for all entries, its diagonal (2n,) for [e₁ … eₙ, de₁ … deₙ], or a
///     diagonal matrix (2n, 2n); >= 0. The paper's is 10.
/// gain: Γ⁻¹, scalar or (n,), > 0.
/// gamma: attenuation level γ of (19), > 0 or infinity; the paper's is 1.
/// leak_rate: σ-modification as a rate [1/s]: the weights return to their prior like
///     exp(-leak_rate t).
/// error_modification: e-modification κ: a leak at the rate gain κ |BᵀPx|.
/// projection_radius: radius of the ball that |W - W₀| stays in, the paper's Ω_f; None or inf for
///     none.
/// dead_zone: d₀: the gain is scaled by max(0, 1 - d₀/|BᵀPx|).
/// normalization: ν: the gain is divided by 1 + ν |ξ|².
/// dictionary: None: every rule has its weight. A number, 1 to 4096: the kernel form of a "grid" of
///     any number of rules. At most so many states are remembered, and W = Σ cₖ ξ(xₖ)ᵀ is made of
///     them. It is the same to rounding until a state is merged or dropped. The `dictionary` of a
///     `ComputedTorque` counts both, and bounds what they lost. 256 is a good number; memory grows
///     with its square. |ξ|² is a product over the inputs: over many inputs, sets that overlap
///     widely learn next to nothing. Make them narrow (σ of 0.3 spacings) and the gain large.
/// merge_tolerance: a new state is merged into its nearest where that loses less than this part of
///     it, 0 <= part < 1 (0 merges nothing); 0.05 with a dictionary, refused without.
///
/// Raises
/// ------
/// ValueError, TypeError
///     Naming the parameter. Whether (19) has a solution shows when a `ComputedTorque` with its
///     gains is built: it raises `NoStabilizingSolution`.
#[pyclass(name = "FuzzyCompensator", module = "steadyarm", frozen, extends = PyForm)]
#[derive(Clone)]
pub(super) struct PyFuzzyCompensator {
    pub basis: PyFuzzyBasis,
    /// Of the arm that it is for; `None`: any.
    pub joints: Option<usize>,
    /// Of the kernel form; `None`: every rule has its weight.
    pub kernel: Option<KernelParameters>,
    settings: Arc<CompensatorSettings>,
}

impl PyFuzzyCompensator {
    /// The compensator of settings with a basis that was checked.
    pub fn made(settings: CompensatorSettings) -> PyResult<New<Self>> {
        let basis = PyFuzzyBasis { settings: Arc::new(settings.basis.clone()) };
        let settings = settings.checked().map_err(|error| refused(error, &basis.settings))?;
        let joints = settings.joints().map_err(other_count)?;
        let kernel = settings.kernel()?;
        let settings = Arc::new(settings);
        Ok(New(PyForm::under(settings.clone(), Self { basis, joints, kernel, settings })))
    }

    /// The core's parameters for `N` joints.
    pub fn parameters<const N: usize>(&self) -> PyResult<FuzzyParameters<N>> {
        Ok(self.settings.parameters()?)
    }

    /// The same for the joints of an arm.
    pub fn of_joints(&self, joints: usize) -> PyResult<New<Self>> {
        let gain = PerJoint::Each(self.settings.gain.values(joints));
        Self::made(CompensatorSettings { gain, ..(*self.settings).clone() })
    }

    fn joints_or_default(&self) -> usize {
        self.joints.unwrap_or(DEFAULT_JOINTS)
    }
}

#[pymethods]
impl PyFuzzyCompensator {
    #[new]
    #[pyo3(
        signature = (basis, q=None, gain=None, gamma=None, leak_rate=None, error_modification=None,
            projection_radius=None, dead_zone=None, normalization=None, dictionary=None,
            merge_tolerance=None),
        text_signature = "(basis, q=10.0, gain=1.0, gamma=1.0, leak_rate=0.0, \
            error_modification=0.0, projection_radius=None, dead_zone=0.0, normalization=0.0, \
            dictionary=None, merge_tolerance=0.05)"
    )]
    #[expect(clippy::too_many_arguments, reason = "keyword arguments of a Python class")]
    fn new(
        basis: Any<'_, '_>,
        q: Given<'_, '_>,
        gain: Given<'_, '_>,
        gamma: Given<'_, '_>,
        leak_rate: Given<'_, '_>,
        error_modification: Given<'_, '_>,
        projection_radius: Given<'_, '_>,
        dead_zone: Given<'_, '_>,
        normalization: Given<'_, '_>,
        dictionary: Given<'_, '_>,
        merge_tolerance: Given<'_, '_>,
    ) -> PyResult<PyClassInitializer<Self>> {
        let basis = basis_of(basis)?;
        let mut settings = CompensatorSettings::new((*basis.settings).clone());
        if let Some(gain) = gain {
            settings.gain = per_joint(gain, "gain")?;
            let joints = settings.gain.count();
            if let Some(message) = joints.and_then(|joints| basis.other_joints(joints, "gain")) {
                return Err(PyValueError::new_err(message));
            }
        }
        let joints = settings.joints().map_err(other_count)?;
        if let Some(q) = q {
            settings.q = diagonal(q, &basis, joints)?;
        }
        for (number, given, name) in [
            (&mut settings.gamma, gamma, "gamma"),
            (&mut settings.leak_rate, leak_rate, "leak_rate"),
            (&mut settings.error_modification, error_modification, "error_modification"),
            (&mut settings.projection_radius, projection_radius, "projection_radius"),
            (&mut settings.dead_zone, dead_zone, "dead_zone"),
            (&mut settings.normalization, normalization, "normalization"),
        ] {
            *number = scalar_or(given, *number, name)?;
        }
        settings.dictionary = dictionary.map(|it| count(it, "dictionary", 1)).transpose()?;
        let form = settings.basis.form;
        if let Some(capacity) = settings.dictionary.filter(|_| form != Rules::Grid) {
            let name = form.name();
            return Err(PyValueError::new_err(format!(
                "dictionary: got {capacity} for FuzzyBasis(form={name:?}), wants form=\"grid\": no \
                 other has a kernel form"
            )));
        }
        if let (None, Some(given)) = (dictionary, merge_tolerance) {
            let message = format!(
                "merge_tolerance: got {} without a dictionary, wants one: dictionary=256",
                given.str()?
            );
            return Err(PyValueError::new_err(message));
        }
        let part = merge_tolerance.map(|it| scalar(it, "merge_tolerance"));
        settings.merge_tolerance = part.transpose()?;
        Ok(Self::made(settings)?.0)
    }

    /// The basis ξ.
    #[getter]
    fn basis(&self) -> New<PyFuzzyBasis> {
        PyFuzzyBasis::made(self.basis.settings.clone())
    }

    /// Γ⁻¹ of each joint, (n,).
    #[getter]
    fn gain(&self) -> Array<1> {
        self.settings.gain.values(self.joints_or_default()).into()
    }

    /// γ of (19).
    #[getter]
    fn gamma(&self) -> f64 {
        self.settings.gamma
    }

    /// Diagonal of Q, (2n,): [e₁ … eₙ, de₁ … deₙ].
    #[getter]
    fn q(&self) -> Array<1> {
        self.settings.q.values(2 * self.joints_or_default()).into()
    }

    /// States of the kernel form at the most; None without a dictionary.
    #[getter]
    fn dictionary(&self) -> Option<usize> {
        self.settings.dictionary
    }

    /// The part of a state that a merge may lose; None without a dictionary.
    #[getter]
    fn merge_tolerance(&self) -> Option<f64> {
        self.kernel.map(|kernel| kernel.merge_tolerance)
    }
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

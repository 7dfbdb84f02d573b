//! `FuzzyBasis`.

use std::sync::Arc;

use pyo3::IntoPyObjectExt;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};

use super::convert::{
    Any, Array, Given, count, flag, matrix, numbers, object, scalar, word, wrong_shape, wrong_type,
};
use super::dispatch::{DEFAULT_JOINTS, MAX_JOINTS, too_many_joints};
use super::errors::value_error;
use super::form::{New, PyForm};
use crate::error::{Error, Problem};
use crate::fuzzy::{FuzzyBasis, KernelBasis};
use crate::scenario::{BasisSettings, InputSettings, Numbers, PerJoint, Rules};

/// Most entries of an evaluated basis (2 GiB).
const MAX_ENTRIES: usize = 1 << 28;

/// Gaussian fuzzy sets, how they combine to rules, and the signals they see: ξ(x) of (1)-(4).
///
/// The paper gives the sets but not the rules; all four readings are here. Inputs come joint after
/// joint within a signal: [e₁ … eₙ, de₁ … deₙ] for "error". ξ is finite however far x is from the
/// centres.
///
/// Parameters
/// ----------
/// form: "grid": a rule for every combination of one set per input (5⁴ = 625 for the paper's
///     sets); "shared": rule j uses set j on every input (5); "concat": a rule for every set of
///     every input, normalised input by input (20); "per_joint": a grid for each joint over its
///     own inputs (25 each).
/// centers: centres of the sets, (sets,) for all inputs, or a list of such lists, one an input.
/// width: σ of exp(-((x - c)/σ)²/2), 1e-9 to 1e9: a scalar, one a set, or (with ``centers`` an
///     input) one an input or one list an input. The paper's exp(-(x - c)²) is σ = 1/√2.
/// normalized: fuzzy basis functions (4), or raw firing strengths.
/// inputs: "error" (e, de), the paper's; "state" (q, dq); "reference" (q_d, dq_d); "trajectory"
///     (q_d, dq_d, ddq_d); one signal, a list of signals, or a dict signal -> scale that
///     multiplies it. ``e`` of a continuous joint lies in [-π, π); ``q`` and ``q_d`` are as they
///     are measured and given, turns included.
/// joints: of the arm; by default those that the lists of ``centers`` are for, or any. A controller
///     builds the rules for its own arm.
///
/// Raises
/// ------
/// ValueError, TypeError
///     Naming the parameter. At most 64 inputs, 512 sets, 1 048 576 rules: nothing is allocated
///     before that is known. A "grid" may have any number of rules: it is refused only where they
///     would be written out, so not by a `FuzzyCompensator` with a ``dictionary``.
#[pyclass(name = "FuzzyBasis", module = "steadyarm", frozen, extends = PyForm)]
#[derive(Clone)]
pub(super) struct PyFuzzyBasis {
    pub settings: Arc<BasisSettings>,
}

impl<'py> IntoPyObject<'py> for &BasisSettings {
    type Target = PyAny;
    type Output = Bound<'py, PyAny>;
    type Error = PyErr;

    fn into_pyobject(self, py: Python<'py>) -> PyResult<Self::Output> {
        PyFuzzyBasis::made(Arc::new(self.clone())).into_bound_py_any(py)
    }
}

impl PyFuzzyBasis {
    /// The basis of settings that were checked.
    pub fn made(settings: Arc<BasisSettings>) -> New<Self> {
        New(PyForm::under(settings.clone(), Self { settings }))
    }

    /// The grid over the inputs of an arm, in the kernel form.
    pub fn kernel_for_arm(&self, joints: usize) -> PyResult<KernelBasis> {
        self.settings.kernel(joints).map_err(|error| refused(error, &self.settings))
    }

    /// The basis for an arm.
    pub fn for_arm(&self, joints: usize) -> PyResult<FuzzyBasis> {
        self.settings.build(joints).map_err(|error| refused(error, &self.settings))
    }

    /// The basis over so many inputs, whatever they are.
    pub fn over(&self, inputs: usize) -> PyResult<FuzzyBasis> {
        let basis = self.settings.over(inputs, self.joints_or_default());
        basis.map_err(|error| refused(error, &self.settings))
    }

    /// What is wrong with the lists of centers, where they are for another joint count than `of`
    /// is.
    pub fn other_joints(&self, joints: usize, of: &str) -> Option<String> {
        let own = self.settings.joints.filter(|own| *own != joints)?;
        let (got, wanted) = (self.settings.lists()?, self.settings.inputs.len(joints));
        Some(format!(
            "centers: got {got} lists, one for each input of {own} joints, wants one list, or \
             {wanted} for the {joints} joints of {of}"
        ))
    }

    fn joints_or_default(&self) -> usize {
        self.settings.joints.unwrap_or(DEFAULT_JOINTS)
    }
}

/// The error of a basis, with what to do about it.
pub(super) fn refused(error: Error, settings: &BasisSettings) -> PyErr {
    match error.problem() {
        Problem::TooMany { .. } if settings.form == Rules::Grid && error.parameter() == "rules" => {
            let way = "use dictionary=256, the kernel form of FuzzyCompensator";
            PyValueError::new_err(format!("{error}; {way}"))
        }
        Problem::WrongLength { got, wanted, .. }
            if settings.lists() == Some(got) && error.parameter() == "centers" =>
        {
            PyValueError::new_err(format!(
                "centers: got {got} lists, wants one list, or one for each of {wanted} inputs"
            ))
        }
        _ => value_error(error),
    }
}

#[pymethods]
impl PyFuzzyBasis {
    #[new]
    #[pyo3(
        signature = (form, centers, width, normalized=None, inputs=None, joints=None),
        text_signature = "(form, centers, width, normalized=True, inputs='error', joints=None)"
    )]
    fn new(
        form: Any<'_, '_>,
        centers: Any<'_, '_>,
        width: Any<'_, '_>,
        normalized: Given<'_, '_>,
        inputs: Given<'_, '_>,
        joints: Given<'_, '_>,
    ) -> PyResult<PyClassInitializer<Self>> {
        let form = word(form, "form", Rules::NAMES)?;
        let normalized = normalized.map(|value| flag(value, "normalized")).transpose()?;
        let centers = ragged(centers, "centers")?;
        let width = match width.len() {
            Err(_) => scalar(width, "width")?.into(),
            Ok(_) => ragged(width, "width")?,
        };
        let mut settings = BasisSettings::new(form, centers, width);
        settings.normalized = normalized.unwrap_or(settings.normalized);
        if let Some(inputs) = inputs {
            settings.inputs = signals(inputs)?;
        }
        settings.joints = joints.map(joint_count).transpose()?;
        let checked = settings.clone().checked().map_err(|error| refused(error, &settings))?;
        Ok(Self::made(Arc::new(checked)).0)
    }

    /// How the sets combine to rules.
    #[getter]
    fn form(&self) -> &str {
        self.settings.form.name()
    }

    /// Whether ξ is normalised (4).
    #[getter]
    fn normalized(&self) -> bool {
        self.settings.normalized
    }

    /// Centres of the sets: a list for all inputs, or a list of lists, one an input.
    #[getter]
    fn centers(&self) -> &Numbers {
        &self.settings.centers
    }

    /// σ of the sets, as it was given.
    #[getter]
    fn width(&self) -> &Numbers {
        &self.settings.width
    }

    /// The signals with their scales, in order.
    #[getter]
    fn inputs(&self) -> Vec<(String, f64)> {
        self.settings.inputs.0.clone()
    }

    /// Joints of the arm that it is for; None: any.
    #[getter]
    fn joints(&self) -> Option<usize> {
        self.settings.joints
    }

    /// Number of rules for the arm's inputs (per_joint: of all joints together).
    #[getter]
    fn rules<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let joints = self.joints_or_default();
        if self.settings.form != Rules::Grid {
            return Ok(self.for_arm(joints)?.rules().into_pyobject(py)?.into_any());
        }
        let one = 1_usize.into_pyobject(py)?.into_any();
        let axes = self.settings.axes(self.settings.inputs.len(joints));
        let axes = axes.map_err(|error| refused(error, &self.settings))?;
        axes.iter().try_fold(one, |rules, axis| rules.mul(axis.centers.len()))
    }

    /// ξ at every row of ``x``: (T, inputs) -> (T, rules).
    ///
    /// The number of inputs follows from ``x``; per_joint takes input k for joint k mod n. Raises
    /// ValueError for a wrong shape, NaN, infinity, too many rules, or more than 2²⁸ entries.
    fn evaluate(&self, x: Any<'_, '_>) -> PyResult<Array<2>> {
        let (rows, columns, values) = matrix(x, "x", "(samples, inputs)")?;
        if columns == 0 {
            return Err(wrong_shape("x", &[rows, 0], "(samples, inputs) with at least one input"));
        }
        let basis = self.over(columns)?;
        let entries = rows.checked_mul(basis.rules()).filter(|&entries| entries <= MAX_ENTRIES);
        let Some(entries) = entries else {
            let most = MAX_ENTRIES / basis.rules();
            let message = format!("x: got {rows} samples, wants at most {most} for so many rules");
            return Err(PyValueError::new_err(message));
        };
        let mut work = vec![0.0; basis.work_len()];
        let mut xi = vec![0.0; entries];
        for (x, xi) in values.chunks_exact(columns).zip(xi.chunks_exact_mut(basis.rules())) {
            basis.evaluate(x, &mut work, xi)?;
        }
        Ok(Array::rows(xi, basis.rules()))
    }
}

/// The argument `joints`.
fn joint_count(value: Any<'_, '_>) -> PyResult<usize> {
    match count(value, "joints", 1)? {
        joints @ 1..=MAX_JOINTS => Ok(joints),
        other => Err(too_many_joints(other)),
    }
}

/// A list of numbers (for all inputs), or a list of such lists.
fn ragged(value: Any<'_, '_>, name: &str) -> PyResult<Numbers> {
    let nested = value.try_iter().ok().and_then(|mut i| i.next()).and_then(Result::ok);
    if nested.is_some_and(|first| first.len().is_ok() && !first.is_instance_of::<PyString>()) {
        let lists = value.try_iter()?.map(|row| one_dimension(&row?, name));
        return Ok(Numbers::Rows(lists.collect::<PyResult<_>>()?));
    }
    one_dimension(value, name).map(PerJoint::Each).map(Numbers::Same)
}

fn one_dimension(value: Any<'_, '_>, name: &str) -> PyResult<Vec<f64>> {
    let list = numbers(value, name)?;
    if list.shape.len() == 1 {
        Ok(list.values)
    } else {
        Err(wrong_shape(name, &list.shape, "(sets,)"))
    }
}

/// "error", ["e", "de"] or {"e": 1.0, "de": 0.5}.
fn signals(value: Any<'_, '_>) -> PyResult<InputSettings> {
    let unknown = |name: &str| {
        PyValueError::new_err(format!("inputs: got {name:?}, {}", InputSettings::wanted()))
    };
    if let Ok(name) = value.extract::<String>() {
        return InputSettings::named(&name).ok_or_else(|| unknown(&name));
    }
    let mut chosen: Vec<(String, f64)> = Vec::new();
    if let Ok(scales) = value.cast::<PyDict>() {
        for (name, scale) in scales {
            let name: String = name.extract().map_err(|_| wrong_type("inputs", &name, "names"))?;
            let place = format!("inputs[{name:?}]");
            let scale = scalar(&scale, &place)?;
            if !scale.is_finite() || scale == 0.0 {
                let message = format!("{place}: got {scale}, wants a finite scale other than 0");
                return Err(PyValueError::new_err(message));
            }
            chosen.push((name, scale));
        }
    } else {
        let wanted = "a name, a list of names or a dict name -> scale";
        let names: Vec<String> =
            value.extract().map_err(|_| wrong_type("inputs", value, wanted))?;
        chosen.extend(names.into_iter().map(|name| (name, 1.0)));
    }
    for (i, (name, _)) in chosen.iter().enumerate() {
        if !InputSettings::is_signal(name) {
            return Err(unknown(name));
        }
        if chosen[..i].iter().any(|(other, _)| other == name) {
            let message = format!("inputs: got {name:?} twice, wants every signal once");
            return Err(PyValueError::new_err(message));
        }
    }
    if chosen.is_empty() {
        return Err(PyValueError::new_err("inputs: got no signal, wants at least one"));
    }
    Ok(InputSettings(chosen))
}

/// A basis that was given as an argument.
pub(super) fn basis_of(value: Any<'_, '_>) -> PyResult<PyFuzzyBasis> {
    Ok(object::<PyFuzzyBasis>(value, "basis", "a FuzzyBasis")?.get().clone())
}

//! `FuzzyBasis`.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};

use super::convert::{
    Any, Array2, count, flag, matrix, numbers, owned2, scalar, word, wrong_shape, wrong_type,
};
use super::dispatch::{DEFAULT_JOINTS, MAX_JOINTS, too_many_joints};
use super::errors::value_error;
use crate::control::{Inputs, Signal};
use crate::error::Problem;
use crate::fuzzy::{Axis, Form, FuzzyBasis, KernelBasis};

/// Names of the signals.
const SIGNALS: [(&str, Signal); 7] = [
    ("e", Signal::E),
    ("de", Signal::De),
    ("q", Signal::Q),
    ("dq", Signal::Dq),
    ("q_d", Signal::QDesired),
    ("dq_d", Signal::DqDesired),
    ("ddq_d", Signal::DdqDesired),
];

/// Names of the forms.
const FORMS: [&str; 4] = ["grid", "shared", "concat", "per_joint"];

/// Most entries of an evaluated basis (2 GiB).
const MAX_ENTRIES: usize = 1 << 28;

/// Gaussian fuzzy sets, how they combine to rules, and the signals they see (eqs. 1-4).
///
/// form: "grid" (a rule for every combination of one set per input), "shared" (rule j uses set j on
/// every input), "concat" (a rule for every set of every input) or "per_joint" (a grid for each
/// joint). centers: a list for all inputs, or a list of lists, one an input; width: σ, a scalar,
/// one a set, or one an input. normalized: fuzzy basis functions (4) or raw firing strengths.
/// inputs: "error" (e, de), "state" (q, dq), "reference" (q_d, dq_d), "trajectory" (q_d, dq_d,
/// ddq_d), a list of these signals, or a dict signal -> scale. joints: of the arm; by default those
/// that the lists of centers are for, or any.
#[pyclass(name = "FuzzyBasis", module = "steadyarm", frozen)]
#[derive(Clone)]
pub(super) struct PyFuzzyBasis {
    form: String,
    /// Centres of every input, or one list for all.
    centers: Vec<Vec<f64>>,
    /// Widths likewise.
    widths: Vec<Vec<f64>>,
    shared_axis: bool,
    normalized: bool,
    inputs: Inputs,
    /// Joints of the arm that it is for; `None`: any.
    pub joints: Option<usize>,
}

impl PyFuzzyBasis {
    /// The basis over this many inputs of `joints` joints, with all its rules.
    pub fn build(&self, inputs: usize, joints: usize) -> PyResult<FuzzyBasis> {
        let form = match self.form.as_str() {
            "grid" => Form::Grid,
            "shared" => Form::Shared,
            "concat" => Form::Concat,
            _ => Form::PerJoint { joints },
        };
        let axes = self.axes(inputs)?;
        FuzzyBasis::new(form, self.normalized, &axes).map_err(|error| {
            let too_many = matches!(error.problem(), Problem::TooMany { .. });
            if form == Form::Grid && too_many && error.parameter() == "rules" {
                let way = "use dictionary=256, the kernel form of FuzzyCompensator";
                return PyValueError::new_err(format!("{error}; {way}"));
            }
            value_error(error)
        })
    }

    /// The grid over the inputs of an arm, in the kernel form.
    pub fn kernel_for_arm(&self, joints: usize) -> PyResult<KernelBasis> {
        let axes = self.axes(self.inputs.len(joints))?;
        KernelBasis::new(self.normalized, &axes).map_err(value_error)
    }

    /// Whether rule after rule is a product over all inputs, of which there may be too many to
    /// write out.
    pub fn is_grid(&self) -> bool {
        self.form == "grid"
    }

    /// Refuses what makes no basis for an arm; a grid may have any number of rules.
    pub fn check_for_arm(&self, joints: usize) -> PyResult<()> {
        if self.is_grid() {
            self.kernel_for_arm(joints).map(drop)
        } else {
            self.for_arm(joints).map(drop)
        }
    }

    /// What is wrong with the lists of centers, where they are for another joint count than `of`
    /// is.
    pub fn other_joints(&self, joints: usize, of: &str) -> Option<String> {
        let own = self.joints.filter(|own| !self.shared_axis && *own != joints)?;
        let (got, wanted) = (self.centers.len(), self.inputs.len(joints));
        Some(format!(
            "centers: got {got} lists, one for each input of {own} joints, wants one list, or \
             {wanted} for the {joints} \
             joints of {of}"
        ))
    }

    /// The sets of so many inputs.
    fn axes(&self, inputs: usize) -> PyResult<Vec<Axis<'_>>> {
        if !self.shared_axis && self.centers.len() != inputs {
            let (got, wanted) = (self.centers.len(), inputs);
            let message = format!(
                "centers: got {got} lists, wants one list, or one for each of {wanted} inputs"
            );
            return Err(PyValueError::new_err(message));
        }
        let axis = |k: usize| {
            let k = if self.shared_axis { 0 } else { k };
            Axis { centers: &self.centers[k], widths: &self.widths[k] }
        };
        Ok((0..inputs).map(axis).collect())
    }

    /// The basis for an arm.
    pub fn for_arm(&self, joints: usize) -> PyResult<FuzzyBasis> {
        self.build(self.inputs.len(joints), joints)
    }

    /// The basis over so many inputs, whatever they are.
    pub fn over(&self, inputs: usize) -> PyResult<FuzzyBasis> {
        self.build(inputs, self.joints_or_default())
    }

    pub fn signals(&self) -> Inputs {
        self.inputs
    }

    fn joints_or_default(&self) -> usize {
        self.joints.unwrap_or(DEFAULT_JOINTS)
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
        normalized: Option<Any<'_, '_>>,
        inputs: Option<Any<'_, '_>>,
        joints: Option<Any<'_, '_>>,
    ) -> PyResult<Self> {
        let form = word(form, "form", FORMS)?;
        let normalized = normalized.map_or(Ok(true), |value| flag(value, "normalized"))?;
        let (centers, shared_axis) = ragged(centers, "centers")?;
        let widths = widths(width, &centers, shared_axis)?;
        let inputs = inputs.map_or(Ok(Inputs::error()), signals)?;
        let joints = match joints {
            Some(joints) => Some(joint_count(joints)?),
            None if shared_axis => None,
            None => joints_of_lists(centers.len(), &inputs),
        };
        let form = form.into();
        let basis = Self { form, centers, widths, shared_axis, normalized, inputs, joints };
        if shared_axis || joints.is_some() {
            basis.check_for_arm(basis.joints_or_default())?;
        }
        Ok(basis)
    }

    /// How the sets combine to rules.
    #[getter]
    fn form(&self) -> &str {
        &self.form
    }

    /// Whether ξ is normalised (4).
    #[getter]
    fn normalized(&self) -> bool {
        self.normalized
    }

    /// The signals with their scales, in order.
    #[getter]
    fn inputs(&self) -> Vec<(&'static str, f64)> {
        let name = |signal| SIGNALS.iter().find(|(_, s)| *s == signal).map_or("", |(name, _)| name);
        self.inputs.signals().iter().map(|&(signal, scale)| (name(signal), scale)).collect()
    }

    /// Joints of the arm that it is for; None: any.
    #[getter]
    fn joints(&self) -> Option<usize> {
        self.joints
    }

    /// Number of rules for the arm's inputs, however many.
    #[getter]
    fn rules<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let joints = self.joints_or_default();
        if !self.is_grid() {
            return Ok(self.for_arm(joints)?.rules().into_pyobject(py)?.into_any());
        }
        let one = 1_usize.into_pyobject(py)?.into_any();
        let axes = self.axes(self.inputs.len(joints))?;
        axes.iter().try_fold(one, |rules, axis| rules.mul(axis.centers.len()))
    }

    /// ξ at every row of x: (T, inputs) -> (T, rules). The inputs are joint after joint within a
    /// signal.
    fn evaluate<'py>(&self, py: Python<'py>, x: Any<'_, 'py>) -> PyResult<Array2<'py>> {
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
            basis.evaluate(x, &mut work, xi).map_err(value_error)?;
        }
        owned2(py, xi, basis.rules())
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let PyFuzzyBasis { form, centers, widths, shared_axis, normalized, joints, .. } = slf.get();
        let py = slf.py();
        let list = |x: &Vec<Vec<f64>>| -> PyResult<Bound<'py, PyAny>> {
            if *shared_axis {
                Ok(x[0].clone().into_pyobject(py)?)
            } else {
                Ok(x.clone().into_pyobject(py)?)
            }
        };
        let inputs = PyDict::new(py);
        for (name, scale) in slf.get().inputs() {
            inputs.set_item(name, scale)?;
        }
        let arguments = (form, list(centers)?, list(widths)?, *normalized, inputs, *joints);
        Ok((slf.get_type().into_any(), arguments.into_pyobject(py)?.into_any()))
    }

    pub fn __repr__(&self) -> String {
        let (form, normalized, inputs) = (&self.form, self.normalized, self.inputs());
        format!("FuzzyBasis(form={form:?}, normalized={normalized}, inputs={inputs:?})")
    }
}

/// The argument `joints`.
fn joint_count(value: Any<'_, '_>) -> PyResult<usize> {
    match count(value, "joints")? {
        joints @ 1..=MAX_JOINTS => Ok(joints),
        other => Err(too_many_joints(other)),
    }
}

/// The joints that so many lists are for, one list an input.
fn joints_of_lists(lists: usize, inputs: &Inputs) -> Option<usize> {
    let signals = inputs.len(1);
    let joints = lists / signals;
    ((1..=MAX_JOINTS).contains(&joints) && lists.is_multiple_of(signals)).then_some(joints)
}

/// A list of numbers (for all inputs), or a list of such lists.
fn ragged(value: Any<'_, '_>, name: &str) -> PyResult<(Vec<Vec<f64>>, bool)> {
    let nested = value.try_iter().ok().and_then(|mut i| i.next()).and_then(Result::ok);
    if nested.is_some_and(|first| first.len().is_ok() && !first.is_instance_of::<PyString>()) {
        let lists = value.try_iter()?.map(|row| one_dimension(&row?, name));
        return Ok((lists.collect::<PyResult<_>>()?, false));
    }
    Ok((vec![one_dimension(value, name)?], true))
}

fn one_dimension(value: Any<'_, '_>, name: &str) -> PyResult<Vec<f64>> {
    let list = numbers(value, name)?;
    if list.shape.len() == 1 {
        Ok(list.values)
    } else {
        Err(wrong_shape(name, &list.shape, "(sets,)"))
    }
}

/// Widths for the centres: a scalar, one a set, one an input, or a list a input.
fn widths(value: Any<'_, '_>, centers: &[Vec<f64>], shared_axis: bool) -> PyResult<Vec<Vec<f64>>> {
    let (lists, flat) = if value.len().is_err() {
        (vec![vec![scalar(value, "width")?]; centers.len()], false)
    } else {
        ragged(value, "width")?
    };
    match (flat, shared_axis) {
        (true, false) if lists[0].len() == centers.len() => {
            Ok(lists[0].iter().map(|&w| vec![w]).collect())
        }
        (false, _) if lists.len() == centers.len() => Ok(lists),
        (true, true) => Ok(lists),
        _ => Err(PyValueError::new_err(format!(
            "width: got {} entries, wants a scalar, or one for each of {} inputs",
            if flat { lists[0].len() } else { lists.len() },
            centers.len()
        ))),
    }
}

/// "error", ["e", "de"] or {"e": 1.0, "de": 0.5}.
fn signals(value: Any<'_, '_>) -> PyResult<Inputs> {
    if let Ok(name) = value.extract::<String>() {
        return match name.as_str() {
            "error" => Ok(Inputs::error()),
            "state" => Ok(Inputs::state()),
            "reference" => Ok(Inputs::reference()),
            "trajectory" => Ok(Inputs::trajectory()),
            _ => Inputs::new(&[(signal(&name)?, 1.0)]).map_err(value_error),
        };
    }
    let wanted = "a name, a list of names or a dict name -> scale";
    let mut chosen: Vec<(Signal, f64)> = Vec::new();
    if let Ok(scales) = value.cast::<PyDict>() {
        for (name, scale) in scales {
            let name: String = name.extract().map_err(|_| wrong_type("inputs", &name, "names"))?;
            let place = format!("inputs[{name:?}]");
            let scale = scalar(&scale, &place)?;
            if !scale.is_finite() || scale == 0.0 {
                let message = format!("{place}: got {scale}, wants a finite scale other than 0");
                return Err(PyValueError::new_err(message));
            }
            chosen.push((signal(&name)?, scale));
        }
    } else {
        let names: Vec<String> =
            value.extract().map_err(|_| wrong_type("inputs", value, wanted))?;
        for name in names {
            let signal = signal(&name)?;
            if chosen.iter().any(|(other, _)| *other == signal) {
                let message = format!("inputs: got {name:?} twice, wants every signal once");
                return Err(PyValueError::new_err(message));
            }
            chosen.push((signal, 1.0));
        }
    }
    if chosen.is_empty() {
        return Err(PyValueError::new_err("inputs: got no signal, wants at least one"));
    }
    Inputs::new(&chosen).map_err(value_error)
}

fn signal(name: &str) -> PyResult<Signal> {
    SIGNALS.iter().find(|(known, _)| *known == name).map(|(_, signal)| *signal).ok_or_else(|| {
        let signals: Vec<&str> = SIGNALS.iter().map(|(known, _)| *known).collect();
        let known = signals.join(", ");
        let presets = "error, state, reference, trajectory";
        PyValueError::new_err(format!(
            "inputs: got {name:?}, wants one of {known}, or a preset: {presets}"
        ))
    })
}

/// A basis that was given as an argument.
pub(super) fn basis_of(value: Any<'_, '_>) -> PyResult<PyFuzzyBasis> {
    let basis = value.cast::<PyFuzzyBasis>();
    Ok(basis.map_err(|_| wrong_type("basis", value, "a FuzzyBasis"))?.get().clone())
}

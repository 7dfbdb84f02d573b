//! The simulation call, its record, and its metrics.

use core::ops::ControlFlow;

use pyo3::IntoPyObjectExt;
use pyo3::exceptions::{PyKeyboardInterrupt, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

use super::controller::PyController;
use super::convert::{
    Any, Array, Given, columns, count, joints, matrix, matrix_of, numbers, object, scalar, word,
    wrong_shape,
};
use super::dispatch::{each, of_joints};
use super::effects::PyEffects;
use super::guard::{PyGuard, done};
use super::guarding::{Guards, Own};
use super::monitor::Monitor;
use super::plant::{Plant, Plants, PyPlant};
use super::sources::Source;
use super::tracked::{Tracker, Trackers};
use crate::control::{Channel, Width};
use crate::error::{Error, positive};
use crate::sim::{self, Certificate, Column, Method, Options, Run, Status, Tolerance, Window};

/// Arguments of a simulation that are the same for any joint count, and the start that is not.
struct Settings<'a, 'py> {
    duration: f64,
    dt: f64,
    method: Method,
    control_period: Option<f64>,
    record_every: usize,
    record: sim::Record,
    q0: Given<'a, 'py>,
    dq0: Given<'a, 'py>,
    effects: Given<'a, 'py>,
}

impl Settings<'_, '_> {
    fn options<const N: usize>(&self) -> PyResult<Options<N>> {
        let Self { duration, dt, method, control_period, record_every, record, q0, dq0, effects } =
            *self;
        let start =
            |value: Given<'_, '_>, name| value.map_or(Ok([0.0; N]), |value| joints(value, name));
        let (q0, dq0) = (start(q0, "q0")?, start(dq0, "dq0")?);
        let effects = PyEffects::of(effects)?;
        Ok(Options { duration, dt, method, control_period, q0, dq0, record_every, record, effects })
    }
}

/// Run `steadyarm.simulate`; the tracker given stays as it is.
///
/// Returns the record as a dict, and what a callable raised. The dict has the state that the run
/// started in, and the parts of a tracker in the state that it ended in.
#[pyfunction]
#[pyo3(signature = (plant, tracker, reference, duration, dt, method, control_period, q0, dq0,
    rtol, atol, record_every, record, effects, progress))]
#[expect(clippy::too_many_arguments, reason = "called by keyword from one Python function")]
pub(super) fn simulate<'py>(
    py: Python<'py>,
    plant: Any<'_, 'py>,
    tracker: Any<'_, 'py>,
    reference: Any<'_, 'py>,
    duration: Any<'_, 'py>,
    dt: Any<'_, 'py>,
    method: Any<'_, 'py>,
    control_period: Given<'_, 'py>,
    q0: Given<'_, 'py>,
    dq0: Given<'_, 'py>,
    rtol: Any<'_, 'py>,
    atol: Any<'_, 'py>,
    record_every: Any<'_, 'py>,
    record: Any<'_, 'py>,
    effects: Given<'_, 'py>,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Bound<'py, PyDict>, Option<PyErr>)> {
    let tolerance = Tolerance { rtol: scalar(rtol, "rtol")?, atol: scalar(atol, "atol")? };
    let methods = [("rk4", Method::Rk4), ("dp54", Method::Dp54(tolerance))];
    let method = word(method, "method", methods)?;
    let (duration, dt) = (scalar(duration, "duration")?, scalar(dt, "dt")?);
    let control_period = control_period.map(|it| scalar(it, "control_period")).transpose()?;
    let record_every = count(record_every, "record_every", 1)?;
    let records = [("all", sim::Record::All), ("motion", sim::Record::Motion)];
    let record = word(record, "record", records)?;
    let settings =
        Settings { duration, dt, method, control_period, record_every, record, q0, dq0, effects };
    let plant = object::<PyPlant>(plant, "plant", "a Plant")?;
    let guard = tracker.cast::<PyGuard>().ok();
    let mut guards = guard.map(|guard| guard.try_borrow().map(|guard| guard.twin())).transpose()?;
    let guarded = guard.map(|guard| guard.borrow().tracker.clone_ref(py));
    let tracker = match &guarded {
        Some(tracker) => tracker.bind(py),
        None => object::<PyController>(
            tracker,
            "tracker",
            "a Controller, such as a ComputedTorque, or a Guard",
        )?,
    };
    let mut twin = PyController::twin(tracker)?;
    let start = twin.parts(py).1;
    let (plants, monitor) = (&plant.get().plants, Monitor::new(progress));
    let (record, raised) = each!(&mut twin.trackers, Trackers, tracker => {
        simulated(py, plants, (tracker, guards.as_mut()), reference, settings, monitor)
    })?;
    record.set_item("guard", guards.map(|guards| done(py, &guards)).transpose()?)?;
    record.set_item("start", start)?;
    let (arguments, state) = twin.parts(py);
    record.set_item("tracker", (tracker.get_type(), arguments, state))?;
    Ok((record, raised))
}

/// The part of [`simulate`] that knows the joint count. The tracker ends as the run left it.
fn simulated<'py, const N: usize>(
    py: Python<'py>,
    plants: &Plants,
    (tracker, guards): (&mut Tracker<N>, Option<&mut Guards>),
    reference: Any<'_, 'py>,
    settings: Settings<'_, 'py>,
    mut monitor: Monitor,
) -> PyResult<(Bound<'py, PyDict>, Option<PyErr>)> {
    let joints = plants.joints();
    let plant = each!(plants, Plants, plant => of_joints::<Plant<N>>(&**plant));
    let plant = plant.ok_or_else(|| {
        let message = format!("plant: got one of {joints} joints, wants {N}, as the tracker has");
        PyValueError::new_err(message)
    })?;
    let Tracker { controller, state, latest, .. } = tracker;
    *latest = None;
    let options = settings.options()?;
    controller.law.tell(options.control_period.unwrap_or(f64::NAN));
    let reference = Source::reference(reference, "reference")?;
    let run = py.detach(|| {
        let (system, law) = ((plant, &**controller, &reference), &controller.law);
        let guards = guards.and_then(Own::of_run);
        sim::simulate_by(system, state, guards, &options, |t| {
            // Through a guard the run would go on.
            if law.has_raised() { ControlFlow::Break(()) } else { monitor.look(t) }
        })
    });
    let mut run = run?;
    // All are asked: the plant outlives the run.
    let of_disturbance = plant.disturbance.as_ref().and_then(Source::raised);
    let of_law = controller.law.raised();
    let raised = match monitor.raised.or(reference.raised()).or(of_disturbance).or(of_law) {
        Some(error) if error.is_instance_of::<PyKeyboardInterrupt>(py) => {
            run.status = Status::Interrupted { t: ended(&run) };
            None
        }
        other => other,
    };
    let (status, certificate, rows) = ((run.status, ended(&run)), run.certificate, run.t.len());
    let record = record(py, status, certificate, run.into_columns(), [rows, N])?;
    let (compensator, state) = (&controller.compensator, &state.compensator);
    let weights = compensator.weights(state).ok();
    record
        .set_item("weights", weights.map(|w| (w.len() / N, w)).map(|(n, w)| Array::rows(w, n)))?;
    record.set_item("dictionary", compensator.dictionary(py, state)?)?;
    Ok((record, raised))
}

fn ended<const N: usize>(run: &Run<N>) -> f64 {
    match run.status {
        Status::Finished | Status::Unresolved(_) => run.t.last().copied().unwrap_or(0.0),
        Status::Interrupted { t } | Status::Diverged { t, .. } => t,
    }
}

/// Tell the signals of every record: name, unit, whether there is one a joint, what it is.
#[pyfunction]
pub(super) fn channels() -> Vec<Declared> {
    Run::<1>::channels().map(declared).collect()
}

type Declared = (&'static str, &'static str, bool, &'static str);

fn declared(channel: &Channel) -> Declared {
    let Channel { name, unit, width, doc } = *channel;
    (name, unit, width == Width::Joints, doc)
}

/// A run as a dict: its status and certificate, the `columns` of every record by name, and its
/// `own` with what they are.
fn record<'py>(
    py: Python<'py>,
    (status, ended): (Status, f64),
    certificate: Option<Certificate>,
    all: Vec<Column>,
    [rows, joints]: [usize; 2],
) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("status", self::status(status, ended))?;
    dict.set_item("certificate", certificate.map(|it| figures(py, &it)).transpose()?)?;
    let (columns, own) = (PyDict::new(py), PyList::empty(py));
    let common = Run::<1>::channels().count();
    for (i, Column { channel, values }) in all.into_iter().enumerate() {
        let recorded = values.len() == rows * channel.width.of(joints);
        let array = array(py, channel.width, values, joints)?;
        if i < common {
            columns.set_item(channel.name, recorded.then_some(array))?;
        } else if recorded {
            own.append((declared(&channel), array))?;
        }
    }
    dict.set_item("columns", columns)?;
    dict.set_item("own", own)?;
    Ok(dict)
}

fn array(
    py: Python<'_>,
    width: Width,
    values: Vec<f64>,
    joints: usize,
) -> PyResult<Bound<'_, PyAny>> {
    match width {
        Width::One => Array::from(values).into_bound_py_any(py),
        Width::Joints => Array::rows(values, joints).into_bound_py_any(py),
    }
}

/// Its kind, when it ended, and the reason.
fn status(status: Status, ended: f64) -> (&'static str, f64, String) {
    let (kind, reason) = match status {
        Status::Finished => ("finished", String::new()),
        Status::Interrupted { .. } => ("interrupted", "it was stopped from the keyboard".into()),
        Status::Unresolved(doubt) => ("unresolved", doubt.to_string()),
        Status::Diverged { cause, doubt: None, .. } => ("diverged", cause.to_string()),
        Status::Diverged { cause, doubt: Some(doubt), .. } => {
            ("diverged", format!("{cause}; before that, {doubt}"))
        }
    };
    (kind, ended, reason)
}

fn figures<'py>(py: Python<'py>, certificate: &Certificate) -> PyResult<Bound<'py, PyDict>> {
    let figures = PyDict::new(py);
    figures.set_item("residual", certificate.residual())?;
    figures.set_item("v_start", certificate.v_start)?;
    figures.set_item("v_end", certificate.v_end)?;
    figures.set_item("supplied", certificate.supplied)?;
    figures.set_item("state_cost", certificate.state_cost)?;
    figures.set_item("uncertainty", certificate.uncertainty)?;
    Ok(figures)
}

/// Run `steadyarm.Run.metrics`: the figures of every joint.
///
/// Without ``tau``, the arrays of its figures are empty.
#[pyfunction]
pub(super) fn metrics<'py>(
    py: Python<'py>,
    t: Any<'_, 'py>,
    e: Any<'_, 'py>,
    tau: Given<'_, 'py>,
    window: Any<'_, 'py>,
    band: Any<'_, 'py>,
) -> PyResult<Bound<'py, PyDict>> {
    let numbers_of_window = numbers(window, "window")?;
    let [from, to] = numbers_of_window.values[..] else {
        return Err(wrong_shape("window", &numbers_of_window.shape, "(from, to)"));
    };
    let band = scalar(band, "band")?;
    positive("band", &[band])?;
    let t = numbers(t, "t")?.values;
    let (rows, joints, e) = matrix(e, "e", "(T, n)")?;
    if rows != t.len() {
        return Err(wrong_shape("e", &[rows, joints], &format!("({}, n)", t.len())));
    }
    let tau = tau.map(|tau| matrix_of(tau, "tau", rows, joints)).transpose()?.unwrap_or_default();
    let recorded = t.first().zip(t.last()).filter(|&(first, last)| from <= *last && to >= *first);
    if recorded.is_none() || from > to || from.is_nan() || to.is_nan() {
        return Err(no_sample(from, to, &t));
    }
    let window = Window { from, to, band };
    let column = |values: &[f64], n: usize| -> Vec<[f64; 1]> {
        values.chunks_exact(joints).map(|row| [row[n]]).collect()
    };
    let joints = (0..joints)
        .map(|n| sim::metrics(0, &t, &column(&e, n), &column(&tau, n), window))
        .collect::<Result<Vec<_>, Error>>()
        .map_err(|_| no_sample(from, to, &t))?;
    let moved = if tau.is_empty() { &[][..] } else { &joints };
    let dict = columns!(py, joints, |m|
        rms_e: m.rms_e, max_abs_e: m.max_abs_e, itae: m.itae, settling_time: m.settling_time,
    );
    let torques = columns!(py, moved, |m|
        rms_tau: m.rms_tau, max_abs_tau: m.max_abs_tau, torque_variation: m.torque_variation,
    );
    dict.update(torques.as_mapping())?;
    Ok(dict)
}

fn no_sample(from: f64, to: f64, t: &[f64]) -> PyErr {
    let recorded = match (t.first(), t.last()) {
        (Some(first), Some(last)) => format!("the record runs from {first} to {last} s"),
        _ => "the record is empty".into(),
    };
    let message =
        format!("window: got ({from}, {to}), wants at least one sample in it; {recorded}");
    PyValueError::new_err(message)
}

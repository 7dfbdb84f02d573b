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
use super::dispatch::{each, of_joints, other_joints};
use super::effects::PyEffects;
use super::guard::{PyGuard, done};
use super::guarding::{Guards, Own};
use super::monitor::Monitor;
use super::plant::{Plant, Plants, PyPlant};
use super::sources::Source;
use super::tracked::{Tracker, Trackers};
use crate::control::{Channel, Width};
use crate::effects::Effects;
use crate::error::{Error, positive};
use crate::sim::{self, Certificate, Column, Method, Options, Run, Status, Tolerance, Window};

/// How the time goes on, the same for any joint count.
#[derive(Clone, Copy)]
pub(super) struct Numerics {
    duration: f64,
    dt: f64,
    method: Method,
    control_period: Option<f64>,
}

impl Numerics {
    pub fn of(
        duration: Any<'_, '_>,
        dt: Any<'_, '_>,
        method: Any<'_, '_>,
        control_period: Given<'_, '_>,
        [rtol, atol]: [Any<'_, '_>; 2],
    ) -> PyResult<Self> {
        let tolerance = Tolerance { rtol: scalar(rtol, "rtol")?, atol: scalar(atol, "atol")? };
        let methods = [("rk4", Method::Rk4), ("dp54", Method::Dp54(tolerance))];
        let method = word(method, "method", methods)?;
        let (duration, dt) = (scalar(duration, "duration")?, scalar(dt, "dt")?);
        let control_period = control_period.map(|it| scalar(it, "control_period")).transpose()?;
        Ok(Self { duration, dt, method, control_period })
    }

    /// With them, the options of a run of `N` joints from this start through these effects.
    pub fn options<const N: usize>(
        self,
        (q0, dq0, effects): ([f64; N], [f64; N], Effects<N>),
    ) -> Options<N> {
        let Self { duration, dt, method, control_period } = self;
        Options { duration, dt, method, control_period, q0, dq0, effects, ..Options::default() }
    }
}

/// Arguments of a simulation that are the same for any joint count, and the start that is not.
struct Settings<'a, 'py> {
    numerics: Numerics,
    record_every: usize,
    record: sim::Record,
    q0: Given<'a, 'py>,
    dq0: Given<'a, 'py>,
    effects: Given<'a, 'py>,
}

impl Settings<'_, '_> {
    fn options<const N: usize>(&self) -> PyResult<Options<N>> {
        let Self { numerics, record_every, record, q0, dq0, effects } = *self;
        let start =
            |value: Given<'_, '_>, name| value.map_or(Ok([0.0; N]), |value| joints(value, name));
        let (q0, dq0) = (start(q0, "q0")?, start(dq0, "dq0")?);
        let options = numerics.options((q0, dq0, PyEffects::of(effects)?));
        Ok(Options { record_every, record, ..options })
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
    let numerics = Numerics::of(duration, dt, method, control_period, [rtol, atol])?;
    let record_every = count(record_every, "record_every", 1)?;
    let records = [("all", sim::Record::All), ("motion", sim::Record::Motion)];
    let record = word(record, "record", records)?;
    let settings = Settings { numerics, record_every, record, q0, dq0, effects };
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
    as_the_tracker::<N>(joints)?;
    let Some(plant) = plant else { return Err(other_joints("plant", joints, N)) };
    let Tracker { controller, state, latest, .. } = tracker;
    *latest = None;
    let options = settings.options()?;
    controller.law.tell(options.control_period.unwrap_or(f64::NAN));
    let reference = Source::reference(reference, "reference")?;
    let run = py.detach(|| {
        let (system, law) = ((plant, &**controller, &reference), &controller.law);
        let guards = guards.and_then(Own::of_run);
        // Through a guard the run would go on.
        let mut look = |t| if law.has_raised() { ControlFlow::Break(()) } else { monitor.look(t) };
        sim::simulate_by(system, state, guards, &options, &mut look)
    });
    let mut run = run?;
    // All are asked: the plant outlives the run.
    let of_disturbance = plant.disturbance.as_ref().and_then(Source::raised);
    let of_law = controller.law.raised();
    let raised = match monitor.raised.or(reference.raised()).or(of_disturbance).or(of_law) {
        Some(error) if error.is_instance_of::<PyKeyboardInterrupt>(py) => {
            run.status = Status::Interrupted { t: ended(run.status, end(&run)) };
            None
        }
        other => other,
    };
    let (status, certificate, rows) =
        ((run.status, ended(run.status, end(&run))), run.certificate, run.t.len());
    let record = record(py, status, certificate, run.into_columns(), [rows, N])?;
    let (compensator, state) = (&controller.compensator, &state.compensator);
    let weights = compensator.weights(state).ok();
    record
        .set_item("weights", weights.map(|w| (w.len() / N, w)).map(|(n, w)| Array::rows(w, n)))?;
    record.set_item("dictionary", compensator.dictionary(py, state)?)?;
    Ok((record, raised))
}

/// Refuses a plant of another joint count than the tracker's `N`.
pub(super) fn as_the_tracker<const N: usize>(joints: usize) -> PyResult<()> {
    if joints == N {
        return Ok(());
    }
    let message = format!("plant: got one of {joints} joints, wants {N}, as the tracker has");
    Err(PyValueError::new_err(message))
}

/// Time of the last row \[s\].
fn end<const N: usize>(run: &Run<N>) -> f64 {
    run.t.last().copied().unwrap_or(0.0)
}

/// When a run ended \[s\]: at its `end`, or before.
pub(super) fn ended(status: Status, end: f64) -> f64 {
    match status {
        Status::Finished | Status::Unresolved(_) => end,
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
pub(super) fn status(status: Status, ended: f64) -> (&'static str, f64, String) {
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

/// The window of metrics from its arguments.
pub(super) fn window_of(window: Any<'_, '_>, band: Any<'_, '_>) -> PyResult<Window> {
    let given = numbers(window, "window")?;
    let [from, to] = given.values[..] else {
        return Err(wrong_shape("window", &given.shape, "(from, to)"));
    };
    let band = scalar(band, "band")?;
    positive("band", &[band])?;
    Ok(Window { from, to, band })
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
    let window = window_of(window, band)?;
    let Window { from, to, .. } = window;
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

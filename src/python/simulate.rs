//! `Plant` and the simulation call.

use core::ops::ControlFlow;
use std::sync::Arc;
use std::time::{Duration, Instant};

use pyo3::exceptions::{PyKeyboardInterrupt, PyRuntimeError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::arm::PyTwoLink;
use super::compensator::weights_of;
use super::convert::{
    Array1, array1, count, finite_scalar, finite_vector, joints, matrix_of, numbers, owned1,
    owned2, scalar, type_name, word, wrong_shape,
};
use super::dispatch::JOINTS;
use super::signals::{AnyDisturbance, AnyReference, Callback};
use super::tracker::PyComputedTorque;
use super::value_error;
use crate::arm::TwoLink;
use crate::error::{Error, finite, positive};
use crate::plant::Plant;
use crate::sim::{self, Method, Motion, Options, Run, Status, Tolerance, Window};

type Any<'a, 'py> = &'a Bound<'py, PyAny>;

/// Signals are looked for this often.
const CHECK_EVERY: Duration = Duration::from_millis(20);

/// What is really there: M q̈ + H + τ_d = τ (eq. 6), τ limited by the actuators.
///
/// arm: TwoLink. disturbance: τ_d [N·m], opposing τ: Sines, Quintic, Table, or a callable (q, dq, t) -> (2,).
/// effort_limit [N·m]: scalar or (2,); none by default.
#[pyclass(name = "Plant", module = "steadyarm", frozen)]
pub(super) struct PyPlant {
    plant: Plant<JOINTS, TwoLink, AnyDisturbance>,
    arguments: Py<PyAny>,
}

#[pymethods]
impl PyPlant {
    #[new]
    #[pyo3(signature = (arm, disturbance=None, effort_limit=None))]
    fn new(
        py: Python<'_>,
        arm: Any<'_, '_>,
        disturbance: Option<Any<'_, '_>>,
        effort_limit: Option<Any<'_, '_>>,
    ) -> PyResult<Self> {
        let given = (arm, disturbance);
        let arm = arm.cast::<PyTwoLink>().map_err(|_| {
            PyTypeError::new_err(format!("arm: got {}, wants a TwoLink", type_name(arm)))
        })?;
        let disturbance = disturbance.map_or(Ok(AnyDisturbance::NONE), AnyDisturbance::new)?;
        let mut plant = Plant::new(arm.get().arm, disturbance);
        if let Some(limit) = effort_limit {
            plant = plant.with_effort_limit(joints(limit, "effort_limit")?).map_err(value_error)?;
        }
        let arguments = (given.0, given.1, *plant.effort_limit());
        let arguments = arguments.into_pyobject(py)?.into_any().unbind();
        Ok(Self { plant, arguments })
    }

    /// The arm that is really there.
    #[getter]
    fn arm(&self, py: Python<'_>) -> PyResult<Py<PyTwoLink>> {
        Py::new(py, PyTwoLink { arm: self.plant.arm })
    }

    /// τ_d as it was given.
    #[getter]
    fn disturbance<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.arguments.bind(py).get_item(1)
    }

    /// Largest torque of each actuator [N·m], (2,); inf without a limit.
    #[getter]
    fn effort_limit<'py>(&self, py: Python<'py>) -> Array1<'py> {
        array1(py, self.plant.effort_limit())
    }

    /// Move on by dt [s] from time t [s] under the held torque tau [N·m] (one step of RK4): (q, dq) at t + dt.
    fn step<'py>(
        &self,
        py: Python<'py>,
        q: Any<'_, 'py>,
        dq: Any<'_, 'py>,
        tau: Any<'_, 'py>,
        t: Any<'_, 'py>,
        dt: Any<'_, 'py>,
    ) -> PyResult<(Array1<'py>, Array1<'py>)> {
        let motion = Motion { q: finite_vector(q, "q")?, dq: finite_vector(dq, "dq")? };
        let (tau, t) = (finite_vector(tau, "tau")?, finite_scalar(t, "t")?);
        let dt = scalar(dt, "dt")?;
        positive("dt", &[dt]).map_err(value_error)?;
        let next = sim::hold_torque(&self.plant, &motion, &tau, t, dt);
        if let Some(error) = self.plant.disturbance.callback().and_then(Callback::raised) {
            return Err(error);
        }
        let motion = [next.q.as_slice(), next.dq.as_slice()].concat();
        finite("disturbance, tau or dt: next motion", &motion).map_err(value_error)?;
        Ok((array1(py, next.q.as_slice()), array1(py, next.dq.as_slice())))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> (Bound<'py, PyAny>, Py<PyAny>) {
        (slf.get_type().into_any(), slf.get().arguments.clone_ref(slf.py()))
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let arguments = self.arguments.bind(py);
        let (arm, disturbance) = (arguments.get_item(0)?, arguments.get_item(1)?);
        Ok(format!("Plant({}, disturbance={})", arm.repr()?, disturbance.repr()?))
    }
}

/// Looks for Ctrl-C and shows progress, now and then.
struct Monitor {
    checked: Instant,
    progress: Option<Py<PyAny>>,
    raised: Option<PyErr>,
}

impl Monitor {
    fn look(&mut self, t: f64) -> ControlFlow<()> {
        if self.checked.elapsed() < CHECK_EVERY {
            return ControlFlow::Continue(());
        }
        self.checked = Instant::now();
        let result = Python::attach(|py| {
            if let Some(progress) = &self.progress {
                progress.call1(py, (t,))?;
            }
            py.check_signals()
        });
        match result {
            Ok(()) => ControlFlow::Continue(()),
            Err(error) => {
                self.raised = Some(error);
                ControlFlow::Break(())
            }
        }
    }
}

/// Simulates from the tracker's state, which stays as it is. Returns the record as a dict, and what a callback raised.
#[pyfunction]
#[pyo3(signature = (plant, tracker, reference, duration, dt, method, control_period, q0, dq0, rtol, atol,
    record_every, progress))]
#[expect(clippy::too_many_arguments, reason = "called by keyword from one Python function")]
pub(super) fn simulate<'py>(
    py: Python<'py>,
    plant: Any<'_, 'py>,
    tracker: Any<'_, 'py>,
    reference: Any<'_, 'py>,
    duration: Any<'_, 'py>,
    dt: Any<'_, 'py>,
    method: Any<'_, 'py>,
    control_period: Option<Any<'_, 'py>>,
    q0: Option<Any<'_, 'py>>,
    dq0: Option<Any<'_, 'py>>,
    rtol: Any<'_, 'py>,
    atol: Any<'_, 'py>,
    record_every: Any<'_, 'py>,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Bound<'py, PyDict>, Option<PyErr>)> {
    let tolerance = Tolerance { rtol: scalar(rtol, "rtol")?, atol: scalar(atol, "atol")? };
    let method = match word(method, "method", ["rk4", "dp54"])? {
        "rk4" => Method::Rk4,
        _ => Method::Dp54(tolerance),
    };
    let (duration, dt) = (scalar(duration, "duration")?, scalar(dt, "dt")?);
    let control_period =
        control_period.map(|period| scalar(period, "control_period")).transpose()?;
    let record_every = count(record_every, "record_every")?;
    let start =
        |value: Option<Any<'_, '_>>, name| value.map_or(Ok([0.0; JOINTS]), |v| joints(v, name));
    let (q0, dq0) = (start(q0, "q0")?, start(dq0, "dq0")?);
    let options = Options { duration, dt, method, control_period, q0, dq0, record_every };
    let plant = plant.cast::<PyPlant>().map_err(|_| {
        PyTypeError::new_err(format!("plant: got {}, wants a Plant", type_name(plant)))
    })?;
    let plant = &plant.get().plant;
    let tracker = tracker.cast::<PyComputedTorque>().map_err(|_| {
        PyTypeError::new_err(format!("tracker: got {}, wants a ComputedTorque", type_name(tracker)))
    })?;
    let reference = AnyReference::new(reference)?;
    let (controller, mut state) = {
        let tracker = tracker.try_borrow().map_err(|_| {
            PyRuntimeError::new_err("tracker: it is in the middle of a step, wants one that is not")
        })?;
        (Arc::clone(&tracker.controller), tracker.state.clone())
    };
    let mut monitor = Monitor { checked: Instant::now(), progress, raised: None };
    let run = py.detach(|| {
        sim::simulate(plant, &*controller, &mut state, &reference, &options, |t| monitor.look(t))
    });
    let mut run = run.map_err(value_error)?;
    let callbacks = [reference.callback(), plant.disturbance.callback()];
    let raised =
        monitor.raised.or_else(|| callbacks.into_iter().flatten().find_map(Callback::raised));
    let raised = match raised {
        Some(error) if error.is_instance_of::<PyKeyboardInterrupt>(py) => {
            run.status = Status::Interrupted { t: ended(&run) };
            None
        }
        other => other,
    };
    let weights = weights_of(py, &controller.compensator, &state.compensator)?;
    let record = record(py, run)?;
    record.set_item("weights", weights)?;
    Ok((record, raised))
}

fn ended(run: &Run<JOINTS>) -> f64 {
    match run.status {
        Status::Finished => run.t.last().copied().unwrap_or(0.0),
        Status::Interrupted { t } | Status::Diverged { t, .. } => t,
    }
}

fn record<'py>(py: Python<'py>, run: Run<JOINTS>) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    let (kind, reason) = match run.status {
        Status::Finished => ("finished", String::new()),
        Status::Interrupted { .. } => ("interrupted", "it was stopped from the keyboard".into()),
        Status::Diverged { cause, .. } => ("diverged", cause.to_string()),
    };
    dict.set_item("status", (kind, ended(&run), reason))?;
    if let Some(c) = run.certificate {
        let figures = PyDict::new(py);
        figures.set_item("residual", c.residual())?;
        figures.set_item("v_start", c.v_start)?;
        figures.set_item("v_end", c.v_end)?;
        figures.set_item("supplied", c.supplied)?;
        figures.set_item("state_cost", c.state_cost)?;
        figures.set_item("uncertainty", c.uncertainty)?;
        dict.set_item("certificate", figures)?;
    } else {
        dict.set_item("certificate", py.None())?;
    }
    dict.set_item("t", owned1(py, run.t))?;
    for (name, rows) in [
        ("q", run.q),
        ("dq", run.dq),
        ("q_d", run.q_d),
        ("dq_d", run.dq_d),
        ("ddq_d", run.ddq_d),
        ("e", run.e),
        ("de", run.de),
        ("tau", run.tau),
        ("tau_model", run.tau_model),
        ("tau_compensation", run.tau_compensation),
        ("rho", run.rho),
        ("rho_hat", run.rho_hat),
    ] {
        dict.set_item(name, owned2(py, rows.into_flattened(), JOINTS)?)?;
    }
    for (name, values) in [("weights_norm", run.weights_norm), ("V", run.v)] {
        let values = if values.is_empty() { None } else { Some(owned1(py, values)) };
        dict.set_item(name, values)?;
    }
    Ok(dict)
}

/// The figures of every joint over a window, as a dict of lists.
#[pyfunction]
pub(super) fn metrics<'py>(
    py: Python<'py>,
    t: Any<'_, 'py>,
    e: Any<'_, 'py>,
    tau: Any<'_, 'py>,
    window: Any<'_, 'py>,
    band: Any<'_, 'py>,
) -> PyResult<Bound<'py, PyDict>> {
    let numbers_of_window = numbers(window, "window")?;
    let [from, to] = numbers_of_window.values[..] else {
        return Err(wrong_shape("window", &numbers_of_window.shape, "(from, to)"));
    };
    let band = scalar(band, "band")?;
    positive("band", &[band]).map_err(value_error)?;
    let t = numbers(t, "t")?.values;
    let rows = |value, name| matrix_of(value, name, t.len(), JOINTS);
    let (e, tau) = (rows(e, "e")?, rows(tau, "tau")?);
    let recorded = t.first().zip(t.last()).filter(|&(first, last)| from <= *last && to >= *first);
    if recorded.is_none() || from > to || from.is_nan() || to.is_nan() {
        return Err(no_sample(from, to, &t));
    }
    let (e, tau) = (e.as_chunks::<JOINTS>().0, tau.as_chunks::<JOINTS>().0);
    let window = Window { from, to, band };
    let joints = (0..JOINTS)
        .map(|n| sim::metrics(n, &t, e, tau, window))
        .collect::<Result<Vec<_>, Error>>()
        .map_err(|_| no_sample(from, to, &t))?;
    let dict = PyDict::new(py);
    let set = |name, value: fn(&sim::Metrics) -> f64| {
        let values: Vec<f64> = joints.iter().map(value).collect();
        dict.set_item(name, owned1(py, values))
    };
    set("rms_e", |m| m.rms_e)?;
    set("max_abs_e", |m| m.max_abs_e)?;
    set("itae", |m| m.itae)?;
    set("settling_time", |m| m.settling_time)?;
    set("rms_tau", |m| m.rms_tau)?;
    set("max_abs_tau", |m| m.max_abs_tau)?;
    set("torque_variation", |m| m.torque_variation)?;
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

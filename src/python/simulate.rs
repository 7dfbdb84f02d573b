//! `Plant` and the simulation call.

use core::ops::ControlFlow;
use std::time::{Duration, Instant};

use pyo3::exceptions::{PyKeyboardInterrupt, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::arm::PyTwoLink;
use super::convert::{
    Array1, array1, joints, matrix_of, numbers, owned1, owned2, type_name, vector,
};
use super::dispatch::JOINTS;
use super::signals::{AnyDisturbance, AnyReference, Callback};
use super::tracker::PyComputedTorque;
use super::value_error;
use crate::arm::TwoLink;
use crate::plant::Plant;
use crate::sim::{self, Method, Motion, Options, Run, Status, Tolerance, Window};

type Any<'a, 'py> = &'a Bound<'py, PyAny>;

/// Signals are looked for this often.
const CHECK_EVERY: Duration = Duration::from_millis(20);

/// The true arm with its disturbance.
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
        let arguments = (arm, disturbance, effort_limit).into_pyobject(py)?.into_any().unbind();
        let arm = arm.cast::<PyTwoLink>().map_err(|_| {
            PyTypeError::new_err(format!("arm: got {}, wants a TwoLink", type_name(arm)))
        })?;
        let disturbance = disturbance.map_or(Ok(AnyDisturbance::None), AnyDisturbance::new)?;
        let mut plant = Plant::new(arm.get().arm, disturbance);
        if let Some(limit) = effort_limit {
            plant = plant.with_effort_limit(joints(limit, "effort_limit")?).map_err(value_error)?;
        }
        Ok(Self { plant, arguments })
    }

    #[getter]
    fn arm(&self, py: Python<'_>) -> PyResult<Py<PyTwoLink>> {
        Py::new(py, PyTwoLink { arm: self.plant.arm })
    }

    #[getter]
    fn disturbance<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.arguments.bind(py).get_item(1)
    }

    #[getter]
    fn effort_limit<'py>(&self, py: Python<'py>) -> Array1<'py> {
        array1(py, self.plant.effort_limit())
    }

    fn step<'py>(
        &self,
        py: Python<'py>,
        q: Any<'_, 'py>,
        dq: Any<'_, 'py>,
        tau: Any<'_, 'py>,
        t: f64,
        dt: f64,
    ) -> PyResult<(Array1<'py>, Array1<'py>)> {
        let motion = Motion { q: vector(q, "q")?, dq: vector(dq, "dq")? };
        let next = sim::hold_torque(&self.plant, &motion, &vector(tau, "tau")?, t, dt);
        if let Some(error) = self.plant.disturbance.callback().and_then(Callback::raised) {
            return Err(error);
        }
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
    duration: f64,
    dt: f64,
    method: &str,
    control_period: Option<f64>,
    q0: Option<Any<'_, 'py>>,
    dq0: Option<Any<'_, 'py>>,
    rtol: f64,
    atol: f64,
    record_every: usize,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Bound<'py, PyDict>, Option<PyErr>)> {
    let method = match method {
        "rk4" => Method::Rk4,
        "dp54" => Method::Dp54(Tolerance { rtol, atol }),
        _ => {
            let message = format!("method: got {method:?}, wants \"rk4\" or \"dp54\"");
            return Err(PyValueError::new_err(message));
        }
    };
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
    let tracker = tracker.borrow();
    let reference = AnyReference::new(reference)?;
    let mut state = tracker.state.clone();
    let controller = &tracker.controller;
    let mut monitor = Monitor { checked: Instant::now(), progress, raised: None };
    let run = py.detach(|| {
        sim::simulate(plant, controller, &mut state, &reference, &options, |t| monitor.look(t))
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
    let weights = tracker.weights_of(py, &state.compensator)?;
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
    window: (f64, f64),
    band: f64,
) -> PyResult<Bound<'py, PyDict>> {
    let t = numbers(t, "t")?.values;
    let rows = |value, name| matrix_of(value, name, t.len(), JOINTS);
    let (e, tau) = (rows(e, "e")?, rows(tau, "tau")?);
    let (e, tau) = (e.as_chunks::<JOINTS>().0, tau.as_chunks::<JOINTS>().0);
    let window = Window { from: window.0, to: window.1, band };
    let joints = (0..JOINTS)
        .map(|n| sim::metrics(n, &t, e, tau, window))
        .collect::<Result<Vec<_>, _>>()
        .map_err(value_error)?;
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

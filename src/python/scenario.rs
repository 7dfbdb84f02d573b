//! Settings as Python objects: those of the paper, and those of a file.

use pyo3::IntoPyObjectExt;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use pythonize::pythonize;

use super::curves::PyCurve;
use super::disturbances::PyDisturbance;
use super::effects::PyEffects;
use super::form::Fields;
use super::fuzzy::PyFuzzyCompensator;
use super::two_link::PyTwoLink;
use crate::paper;
use crate::scenario::{PushSettings, Scenario};

/// Return a simulation of the paper, "printed" or "claimed", as TOML.
#[pyfunction]
pub(super) fn paper_scenario(number: usize, preset: &str) -> PyResult<String> {
    let reading = if preset == "claimed" { paper::CLAIMED } else { paper::PRINTED };
    let mut scenario = Scenario::paper(reading)?;
    if number < 3 {
        scenario.compensator = None;
    }
    if number == 1 {
        (scenario.plant, scenario.disturbance) = (None, None);
    }
    Ok(scenario.to_toml()?)
}

/// Return a scenario in TOML as TOML with every default written out: what it says, to the bit.
///
/// Raises ValueError as `read_scenario`.
#[pyfunction]
pub(super) fn canonical_scenario(text: &str) -> PyResult<String> {
    Ok(Scenario::from_toml(text)?.to_toml()?)
}

/// Read a scenario in TOML: objects by section, None for a section that it does not have.
///
/// ``two_link`` (the arm that the controller believes in) and ``plant`` give a `TwoLink`,
/// ``compensator`` with its ``compensator.basis`` a `FuzzyCompensator`; ``reference.sines``,
/// ``reference.quintic``, ``reference.table`` or ``reference.waypoints`` that class under
/// "reference", and ``transfer`` likewise; ``disturbance`` these and `Pulses`, `Noise`, `Wrench`,
/// one or a list of them; ``effects`` an `Effects`; ``controller`` a dict of ``kp``, ``kv``,
/// ``effort_limit``, ``effort_rate_limit``, and ``run`` one of arguments of `simulate`; ``title``,
/// ``robot``, ``actual``, ``front``, ``metrics`` and ``controllers`` (laws by name) are as in the
/// file, see `Scenario`. Keys are the arguments of the classes. Raises ValueError naming the path
/// of what is unknown, of the wrong type or out of range:
/// ``compensator.gain[1]: got -1, wants a number > 0``.
#[pyfunction]
pub(super) fn read_scenario<'py>(py: Python<'py>, text: &str) -> PyResult<Bound<'py, PyDict>> {
    let Scenario {
        title,
        robot,
        two_link,
        plant,
        controller,
        compensator,
        reference,
        transfer,
        disturbance,
        run,
        actual,
        effects,
        front,
        metrics,
        controllers,
    } = Scenario::from_toml(text)?;
    let sections = PyDict::new(py);
    sections.set_item("title", title)?;
    sections.set_item("robot", pythonize(py, &robot)?)?;
    let mut actual = actual;
    let other = actual.as_mut().and_then(|actual| actual.two_link.take());
    let actual = pythonize(py, &actual)?;
    if let Some(arm) = other {
        actual.set_item("two_link", PyTwoLink::made(arm)?)?;
    }
    sections.set_item("actual", actual)?;
    sections.set_item("front", pythonize(py, &front)?)?;
    sections.set_item("metrics", pythonize(py, &metrics)?)?;
    sections.set_item("controllers", pythonize(py, &controllers)?)?;
    sections.set_item("effects", effects.map(PyEffects::made).transpose()?)?;
    let set = |name, path: &str, object: Option<PyResult<Bound<'_, PyAny>>>| {
        let named = |error: PyErr| PyValueError::new_err(format!("{path}.{}", error.value(py)));
        sections.set_item(name, object.transpose().map_err(named)?)
    };
    for (name, arm) in [("two_link", two_link), ("plant", plant)] {
        set(name, name, arm.map(|arm| PyTwoLink::made(arm)?.into_bound_py_any(py)))?;
    }
    set("controller", "controller", controller.map(|it| Ok(it.fields(py)?.into_any())))?;
    let object = compensator.map(|it| PyFuzzyCompensator::made(it)?.into_bound_py_any(py));
    set("compensator", "compensator", object)?;
    for (name, motion) in [("reference", reference), ("transfer", transfer)] {
        let path = motion.as_ref().map_or("", |motion| motion.name());
        set(name, &format!("{name}.{path}"), motion.map(|it| PyCurve::object(py, &it)))?;
    }
    set("disturbance", "disturbance", disturbance.map(|it| pushes(py, &it.0)))?;
    set("run", "run", run.map(|it| Ok(it.fields(py)?.into_any())))?;
    Ok(sections)
}

/// One disturbance as its object, several as a list.
fn pushes<'py>(py: Python<'py>, list: &[PushSettings]) -> PyResult<Bound<'py, PyAny>> {
    let object = |push: &PushSettings| {
        let named =
            |error: PyErr| PyValueError::new_err(format!("{}.{}", push.name(), error.value(py)));
        PyDisturbance::object(py, push).map_err(named)
    };
    match list {
        [one] => object(one),
        list => list.iter().map(object).collect::<PyResult<Vec<_>>>()?.into_bound_py_any(py),
    }
}

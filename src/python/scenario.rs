//! Settings as Python objects: those of the paper, and those of a file.

use pyo3::IntoPyObjectExt;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::form::Fields;
use super::fuzzy::PyFuzzyCompensator;
use super::signals::PyMotion;
use super::two_link::PyTwoLink;
use crate::paper;
use crate::scenario::Scenario;

/// Return the paper's third simulation in each reading, as `read_scenario` does.
#[pyfunction]
pub(super) fn paper_settings(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let readings = PyDict::new(py);
    for (name, reading) in [("printed", paper::PRINTED), ("claimed", paper::CLAIMED)] {
        readings.set_item(name, sections(py, Scenario::paper(reading)?)?)?;
    }
    Ok(readings)
}

/// Read a scenario in TOML: objects by section, None for a section that it does not have.
///
/// ``two_link`` (the arm that the controller believes in) and ``plant`` give a `TwoLink`,
/// ``compensator`` with its ``compensator.basis`` a `FuzzyCompensator`; ``reference.sines``,
/// ``reference.quintic`` or ``reference.table`` that class under "reference", and ``disturbance``
/// likewise; ``controller`` a dict of ``kp``, ``kv``, ``effort_limit``, ``effort_rate_limit``.
/// Keys are the arguments of the classes. Raises ValueError naming the path of what is unknown, of
/// the wrong type or out of range: ``compensator.gain[1]: got -1, wants a number > 0``.
#[pyfunction]
pub(super) fn read_scenario<'py>(py: Python<'py>, text: &str) -> PyResult<Bound<'py, PyDict>> {
    sections(py, Scenario::from_toml(text)?)
}

fn sections(py: Python<'_>, scenario: Scenario) -> PyResult<Bound<'_, PyDict>> {
    let Scenario { two_link, plant, controller, compensator, reference, disturbance } = scenario;
    let sections = PyDict::new(py);
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
    for (name, motion) in [("reference", reference), ("disturbance", disturbance)] {
        let path = motion.as_ref().map_or("", |motion| motion.name());
        set(name, &format!("{name}.{path}"), motion.map(|it| PyMotion::object(py, &it)))?;
    }
    Ok(sections)
}

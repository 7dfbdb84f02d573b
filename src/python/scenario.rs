//! Settings as Python objects: those of the paper, and those of a file.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::basis::PyFuzzyBasis;
use super::errors::{read_error, value_error};
use super::fuzzy::PyFuzzyCompensator;
use super::signals::{PyQuintic, PySines, PyTable};
use super::two_link::PyTwoLink;
use crate::paper;
use crate::scenario::{MotionSettings, Scenario};

/// Return a simulation of the paper, "printed" or "claimed", as TOML.
#[pyfunction]
pub(super) fn paper_scenario(number: usize, preset: &str) -> PyResult<String> {
    let reading = if preset == "claimed" { paper::CLAIMED } else { paper::PRINTED };
    let mut scenario = Scenario::paper(reading).map_err(value_error)?;
    if number < 3 {
        scenario.compensator = None;
    }
    if number == 1 {
        (scenario.plant, scenario.disturbance) = (None, None);
    }
    scenario.to_toml().map_err(read_error)
}

/// Read a scenario in TOML: objects by section, None for a section that it does not have.
///
/// ``two_link`` (the arm that the controller believes in) and ``plant`` give a `TwoLink`,
/// ``compensator`` with its ``compensator.basis`` a `FuzzyCompensator`; ``reference.sines``,
/// ``reference.quintic`` or ``reference.table`` that class under "reference", and ``disturbance``
/// likewise; ``controller`` a dict of ``kp``, ``kv``, ``effort_limit``, ``effort_rate_limit``, and
/// ``run`` one of arguments of `simulate`. Keys are the arguments of the classes. Raises ValueError
/// naming the path of what is unknown, of the wrong type or out of range:
/// ``compensator.gain[1]: got -1, wants a number > 0``.
#[pyfunction]
pub(super) fn read_scenario<'py>(py: Python<'py>, text: &str) -> PyResult<Bound<'py, PyDict>> {
    let scenario = Scenario::from_toml(text).map_err(read_error)?;
    let sections = (&scenario).into_pyobject(py)?;
    let class_of = |motion: &Option<MotionSettings>| match motion {
        Some(MotionSettings::Table(_)) => (".table", py.get_type::<PyTable>()),
        Some(MotionSettings::Quintic(_)) => (".quintic", py.get_type::<PyQuintic>()),
        Some(MotionSettings::Sines(_)) | None => (".sines", py.get_type::<PySines>()),
    };
    for (name, (below, class)) in [
        ("two_link", ("", py.get_type::<PyTwoLink>())),
        ("plant", ("", py.get_type::<PyTwoLink>())),
        ("compensator", ("", py.get_type::<PyFuzzyCompensator>())),
        ("reference", class_of(&scenario.reference)),
        ("disturbance", class_of(&scenario.disturbance)),
    ] {
        let Ok(arguments) = sections.as_any().get_item(name)?.cast_into::<PyDict>() else {
            continue;
        };
        if let Some(basis) = arguments.get_item("basis")? {
            let basis = py.get_type::<PyFuzzyBasis>().call((), Some(basis.cast()?))?;
            arguments.set_item("basis", basis)?;
        }
        let object = class
            .call((), Some(&arguments))
            .map_err(|error| PyValueError::new_err(format!("{name}{below}.{}", error.value(py))))?;
        sections.set_item(name, object)?;
    }
    Ok(sections)
}

//! The Python extension module `steadyarm._core`. Documentation for users stands in `_core.pyi` and
//! in the package.

mod any_arm;
mod arm;
mod basis;
mod compensator;
mod convert;
mod design;
mod dispatch;
mod form;
mod fuzzy;
mod limits;
mod monitor;
mod per_joint;
mod planted;
mod riccati;
mod saving;
mod scenario;
mod serial;
mod serial_arm;
mod serial_changes;
mod serial_files;
mod signals;
mod simulate;
mod sources;
mod tracked;
mod tracker;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::error::{Error, Problem};
use crate::robot::ReadError;

pyo3::create_exception!(
    steadyarm,
    NoStabilizingSolution,
    PyValueError,
    "The Riccati equation has no stabilising solution; attributes gamma, gamma_opt, max_scale."
);

/// Python places objects at multiples of 16 bytes: what wants more has to stand in a box.
const fn fits_python<T>() -> bool {
    align_of::<T>() <= 16
}

const _: () = {
    assert!(fits_python::<arm::PyTwoLink>() && fits_python::<serial::PySerial>());
    assert!(fits_python::<basis::PyFuzzyBasis>() && fits_python::<riccati::PySolution>());
    assert!(fits_python::<fuzzy::PyFuzzyApproximator>());
    assert!(fits_python::<fuzzy::PyFuzzyCompensator>());
    assert!(fits_python::<signals::PyMotion>() && fits_python::<simulate::PyPlant>());
    assert!(fits_python::<tracker::PyComputedTorque>());
};

/// The core's error as a Python exception.
fn value_error(error: Error) -> PyErr {
    let Problem::NoStabilizingSolution { gamma, gamma_opt, max_scale } = error.problem() else {
        return PyValueError::new_err(error.to_string());
    };
    Python::attach(|py| {
        let exception = NoStabilizingSolution::new_err(error.to_string());
        let value = exception.value(py);
        let figures = [("gamma", gamma), ("gamma_opt", gamma_opt), ("max_scale", max_scale)];
        match figures.iter().try_for_each(|(name, figure)| value.setattr(*name, *figure)) {
            Ok(()) => exception,
            Err(error) => error,
        }
    })
}

/// What is wrong with a robot description as a Python exception.
fn read_error(error: ReadError) -> PyErr {
    PyValueError::new_err(error.to_string())
}

#[pymodule]
#[pyo3(name = "_core")]
mod core_module {
    #[pymodule_export]
    const MAX_RECORD_BYTES: u64 = crate::sim::MAX_RECORD_BYTES;

    #[pymodule_export]
    use super::NoStabilizingSolution;
    #[pymodule_export]
    use super::arm::PyTwoLink;
    #[pymodule_export]
    use super::basis::PyFuzzyBasis;
    #[pymodule_export]
    use super::design::design;
    #[pymodule_export]
    use super::form::PyForm;
    #[pymodule_export]
    use super::fuzzy::{PyFuzzyApproximator, PyFuzzyCompensator};
    #[pymodule_export]
    use super::limits::PyExcess;
    #[pymodule_export]
    use super::riccati::{PySolution, bounded_real_riccati, care};
    #[pymodule_export]
    use super::scenario::{paper_settings, read_scenario};
    #[pymodule_export]
    use super::serial::PySerial;
    #[pymodule_export]
    use super::signals::{PyMotion, PyQuintic, PySines, PyTable};
    #[pymodule_export]
    use super::simulate::{PyPlant, channels, metrics, simulate};
    #[pymodule_export]
    use super::sources::desired_motion;
    #[pymodule_export]
    use super::tracker::PyComputedTorque;
}

//! Errors of the core as exceptions of Python.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::error::{Error, Problem};
use crate::robot::ReadError;

pyo3::create_exception!(
    steadyarm,
    NoStabilizingSolution,
    PyValueError,
    "The Riccati equation (19) has no stabilising solution.\n\n\
     There is one exactly when ``gamma > gamma_opt``, or, at this gamma, for Q times less than\n\
     ``max_scale``.\n\n\
     Attributes\n\
     ----------\n\
     gamma: γ that was asked for.\n\
     gamma_opt: the smallest γ with a solution for this Q; γ must be larger.\n\
     max_scale: at this γ, Q times anything smaller than this has a solution."
);

/// The core's error as a Python exception.
pub(super) fn value_error(error: Error) -> PyErr {
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

impl From<Error> for PyErr {
    fn from(error: Error) -> Self {
        value_error(error)
    }
}

impl From<ReadError> for PyErr {
    fn from(error: ReadError) -> Self {
        PyValueError::new_err(error.to_string())
    }
}

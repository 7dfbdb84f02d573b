//! A reference against an arm's limits, before it runs.

use core::cell::RefCell;
use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::form::{Fields, New, PyForm, fields};
use super::monitor::Monitor;
use super::sources::Source;
use crate::arm::Serial;
use crate::design::{Excess, check_limits};
use crate::math::Vector;
use crate::reference::{Reference, Setpoint};

/// A limit of a joint that a reference exceeds, where it does so most; of `Serial.check`.
#[pyclass(name = "Excess", module = "steadyarm", frozen, get_all, extends = PyForm)]
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PyExcess {
    /// Joint, from 0.
    joint: usize,
    /// Name of the joint.
    name: String,
    /// Which of its limits: "position", "velocity" or "effort".
    bound: String,
    /// The limit [rad, rad/s or N·m; m, m/s or N for a prismatic joint].
    limit: f64,
    /// What the reference asks for.
    value: f64,
    /// By how much that is too much, > 0.
    by: f64,
    /// When it asks for that [s].
    time: f64,
    /// When the limit is first exceeded [s].
    first: f64,
    /// All of that in words, as ``str`` gives it.
    message: String,
}

impl PyExcess {
    pub fn new(name: String, excess: Excess) -> New<Self> {
        let Excess { joint, bound, limit, value, time, first, .. } = excess;
        let (by, message) = (excess.by(), format!("joint {name:?}: {excess}"));
        let bound = bound.name().into();
        Self { joint, name, bound, limit, value, by, time, first, message }.made()
    }

    fn made(self) -> New<Self> {
        New(PyForm::under(Arc::new(self.clone()), self))
    }
}

fields! { PyExcess { joint, name, bound, limit, value, by, time, first, message } }

#[pymethods]
impl PyExcess {
    #[new]
    #[expect(clippy::too_many_arguments, reason = "a record")]
    fn from_fields(
        joint: usize,
        name: String,
        bound: String,
        limit: f64,
        value: f64,
        by: f64,
        time: f64,
        first: f64,
        message: String,
    ) -> PyClassInitializer<Self> {
        Self { joint, name, bound, limit, value, by, time, first, message }.made().0
    }

    fn __str__(&self) -> &str {
        &self.message
    }
}

/// A reference that can be stopped from the keyboard.
struct Watched<'a, const N: usize> {
    reference: &'a Source<N>,
    monitor: &'a RefCell<Monitor>,
}

impl<const N: usize> Reference<N> for Watched<'_, N> {
    fn at(&self, t: f64) -> Setpoint<N> {
        match self.monitor.borrow_mut().look(t).is_break() {
            true => Setpoint::at_rest(Vector::repeat(f64::NAN)),
            false => self.reference.at(t),
        }
    }
}

/// What a reference exceeds, looked at every dt up to the duration.
pub(super) fn check<const N: usize>(
    py: Python<'_>,
    arm: &Serial<N>,
    reference: &Bound<'_, PyAny>,
    [duration, dt]: [f64; 2],
) -> PyResult<Vec<Excess>> {
    let reference = Source::<N>::reference(reference, "reference")?;
    let (check, interrupted) = py.detach(|| {
        let monitor = RefCell::new(Monitor::new(None));
        let watched = Watched { reference: &reference, monitor: &monitor };
        let check = check_limits(arm, &watched, duration, dt);
        (check, monitor.into_inner().raised)
    });
    if let Some(error) = reference.raised().or(interrupted) {
        return Err(error);
    }
    Ok(check?.excesses().copied().collect())
}

//! References and disturbances of `N` joints: built-in signals, or any Python callable.

use std::sync::Mutex;

use pyo3::PyTraverseError;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::gc::PyVisit;
use pyo3::prelude::*;
use pyo3::types::{PyList, PyTuple};

use super::any_arm::{AnyArm, Arms};
use super::arm::PyArm;
use super::convert::{Any, Array, array1, matrix_of, numbers, type_name, vector};
use super::curves::PyCurve;
use super::dispatch::{each, same_joints};
use super::disturbances::PyDisturbance;
use crate::arm::Arm;
use crate::control::Sample;
use crate::math::Vector;
use crate::plant::Disturbance;
use crate::reference::{Reference, Setpoint};
use crate::scenario::{Curve, Push};

/// A Python function in a simulation. What it raises is kept, and the simulation sees NaN and ends.
pub(super) struct Callback {
    function: Py<PyAny>,
    raised: Mutex<Option<PyErr>>,
}

impl Callback {
    fn new(function: Any<'_, '_>, name: &str, call: &str) -> PyResult<Self> {
        if !function.is_callable() {
            let got = type_name(function);
            let message =
                format!("{name}: got {got}, wants Sines, Quintic, Table, Waypoints{call}");
            return Err(PyTypeError::new_err(message));
        }
        Ok(Self { function: function.clone().unbind(), raised: Mutex::new(None) })
    }

    fn raised(&self) -> Option<PyErr> {
        self.raised.lock().ok()?.take()
    }

    /// Calls the function, unless it raised before: the integrator's remaining stages ask once
    /// more.
    fn call<T>(&self, failed: T, body: impl FnOnce(&Bound<'_, PyAny>) -> PyResult<T>) -> T {
        if self.raised.lock().is_ok_and(|raised| raised.is_some()) {
            return failed;
        }
        Python::attach(|py| match body(self.function.bind(py)) {
            Ok(value) => value,
            Err(error) => {
                if let Ok(mut raised) = self.raised.lock() {
                    raised.get_or_insert(error);
                }
                failed
            }
        })
    }
}

/// A reference, or (as an `Option`) a disturbance: a motion, or any Python callable.
pub(super) enum Source<const N: usize> {
    Curve(Curve<N>),
    Callback(Callback),
    /// A disturbance only.
    Push(Push<N, AnyArm<N>>),
    /// A sum of disturbances.
    Sum(Vec<Self>),
}

impl<const N: usize> Source<N> {
    /// The argument of this name.
    pub fn reference(value: Any<'_, '_>, name: &str) -> PyResult<Self> {
        Self::new(value, name, " or a callable t -> (q_d, dq_d, ddq_d)")
    }

    /// What pushes this arm; `None` where nothing does.
    pub fn disturbance(value: Any<'_, '_>, arm: &AnyArm<N>) -> PyResult<Option<Self>> {
        if value.is_none() {
            return Ok(None);
        }
        if value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>() {
            let each = value.try_iter()?.map(|one| Self::push(&one?, arm));
            return Ok(Some(Self::Sum(each.collect::<PyResult<_>>()?)));
        }
        Self::push(value, arm).map(Some)
    }

    fn push(value: Any<'_, '_>, arm: &AnyArm<N>) -> PyResult<Self> {
        if let Ok(push) = value.cast::<PyDisturbance>() {
            let push = push.get();
            same_joints("disturbance", push.joints.unwrap_or(N), N)?;
            return push.push(arm).map(Self::Push);
        }
        let others = ", Pulses, Noise, Wrench or a callable (q, dq, t) -> tau_d, or a list of them";
        Self::new(value, "disturbance", others)
    }

    /// `name` and `call` are for the message to a user who gave something else.
    fn new(value: Any<'_, '_>, name: &str, call: &str) -> PyResult<Self> {
        let Ok(motion) = value.cast::<PyCurve>() else {
            return Ok(Self::Callback(Callback::new(value, name, call)?));
        };
        let motion = motion.get();
        same_joints(name, motion.joints.unwrap_or(N), N)?;
        motion.motion().map(Self::Curve)
    }

    /// Whether it is a callable, or has one in it.
    pub fn calls(&self) -> bool {
        match self {
            Self::Callback(_) => true,
            Self::Sum(list) => list.iter().any(Self::calls),
            Self::Curve(_) | Self::Push(_) => false,
        }
    }

    /// What the function raised, if it did; it is forgotten here.
    pub fn raised(&self) -> Option<PyErr> {
        match self {
            Self::Callback(callback) => callback.raised(),
            Self::Sum(list) => list.iter().find_map(Self::raised),
            Self::Curve(_) | Self::Push(_) => None,
        }
    }

    /// Shows the function to the garbage collector. It cannot be set anew, so some other object of
    /// a cycle can, and a class that holds this needs no `__clear__`.
    pub fn traverse(&self, visit: &PyVisit<'_>) -> Result<(), PyTraverseError> {
        match self {
            Self::Callback(callback) => visit.call(&callback.function),
            Self::Sum(list) => list.iter().try_for_each(|each| each.traverse(visit)),
            Self::Curve(_) | Self::Push(_) => Ok(()),
        }
    }
}

impl<const N: usize> Reference<N> for Source<N> {
    #[inline(always)]
    fn at(&self, t: f64) -> Setpoint<N> {
        match self {
            Self::Curve(motion) => motion.at(t),
            Self::Callback(callback) => callback
                .call(Setpoint::at_rest(Vector::repeat(f64::NAN)), |function| {
                    setpoint(&function.call1((t,))?)
                }),
            Self::Push(_) | Self::Sum(_) => Setpoint::at_rest(Vector::repeat(f64::NAN)),
        }
    }
}

fn setpoint<const N: usize>(value: &Bound<'_, PyAny>) -> PyResult<Setpoint<N>> {
    let wanted = "reference: wants (q_d, dq_d, ddq_d)";
    let length = value.len().map_err(|_| {
        PyTypeError::new_err(format!("{wanted}, got {} from the callable", type_name(value)))
    })?;
    if length != 3 {
        let message = format!("{wanted}, got {length} entries from the callable");
        return Err(PyTypeError::new_err(message));
    }
    Ok(Setpoint {
        q: vector(&value.get_item(0)?, "reference: q_d")?,
        dq: vector(&value.get_item(1)?, "reference: dq_d")?,
        ddq: vector(&value.get_item(2)?, "reference: ddq_d")?,
    })
}

/// Return [q_d, dq_d, ddq_d, e, de] at each of these times, (T, n) each.
///
/// e and de are those of a controller with this nominal arm that was at ``q``, ``dq``, (T, n) each.
/// Raises what a callable raises, and ValueError where it returns what is not finite.
#[pyfunction]
pub(super) fn desired_motion(
    py: Python<'_>,
    reference: Any<'_, '_>,
    arm: Any<'_, '_>,
    t: Any<'_, '_>,
    q: Any<'_, '_>,
    dq: Any<'_, '_>,
) -> PyResult<[Array<2>; 5]> {
    let PyArm { arms } = PyArm::of(arm)?;
    let joints = arms.joints();
    let t = numbers(t, "t")?.values;
    let q = matrix_of(q, "q", t.len(), joints)?;
    let dq = matrix_of(dq, "dq", t.len(), joints)?;
    each!(arms, Arms, arm => desired(py, reference, &**arm, &t, [&q, &dq]))
}

fn desired<const N: usize>(
    py: Python<'_>,
    reference: Any<'_, '_>,
    arm: &AnyArm<N>,
    t: &[f64],
    [q, dq]: [&[f64]; 2],
) -> PyResult<[Array<2>; 5]> {
    let (reference, wraps) = (Source::<N>::reference(reference, "reference")?, arm.wraps());
    let mut columns = [(); 5].map(|()| Vec::with_capacity(N * t.len()));
    py.detach(|| {
        for ((t, q), dq) in t.iter().zip(q.chunks_exact(N)).zip(dq.chunks_exact(N)) {
            let (q, dq) = (Vector::from_column_slice(q), Vector::from_column_slice(dq));
            let seen = Sample::wrapped(q, dq, reference.at(*t), &wraps);
            let Setpoint { q, dq, ddq } = seen.desired;
            for (column, row) in columns.iter_mut().zip([q, dq, ddq, seen.e, seen.de]) {
                column.extend(row.iter());
            }
        }
    });
    if let Some(error) = reference.raised() {
        return Err(error);
    }
    let lost = |column: &Vec<f64>| column.iter().position(|x| !x.is_finite());
    if let Some(place) = columns.iter().find_map(lost) {
        let time = t[place / N];
        let message = format!("reference: got no number at t = {time} s, wants finite ones");
        return Err(PyValueError::new_err(message));
    }
    Ok(columns.map(|column| Array::rows(column, N)))
}

impl<const N: usize> Disturbance<N> for Option<Source<N>> {
    fn is_same(&self, other: &Self) -> bool {
        match (self, other) {
            (None, None) => true,
            (Some(Source::Curve(one)), Some(Source::Curve(other))) => one.is_same(other),
            _ => false,
        }
    }

    #[inline]
    fn torque(&self, q: &Vector<N>, dq: &Vector<N>, t: f64) -> Vector<N> {
        self.as_ref().map_or_else(Vector::zeros, |source| source.torque(q, dq, t))
    }

    #[inline(always)]
    fn at_time(&self, t: f64) -> Option<Vector<N>> {
        self.as_ref().map_or_else(|| Some(Vector::zeros()), |source| source.at_time(t))
    }
}

impl<const N: usize> Disturbance<N> for Source<N> {
    #[inline]
    fn torque(&self, q: &Vector<N>, dq: &Vector<N>, t: f64) -> Vector<N> {
        match self {
            Self::Curve(motion) => motion.torque(q, dq, t),
            Self::Push(push) => push.torque(q, dq, t),
            Self::Sum(list) => list.torque(q, dq, t),
            Self::Callback(callback) => callback.call(Vector::repeat(f64::NAN), |function| {
                let py = function.py();
                let (q, dq) = (array1(py, q.as_slice()), array1(py, dq.as_slice()));
                vector(&function.call1((q, dq, t))?, "disturbance")
            }),
        }
    }

    #[inline(always)]
    fn at_time(&self, t: f64) -> Option<Vector<N>> {
        match self {
            Self::Curve(motion) => motion.at_time(t),
            Self::Push(push) => push.at_time(t),
            Self::Sum(list) => list.at_time(t),
            Self::Callback(_) => None,
        }
    }
}

//! References and disturbances: built-in signals, or any Python callable.

use std::sync::Mutex;

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;

use super::convert::{
    Array1, array1, finite_scalar, joints, matrix_of, numbers, renamed, scalar, type_name, vector,
    wrong_shape,
};
use super::dispatch::{JOINTS, JointVector};
use super::value_error;
use crate::plant::Disturbance;
use crate::reference::{Harmonic, Quintic, Reference, Setpoint, Sines, Table};

type Any<'a, 'py> = &'a Bound<'py, PyAny>;
type Amplitudes = Vec<[f64; JOINTS]>;
type Triple<'py> = (Array1<'py>, Array1<'py>, Array1<'py>);

/// offset + Σ sin_k sin(ω_k t) + cos_k cos(ω_k t) with exact derivatives: a reference [rad] or a disturbance [N·m].
///
/// frequency [rad/s]: (K,), with sin and cos (K, 2); or a scalar, with sin and cos scalar or (2,). offset: scalar or
/// (2,). Calling it with t [s] gives (q_d, dq_d, ddq_d).
#[pyclass(name = "Sines", module = "steadyarm", frozen)]
#[derive(Clone)]
pub(super) struct PySines {
    sines: Sines<JOINTS, Vec<Harmonic<JOINTS>>>,
    arguments: (Vec<f64>, Amplitudes, Amplitudes, [f64; JOINTS]),
}

#[pymethods]
impl PySines {
    #[new]
    #[pyo3(signature = (frequency, sin=None, cos=None, offset=None))]
    fn new(
        frequency: Any<'_, '_>,
        sin: Option<Any<'_, '_>>,
        cos: Option<Any<'_, '_>>,
        offset: Option<Any<'_, '_>>,
    ) -> PyResult<Self> {
        let frequencies = numbers(frequency, "frequency")?;
        if frequencies.shape.len() > 1 {
            return Err(wrong_shape("frequency", &frequencies.shape, "a scalar or (K,)"));
        }
        let count = frequencies.values.len();
        let amplitudes = |value: Option<Any<'_, '_>>, name| -> PyResult<Amplitudes> {
            let Some(value) = value else { return Ok(vec![[0.0; JOINTS]; count]) };
            if frequencies.shape.is_empty() {
                return Ok(vec![joints(value, name)?]);
            }
            Ok(matrix_of(value, name, count, JOINTS)?.as_chunks().0.to_vec())
        };
        let (sin, cos) = (amplitudes(sin, "sin")?, amplitudes(cos, "cos")?);
        let offset = offset.map_or(Ok([0.0; JOINTS]), |o| joints(o, "offset"))?;
        let harmonics = (0..count)
            .map(|k| Harmonic { frequency: frequencies.values[k], sin: sin[k], cos: cos[k] })
            .collect();
        let argument = |name: &'static str| name.strip_prefix("harmonics.").unwrap_or(name);
        let sines = Sines::new(offset, harmonics).map_err(|e| value_error(renamed(e, argument)))?;
        Ok(Self { sines, arguments: (frequencies.values, sin, cos, offset) })
    }

    fn __call__<'py>(&self, py: Python<'py>, t: Any<'_, 'py>) -> PyResult<Triple<'py>> {
        Ok(triple(py, &self.sines.at(finite_scalar(t, "t")?)))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let arguments = slf.get().arguments.clone().into_pyobject(slf.py())?;
        Ok((slf.get_type().into_any(), arguments.into_any()))
    }

    fn __repr__(&self) -> String {
        let (frequency, sin, cos, offset) = &self.arguments;
        format!("Sines(frequency={frequency:?}, sin={sin:?}, cos={cos:?}, offset={offset:?})")
    }
}

/// From start to goal [rad] along the quintic of least jerk, in `duration` [s] from `start_time` [s] on.
///
/// start, goal: scalar or (2,). It rests before and after. Calling it with t [s] gives (q_d, dq_d, ddq_d).
#[pyclass(name = "Quintic", module = "steadyarm", frozen)]
#[derive(Clone)]
pub(super) struct PyQuintic {
    quintic: Quintic<JOINTS>,
    arguments: ([f64; JOINTS], [f64; JOINTS], f64, f64),
}

#[pymethods]
impl PyQuintic {
    #[new]
    #[pyo3(signature = (start, goal, duration, start_time=None))]
    fn new(
        start: Any<'_, '_>,
        goal: Any<'_, '_>,
        duration: Any<'_, '_>,
        start_time: Option<Any<'_, '_>>,
    ) -> PyResult<Self> {
        let (start, goal) = (joints(start, "start")?, joints(goal, "goal")?);
        let duration = scalar(duration, "duration")?;
        let start_time = start_time.map_or(Ok(0.0), |t| scalar(t, "start_time"))?;
        let quintic = Quintic::new(start, goal, start_time, duration).map_err(value_error)?;
        Ok(Self { quintic, arguments: (start, goal, duration, start_time) })
    }

    fn __call__<'py>(&self, py: Python<'py>, t: Any<'_, 'py>) -> PyResult<Triple<'py>> {
        Ok(triple(py, &self.quintic.at(finite_scalar(t, "t")?)))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let arguments = slf.get().arguments.into_pyobject(slf.py())?;
        Ok((slf.get_type().into_any(), arguments.into_any()))
    }

    fn __repr__(&self) -> String {
        let (start, goal, duration, start_time) = self.arguments;
        format!(
            "Quintic(start={start:?}, goal={goal:?}, duration={duration}, start_time={start_time})"
        )
    }
}

/// A sampled motion, interpolated with continuous acceleration.
///
/// t (T,) [s], increasing; q (T, 2) [rad]; dq [rad/s] and ddq [rad/s²] (T, 2), both or neither: they then come from
/// q. It rests before and after. Calling it with t [s] gives (q_d, dq_d, ddq_d).
#[pyclass(name = "Table", module = "steadyarm", frozen)]
#[derive(Clone)]
pub(super) struct PyTable {
    table: Table<JOINTS, Vec<f64>>,
}

#[pymethods]
impl PyTable {
    #[new]
    #[pyo3(signature = (t, q, dq=None, ddq=None))]
    fn new(
        t: Any<'_, '_>,
        q: Any<'_, '_>,
        dq: Option<Any<'_, '_>>,
        ddq: Option<Any<'_, '_>>,
    ) -> PyResult<Self> {
        let times = numbers(t, "t")?;
        if times.shape.len() != 1 {
            return Err(wrong_shape("t", &times.shape, "(T,)"));
        }
        let rows = |value, name| matrix_of(value, name, times.values.len(), JOINTS);
        let q = rows(q, "q")?;
        let table = match (dq, ddq) {
            (None, None) => Table::from_positions(&times.values, &q),
            (Some(dq), Some(ddq)) => {
                Table::new(times.values.clone(), q, rows(dq, "dq")?, rows(ddq, "ddq")?)
            }
            _ => {
                let message =
                    "dq, ddq: got one of them, wants both or neither (then they come from q)";
                return Err(PyTypeError::new_err(message));
            }
        };
        Ok(Self { table: table.map_err(value_error)? })
    }

    fn __call__<'py>(&self, py: Python<'py>, t: Any<'_, 'py>) -> PyResult<Triple<'py>> {
        Ok(triple(py, &self.table.at(finite_scalar(t, "t")?)))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let [t, q, dq, ddq] = slf.get().table.columns();
        let pairs = |x: &[f64]| x.as_chunks::<JOINTS>().0.to_vec();
        let arguments = (t.to_vec(), pairs(q), pairs(dq), pairs(ddq)).into_pyobject(slf.py())?;
        Ok((slf.get_type().into_any(), arguments.into_any()))
    }

    fn __repr__(&self) -> String {
        format!("Table({} samples)", self.table.columns()[0].len())
    }
}

fn triple<'py>(py: Python<'py>, setpoint: &Setpoint<JOINTS>) -> Triple<'py> {
    let array = |x: &JointVector| array1(py, x.as_slice());
    (array(&setpoint.q), array(&setpoint.dq), array(&setpoint.ddq))
}

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
                format!("{name}: got {got}, wants Sines, Quintic, Table or a callable {call}");
            return Err(PyTypeError::new_err(message));
        }
        Ok(Self { function: function.clone().unbind(), raised: Mutex::new(None) })
    }

    /// What the function raised, if it did.
    pub fn raised(&self) -> Option<PyErr> {
        self.raised.lock().ok()?.take()
    }

    /// Calls the function, unless it raised before: the integrator's remaining stages ask once more.
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

/// What a reference or a disturbance is made from.
enum Source {
    Sines(Sines<JOINTS, Vec<Harmonic<JOINTS>>>),
    Quintic(Quintic<JOINTS>),
    Table(Table<JOINTS, Vec<f64>>),
    Callback(Callback),
}

impl Source {
    /// `name` and `call` are for the message to a user who gave something else.
    fn new(value: Any<'_, '_>, name: &str, call: &str) -> PyResult<Self> {
        if let Ok(sines) = value.cast::<PySines>() {
            Ok(Self::Sines(sines.get().sines.clone()))
        } else if let Ok(quintic) = value.cast::<PyQuintic>() {
            Ok(Self::Quintic(quintic.get().quintic))
        } else if let Ok(table) = value.cast::<PyTable>() {
            Ok(Self::Table(table.get().table.clone()))
        } else {
            Ok(Self::Callback(Callback::new(value, name, call)?))
        }
    }

    fn callback(&self) -> Option<&Callback> {
        if let Self::Callback(callback) = self { Some(callback) } else { None }
    }
}

/// Any reference.
pub(super) struct AnyReference(Source);

impl AnyReference {
    pub fn new(value: Any<'_, '_>) -> PyResult<Self> {
        Source::new(value, "reference", "t -> (q_d, dq_d, ddq_d)").map(Self)
    }

    pub fn callback(&self) -> Option<&Callback> {
        self.0.callback()
    }
}

impl Reference<JOINTS> for AnyReference {
    #[inline]
    fn at(&self, t: f64) -> Setpoint<JOINTS> {
        match &self.0 {
            Source::Sines(sines) => sines.at(t),
            Source::Quintic(quintic) => quintic.at(t),
            Source::Table(table) => table.at(t),
            Source::Callback(callback) => callback
                .call(Setpoint::at_rest(JointVector::repeat(f64::NAN)), |function| {
                    setpoint(&function.call1((t,))?)
                }),
        }
    }
}

fn setpoint(value: &Bound<'_, PyAny>) -> PyResult<Setpoint<JOINTS>> {
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

/// Any disturbance, or none.
pub(super) struct AnyDisturbance(Option<Source>);

impl AnyDisturbance {
    pub const NONE: Self = Self(None);

    pub fn new(value: Any<'_, '_>) -> PyResult<Self> {
        if value.is_none() {
            return Ok(Self::NONE);
        }
        Source::new(value, "disturbance", "(q, dq, t) -> tau_d").map(|source| Self(Some(source)))
    }

    pub fn callback(&self) -> Option<&Callback> {
        self.0.as_ref()?.callback()
    }
}

impl Disturbance<JOINTS> for AnyDisturbance {
    #[inline]
    fn torque(&self, q: &JointVector, dq: &JointVector, t: f64) -> JointVector {
        match &self.0 {
            None => JointVector::zeros(),
            Some(Source::Sines(sines)) => sines.value(t),
            Some(Source::Quintic(quintic)) => quintic.at(t).q,
            Some(Source::Table(table)) => table.at(t).q,
            Some(Source::Callback(callback)) => {
                callback.call(JointVector::repeat(f64::NAN), |function| {
                    let py = function.py();
                    let (q, dq) = (array1(py, q.as_slice()), array1(py, dq.as_slice()));
                    vector(&function.call1((q, dq, t))?, "disturbance")
                })
            }
        }
    }
}

//! `Sines`, `Quintic` and `Table`: motions and disturbances of any joint count.

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;

use super::convert::{
    Any, finite_scalar, matrix_of, numbers, renamed, scalar, scalar_or, wrong_shape,
};
use super::dispatch::{DEFAULT_JOINTS, MAX_JOINTS, for_joints};
use super::errors::value_error;
use super::motion::{Motion, Signal, Triple};
use super::per_joint::{PerJoint, common_joints};
use crate::reference::{Harmonic, Quintic, Sines, Table};

type Arguments<'py> = (Bound<'py, PyAny>, Bound<'py, PyAny>);

/// offset + Σ sin_k sin(ω_k t) + cos_k cos(ω_k t) with exact derivatives: a reference [rad] or a
/// disturbance [N·m].
///
/// frequency [rad/s]: (K,), with sin and cos (K, n); or a scalar, with sin and cos scalar or (n,).
/// offset: scalar or (n,). Calling it with t [s] gives (q_d, dq_d, ddq_d).
#[pyclass(name = "Sines", module = "steadyarm", frozen)]
pub(super) struct PySines {
    pub joints: Option<usize>,
    pub signal: Box<dyn Signal>,
    arguments: SinesArguments,
}

struct SinesArguments {
    /// (K,) or one.
    frequency: PerJoint,
    sin: Amplitudes,
    cos: Amplitudes,
    offset: PerJoint,
}

/// Amplitudes of K harmonics.
enum Amplitudes {
    /// The same for all: none, or those of a single frequency.
    Same(PerJoint),
    /// (K, n), row-major, and n.
    Rows(Vec<f64>, usize),
}

impl Amplitudes {
    fn new(value: Option<Any<'_, '_>>, name: &str, frequency: &PerJoint) -> PyResult<Self> {
        let Some(value) = value else { return Ok(Self::Same(PerJoint::All(0.0))) };
        let PerJoint::Each(frequencies) = frequency else {
            return Ok(Self::Same(PerJoint::new(value, name)?));
        };
        let shape = numbers(value, name)?.shape;
        match shape[..] {
            [rows, columns @ 1..=MAX_JOINTS] if rows == frequencies.len() => {
                Ok(Self::Rows(matrix_of(value, name, rows, columns)?, columns))
            }
            _ => {
                let rows = frequencies.len();
                Err(wrong_shape(
                    name,
                    &shape,
                    &format!("({rows}, n) with n from 1 to {MAX_JOINTS}"),
                ))
            }
        }
    }

    fn joints(&self) -> Option<usize> {
        match self {
            Self::Same(values) => values.len(),
            Self::Rows(_, joints) => Some(*joints),
        }
    }

    /// The values of a harmonic.
    fn row(&self, k: usize) -> PerJoint {
        match self {
            Self::Same(values) => values.clone(),
            Self::Rows(values, joints) => {
                PerJoint::Each(values[k * joints..(k + 1) * joints].to_vec())
            }
        }
    }

    fn to_python<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        match self {
            Self::Same(PerJoint::All(0.0)) => Ok(py.None().into_bound(py)),
            Self::Same(values) => values.to_python(py),
            Self::Rows(values, joints) => {
                let rows: Vec<Vec<f64>> = values.chunks_exact(*joints).map(Vec::from).collect();
                rows.into_pyobject(py)
            }
        }
    }
}

impl core::fmt::Debug for Amplitudes {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Same(values) => values.fmt(f),
            Self::Rows(values, joints) => {
                f.debug_list().entries(values.chunks_exact(*joints)).finish()
            }
        }
    }
}

fn sines<const N: usize>(arguments: &SinesArguments) -> PyResult<Motion<N>> {
    let SinesArguments { frequency, sin, cos, offset } = arguments;
    let harmonics = frequency.values(1).into_iter().enumerate().map(|(k, frequency)| {
        Ok(Harmonic { frequency, sin: sin.row(k).each("sin")?, cos: cos.row(k).each("cos")? })
    });
    let harmonics = harmonics.collect::<PyResult<Vec<_>>>()?;
    let argument = |name: &'static str| name.strip_prefix("harmonics.").unwrap_or(name);
    let sines = Sines::new(offset.each("offset")?, harmonics);
    sines.map(Motion::Sines).map_err(|error| value_error(renamed(error, argument)))
}

fn sines_signal<const N: usize>(arguments: &SinesArguments) -> PyResult<Box<dyn Signal>> {
    Ok(Box::new(sines::<N>(arguments)?))
}

impl PySines {
    /// For an arm.
    pub fn motion<const N: usize>(&self) -> PyResult<Motion<N>> {
        sines(&self.arguments)
    }
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
        let frequency = match frequencies.shape[..] {
            [] => PerJoint::All(frequencies.values[0]),
            [_] => PerJoint::Each(frequencies.values),
            _ => return Err(wrong_shape("frequency", &frequencies.shape, "a scalar or (K,)")),
        };
        let sin = Amplitudes::new(sin, "sin", &frequency)?;
        let cos = Amplitudes::new(cos, "cos", &frequency)?;
        let offset = PerJoint::or(offset, 0.0, "offset")?;
        let known = [("sin", sin.joints()), ("cos", cos.joints()), ("offset", offset.len())];
        let joints = common_joints(None, known)?;
        let arguments = SinesArguments { frequency, sin, cos, offset };
        let count = joints.unwrap_or(DEFAULT_JOINTS);
        Ok(Self { joints, signal: for_joints!(count, sines_signal(&arguments))?, arguments })
    }

    fn __call__<'py>(&self, py: Python<'py>, t: Any<'_, 'py>) -> PyResult<Triple<'py>> {
        Ok(self.signal.at_time(py, finite_scalar(t, "t")?))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Arguments<'py>> {
        let (py, SinesArguments { frequency, sin, cos, offset }) = (slf.py(), &slf.get().arguments);
        let (sin, cos) = (sin.to_python(py)?, cos.to_python(py)?);
        let arguments = (frequency.to_python(py)?, sin, cos, offset.to_python(py)?);
        Ok((slf.get_type().into_any(), arguments.into_pyobject(py)?.into_any()))
    }

    fn __repr__(&self) -> String {
        let SinesArguments { frequency, sin, cos, offset } = &self.arguments;
        format!("Sines(frequency={frequency:?}, sin={sin:?}, cos={cos:?}, offset={offset:?})")
    }
}

/// From start to goal [rad] along the quintic of least jerk, in `duration` [s] from `start_time`
/// [s] on.
///
/// start, goal: scalar or (n,). It rests before and after. Calling it with t [s] gives (q_d, dq_d,
/// ddq_d).
#[pyclass(name = "Quintic", module = "steadyarm", frozen)]
pub(super) struct PyQuintic {
    pub joints: Option<usize>,
    pub signal: Box<dyn Signal>,
    arguments: QuinticArguments,
}

struct QuinticArguments {
    start: PerJoint,
    goal: PerJoint,
    duration: f64,
    start_time: f64,
}

fn quintic<const N: usize>(arguments: &QuinticArguments) -> PyResult<Motion<N>> {
    let QuinticArguments { start, goal, duration, start_time } = arguments;
    let (start, goal) = (start.each("start")?, goal.each("goal")?);
    Quintic::new(start, goal, *start_time, *duration).map(Motion::Quintic).map_err(value_error)
}

fn quintic_signal<const N: usize>(arguments: &QuinticArguments) -> PyResult<Box<dyn Signal>> {
    Ok(Box::new(quintic::<N>(arguments)?))
}

impl PyQuintic {
    /// For an arm.
    pub fn motion<const N: usize>(&self) -> PyResult<Motion<N>> {
        quintic(&self.arguments)
    }
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
        let (start, goal) = (PerJoint::new(start, "start")?, PerJoint::new(goal, "goal")?);
        let joints = common_joints(None, [("start", start.len()), ("goal", goal.len())])?;
        let duration = scalar(duration, "duration")?;
        let start_time = scalar_or(start_time, 0.0, "start_time")?;
        let arguments = QuinticArguments { start, goal, duration, start_time };
        let count = joints.unwrap_or(DEFAULT_JOINTS);
        Ok(Self { joints, signal: for_joints!(count, quintic_signal(&arguments))?, arguments })
    }

    fn __call__<'py>(&self, py: Python<'py>, t: Any<'_, 'py>) -> PyResult<Triple<'py>> {
        Ok(self.signal.at_time(py, finite_scalar(t, "t")?))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Arguments<'py>> {
        let (py, arguments) = (slf.py(), &slf.get().arguments);
        let QuinticArguments { start, goal, duration, start_time } = arguments;
        let arguments = (start.to_python(py)?, goal.to_python(py)?, *duration, *start_time);
        Ok((slf.get_type().into_any(), arguments.into_pyobject(py)?.into_any()))
    }

    fn __repr__(&self) -> String {
        let QuinticArguments { start, goal, duration, start_time } = &self.arguments;
        format!(
            "Quintic(start={start:?}, goal={goal:?}, duration={duration}, start_time={start_time})"
        )
    }
}

/// A sampled motion, interpolated with continuous acceleration.
///
/// t (T,) [s], increasing; q (T, n) [rad]; dq [rad/s] and ddq [rad/s²] (T, n), both or neither:
/// they then come from q. It rests before and after. Calling it with t [s] gives (q_d, dq_d,
/// ddq_d).
#[pyclass(name = "Table", module = "steadyarm", frozen)]
pub(super) struct PyTable {
    pub joints: usize,
    pub signal: Box<dyn Signal>,
}

/// Columns of a table; q̇ and q̈ together, if at all.
struct Columns {
    t: Vec<f64>,
    q: Vec<f64>,
    rates: Option<[Vec<f64>; 2]>,
}

fn table_signal<const N: usize>(columns: Columns) -> PyResult<Box<dyn Signal>> {
    let table: Table<N, Vec<f64>> = match columns {
        Columns { t, q, rates: None } => Table::from_positions(&t, &q),
        Columns { t, q, rates: Some([dq, ddq]) } => Table::new(t, q, dq, ddq),
    }
    .map_err(value_error)?;
    Ok(Box::new(Motion::Table(table)))
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
        let (samples, shape) = (times.values.len(), numbers(q, "q")?.shape);
        let joints = match shape[..] {
            [rows, joints @ 1..=MAX_JOINTS] if rows == samples => joints,
            _ => {
                let wanted = format!("({samples}, n) with n from 1 to {MAX_JOINTS}");
                return Err(wrong_shape("q", &shape, &wanted));
            }
        };
        let rows = |value, name| matrix_of(value, name, samples, joints);
        let q = rows(q, "q")?;
        let rates = match (dq, ddq) {
            (None, None) => None,
            (Some(dq), Some(ddq)) => Some([rows(dq, "dq")?, rows(ddq, "ddq")?]),
            _ => {
                let message =
                    "dq, ddq: got one of them, wants both or neither (then they come from q)";
                return Err(PyTypeError::new_err(message));
            }
        };
        let columns = Columns { t: times.values, q, rates };
        Ok(Self { joints, signal: for_joints!(joints, table_signal(columns))? })
    }

    fn __call__<'py>(&self, py: Python<'py>, t: Any<'_, 'py>) -> PyResult<Triple<'py>> {
        Ok(self.signal.at_time(py, finite_scalar(t, "t")?))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Arguments<'py>> {
        let Self { joints, signal } = slf.get();
        let rows =
            |x: &[f64]| -> Vec<Vec<f64>> { x.chunks_exact(*joints).map(Vec::from).collect() };
        let arguments =
            signal.columns().map(|[t, q, dq, ddq]| (t.to_vec(), rows(q), rows(dq), rows(ddq)));
        Ok((slf.get_type().into_any(), arguments.into_pyobject(slf.py())?.into_any()))
    }

    fn __repr__(&self) -> String {
        format!("Table({} samples)", self.signal.columns().map_or(0, |columns| columns[0].len()))
    }
}

//! `Sines`, `Quintic`, `Table` and `Waypoints`: motions and disturbances of any joint count.

use std::sync::Arc;

use pyo3::IntoPyObjectExt;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;

use super::convert::{
    Any, Array, Given, Numbers, matrix, matrix_of, numbers, scalar, scalar_or, wrong_shape,
};
use super::dispatch::{DEFAULT_JOINTS, MAX_JOINTS, by_joints, each, for_joints, of_joints};
use super::errors::value_error;
use super::form::{New, PyForm};
use super::per_joint::{amplitudes, other_count, per_joint, rows};
use crate::error::finite;
use crate::reference::{Reference, Setpoint};
use crate::scenario::{
    Curve, CurveSettings, PerJoint, QuinticSettings, SinesSettings, TableSettings,
    WaypointsSettings,
};

by_joints! {
    /// A motion of any joint count.
    Curves of Curve
}

/// A desired motion, or a disturbance: `Sines`, `Quintic`, `Table` or `Waypoints`.
///
/// Call it with ``t`` [s]: it gives (q_d, dq_d, ddq_d), each (n,). With times of shape (T,) each is
/// (T, n).
#[pyclass(name = "Curve", module = "steadyarm", subclass, frozen, extends = PyForm)]
pub(super) struct PyCurve {
    /// `None`: any.
    pub joints: Option<usize>,
    motions: Curves,
    settings: Arc<CurveSettings>,
}

impl PyCurve {
    /// For an arm; what is one number counts for all its joints.
    pub fn motion<const N: usize>(&self) -> PyResult<Curve<N>> {
        let made = each!(&self.motions, Curves, motion => of_joints::<Curve<N>>(&**motion));
        made.map_or_else(|| self.settings.build().map_err(value_error), |made| Ok(made.clone()))
    }

    /// Its arguments.
    pub fn settings(&self) -> &CurveSettings {
        &self.settings
    }

    /// When it arrives at each of its poses [s], if it has some.
    fn arrivals(&self) -> Vec<f64> {
        each!(&self.motions, Curves, motion => match &**motion {
            Curve::Waypoints(path) => path.arrivals().collect(),
            _ => Vec::new(),
        })
    }

    /// The class of this motion, above it.
    fn under<T: pyo3::PyClass<BaseType = Self>>(
        settings: CurveSettings,
        class: T,
    ) -> PyResult<PyClassInitializer<T>> {
        let joints = settings.joints().map_err(other_count)?;
        let motions = for_joints!(joints.unwrap_or(DEFAULT_JOINTS), motions(&settings))?;
        let settings = Arc::new(settings);
        let motion = Self { joints, motions, settings: settings.clone() };
        Ok(PyForm::under(settings, motion).add_subclass(class))
    }

    /// The object of a motion.
    pub fn object<'py>(py: Python<'py>, motion: &CurveSettings) -> PyResult<Bound<'py, PyAny>> {
        let settings = motion.clone();
        match motion {
            CurveSettings::Sines(_) => New(Self::under(settings, PySines)?).into_bound_py_any(py),
            CurveSettings::Quintic(_) => {
                New(Self::under(settings, PyQuintic)?).into_bound_py_any(py)
            }
            CurveSettings::Table(_) => New(Self::under(settings, PyTable)?).into_bound_py_any(py),
            CurveSettings::Waypoints(_) => {
                New(Self::under(settings, PyWaypoints)?).into_bound_py_any(py)
            }
        }
    }
}

fn motions<const N: usize>(settings: &CurveSettings) -> PyResult<Curves>
where
    Curves: From<Curve<N>>,
{
    Ok(settings.build::<N>()?.into())
}

#[pymethods]
impl PyCurve {
    fn __call__<'py>(&self, py: Python<'py>, t: Any<'_, 'py>) -> PyResult<[Bound<'py, PyAny>; 3]> {
        let Numbers { shape, values } = numbers(t, "t")?;
        finite("t", &values)?;
        if shape.len() > 1 {
            return Err(wrong_shape("t", &shape, "a scalar or (T,)"));
        }
        let columns = each!(&self.motions, Curves, motion => columns(&**motion, &values));
        let [q, dq, ddq] = columns.map(|(values, joints)| match shape[..] {
            [] => Array::from(values).into_pyobject(py),
            _ => Array::rows(values, joints).into_pyobject(py),
        });
        Ok([q?, dq?, ddq?])
    }
}

/// q_d, q̇_d, q̈_d at these times, row-major, with the number of joints.
fn columns<const N: usize>(motion: &Curve<N>, times: &[f64]) -> [(Vec<f64>, usize); 3] {
    let mut columns = [(); 3].map(|()| (Vec::with_capacity(N * times.len()), N));
    for &t in times {
        let Setpoint { q, dq, ddq } = motion.at(t);
        for ((column, _), row) in columns.iter_mut().zip([q, dq, ddq]) {
            column.extend(row.iter());
        }
    }
    columns
}

/// ``offset + Σ sin_k sin(ω_k t) + cos_k cos(ω_k t)`` with its exact derivatives.
///
/// A reference in rad, or a disturbance in N·m. Call it with ``t`` [s], (T,) or a scalar: it gives
/// (q_d, dq_d, ddq_d), each (T, n) or (n,).
///
/// Parameters
/// ----------
/// frequency: ω [rad/s], (K,) or a scalar.
/// sin, cos: amplitudes, (K, n), or scalar or (n,) if ``frequency`` is a scalar; 0 by default.
/// offset: scalar or (n,); 0 by default.
/// start_time: when it starts [s], with t - start_time for t; None: it is there at all times.
///     Before, a reference stands still where it will begin, and a disturbance is zero.
#[pyclass(name = "Sines", module = "steadyarm", frozen, extends = PyCurve)]
pub(super) struct PySines;

#[pymethods]
impl PySines {
    #[new]
    #[pyo3(signature = (frequency, sin=None, cos=None, offset=None, start_time=None))]
    fn new(
        frequency: Any<'_, '_>,
        sin: Given<'_, '_>,
        cos: Given<'_, '_>,
        offset: Given<'_, '_>,
        start_time: Given<'_, '_>,
    ) -> PyResult<PyClassInitializer<Self>> {
        let frequencies = numbers(frequency, "frequency")?;
        let frequency = match frequencies.shape[..] {
            [] => PerJoint::All(frequencies.values[0]),
            [_] => PerJoint::Each(frequencies.values),
            _ => return Err(wrong_shape("frequency", &frequencies.shape, "a scalar or (K,)")),
        };
        let mut sines = SinesSettings::new(frequency);
        sines.start_time = start_time.map(|start| scalar(start, "start_time")).transpose()?;
        sines.sin = sin.map(|sin| amplitudes(sin, "sin", &sines.frequency)).transpose()?;
        sines.cos = cos.map(|cos| amplitudes(cos, "cos", &sines.frequency)).transpose()?;
        if let Some(offset) = offset {
            sines.offset = per_joint(offset, "offset")?;
        }
        if let (Some(0), Some(given)) = (sines.frequency.count(), sin.or(cos))
            && let [_, joints] = numbers(given, "sin")?.shape[..]
        {
            // Without rows, the constant part says how many joints there are.
            sines.offset = PerJoint::Each(sines.offset.values(joints));
        }
        PyCurve::under(CurveSettings::Sines(sines), Self)
    }
}

/// From ``start`` to ``goal`` [rad] along the quintic of least jerk; at rest before and after.
///
/// ``start``, ``goal``: scalar or (n,). ``duration`` [s] > 0, ``start_time`` [s], 0 by default.
/// Call it with ``t`` [s], (T,) or a scalar: it gives (q_d, dq_d, ddq_d), each (T, n) or (n,).
#[pyclass(name = "Quintic", module = "steadyarm", frozen, extends = PyCurve)]
pub(super) struct PyQuintic;

#[pymethods]
impl PyQuintic {
    #[new]
    #[pyo3(signature = (start, goal, duration, start_time=None))]
    fn new(
        start: Any<'_, '_>,
        goal: Any<'_, '_>,
        duration: Any<'_, '_>,
        start_time: Given<'_, '_>,
    ) -> PyResult<PyClassInitializer<Self>> {
        let (start, goal) = (per_joint(start, "start")?, per_joint(goal, "goal")?);
        let duration = scalar(duration, "duration")?;
        let start_time = scalar_or(start_time, 0.0, "start_time")?;
        let quintic = QuinticSettings { start, goal, duration, start_time };
        PyCurve::under(CurveSettings::Quintic(quintic), Self)
    }
}

/// A sampled motion, interpolated with continuous acceleration; at rest before and after.
///
/// Call it with ``t`` [s], (T,) or a scalar: it gives (q_d, dq_d, ddq_d), each (T, n) or (n,).
///
/// Parameters
/// ----------
/// t: times [s], (T,), increasing, at least two.
/// q: positions [rad], (T, n).
/// dq, ddq: velocities [rad/s] and accelerations [rad/s²], (T, n); both, or neither: they then come
///     from ``q``.
/// start_time: when it is at the first sample [s]; None: at t[0].
#[pyclass(name = "Table", module = "steadyarm", frozen, extends = PyCurve)]
pub(super) struct PyTable;

#[pymethods]
impl PyTable {
    #[new]
    #[pyo3(signature = (t, q, dq=None, ddq=None, start_time=None))]
    fn new(
        t: Any<'_, '_>,
        q: Any<'_, '_>,
        dq: Given<'_, '_>,
        ddq: Given<'_, '_>,
        start_time: Given<'_, '_>,
    ) -> PyResult<PyClassInitializer<Self>> {
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
        if dq.is_some() != ddq.is_some() {
            let message = "dq, ddq: got one of them, wants both or neither (then they come from q)";
            return Err(PyTypeError::new_err(message));
        }
        let samples_of = |value, name| -> PyResult<_> {
            Ok(rows(&matrix_of(value, name, samples, joints)?, joints))
        };
        let q = samples_of(q, "q")?;
        let dq = dq.map(|dq| samples_of(dq, "dq")).transpose()?;
        let ddq = ddq.map(|ddq| samples_of(ddq, "ddq")).transpose()?;
        let start_time = start_time.map(|start| scalar(start, "start_time")).transpose()?;
        let table = TableSettings { t: times.values, q, dq, ddq, start_time };
        PyCurve::under(CurveSettings::Table(table), Self)
    }

    /// Read a motion from a CSV file, such as `Run.to_csv` writes or a robot recorded.
    ///
    /// Its first line names the columns: t [s], q_1, q_2 … [rad] and, where there are both,
    /// dq_1 … [rad/s] and ddq_1 … [rad/s²]; ``desired`` reads q_d_1, dq_d_1, ddq_d_1 instead. Other
    /// columns are passed over. Raises OSError, and ValueError that names the line or the column.
    #[staticmethod]
    #[pyo3(
        signature = (path, desired=false, start_time=None),
        text_signature = "(path, desired=False, start_time=None)"
    )]
    fn from_csv<'py>(
        path: Any<'_, 'py>,
        desired: bool,
        start_time: Given<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = path.py();
        let columns = py.import("steadyarm._csv")?.call_method1("motion", (path, desired))?;
        let (t, q, dq, ddq): (Py<PyAny>, Py<PyAny>, Py<PyAny>, Py<PyAny>) = columns.extract()?;
        py.get_type::<Self>().call1((t, q, dq, ddq, start_time))
    }
}

/// From pose to pose as fast as velocity, acceleration and jerk may be, with pauses.
///
/// The joints start and arrive together, on a straight line from pose to pose, and come to rest at
/// every pose, for no longer than an instant without a pause; before and after they stand still. At
/// every moment of a move one joint is at one of its limits. Velocity and acceleration are
/// continuous. Call it with ``t`` [s], (T,) or a scalar: it gives (q_d, dq_d, ddq_d), each
/// (T, n) or (n,).
///
/// Parameters
/// ----------
/// poses: positions [rad], (K, n), at least two.
/// velocity, acceleration, jerk: limits [rad/s], [rad/s²], [rad/s³], scalar or (n,), > 0.
/// pause: how long it rests at the poses between the first and the last [s], scalar or (K - 2,).
/// start_time: when it leaves the first pose [s].
#[pyclass(name = "Waypoints", module = "steadyarm", frozen, extends = PyCurve)]
pub(super) struct PyWaypoints;

#[pymethods]
impl PyWaypoints {
    #[new]
    #[pyo3(
        signature = (poses, velocity, acceleration, jerk, pause=None, start_time=None),
        text_signature = "(poses, velocity, acceleration, jerk, pause=0.0, start_time=0.0)"
    )]
    fn new(
        poses: Any<'_, '_>,
        velocity: Any<'_, '_>,
        acceleration: Any<'_, '_>,
        jerk: Any<'_, '_>,
        pause: Given<'_, '_>,
        start_time: Given<'_, '_>,
    ) -> PyResult<PyClassInitializer<Self>> {
        let wanted = format!("(K, n) with n from 1 to {MAX_JOINTS}");
        let (_, joints, poses) = match matrix(poses, "poses", &wanted)? {
            (rows, joints @ 1..=MAX_JOINTS, values) => (rows, joints, values),
            (rows, columns, _) => return Err(wrong_shape("poses", &[rows, columns], &wanted)),
        };
        let pause = match pause.map(|pause| numbers(pause, "pause")).transpose()? {
            None => PerJoint::All(0.0),
            Some(Numbers { shape, values }) => match shape[..] {
                [] => PerJoint::All(values[0]),
                [_] => PerJoint::Each(values),
                _ => return Err(wrong_shape("pause", &shape, "a scalar or (K - 2,)")),
            },
        };
        let waypoints = WaypointsSettings {
            poses: rows(&poses, joints),
            velocity: per_joint(velocity, "velocity")?,
            acceleration: per_joint(acceleration, "acceleration")?,
            jerk: per_joint(jerk, "jerk")?,
            pause,
            start_time: scalar_or(start_time, 0.0, "start_time")?,
        };
        PyCurve::under(CurveSettings::Waypoints(waypoints), Self)
    }

    /// How long it takes from the first pose to the last, with its pauses [s].
    #[getter]
    fn duration(slf: PyRef<'_, Self>) -> f64 {
        let arrivals = slf.as_super().arrivals();
        arrivals.last().zip(arrivals.first()).map_or(0.0, |(end, start)| end - start)
    }

    /// When it arrives at each pose [s], (K,); at the first one that is ``start_time``.
    #[getter]
    fn arrivals(slf: PyRef<'_, Self>) -> Array<1> {
        slf.as_super().arrivals().into()
    }
}

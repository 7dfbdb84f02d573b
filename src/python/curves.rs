//! `Sines`, `Quintic` and `Table`: motions and disturbances of any joint count.

use std::sync::Arc;

use pyo3::IntoPyObjectExt;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;

use super::convert::{
    Any, Array, Given, finite_scalar, matrix_of, numbers, scalar, scalar_or, wrong_shape,
};
use super::dispatch::{DEFAULT_JOINTS, MAX_JOINTS, by_joints, each, for_joints, of_joints};
use super::errors::value_error;
use super::form::{New, PyForm};
use super::per_joint::{amplitudes, other_count, per_joint, rows};
use crate::reference::{Reference, Setpoint};
use crate::scenario::{
    Curve, CurveSettings, PerJoint, QuinticSettings, SinesSettings, TableSettings,
};

by_joints! {
    /// A motion of any joint count.
    Curves of Curve
}

/// A desired motion, or a disturbance: `Sines`, `Quintic` or `Table`.
///
/// Call it with ``t`` [s]: it gives (q_d, dq_d, ddq_d), each (n,).
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
    fn __call__(&self, t: Any<'_, '_>) -> PyResult<(Array<1>, Array<1>, Array<1>)> {
        each!(&self.motions, Curves, motion => {
            let Setpoint { q, dq, ddq } = motion.at(finite_scalar(t, "t")?);
            Ok((q.into(), dq.into(), ddq.into()))
        })
    }
}

/// ``offset + Σ sin_k sin(ω_k t) + cos_k cos(ω_k t)`` with its exact derivatives.
///
/// A reference in rad, or a disturbance in N·m. Call it with ``t`` [s]: it gives
/// (q_d, dq_d, ddq_d), each (n,).
///
/// Parameters
/// ----------
/// frequency: ω [rad/s], (K,) or a scalar.
/// sin, cos: amplitudes, (K, n), or scalar or (n,) if ``frequency`` is a scalar; 0 by default.
/// offset: scalar or (n,); 0 by default.
#[pyclass(name = "Sines", module = "steadyarm", frozen, extends = PyCurve)]
pub(super) struct PySines;

#[pymethods]
impl PySines {
    #[new]
    #[pyo3(signature = (frequency, sin=None, cos=None, offset=None))]
    fn new(
        frequency: Any<'_, '_>,
        sin: Given<'_, '_>,
        cos: Given<'_, '_>,
        offset: Given<'_, '_>,
    ) -> PyResult<PyClassInitializer<Self>> {
        let frequencies = numbers(frequency, "frequency")?;
        let frequency = match frequencies.shape[..] {
            [] => PerJoint::All(frequencies.values[0]),
            [_] => PerJoint::Each(frequencies.values),
            _ => return Err(wrong_shape("frequency", &frequencies.shape, "a scalar or (K,)")),
        };
        let mut sines = SinesSettings::new(frequency);
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
/// Call it with ``t`` [s]: it gives (q_d, dq_d, ddq_d), each (n,).
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
/// Call it with ``t`` [s]: it gives (q_d, dq_d, ddq_d), each (n,).
///
/// Parameters
/// ----------
/// t: times [s], (T,), increasing, at least two.
/// q: positions [rad], (T, n).
/// dq, ddq: velocities [rad/s] and accelerations [rad/s²], (T, n); both, or neither: they then come
///     from ``q``.
#[pyclass(name = "Table", module = "steadyarm", frozen, extends = PyCurve)]
pub(super) struct PyTable;

#[pymethods]
impl PyTable {
    #[new]
    #[pyo3(signature = (t, q, dq=None, ddq=None))]
    fn new(
        t: Any<'_, '_>,
        q: Any<'_, '_>,
        dq: Given<'_, '_>,
        ddq: Given<'_, '_>,
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
        let table = TableSettings { t: times.values, q, dq, ddq };
        PyCurve::under(CurveSettings::Table(table), Self)
    }
}

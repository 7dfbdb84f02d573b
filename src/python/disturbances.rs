//! `Pulses`, `Noise` and `Wrench`: disturbances of any joint count that are no curves.

use std::sync::Arc;

use pyo3::IntoPyObjectExt;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::any_arm::AnyArm;
use super::convert::{
    Any, Given, numbers, object, scalar, vector, whole, word, wrong_shape, wrong_type,
};
use super::curves::PyCurve;
use super::dispatch::for_joints;
use super::errors::value_error;
use super::form::{Fields, New, PyForm};
use super::per_joint::{amplitudes, other_count, per_joint};
use crate::scenario::{
    NoiseSettings, PerJoint, PulsesSettings, Push, PushSettings, ShapeName, WrenchSettings,
};

/// A disturbance that is no curve: `Pulses`, `Noise` or `Wrench`.
#[pyclass(name = "Disturbance", module = "steadyarm", subclass, frozen, extends = PyForm)]
pub(super) struct PyDisturbance {
    /// `None`: any.
    pub joints: Option<usize>,
    settings: Arc<PushSettings>,
}

impl PyDisturbance {
    /// For an arm of `N` joints.
    pub fn push<const N: usize>(&self, arm: &AnyArm<N>) -> PyResult<Push<N, AnyArm<N>>> {
        self.settings.build(arm).map_err(value_error)
    }

    /// The class of these settings, above them.
    fn under<T: pyo3::PyClass<BaseType = Self>>(
        settings: PushSettings,
        class: T,
    ) -> PyResult<PyClassInitializer<T>> {
        let joints = settings.joints().map_err(other_count)?;
        // What is wrong whatever the arm is refused at once.
        if !matches!(settings, PushSettings::Wrench(_)) {
            for_joints!(joints.unwrap_or(1), checked(&settings))?;
        }
        let settings = Arc::new(settings);
        let made = Self { joints, settings: settings.clone() };
        Ok(PyForm::under(settings, made).add_subclass(class))
    }

    /// The object of a disturbance, or of a curve.
    pub fn object<'py>(py: Python<'py>, push: &PushSettings) -> PyResult<Bound<'py, PyAny>> {
        let push = push.clone();
        match &push {
            PushSettings::Pulses(_) => New(Self::under(push, PyPulses)?).into_bound_py_any(py),
            PushSettings::Noise(_) => New(Self::under(push, PyNoise)?).into_bound_py_any(py),
            PushSettings::Wrench(_) => New(Self::under(push, PyWrench)?).into_bound_py_any(py),
            curve => match curve.curve() {
                Some(curve) => PyCurve::object(py, &curve),
                None => Err(PyTypeError::new_err("disturbance: got no kind that is known")),
            },
        }
    }

    /// The settings of an object that is a curve or one of these.
    fn settings(value: Any<'_, '_>, name: &str) -> PyResult<PushSettings> {
        if let Ok(curve) = value.cast::<PyCurve>() {
            return Ok(curve.get().settings().clone().into());
        }
        let wanted = "a curve, Pulses or Noise";
        let it = object::<Self>(value, name, wanted)?;
        if matches!(*it.get().settings, PushSettings::Wrench(_)) {
            return Err(wrong_type(name, value, wanted));
        }
        Ok((*it.get().settings).clone())
    }
}

impl Fields for PushSettings {
    fn fields<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        match (self, self.curve()) {
            (Self::Pulses(pulses), _) => pulses.fields(py),
            (Self::Noise(noise), _) => noise.fields(py),
            (Self::Wrench(WrenchSettings { force, moment, curve }), _) => {
                let fields = PyDict::new(py);
                fields.set_item("force", force)?;
                fields.set_item("moment", moment)?;
                let curve = curve.as_ref().map(|curve| PyDisturbance::object(py, curve));
                fields.set_item("curve", curve.transpose()?)?;
                Ok(fields)
            }
            (_, Some(curve)) => curve.fields(py),
            (_, None) => Ok(PyDict::new(py)),
        }
    }
}

fn checked<const N: usize>(settings: &PushSettings) -> PyResult<()> {
    settings.signal::<N>().map(drop).map_err(value_error)
}

/// Steps and impulses: each torque from its time on, for as long as it lasts. A disturbance.
///
/// Parameters
/// ----------
/// time: when they begin [s], (K,) or a scalar.
/// torque: heights [N·m], which oppose τ: (K, n), or scalar or (n,) if ``time`` is a scalar.
/// duration: how long they last [s], (K,) or a scalar, > 0; inf or None for steps.
/// shape: "rectangle", or "half_sine" for one that rises and falls as sin(π s).
#[pyclass(name = "Pulses", module = "steadyarm", frozen, extends = PyDisturbance)]
pub(super) struct PyPulses;

#[pymethods]
impl PyPulses {
    #[new]
    #[pyo3(
        signature = (time, torque, duration=None, shape=None),
        text_signature = "(time, torque, duration=None, shape='rectangle')"
    )]
    fn new(
        time: Any<'_, '_>,
        torque: Any<'_, '_>,
        duration: Given<'_, '_>,
        shape: Given<'_, '_>,
    ) -> PyResult<PyClassInitializer<Self>> {
        let time = list(time, "time")?;
        let torque = amplitudes(torque, "torque", &time)?;
        let duration = duration.map_or(Ok(f64::INFINITY.into()), |it| list(it, "duration"))?;
        let shapes = [ShapeName::Rectangle, ShapeName::HalfSine].map(|shape| (shape.name(), shape));
        let shape = shape.map_or(Ok(ShapeName::Rectangle), |it| word(it, "shape", shapes))?;
        let pulses = PulsesSettings { time, torque, duration, shape };
        PyDisturbance::under(PushSettings::Pulses(pulses), Self)
    }
}

/// A number, or a list of them.
fn list(value: Any<'_, '_>, name: &str) -> PyResult<PerJoint> {
    let given = numbers(value, name)?;
    match given.shape[..] {
        [] => Ok(PerJoint::All(given.values[0])),
        [_] => Ok(PerJoint::Each(given.values)),
        _ => Err(wrong_shape(name, &given.shape, "a scalar or (K,)")),
    }
}

/// Coloured noise, a disturbance: white noise through a first-order low-pass.
///
/// It is Gaussian and stationary, with standard deviation ``deviation`` and correlation
/// ``exp(-2 π cutoff |Δt|)``; the joints are independent. It is a function of time: the same seed
/// gives the same bits in every run, with any step, on every machine.
///
/// Parameters
/// ----------
/// deviation: standard deviation [N·m], scalar or (n,), >= 0.
/// cutoff: cut-off of the filter [Hz], > 0.
/// seed: a whole number from 0 to 2^63 - 1.
#[pyclass(name = "Noise", module = "steadyarm", frozen, extends = PyDisturbance)]
pub(super) struct PyNoise;

#[pymethods]
impl PyNoise {
    #[new]
    #[pyo3(
        signature = (deviation, cutoff, seed=None),
        text_signature = "(deviation, cutoff, seed=0)"
    )]
    fn new(
        deviation: Any<'_, '_>,
        cutoff: Any<'_, '_>,
        seed: Given<'_, '_>,
    ) -> PyResult<PyClassInitializer<Self>> {
        let deviation = per_joint(deviation, "deviation")?;
        let cutoff = scalar(cutoff, "cutoff")?;
        let seed = seed.map_or(Ok(0), |seed| whole(seed, "seed"))?;
        let noise = NoiseSettings { deviation, cutoff, seed };
        PyDisturbance::under(PushSettings::Noise(noise), Self)
    }
}

/// A force and a moment on the tip, in the axes of the base. A disturbance of ``-Jᵀ (F, m)``.
///
/// It pushes the arm where it points: ``M ddq + H = τ + Jᵀ (F, m)``. The tip is that of
/// ``arm.pose(q)``, of the arm that is really there.
///
/// Parameters
/// ----------
/// force: F [N], (3,); none by default.
/// moment: m [N·m], (3,); none by default.
/// curve: both over time in place of constants: a curve, `Pulses` or `Noise` of six columns, force
///     before moment.
#[pyclass(name = "Wrench", module = "steadyarm", frozen, extends = PyDisturbance)]
pub(super) struct PyWrench;

#[pymethods]
impl PyWrench {
    #[new]
    #[pyo3(signature = (force=None, moment=None, curve=None))]
    fn new(
        force: Given<'_, '_>,
        moment: Given<'_, '_>,
        curve: Given<'_, '_>,
    ) -> PyResult<PyClassInitializer<Self>> {
        let three = |value: Given<'_, '_>, name| {
            value.map(|it| vector::<3>(it, name).map(Into::into)).transpose()
        };
        let (force, moment) = (three(force, "force")?, three(moment, "moment")?);
        let curve =
            curve.map(|it| PyDisturbance::settings(it, "curve").map(Box::new)).transpose()?;
        let wrench = WrenchSettings { force, moment, curve };
        wrench.build().map_err(value_error)?;
        PyDisturbance::under(PushSettings::Wrench(wrench), Self)
    }
}

//! `Effects`: what stands between a controller and its arm.

use std::sync::Arc;

use pyo3::IntoPyObjectExt;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use pythonize::Depythonizer;
use serde::de::DeserializeOwned;

use super::convert::{Any, Given, object};
use super::form::{New, PyForm};
use crate::effects::Effects;
use crate::scenario::{EffectsSettings, SideName, VelocityName};

/// Sensors, timing and actuators of a real machine, seeded: all of them are off by default.
///
/// For `simulate` with a ``control_period``. What was measured and sent is recorded:
/// ``run.q_measured``, ``run.dq_measured``, ``run.tau_commanded``, ``run.q_motor``,
/// ``run.tau_cogging``, ``run.sample_age``. The same
/// seed gives the same bits.
///
/// Parameters
/// ----------
/// encoder_bits: bits of each encoder in a turn of its joint, scalar or (n,); None: exact.
/// noise: standard deviation of positions, before the encoder [rad], scalar or (n,).
/// velocity: where velocities come from: "measured" (the joint's own, with ``velocity_noise``
///     [rad/s]), "difference" of positions through a first-order filter of ``velocity_cutoff``
///     [Hz], a "tracking" differentiator of ``velocity_bandwidth`` [rad/s], or a "kalman" filter in
///     its steady state that counts with accelerations of ``velocity_acceleration`` [rad/s²].
/// velocity_noise, velocity_cutoff, velocity_bandwidth, velocity_acceleration: as above.
/// delay: samples, 0 to 4, between a torque and the period in which it acts.
/// jitter: by how much a period may differ from its length, as a share of it, 0 to 0.9.
/// drop: probability that a sample is lost, 0 to 0.9; the torque before it is held on.
/// effort_rate_limit: largest change of each torque that a drive follows [N·m/s], scalar or (n,).
/// gain: what arrives of a torque, as a share, scalar or (n,).
/// lag: time constant of each drive [s], scalar or (n,).
/// cogging: largest cogging torque [N·m], scalar or (n,), ``cogging_per_turn`` times in a turn.
/// cogging_per_turn: as above. With joints that give, cogging acts on the link.
/// joint_stiffness: of gears that give [N·m/rad], scalar or (n,); None: links follow their motors.
///     Needs a ``rotor_inertia``. The plant's own rotors are to be left out: ``with_armature(0)``.
/// joint_damping: of the gears [N·m·s/rad], scalar or (n,).
/// rotor_inertia: of each motor, on the link's side of its gear [kg·m²], scalar or (n,).
/// backlash: play of the gears from end to end [rad], scalar or (n,).
/// encoder_side: "motor" (as in most robots) or "link", where the encoders are.
/// seed: of all that is random, a whole number >= 0.
#[pyclass(name = "Effects", module = "steadyarm", frozen, extends = PyForm)]
pub(super) struct PyEffects {
    settings: Arc<EffectsSettings>,
}

impl PyEffects {
    /// The object of settings.
    pub fn made(settings: EffectsSettings) -> PyResult<New<Self>> {
        settings.check()?;
        let settings = Arc::new(settings);
        Ok(New(PyForm::under(settings.clone(), Self { settings })))
    }

    /// The effects of `N` joints that an argument says; `None`: none.
    pub fn of<const N: usize>(value: Given<'_, '_>) -> PyResult<Effects<N>> {
        let Some(value) = value else { return Ok(Effects::default()) };
        let effects = object::<Self>(value, "effects", "Effects or None")?.get();
        Ok(effects.settings.build()?)
    }
}

/// Settings from arguments by name, of which `None` is left out.
pub(super) fn settings<T: DeserializeOwned>(given: &Bound<'_, PyDict>, what: &str) -> PyResult<T> {
    let plain = PyDict::new(given.py());
    for (name, value) in given {
        if value.is_none() {
            continue;
        }
        // An array of numpy is no list.
        let listed = value.call_method0("tolist");
        plain.set_item(name, listed.unwrap_or(value))?;
    }
    let mut source = Depythonizer::from_object(&plain);
    serde_path_to_error::deserialize(&mut source).map_err(|error| {
        let path = error.path().to_string();
        let place = if path == "." { what } else { &path };
        PyValueError::new_err(format!("{place}: {}", error.inner()))
    })
}

#[pymethods]
impl PyEffects {
    #[new]
    #[pyo3(signature = (encoder_bits=None, noise=None, velocity=None, velocity_noise=None,
        velocity_cutoff=None, velocity_bandwidth=None, velocity_acceleration=None, delay=None,
        jitter=None, drop=None, effort_rate_limit=None, gain=None, lag=None, cogging=None,
        cogging_per_turn=None, joint_stiffness=None, joint_damping=None, rotor_inertia=None,
        backlash=None, encoder_side=None, seed=None))]
    #[expect(clippy::too_many_arguments, reason = "a Python class")]
    fn new(
        py: Python<'_>,
        encoder_bits: Given<'_, '_>,
        noise: Given<'_, '_>,
        velocity: Given<'_, '_>,
        velocity_noise: Given<'_, '_>,
        velocity_cutoff: Given<'_, '_>,
        velocity_bandwidth: Given<'_, '_>,
        velocity_acceleration: Given<'_, '_>,
        delay: Given<'_, '_>,
        jitter: Given<'_, '_>,
        drop: Given<'_, '_>,
        effort_rate_limit: Given<'_, '_>,
        gain: Given<'_, '_>,
        lag: Given<'_, '_>,
        cogging: Given<'_, '_>,
        cogging_per_turn: Given<'_, '_>,
        joint_stiffness: Given<'_, '_>,
        joint_damping: Given<'_, '_>,
        rotor_inertia: Given<'_, '_>,
        backlash: Given<'_, '_>,
        encoder_side: Given<'_, '_>,
        seed: Given<'_, '_>,
    ) -> PyResult<PyClassInitializer<Self>> {
        let given = PyDict::new(py);
        let all: [(&str, Option<Any<'_, '_>>); 21] = [
            ("encoder_bits", encoder_bits),
            ("noise", noise),
            ("velocity", velocity),
            ("velocity_noise", velocity_noise),
            ("velocity_cutoff", velocity_cutoff),
            ("velocity_bandwidth", velocity_bandwidth),
            ("velocity_acceleration", velocity_acceleration),
            ("delay", delay),
            ("jitter", jitter),
            ("drop", drop),
            ("effort_rate_limit", effort_rate_limit),
            ("gain", gain),
            ("lag", lag),
            ("cogging", cogging),
            ("cogging_per_turn", cogging_per_turn),
            ("joint_stiffness", joint_stiffness),
            ("joint_damping", joint_damping),
            ("rotor_inertia", rotor_inertia),
            ("backlash", backlash),
            ("encoder_side", encoder_side),
            ("seed", seed),
        ];
        for (name, value) in all {
            if let Some(value) = value {
                given.set_item(name, value)?;
            }
        }
        Ok(Self::made(settings(&given, "effects")?)?.0)
    }

    /// Samples between a torque and the period in which it acts.
    #[getter]
    fn delay(&self) -> usize {
        self.settings.delay
    }

    /// Seed of all that is random.
    #[getter]
    fn seed(&self) -> u64 {
        self.settings.seed
    }
}

impl<'py> IntoPyObject<'py> for &SideName {
    type Target = PyAny;
    type Output = Bound<'py, PyAny>;
    type Error = PyErr;

    fn into_pyobject(self, py: Python<'py>) -> PyResult<Self::Output> {
        self.name().into_bound_py_any(py)
    }
}

impl<'py> IntoPyObject<'py> for &VelocityName {
    type Target = PyAny;
    type Output = Bound<'py, PyAny>;
    type Error = PyErr;

    fn into_pyobject(self, py: Python<'py>) -> PyResult<Self::Output> {
        self.name().into_bound_py_any(py)
    }
}

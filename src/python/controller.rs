//! `Controller`: what every controller has, whatever its law.

use std::path::PathBuf;

use pyo3::PyTraverseError;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::gc::PyVisit;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyTuple};

use super::any_law::AnyLaw;
use super::arm::PyArm;
use super::compensator::no_compensator;
use super::convert::{Any, Array, Array1, Given, array1, joints, scalar, vector, wrong_type};
use super::dispatch::{each, for_joints};
use super::errors::value_error;
use super::form::{self, Form, Objects};
use super::saving;
use super::tracked::{Fronted, Limited, Tracker, Trackers, front, other_law, said};
use crate::control::{Front, Origin};
use crate::error::Problem;
use crate::math::Vector;
use crate::reference::Setpoint;

/// The arguments of the class.
const NAMES: [&str; 10] = [
    "arm",
    "law",
    "effort_limit",
    "effort_rate_limit",
    "last_tau",
    "hand_over",
    "velocity_filter",
    "bumpless",
    "delay",
    "control_period",
];

/// A controller with a law, and all that it remembers. `laws` makes them by name.
///
/// It remembers what it learnt, its last torque, the number of its steps, and the period that is
/// going on. Pickled or saved and restored, its next torques are the same to the bit. What
/// remembers is equal to itself alone; ``copy.replace(controller, delay=1)`` is another, before its
/// first step.
///
/// Parameters
/// ----------
/// arm: what the controller believes of the arm, with n joints.
/// law: a dict of its name, ``{"law": "super_twisting", ...}``, and its parameters, as the
///     functions of `laws` make it and a scenario file has it; or a controller of your own: an
///     object with a method ``step(q, dq, q_d, dq_d, ddq_d, dt) -> tau``.
/// effort_limit: largest torque of each joint [N·m], scalar or (n,), > 0; None or inf for none.
/// effort_rate_limit: largest change of each torque [N·m/s], likewise; for `step` and sampled
///     simulations only. It counts from the torque commanded last.
/// last_tau: the torque that is on the robot when the controller takes over [N·m], scalar or (n,),
///     at most 1e10. None: what holds ``arm`` at rest there.
/// hand_over: rate a [1/s] at which the reference is taken over from where the arm is:
///     ``q_d' = q_d + (δ + (δ̇ + aδ)t) exp(-at)``, δ the error at the first sample. None: at once.
/// velocity_filter: cut-off [Hz] of a velocity that is made of positions, by the difference of the
///     error through a first-order filter; the measured one is not used then. None: it is.
/// bumpless: rate [1/s] at which the torque goes from ``last_tau`` to the law's. None: at once.
/// delay: samples, 0 to 4, between a torque and the period in which it acts.
/// control_period: the period of the loop [s], for laws whose gains or conditions depend on it; a
///     law that it does not suit is refused. None: not known.
///
/// Raises
/// ------
/// ValueError, TypeError
///     Naming the parameter, or the condition of the law that does not hold.
#[pyclass(name = "Controller", module = "steadyarm", subclass)]
pub(super) struct PyController {
    pub arguments: Objects,
    pub trackers: Trackers,
}

impl PyController {
    /// The same tracker in the same state, of which one may go on alone. A controller of one's own
    /// is copied deeply.
    pub fn twin(tracker: &Bound<'_, Self>) -> PyResult<Self> {
        let (py, this) = (tracker.py(), Self::free(tracker)?);
        let trackers = each!(&this.trackers, Trackers, it => Tracker::clone(it).into());
        let mut twin = Self { arguments: this.arguments.clone_ref(py), trackers };
        if each!(&this.trackers, Trackers, it => matches!(it.controller.law, AnyLaw::Own(..))) {
            let own = this.arguments.get(py, 1)?;
            let changes = PyDict::new(py);
            changes.set_item("law", form::deep_copy(&own)?)?;
            let other = form::replaced(tracker, &this.arguments, Some(&changes))?;
            let other = other.cast::<Self>()?.borrow();
            twin.arguments = other.arguments.clone_ref(py);
            let saved = each!(&this.trackers, Trackers, it => it.controller.save(&it.state));
            twin.trackers = each!(&other.trackers, Trackers, it => Tracker::clone(it).into());
            twin.restore(&saved, true).map_err(value_error)?;
        }
        Ok(twin)
    }

    /// It, unless it is in the middle of a step.
    fn free<'a>(tracker: &'a Bound<'_, Self>) -> PyResult<PyRef<'a, Self>> {
        tracker.try_borrow().map_err(|_| {
            PyRuntimeError::new_err("tracker: it is in the middle of a step, wants one that is not")
        })
    }

    /// What it is made of: its arguments, and what it remembers.
    pub fn parts<'py>(&self, py: Python<'py>) -> (Py<PyTuple>, Bound<'py, PyBytes>) {
        (self.arguments.values.clone_ref(py), self.__getstate__(py))
    }

    fn restore(&mut self, bytes: &[u8], other: bool) -> crate::error::Result<Origin> {
        each!(&mut self.trackers, Trackers, it => it.restore(bytes, other))
    }

    fn set_frozen(&mut self, frozen: bool) -> PyResult<()> {
        each!(&mut self.trackers, Trackers, it => {
            it.controller.settle(&mut it.state).set_frozen(frozen)
        })
    }
}

#[pymethods]
impl PyController {
    #[new]
    #[pyo3(signature = (arm, law, effort_limit=None, effort_rate_limit=None, last_tau=None,
        hand_over=None, velocity_filter=None, bumpless=None, delay=None, control_period=None))]
    #[expect(clippy::too_many_arguments, reason = "a Python class")]
    fn new(
        py: Python<'_>,
        arm: Any<'_, '_>,
        law: Any<'_, '_>,
        effort_limit: Given<'_, '_>,
        effort_rate_limit: Given<'_, '_>,
        last_tau: Given<'_, '_>,
        hand_over: Given<'_, '_>,
        velocity_filter: Given<'_, '_>,
        bumpless: Given<'_, '_>,
        delay: Given<'_, '_>,
        control_period: Given<'_, '_>,
    ) -> PyResult<Self> {
        let limited = Limited { effort_limit, effort_rate_limit, last_tau };
        let fronted = Fronted { hand_over, velocity_filter, bumpless, delay };
        let period = control_period.map(|it| scalar(it, "control_period")).transpose()?;
        let joints = PyArm::of(arm)?.joints();
        let trackers = for_joints!(joints, other_law(arm, law, &limited, &fronted, period))?;
        let [effort, effort_rate, last_tau] = said(&trackers);
        let Front { hand_over, velocity_filter, bumpless, delay } = front(&trackers);
        // What the caller does to his dict later changes no controller.
        let law = if law.is_instance_of::<PyDict>() { form::deep_copy(law)? } else { law.clone() };
        let values = (
            arm,
            law,
            effort,
            effort_rate,
            last_tau,
            hand_over,
            velocity_filter,
            bumpless,
            delay,
            period,
        );
        Ok(Self { arguments: Objects::new(py, &NAMES, values)?, trackers })
    }

    /// The law: a dict of its name and parameters, or the object that was given.
    #[getter]
    fn law<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        each!(&self.trackers, Trackers, it => match &it.controller.law {
            AnyLaw::Computed(law) => {
                let dict = PyDict::new(py);
                dict.set_item("law", "computed_torque")?;
                dict.set_item("kp", law.gains.kp.to_vec())?;
                dict.set_item("kv", law.gains.kv.to_vec())?;
                Ok(dict.into_any())
            }
            _ => self.arguments.get(py, 1),
        })
    }

    /// Gains and what was learnt, at the end of the latest period: numbers by name, arrays.
    ///
    /// Of the recommended controller: ``bandwidth`` [rad/s], ``cut_off`` [Hz], ``learning`` [Hz],
    /// ``acceleration_share``, ``condition``, ``weight`` [kg·m²], ``unit`` [N·m], ``parameters``
    /// (m,), ``covariance`` (m, m) as a flat array, ``prior`` (m,); `learned` reads them. Empty for
    /// others.
    fn describe<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for (name, numbers) in each!(&self.trackers, Trackers, it => it.described()) {
            dict.set_item(name, array1(py, &numbers))?;
        }
        Ok(dict)
    }

    /// Samples between a torque and the period in which it acts.
    #[getter]
    fn delay(&self) -> usize {
        front(&self.trackers).delay
    }

    /// Hand over anew at the next sample, to another reference.
    fn start_hand_over(&mut self) {
        each!(&mut self.trackers, Trackers, it => it.state.hand_over());
    }

    /// One sample: the torque [N·m], (n,), to hold for ``dt`` [s]; adapts the weights meanwhile.
    ///
    /// ``q``, ``q_d`` [rad]: (n,), at most 1e5, of a joint that has turned farther without whole
    /// turns; ``dq``, ``dq_d`` [rad/s], ``ddq_d`` [rad/s²]: (n,), at most 1e10. ``dt`` is 1e-9 to
    /// 1 s. The torque is finite and inside the limits.
    ///
    /// A step first ends the period of the one before, and learns from it, then decides.
    /// ``applied`` [N·m], (n,), finite: the torque that acted in that period, where the drive
    /// let through another one than `step` gave, ``applied=np.clip(tau, -drive, drive)``. Nothing
    /// is learnt from a period in which it differs from what the law asked for, by whatever
    /// little: what a sensor measured is not wanted here. None: what `step` gave. Before the first
    /// step it says nothing. ``elapsed`` [s]: the time since the last step, as it was measured,
    /// where the loop jitters; None: the ``dt`` of that step.
    ///
    /// Raises ValueError or TypeError naming what does not fit; nothing has changed then, bit for
    /// bit. For ``tau``, a torque that would be infinite, the period before has ended.
    #[inline]
    #[pyo3(signature = (q, dq, q_d, dq_d, ddq_d, dt, applied=None, elapsed=None))]
    #[expect(clippy::too_many_arguments, reason = "a Python method")]
    fn step<'py>(
        &mut self,
        py: Python<'py>,
        q: Any<'_, 'py>,
        dq: Any<'_, 'py>,
        q_d: Any<'_, 'py>,
        dq_d: Any<'_, 'py>,
        ddq_d: Any<'_, 'py>,
        dt: Any<'_, 'py>,
        applied: Given<'_, 'py>,
        elapsed: Given<'_, 'py>,
    ) -> PyResult<Array1<'py>> {
        each!(&mut self.trackers, Trackers, it => {
            let (q, dq) = (vector(q, "q")?, vector(dq, "dq")?);
            let (q_d, dq_d) = (vector(q_d, "q_d")?, vector(dq_d, "dq_d")?);
            let desired = Setpoint { q: q_d, dq: dq_d, ddq: vector(ddq_d, "ddq_d")? };
            let dt = scalar(dt, "dt")?;
            let applied = applied.map(|tau| vector(tau, "applied")).transpose()?;
            let elapsed = elapsed.map(|it| scalar(it, "elapsed")).transpose()?;
            let tau = it.step(applied.as_ref(), &q, &dq, &desired, dt, elapsed);
            let raised = |error| it.controller.law.raised().unwrap_or_else(|| value_error(error));
            Ok(array1(py, tau.map_err(raised)?.as_slice()))
        })
    }

    /// Forget everything: weights, prior, last torque, count of steps.
    ///
    /// The tracker is then as a new one, to the bit, and not frozen. ``last_tau``: the torque that
    /// is on the robot now [N·m], scalar or (n,); None: as it was built. A controller of your own
    /// is reset by its method ``reset()``; TypeError if it has none.
    #[pyo3(signature = (last_tau=None))]
    fn reset(&mut self, last_tau: Given<'_, '_>) -> PyResult<()> {
        each!(&self.trackers, Trackers, it => it.controller.law.reset())?;
        each!(&mut self.trackers, Trackers, it => {
            let last_tau = last_tau.map(|tau| joints(tau, "last_tau").map(Vector::from));
            it.reset(last_tau.transpose()?).map_err(value_error)
        })
    }

    /// M₀v + H₀ of the latest step [N·m], (n,); None before it, and after a load.
    #[getter]
    fn tau_model(&self) -> Option<Array<1>> {
        each!(&self.trackers, Trackers, it => it.latest.map(|it| it.model.into()))
    }

    /// -M₀ρ̂ of the latest step [N·m], (n,); None before it, and after a load.
    #[getter]
    fn tau_compensation(&self) -> Option<Array<1>> {
        each!(&self.trackers, Trackers, it => it.latest.map(|it| it.compensation.into()))
    }

    /// ρ̂ of the latest step [rad/s²], (n,); None before it, and after a load.
    #[getter]
    fn rho_hat(&self) -> Option<Array<1>> {
        each!(&self.trackers, Trackers, it => it.latest.map(|it| it.rho_hat.into()))
    }

    /// Whether a limit cut the latest torque; nothing is learnt from its period then.
    ///
    /// False before a step, and after a load.
    #[getter]
    fn limited(&self) -> bool {
        each!(&self.trackers, Trackers, it => it.latest.is_some_and(|it| it.limited))
    }

    /// Number of samples accepted.
    #[getter]
    fn steps(&self) -> u64 {
        each!(&self.trackers, Trackers, it => it.state.steps)
    }

    /// The nominal arm.
    #[getter]
    fn arm<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.arguments.get(py, 0)
    }

    /// Stop adapting; the weights stay in use.
    ///
    /// The latest period ends, and is still learnt from: ``applied`` [N·m], (n,), is the torque
    /// that acted in it, as in `step`; None: what `step` gave, or a guard sent. Raises TypeError
    /// without a compensator.
    #[pyo3(signature = (applied=None))]
    fn freeze(&mut self, applied: Given<'_, '_>) -> PyResult<()> {
        each!(&mut self.trackers, Trackers, it => {
            if !it.controller.compensator.remembers() {
                return Err(no_compensator());
            }
            let applied = applied.map(|tau| vector(tau, "applied")).transpose()?;
            it.controller.end_period(&mut it.state, applied.as_ref()).map_err(value_error)
        })?;
        self.set_frozen(true)
    }

    /// Adapt again. Raises TypeError without a compensator.
    fn unfreeze(&mut self) -> PyResult<()> {
        self.set_frozen(false)
    }

    /// Whether it learns something that stays right when learning stops; an observer does
    /// not.
    #[getter]
    fn learns(&self) -> bool {
        each!(&self.trackers, Trackers, it => it.controller.compensator.learns())
    }

    /// Whether adaptation is stopped.
    #[getter]
    fn frozen(&self) -> bool {
        each!(&self.trackers, Trackers, it => it.state.compensator.frozen())
    }

    /// What the controller remembers, as bytes: versioned, checksummed, exact to the bit.
    fn __getstate__<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        let saved = each!(&self.trackers, Trackers, it => {
            it.controller.save(&it.state)
        });
        PyBytes::new(py, &saved)
    }

    fn __setstate__(&mut self, bytes: Any<'_, '_>) -> PyResult<()> {
        let bytes =
            bytes.cast::<PyBytes>().map_err(|_| wrong_type("saved state", bytes, "bytes"))?;
        self.restore(bytes.as_bytes(), false).map(drop).map_err(value_error)
    }

    /// Write what the controller remembers (weights, last torque, latest period) to a file.
    ///
    /// The file is replaced as a whole; a pipe or device is written to. Raises OSError if that
    /// fails; what was there stays then. Other threads may use the controller meanwhile.
    fn save(slf: &Bound<'_, Self>, path: PathBuf) -> PyResult<()> {
        each!(&slf.try_borrow()?.trackers, Trackers, it => it.controller.law.saves())?;
        // Not borrowed while the disk is waited for: other threads may step it.
        let saved = slf.try_borrow()?.__getstate__(slf.py());
        saving::write(&path, &saved)
    }

    /// Read what `save` wrote; the next torques are then the same to the bit.
    ///
    /// Raises ValueError for a damaged file, or one of a controller with another nominal arm, other
    /// gains, another compensator or other sets, which it names, and OSError if the file cannot be
    /// read; nothing has changed then. ``other=True`` takes the state of another controller of the
    /// same size all the same: you know that its weights are right here. A file of version 1 does
    /// not say whose it is, and is taken with a UserWarning.
    #[pyo3(signature = (path, other=false))]
    fn load(slf: &Bound<'_, Self>, path: PathBuf, other: bool) -> PyResult<()> {
        each!(&slf.try_borrow()?.trackers, Trackers, it => it.controller.law.saves())?;
        let bytes = saving::read(slf.py(), &path)?;
        let mut twin = Self::twin(slf)?;
        let origin = twin.restore(bytes.as_bytes(), other).map_err(|error| {
            let path = path.display();
            let hint = match error.problem() {
                Problem::OtherController { .. } => "; other=True takes it all the same",
                _ => "",
            };
            PyValueError::new_err(format!(
                "path: got {path}, wants a file of this controller ({error}{hint})"
            ))
        })?;
        if origin == Origin::Unknown && !other {
            saving::warn_of_unknown(slf.py(), &path)?;
        }
        slf.try_borrow_mut()?.trackers = twin.trackers;
        Ok(())
    }

    fn __reduce__<'py>(
        slf: &Bound<'py, Self>,
    ) -> PyResult<(Bound<'py, PyAny>, Py<PyTuple>, Bound<'py, PyBytes>)> {
        let (arguments, state) = slf.try_borrow()?.parts(slf.py());
        Ok((slf.get_type().into_any(), arguments, state))
    }

    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        each!(&self.trackers, Trackers, it => it.controller.law.traverse(&visit))?;
        self.arguments.traverse(&visit)
    }

    /// A tracker before its first step, with other values of these arguments.
    #[pyo3(signature = (**changes))]
    fn __replace__<'py>(
        slf: &Bound<'py, Self>,
        changes: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let arguments = slf.try_borrow()?.arguments.clone_ref(slf.py());
        form::replaced(slf, &arguments, changes)
    }

    fn __repr__(slf: &Bound<'_, Self>) -> PyResult<String> {
        let arguments = slf.try_borrow()?.arguments.clone_ref(slf.py());
        form::shown(slf, &arguments)
    }
}

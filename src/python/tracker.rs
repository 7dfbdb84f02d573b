//! `ComputedTorque`: the stepwise controller.

use std::path::PathBuf;

use pyo3::PyTraverseError;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::gc::PyVisit;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyTuple};

use super::arm::PyArm;
use super::compensator::{compensator_of, no_compensator};
use super::convert::{
    Any, Array, Array1, Given, array1, joints, matrix_of, scalar, vector, wrong_type,
};
use super::dispatch::{each, for_joints};
use super::errors::value_error;
use super::form::{self, Form, Objects, limits};
use super::saving;
use super::tracked::{Arguments, Tracker, Trackers, tracker};
use crate::control::{Gains, Limits, Origin};
use crate::error::Problem;
use crate::math::Vector;
use crate::reference::Setpoint;

/// The arguments of the class.
const NAMES: [&str; 7] =
    ["arm", "kp", "kv", "compensator", "effort_limit", "effort_rate_limit", "last_tau"];

/// Computed torque for the nominal arm with a compensator (7), (11), (12), and its state.
///
/// ``tau = M₀ (v - ρ̂) + H₀`` with ``v = ddq_d - K_v de - K_p e``, ``e = q - q_d``. Where a joint
/// of ``arm`` is continuous, e is taken around the circle, -π <= e < π.
///
/// The object remembers its weights, its last torque, the number of its steps, and the period that
/// is going on. Pickled or saved and restored, its next torques are the same to the bit. What
/// remembers is equal to itself alone; ``copy.replace(tracker, kp=9.0)`` is another, before its
/// first step.
///
/// Parameters
/// ----------
/// arm: what the controller believes of the arm, with n joints.
/// kp: K_p [1/s²], scalar or (n,), > 0.
/// kv: K_v [1/s], scalar or (n,), > 0.
/// compensator: produces ρ̂; None for plain computed torque.
/// effort_limit: largest torque of each joint [N·m], scalar or (n,), > 0; None or inf for none.
/// effort_rate_limit: largest change of each torque [N·m/s], likewise; for `step` and sampled
///     simulations only. It counts from the torque commanded last.
/// last_tau: the torque that is on the robot when the controller takes over [N·m], scalar or (n,),
///     at most 1e10: what the rate limit of the first sample counts from. None: what holds ``arm``
///     at rest there.
///
/// Raises
/// ------
/// NoStabilizingSolution
///     If (19) has no solution for these gains and the compensator's Q and γ.
/// ValueError, TypeError
///     Naming the parameter.
#[pyclass(name = "ComputedTorque", module = "steadyarm")]
pub(super) struct PyComputedTorque {
    arguments: Objects,
    pub trackers: Trackers,
}

impl PyComputedTorque {
    /// The same tracker in the same state, of which one may go on alone.
    pub fn twin(tracker: &Bound<'_, Self>) -> PyResult<Self> {
        let this = tracker.try_borrow().map_err(|_| {
            PyRuntimeError::new_err("tracker: it is in the middle of a step, wants one that is not")
        })?;
        let trackers = each!(&this.trackers, Trackers, it => Tracker::clone(it).into());
        Ok(Self { arguments: this.arguments.clone_ref(tracker.py()), trackers })
    }

    /// What it is made of: its arguments, and what it remembers.
    pub fn parts<'py>(&self, py: Python<'py>) -> (Py<PyTuple>, Bound<'py, PyBytes>) {
        (self.arguments.values.clone_ref(py), self.__getstate__(py))
    }

    fn restore(&mut self, bytes: &[u8], other: bool) -> crate::error::Result<Origin> {
        each!(&mut self.trackers, Trackers, it => it.restore(bytes, other))
    }

    fn write_weights(&mut self, weights: Any<'_, '_>, prior: bool) -> PyResult<()> {
        let rows = self.trackers.joints();
        each!(&mut self.trackers, Trackers, it => {
            let compensator = &it.controller.compensator;
            let weights = matrix_of(weights, "weights", rows, compensator.rules()?)?;
            compensator.check_weights(&weights, prior)?;
            compensator.set_weights(it.controller.settle(&mut it.state), &weights, prior)
        })
    }

    fn set_frozen(&mut self, frozen: bool) -> PyResult<()> {
        each!(&mut self.trackers, Trackers, it => {
            it.controller.settle(&mut it.state).set_frozen(frozen)
        })
    }
}

#[pymethods]
impl PyComputedTorque {
    #[new]
    #[pyo3(signature = (arm, kp, kv, compensator=None, effort_limit=None, effort_rate_limit=None, last_tau=None))]
    #[expect(clippy::too_many_arguments, reason = "a Python class")]
    fn new(
        py: Python<'_>,
        arm: Any<'_, '_>,
        kp: Any<'_, '_>,
        kv: Any<'_, '_>,
        compensator: Given<'_, '_>,
        effort_limit: Given<'_, '_>,
        effort_rate_limit: Given<'_, '_>,
        last_tau: Given<'_, '_>,
    ) -> PyResult<Self> {
        let given =
            Arguments { arm, kp, kv, compensator, effort_limit, effort_rate_limit, last_tau };
        let joints = PyArm::of(arm)?.joints();
        let trackers = for_joints!(joints, tracker(&given))?;
        let (kp, kv, effort, effort_rate) = each!(&trackers, Trackers, it => {
            let Limits { effort_limit, effort_rate_limit } = &it.controller.limits;
            let Gains { kp, kv } = &it.controller.law.gains;
            (kp.to_vec(), kv.to_vec(), limits(effort_limit), limits(effort_rate_limit))
        });
        let last_tau =
            each!(&trackers, Trackers, it => it.last_tau.map(|tau| tau.as_slice().to_vec()));
        // Scalars of the compensator count for the joints of this arm.
        let compensator =
            compensator.map(|it| compensator_of(it)?.of_joints(joints)).transpose()?;
        let values = (arm, kp, kv, compensator, effort, effort_rate, last_tau);
        Ok(Self { arguments: Objects::new(py, &NAMES, values)?, trackers })
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
    /// step it says nothing.
    ///
    /// Raises ValueError or TypeError naming what does not fit; nothing has changed then, bit for
    /// bit. For ``tau``, a torque that would be infinite, the period before has ended.
    #[inline]
    #[pyo3(signature = (q, dq, q_d, dq_d, ddq_d, dt, applied=None))]
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
    ) -> PyResult<Array1<'py>> {
        each!(&mut self.trackers, Trackers, it => {
            let (q, dq) = (vector(q, "q")?, vector(dq, "dq")?);
            let (q_d, dq_d) = (vector(q_d, "q_d")?, vector(dq_d, "dq_d")?);
            let desired = Setpoint { q: q_d, dq: dq_d, ddq: vector(ddq_d, "ddq_d")? };
            let dt = scalar(dt, "dt")?;
            let applied = applied.map(|tau| vector(tau, "applied")).transpose()?;
            let tau = it.step(applied.as_ref(), &q, &dq, &desired, dt).map_err(value_error)?;
            Ok(array1(py, tau.as_slice()))
        })
    }

    /// Forget everything: weights, prior, last torque, count of steps.
    ///
    /// The tracker is then as a new one, to the bit, and not frozen. ``last_tau``: the torque that
    /// is on the robot now [N·m], scalar or (n,); None: as it was built.
    #[pyo3(signature = (last_tau=None))]
    fn reset(&mut self, last_tau: Given<'_, '_>) -> PyResult<()> {
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

    /// K_p [1/s²], (n,).
    #[getter]
    fn kp(&self) -> Array<1> {
        each!(&self.trackers, Trackers, it => it.controller.law.gains.kp[..].into())
    }

    /// K_v [1/s], (n,).
    #[getter]
    fn kv(&self) -> Array<1> {
        each!(&self.trackers, Trackers, it => it.controller.law.gains.kv[..].into())
    }

    /// The nominal arm.
    #[getter]
    fn arm<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.arguments.get(py, 0)
    }

    /// The compensator, or None.
    #[getter]
    fn compensator<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.arguments.get(py, 3)
    }

    /// P of (19), (2n, 2n); None without a compensator.
    #[getter]
    #[pyo3(name = "P")]
    fn p(&self) -> Option<Array<2>> {
        let p = each!(&self.trackers, Trackers, it => it.p());
        p.map(|p| Array::rows(p, 2 * self.trackers.joints()))
    }

    /// W, (n, rules) (per_joint: the rules of one joint), a copy; None without a compensator.
    ///
    /// What the latest period taught is in it, as if the torque of `step` acted; the next step may
    /// still tell another one. Assign to set it: adaptation goes on from there, without a prior W₀.
    /// Raises ValueError for a wrong shape, entries that are not finite or beyond 1e150, or weights
    /// beyond the ``projection_radius``; TypeError without a compensator. With a ``dictionary``
    /// there is no such matrix: reading and setting raise TypeError.
    #[getter]
    fn weights(&self, py: Python<'_>) -> PyResult<Option<Array<2>>> {
        if self.compensator(py)?.is_none() {
            return Ok(None);
        }
        each!(&self.trackers, Trackers, it => {
            let compensator = &it.controller.compensator;
            let weights = compensator.weights(&it.ended())?;
            Ok(Some(Array::rows(weights, compensator.rules()?)))
        })
    }

    #[setter]
    fn set_weights(&mut self, weights: Any<'_, '_>) -> PyResult<()> {
        self.write_weights(weights, false)
    }

    /// Set W, and make it the W₀ that leak, e-modification and projection pull to.
    fn warm_start(&mut self, weights: Any<'_, '_>) -> PyResult<()> {
        self.write_weights(weights, true)
    }

    /// The kernel form in figures; None for a compensator without a dictionary.
    ///
    /// ``atoms`` of ``capacity`` states are in it. ``merged`` terms went into a state that was
    /// there; ``dropped`` states made room when it was full. ``error_bound`` (n,) bounds what all
    /// that lost, |W - W_exact| of each joint, and fades as W does. The error of ρ̂ [rad/s²] is at
    /// most |ξ| times that, with |ξ| <= 1 for a normalised basis.
    #[getter]
    fn dictionary<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        each!(&self.trackers, Trackers, it => {
            it.controller.compensator.dictionary(py, &it.ended())
        })
    }

    /// Stop adapting; the weights stay in use.
    ///
    /// The latest period ends, and is still learnt from: ``applied`` [N·m], (n,), is the torque
    /// that acted in it, as in `step`; None: what `step` gave, or a guard sent. Raises TypeError
    /// without a compensator.
    #[pyo3(signature = (applied=None))]
    fn freeze(&mut self, applied: Given<'_, '_>) -> PyResult<()> {
        each!(&mut self.trackers, Trackers, it => {
            it.controller.compensator.subject().ok_or_else(no_compensator)?;
            let applied = applied.map(|tau| vector(tau, "applied")).transpose()?;
            it.controller.end_period(&mut it.state, applied.as_ref()).map_err(value_error)
        })?;
        self.set_frozen(true)
    }

    /// Adapt again. Raises TypeError without a compensator.
    fn unfreeze(&mut self) -> PyResult<()> {
        self.set_frozen(false)
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

    // As for a plant: no `__clear__`.
    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
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

//! `Guard`: what stands between a controller and the robot.

use pyo3::PyTraverseError;
use pyo3::gc::PyVisit;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::controller::PyController;
use super::convert::{
    Any, Array1, Given, array1, count, joints, object, scalar, scalar_or, vector,
};
use super::dispatch::{each, for_joints};
use super::errors::value_error;
use super::guarding::{Arguments, Guards, Own, guard};
use crate::control::{Cause, Event, Seen};
use crate::math::Vector;
use crate::reference::Setpoint;

/// A guard around a tracker: an answer to every sample, good, bad or missing.
///
/// The torque that it gives can be sent, whatever came: it is finite, at most ``effort_limit``, and
/// changes by at most ``effort_rate_limit`` from the one before. A sample that cannot be true is
/// not used, and nothing is learnt from it. The last torque is then held, decays to the one that
/// carries the arm, and after ``hold`` + ``decay`` periods the guard stops: it brakes the arm, and
/// stays stopped until `rearm`. It has no clock: tell it the time since the last call.
///
/// Parameters
/// ----------
/// tracker: the controller; the guard steps it.
/// control_period: nominal period of the loop [s], 1e-9 to 1.
/// position_limits: (n, 2) [rad]; outside, the guard stops. None: the nominal arm's.
/// velocity_limit: [rad/s], scalar or (n,). Faster, the guard stops; a position that moved farther
///     than that since the last sample is not used. None: the nominal arm's.
/// effort_limit: [N·m], scalar or (n,). None: the nominal arm's.
/// effort_rate_limit: [N·m/s], scalar or (n,); None for no limit.
/// power_limit: of τ·q̇ that a joint gives to the arm [W], scalar or (n,); None for no limit.
/// envelope: of the tracking error [rad], scalar or (n,); outside, the guard stops. None: no limit.
/// slack: what a position may change beyond its speed limit [rad], such as an encoder's step.
/// hold, decay: periods without a good sample in which the torque is held, and in which it decays.
/// bandwidth: p of the brake [rad/s], scalar or (n,), at most 0.25 / control_period: the nominal
///     arm comes to rest with a double pole at -p. None: min(0.1 / control_period, 20).
/// deceleration: of the brake [rad/s²], scalar or (n,); None: 10.
/// last_tau: the torque that is on the robot at take-over [N·m], scalar or (n,). None: what the
///     tracker commanded last, or was made with; else the one that carries the arm at the first
///     good sample, and zero until then.
///
/// Raises
/// ------
/// ValueError, TypeError
///     Naming the parameter.
#[pyclass(name = "Guard", module = "steadyarm")]
pub(super) struct PyGuard {
    pub tracker: Py<PyController>,
    pub guards: Guards,
}

impl PyGuard {
    /// |τ| of each joint is at most that [N·m].
    pub fn effort_limit(&self) -> Vec<f64> {
        each!(&self.guards, Guards, own => own.parameters.effort_limit.to_vec())
    }

    /// A copy for a run, which leaves the guard as it is, and counts from zero.
    pub fn twin(&self) -> Guards {
        each!(&self.guards, Guards, own => {
            let mut own = Own::clone(own);
            own.memory.recount();
            own.into()
        })
    }
}

/// In how many calls each event happened, by name, and why the guard has stopped.
pub(super) fn done<'py>(
    py: Python<'py>,
    guards: &Guards,
) -> PyResult<(Bound<'py, PyDict>, Option<String>)> {
    let events = PyDict::new(py);
    each!(guards, Guards, own => {
        for event in Event::ALL {
            events.set_item(event.name(), own.memory.count(event))?;
        }
        Ok((events, own.memory.stopped().map(words)))
    })
}

#[pymethods]
impl PyGuard {
    #[new]
    #[pyo3(signature = (tracker, control_period, *, position_limits=None, velocity_limit=None,
        effort_limit=None, effort_rate_limit=None, power_limit=None, envelope=None, slack=None,
        hold=None, decay=None, bandwidth=None, deceleration=None, last_tau=None))]
    #[expect(clippy::too_many_arguments, reason = "a Python method")]
    fn new(
        tracker: Any<'_, '_>,
        control_period: Any<'_, '_>,
        position_limits: Given<'_, '_>,
        velocity_limit: Given<'_, '_>,
        effort_limit: Given<'_, '_>,
        effort_rate_limit: Given<'_, '_>,
        power_limit: Given<'_, '_>,
        envelope: Given<'_, '_>,
        slack: Given<'_, '_>,
        hold: Given<'_, '_>,
        decay: Given<'_, '_>,
        bandwidth: Given<'_, '_>,
        deceleration: Given<'_, '_>,
        last_tau: Given<'_, '_>,
    ) -> PyResult<Self> {
        let periods = |value: Given<'_, '_>, name| {
            let count = value.map_or(Ok(20), |value| count(value, name, 0))?;
            Ok::<u32, PyErr>(u32::try_from(count).unwrap_or(u32::MAX))
        };
        let (hold, decay) = (periods(hold, "hold")?, periods(decay, "decay")?);
        let tracker =
            object::<PyController>(tracker, "tracker", "a Controller, such as a ComputedTorque")?;
        let arguments = Arguments {
            control_period: scalar(control_period, "control_period")?,
            position_limits,
            velocity_limit,
            effort_limit,
            effort_rate_limit,
            power_limit,
            envelope,
            slack,
            hold,
            decay,
            bandwidth,
            deceleration,
            last_tau,
        };
        let trackers = &tracker.borrow().trackers;
        let guards = for_joints!(trackers.joints(), guard(trackers, &arguments))?;
        Ok(Self { tracker: tracker.clone().unbind(), guards })
    }

    /// One sample: the torque to send [N·m], (n,).
    ///
    /// ``q``, ``q_d`` [rad], ``dq``, ``dq_d`` [rad/s], ``ddq_d`` [rad/s²]: (n,), whatever is in
    /// them. ``elapsed``: the time since the last call [s], as it was measured; None: a period.
    /// ``applied``: the torque that the drive let through since then [N·m], (n,), if it says so;
    /// where it is not finite nothing is learnt from that period, and ``not_finite`` is counted.
    /// Raises ValueError or TypeError for what is no such array alone; nothing has changed then.
    #[pyo3(signature = (q, dq, q_d, dq_d, ddq_d, elapsed=None, applied=None))]
    #[expect(clippy::too_many_arguments, reason = "a Python method")]
    fn step<'py>(
        &mut self,
        py: Python<'py>,
        q: Any<'_, 'py>,
        dq: Any<'_, 'py>,
        q_d: Any<'_, 'py>,
        dq_d: Any<'_, 'py>,
        ddq_d: Any<'_, 'py>,
        elapsed: Given<'_, 'py>,
        applied: Given<'_, 'py>,
    ) -> PyResult<Array1<'py>> {
        let tracker = &mut self.tracker.bind(py).try_borrow_mut()?.trackers;
        each!(&mut self.guards, Guards, own => {
            let (q, dq) = (&vector(q, "q")?, &vector(dq, "dq")?);
            let (q_d, dq_d) = (vector(q_d, "q_d")?, vector(dq_d, "dq_d")?);
            let desired = &Setpoint { q: q_d, dq: dq_d, ddq: vector(ddq_d, "ddq_d")? };
            let elapsed = scalar_or(elapsed, own.parameters.control_period, "elapsed")?;
            let applied = applied.map(|tau| vector(tau, "applied")).transpose()?;
            let seen = Seen { q, dq, desired, applied: applied.as_ref(), elapsed };
            let tracker = own.of(tracker)?;
            tracker.controller.law.tell(own.parameters.control_period);
            let guarded = own.turn(tracker).step(&seen);
            Ok(array1(py, own.sent(tracker, guarded).as_slice()))
        })
    }

    /// A period in which no sample came: the torque to send [N·m], (n,).
    fn missed<'py>(&mut self, py: Python<'py>) -> PyResult<Array1<'py>> {
        let tracker = &mut self.tracker.bind(py).try_borrow_mut()?.trackers;
        each!(&mut self.guards, Guards, own => {
            let tracker = own.of(tracker)?;
            let guarded = own.turn(tracker).missed();
            Ok(array1(py, own.sent(tracker, guarded).as_slice()))
        })
    }

    /// Stop: from the next sample on the arm is braked, until `rearm`.
    fn stop(&mut self, py: Python<'_>) -> PyResult<()> {
        let tracker = &mut self.tracker.bind(py).try_borrow_mut()?.trackers;
        each!(&mut self.guards, Guards, own => {
            let tracker = own.of(tracker)?;
            own.turn(tracker).stop();
            Ok(())
        })
    }

    /// Let a guard that has stopped run again from the next sample on.
    ///
    /// That sample may be anywhere; the set-point should be near it.
    fn rearm(&mut self) {
        each!(&mut self.guards, Guards, own => own.memory.rearm());
    }

    /// Forget everything, the tracker's weights too: both are then as new ones, to the bit.
    ///
    /// ``last_tau``: the torque that is on the robot now [N·m], scalar or (n,); None: as it was
    /// built.
    #[pyo3(signature = (last_tau=None))]
    fn reset(&mut self, py: Python<'_>, last_tau: Given<'_, '_>) -> PyResult<()> {
        let tracker = &mut self.tracker.bind(py).try_borrow_mut()?.trackers;
        each!(&mut self.guards, Guards, own => {
            let last_tau = last_tau.map(|tau| joints(tau, "last_tau").map(Vector::from));
            let (last_tau, tracker) = (last_tau.transpose()?, own.of(tracker)?);
            tracker.reset(None).and_then(|()| own.begin(tracker, last_tau)).map_err(value_error)
        })
    }

    /// Why the guard has stopped, such as "position of joint 2"; None while it runs.
    #[getter]
    fn stopped(&self) -> Option<String> {
        each!(&self.guards, Guards, own => own.memory.stopped().map(words))
    }

    /// What the guard did in the latest call, by name; empty if there was nothing to do.
    #[getter]
    fn latest(&self) -> Vec<&'static str> {
        each!(&self.guards, Guards, own => own.latest.iter().map(Event::name).collect())
    }

    /// In how many calls each event happened, by name; of ``missed``, how many periods.
    ///
    /// Not used: ``not_finite``, ``jump``, ``early``, ``missed``, ``clock``. Used: ``late``. The
    /// ``controller`` refused. Cut: ``effort``, ``effort_rate``, ``power``. Stopped: ``position``,
    /// ``velocity``, ``envelope``, ``stop``.
    #[getter]
    fn events<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        Ok(done(py, &self.guards)?.0)
    }

    /// Periods in a row without a good sample.
    #[getter]
    fn lost(&self) -> u64 {
        each!(&self.guards, Guards, own => own.memory.lost())
    }

    /// The torque sent last [N·m], (n,); None before the first.
    #[getter]
    fn last_tau<'py>(&self, py: Python<'py>) -> Option<Array1<'py>> {
        each!(&self.guards, Guards, own => {
            own.memory.last_tau().map(|tau| array1(py, tau.as_slice()))
        })
    }

    /// The controller that it guards.
    #[getter]
    fn tracker(&self, py: Python<'_>) -> Py<PyController> {
        self.tracker.clone_ref(py)
    }

    /// Nominal period of the loop [s].
    #[getter]
    fn control_period(&self) -> f64 {
        each!(&self.guards, Guards, own => own.parameters.control_period)
    }

    fn __repr__(&self) -> String {
        let state = self.stopped().map_or("running".into(), |why| format!("stopped: {why}"));
        format!("Guard(control_period={:?}, {state})", self.control_period())
    }

    // As for a plant: no `__clear__`.
    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        visit.call(&self.tracker)
    }
}

fn words(Cause { event, joint }: Cause) -> String {
    match joint {
        Some(joint) => format!("{} of joint {}", event.name(), joint + 1),
        None => event.name().into(),
    }
}

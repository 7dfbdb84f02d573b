//! `Guard`: what stands between a controller and the robot.

use core::any::Any as Type;

use pyo3::PyTraverseError;
use pyo3::exceptions::PyTypeError;
use pyo3::gc::PyVisit;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::any_arm::AnyArm;
use super::compensator::{AnyCompensator, Memory};
use super::convert::{
    Any, Array1, Given, Numbers, array1, count, joints, numbers, object, scalar, scalar_or, vector,
    wrong_shape,
};
use super::dispatch::{by_joints, each, for_joints};
use super::errors::value_error;
use super::tracked::{Tracker, Trackers};
use super::tracker::PyComputedTorque;
use crate::arm::{Arm, Serial};
use crate::control::{
    Brake, Cause, ComputedTorque, Event, Events, GuardMemory, GuardParameters, Guarded, Seen, Turn,
};
use crate::error::Error;
use crate::math::Vector;
use crate::reference::Setpoint;

/// Stiffness of the brake in periods, and at most \[1/s\]: ω = min(0.1 / period, 20).
const BRAKE_RATE: f64 = 0.1;
const FASTEST_BRAKE: f64 = 20.0;

/// A guard of `N` joints.
#[derive(Clone)]
pub(super) struct Own<const N: usize> {
    pub parameters: GuardParameters<N>,
    pub memory: GuardMemory<N>,
    /// The torque at take-over that it was made with.
    last_tau: Option<Vector<N>>,
    latest: Events,
}

by_joints! {
    /// A guard of any joint count.
    Guards of Own
}

/// Arguments of the class that depend on the joint count.
struct Arguments<'a, 'py> {
    period: f64,
    position_limits: Given<'a, 'py>,
    velocity_limit: Given<'a, 'py>,
    effort_limit: Given<'a, 'py>,
    effort_rate_limit: Given<'a, 'py>,
    power_limit: Given<'a, 'py>,
    envelope: Given<'a, 'py>,
    slack: Given<'a, 'py>,
    hold: u32,
    decay: u32,
    stiffness: Given<'a, 'py>,
    damping: Given<'a, 'py>,
    deceleration: Given<'a, 'py>,
    last_tau: Given<'a, 'py>,
}

type Guarding<'a, const N: usize> =
    Turn<'a, N, ComputedTorque<N, AnyArm<N>>, AnyCompensator<N>, Memory<N>>;

impl<const N: usize> Own<N> {
    fn turn<'a>(&'a mut self, tracker: &'a mut Tracker<N>) -> Guarding<'a, N> {
        let Tracker { controller, state, .. } = tracker;
        Turn { guard: &self.parameters, memory: &mut self.memory, controller, state }
    }

    /// The tracker of as many joints.
    fn of<'a>(&self, trackers: &'a mut Trackers) -> PyResult<&'a mut Tracker<N>> {
        let inner = each!(trackers, Trackers, it => (&mut **it as &mut dyn Type).downcast_mut());
        inner.ok_or_else(other_tracker)
    }

    /// Of a run, on top of a tracker.
    pub fn of_run(guards: &mut Guards) -> Option<(&GuardParameters<N>, &mut GuardMemory<N>)> {
        let own: Option<&mut Self> =
            each!(guards, Guards, own => (&mut **own as &mut dyn Type).downcast_mut());
        own.map(|own| (&own.parameters, &mut own.memory))
    }

    /// What is sent, with what it was.
    fn sent(&mut self, tracker: &mut Tracker<N>, guarded: Guarded<N>) -> Vector<N> {
        (self.latest, tracker.latest) = (guarded.events, guarded.command.or(tracker.latest));
        guarded.tau
    }
}

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
/// period: nominal period of the loop [s], 1e-9 to 1.
/// position_limits: (n, 2) [rad]; outside, the guard stops. None: the nominal arm's.
/// velocity_limit: [rad/s], scalar or (n,). Faster, the guard stops; a position that moved farther
///     than that since the last sample is not used. None: the nominal arm's.
/// effort_limit: [N·m], scalar or (n,). None: the nominal arm's.
/// effort_rate_limit: [N·m/s], scalar or (n,); None for no limit.
/// power_limit: of τ·q̇ that a joint gives to the arm [W], scalar or (n,); None for no limit.
/// envelope: of the tracking error [rad], scalar or (n,); outside, the guard stops. None: no limit.
/// slack: what a position may change beyond its speed limit [rad], such as an encoder's step.
/// hold, decay: periods without a good sample in which the torque is held, and in which it decays.
/// stiffness, damping: of the brake [N·m/rad, N·m·s/rad], scalar or (n,). None: those of a double
///     pole at -min(0.1 / period, 20) 1/s for the inertias of the nominal arm at q = 0.
/// deceleration: of the brake [rad/s²], scalar or (n,).
/// last_tau: the torque that is on the robot at take-over [N·m], scalar or (n,); None: the one that
///     carries the arm at the first good sample.
///
/// Raises
/// ------
/// ValueError, TypeError
///     Naming the parameter.
#[pyclass(name = "Guard", module = "steadyarm")]
pub(super) struct PyGuard {
    pub tracker: Py<PyComputedTorque>,
    pub guards: Guards,
}

impl PyGuard {
    /// A copy for a run, which leaves the guard as it is.
    pub fn twin(&self) -> Guards {
        each!(&self.guards, Guards, own => Own::clone(own).into())
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
    #[pyo3(signature = (tracker, period, *, position_limits=None, velocity_limit=None,
        effort_limit=None, effort_rate_limit=None, power_limit=None, envelope=None, slack=None,
        hold=None, decay=None, stiffness=None, damping=None, deceleration=None, last_tau=None))]
    #[expect(clippy::too_many_arguments, reason = "a Python method")]
    fn new(
        tracker: Any<'_, '_>,
        period: Any<'_, '_>,
        position_limits: Given<'_, '_>,
        velocity_limit: Given<'_, '_>,
        effort_limit: Given<'_, '_>,
        effort_rate_limit: Given<'_, '_>,
        power_limit: Given<'_, '_>,
        envelope: Given<'_, '_>,
        slack: Given<'_, '_>,
        hold: Given<'_, '_>,
        decay: Given<'_, '_>,
        stiffness: Given<'_, '_>,
        damping: Given<'_, '_>,
        deceleration: Given<'_, '_>,
        last_tau: Given<'_, '_>,
    ) -> PyResult<Self> {
        let periods = |value: Given<'_, '_>, name| {
            let count = value.map_or(Ok(20), |value| count(value, name, 0))?;
            Ok::<u32, PyErr>(u32::try_from(count).unwrap_or(u32::MAX))
        };
        let (hold, decay) = (periods(hold, "hold")?, periods(decay, "decay")?);
        let tracker = object::<PyComputedTorque>(tracker, "tracker", "a ComputedTorque")?;
        let arguments = Arguments {
            period: scalar(period, "period")?,
            position_limits,
            velocity_limit,
            effort_limit,
            effort_rate_limit,
            power_limit,
            envelope,
            slack,
            hold,
            decay,
            stiffness,
            damping,
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
    /// ``applied``: the torque that the drive let through since then [N·m], (n,), if it says so.
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
            let elapsed = scalar_or(elapsed, own.parameters.period, "elapsed")?;
            let applied = applied.map(|tau| vector(tau, "applied")).transpose()?;
            let seen = Seen { q, dq, desired, applied: applied.as_ref(), elapsed };
            let tracker = own.of(tracker)?;
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
    fn reset(&mut self, py: Python<'_>) -> PyResult<()> {
        let tracker = &mut self.tracker.bind(py).try_borrow_mut()?.trackers;
        each!(&mut self.guards, Guards, own => {
            own.of(tracker)?.reset(None).map_err(value_error)?;
            own.memory = GuardMemory::default();
            own.last_tau.map_or(Ok(()), |tau| own.memory.take_over(&tau)).map_err(value_error)
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

    /// In how many calls each event happened, by name.
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
    fn tracker(&self, py: Python<'_>) -> Py<PyComputedTorque> {
        self.tracker.clone_ref(py)
    }

    /// Nominal period of the loop [s].
    #[getter]
    fn period(&self) -> f64 {
        each!(&self.guards, Guards, own => own.parameters.period)
    }

    fn __repr__(&self) -> String {
        let state = self.stopped().map_or("running".into(), |why| format!("stopped: {why}"));
        format!("Guard(period={:?}, {state})", self.period())
    }

    // As for a plant: no `__clear__`.
    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        visit.call(&self.tracker)
    }
}

fn other_tracker() -> PyErr {
    PyTypeError::new_err("tracker: it has other joints than its guard")
}

fn words(Cause { event, joint }: Cause) -> String {
    match joint {
        Some(joint) => format!("{} of joint {}", event.name(), joint + 1),
        None => event.name().into(),
    }
}

/// A guard before its first step.
fn guard<const N: usize>(trackers: &Trackers, arguments: &Arguments<'_, '_>) -> PyResult<Guards>
where
    Guards: From<Own<N>>,
{
    let tracker =
        each!(trackers, Trackers, it => (&**it as &dyn Type).downcast_ref::<Tracker<N>>());
    let tracker = tracker
        .ok_or_else(|| PyTypeError::new_err("tracker: it has other joints than its guard"))?;
    let arm = &tracker.controller.law.arm;
    let none = [f64::INFINITY; N];
    let own = |limit: fn(&Serial<N>) -> [f64; N]| arm.chain().map_or(none, limit);
    let limit = |value: Given<'_, '_>, name, otherwise| {
        value.map_or(Ok(otherwise), |value| joints::<N>(value, name))
    };
    let defaults = GuardParameters::new(arguments.period, brake(arm, arguments)?);
    let position_limits = match arguments.position_limits {
        Some(value) => pairs(value, "position_limits")?,
        None => arm.chain().map_or(defaults.position_limits, Serial::position_limits),
    };
    let parameters = GuardParameters {
        position_limits,
        velocity_limit: limit(
            arguments.velocity_limit,
            "velocity_limit",
            own(Serial::velocity_limit),
        )?,
        effort_limit: limit(arguments.effort_limit, "effort_limit", own(Serial::effort_limit))?,
        effort_rate_limit: limit(arguments.effort_rate_limit, "effort_rate_limit", none)?,
        power_limit: limit(arguments.power_limit, "power_limit", none)?,
        envelope: limit(arguments.envelope, "envelope", none)?,
        slack: limit(arguments.slack, "slack", [0.0; N])?,
        hold: arguments.hold,
        decay: arguments.decay,
        ..defaults
    };
    let short = |error: Error| {
        let name = error.parameter();
        value_error(error.named(name.strip_prefix("brake.").unwrap_or(name)))
    };
    parameters.validate().map_err(short)?;
    let last_tau = arguments.last_tau.map(|tau| joints(tau, "last_tau").map(Vector::from));
    let last_tau = last_tau.transpose()?;
    let mut memory = GuardMemory::default();
    last_tau.map_or(Ok(()), |tau| memory.take_over(&tau)).map_err(value_error)?;
    Ok(Own { parameters, memory, last_tau, latest: Events::default() }.into())
}

/// (n, 2), infinite for no limit.
fn pairs<const N: usize>(value: Any<'_, '_>, name: &str) -> PyResult<[[f64; 2]; N]> {
    let Numbers { shape, values } = numbers(value, name)?;
    if shape != [N, 2] {
        return Err(wrong_shape(name, &shape, &format!("({N}, 2)")));
    }
    Ok(core::array::from_fn(|n| [values[2 * n], values[2 * n + 1]]))
}

fn brake<const N: usize>(arm: &AnyArm<N>, arguments: &Arguments<'_, '_>) -> PyResult<Brake<N>> {
    let mass = arm.mass_matrix(&Vector::zeros());
    let rate = FASTEST_BRAKE.min(BRAKE_RATE / arguments.period);
    let or = |value: Given<'_, '_>, name, otherwise: f64, power: i32| match value {
        Some(value) => joints::<N>(value, name),
        None => Ok(core::array::from_fn(|n| otherwise * mass[(n, n)] * rate.powi(power))),
    };
    let deceleration =
        arguments.deceleration.map_or(Ok([10.0; N]), |value| joints(value, "deceleration"))?;
    Ok(Brake {
        stiffness: or(arguments.stiffness, "stiffness", 1.0, 2)?,
        damping: or(arguments.damping, "damping", 2.0, 1)?,
        deceleration,
    })
}

//! A guard with its memory, of any joint count: what `Guard` holds.

use core::any::Any as Type;

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;

use super::any_law::AnyLaw;
use super::compensator::{AnyCompensator, Memory};
use super::convert::{Any, Given, Numbers, joints, numbers, wrong_shape};
use super::dispatch::{by_joints, each};
use super::errors::value_error;
use super::tracked::{Tracker, Trackers};
use crate::arm::Serial;
use crate::control::{Brake, Command, Events, GuardMemory, GuardParameters, Guarded, Turn};
use crate::error::{Error, Result};
use crate::math::Vector;

/// Bandwidth of the brake in radians a period, and at most [rad/s].
const BRAKE_RATE: f64 = 0.1;
const FASTEST_BRAKE: f64 = 20.0;

/// A guard of `N` joints.
#[derive(Clone)]
pub(super) struct Own<const N: usize> {
    pub parameters: GuardParameters<N>,
    pub memory: GuardMemory<N>,
    /// The torque at take-over that it was made with.
    pub last_tau: Option<Vector<N>>,
    pub latest: Events,
}

by_joints! {
    /// A guard of any joint count.
    Guards of Own
}

/// Arguments of the class that depend on the joint count.
pub(super) struct Arguments<'a, 'py> {
    pub control_period: f64,
    pub position_limits: Given<'a, 'py>,
    pub velocity_limit: Given<'a, 'py>,
    pub effort_limit: Given<'a, 'py>,
    pub effort_rate_limit: Given<'a, 'py>,
    pub power_limit: Given<'a, 'py>,
    pub envelope: Given<'a, 'py>,
    pub slack: Given<'a, 'py>,
    pub hold: u32,
    pub decay: u32,
    pub bandwidth: Given<'a, 'py>,
    pub deceleration: Given<'a, 'py>,
    pub last_tau: Given<'a, 'py>,
}

type Guarding<'a, const N: usize> = Turn<'a, N, AnyLaw<N>, AnyCompensator<N>, Memory<N>>;

impl<const N: usize> Own<N> {
    pub fn turn<'a>(&'a mut self, tracker: &'a mut Tracker<N>) -> Guarding<'a, N> {
        let Tracker { controller, state, .. } = tracker;
        Turn { guard: &self.parameters, memory: &mut self.memory, controller, state }
    }

    /// The tracker of as many joints.
    pub fn of<'a>(&self, trackers: &'a mut Trackers) -> PyResult<&'a mut Tracker<N>> {
        let inner = each!(trackers, Trackers, it => (&mut **it as &mut dyn Type).downcast_mut());
        inner.ok_or_else(other_tracker)
    }

    /// Of a run, on top of a tracker.
    pub fn of_run(guards: &mut Guards) -> Option<(&GuardParameters<N>, &mut GuardMemory<N>)> {
        let own: Option<&mut Self> =
            each!(guards, Guards, own => (&mut **own as &mut dyn Type).downcast_mut());
        own.map(|own| (&own.parameters, &mut own.memory))
    }

    /// Before the first sample. It takes over at this torque; `None`: at the one that it was made
    /// with, or else at what its tracker commanded last.
    pub fn begin(&mut self, tracker: &Tracker<N>, last_tau: Option<Vector<N>>) -> Result<()> {
        let mut memory = GuardMemory::new(tracker.state.last_tau);
        last_tau.or(self.last_tau).map_or(Ok(()), |tau| memory.take_over(&tau))?;
        (self.memory, self.latest) = (memory, Events::default());
        Ok(())
    }

    /// What is sent, with what it was.
    pub fn sent(&mut self, tracker: &mut Tracker<N>, guarded: Guarded<N>) -> Vector<N> {
        let Guarded { tau, command, events } = guarded;
        self.latest = events;
        if let Some(command) = command {
            let limited = command.applied(&tau).limited();
            tracker.latest = Some(Command { tau, limited, ..command });
        }
        tau
    }
}

/// A guard before its first step.
pub(super) fn guard<const N: usize>(
    trackers: &Trackers,
    arguments: &Arguments<'_, '_>,
) -> PyResult<Guards>
where
    Guards: From<Own<N>>,
{
    let tracker =
        each!(trackers, Trackers, it => (&**it as &dyn Type).downcast_ref::<Tracker<N>>());
    let tracker = tracker
        .ok_or_else(|| PyTypeError::new_err("tracker: it has other joints than its guard"))?;
    let arm = tracker.controller.law.arm();
    let none = [f64::INFINITY; N];
    let own = |limit: fn(&Serial<N>) -> [f64; N]| arm.chain().map_or(none, limit);
    let limit = |value: Given<'_, '_>, name, otherwise| {
        value.map_or(Ok(otherwise), |value| joints::<N>(value, name))
    };
    let defaults = GuardParameters::new(arguments.control_period, brake(arguments)?);
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
    let memory = GuardMemory::default();
    let mut own = Own { parameters, memory, last_tau, latest: Events::default() };
    own.begin(tracker, None).map_err(value_error)?;
    Ok(own.into())
}

/// (n, 2), infinite for no limit.
fn pairs<const N: usize>(value: Any<'_, '_>, name: &str) -> PyResult<[[f64; 2]; N]> {
    let Numbers { shape, values } = numbers(value, name)?;
    if shape != [N, 2] {
        return Err(wrong_shape(name, &shape, &format!("({N}, 2)")));
    }
    Ok(core::array::from_fn(|n| [values[2 * n], values[2 * n + 1]]))
}

fn brake<const N: usize>(arguments: &Arguments<'_, '_>) -> PyResult<Brake<N>> {
    let fastest = FASTEST_BRAKE.min(BRAKE_RATE / arguments.control_period);
    let or = |value: Given<'_, '_>, name, otherwise: f64| {
        value.map_or(Ok([otherwise; N]), |value| joints::<N>(value, name))
    };
    Ok(Brake {
        bandwidth: or(arguments.bandwidth, "bandwidth", fastest)?,
        deceleration: or(arguments.deceleration, "deceleration", 10.0)?,
    })
}

fn other_tracker() -> PyErr {
    PyTypeError::new_err("tracker: it has other joints than its guard")
}

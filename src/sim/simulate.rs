//! One call for a whole run.

use core::ops::ControlFlow;

use super::affected::CHANNELS;
use super::closed_loop::ClosedLoop;
use super::continuous::{dp54, rk4};
use super::integrators::Motion;
use super::options::{Method, Options};
use super::recorder::Recorder;
use super::run::Run;
use super::sampled::{Guarding, Sampled};
use crate::arm::Arm;
use crate::control::{Compensator, Controller, Front, Guard, GuardState, Law, State};
use crate::error::{Error, Result, within};
use crate::plant::{Disturbance, Plant};
use crate::reference::Reference;

/// How far two periods that are meant to be the same may differ, relative.
const SAME_PERIOD: f64 = 1e-9;

/// Simulates the closed loop and records it.
///
/// `state` is the controller's and ends as the run left it, its last period included. A sampled
/// controller is told what the plant's actuators let through. `monitor` is told the time \[s\]
/// before every step and may break the run off. A run that cannot go on ends early. Its
/// [`Status`](super::Status) says when and why; what was recorded so far is returned.
///
/// # Errors
/// The name of an option that makes no sense; see [`Options`]. `effort_rate_limit`: set, but the
/// controller acts in continuous time, where no step bounds the change. `record_every`: the record
/// would take more than [`MAX_RECORD_BYTES`](super::MAX_RECORD_BYTES), or than memory has.
/// `channels`: a signal of the compensator's own has the name of another.
pub fn simulate<const N: usize, A, D, L, C, R, S>(
    plant: &Plant<N, A, D>,
    controller: &Controller<N, L, C>,
    state: &mut State<N, S>,
    reference: &R,
    options: &Options<N>,
    mut monitor: impl FnMut(f64) -> ControlFlow<()>,
) -> Result<Run<N>>
where
    A: Arm<N>,
    D: Disturbance<N>,
    L: Law<N>,
    C: Compensator<N, S>,
    R: Reference<N>,
{
    simulate_by((plant, controller, reference), state, None, options, &mut monitor)
}

/// The same of a loop whose sampled controller is guarded. The controller asks at the guard's
/// period; what the guard does is in its state.
///
/// # Errors
/// As [`simulate`]. `control_period`: not the guard's period.
pub fn simulate_guarded<const N: usize, A, D, L, C, R, S>(
    plant: &Plant<N, A, D>,
    guard: &Guard<N, L, C>,
    state: &mut GuardState<N, S>,
    reference: &R,
    options: &Options<N>,
    mut monitor: impl FnMut(f64) -> ControlFlow<()>,
) -> Result<Run<N>>
where
    A: Arm<N>,
    D: Disturbance<N>,
    L: Law<N>,
    C: Compensator<N, S>,
    R: Reference<N>,
{
    let GuardState { controller: state, guard: memory } = state;
    let guarding = Some((guard.parameters(), memory));
    simulate_by((plant, &guard.controller, reference), state, guarding, options, &mut monitor)
}

/// Either of them. The monitor is behind a pointer: the loops are compiled once, whoever watches.
pub(crate) fn simulate_by<const N: usize, A, D, L, C, R, S>(
    (plant, controller, reference): (&Plant<N, A, D>, &Controller<N, L, C>, &R),
    state: &mut State<N, S>,
    guarding: Guarding<'_, N>,
    options: &Options<N>,
    monitor: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<Run<N>>
where
    A: Arm<N>,
    D: Disturbance<N>,
    L: Law<N>,
    C: Compensator<N, S>,
    R: Reference<N>,
{
    if let Some((guard, _)) = &guarding {
        let same = |period: f64| (period / guard.control_period - 1.0).abs() < SAME_PERIOD;
        let wanted = "the period of the guard; a guarded controller is a sampled one";
        let period = options.control_period;
        let period = period.ok_or_else(|| Error::not_given("control_period", wanted))?;
        within("control_period", &[period], same, wanted)?;
    }
    let (steps, hold) = options.steps()?;
    let start = Motion { q: options.q0.into(), dq: options.dq0.into() };
    if options.control_period.is_none() {
        check_unlimited_rate(&controller.limits.effort_rate_limit)?;
        check_continuous(plant, controller, options)?;
    }
    let affected = options.effects.is_on() || plant.changes();
    let of_effects = if affected { CHANNELS } else { &[] };
    let own = [controller.compensator.channels(), of_effects].concat();
    let record = Recorder::new(steps, options, &own)?;
    let system = ClosedLoop::new(plant, controller, reference);
    Ok(match (options.control_period, options.method) {
        (None, Method::Rk4) => rk4(system, controller.settle(state), start, record, monitor),
        (None, Method::Dp54(tolerance)) => {
            dp54(system, controller.settle(state), start, record, tolerance, monitor)
        }
        (Some(_), _) => {
            let (method, dt) = (options.method, options.dt);
            let sampled = Sampled { plant, controller, reference, hold, dt, method };
            if affected {
                sampled.run_affected(&options.effects, state, start, record, monitor, guarding)
            } else {
                sampled.run(state, start, record, monitor, guarding)
            }
        }
    })
}

/// Refuses in continuous time what works from sample to sample.
fn check_continuous<const N: usize, A, D, L, C, S>(
    plant: &Plant<N, A, D>,
    controller: &Controller<N, L, C>,
    options: &Options<N>,
) -> Result<()>
where
    A: Arm<N>,
    D: Disturbance<N>,
    L: Law<N>,
    C: Compensator<N, S>,
{
    let found = [
        (
            controller.compensator.sampled_only(),
            "a period: the controller works from sample to sample",
        ),
        (
            controller.front != Front::default(),
            "a period: hand-over, velocity filter, bumpless \
          start and delay of a controller are those of a sampled one",
        ),
        (
            options.effects.is_on(),
            "a period: sensors, timing and actuators are those of a sampled \
          controller",
        ),
        (plant.changes(), "a period: a plant that changes needs a sampled controller"),
    ];
    match found.iter().find(|(is, _)| *is) {
        Some((_, wanted)) => Err(Error::not_given("control_period", wanted)),
        None => Ok(()),
    }
}

fn check_unlimited_rate(limit: &[f64]) -> Result<()> {
    let Some(index) = limit.iter().position(|limit| limit.is_finite()) else { return Ok(()) };
    let wanted = "no rate limit in continuous time; set control_period";
    Err(Error::out_of_range("effort_rate_limit", limit[index], wanted).at(index))
}

//! The controller in continuous time: it acts at every stage of the integrator.

use core::ops::ControlFlow;

use super::adaptive::{Accepted, attempt, attempt_stiff};
use super::certificate::Certificate;
use super::closed_loop::{ClosedLoop, Start};
use super::evaluation::Evaluation;
use super::integrators::{DP54, Dense, Motion, RK4, Tolerance, dp54_dense};
use super::recorder::Recorder;
use super::run::Run;
use super::status::Cause;
use crate::arm::Arm;
use crate::control::{Compensator, Law, MAX_STAGES, Stage};
use crate::math::{Vector, part};
use crate::plant::Disturbance;
use crate::reference::Reference;

/// The last stage of Dormand-Prince, at the end of the step: the first of the next one.
const LAST: usize = 6;

/// RK4 with a fixed step; a row a step.
pub(super) fn rk4<const N: usize, A, D, L, C, R, S>(
    mut system: ClosedLoop<'_, N, A, D, L, C, R>,
    state: &mut S,
    mut motion: Motion<N>,
    mut record: Recorder<N>,
    mut monitor: impl FnMut(f64) -> ControlFlow<()>,
) -> Run<N>
where
    A: Arm<N>,
    D: Disturbance<N>,
    L: Law<N>,
    C: Compensator<N, S>,
    R: Reference<N>,
{
    let (h, own) = (record.dt, &system.controller.compensator);
    let mut certificate = Certificate::default();
    for k in 0..=record.steps {
        let t = record.time(k);
        let (at, start) = system.begin(state, h, t, &motion);
        system.settle(&at, h, &mut certificate);
        if !record.check(&at) {
            break;
        }
        record.take(k, &at, |row| own.signals(state, &at.sample, row));
        record.confirm(&mut certificate, &at);
        if k == record.steps {
            break;
        }
        if monitor(t).is_break() {
            record.interrupted(t);
            break;
        }
        match system.finish(state, (t, h, record.time(k + 1)), &motion, &start) {
            Ok(moved) => {
                record.resolve(t, &motion, &moved);
                motion = moved.motion;
            }
            Err(error) => {
                record.diverged(t, blame(system.lost_reference(), Cause::Rejected(error)));
                break;
            }
        }
        system.certify_step(h, &mut certificate);
    }
    record.finish()
}

/// Dormand-Prince with error control; the rows come from its dense output.
pub(super) fn dp54<const N: usize, A, D, L, C, R, S>(
    mut system: ClosedLoop<'_, N, A, D, L, C, R>,
    state: &mut S,
    mut motion: Motion<N>,
    mut record: Recorder<N>,
    tolerance: Tolerance,
    mut monitor: impl FnMut(f64) -> ControlFlow<()>,
) -> Run<N>
where
    A: Arm<N>,
    D: Disturbance<N>,
    L: Law<N>,
    C: Compensator<N, S>,
    R: Reference<N>,
{
    let (end, own) = (record.time(record.steps), &system.controller.compensator);
    let mut certificate = Certificate::default();
    let (mut t, mut h, mut row, mut carried) = (0.0, record.dt, 0, None);
    let mut last_h = h;
    loop {
        let start = carried.unwrap_or_else(|| system.start(state, h, t, &motion));
        let Some(at) = system.evaluation().copied() else { break };
        system.settle(&at, last_h, &mut certificate);
        if !record.check(&at) {
            break;
        }
        if row <= record.steps && record.time(row) == t {
            record.take(row, &at, |row| own.signals(state, &at.sample, row));
            row += 1;
        }
        record.confirm(&mut certificate, &at);
        if t >= end {
            break;
        }
        if monitor(t).is_break() {
            record.interrupted(t);
            break;
        }
        let here = (t, h, end);
        let accepted = if start.is_stiff() {
            by_stiff_steps(
                &mut system,
                state,
                &motion,
                &start,
                (t, h),
                (&record, &mut row),
                tolerance,
            )
        } else {
            by_dp54(&mut system, state, &motion, &start, here, (&mut record, &mut row), tolerance)
        };
        let Some((step, ddq)) = accepted else {
            record.diverged(t, blame(system.lost_reference(), Cause::StepTooShort));
            break;
        };
        let advanced = if start.is_stiff() {
            system.certify_step(step.h, &mut certificate);
            system.advance(state, &RK4.end(step.h, 4))
        } else {
            system.certify(&DP54, step.h, &mut certificate);
            system.advance(state, &DP54.end(step.h, LAST))
        };
        if let Err(error) = advanced {
            record.diverged(t, Cause::Rejected(error));
            break;
        }
        (motion, t, h, last_h) = (step.motion, step.end, step.next_h, step.h);
        carried = system.carry(state, LAST, ddq);
    }
    record.finish()
}

/// A step of Dormand-Prince from `t`, first tried with the length `h`. Records the rows within it,
/// and gives q̈ at its end. `None` if no step met the tolerance.
fn by_dp54<const N: usize, A, D, L, C, R, S>(
    system: &mut ClosedLoop<'_, N, A, D, L, C, R>,
    state: &mut S,
    motion: &Motion<N>,
    start: &Start<N>,
    (t, h, end): (f64, f64, f64),
    (record, row): (&mut Recorder<N>, &mut usize),
    tolerance: Tolerance,
) -> Option<(Accepted<N>, Vector<N>)>
where
    A: Arm<N>,
    D: Disturbance<N>,
    L: Law<N>,
    C: Compensator<N, S>,
    R: Reference<N>,
{
    let mut rates = [Motion::zeros(); 7];
    rates[0] = Motion { q: motion.dq, dq: start.ddq };
    let step = attempt((t, h, end), motion, &mut rates, tolerance, |stage, time, at| {
        if stage.index == LAST {
            system.acceleration(state, stage, time, at)
        } else {
            system.rate(state, stage, time, at)
        }
    })?;
    let between = Dense::new(step.h, motion, &rates);
    while *row <= record.steps && record.time(*row) <= step.end {
        if record.due(*row) {
            let time = record.time(*row);
            let theta = (time - t) / step.h;
            let at = between.at(theta);
            if record.wants_all() {
                let at = dense(system, state, (time, step.h, theta), &at);
                record.take_between(&at, |row| {
                    system.controller.compensator.signals(state, &at.sample, row);
                });
            } else {
                record.take_motion(time, &at);
            }
        }
        *row += 1;
    }
    Some((step, rates[LAST].dq))
}

/// A step with friction solved for, up to the next row.
fn by_stiff_steps<const N: usize, A, D, L, C, R, S>(
    system: &mut ClosedLoop<'_, N, A, D, L, C, R>,
    state: &mut S,
    motion: &Motion<N>,
    start: &Start<N>,
    (t, h): (f64, f64),
    (record, row): (&Recorder<N>, &mut usize),
    tolerance: Tolerance,
) -> Option<(Accepted<N>, Vector<N>)>
where
    A: Arm<N>,
    D: Disturbance<N>,
    L: Law<N>,
    C: Compensator<N, S>,
    R: Reference<N>,
{
    while !record.due(*row) {
        *row += 1;
    }
    let step = attempt_stiff((t, h, record.time(*row)), motion, tolerance, |h, end| {
        system.attempt(state, (t, h, end), motion, start)
    })?;
    Some((step, start.ddq))
}

/// Why the run cannot go on: the last set-point if that is NaN or infinite, or else `cause`.
fn blame(lost_reference: bool, cause: Cause) -> Cause {
    if lost_reference { Cause::Reference } else { cause }
}

/// Evaluates the loop inside the step that was just taken, at time `t`, θ h after its start. This
/// evaluation takes the place of the last stage.
fn dense<const N: usize, A, D, L, C, R, S>(
    system: &mut ClosedLoop<'_, N, A, D, L, C, R>,
    state: &mut S,
    (t, h, theta): (f64, f64, f64),
    motion: &Motion<N>,
) -> Evaluation<N>
where
    A: Arm<N>,
    D: Disturbance<N>,
    L: Law<N>,
    C: Compensator<N, S>,
    R: Reference<N>,
{
    let coefficients = dp54_dense(theta);
    let (index, nodes) = (MAX_STAGES - 1, &DP54.nodes[..]);
    let stage = Stage { index, step: h, node: theta, coefficients: &coefficients, nodes };
    part::<N, _>(|| system.evaluate(state, &stage, t, motion).0)
}

//! The controller in continuous time: it acts at every stage of the integrator.

use core::ops::ControlFlow;

use super::adaptive::attempt;
use super::certificate::Certificate;
use super::closed_loop::{ClosedLoop, Evaluation};
use super::integrators::{DP54, Dense, Motion, RK4, Tolerance, dp54_dense};
use super::recorder::Recorder;
use super::run::{Cause, Run, Status};
use crate::arm::Arm;
use crate::control::{Compensator, MAX_STAGES, Stage};
use crate::plant::Disturbance;
use crate::reference::Reference;

/// The last stage of Dormand-Prince, at the end of the step: the first of the next one.
const LAST: usize = 6;

/// RK4 with a fixed step; a row a step.
pub(super) fn rk4<const N: usize, A, D, B, C, R, S>(
    mut system: ClosedLoop<'_, N, A, D, B, C, R>,
    state: &mut S,
    mut motion: Motion<N>,
    mut record: Recorder<N>,
    mut monitor: impl FnMut(f64) -> ControlFlow<()>,
) -> Run<N>
where
    A: Arm<N>,
    D: Disturbance<N>,
    B: Arm<N>,
    C: Compensator<N, S>,
    R: Reference<N>,
{
    let h = record.dt;
    let mut certificate = Certificate::default();
    let mut rates = [Motion::zeros(); 4];
    for k in 0..=record.steps {
        let t = record.time(k);
        let (at, ddq) = system.evaluate(state, &RK4.stage(0, h), t, &motion);
        rates[0] = Motion { q: motion.dq, dq: ddq };
        if !record.check(&at) {
            break;
        }
        record.take(k, &at);
        record.confirm(&mut certificate, &at);
        if k == record.steps {
            break;
        }
        if monitor(t).is_break() {
            record.stop(Status::Interrupted { t });
            break;
        }
        match system.finish_rk4(state, (t, h, record.time(k + 1)), &motion, &mut rates) {
            Ok(next) => motion = next,
            Err(error) => {
                let cause = blame(system.lost_reference(), Cause::Rejected(error));
                record.stop(Status::Diverged { t, cause });
                break;
            }
        }
        system.certify(&RK4, h, &mut certificate);
    }
    record.finish()
}

/// Dormand-Prince with error control; the rows come from its dense output.
pub(super) fn dp54<const N: usize, A, D, B, C, R, S>(
    mut system: ClosedLoop<'_, N, A, D, B, C, R>,
    state: &mut S,
    mut motion: Motion<N>,
    mut record: Recorder<N>,
    tolerance: Tolerance,
    mut monitor: impl FnMut(f64) -> ControlFlow<()>,
) -> Run<N>
where
    A: Arm<N>,
    D: Disturbance<N>,
    B: Arm<N>,
    C: Compensator<N, S>,
    R: Reference<N>,
{
    let end = record.time(record.steps);
    let mut certificate = Certificate::default();
    let mut rates = [Motion::zeros(); 7];
    let (mut t, mut h, mut row, mut carried) = (0.0, record.dt, 0, false);
    loop {
        if !carried {
            let ddq = system.acceleration(state, &DP54.stage(0, h), t, &motion);
            rates[0] = Motion { q: motion.dq, dq: ddq };
        }
        if let Some(at) = system.evaluation() {
            if !record.check(at) {
                break;
            }
            if row == 0 {
                record.take(row, at);
                row = 1;
            }
            record.confirm(&mut certificate, at);
        }
        if t >= end {
            break;
        }
        if monitor(t).is_break() {
            record.stop(Status::Interrupted { t });
            break;
        }
        let accepted = attempt((t, h, end), &motion, &mut rates, tolerance, |stage, time, at| {
            if stage.index == LAST {
                system.acceleration(state, stage, time, at)
            } else {
                system.rate(state, stage, time, at)
            }
        });
        let Some(step) = accepted else {
            let cause = blame(system.lost_reference(), Cause::StepTooShort);
            record.stop(Status::Diverged { t, cause });
            break;
        };
        let between = Dense::new(step.h, &motion, &rates);
        while row <= record.steps && record.time(row) <= step.end {
            if record.due(row) {
                let time = record.time(row);
                let theta = (time - t) / step.h;
                let at = between.at(theta);
                if record.wants_all() {
                    record.take_between(&dense(&mut system, state, (time, step.h, theta), &at));
                } else {
                    record.take_motion(time, &at);
                }
            }
            row += 1;
        }
        system.certify(&DP54, step.h, &mut certificate);
        if let Err(error) = system.advance(state, &DP54.end(step.h, LAST)) {
            record.stop(Status::Diverged { t, cause: Cause::Rejected(error) });
            break;
        }
        (motion, t, h) = (step.motion, step.end, step.next_h);
        rates[0] = rates[LAST];
        carried = system.carry(state, LAST);
    }
    record.finish()
}

/// Why the run cannot go on: the set-point of the stage evaluated last if that is no number, or else `cause`.
fn blame(lost_reference: bool, cause: Cause) -> Cause {
    if lost_reference { Cause::Reference } else { cause }
}

/// Evaluates the loop inside the step that was just taken, at time `t`, θ h after its start, in the place of the last stage.
fn dense<const N: usize, A, D, B, C, R, S>(
    system: &mut ClosedLoop<'_, N, A, D, B, C, R>,
    state: &mut S,
    (t, h, theta): (f64, f64, f64),
    motion: &Motion<N>,
) -> Evaluation<N>
where
    A: Arm<N>,
    D: Disturbance<N>,
    B: Arm<N>,
    C: Compensator<N, S>,
    R: Reference<N>,
{
    let coefficients = dp54_dense(theta);
    let (index, nodes) = (MAX_STAGES - 1, &DP54.nodes[..]);
    let stage = Stage { index, step: h, node: theta, coefficients: &coefficients, nodes };
    system.evaluate(state, &stage, t, motion).0
}

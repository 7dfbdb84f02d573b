//! Sampled control: the controller steps once a period and its torque is held while the plant moves on.

use core::ops::ControlFlow;

use super::adaptive::attempt;
use super::closed_loop::Evaluation;
use super::integrators::{Motion, RK4};
use super::options::Method;
use super::recorder::Recorder;
use super::run::{Cause, Run, Status};
use crate::arm::Arm;
use crate::control::{Audit, Command, Compensator, ComputedTorque, Sample, State};
use crate::error::{Error, Result};
use crate::math::Vector;
use crate::plant::{Disturbance, Plant};
use crate::reference::Reference;

/// The plant under a held torque: one step of RK4 of length `h` [s] from time `t`.
pub fn hold_torque<const N: usize, A: Arm<N>, D: Disturbance<N>>(
    plant: &Plant<N, A, D>,
    motion: &Motion<N>,
    tau: &Vector<N>,
    t: f64,
    h: f64,
) -> Motion<N> {
    let applied = plant.applied(tau);
    let mut rates = [Motion::zeros(); 4];
    RK4.stages(h, motion, 0, &mut rates, |stage, at| {
        plant.acceleration(&at.q, &at.dq, &applied, t + stage.node * h)
    });
    motion.plus(h, &RK4.weights, &rates)
}

/// Plant, sampled controller and reference.
pub(super) struct Sampled<'a, const N: usize, A, D, B, C, R> {
    pub plant: &'a Plant<N, A, D>,
    pub controller: &'a ComputedTorque<N, B, C>,
    pub reference: &'a R,
    /// Rows in a control period.
    pub hold: usize,
    pub method: Method,
}

impl<const N: usize, A, D, B, C, R> Sampled<'_, N, A, D, B, C, R>
where
    A: Arm<N>,
    D: Disturbance<N>,
    B: Arm<N>,
    R: Reference<N>,
{
    /// The loop that a user would write: step the controller, hold its torque.
    pub fn run<S>(
        &self,
        state: &mut State<N, S>,
        mut motion: Motion<N>,
        mut record: Recorder<N>,
        mut monitor: impl FnMut(f64) -> ControlFlow<()>,
    ) -> Run<N>
    where
        C: Compensator<N, S>,
    {
        let period = self.hold as f64 * record.dt;
        let mut held = None;
        for k in 0..=record.steps {
            let t = record.time(k);
            let sample = self.controller.sample(&motion.q, &motion.dq, &self.reference.at(t));
            if k.is_multiple_of(self.hold) && k < record.steps || held.is_none() {
                match self.decide(state, &sample, period) {
                    Ok(decision) => held = Some(decision),
                    Err(error) => {
                        record.stop(Status::Diverged { t, cause: Cause::Rejected(error) });
                        break;
                    }
                }
            }
            let Some((command, audit)) = held else { break };
            let at = self.evaluate(t, sample, command, audit);
            if !record.check(&at) {
                break;
            }
            record.take(k, &at);
            if k == record.steps {
                break;
            }
            if monitor(t).is_break() {
                record.stop(Status::Interrupted { t });
                break;
            }
            match self.hold(&motion, &command.tau, (t, record.dt, record.time(k + 1))) {
                Ok(next) => motion = next,
                Err(cause) => {
                    record.stop(Status::Diverged { t, cause });
                    break;
                }
            }
        }
        record.finish()
    }

    fn decide<S>(
        &self,
        state: &mut State<N, S>,
        sample: &Sample<N>,
        period: f64,
    ) -> Result<(Command<N>, Option<Audit<N>>), Error>
    where
        C: Compensator<N, S>,
    {
        let Sample { q, dq, desired, .. } = sample;
        let command = self.controller.step(state, q, dq, desired, period)?;
        Ok((command, self.controller.compensator.audit(&state.compensator, 0, sample)))
    }

    fn evaluate(
        &self,
        t: f64,
        sample: Sample<N>,
        command: Command<N>,
        audit: Option<Audit<N>>,
    ) -> Evaluation<N> {
        let applied = self.plant.applied(&command.tau);
        let ddq = self.plant.acceleration(&sample.q, &sample.dq, &applied, t);
        Evaluation::new(t, sample, command, applied, &ddq, audit)
    }

    fn hold(
        &self,
        start: &Motion<N>,
        tau: &Vector<N>,
        (t, h, end): (f64, f64, f64),
    ) -> Result<Motion<N>, Cause> {
        let Method::Dp54(tolerance) = self.method else {
            return Ok(hold_torque(self.plant, start, tau, t, h));
        };
        let applied = self.plant.applied(tau);
        let (mut motion, mut t, mut h) = (*start, t, h);
        let mut rates = [Motion::zeros(); 7];
        while t < end {
            let ddq = self.plant.acceleration(&motion.q, &motion.dq, &applied, t);
            rates[0] = Motion { q: motion.dq, dq: ddq };
            let step = attempt((t, h, end), &motion, &mut rates, tolerance, |_, time, at| {
                self.plant.acceleration(&at.q, &at.dq, &applied, time)
            })
            .ok_or(Cause::StepTooShort)?;
            (motion, t, h) = (step.motion, step.end, step.next_h);
        }
        Ok(motion)
    }
}

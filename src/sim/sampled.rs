//! Sampled control: the controller steps once a period and its torque is held while the plant moves
//! on.

use core::ops::ControlFlow;

use super::evaluation::Evaluation;
use super::held::Held;
use super::integrators::Motion;
use super::options::Method;
use super::recorder::Recorder;
use super::run::Run;
use super::status::Cause;
use crate::arm::Arm;
use crate::control::{
    Audit, Command, Compensator, Controller, GuardMemory, GuardParameters, Guarded, Law, Sample,
    Seen, State, Turn,
};
use crate::error::Result;
use crate::math::{Matrix, Vector};
use crate::plant::{Disturbance, Plant};
use crate::reference::Reference;

/// What stands between the controller and the robot, if anything does.
pub(super) type Guarding<'a, const N: usize> =
    Option<(&'a GuardParameters<N>, &'a mut GuardMemory<N>)>;

/// Plant, sampled controller and reference.
pub(super) struct Sampled<'a, const N: usize, A, D, L, C, R> {
    pub plant: &'a Plant<N, A, D>,
    pub controller: &'a Controller<N, L, C>,
    pub reference: &'a R,
    /// Rows in a control period, and their spacing \[s\].
    pub hold: usize,
    pub dt: f64,
    pub method: Method,
}

impl<const N: usize, A, D, L, C, R> Sampled<'_, N, A, D, L, C, R>
where
    A: Arm<N>,
    D: Disturbance<N>,
    L: Law<N>,
    R: Reference<N>,
{
    /// The loop that a user would write: step the controller, hold its torque.
    pub fn run<S>(
        &self,
        state: &mut State<N, S>,
        mut motion: Motion<N>,
        mut record: Recorder<N>,
        mut monitor: impl FnMut(f64) -> ControlFlow<()>,
        mut guard: Guarding<'_, N>,
    ) -> Run<N>
    where
        C: Compensator<N, S>,
    {
        let period = self.hold as f64 * record.dt;
        let mut now: Option<(Command<N>, Held<'_, N, A, D>)> = None;
        for k in 0..=record.steps {
            let t = record.time(k);
            let sample = self.controller.sample(&motion.q, &motion.dq, &self.reference.at(t));
            if k.is_multiple_of(self.hold) && k < record.steps || now.is_none() {
                let before = now.as_ref().map(|(_, held)| &held.applied);
                let decided = match &mut guard {
                    None => self.decide(state, before, &sample, period, None),
                    Some((guard, memory)) => {
                        Ok(self.decide_guarded((guard, memory), state, before, &sample, period))
                    }
                };
                match decided {
                    Ok(command) => {
                        now = Some((
                            command,
                            Held::new(self.plant, t, &self.plant.applied(&command.tau)),
                        ))
                    }
                    Err(error) => {
                        record.diverged(t, Cause::Rejected(error));
                        break;
                    }
                }
            }
            let Some((command, held)) = &now else { break };
            let ddq = held.acceleration(&motion, t);
            let audit = if record.takes(k) { self.audit(state) } else { None };
            let at = Evaluation::new(t, sample, *command, held.applied, &ddq, audit);
            if !record.check(&at) {
                break;
            }
            record.take(k, &at, |row| self.signals(state, row));
            if k == record.steps {
                break;
            }
            if monitor(t).is_break() {
                record.interrupted(t);
                break;
            }
            let times = (t, record.dt, record.time(k + 1));
            match held.move_on(self.method, &mut record, (&motion, &ddq), times) {
                Some(next) => motion = next,
                None => {
                    record.diverged(t, Cause::StepTooShort);
                    break;
                }
            }
        }
        // What the last period did to the state is part of the run.
        let last = now.map(|(_, held)| held.applied);
        if let Err(error) = self.controller.end_period(state, last.as_ref()) {
            record.diverged(record.time(record.steps), Cause::Rejected(error));
        }
        record.finish()
    }

    /// Ends the period before with the torque that the actuators gave, and decides on the next. M₀
    /// and H₀ of a law that has a model may be `known`.
    #[inline(always)]
    pub(super) fn decide<S>(
        &self,
        state: &mut State<N, S>,
        applied: Option<&Vector<N>>,
        sample: &Sample<N>,
        period: f64,
        known: Option<&(Matrix<N>, Vector<N>)>,
    ) -> Result<Command<N>>
    where
        C: Compensator<N, S>,
    {
        if applied.is_some() {
            self.controller.end_period(state, applied)?;
        }
        if let Some(dynamics) = known {
            return self.controller.step_from(dynamics, state, sample, period);
        }
        let Sample { q, dq, desired, .. } = sample;
        self.controller.step(state, q, dq, desired, period)
    }

    /// The same through a guard.
    #[inline(never)]
    pub(super) fn decide_guarded<S>(
        &self,
        (guard, memory): (&GuardParameters<N>, &mut GuardMemory<N>),
        state: &mut State<N, S>,
        applied: Option<&Vector<N>>,
        Sample { q, dq, desired, .. }: &Sample<N>,
        elapsed: f64,
    ) -> Command<N>
    where
        C: Compensator<N, S>,
    {
        let mut turn = Turn { guard, memory, controller: self.controller, state };
        sent(turn.step(&Seen { q, dq, desired, applied, elapsed }))
    }

    /// What a guard sends where a sample is lost.
    pub(super) fn missed<S>(
        &self,
        (guard, memory): (&GuardParameters<N>, &mut GuardMemory<N>),
        state: &mut State<N, S>,
    ) -> Command<N>
    where
        C: Compensator<N, S>,
    {
        sent(Turn { guard, memory, controller: self.controller, state }.missed())
    }

    /// The terms of the identity at the sample that was decided on last.
    #[inline(always)]
    pub(super) fn audit<S>(&self, state: &State<N, S>) -> Option<Audit<N>>
    where
        C: Compensator<N, S>,
    {
        self.controller.compensator.audit(state.compensator(), 0, state.seen()?)
    }

    /// The compensator's own signals there.
    pub(super) fn signals<S>(&self, state: &State<N, S>, row: &mut [f64])
    where
        C: Compensator<N, S>,
    {
        if let Some(seen) = state.seen() {
            self.controller.compensator.signals(state.compensator(), seen, row);
        }
    }
}

/// What a guard sent, as a command.
fn sent<const N: usize>(Guarded { tau, command, .. }: Guarded<N>) -> Command<N> {
    let none = Vector::zeros();
    let own =
        Command { tau, model: tau, compensation: none, v: none, rho_hat: none, limited: true };
    command.map_or(own, |asked| Command {
        tau,
        limited: asked.limited || tau != asked.tau,
        ..asked
    })
}

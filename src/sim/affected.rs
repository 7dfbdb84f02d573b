//! Sampled control through sensors, timing and actuators: the loop of a real machine.
//!
//! ```text
//! row k        record what is really there
//! sample j     measured = sensors(motion)      the period before ends with what the drives told
//!              τ = step(measured)              told = limited(τ)     after `delay` samples it acts
//! ```
//!
//! Rows stand on a grid of `dt`; samples may come between them.

use core::ops::ControlFlow;

use super::evaluation::Evaluation;
use super::held::Held;
use super::integrators::Motion;
use super::options::Method;
use super::recorder::Recorder;
use super::run::Run;
use super::sampled::{Guarding, Sampled};
use super::status::Cause;
use crate::arm::Arm;
use crate::control::{
    Channel, Command, Compensator, Law, MAX_DELAY, Sample, State, Width, held_on, mean_acting,
};
use crate::effects::{Clock, Drive, Effects, Measuring, Side, Transmission};
use crate::error::Result;
use crate::math::Vector;
use crate::plant::{Disturbance, MotorState};
use crate::reference::Reference;

/// Times that are nearer than this share of a step are the same.
const SAME: f64 = 1e-6;

/// Signals of a loop with effects.
pub(super) const CHANNELS: &[Channel] = &[
    Channel {
        name: "q_measured",
        unit: "rad",
        width: Width::Joints,
        doc: "Position as the controller saw it last",
    },
    Channel {
        name: "dq_measured",
        unit: "rad/s",
        width: Width::Joints,
        doc: "Velocity as the sensors gave it last; a controller's own filter makes another",
    },
    Channel {
        name: "tau_commanded",
        unit: "N·m",
        width: Width::Joints,
        doc: "Torque that the controller sent last, before delay and drives",
    },
    Channel {
        name: "q_motor",
        unit: "rad",
        width: Width::Joints,
        doc: "Position of the motors on the link's side of their gears; that of the links without",
    },
    Channel {
        name: "tau_cogging",
        unit: "N·m",
        width: Width::Joints,
        doc: "Cogging torque, which opposes the applied one",
    },
    Channel {
        name: "sample_age",
        unit: "s",
        width: Width::One,
        doc: "Time since the controller's last sample",
    },
];

/// What stands between controller and plant, in a run.
pub(super) struct Line<const N: usize> {
    clock: Clock,
    measuring: Measuring<N>,
    pub drive: Drive<N>,
    /// Torques on their way, the latest first; the one that has waited long enough acts.
    sent: [Vector<N>; MAX_DELAY + 1],
    /// What the drives told of the last torque that was asked for, of those in the periods before,
    /// the latest first, and how many samples were lost since.
    told: Vector<N>,
    older: [Vector<N>; MAX_DELAY],
    lost: f64,
    /// The motors, where gears give.
    motors: Option<MotorState<N>>,
    /// What was measured last, and when \[s\].
    measured: [Vector<N>; 2],
    seen_at: f64,
    pub command: Option<Command<N>>,
}

/// A sample that is taken.
#[derive(Clone, Copy)]
pub(super) struct Taken<const N: usize> {
    /// What the controller sees; `None` if it is lost.
    pub sample: Option<Sample<N>>,
    /// Since the one before \[s\], which is a period before the first.
    pub elapsed: f64,
    /// What the drives told since, if this is not the first.
    pub told: Option<Vector<N>>,
}

impl<const N: usize> Line<N> {
    fn new(effects: &Effects<N>, effort_limit: [f64; N], period: f64, begun: &Vector<N>) -> Self {
        let Effects { sensors, timing, actuators, seed, .. } = *effects;
        Self {
            clock: Clock::new(timing, period, seed),
            measuring: Measuring::new(sensors, seed),
            drive: Drive::new(actuators, effort_limit, begun),
            sent: [*begun; MAX_DELAY + 1],
            told: *begun,
            older: [*begun; MAX_DELAY],
            lost: 0.0,
            motors: None,
            measured: [Vector::zeros(); 2],
            seen_at: 0.0,
            command: None,
        }
    }

    /// What the drives told of the torque that acted since the last sample, in a loop that is late
    /// by so many [N·m].
    pub(super) fn acted(&self, delay: usize) -> Vector<N> {
        if delay == 0 || self.lost == 0.0 {
            return *delay.checked_sub(1).and_then(|k| self.older.get(k)).unwrap_or(&self.told);
        }
        mean_acting(delay, self.lost, &self.told, &self.older)
    }

    /// What arrives at the links now [N·m].
    fn arrived(&self, effects: &Effects<N>, Motion { q, dq }: &Motion<N>) -> Vector<N> {
        match (&effects.transmission, &self.motors) {
            (Some(transmission), Some(motors)) => transmission.gears.gear_torque(q, dq, motors),
            _ => self.drive.arrived(),
        }
    }

    /// What the encoders see.
    fn at_encoders(&self, effects: &Effects<N>, motion: &Motion<N>) -> Motion<N> {
        match (&effects.transmission, &self.motors) {
            (Some(Transmission { encoders: Side::Motor, .. }), Some(motors)) => {
                Motion { q: motors.theta, dq: motors.dtheta }
            }
            _ => *motion,
        }
    }

    /// A row of the signals.
    fn signals(&self, effects: &Effects<N>, motion: &Motion<N>, t: f64, row: &mut [f64]) {
        let [q, dq] = &self.measured;
        let sent = self.command.as_ref().map_or(&self.sent[0], |command| &command.tau);
        let motors = self.motors.as_ref().map_or(&motion.q, |motors| &motors.theta);
        let cogging = effects.actuators.cogging_torque(&motion.q);
        let of_joints = [q, dq, sent, motors, &cogging];
        let numbers = of_joints.into_iter().flatten().copied().chain([t - self.seen_at]);
        row.iter_mut().zip(numbers).for_each(|(cell, number)| *cell = number);
    }
}

impl<const N: usize, A, D, L, C, R> Sampled<'_, N, A, D, L, C, R>
where
    A: Arm<N>,
    D: Disturbance<N>,
    L: Law<N>,
    R: Reference<N>,
{
    /// The run through effects, or of a plant that changes.
    #[inline(never)]
    pub fn run_affected<S>(
        &self,
        effects: &Effects<N>,
        state: &mut State<N, S>,
        mut motion: Motion<N>,
        mut record: Recorder<N>,
        mut monitor: impl FnMut(f64) -> ControlFlow<()>,
        mut guard: Guarding<'_, N>,
    ) -> Run<N>
    where
        C: Compensator<N, S>,
    {
        let mut line = self.line(effects, state, &motion.q);
        let own = self.controller.compensator.channels();
        let own: usize = own.iter().map(|channel| channel.width.of(N)).sum();
        line.motors = effects.transmission.map(|transmission| {
            let Motion { q, dq } = &motion;
            transmission.gears.carrying(q, dq, &self.plant.arm.gravity(q))
        });
        let mut t = 0.0;
        'rows: for k in 0..=record.steps {
            let row = record.time(k);
            loop {
                let next = line.clock.next();
                let early = next < row - SAME * record.dt;
                let due = early || k < record.steps && next <= row + SAME * record.dt;
                let end = if early { next } else { row };
                match self.glide(effects, &mut line, &mut record, motion, (t, end)) {
                    Some(next) => (motion, t) = (next, end),
                    None => {
                        record.diverged(t, Cause::StepTooShort);
                        break 'rows;
                    }
                }
                if !due {
                    break;
                }
                if let Err(error) = self.sample(effects, &mut line, state, &motion, t, &mut guard) {
                    record.diverged(t, Cause::Rejected(error));
                    break 'rows;
                }
            }
            let Some(command) = line.command else { break };
            let held = self.held(effects, &line.arrived(effects, &motion), t);
            let sample = self.controller.sample(&motion.q, &motion.dq, &self.reference.at(t));
            let audit = if record.takes(k) { self.audit(state) } else { None };
            let ddq = held.acceleration(&motion, t);
            let at = Evaluation::new(t, sample, command, line.drive.arrived(), &ddq, audit);
            if !record.check(&at) {
                break;
            }
            record.take(k, &at, |row| {
                let (compensator, own_row) = row.split_at_mut(own);
                self.signals(state, compensator);
                line.signals(effects, &motion, t, own_row);
            });
            if k < record.steps && monitor(t).is_break() {
                record.interrupted(t);
                break;
            }
        }
        if let Err(error) = self.end_affected(&line, state) {
            record.diverged(record.time(record.steps), Cause::Rejected(error));
        }
        record.finish()
    }

    /// What stands between controller and plant at the start of a run.
    pub(super) fn line<S>(
        &self,
        effects: &Effects<N>,
        state: &State<N, S>,
        q: &Vector<N>,
    ) -> Line<N> {
        let begun = state.last_tau.unwrap_or_else(|| self.controller.law.resting_torque(q));
        let (period, begun) = (self.hold as f64 * self.dt, self.plant.applied(&begun));
        Line::new(effects, *self.plant.effort_limit(), period, &begun)
    }

    /// Ends the last period.
    pub(super) fn end_affected<S>(&self, line: &Line<N>, state: &mut State<N, S>) -> Result<()>
    where
        C: Compensator<N, S>,
    {
        self.controller.end_period(state, Some(&line.acted(self.controller.front.delay)))
    }

    /// A sample at time `t`: what is measured, and the torque for it.
    fn sample<S>(
        &self,
        effects: &Effects<N>,
        line: &mut Line<N>,
        state: &mut State<N, S>,
        motion: &Motion<N>,
        t: f64,
        guard: &mut Guarding<'_, N>,
    ) -> Result<()>
    where
        C: Compensator<N, S>,
    {
        let taken = self.take(effects, line, motion, t);
        let period = self.hold as f64 * self.dt;
        let Taken { sample, elapsed, told } = &taken;
        let command = match (sample, guard) {
            (Some(sample), None) => {
                if told.is_some() {
                    self.controller.lasted(state, *elapsed)?;
                }
                Some(self.decide(state, told.as_ref(), sample, period, None)?)
            }
            (Some(sample), Some((guard, memory))) => {
                let turn = (*guard, &mut **memory);
                Some(self.decide_guarded(turn, state, told.as_ref(), sample, *elapsed))
            }
            (None, Some((guard, memory))) => Some(self.missed((*guard, &mut **memory), state)),
            (None, None) => None,
        };
        self.send(effects, line, &taken, command);
        Ok(())
    }

    /// Takes a sample at time `t`.
    pub(super) fn take(
        &self,
        effects: &Effects<N>,
        line: &mut Line<N>,
        motion: &Motion<N>,
        t: f64,
    ) -> Taken<N> {
        let kept = line.clock.take();
        let (period, begun) = (self.hold as f64 * self.dt, line.command.is_none());
        let elapsed = match t - line.seen_at {
            _ if begun => period,
            apart if effects.timing.jitter == 0.0 => libm::rint(apart / period) * period,
            apart => apart,
        };
        let told = (!begun).then(|| line.acted(self.controller.front.delay));
        if !kept {
            return Taken { sample: None, elapsed, told };
        }
        let Motion { q, dq } = line.at_encoders(effects, motion);
        line.measured = line.measuring.measure(&q, &dq, elapsed).into();
        line.seen_at = t;
        let [q, dq] = &line.measured;
        let sample = Some(self.controller.sample(q, dq, &self.reference.at(t)));
        Taken { sample, elapsed, told }
    }

    /// Sends the torque that was decided on; `None`: the one before is held on.
    pub(super) fn send(
        &self,
        effects: &Effects<N>,
        line: &mut Line<N>,
        taken: &Taken<N>,
        command: Option<Command<N>>,
    ) {
        let Taken { elapsed, told: begun, .. } = taken;
        let told = match &command {
            None => {
                line.lost += 1.0;
                line.sent[0]
            }
            Some(command) => {
                let told = line.drive.ask(&command.tau, *elapsed);
                if begun.is_some() {
                    held_on(&mut line.older, &line.told, line.lost);
                }
                (line.told, line.lost) = (told, 0.0);
                told
            }
        };
        line.command = command.or(line.command);
        line.sent.rotate_right(1);
        line.sent[0] = told;
        line.drive.act(&line.sent[effects.timing.delay]);
    }

    /// The plant under what arrives at its joints.
    fn held<'a>(
        &'a self,
        effects: &'a Effects<N>,
        arriving: &Vector<N>,
        t: f64,
    ) -> Held<'a, N, A, D> {
        let held = Held::new(self.plant, t, arriving);
        let cogs = effects.actuators.cogging.iter().any(|c| *c > 0.0);
        if cogs { held.cogging(&effects.actuators) } else { held }
    }

    /// The motion at time `end` \[s\], from that at `t`; `None` if the error control gave up.
    fn glide(
        &self,
        effects: &Effects<N>,
        line: &mut Line<N>,
        record: &mut Recorder<N>,
        motion: Motion<N>,
        (t, end): (f64, f64),
    ) -> Option<Motion<N>> {
        let h = end - t;
        if h <= SAME * record.dt {
            return Some(motion);
        }
        let h = if (h - record.dt).abs() <= SAME * record.dt { record.dt } else { h };
        let arriving = line.drive.arriving(h);
        if let (Some(transmission), Some(motors)) = (&effects.transmission, &mut line.motors) {
            let arm = self.plant.arm_at(t);
            let (q, dq) = transmission.gears.advance(
                arm,
                (motion.q, motion.dq),
                motors,
                &arriving,
                (t, h),
                |&(q, dq), torque, t, h| {
                    let (held, at) = (self.held(effects, torque, t), Motion { q, dq });
                    let Motion { q, dq } = held.step_from(&at, t, h);
                    (q, dq)
                },
            );
            return Some(Motion { q, dq });
        }
        let held = self.held(effects, &arriving, t);
        let ddq = match self.method {
            Method::Rk4 => held.acceleration(&motion, t),
            Method::Dp54(_) => Vector::zeros(),
        };
        held.move_on(self.method, record, (&motion, &ddq), (t, h, end))
    }
}

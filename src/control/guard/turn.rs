//! One period of a guarded loop.
//!
//! In this order: the time since the last call is judged, then the sample; the controller is asked,
//! or the arm is braked; effort, rate and power have the last word.

use super::bounds::Bounded;
use super::judge::Verdict;
use super::{Cause, Event, Events, GuardMemory, GuardParameters};
use crate::control::{Command, Compensator, Controller, Law, State};
use crate::math::Vector;
use crate::reference::Setpoint;

/// A time between two samples above this is a host that was suspended, or a clock that was set
/// \[s\].
const LONGEST: f64 = 1.0;
/// A sample that comes before this share of a period is early, and one after that share is late.
const EARLY: f64 = 0.5;
const LATE: f64 = 1.5;

/// What one period of a guarded loop gives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Guarded<const N: usize> {
    /// The torque to send: finite and within effort and rate, whatever came [N·m].
    pub tau: Vector<N>,
    /// What the controller asked for; `None` if it was not asked, or refused.
    pub command: Option<Command<N>>,
    /// What the guard did.
    pub events: Events,
}

/// What came.
pub(crate) struct Seen<'a, const N: usize> {
    pub q: &'a Vector<N>,
    pub dq: &'a Vector<N>,
    pub desired: &'a Setpoint<N>,
    /// What acted since the last call [N·m]; `None`: what was sent.
    pub applied: Option<&'a Vector<N>>,
    /// Time since the last call \[s\].
    pub elapsed: f64,
}

/// A guard and its controller, at one call.
pub(crate) struct Turn<'a, const N: usize, L, C, S> {
    pub guard: &'a GuardParameters<N>,
    pub memory: &'a mut GuardMemory<N>,
    pub controller: &'a Controller<N, L, C>,
    pub state: &'a mut State<N, S>,
}

impl<const N: usize, L: Law<N>, C: Compensator<N, S>, S> Turn<'_, N, L, C, S> {
    /// The torque to send for a sample.
    pub fn step(&mut self, came: &Seen<'_, N>) -> Guarded<N> {
        let mut events = Events::default();
        let judged = self.judge_time(came.elapsed, &mut events);
        if judged == Err(Event::Early) {
            return self.repeat(events);
        }
        self.end_period(came.applied, &mut events);
        if let Err(event) = judged {
            return self.lose(event, events);
        }
        let seen = self.controller.sample(came.q, came.dq, came.desired);
        let verdict = self.guard.judge(self.memory, &seen, &self.controller.law.wraps());
        match verdict {
            Verdict::Bad(event) => {
                return self.lose(event, events);
            }
            Verdict::Breach(cause) => {
                events.add(cause.event);
                self.halt(cause);
            }
            Verdict::Good if self.memory.lost > self.patience() => self.halt(Cause::MISSED),
            Verdict::Good | Verdict::NoSetpoint => {}
        }
        let memory = &mut *self.memory;
        (memory.last_good, memory.since_good) = (Some([seen.q, seen.dq]), 0.0);
        if memory.stopped.is_some() {
            memory.lost = 0;
            return self.brake(&seen.q, &seen.dq, events);
        }
        if matches!(verdict, Verdict::NoSetpoint) {
            return self.lose(Event::NotFinite, events);
        }
        self.ask(came, events)
    }

    /// The torque to send where no sample came.
    pub fn missed(&mut self) -> Guarded<N> {
        let mut events = Events::default();
        self.end_period(None, &mut events);
        self.memory.since_good += self.guard.control_period;
        self.memory.since_call = 0.0;
        self.lose(Event::Missed, events)
    }

    /// Stops.
    pub fn stop(&mut self) {
        let mut events = Events::default();
        events.add(Event::Stop);
        self.memory.add(events);
        self.halt(Cause { event: Event::Stop, joint: None });
    }

    /// The longest row of periods without a good sample after which the guard still runs.
    fn patience(&self) -> u64 {
        u64::from(self.guard.hold) + u64::from(self.guard.decay)
    }

    /// Counts the time on. The event is why the sample cannot be used.
    fn judge_time(&mut self, elapsed: f64, events: &mut Events) -> Result<(), Event> {
        let (memory, period) = (&mut *self.memory, self.guard.control_period);
        if !(elapsed > 0.0 && elapsed <= LONGEST) {
            memory.since_good += period;
            memory.since_call = 0.0;
            if elapsed > LONGEST {
                self.halt(Cause { event: Event::Clock, joint: None });
            }
            return Err(Event::Clock);
        }
        memory.since_call += elapsed;
        let (begun, since) = (memory.last_good.is_some(), memory.since_good + memory.since_call);
        if begun && since < EARLY * period {
            return Err(Event::Early);
        }
        if begun && memory.since_call > LATE * period {
            events.add(Event::Late);
            let missed = libm::round(memory.since_call / period) as u64 - 1;
            memory.lost += missed;
            memory.counts[Event::Missed as usize] += missed;
        }
        memory.since_good += memory.since_call;
        memory.since_call = 0.0;
        Ok(())
    }

    /// Ends the period before with the torque that acted in it. Nothing is learnt from it where
    /// that is said, and is not finite.
    fn end_period(&mut self, applied: Option<&Vector<N>>, events: &mut Events) {
        if applied.is_some_and(|tau| !is_finite(tau)) {
            events.add(Event::NotFinite);
            self.state.pending = None;
        }
        // What cannot end is left out.
        _ = self.controller.end_period(self.state, applied);
    }

    /// What the controller wants for a good sample.
    fn ask(&mut self, came: &Seen<'_, N>, events: Events) -> Guarded<N> {
        let Seen { q, dq, desired, .. } = *came;
        match self.controller.step(self.state, q, dq, desired, self.guard.control_period) {
            Ok(command) => {
                self.memory.lost = 0;
                let given = self.send(&command.tau, Some(command), events);
                if let Some(pending) = &mut self.state.pending {
                    pending.applied.tau = given.tau;
                }
                given
            }
            Err(_) => self.lose(Event::Controller, events),
        }
    }

    /// Stops, unless that has happened: what is pending ends, and nothing is learnt until the
    /// guard runs again.
    fn halt(&mut self, cause: Cause) {
        if self.memory.stopped.is_none() {
            self.memory.stopped = Some(cause);
            self.end_period(None, &mut Events::default());
        }
    }

    /// A period without an answer of the controller: the last torque for a while, then on the way
    /// to the torque that carries the arm, then a stop, whose cause is the last `event`.
    fn lose(&mut self, event: Event, mut events: Events) -> Guarded<N> {
        events.add(event);
        self.memory.lost = self.memory.lost.saturating_add(1);
        let (lost, patience) = (self.memory.lost, self.patience());
        if lost > patience {
            self.halt(Cause { event, joint: None });
        }
        let carrying = self.memory.last_good.map_or_else(Vector::zeros, |[q, _]| self.carrying(&q));
        let last = self.memory.last_tau.unwrap_or(carrying);
        let wanted = if self.memory.stopped.is_some() {
            carrying
        } else if lost <= u64::from(self.guard.hold) {
            last
        } else {
            last + (carrying - last) / (patience + 1 - lost) as f64
        };
        self.send(&wanted, None, events)
    }

    /// The torque that brings the arm to rest.
    fn brake(&mut self, q: &Vector<N>, dq: &Vector<N>, events: Events) -> Guarded<N> {
        let brake = &self.guard.brake;
        let start = Setpoint { q: *q, dq: *dq, ddq: Vector::zeros() };
        let from = self.memory.slowing.unwrap_or(start);
        self.memory.slowing = Some(brake.slow_down(&from, self.guard.control_period));
        let seen = self.controller.sample(q, dq, &from);
        let wanted = brake.acceleration(&seen.e, &seen.de);
        let braking = self.controller.law.inertia_torque(q, &wanted);
        let braking = if is_finite(&braking) { braking } else { Vector::zeros() };
        self.send(&(self.carrying(q) + braking), None, events)
    }

    /// The law's resting torque; zero where that is not finite.
    fn carrying(&self, q: &Vector<N>) -> Vector<N> {
        let tau = self.controller.law.resting_torque(q);
        if is_finite(&tau) { tau } else { Vector::zeros() }
    }

    /// The last torque once more.
    fn repeat(&mut self, mut events: Events) -> Guarded<N> {
        events.add(Event::Early);
        let last = self.memory.last_tau.unwrap_or_else(Vector::zeros);
        self.send(&last, None, events)
    }

    /// Lets the limits have the last word, and remembers what is sent.
    fn send(
        &mut self,
        wanted: &Vector<N>,
        command: Option<Command<N>>,
        mut events: Events,
    ) -> Guarded<N> {
        let seen = self.memory.sees().copied();
        let resting = seen.map(|[q, _]| self.carrying(&q));
        let taken_over = self.memory.last_tau.or(resting);
        let last = taken_over.unwrap_or_else(Vector::zeros);
        let dq = seen.as_ref().map(|[_, dq]| dq);
        let Bounded { tau, events: cut, breach } = self.guard.bounded(&last, wanted, dq);
        events.join(cut);
        self.memory.last_tau = taken_over.map(|_| tau);
        if let Some(joint) = breach {
            events.add(Event::Power);
            self.halt(Cause { event: Event::Power, joint: Some(joint) });
        }
        self.memory.add(events);
        Guarded { tau, command, events }
    }
}

fn is_finite<const N: usize>(tau: &Vector<N>) -> bool {
    tau.iter().all(|x| x.is_finite())
}

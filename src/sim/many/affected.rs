//! The controllers of eight sampled loops with effects: what is measured of each, what they decide,
//! side by side where they can, and what of it arrives.

use super::bodies::{Bodies, Now};
use super::case::Case;
use super::course::Course;
use super::measured::Measured;
use super::models::Models;
use super::together::settled;
use crate::arm::Arm;
use crate::control::{Command, Compensator, Law, Sample, State};
use crate::effects::Effects;
use crate::math::{Abreast, LANES, Vector, lane, put};
use crate::plant::Disturbance;
use crate::reference::Reference;
use crate::sim::affected::{Line, Taken};
use crate::sim::integrators::Motion;
use crate::sim::sampled::Sampled;

/// Whether loops with these effects go side by side: samples come on rows, links follow their
/// motors, and nothing but the controllers and drives makes torques.
pub(super) fn goes_along<const N: usize>(effects: &Effects<N>) -> bool {
    let cogs = effects.actuators.cogging.iter().any(|c| *c > 0.0);
    effects.timing.jitter == 0.0 && effects.transmission.is_none() && !cogs
}

/// Loops with effects.
pub(super) struct Affected<'a, const N: usize, A, D, L, C, R, S> {
    effects: [&'a Effects<N>; LANES],
    loops: [Sampled<'a, N, A, D, L, C, R>; LANES],
    lines: [Line<N>; LANES],
    controllers: Controllers<N, S>,
    begun: bool,
}

/// Their controllers.
enum Controllers<const N: usize, S> {
    Abreast(Box<Measured<N>>),
    Each(Box<States<N, S>>),
}

/// The states of controllers that decide one after the other, with M₀ and H₀ of all, where nothing
/// else is needed of their models; and the motion that was measured last.
struct States<const N: usize, S> {
    states: [State<N, S>; LANES],
    models: Option<Models<N>>,
    q: Vector<N, Abreast>,
    dq: Vector<N, Abreast>,
}

impl<'a, const N: usize, A, D, L, C, R, S> Affected<'a, N, A, D, L, C, R, S>
where
    A: Arm<N>,
    D: Disturbance<N>,
    L: Law<N>,
    C: Compensator<N, S>,
    R: Reference<N>,
    S: Clone,
{
    /// Those of these runs.
    pub fn new(
        cases: [&'a Case<'a, N, A, D, L, C, R, S>; LANES],
        bodies: &Bodies<N>,
        Course { hold, h, .. }: Course<'_>,
    ) -> Self {
        let loops = cases.map(|case| case.sampled(hold, h));
        let line = |i: usize| loops[i].line(&cases[i].effects, cases[i].state, &cases[i].q0.into());
        let lines = core::array::from_fn(line);
        let effects = cases.map(|case| &case.effects);
        // A controller whose sample is lost does not decide when the others do.
        let keeps = effects.iter().all(|effects| effects.timing.drop == 0.0);
        let abreast = if keeps { Measured::new(cases, &settled(cases), bodies) } else { None };
        let controllers = match abreast {
            Some(measured) => Controllers::Abreast(Box::new(measured)),
            None => {
                let zeros = Vector::<N, _>::repeat(Abreast::all(0.0));
                let (states, models) = (cases.map(|case| case.state.clone()), Models::of(cases));
                Controllers::Each(Box::new(States { states, models, q: zeros, dq: zeros }))
            }
        };
        Self { effects, loops, lines, controllers, begun: false }
    }

    /// Takes a sample of each loop at time `t` \[s\], and asks its controller for the torque of a
    /// period \[s\]. One that refuses is lost.
    pub fn decide(&mut self, bodies: &mut Bodies<N>, period: f64, t: f64) {
        let mut all = [None; LANES];
        for (i, (taken, line)) in all.iter_mut().zip(&mut self.lines).enumerate() {
            let Sample { q, dq, .. } = &bodies.now.seen;
            let motion = Motion { q: lane(q, i), dq: lane(dq, i) };
            *taken = Some(self.loops[i].take(self.effects[i], line, &motion, t));
        }
        let commands = match &mut self.controllers {
            Controllers::Abreast(measured) => {
                for (i, taken) in all.iter().enumerate() {
                    let Some(Taken { sample: Some(sample), told, .. }) = taken else { continue };
                    let (Sample { q, dq, desired, .. }, of) = (sample, self.loops[i].controller);
                    measured.seen.show(i, &of.felt(q, dq, desired));
                    match told {
                        Some(told) => measured.tell(i, told),
                        None => measured.begin(i, of, q, &mut bodies.lost),
                    }
                }
                measured.decide(bodies.arch, self.begun, period, &mut bodies.lost);
                core::array::from_fn(|i| Some(measured.command(i)))
            }
            Controllers::Each(states) => states.decide(&self.loops, &all, bodies, period),
        };
        self.begun = true;
        let Bodies { now: Now { v, rho_hat, .. }, lost, .. } = bodies;
        for (i, (taken, command)) in all.iter().zip(commands).enumerate() {
            let (Some(taken), 0.0) = (taken, lost.0[i]) else { continue };
            let line = &mut self.lines[i];
            self.loops[i].send(self.effects[i], line, taken, command);
            if let Some(command) = &line.command {
                for n in 0..N {
                    v[n].0[i] = command.v[n];
                    rho_hat[n].0[i] = command.rho_hat[n];
                }
            }
        }
    }

    /// Applies what has arrived.
    pub fn arrived(&self, bodies: &mut Bodies<N>) {
        for (i, line) in self.lines.iter().enumerate() {
            put(&line.drive.arrived(), &mut bodies.now.applied, i);
        }
    }

    /// Applies what arrives in the next `h` \[s\]; whether it is another torque than before.
    pub fn arriving(&mut self, bodies: &mut Bodies<N>, h: f64) -> bool {
        let before = bodies.now.applied;
        for (i, line) in self.lines.iter_mut().enumerate() {
            put(&line.drive.arriving(h), &mut bodies.now.applied, i);
        }
        before != bodies.now.applied
    }

    /// Ends the last period \[s\]; one that cannot end is lost.
    pub fn end(&mut self, bodies: &mut Bodies<N>, period: f64) {
        match &mut self.controllers {
            Controllers::Abreast(measured) => {
                for (i, line) in self.lines.iter().enumerate() {
                    measured.tell(i, &line.acted(self.loops[i].controller.front.delay));
                }
                measured.end(bodies.arch, period, &mut bodies.lost);
            }
            Controllers::Each(states) => {
                for (i, (line, state)) in self.lines.iter().zip(&mut states.states).enumerate() {
                    if self.loops[i].end_affected(line, state).is_err() {
                        bodies.lost.0[i] = f64::NAN;
                    }
                }
            }
        }
    }
}

impl<const N: usize, S: Clone> States<N, S> {
    /// What each commands for the sample that was taken; `None` where that is lost, or the run is.
    fn decide<A, D, L, C, R>(
        &mut self,
        loops: &[Sampled<'_, N, A, D, L, C, R>; LANES],
        all: &[Option<Taken<N>>; LANES],
        Bodies { arch, lost, .. }: &mut Bodies<N>,
        period: f64,
    ) -> [Option<Command<N>>; LANES]
    where
        A: Arm<N>,
        D: Disturbance<N>,
        L: Law<N>,
        C: Compensator<N, S>,
        R: Reference<N>,
    {
        for (i, taken) in all.iter().enumerate() {
            if let Some(Taken { sample: Some(sample), .. }) = taken {
                for n in 0..N {
                    (self.q[n].0[i], self.dq[n].0[i]) = (sample.q[n], sample.dq[n]);
                }
            }
        }
        if let Some(models) = &mut self.models {
            models.find(*arch, (&self.q, &self.dq));
        }
        let mut commands = [None; LANES];
        for (i, taken) in all.iter().enumerate() {
            let (Some(Taken { sample: Some(sample), elapsed, told }), 0.0) = (taken, lost.0[i])
            else {
                continue;
            };
            let (sampled, state) = (&loops[i], &mut self.states[i]);
            let known = self.models.as_ref().map(|models| models.of_lane(i));
            let lasted = told.map_or(Ok(()), |_| sampled.controller.lasted(state, *elapsed));
            let command = lasted.and_then(|()| {
                sampled.decide(state, told.as_ref(), sample, period, known.as_ref())
            });
            match command {
                Ok(command) => commands[i] = Some(command),
                Err(_) => lost.0[i] = f64::NAN,
            }
        }
        commands
    }
}

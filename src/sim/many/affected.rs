//! The controllers of eight sampled loops with effects, one after the other: what is measured, what
//! they decide, and what of it arrives.

use super::bodies::{Bodies, Now};
use super::case::Case;
use super::course::Course;
use super::models::Models;
use crate::arm::Arm;
use crate::control::{Compensator, Law, State};
use crate::effects::Effects;
use crate::math::{Abreast, LANES, Vector, lane};
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

/// Loops with effects, with the states of their controllers.
pub(super) struct Affected<'a, const N: usize, A, D, L, C, R, S> {
    effects: [&'a Effects<N>; LANES],
    loops: [Sampled<'a, N, A, D, L, C, R>; LANES],
    states: [State<N, S>; LANES],
    lines: [Line<N>; LANES],
    models: Option<Models<N>>,
    /// What was measured last.
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
        Course { hold, h, .. }: Course<'_>,
    ) -> Self {
        let loops = cases.map(|case| case.sampled(hold, h));
        let states = cases.map(|case| case.state.clone());
        let line = |i: usize| loops[i].line(&cases[i].effects, &states[i], &cases[i].q0.into());
        let lines = core::array::from_fn(line);
        let zeros = Vector::<N, _>::repeat(Abreast::all(0.0));
        let effects = cases.map(|case| &case.effects);
        Self { effects, loops, states, lines, models: Models::of(cases), q: zeros, dq: zeros }
    }

    /// Takes a sample of each loop at time `t` \[s\], and asks its controller for the torque of a
    /// period \[s\]. One that refuses is lost.
    pub fn decide(&mut self, bodies: &mut Bodies<N>, period: f64, t: f64) {
        let Bodies { arch, now: Now { seen, v, rho_hat, .. }, lost, .. } = bodies;
        let mut all = [None; LANES];
        for (i, (taken, line)) in all.iter_mut().zip(&mut self.lines).enumerate() {
            let motion = Motion { q: lane(&seen.q, i), dq: lane(&seen.dq, i) };
            let sampled = self.loops[i].take(self.effects[i], line, &motion, t);
            if let Taken { sample: Some(sample), .. } = &sampled {
                for n in 0..N {
                    (self.q[n].0[i], self.dq[n].0[i]) = (sample.q[n], sample.dq[n]);
                }
            }
            *taken = Some(sampled);
        }
        if let Some(models) = &mut self.models {
            models.find(*arch, (&self.q, &self.dq));
        }
        for (i, taken) in all.iter().enumerate() {
            let (Some(taken), 0.0) = (taken, lost.0[i]) else { continue };
            let (sampled, state) = (&self.loops[i], &mut self.states[i]);
            let command = match &taken.sample {
                None => Ok(None),
                Some(sample) => {
                    let known = self.models.as_ref().map(|models| models.of_lane(i));
                    let lasted = taken
                        .told
                        .map_or(Ok(()), |_| sampled.controller.lasted(state, taken.elapsed));
                    let told = taken.told.as_ref();
                    lasted
                        .and_then(|()| sampled.decide(state, told, sample, period, known.as_ref()))
                        .map(Some)
                }
            };
            let Ok(command) = command else {
                lost.0[i] = f64::NAN;
                continue;
            };
            let line = &mut self.lines[i];
            sampled.send(self.effects[i], line, taken, command);
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

    /// Ends the last period; one that cannot end is lost.
    pub fn end(&mut self, lost: &mut Abreast) {
        for (i, (line, state)) in self.lines.iter().zip(&mut self.states).enumerate() {
            if self.loops[i].end_affected(line, state).is_err() {
                lost.0[i] = f64::NAN;
            }
        }
    }
}

/// Puts a vector into a lane.
fn put<const N: usize>(from: &Vector<N>, to: &mut Vector<N, Abreast>, i: usize) {
    for n in 0..N {
        to[n].0[i] = from[n];
    }
}

//! The controllers of eight sampled loops: side by side, or one after the other, as each does
//! alone.

use super::affected::Affected;
use super::bodies::{Bodies, Now};
use super::case::Case;
use super::course::Course;
use super::measured::Measured;
use super::models::Models;
use super::together::{Together, settled};
use crate::arm::Arm;
use crate::control::{Compensator, Law, State};
use crate::math::{Abreast, LANES, lane};
use crate::plant::Disturbance;
use crate::reference::Reference;
use crate::sim::sampled::Sampled;

/// The controllers of eight loops.
pub(super) enum Deciders<'a, const N: usize, A, D, L, C, R, S> {
    Abreast(Box<Together<N>>),
    /// With other laws, something before them, or limits of rates.
    Apart(Box<Measured<N>>),
    Each(Box<Each<'a, N, A, D, L, C, R, S>>),
    Affected(Box<Affected<'a, N, A, D, L, C, R, S>>),
}

impl<'a, const N: usize, A, D, L, C, R, S> Deciders<'a, N, A, D, L, C, R, S>
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
        course: Course<'_>,
    ) -> Self {
        if cases.iter().any(|case| case.effects.is_on()) {
            return Self::Affected(Box::new(Affected::new(cases, bodies, course)));
        }
        let states = settled(cases);
        if cases.iter().all(|case| case.controller.is_bare())
            && let Some(together) = Together::new(cases, &states, bodies)
        {
            return Self::Abreast(Box::new(together));
        }
        let mut lost = Abreast::all(0.0);
        if let Some(mut measured) = Measured::new(cases, &states, bodies) {
            for (i, case) in cases.iter().enumerate() {
                measured.begin(i, case.controller, &case.q0.into(), &mut lost);
            }
            if lost == Abreast::all(0.0) {
                return Self::Apart(Box::new(measured));
            }
        }
        Self::Each(Box::new(Each::new(cases, course)))
    }
}

/// Controllers one after the other, with their states. M₀ and H₀ of all, where nothing else is
/// needed of their models, are found side by side.
pub(super) struct Each<'a, const N: usize, A, D, L, C, R, S> {
    loops: [Sampled<'a, N, A, D, L, C, R>; LANES],
    states: [State<N, S>; LANES],
    models: Option<Models<N>>,
}

impl<'a, const N: usize, A, D, L, C, R, S> Each<'a, N, A, D, L, C, R, S>
where
    A: Arm<N>,
    D: Disturbance<N>,
    L: Law<N>,
    C: Compensator<N, S>,
    R: Reference<N>,
    S: Clone,
{
    fn new(
        cases: [&'a Case<'a, N, A, D, L, C, R, S>; LANES],
        Course { hold, h, .. }: Course<'_>,
    ) -> Self {
        let loops = cases.map(|case| case.sampled(hold, h));
        Self { loops, states: cases.map(|case| case.state.clone()), models: Models::of(cases) }
    }

    /// Asks every controller for the torque of a period \[s\]; it is told what acted in the one
    /// before, if that has `begun`. One that refuses is lost.
    pub fn decide(&mut self, bodies: &mut Bodies<N>, begun: bool, period: f64) {
        let Bodies { arch, now, lost, .. } = bodies;
        if let Some(models) = &mut self.models {
            models.find(*arch, (&now.seen.q, &now.seen.dq));
        }
        let Now { seen, applied, v, rho_hat, .. } = now;
        for (i, (sampled, state)) in self.loops.iter().zip(&mut self.states).enumerate() {
            if lost.0[i] != 0.0 {
                continue;
            }
            let (before, seen) = (begun.then(|| lane(applied, i)), seen.lane(i));
            let known = self.models.as_ref().map(|models| models.of_lane(i));
            match sampled.decide(state, before.as_ref(), &seen, period, known.as_ref()) {
                Ok(command) => {
                    let acts = sampled.plant.applied(&command.tau);
                    for n in 0..N {
                        applied[n].0[i] = acts[n];
                        v[n].0[i] = command.v[n];
                        rho_hat[n].0[i] = command.rho_hat[n];
                    }
                }
                Err(_) => lost.0[i] = f64::NAN,
            }
        }
    }

    /// Ends the last period; one that cannot end is lost.
    pub fn end(&mut self, bodies: &mut Bodies<N>) {
        let Bodies { now: Now { applied, .. }, lost, .. } = bodies;
        for (i, (sampled, state)) in self.loops.iter().zip(&mut self.states).enumerate() {
            if sampled.controller.end_period(state, Some(&lane(applied, i))).is_err() {
                lost.0[i] = f64::NAN;
            }
        }
    }
}

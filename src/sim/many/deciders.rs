//! The controllers of eight sampled loops: side by side, or one after the other, as each does
//! alone.

use pulp::{Arch, Simd, WithSimd};

use super::affected::Affected;
use super::bodies::{Bodies, Drivers, Now};
use super::case::Case;
use super::course::Course;
use super::models::Models;
use crate::arm::Arm;
use crate::control::{
    Compensator, Controller, EstimatorsAbreast, FARTHEST, Front, Law, Sample, Stage, State,
};
use crate::math::{
    Abreast, LANES, Load, Real, Register, TINY_SIGNAL, Vector, in_lanes, lane, none_missing,
};
use crate::plant::Disturbance;
use crate::reference::Reference;
use crate::sim::sampled::Sampled;

/// The controllers of eight loops.
pub(super) enum Deciders<'a, const N: usize, A, D, L, C, R, S> {
    Abreast(Box<Together<N>>),
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
        match Together::new(cases, bodies) {
            Some(together) => Self::Abreast(Box::new(together)),
            None => Self::Each(Box::new(Each::new(cases, course))),
        }
    }
}

/// Controllers side by side: laws with constant gains, and compensators that can be.
pub(super) struct Together<const N: usize> {
    pub drivers: Drivers<N>,
    compensators: EstimatorsAbreast<N>,
}

impl<const N: usize> Together<N> {
    pub fn new<A: Arm<N>, D: Disturbance<N>, L: Law<N>, C: Compensator<N, S>, R, S: Clone>(
        cases: [&Case<'_, N, A, D, L, C, R, S>; LANES],
        bodies: &Bodies<N>,
    ) -> Option<Self> {
        let plain = |Controller { front, limits, .. }: &Controller<N, L, C>| {
            *front == Front::default() && !limits.limits_rate()
        };
        if !cases.iter().all(|case| plain(case.controller)) {
            return None;
        }
        let mut states = cases.map(|case| case.state.clone());
        let mut learns = [None; LANES];
        for ((to, case), state) in learns.iter_mut().zip(cases).zip(&mut states) {
            let Controller { compensator, .. } = case.controller;
            *to = compensator.learns(case.controller.settle(state));
        }
        let compensators = EstimatorsAbreast::of(none_missing(learns)?)?;
        Some(Self { drivers: Drivers::new(cases, bodies)?, compensators })
    }

    /// The estimates of the compensators for what the controllers see. Where a signal is so small
    /// that a controller does not feel it, or so large that it may refuse it, the run is `lost`.
    pub fn estimate(
        &mut self,
        arch: Arch,
        seen: &Sample<N, Abreast>,
        lost: &mut Abreast,
    ) -> &Vector<N, Abreast> {
        in_lanes(arch, Feel { seen, lost: &mut *lost });
        self.compensators.estimate(arch, &Stage::NOW, seen, lost)
    }

    /// Ends a period \[s\], with the torques that were asked for and those that acted, which are
    /// `limited` or not. What drives weights is small, or the run is lost.
    pub fn end(
        &mut self,
        arch: Arch,
        torques: (&Vector<N, Abreast>, &Vector<N, Abreast>),
        limited: bool,
        period: f64,
        lost: &mut Abreast,
    ) {
        self.compensators.acted(arch, 0, torques, limited);
        self.compensators.advance(arch, &Stage::after(period), lost);
    }
}

struct Feel<'a, const N: usize> {
    seen: &'a Sample<N, Abreast>,
    lost: &'a mut Abreast,
}

impl<const N: usize> WithSimd for Feel<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { seen: Sample { q, dq, desired, .. }, lost } = self;
        for part in 0..Register::<S>::PARTS {
            let mut felt = lost.load(simd, part);
            for signal in [q, dq, &desired.q, &desired.dq, &desired.ddq] {
                for x in signal.iter() {
                    let x = x.load(simd, part);
                    let (zero, lost) = (x.like(0.0), x.like(f64::NAN));
                    let unfelt = (x - x.unless_tiny(TINY_SIGNAL)).abs();
                    felt +=
                        zero.if_less(unfelt, lost, x.like(FARTHEST).if_less(x.abs(), lost, zero));
                }
            }
            felt.store(lost, part);
        }
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

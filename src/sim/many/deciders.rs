//! The controllers of eight sampled loops: side by side, or one after the other, as each does alone.

use pulp::{Simd, WithSimd};

use super::bodies::{Bodies, Drivers, Now};
use super::case::Case;
use super::course::Course;
use crate::arm::{Alike, Arm, ArmsAbreast, Kind};
use crate::control::{
    Compensator, Controller, EstimatorsAbreast, Front, Law, Sample, Stage, State,
};
use crate::math::{
    Abreast, LANES, Load, Matrix, Real, Register, TINY_SIGNAL, Vector, lane, none_missing, store,
};
use crate::plant::Disturbance;
use crate::reference::Reference;
use crate::sim::options::Method;
use crate::sim::sampled::Sampled;

/// The controllers of eight loops.
pub(super) enum Deciders<'a, const N: usize, A, D, L, C, R, S> {
    Abreast(Box<Together<N>>),
    Each(Box<Each<'a, N, A, D, L, C, R, S>>),
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
    fn new<A: Arm<N>, D: Disturbance<N>, L: Law<N>, C: Compensator<N, S>, R, S: Clone>(
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

    /// The estimates of the compensators for a period that begins. The one before, if it has
    /// `begun`, ends \[s\]. Where a signal is so small that a controller does not feel it, the run is
    /// lost.
    pub fn estimate(
        &mut self,
        bodies: &mut Bodies<N>,
        begun: bool,
        period: f64,
    ) -> &Vector<N, Abreast> {
        if begun {
            self.end(bodies, period);
        }
        let Bodies { arch, now, lost, .. } = bodies;
        arch.dispatch(Feel { seen: &now.seen, lost });
        self.compensators.estimate(*arch, &Stage::NOW, &now.seen, lost)
    }

    /// Ends a period \[s\].
    pub fn end(&mut self, bodies: &Bodies<N>, period: f64) {
        let Bodies { arch, now, .. } = bodies;
        self.compensators.acted(*arch, 0, &now.asked, &now.applied);
        self.compensators.advance(*arch, &Stage::after(period));
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
                    let unfelt = (x - x.unless_tiny(TINY_SIGNAL)).abs();
                    felt += x.like(0.0).if_less(unfelt, x.like(f64::NAN), x.like(0.0));
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
        let loops = cases.map(|&Case { plant, controller, reference, .. }| Sampled {
            plant,
            controller,
            reference,
            hold,
            dt: h,
            method: Method::Rk4,
        });
        let states = cases.map(|case| case.state.clone());
        let plain = cases.iter().all(|case| case.controller.front == Front::default());
        let sides = none_missing(cases.map(|case| case.controller.law.model()));
        let models = sides.filter(|_| plain).and_then(ArmsAbreast::of).map(Models::new);
        Self { loops, states, models }
    }

    /// Asks every controller for the torque of a period \[s\]; it is told what acted in the one
    /// before, if that has `begun`. One that refuses is lost.
    pub fn decide(&mut self, bodies: &mut Bodies<N>, begun: bool, period: f64) {
        let Bodies { arch, now, lost, .. } = bodies;
        if let Some(models) = &mut self.models {
            arch.dispatch(Model { models, seen: &now.seen });
        }
        let Now { seen, applied, v, rho_hat, .. } = now;
        for (i, (sampled, state)) in self.loops.iter().zip(&mut self.states).enumerate() {
            if lost.0[i] != 0.0 {
                continue;
            }
            let (before, seen) = (begun.then(|| lane(applied, i)), seen.lane(i));
            let decided = match &self.models {
                Some(models) => {
                    sampled.decide_from(&models.of(i), state, before.as_ref(), &seen, period)
                }
                None => sampled.decide(state, before.as_ref(), &seen, period),
            };
            match decided {
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

/// What eight laws believe of their arms, and M₀ and H₀ of the latest sample.
struct Models<const N: usize> {
    arms: ArmsAbreast<N>,
    mass: Matrix<N, Abreast>,
    bias: Vector<N, Abreast>,
}

impl<const N: usize> Models<N> {
    fn new(arms: ArmsAbreast<N>) -> Self {
        let zero = Abreast::all(0.0);
        let (mass, bias) = (Matrix::<N, _>::repeat(zero), Vector::<N, _>::repeat(zero));
        Self { arms, mass, bias }
    }

    /// M₀ and H₀ of the law in a lane.
    fn of(&self, i: usize) -> (Matrix<N>, Vector<N>) {
        (Matrix::<N>::from_fn(|row, column| self.mass[(row, column)].0[i]), lane(&self.bias, i))
    }
}

struct Model<'a, const N: usize> {
    models: &'a mut Models<N>,
    seen: &'a Sample<N, Abreast>,
}

impl<const N: usize> WithSimd for Model<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { models: Models { arms, mass, bias }, seen } = self;
        for part in 0..Register::<S>::PARTS {
            let (at, mut q) = ((simd, part), seen.q.load(simd, part));
            let mut dq = seen.dq.load(simd, part);
            for n in 0..N {
                q[n] = q[n].unless_tiny(TINY_SIGNAL);
                dq[n] = dq[n].unless_tiny(TINY_SIGNAL);
            }
            let (own_mass, mut own_bias) = match &arms.kind {
                Kind::TwoLinks(arms) => dynamics(at, &**arms, (&q, &dq)),
                Kind::Chains(arms) => dynamics(at, &**arms, (&q, &dq)),
            };
            if let Some(friction) = arms.friction_at(at, &dq) {
                for n in 0..N {
                    own_bias[n] += friction[n];
                }
            }
            for j in 0..N {
                for i in 0..N {
                    own_mass[(i, j)].store(&mut mass[(i, j)], part);
                }
            }
            store(&own_bias, bias, part);
        }
    }
}

/// M and C q̇ + G of a part of arms.
#[inline(always)]
fn dynamics<const N: usize, S: Simd, K: Alike<N>>(
    at: (S, usize),
    arms: &K,
    (q, dq): (&Vector<N, Register<S>>, &Vector<N, Register<S>>),
) -> (Matrix<N, Register<S>>, Vector<N, Register<S>>) {
    arms.mass_matrix_and_bias(at, &arms.moves(at, q, dq))
}

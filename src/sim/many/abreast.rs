//! Eight runs side by side, in continuous time by RK4: a run a lane.
//!
//! What a step does is what [`rk4`](crate::sim::continuous) does of one run, without friction and
//! without a record. Here nothing ends early and nothing is told: a lane in which anything is out
//! of the ordinary is lost, and its run is made once more, alone.

use core::sync::atomic::{AtomicBool, Ordering};

use super::Case;
use super::bodies::Bodies;
use super::estimators::Estimators;
use crate::arm::Arm;
use crate::control::{Compensator, Law, Limits, Sample, Stage};
use crate::math::{Abreast, LANES, Vector};
use crate::plant::Disturbance;
use crate::reference::{Reference, Setpoint};
use crate::sim::closed_loop::time_of;
use crate::sim::integrators::{Motion, RK4};
use crate::sim::metrics::{Figures, Metrics, Window};
use crate::sim::resolution::Smooth;

/// A run that diverges, or is to end, is looked for once in so many steps.
const LOOK_EVERY: usize = 256;

/// How far runs go, and what is asked of them.
#[derive(Clone, Copy)]
pub(super) struct Course<'a> {
    /// Steps, and the length of each \[s\].
    pub steps: usize,
    pub h: f64,
    /// Rows that count are so many steps apart.
    pub every: usize,
    pub stop: &'a AtomicBool,
}

/// The loops of eight runs.
pub(super) struct Loops<'a, const N: usize, A, D, L, C, R, S> {
    cases: [&'a Case<'a, N, A, D, L, C, R, S>; LANES],
    bodies: Box<Bodies<N>>,
    compensators: Estimators<'a, N, C, S>,
    /// Whether all have one reference, or one disturbance.
    common: [bool; 2],
    /// The latest time with the set-points, and with the disturbances that depend on it alone.
    latest: Option<(f64, Setpoint<N, Abreast>, Option<Vector<N, Abreast>>)>,
}

impl<'a, const N: usize, A, D, L, C, R, S> Loops<'a, N, A, D, L, C, R, S>
where
    A: Arm<N>,
    D: Disturbance<N>,
    L: Law<N>,
    C: Compensator<N, S>,
    R: Reference<N>,
    S: Clone,
{
    /// The loops of these runs; `None` where they cannot go side by side.
    pub fn new(cases: [&'a Case<'a, N, A, D, L, C, R, S>; LANES], window: Window) -> Option<Self> {
        let [first, ..] = cases;
        let wraps = first.controller.law.wraps();
        if cases.iter().any(|case| case.controller.law.wraps() != wraps) {
            return None;
        }
        let limit = |of: &dyn Fn(&Case<'a, N, A, D, L, C, R, S>, usize) -> f64| Limits {
            effort_limit: core::array::from_fn(|n| Abreast::of(cases, |case| of(case, n))),
            effort_rate_limit: [Abreast::all(f64::INFINITY); N],
        };
        let limits = [
            limit(&|case, n| case.controller.limits.effort_limit[n]),
            limit(&|case, n| case.plant.effort_limit()[n]),
        ];
        let zero = Abreast::all(0.0);
        let zeros = Vector::<N, Abreast>::repeat(zero);
        let start = Motion {
            q: side_by_side(&cases.map(|case| case.q0.into())),
            dq: side_by_side(&cases.map(|case| case.dq0.into())),
        };
        let desired = Setpoint { q: zeros, dq: zeros, ddq: zeros };
        let bodies = Bodies {
            plants: A::abreast(cases.map(|case| &case.plant.arm))?,
            laws: L::abreast(cases.map(|case| &case.controller.law))?,
            limits,
            wraps,
            start,
            rates: [start; 4],
            seen: Sample { q: zeros, dq: zeros, desired, e: zeros, de: zeros },
            asked: zeros,
            applied: zeros,
            rho: zeros,
            figures: Figures::over(window, zero),
            smooth: Smooth::new(zero),
            lost: zero,
            farthest: zero,
        };
        let disturbance = &first.plant.disturbance;
        let common = [
            cases.iter().all(|case| core::ptr::eq(case.reference, first.reference)),
            cases.iter().all(|case| case.plant.disturbance.is_same(disturbance)),
        ];
        let compensators = Estimators::new(cases);
        Some(Self { cases, bodies: Box::new(bodies), compensators, common, latest: None })
    }

    /// Makes the runs: the metrics of those in which all was ordinary.
    pub fn run(mut self, course: Course<'_>) -> [Option<[Metrics; N]>; LANES] {
        let Course { steps, h, every, stop } = course;
        for k in 0..=steps {
            let times = (k as f64 * h, h, (k + 1) as f64 * h);
            self.stage(&RK4.stage(0, h), times);
            self.bodies.note(times.0, k % every == 0 || k == steps);
            if k == steps {
                break;
            }
            if k % LOOK_EVERY == 0 && (stop.load(Ordering::Relaxed) || self.all_lost()) {
                return [None; LANES];
            }
            for i in 1..4 {
                self.stage(&RK4.stage(i, h), times);
            }
            self.compensators.advance(&RK4.end(h, 4), &mut self.bodies.lost);
            self.bodies.end(h);
        }
        let bodies = self.bodies;
        core::array::from_fn(|lane| {
            let ordinary = bodies.is_ordinary(lane) && bodies.smooth.is_resolved(lane);
            bodies.figures.finish(|x| x.0[lane]).filter(|_| ordinary)
        })
    }

    /// A stage of a step of `h` from `t` to `end` \[s\].
    fn stage(&mut self, stage: &Stage<'_>, (t, h, end): (f64, f64, f64)) {
        let time = time_of(stage, (t, h, end));
        let (desired, disturbance) = self.at_time(time);
        self.bodies.go(stage.index, h, &desired);
        let rho_hat = self.compensators.estimate(stage, &self.bodies.seen);
        let Sample { q, dq, .. } = &self.bodies.seen;
        let tau_d = disturbance.unwrap_or_else(|| self.disturbances(q, dq, time));
        self.bodies.act(stage.index, &rho_hat, &tau_d);
        let Bodies { seen, asked, applied, .. } = &*self.bodies;
        self.compensators.acted(stage.index, seen, asked, applied);
    }

    /// The set-points at time `t`, and the disturbances if they depend on the time alone.
    #[inline(always)]
    fn at_time(&mut self, t: f64) -> (Setpoint<N, Abreast>, Option<Vector<N, Abreast>>) {
        match self.latest {
            Some((time, setpoints, disturbances)) if time == t => (setpoints, disturbances),
            _ => {
                let (setpoints, disturbances) = self.ask(t);
                self.latest = Some((t, setpoints, disturbances));
                (setpoints, disturbances)
            }
        }
    }

    #[inline(never)]
    fn ask(&self, t: f64) -> (Setpoint<N, Abreast>, Option<Vector<N, Abreast>>) {
        let [of_reference, of_disturbance] = self.common;
        let ask = |case: &Case<'_, N, A, D, L, C, R, S>| case.reference.at(t);
        let push = |case: &Case<'_, N, A, D, L, C, R, S>| case.plant.disturbance.at_time(t);
        let setpoints = each(of_reference, self.cases, ask);
        let side = |of: fn(&Setpoint<N>) -> &Vector<N>| {
            Vector::<N, Abreast>::from_fn(|n, _| {
                Abreast::of(setpoints.each_ref(), |setpoint| of(setpoint)[n])
            })
        };
        let desired =
            Setpoint { q: side(|it| &it.q), dq: side(|it| &it.dq), ddq: side(|it| &it.ddq) };
        let disturbances = each(of_disturbance, self.cases, push);
        let all = disturbances.iter().all(Option::is_some);
        let tau_d = disturbances.map(|tau_d| tau_d.unwrap_or_else(Vector::zeros));
        (desired, all.then(|| side_by_side(&tau_d)))
    }

    /// The disturbances where they depend on the motion.
    #[inline(never)]
    fn disturbances(
        &self,
        q: &Vector<N, Abreast>,
        dq: &Vector<N, Abreast>,
        t: f64,
    ) -> Vector<N, Abreast> {
        side_by_side(&core::array::from_fn(|i| {
            self.cases[i].plant.disturbance.torque(&lane(q, i), &lane(dq, i), t)
        }))
    }

    fn all_lost(&self) -> bool {
        (0..LANES).all(|lane| !self.bodies.is_ordinary(lane))
    }
}

/// What each gives, or the first one where it is `common` to all.
fn each<X, T: Copy>(common: bool, all: [&X; LANES], of: impl Fn(&X) -> T) -> [T; LANES] {
    if common { [of(all[0]); LANES] } else { all.map(of) }
}

/// The vector in a lane.
#[inline(always)]
pub(super) fn lane<const N: usize>(x: &Vector<N, Abreast>, lane: usize) -> Vector<N> {
    Vector::<N>::from_fn(|n, _| x[n].0[lane])
}

/// Vectors, a lane each.
#[inline(always)]
pub(super) fn side_by_side<const N: usize>(all: &[Vector<N>; LANES]) -> Vector<N, Abreast> {
    Vector::<N, Abreast>::from_fn(|n, _| Abreast::of(all.each_ref(), |x| x[n]))
}

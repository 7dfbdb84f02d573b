//! Eight runs side by side, in continuous time by RK4: a run a lane.
//!
//! What a step does is what [`rk4`](crate::sim::continuous) does of one run, without friction and
//! without a record. Here nothing ends early and nothing is told: a lane in which anything is out
//! of the ordinary is lost, and its run is made once more, alone.

use core::sync::atomic::{AtomicBool, Ordering};

use pulp::{Arch, Simd, WithSimd};

use super::Case;
use super::estimators::Estimators;
use crate::arm::{Arm, ArmsAbreast};
use crate::control::{Compensator, Law, LawsAbreast, Limits, Sample, Stage};
use crate::math::{Abreast, LANES, Real, Vector};
use crate::plant::Disturbance;
use crate::reference::{Reference, Setpoint};
use crate::sim::closed_loop::time_of;
use crate::sim::integrators::{Motion, RK4};
use crate::sim::metrics::{Figures, Metrics, Window};
use crate::sim::recorder::DIVERGED;
use crate::sim::resolution::Smooth;
use crate::sim::stiff::Moved;

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
    pub window: Window,
    pub stop: &'a AtomicBool,
}

/// The loops of eight runs.
pub(super) struct Loops<'a, const N: usize, A, D, L, C, R, S> {
    cases: [&'a Case<'a, N, A, D, L, C, R, S>; LANES],
    plants: ArmsAbreast<N>,
    laws: LawsAbreast<N>,
    compensators: Estimators<'a, N, C, S>,
    /// Limits of the controllers, and of the plants.
    limits: [Limits<N, Abreast>; 2],
    wraps: [bool; N],
    /// Whether all have one reference, or one disturbance.
    common: [bool; 2],
    /// The latest time with the set-points, and with the disturbances that depend on it alone.
    latest: Option<(f64, Setpoint<N, Abreast>, Option<Vector<N, Abreast>>)>,
    /// Zero as long as all numbers of the run in a lane are finite, and the farthest that it went.
    lost: Abreast,
    farthest: Abreast,
    smooth: Smooth<N, Abreast>,
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
    pub fn new(cases: [&'a Case<'a, N, A, D, L, C, R, S>; LANES]) -> Option<Self> {
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
        let of_reference = cases.iter().all(|case| core::ptr::eq(case.reference, first.reference));
        let disturbance = &first.plant.disturbance;
        let of_disturbance = cases.iter().all(|case| case.plant.disturbance.is_same(disturbance));
        let zero = Abreast::all(0.0);
        Some(Self {
            plants: A::abreast(cases.map(|case| &case.plant.arm))?,
            laws: L::abreast(cases.map(|case| &case.controller.law))?,
            compensators: Estimators::new(cases),
            cases,
            limits,
            wraps,
            common: [of_reference, of_disturbance],
            latest: None,
            lost: zero,
            farthest: zero,
            smooth: Smooth::new(zero),
        })
    }

    /// Makes the runs: the metrics of those in which all was ordinary.
    pub fn run(self, course: Course<'_>) -> [Option<[Metrics; N]>; LANES] {
        Arch::new().dispatch(Whole { loops: self, course })
    }

    #[inline(always)]
    fn go(&mut self, course: Course<'_>) -> [Option<[Metrics; N]>; LANES] {
        let Course { steps, h, every, window, stop } = course;
        let zero = Abreast::all(0.0);
        let mut figures = Figures::<N, Abreast>::over(window, zero);
        let of = |start: fn(&Case<'a, N, A, D, L, C, R, S>) -> [f64; N]| {
            Vector::<N, Abreast>::from_fn(|n, _| Abreast::of(self.cases, |case| start(case)[n]))
        };
        let mut motion = Motion { q: of(|case| case.q0), dq: of(|case| case.dq0) };
        for k in 0..=steps {
            let t = k as f64 * h;
            let (seen, applied, ddq, rho) = self.evaluate(&RK4.stage(0, h), t, &motion);
            self.check(&seen, &rho);
            if k % every == 0 || k == steps {
                figures.add(t, &seen.e, &applied);
            }
            if k == steps {
                break;
            }
            if k % LOOK_EVERY == 0 && (stop.load(Ordering::Relaxed) || self.all_lost()) {
                return [None; LANES];
            }
            let times = (t, h, (k + 1) as f64 * h);
            let moved = Moved::by_rk4(h, &motion, &ddq, |stage, at| {
                self.evaluate(stage, time_of(stage, times), at).2
            });
            self.compensators.advance(&RK4.end(h, 4), &mut self.lost);
            self.smooth.add(h, &motion, &moved);
            motion = moved.motion;
        }
        core::array::from_fn(|lane| {
            let ordinary = self.is_ordinary(lane) && self.smooth.is_resolved(lane);
            figures.finish(|x| x.0[lane]).filter(|_| ordinary)
        })
    }

    /// What the controllers see at a stage, what acts, q̈, and ρ.
    #[inline(always)]
    fn evaluate(
        &mut self,
        stage: &Stage<'_>,
        t: f64,
        Motion { q, dq }: &Motion<N, Abreast>,
    ) -> (Sample<N, Abreast>, Vector<N, Abreast>, Vector<N, Abreast>, Vector<N, Abreast>) {
        let (desired, disturbance) = self.at_time(t);
        let seen = Sample::wrapped(*q, *dq, desired, &self.wraps);
        let rho_hat = self.compensators.estimate(stage, &seen);
        let demand = self.laws.torque(&seen, &rho_hat);
        let asked = sum(&demand.model, &demand.compensation);
        let [controllers, plants] = &self.limits;
        let applied = plants.clamp(&controllers.clamp(&asked));
        self.compensators.acted(stage.index, &seen, &asked, &applied);
        let tau_d = disturbance.unwrap_or_else(|| self.disturbances(q, dq, t));
        let net = Vector::<N, Abreast>::from_fn(|n, _| applied[n] - tau_d[n]);
        let ddq = self.plants.forward_dynamics(q, dq, &net);
        let rho = Vector::<N, Abreast>::from_fn(|n, _| ddq[n] - demand.v[n] + rho_hat[n]);
        (seen, applied, ddq, rho)
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

    /// Notes what is not finite, and how far the motion went.
    #[inline(always)]
    fn check(&mut self, seen: &Sample<N, Abreast>, rho: &Vector<N, Abreast>) {
        let Sample { q, dq, desired, .. } = seen;
        for n in 0..N {
            for x in [q[n], dq[n], desired.q[n], desired.dq[n], desired.ddq[n], rho[n]] {
                self.lost += x * Abreast::all(0.0);
            }
            self.farthest = self.farthest.or_larger(q[n].abs()).or_larger(dq[n].abs());
        }
    }

    fn is_ordinary(&self, lane: usize) -> bool {
        self.lost.0[lane] == 0.0 && self.farthest.0[lane] <= DIVERGED
    }

    fn all_lost(&self) -> bool {
        (0..LANES).all(|lane| !self.is_ordinary(lane))
    }
}

/// All of it, for the instruction set at hand.
struct Whole<'a, 'b, const N: usize, A, D, L, C, R, S> {
    loops: Loops<'a, N, A, D, L, C, R, S>,
    course: Course<'b>,
}

impl<const N: usize, A, D, L, C, R, S> WithSimd for Whole<'_, '_, N, A, D, L, C, R, S>
where
    A: Arm<N>,
    D: Disturbance<N>,
    L: Law<N>,
    C: Compensator<N, S>,
    R: Reference<N>,
    S: Clone,
{
    type Output = [Option<[Metrics; N]>; LANES];

    #[inline(always)]
    fn with_simd<I: Simd>(mut self, _: I) -> Self::Output {
        self.loops.go(self.course)
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

#[inline(always)]
fn sum<const N: usize>(x: &Vector<N, Abreast>, y: &Vector<N, Abreast>) -> Vector<N, Abreast> {
    Vector::<N, Abreast>::from_fn(|n, _| x[n] + y[n])
}

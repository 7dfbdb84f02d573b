//! Eight runs side by side, in continuous time by RK4: a run a lane.
//!
//! What a step does is what [`rk4`](crate::sim::continuous) does of one run, without friction and
//! without a record. Here nothing ends early and nothing is told: a lane in which anything is out
//! of the ordinary is lost, and its run is made once more, alone.

use core::sync::atomic::{AtomicBool, Ordering};

use pulp::Arch;

use super::bodies::Bodies;
use super::case::Case;
use super::estimators::Estimators;
use crate::arm::{Arm, ArmsAbreast};
use crate::control::{Compensator, Law, LawsAbreast, Limits, Sample, Stage};
use crate::math::{Abreast, LANES, Vector, lane, none_missing};
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
    /// The latest time with the set-points, with the disturbances, and whether these depend on the
    /// time alone.
    time: f64,
    desired: Setpoint<N, Abreast>,
    tau_d: Vector<N, Abreast>,
    timely: bool,
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
    /// The loops of these runs with this instruction set; `None` where they cannot go side by side.
    pub fn new(
        cases: [&'a Case<'a, N, A, D, L, C, R, S>; LANES],
        window: Window,
        arch: Arch,
    ) -> Option<Self> {
        let [first, ..] = cases;
        let wraps = first.controller.law.wraps();
        if cases.iter().any(|case| case.controller.law.wraps() != wraps) {
            return None;
        }
        let limits = [
            effort_limits(cases.map(|case| &case.controller.limits.effort_limit)),
            effort_limits(cases.map(|case| case.plant.effort_limit())),
        ];
        let zero = Abreast::all(0.0);
        let zeros = Vector::<N, Abreast>::repeat(zero);
        let start = Motion {
            q: side_by_side(&cases.map(|case| case.q0.into())),
            dq: side_by_side(&cases.map(|case| case.dq0.into())),
        };
        let desired = Setpoint { q: zeros, dq: zeros, ddq: zeros };
        let plants = ArmsAbreast::of(none_missing(cases.map(|case| case.plant.arm.side()))?)?;
        let laws =
            LawsAbreast::of(none_missing(cases.map(|case| case.controller.law.computed()))?)?;
        let bodies = Bodies {
            arch,
            one_pose: plants.pose_as(laws.arms()),
            plants,
            laws,
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
        Some(Self {
            cases,
            bodies: Box::new(bodies),
            compensators,
            common,
            time: f64::NAN,
            desired,
            tau_d: zeros,
            timely: true,
        })
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
            let arch = self.bodies.arch;
            self.compensators.advance(arch, &RK4.end(h, 4), &mut self.bodies.lost);
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
        // Two stages often fall on one time.
        if time != self.time {
            self.ask(time);
        }
        self.bodies.go(stage.index, h, &self.desired);
        if !self.timely {
            self.disturb(time);
        }
        let Bodies { arch, seen, lost, .. } = &mut *self.bodies;
        let rho_hat = self.compensators.estimate(*arch, stage, seen, lost);
        self.bodies.act(stage.index, rho_hat, &self.tau_d);
        let Bodies { arch, seen, asked, applied, .. } = &*self.bodies;
        self.compensators.acted(*arch, stage.index, seen, asked, applied);
    }

    /// Asks for the set-points at a time, and for the disturbances if they depend on it alone.
    fn ask(&mut self, t: f64) {
        let [one_reference, one_disturbance] = self.common;
        (self.time, self.timely) = (t, true);
        let (mut setpoint, mut tau_d) = (None, None);
        for (i, case) in self.cases.iter().enumerate() {
            let asked = setpoint.filter(|_| one_reference);
            let Setpoint { q, dq, ddq } =
                *setpoint.insert(asked.unwrap_or_else(|| case.reference.at(t)));
            let push = tau_d.filter(|_| one_disturbance);
            let push = *tau_d.insert(push.unwrap_or_else(|| case.plant.disturbance.at_time(t)));
            self.timely &= push.is_some();
            for n in 0..N {
                self.desired.q[n].0[i] = q[n];
                self.desired.dq[n].0[i] = dq[n];
                self.desired.ddq[n].0[i] = ddq[n];
                self.tau_d[n].0[i] = push.map_or(0.0, |push| push[n]);
            }
        }
    }

    /// Asks for disturbances that depend on the motion.
    fn disturb(&mut self, t: f64) {
        let Sample { q, dq, .. } = &self.bodies.seen;
        for (i, case) in self.cases.iter().enumerate() {
            let push = case.plant.disturbance.torque(&lane(q, i), &lane(dq, i), t);
            for n in 0..N {
                self.tau_d[n].0[i] = push[n];
            }
        }
    }

    fn all_lost(&self) -> bool {
        (0..LANES).all(|lane| !self.bodies.is_ordinary(lane))
    }
}

/// Limits of effort, those of a run a lane.
fn effort_limits<const N: usize>(each: [&[f64; N]; LANES]) -> Limits<N, Abreast> {
    Limits {
        effort_limit: core::array::from_fn(|n| Abreast::of(each, |limit| limit[n])),
        effort_rate_limit: [Abreast::all(f64::INFINITY); N],
    }
}

/// Vectors, a lane each.
#[inline(always)]
pub(super) fn side_by_side<const N: usize>(all: &[Vector<N>; LANES]) -> Vector<N, Abreast> {
    Vector::<N, Abreast>::from_fn(|n, _| Abreast::of(all.each_ref(), |x| x[n]))
}

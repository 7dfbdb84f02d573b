//! Eight runs side by side, in continuous time by RK4: a run a lane.
//!
//! What a step does is what [`rk4`](crate::sim::continuous) does of one run, without friction and
//! without a record. Here nothing ends early and nothing is told: a lane in which anything is out
//! of the ordinary is lost, and its run is made once more, alone.

use super::bodies::{Bodies, Drivers};
use super::case::Case;
use super::course::Course;
use super::estimators::Estimators;
use super::forces::Push;
use super::surroundings::Surroundings;
use crate::arm::Arm;
use crate::control::{Compensator, Law, Stage};
use crate::math::LANES;
use crate::plant::Disturbance;
use crate::reference::Reference;
use crate::sim::closed_loop::time_of;
use crate::sim::integrators::RK4;
use crate::sim::metrics::Metrics;

/// The loops of eight runs.
pub(super) struct Loops<'a, const N: usize, A, D, L, C, R, S> {
    around: Surroundings<'a, N, A, D, L, C, R, S>,
    bodies: Box<Bodies<N>>,
    drivers: Box<Drivers<N>>,
    compensators: Estimators<'a, N, C, S>,
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
    pub fn new(
        cases: [&'a Case<'a, N, A, D, L, C, R, S>; LANES],
        bodies: Bodies<N>,
    ) -> Option<Self> {
        let drivers = Box::new(Drivers::new(cases, &bodies)?);
        Some(Self {
            around: Surroundings::new(cases),
            bodies: Box::new(bodies),
            drivers,
            compensators: Estimators::new(cases),
        })
    }

    /// Makes the runs: the metrics of those in which all was ordinary.
    pub fn run(mut self, course: Course<'_>) -> [Option<[Metrics; N]>; LANES] {
        let Course { steps, h, .. } = course;
        for k in 0..=steps {
            let times = (k as f64 * h, h, (k + 1) as f64 * h);
            self.stage(&RK4.stage(0, h), times);
            self.bodies.note(times.0, course.counts(k));
            if k == steps {
                break;
            }
            if course.ends(k, &self.bodies) {
                return [None; LANES];
            }
            for i in 1..4 {
                self.stage(&RK4.stage(i, h), times);
            }
            let Bodies { arch, lost, .. } = &mut *self.bodies;
            self.compensators.advance(*arch, &RK4.end(h, 4), lost);
            self.bodies.end(h);
        }
        self.bodies.metrics()
    }

    /// A stage of a step of `h` from `t` to `end` \[s\].
    fn stage(&mut self, stage: &Stage<'_>, (t, h, end): (f64, f64, f64)) {
        let Self { around, bodies, drivers, compensators } = self;
        let time = time_of(stage, (t, h, end));
        around.ask(time);
        bodies.go(stage.index, h, &around.desired);
        around.push(time, &bodies.now.seen);
        let Bodies { arch, now, lost, .. } = &mut **bodies;
        let rho_hat = compensators.estimate(*arch, stage, &now.seen, lost);
        let push = Push { i: stage.index, h, tau_d: &around.tau_d, held: false };
        bodies.act(drivers, rho_hat, push);
        let Bodies { arch, now, .. } = &**bodies;
        compensators.acted(*arch, stage.index, now, drivers.limited);
    }
}

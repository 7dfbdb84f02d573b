//! Eight runs of sampled control side by side, by RK4 between the samples: a run a lane.
//!
//! A lane in which anything is out of the ordinary is lost, as in [`abreast`](super::abreast).

use super::bodies::{Bodies, Now};
use super::case::Case;
use super::course::Course;
use super::deciders::Deciders;
use super::forces::Push;
use super::surroundings::Surroundings;
use super::together::Together;
use crate::arm::Arm;
use crate::control::{Compensator, Law};
use crate::math::LANES;
use crate::plant::Disturbance;
use crate::reference::Reference;
use crate::sim::integrators::RK4;
use crate::sim::metrics::Metrics;

/// The loops of eight runs.
pub(super) struct SampledLoops<'a, const N: usize, A, D, L, C, R, S> {
    around: Surroundings<'a, N, A, D, L, C, R, S>,
    bodies: Box<Bodies<N>>,
    deciders: Deciders<'a, N, A, D, L, C, R, S>,
}

impl<'a, const N: usize, A, D, L, C, R, S> SampledLoops<'a, N, A, D, L, C, R, S>
where
    A: Arm<N>,
    D: Disturbance<N>,
    L: Law<N>,
    C: Compensator<N, S>,
    R: Reference<N>,
    S: Clone,
{
    /// The loops of these runs.
    pub fn new(
        cases: [&'a Case<'a, N, A, D, L, C, R, S>; LANES],
        bodies: Bodies<N>,
        course: Course<'_>,
    ) -> Self {
        let deciders = Deciders::new(cases, &bodies, course);
        Self { around: Surroundings::new(cases), bodies: Box::new(bodies), deciders }
    }

    /// Makes the runs: the metrics of those in which all was ordinary.
    pub fn run(mut self, course: Course<'_>) -> [Option<[Metrics; N]>; LANES] {
        let Course { steps, h, hold, .. } = course;
        for k in 0..=steps {
            let t = k as f64 * h;
            self.around.ask(t);
            self.bodies.go(0, h, &self.around.desired);
            if k.is_multiple_of(hold) && k < steps {
                self.decide(k > 0, hold as f64 * h, (t, h));
            } else {
                self.hold(h, t);
            }
            self.bodies.note(t, course.counts(k));
            if k == steps {
                break;
            }
            if course.ends(k, &self.bodies) {
                return [None; LANES];
            }
            self.go_on(h, t);
            for i in 1..4 {
                self.bodies.go(i, h, &self.around.desired);
                self.fly((i, h), t + RK4.nodes[i] * h);
            }
            self.bodies.end(h);
        }
        match &mut self.deciders {
            Deciders::Abreast(together) => end(together, &mut self.bodies, hold as f64 * h),
            Deciders::Apart(measured) => {
                let Bodies { arch, lost, .. } = &mut *self.bodies;
                measured.end(*arch, hold as f64 * h, lost);
            }
            Deciders::Each(each) => each.end(&mut self.bodies),
            Deciders::Affected(affected) => affected.end(&mut self.bodies, hold as f64 * h),
        }
        self.bodies.metrics()
    }

    /// Decides on the torque of a period \[s\], and lets the arms start on a step of `h` \[s\] from
    /// time `t`. The period before ends, if that has `begun`.
    fn decide(&mut self, begun: bool, period: f64, (t, h): (f64, f64)) {
        let Self { around, bodies, deciders } = self;
        match deciders {
            Deciders::Abreast(together) => {
                around.push(t, &bodies.now.seen);
                if begun {
                    end(together, bodies, period);
                }
                let Bodies { arch, now, lost, .. } = &mut **bodies;
                Together::feel(*arch, &now.seen, lost);
                let rho_hat = *together.estimate(*arch, &now.seen, lost);
                let push = Push { i: 0, h, tau_d: &around.tau_d, held: true };
                bodies.act(&together.drivers, &rho_hat, push);
            }
            Deciders::Apart(measured) => {
                measured.drive(bodies, begun, period);
                self.hold(h, t);
            }
            Deciders::Each(each) => {
                each.decide(bodies, begun, period);
                self.hold(h, t);
            }
            Deciders::Affected(affected) => {
                affected.decide(bodies, period, t);
                self.hold(h, t);
            }
        }
    }

    /// What acts at a row, at time `t` \[s\], before a step of `h` \[s\].
    fn hold(&mut self, h: f64, t: f64) {
        if let Deciders::Affected(affected) = &self.deciders {
            affected.arrived(&mut self.bodies);
        }
        self.fly((0, h), t);
    }

    /// Starts on the step, where another torque acts in it than at its row.
    fn go_on(&mut self, h: f64, t: f64) {
        if let Deciders::Affected(affected) = &mut self.deciders
            && affected.arriving(&mut self.bodies, h)
        {
            self.fly((0, h), t);
        }
    }

    /// Lets the arms go on at stage i of a step of `h` \[s\], at time `t` \[s\].
    fn fly(&mut self, (i, h): (usize, f64), t: f64) {
        self.around.push(t, &self.bodies.now.seen);
        self.bodies.fly(Push { i, h, tau_d: &self.around.tau_d, held: true });
    }
}

/// Ends a period \[s\] of controllers side by side.
fn end<const N: usize>(together: &mut Together<N>, bodies: &mut Bodies<N>, period: f64) {
    let Bodies { arch, now: Now { asked, applied, .. }, lost, .. } = bodies;
    let limited = together.drivers.limited;
    together.end(*arch, (asked, applied), limited, period, lost);
}

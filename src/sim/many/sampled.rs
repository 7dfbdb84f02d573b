//! Eight runs of sampled control side by side, by RK4 between the samples: a run a lane.
//!
//! The arms move side by side. The controllers, of whatever law, decide one after the other, as
//! each does alone. A lane in which anything is out of the ordinary is lost, as in
//! [`abreast`](super::abreast).

use super::bodies::{Bodies, Now};
use super::case::Case;
use super::course::Course;
use super::surroundings::Surroundings;
use crate::arm::Arm;
use crate::control::{Compensator, Law, State};
use crate::math::{LANES, lane};
use crate::plant::Disturbance;
use crate::reference::Reference;
use crate::sim::integrators::RK4;
use crate::sim::metrics::Metrics;
use crate::sim::options::Method;
use crate::sim::sampled::Sampled;

/// The loops of eight runs.
pub(super) struct SampledLoops<'a, const N: usize, A, D, L, C, R, S> {
    around: Surroundings<'a, N, A, D, L, C, R, S>,
    bodies: Box<Bodies<N>>,
    each: [Sampled<'a, N, A, D, L, C, R>; LANES],
    states: [State<N, S>; LANES],
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
        Course { hold, h, .. }: Course<'_>,
    ) -> Self {
        let each = cases.map(|&Case { plant, controller, reference, .. }| Sampled {
            plant,
            controller,
            reference,
            hold,
            dt: h,
            method: Method::Rk4,
        });
        let states = cases.map(|case| case.state.clone());
        Self { around: Surroundings::new(cases), bodies: Box::new(bodies), each, states }
    }

    /// Makes the runs: the metrics of those in which all was ordinary.
    pub fn run(mut self, course: Course<'_>) -> [Option<[Metrics; N]>; LANES] {
        let Course { steps, h, hold, .. } = course;
        for k in 0..=steps {
            let t = k as f64 * h;
            self.around.ask(t);
            self.bodies.go(0, h, &self.around.desired);
            if k.is_multiple_of(hold) && k < steps {
                self.decide(k > 0, hold as f64 * h);
            }
            self.fly((0, h), t);
            self.bodies.note(t, course.counts(k));
            if k == steps {
                break;
            }
            if course.ends(k, &self.bodies) {
                return [None; LANES];
            }
            for i in 1..4 {
                self.bodies.go(i, h, &self.around.desired);
                self.fly((i, h), t + RK4.nodes[i] * h);
            }
            self.bodies.end(h);
        }
        self.end();
        self.bodies.metrics()
    }

    /// Lets the arms go on at stage i of a step of `h` \[s\], at time `t` \[s\].
    fn fly(&mut self, (i, h): (usize, f64), t: f64) {
        self.around.push(t, &self.bodies.now.seen);
        self.bodies.fly((i, h), &self.around.tau_d);
    }

    /// Asks every controller for the torque of a period \[s\]; it is told what acted in the one
    /// before, if that has `begun`. One that refuses is lost.
    fn decide(&mut self, begun: bool, period: f64) {
        let Bodies { now: Now { seen, applied, v, rho_hat, .. }, lost, .. } = &mut *self.bodies;
        for (i, (sampled, state)) in self.each.iter().zip(&mut self.states).enumerate() {
            if lost.0[i] != 0.0 {
                continue;
            }
            let before = begun.then(|| lane(applied, i));
            match sampled.decide(state, before.as_ref(), &seen.lane(i), period) {
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
    fn end(&mut self) {
        let Bodies { now: Now { applied, .. }, lost, .. } = &mut *self.bodies;
        for (i, (sampled, state)) in self.each.iter().zip(&mut self.states).enumerate() {
            if sampled.controller.end_period(state, Some(&lane(applied, i))).is_err() {
                lost.0[i] = f64::NAN;
            }
        }
    }
}

//! What eight runs are asked to do, and what pushes them: set-points and disturbances.

use super::case::Case;
use crate::arm::Arm;
use crate::control::Sample;
use crate::math::{Abreast, LANES, Vector, lane};
use crate::plant::{Disturbance, Plant};
use crate::reference::{Reference, Setpoint};

/// The references and disturbances of eight runs, and what they say at the latest time asked for.
pub(super) struct Surroundings<'a, const N: usize, A, D, L, C, R, S> {
    cases: [&'a Case<'a, N, A, D, L, C, R, S>; LANES],
    /// Whether all have one reference, or one disturbance.
    one_reference: bool,
    one_disturbance: bool,
    pub desired: Setpoint<N, Abreast>,
    pub tau_d: Vector<N, Abreast>,
    /// The times of these \[s\]. Two stages often fall on one time.
    desired_at: f64,
    pushed_at: f64,
    /// Whether all disturbances depend on the time alone.
    timely: bool,
}

impl<'a, const N: usize, A, D, L, C, R, S> Surroundings<'a, N, A, D, L, C, R, S>
where
    A: Arm<N>,
    D: Disturbance<N>,
    R: Reference<N>,
{
    /// Those of these runs.
    pub fn new(cases: [&'a Case<'a, N, A, D, L, C, R, S>; LANES]) -> Self {
        let (reference, disturbance) = (cases[0].reference, &cases[0].plant.disturbance);
        let zeros = Vector::<N, Abreast>::repeat(Abreast::all(0.0));
        Self {
            one_reference: cases.iter().all(|case| core::ptr::eq(case.reference, reference)),
            one_disturbance: cases.iter().all(|case| case.plant.disturbance.is_same(disturbance)),
            cases,
            desired: Setpoint { q: zeros, dq: zeros, ddq: zeros },
            tau_d: zeros,
            desired_at: f64::NAN,
            pushed_at: f64::NAN,
            timely: true,
        }
    }

    /// Asks for the set-points at time `t` \[s\].
    pub fn ask(&mut self, t: f64) {
        if t == self.desired_at {
            return;
        }
        self.desired_at = t;
        if self.one_reference {
            let Setpoint { q, dq, ddq } = self.cases[0].reference.at(t);
            for n in 0..N {
                self.desired.q[n] = Abreast::all(q[n]);
                self.desired.dq[n] = Abreast::all(dq[n]);
                self.desired.ddq[n] = Abreast::all(ddq[n]);
            }
            return;
        }
        for (i, case) in self.cases.iter().enumerate() {
            let Setpoint { q, dq, ddq } = case.reference.at(t);
            for n in 0..N {
                self.desired.q[n].0[i] = q[n];
                self.desired.dq[n].0[i] = dq[n];
                self.desired.ddq[n].0[i] = ddq[n];
            }
        }
    }

    /// Asks for the disturbances at time `t` \[s\] and in this motion.
    pub fn push(&mut self, t: f64, Sample { q, dq, .. }: &Sample<N, Abreast>) {
        if t == self.pushed_at && self.timely {
            return;
        }
        self.pushed_at = t;
        if self.one_disturbance
            && let Some(tau_d) = self.cases[0].plant.disturbance.at_time(t)
        {
            self.timely = true;
            for n in 0..N {
                self.tau_d[n] = Abreast::all(tau_d[n]);
            }
            return;
        }
        self.timely = !self.one_disturbance;
        for (i, case) in self.cases.iter().enumerate() {
            let Plant { disturbance, .. } = case.plant;
            let known = if self.one_disturbance { None } else { disturbance.at_time(t) };
            self.timely &= known.is_some();
            let push = |q, dq| disturbance.torque(&q, &dq, t);
            let tau_d = known.unwrap_or_else(|| push(lane(q, i), lane(dq, i)));
            for n in 0..N {
                self.tau_d[n].0[i] = tau_d[n];
            }
        }
    }
}

//! What eight runs are asked to do, and what pushes them: set-points and disturbances.

use pulp::Simd;

use super::case::Case;
use crate::arm::Arm;
use crate::control::Sample;
use crate::math::{Abreast, LANES, Load, Register, Vector, column, lane};
use crate::plant::{Disturbance, Plant};
use crate::reference::{Reference, Setpoint};

/// A vector of each of eight runs, and the one that is the same for all, if there is one. Kernels
/// spread that over lanes themselves: what was written in pieces would be read late.
pub(super) struct Told<const N: usize> {
    to_all: Option<Vector<N>>,
    to_each: Vector<N, Abreast>,
}

impl<const N: usize> Told<N> {
    fn nothing() -> Self {
        Self { to_all: None, to_each: Vector::<N, Abreast>::repeat(Abreast::all(0.0)) }
    }

    /// Tells the run in a lane something of its own.
    fn tell(&mut self, i: usize, x: &Vector<N>) {
        self.to_all = None;
        for n in 0..N {
            self.to_each[n].0[i] = x[n];
        }
    }
}

impl<const N: usize> Load for Told<N> {
    type In<S: Simd> = Vector<N, Register<S>>;

    #[inline(always)]
    fn load<S: Simd>(&self, simd: S, part: usize) -> Self::In<S> {
        let Some(x) = &self.to_all else { return self.to_each.load(simd, part) };
        let mut spread = column([Abreast::all(x[0]).load(simd, part); N]);
        for n in 1..N {
            spread[n] = Abreast::all(x[n]).load(simd, part);
        }
        spread
    }
}

/// Set-points of eight runs.
pub(super) struct Desired<const N: usize> {
    q: Told<N>,
    dq: Told<N>,
    ddq: Told<N>,
}

impl<const N: usize> Load for Desired<N> {
    type In<S: Simd> = Setpoint<N, Register<S>>;

    #[inline(always)]
    fn load<S: Simd>(&self, simd: S, part: usize) -> Self::In<S> {
        let Self { q, dq, ddq } = self;
        Setpoint { q: q.load(simd, part), dq: dq.load(simd, part), ddq: ddq.load(simd, part) }
    }
}

/// The references and disturbances of eight runs, and what they say at the latest time asked for.
pub(super) struct Surroundings<'a, const N: usize, A, D, L, C, R, S> {
    cases: [&'a Case<'a, N, A, D, L, C, R, S>; LANES],
    /// Whether all have one reference, or one disturbance.
    one_reference: bool,
    one_disturbance: bool,
    pub desired: Desired<N>,
    pub tau_d: Told<N>,
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
        Self {
            one_reference: cases.iter().all(|case| core::ptr::eq(case.reference, reference)),
            one_disturbance: cases.iter().all(|case| case.plant.disturbance.is_same(disturbance)),
            cases,
            desired: Desired { q: Told::nothing(), dq: Told::nothing(), ddq: Told::nothing() },
            tau_d: Told::nothing(),
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
        let Desired { q, dq, ddq } = &mut self.desired;
        if self.one_reference {
            let desired = self.cases[0].reference.at(t);
            (q.to_all, dq.to_all) = (Some(desired.q), Some(desired.dq));
            ddq.to_all = Some(desired.ddq);
            return;
        }
        for (i, case) in self.cases.iter().enumerate() {
            let desired = case.reference.at(t);
            q.tell(i, &desired.q);
            dq.tell(i, &desired.dq);
            ddq.tell(i, &desired.ddq);
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
            self.tau_d.to_all = Some(tau_d);
            return;
        }
        self.timely = !self.one_disturbance;
        for (i, case) in self.cases.iter().enumerate() {
            let Plant { disturbance, .. } = case.plant;
            let known = if self.one_disturbance { None } else { disturbance.at_time(t) };
            self.timely &= known.is_some();
            let push = |q, dq| disturbance.torque(&q, &dq, t);
            self.tau_d.tell(i, &known.unwrap_or_else(|| push(lane(q, i), lane(dq, i))));
        }
    }
}

//! A sampled controller in single precision, for microcontrollers whose FPU has no double: computed
//! torque with constant gains, and a grid of rules a joint that learns (eqs. 7, 11, 18). Where the
//! numbers of a step are all `f32`, none of it is done in software.
//!
//! It is made of a [`Controller`] and says what that says, as far as seven digits go.

use super::checks::{NEAR, POSSIBLE};
use super::computed_torque::computed;
use super::gains::feedback;
use super::learns::Kind;
use super::limits::Limits;
use super::{Compensator, Controller, Front, Inputs, Law, Sample, State};
use crate::arm::SingleArm;
use crate::error::{Error, Result, at_most};
use crate::fuzzy::{MOST_SPACED, Spaced};
use crate::math::{Real, Vector};
use crate::reference::Setpoint;

/// Positions and velocities beyond these are refused [rad, rad/s]; of the acceleration, too.
const FARTHEST: f32 = 1e5;
const FASTEST: f32 = 1e10;
/// Weights beyond this are refused: sums of their products with a mass matrix are still numbers.
const MOST_WEIGHT: f32 = 1e15;

/// The controller. `RULES` is the room for the rules of a joint.
#[derive(Clone, Debug)]
pub struct Single<const N: usize, const RULES: usize> {
    arm: SingleArm<N>,
    kp: [f32; N],
    kv: [f32; N],
    wraps: [bool; N],
    limits: Limits<N, f32>,
    learns: Option<Grids<N>>,
}

/// A grid a joint, over two inputs.
#[derive(Clone, Debug)]
struct Grids<const N: usize> {
    inputs: Inputs,
    scales: [f32; 2],
    sets: [[Spaced<f32>; 2]; N],
    normalized: bool,
    p12: [f32; N],
    p22: [f32; N],
    gain: [f32; N],
}

/// What it remembers: the weights, and the period that has not ended.
#[derive(Clone, Debug, PartialEq)]
pub struct SingleState<const N: usize, const RULES: usize> {
    weights: [[f32; RULES]; N],
    pending: Option<Pending<N>>,
}

/// What a period was decided on: the memberships of each input of each joint, what drives the
/// weights, and the period \[s\].
#[derive(Clone, Copy, Debug, PartialEq)]
struct Pending<const N: usize> {
    memberships: [[[f32; MOST_SPACED]; 2]; N],
    drive: [f32; N],
    dt: f32,
}

impl<const N: usize, const RULES: usize> Single<N, RULES> {
    /// The controller of the same numbers, and its state with the same weights.
    ///
    /// # Errors
    /// [`NotSingle`](crate::Problem::NotSingle), naming `law`, `compensator`, `front`, `sets` or
    /// `effort_rate_limit`. `rules`: more a joint than `RULES`.
    pub fn of<L: Law<N>, C: Compensator<N, S>, S>(
        controller: &Controller<N, L, C>,
        state: &mut State<N, S>,
    ) -> Result<(Self, SingleState<N, RULES>)> {
        let Controller { law, compensator, limits, front } = controller;
        let (Some(side), Some(gains)) = (law.model(), law.constant_gains()) else {
            let wanted = "computed torque with constant gains, of a TwoLink or of a Serial of 10 \
                          joints at the most, without stops and dry friction";
            return Err(Error::not_single("law", wanted));
        };
        if *front != Front::default() {
            return Err(Error::not_single("front", "none"));
        }
        if limits.limits_rate() {
            return Err(Error::not_single("effort_rate_limit", "none"));
        }
        let mut weights = [[0.0; RULES]; N];
        let learns = match compensator.learns(controller.settle(state)).map(|it| it.0) {
            Some(Kind::Nothing) => None,
            Some(Kind::PerJoint(it)) if it.is_plain() => {
                let [rows, columns] = it.sets[0].each_ref().map(Spaced::len);
                at_most("rules", rows * columns, RULES)?;
                for (n, own) in weights.iter_mut().enumerate() {
                    let from = &it.weights[n * it.row..][..rows * columns];
                    own.iter_mut().zip(from).for_each(|(to, w)| *to = *w as f32);
                }
                let mut sets = [[Spaced::<f32>::NOTHING; 2]; N];
                for (to, from) in sets.iter_mut().flatten().zip(it.sets.iter().flatten()) {
                    let wanted = "centers closer to each other: (c - c')^2 / 2 width^2 <= 20";
                    *to = from.single().ok_or(Error::not_single("sets", wanted))?;
                }
                let [first, second] = [0, 1].map(|k| it.inputs.signals()[k].1 as f32);
                let (inputs, scales, normalized) = (it.inputs, [first, second], it.normalized);
                let [p12, p22, gain] = [it.p12, it.p22, it.gain].map(|of| of.map(|x| x as f32));
                Some(Grids { inputs, scales, sets, normalized, p12, p22, gain })
            }
            _ => {
                let wanted = "none, or a basis per joint over two inputs with evenly stepped \
                              sets, which moves by the law (18) alone and is not frozen";
                return Err(Error::not_single("compensator", wanted));
            }
        };
        let single = Self {
            arm: SingleArm::of(side),
            kp: gains.kp.map(|x| x as f32),
            kv: gains.kv.map(|x| x as f32),
            wraps: law.wraps(),
            limits: Limits {
                effort_limit: limits.effort_limit.map(|x| x as f32),
                effort_rate_limit: [f32::INFINITY; N],
            },
            learns,
        };
        Ok((single, SingleState { weights, pending: None }))
    }

    /// One sample: ends the period before, then gives the torque [N·m] to hold for `dt` \[s\].
    /// Allocates nothing and cannot panic.
    ///
    /// # Errors
    /// `q`, `q_d`: not finite, or beyond 1e5 rad. `dq`, `dq_d`, `ddq_d`: not finite, or beyond
    /// 1e10. `dt`: not between 1 µs and 1 s. `weights`: they could become larger than 1e15. Nothing
    /// has changed then. `tau`: the torque is not finite; the period before has ended.
    pub fn step(
        &self,
        state: &mut SingleState<N, RULES>,
        q: &Vector<N, f32>,
        dq: &Vector<N, f32>,
        desired: &Setpoint<N, f32>,
        dt: f32,
    ) -> Result<Vector<N, f32>> {
        check(q, dq, desired, dt)?;
        let seen = Sample::wrapped(*q, *dq, *desired, &self.wraps);
        let mut rho_hat = Vector::<N, f32>::repeat(0.0);
        if let Some(grids) = &self.learns {
            let next = grids.look(&seen, dt);
            grids.admit(state, &next)?;
            state.end(grids);
            for n in 0..N {
                rho_hat[n] = grids.contract(&state.weights[n], &next.memberships[n]);
            }
            state.pending = Some(next);
        }
        let (mass, bias) = self.arm.mass_matrix_and_bias(q, dq);
        let demand = computed((&mass, &bias), feedback(&self.kp, &self.kv, &seen), &rho_hat);
        let mut asked = demand.model;
        for n in 0..N {
            asked[n] += demand.compensation[n];
        }
        let tau = self.limits.clamp(&asked);
        let limited = tau != asked;
        if let Some(pending) = state.pending.as_mut().filter(|_| limited) {
            pending.drive = [0.0; N];
        }
        match tau.iter().position(|tau| !tau.is_finite()) {
            None => Ok(tau),
            Some(n) => {
                state.pending = None;
                Err(Error::not_finite("tau", tau[n].into()).at(n))
            }
        }
    }

    /// Forgets what was learnt.
    pub fn reset(&self, state: &mut SingleState<N, RULES>) {
        *state = SingleState { weights: [[0.0; RULES]; N], pending: None };
    }
}

impl<const N: usize, const RULES: usize> SingleState<N, RULES> {
    /// The weights of each joint, rule after rule, at the start of the period that is pending.
    pub fn weights(&self) -> &[[f32; RULES]; N] {
        &self.weights
    }

    /// Ends the period that is pending: D ← D + h Γ s ξᵀ.
    fn end(&mut self, grids: &Grids<N>) {
        let Some(Pending { memberships, drive, dt }) = self.pending.take() else { return };
        for (n, weights) in self.weights.iter_mut().enumerate() {
            let ([rows, columns], [first, second]) = (grids.lengths(n), &memberships[n]);
            for (row, p) in weights.chunks_exact_mut(columns).zip(&first[..rows]) {
                let share = dt * drive[n] * p;
                row.iter_mut().zip(second).for_each(|(w, q)| *w += share * q);
            }
        }
    }
}

impl<const N: usize> Grids<N> {
    /// Sets of both inputs of a joint.
    fn lengths(&self, n: usize) -> [usize; 2] {
        self.sets[n].each_ref().map(Spaced::len)
    }

    /// What a sample says to the weights: memberships, and what drives.
    fn look(&self, seen: &Sample<N, f32>, dt: f32) -> Pending<N> {
        let mut pending =
            Pending { memberships: [[[0.0; MOST_SPACED]; 2]; N], drive: [0.0; N], dt };
        for n in 0..N {
            for (k, (signal, _)) in self.inputs.signals().iter().enumerate() {
                let sets = &self.sets[n][k];
                let x = sets.within(self.scales[k] * signal.of(seen)[n]);
                let input = (x, sets.exponent(x).0.series_exp());
                pending.memberships[n][k] = sets.memberships(input, sets.steps(), self.normalized);
            }
            let s = self.p12[n] * seen.e[n] + self.p22[n] * seen.de[n];
            pending.drive[n] = self.gain[n] * s;
        }
        pending
    }

    /// Refuses a sample whose drive could take the weights too far.
    fn admit<const RULES: usize>(
        &self,
        state: &SingleState<N, RULES>,
        next: &Pending<N>,
    ) -> Result<()> {
        for n in 0..N {
            let before = state.pending.as_ref().map_or(0.0, |it| it.dt * it.drive[n]);
            let change = before.abs() + (next.dt * next.drive[n]).abs();
            let largest = state.weights[n].iter().fold(0.0, |most, w| w.abs().max(most));
            let got = largest + change;
            if got.is_nan() || got > MOST_WEIGHT {
                let wanted = "weights of at most 1e15; lower the gain";
                return Err(Error::out_of_range("weights", got.into(), wanted).at(n));
            }
        }
        Ok(())
    }

    /// w·ξ.
    fn contract(&self, weights: &[f32], [first, second]: &[[f32; MOST_SPACED]; 2]) -> f32 {
        let [rows, columns] = self.lengths(0);
        let mut sum = 0.0;
        for (row, p) in weights.chunks_exact(columns).zip(&first[..rows]) {
            let inner: f32 = row.iter().zip(second).map(|(w, q)| w * q).sum();
            sum += p * inner;
        }
        sum
    }
}

fn check<const N: usize>(
    q: &Vector<N, f32>,
    dq: &Vector<N, f32>,
    desired: &Setpoint<N, f32>,
    dt: f32,
) -> Result<()> {
    let signals = [
        ("q", q, FARTHEST, NEAR),
        ("q_d", &desired.q, FARTHEST, NEAR),
        ("dq", dq, FASTEST, POSSIBLE),
        ("dq_d", &desired.dq, FASTEST, POSSIBLE),
        ("ddq_d", &desired.ddq, FASTEST, POSSIBLE),
    ];
    for (name, signal, most, wanted) in signals {
        for n in 0..N {
            if !signal[n].is_finite() {
                return Err(Error::not_finite(name, signal[n].into()).at(n));
            }
            if signal[n].abs() > most {
                return Err(Error::out_of_range(name, signal[n].into(), wanted).at(n));
            }
        }
    }
    if !(1e-6..=1.0).contains(&dt) {
        return Err(Error::out_of_range("dt", dt.into(), "a period between 1e-6 and 1 s"));
    }
    Ok(())
}

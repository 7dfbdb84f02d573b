//! The end of a period: what the torque that acted says goes through the filters, and the rows
//! whose turn it is are learnt.
//!
//! ```text
//! ζ ← ζ + hp (v + D⁻¹(τ_a − τ_asked) − α)
//! y = LP[τ_a − ID₀ + f₀(q̇_d) − f₀(q̇)] − c d/dt LP[Dė']    φ = LP[Φ]    a row of y = φθ a period
//! ```
//!
//! A row is left out while its joint rests, for friction at rest may be anything, and all are while
//! a limit or a large error is in what the filter sees.

use core::f64::consts::TAU;

use super::features::{FRICTION, friction};
use super::gains::LearningGains;
use super::learned_torque::LearnedTorque;
use super::memory::{Decided, Filtered, LearnedTorqueState, Now, Parts};
use super::regression::TINY;
use crate::arm::{Factor, Parametric};
use crate::fuzzy::Buffer;
use crate::math::{Matrix, Real, Vector, decay};

/// Every row is learnt once in this time \[s\].
const CYCLE: f64 = 0.02;
/// In this time what was learnt is half forgotten, or more: T_f of P \[s\].
const FORGETTING: f64 = 100.0;
/// Cut-off of the velocity on which friction is learnt \[Hz\].
pub(super) const FRICTION_CUT_OFF: f64 = 15.0;
/// Where a joint is farther from the desired motion \[rad\], Φ(q_d) is not what acts; a row is
/// learnt if that was so, or a torque limited, in less than this share of what the filter sees.
pub(super) const FAR: f64 = 0.1;
const ASTRAY: f64 = 0.02;
/// A joint that is slower rests [rad/s], and so does one that is only pushed about; a row is learnt
/// if it rested less than this share of what the filter sees.
const REST: f64 = 0.02;
const RESTED: f64 = 0.3;

/// Whose turn it is to be learnt, period after period.
#[derive(Clone, Copy, Debug)]
pub(super) struct Turns {
    cycle: u64,
    tasks: usize,
    joints: usize,
}

impl Turns {
    /// Those of so many joints, with this period \[s\].
    pub fn new(joints: usize, control_period: f64) -> Self {
        let cycle = libm::rint(CYCLE / control_period).max(1.0) as u64;
        Self { cycle, tasks: (joints + 1).div_ceil(cycle as usize), joints }
    }

    /// Those whose turn it is in period `k`: joints, and after the last of them, P.
    pub fn of(&self, k: u64) -> impl Iterator<Item = usize> + use<> {
        let (first, last) = ((k % self.cycle) as usize * self.tasks, self.joints);
        (first..first + self.tasks).take_while(move |n| *n <= last)
    }
}

impl<const N: usize, T: Real> Filtered<N, T> {
    /// The observer over a period of `dt` \[s\], the `first` or not, in which the torque acted that
    /// was to give an acceleration `v`; with D ė'.
    #[inline(always)]
    pub fn observe(
        &mut self,
        (now, v): (&Now<N, T>, &Vector<N, T>),
        (weight, momentum): (&Matrix<N, T>, &Vector<N, T>),
        (bandwidth, slow): (&[T; N], T),
        (dt, first): (f64, bool),
    ) {
        let pushed = now.pushed(weight);
        if first {
            (self.slow, self.momentum) = (now.velocity, *momentum);
        }
        for n in 0..N {
            let (one, velocity) = (slow.like(1.0), now.velocity[n]);
            let share = bandwidth[n] * slow.like(dt);
            let missing = v[n] + pushed[n] - now.alpha[n];
            self.zeta[n] += one.if_less(share, one, share) * missing;
            let lag = velocity - self.slow[n];
            self.slow[n] += lag * slow;
        }
        self.velocity = now.velocity;
        self.period = dt;
    }

    /// What acted in a period of `dt` \[s\] goes through the filter, against friction that differs
    /// by `rubbed` at `velocity` from what was counted on: what Φθ should be.
    #[inline(always)]
    pub fn take(
        &mut self,
        (now, acting): (&Now<N, T>, &Decided<N, T>),
        (velocity, rubbed): (&Vector<N, T>, &Vector<N, T>),
        momentum: &Vector<N, T>,
        (share, acceleration_share): (T, T),
        dt: f64,
    ) -> Vector<N, T> {
        let (zero, one) = (share.like(0.0), share.like(1.0));
        let mut wanted = self.torque;
        for n in 0..N {
            let known = acting.torque[n] + now.cut[n] + rubbed[n];
            let (surprise, last) = (known - self.torque[n], self.momentum[n]);
            self.torque[n] += surprise * share;
            self.momentum[n] += (momentum[n] - last) * share;
            let change = (self.momentum[n] - last) / share.like(dt);
            wanted[n] = self.torque[n] - change * acceleration_share;
            let (own, asked) = (velocity[n].abs(), acting.dq[n].abs());
            let least = own.if_less(asked, own, asked);
            let rests = least.if_less(share.like(REST), one, zero);
            let change = rests - self.rest[n];
            self.rest[n] += change * share;
        }
        let astray = zero.if_less(now.size_of_cut(), one, now.far);
        let change = astray - self.astray;
        self.astray += change * share;
        self.since += dt;
        wanted
    }
}

/// Whether a row is learnt, of a joint that rests and of an arm that is astray so much.
pub(super) fn tells(rest: f64, astray: f64) -> bool {
    rest <= RESTED && astray <= ASTRAY
}

/// The share of P that is forgotten after so long \[s\].
pub(super) fn forgotten(since: f64) -> f64 {
    (since / FORGETTING).min(1.0)
}

impl<const N: usize, T: Real> Now<N, T> {
    /// Zero where no limit cut a torque.
    #[inline(always)]
    fn size_of_cut(&self) -> T {
        let mut size = self.far.like(0.0);
        for n in 0..N {
            size += self.cut[n].abs();
        }
        size
    }

    /// What limits took of the acceleration, D⁻¹(τ_a − τ_asked).
    #[inline(always)]
    fn pushed(&self, weight: &Matrix<N, T>) -> Vector<N, T> {
        let (size, zero) = (self.size_of_cut(), self.far.like(0.0));
        let mut pushed = self.cut;
        if zero.any_less(size) {
            let solved = Factor::of(weight).solve(&self.cut);
            for n in 0..N {
                pushed[n] = zero.if_less(size, solved[n], pushed[n]);
            }
        }
        pushed
    }
}

impl<const N: usize, const K: usize, A: Parametric<N, K>> LearnedTorque<N, K, A> {
    /// Where the columns of period `k` are.
    pub(super) fn turn(&self, k: u64) -> usize {
        (k % (self.gains.delay as u64 + 1)) as usize
    }

    /// The end of a period of `dt` \[s\].
    pub(super) fn end<B: Buffer>(
        &self,
        state: &mut LearnedTorqueState<N, B>,
        dt: f64,
        learns: bool,
    ) {
        let LearnedTorqueState { memory, filtered, decided, periods, now, weight, .. } = state;
        let LearningGains { pull, learning, acceleration_share, delay, .. } = &self.gains;
        let k = *periods;
        decided[self.turn(k)] = now.decided;
        let mut parts = self.parts(memory.as_mut_slice());
        // What acts before the first torque arrives keeps the arm as it is.
        let acting = k.checked_sub(*delay as u64).map(|k| (self.turn(k), decided[self.turn(k)]));
        let v = acting.map_or(Vector::zeros(), |(_, it)| it.v);
        let (momentum, slow) = (*weight * now.velocity, filter(FRICTION_CUT_OFF, dt));
        let observer = (&pull.bandwidth, slow);
        filtered.observe((now, &v), (weight, &momentum), observer, (dt, k == 0));
        *periods = k.saturating_add(1);
        let Some((turn, acting)) = acting else { return };
        let share = filter(*learning, dt);
        let velocity = acting.dq + filtered.slow;
        self.smooth(share, turn, &velocity, &mut parts);
        // What is known of friction acts at the arm's velocity too.
        let rubbed = self.arm.friction(&acting.dq) - self.arm.friction(&velocity);
        let (acted, shares) = ((&*now, &acting), (share, *acceleration_share));
        let wanted = filtered.take(acted, (&velocity, &rubbed), &momentum, shares, dt);
        if learns {
            self.learn(k, &wanted, filtered, &mut parts);
        }
    }

    /// The rows whose turn it is in period `k`, and after all of them P forgets.
    fn learn(&self, k: u64, wanted: &Vector<N>, filtered: &mut Filtered<N>, parts: &mut Parts<'_>) {
        let Parts { regression, inertial, own, .. } = parts;
        for n in Turns::new(N, self.gains.control_period).of(k) {
            if n == N {
                regression.forget(forgotten(filtered.since), self.features.prior());
                filtered.since = 0.0;
            } else if tells(filtered.rest[n], filtered.astray) {
                let own = &own[n * self.features.shape.own()..][..self.features.shape.own()];
                let row = self.features.shape.row(n, &inertial[self.features.shape.acting(n)], own);
                regression.learn(&row, wanted[n], self.gains.unit[n]);
            }
        }
    }

    /// The columns of the torque that acted, through the filter.
    fn smooth(&self, share: f64, turn: usize, velocity: &Vector<N>, parts: &mut Parts<'_>) {
        let Parts { inertial, own, columns, .. } = parts;
        let columns =
            &columns[turn * self.features.shape.columns()..][..self.features.shape.columns()];
        for n in 0..N {
            let acting = self.features.shape.acting(n);
            approach(&mut inertial[acting.clone()], share, &columns[acting]);
            let own = &mut own[n * self.features.shape.own()..][..self.features.shape.own()];
            approach(own, share, &friction(velocity[n]));
            approach(&mut own[FRICTION..], share, &columns[self.features.shape.places()]);
        }
    }
}

/// The share that a filter with this cut-off \[Hz\] takes of a new value, after `period` \[s\].
pub(super) fn filter(cut_off: f64, period: f64) -> f64 {
    1.0 - decay(TAU * cut_off * period)
}

/// y ← y + share (x − y).
fn approach(y: &mut [f64], share: f64, x: &[f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y = nearer(*y, share, *x);
    }
}

/// y + share (x − y).
#[inline(always)]
pub(super) fn nearer<T: Real>(y: T, share: T, x: T) -> T {
    (y + share * (x - y)).unless_tiny(TINY)
}

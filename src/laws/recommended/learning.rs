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
use super::learned_torque::LearnedTorque;
use super::memory::{Filtered, LearnedTorqueState, Parts};
use super::regression::unless_tiny;
use crate::arm::{Factor, Parametric};
use crate::fuzzy::Buffer;
use crate::math::{Vector, decay};

/// Every row is learnt once in this time \[s\].
const CYCLE: f64 = 0.02;
/// In this time what was learnt is half forgotten, or more: T_f of P \[s\].
const FORGETTING: f64 = 100.0;
/// Cut-off of the velocity on which friction is learnt \[Hz\].
const FRICTION_CUT_OFF: f64 = 15.0;
/// Where a joint is farther from the desired motion \[rad\], Φ(q_d) is not what acts; a row is
/// learnt if that was so, or a torque limited, in less than this share of what the filter sees.
pub(super) const FAR: f64 = 0.1;
const ASTRAY: f64 = 0.02;
/// A joint that is slower rests [rad/s], and so does one that is only pushed about; a row is learnt
/// if it rested less than this share of what the filter sees.
const REST: f64 = 0.02;
const RESTED: f64 = 0.3;

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
        let LearnedTorqueState { memory, filtered, decided, periods, now, .. } = state;
        let (delay, k) = (self.gains.delay as u64, *periods);
        decided[self.turn(k)] = now.decided;
        let mut parts = self.parts(memory.as_mut_slice());
        // What acts before the first torque arrives keeps the arm as it is.
        let acting = k.checked_sub(delay).map(|k| (self.turn(k), decided[self.turn(k)]));
        let v = acting.map_or(Vector::zeros(), |(_, it)| it.v);
        let pushed = if now.cut == Vector::<N>::zeros() {
            now.cut
        } else {
            Factor::of(&now.weight).solve(&now.cut)
        };
        let momentum = now.weight * now.velocity;
        if k == 0 {
            (filtered.slow, filtered.momentum) = (now.velocity, momentum);
        }
        let missing = v + pushed - now.alpha;
        let p = &self.gains.pull.bandwidth;
        filtered.zeta += Vector::from_fn(|n, _| (p[n] * dt).min(1.0) * missing[n]);
        filtered.velocity = now.velocity;
        filtered.slow += (now.velocity - filtered.slow) * filter(FRICTION_CUT_OFF, dt);
        (filtered.period, *periods) = (dt, k.saturating_add(1));
        let Some((turn, acting)) = acting else { return };
        let share = filter(self.gains.learning, dt);
        let velocity = acting.dq + filtered.slow;
        self.smooth(share, turn, &velocity, &mut parts);
        let last = filtered.momentum;
        // What is known of friction acts at the arm's velocity too.
        let rubbed = self.arm.friction(&acting.dq) - self.arm.friction(&velocity);
        filtered.torque += (acting.torque + now.cut + rubbed - filtered.torque) * share;
        filtered.momentum += (momentum - last) * share;
        let slow = |n: usize| velocity[n].abs().min(acting.dq[n].abs()) < REST;
        let rests = Vector::from_fn(|n, _| if slow(n) { 1.0 } else { 0.0 });
        filtered.rest += (rests - filtered.rest) * share;
        let astray = now.far || now.cut != Vector::<N>::zeros();
        filtered.astray += (if astray { 1.0 } else { 0.0 } - filtered.astray) * share;
        filtered.since += dt;
        if learns {
            let change = (filtered.momentum - last) / dt;
            let wanted = filtered.torque - change * self.gains.acceleration_share;
            self.learn(k, &wanted, filtered, &mut parts);
        }
    }

    /// The rows whose turn it is in period `k`, and after all of them P forgets.
    fn learn(&self, k: u64, wanted: &Vector<N>, filtered: &mut Filtered<N>, parts: &mut Parts<'_>) {
        let Parts { regression, inertial, own, .. } = parts;
        let cycle = libm::rint(CYCLE / self.gains.control_period).max(1.0) as u64;
        let tasks = (N + 1).div_ceil(cycle as usize);
        let first = (k % cycle) as usize * tasks;
        for n in (first..first + tasks).take_while(|n| *n <= N) {
            if n == N {
                let share = filtered.since / FORGETTING;
                regression.forget(share.min(1.0), self.features.prior());
                filtered.since = 0.0;
            } else if filtered.rest[n] <= RESTED && filtered.astray <= ASTRAY {
                let own = &own[n * self.features.own()..][..self.features.own()];
                let row = self.features.row(n, &inertial[self.features.acting(n)], own);
                regression.learn(&row, wanted[n], self.gains.unit[n]);
            }
        }
    }

    /// The columns of the torque that acted, through the filter.
    fn smooth(&self, share: f64, turn: usize, velocity: &Vector<N>, parts: &mut Parts<'_>) {
        let Parts { inertial, own, columns, .. } = parts;
        let columns = &columns[turn * self.features.columns()..][..self.features.columns()];
        for n in 0..N {
            let acting = self.features.acting(n);
            approach(&mut inertial[acting.clone()], share, &columns[acting]);
            let own = &mut own[n * self.features.own()..][..self.features.own()];
            approach(own, share, &friction(velocity[n]));
            approach(&mut own[FRICTION..], share, &columns[N * K..]);
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
        *y = unless_tiny(*y + share * (x - *y));
    }
}

//! The law and what it has learnt, of eight runs side by side, from their first sample on.
//!
//! What a torque is made of, its filters and the observer go side by side. A row is learnt in one
//! run after the other: P fills registers by itself.

mod kernels;
mod numbers;
mod registers;

use std::boxed::Box;

use pulp::Arch;

use self::kernels::{Ask, Observe, Take};
use self::numbers::{LearnedAbreast, Learnt, Shares, regression};
use super::learning::{forgotten, tells};
use crate::control::{Asks, Beliefs, Demand, OwnSide, Sample};
use crate::math::{Abreast, LANES, Vector, in_lanes};
use crate::reference::Setpoint;

/// These laws with what learns side by side; `None` where they cannot be.
pub(super) fn put<const N: usize>(
    laws: [Beliefs<'_, N>; LANES],
    each: [OwnSide<'_, N>; LANES],
) -> Option<Box<dyn Asks<N>>> {
    Some(Box::new(LearnedAbreast::of(laws, each)?))
}

impl<const N: usize> LearnedAbreast<N> {
    /// Where the columns of period `k` are.
    fn turn(&self, k: u64) -> usize {
        (k % (self.gains[0].delay as u64 + 1)) as usize
    }

    /// The rows whose turn it is in period `k`, and after all of them P forgets.
    fn learn(&mut self, k: u64) {
        let Self { shape, learnt, filtered, theta, inertial, own, wanted, gains, .. } = self;
        for n in self.turns.of(k) {
            if n == N {
                for learnt in &mut *learnt {
                    let Learnt { memory, prior, .. } = learnt;
                    let share = forgotten(filtered.since);
                    regression(memory, shape).forget(share, prior.iter().copied());
                }
                filtered.since = 0.0;
                continue;
            }
            let own = &own[n * shape.own()..][..shape.own()];
            let inertial = &inertial[shape.acting(n)];
            for (i, Learnt { memory, row, .. }) in learnt.iter_mut().enumerate() {
                if !tells(filtered.rest[n].0[i], filtered.astray.0[i]) {
                    continue;
                }
                row.clear();
                row.extend(inertial.iter().chain(own).map(|entry| entry.0[i]));
                let (acting, own) = row.split_at(inertial.len());
                let mut regression = regression(memory, shape);
                regression.learn(&shape.row(n, acting, own), wanted[n].0[i], gains[i].unit[n]);
                for (to, from) in theta.iter_mut().zip(&*regression.theta) {
                    to.0[i] = *from;
                }
            }
        }
    }
}

impl<const N: usize> Asks<N> for LearnedAbreast<N> {
    fn ask(
        &mut self,
        arch: Arch,
        seen: &Sample<N, Abreast>,
        asked: (&mut Demand<N, Abreast>, &mut Vector<N, Abreast>),
    ) {
        let turn = self.turn(self.periods);
        let Self { arm, weight, columns, shape, residuals, room, .. } = self;
        let Setpoint { q, dq, ddq } = &seen.desired;
        arm.find(arch, (q, dq));
        weight.find_mass(arch, q);
        let columns = &mut columns[turn * shape.columns()..][..shape.columns()];
        arm.write_regressor(arch, [q, dq, ddq], columns);
        if let Some(residuals) = residuals {
            let [own, work] = room;
            for (i, residual) in residuals.iter().enumerate() {
                residual.write(&seen.lane(i), own, work);
                for (to, column) in columns[shape.places()].iter_mut().zip(&*own) {
                    to.0[i] = *column;
                }
            }
        }
        in_lanes(arch, Ask { turn, seen, it: self, asked });
    }

    fn end(
        &mut self,
        arch: Arch,
        torques: (&Vector<N, Abreast>, &Vector<N, Abreast>),
        dt: f64,
        lost: &mut Abreast,
    ) {
        if self.shares.dt != dt {
            self.shares = Shares::of(self.gains.each_ref(), dt);
        }
        let k = self.periods;
        self.decided[self.turn(k)] = self.now.decided;
        let acting = k.checked_sub(self.gains[0].delay as u64).map(|k| self.turn(k));
        in_lanes(arch, Observe { it: &mut *self, torques, acting, dt, lost });
        self.periods = k.saturating_add(1);
        let Some(turn) = acting else { return };
        let Self { arm, decided, moving, rubbed: [desired, measured], .. } = self;
        arm.friction(arch, &decided[turn].dq, desired);
        arm.friction(arch, moving, measured);
        in_lanes(arch, Take { it: &mut *self, turn, dt });
        self.learn(k);
    }
}

//! What stands before the laws of eight controllers side by side, and the limits of their torques'
//! rates.
//!
//! All of one kind, each with rates of its own. In such loops no sample is lost, and what acted is
//! always told.

use pulp::{Arch, Simd, WithSimd};

use super::{Front, FrontMemory, MAX_DELAY, View, held_on};
use crate::control::checks::FARTHEST;
use crate::control::limits::possible;
use crate::control::{Controller, Law, Limits, Sample, State};
use crate::math::{
    Abreast, LANES, Load, Real, Register, Vector, in_lanes, lane, put, side_by_side, store,
};

/// Fronts and rate limits, with what they remember.
#[derive(Clone, Debug)]
pub(crate) struct FrontsAbreast<const N: usize> {
    front: Front<Abreast>,
    wraps: [bool; N],
    view: View<N, Abreast>,
    /// Length of the period that ended last \[s\].
    period: Abreast,
    /// What was asked for in the periods that ended, the latest first [N·m].
    sent: [Vector<N, Abreast>; MAX_DELAY],
    /// The torques that were commanded last [N·m], of those that were.
    last: Vector<N, Abreast>,
    commanded: [bool; LANES],
    /// Which have not had a sample.
    fresh: [bool; LANES],
}

impl<const N: usize> FrontsAbreast<N> {
    /// Those of these controllers with their states, of which no period is pending; `None` if they
    /// are not of one kind.
    pub fn of<L: Law<N>, C, S>(
        each: [(&Controller<N, L, C>, &State<N, S>); LANES],
    ) -> Option<Self> {
        let fronts = each.map(|(controller, _)| &controller.front);
        let wraps = each[0].0.law.wraps();
        let alike = each.iter().all(|(controller, state)| {
            let Front { hand_over, velocity_filter, bumpless, delay } = &controller.front;
            hand_over.is_some() == fronts[0].hand_over.is_some()
                && velocity_filter.is_some() == fronts[0].velocity_filter.is_some()
                && bumpless.is_some() == fronts[0].bumpless.is_some()
                && *delay == fronts[0].delay
                && controller.law.wraps() == wraps
                && state.front.lost == 0.0
        });
        if !alike {
            return None;
        }
        let rates = |of: fn(&Front) -> Option<f64>| {
            of(fronts[0]).map(|_| Abreast::of(fronts, |front| of(front).unwrap_or(f64::NAN)))
        };
        let memories = each.map(|(_, state)| &state.front);
        let vectors = |of: fn(&FrontMemory<N>) -> &Vector<N>| {
            side_by_side(&memories.map(|memory| *of(memory)))
        };
        let zeros = Vector::zeros();
        Some(Self {
            front: Front {
                hand_over: rates(|front| front.hand_over),
                velocity_filter: rates(|front| front.velocity_filter),
                bumpless: rates(|front| front.bumpless),
                delay: fronts[0].delay,
            },
            wraps,
            view: View {
                age: Abreast::of(memories, |memory| memory.view.age),
                offset: [vectors(|it| &it.view.offset[0]), vectors(|it| &it.view.offset[1])],
                error: [vectors(|it| &it.view.error[0]), vectors(|it| &it.view.error[1])],
                bump: vectors(|it| &it.view.bump),
            },
            period: Abreast::of(memories, |memory| memory.period),
            sent: core::array::from_fn(|k| {
                side_by_side(&memories.map(|memory| memory.sent[k].asked))
            }),
            last: side_by_side(&each.map(|(_, state)| state.last_tau.unwrap_or(zeros))),
            commanded: each.map(|(_, state)| state.last_tau.is_some()),
            fresh: each.map(|(_, state)| state.steps == 0),
        })
    }

    /// Tells the one in a lane where its arm is at the first sample of its `controller`. One that
    /// cannot be told is `lost`.
    pub fn begin<L: Law<N>, C>(
        &mut self,
        i: usize,
        Controller { law, limits, .. }: &Controller<N, L, C>,
        q: &Vector<N>,
        lost: &mut Abreast,
    ) {
        if !self.commanded[i] {
            put(&law.resting_torque(q), &mut self.last, i);
        }
        let before = lane(&self.last, i);
        if before.iter().any(|tau| !tau.is_finite()) {
            lost.0[i] = f64::NAN;
        }
        if self.fresh[i] {
            self.sent.iter_mut().for_each(|sent| put(&limits.clamp(&before), sent, i));
        }
    }

    /// Makes of what was measured what laws are to see. What no controller accepts is `lost`.
    pub fn look(&mut self, arch: Arch, seen: &mut Sample<N, Abreast>, lost: &mut Abreast) {
        in_lanes(arch, Look { fronts: self, seen, lost });
    }

    /// Adds to the model's torques what takes the jump out of the first ones.
    #[inline(always)]
    pub fn cushion<S: Simd>(
        &mut self,
        (simd, part): (S, usize),
        model: &mut Vector<N, Register<S>>,
        compensation: &Vector<N, Register<S>>,
    ) {
        let Self { front, view, last, .. } = self;
        if front.bumpless.is_none() {
            return;
        }
        let (mut near, mut asked) = (view.load(simd, part), *model);
        for n in 0..N {
            asked[n] += compensation[n];
        }
        front.load(simd, part).cushion(&mut near, &last.load(simd, part), &asked, model);
        store(&near.bump, &mut view.bump, part);
    }

    /// The torques inside these limits, for a period of `dt` \[s\].
    #[inline(always)]
    pub fn follow<S: Simd>(
        &mut self,
        (simd, part): (S, usize),
        limits: &Limits<N, Register<S>>,
        tau: &Vector<N, Register<S>>,
        dt: f64,
    ) -> Vector<N, Register<S>> {
        let tau = limits.clamp_after(&self.last.load(simd, part), tau, dt);
        store(&possible(&tau), &mut self.last, part);
        tau
    }

    /// What was asked for what acted in the period that ends, for which `asked` was asked.
    pub fn acting<'a>(&'a self, asked: &'a Vector<N, Abreast>) -> &'a Vector<N, Abreast> {
        self.front.delay.checked_sub(1).map_or(asked, |k| &self.sent[k])
    }

    /// Remembers what was `asked` for in a period of `dt` \[s\] that ends.
    pub fn ended(&mut self, asked: &Vector<N, Abreast>, dt: f64) {
        self.period = Abreast::all(dt);
        if self.front.delay > 0 {
            held_on(&mut self.sent, asked, 0.0);
        }
    }
}

struct Look<'a, const N: usize> {
    fronts: &'a mut FrontsAbreast<N>,
    seen: &'a mut Sample<N, Abreast>,
    lost: &'a mut Abreast,
}

impl<const N: usize> WithSimd for Look<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { fronts: FrontsAbreast { front, wraps, view, period, .. }, seen, lost } = self;
        for part in 0..Register::<S>::PARTS {
            let mut near = view.load(simd, part);
            let (measured, elapsed) = (seen.load(simd, part), period.load(simd, part));
            let looked = front.load(simd, part).look(&mut near, &measured, elapsed, wraps);
            near.age.store(&mut view.age, part);
            for (from, to) in near.offset.iter().zip(&mut view.offset) {
                store(from, to, part);
            }
            for (from, to) in near.error.iter().zip(&mut view.error) {
                store(from, to, part);
            }
            let (zero, nan) = (elapsed.like(0.0), elapsed.like(f64::NAN));
            let mut felt = lost.load(simd, part);
            let desired = &looked.desired;
            for signal in [&looked.q, &looked.dq, &desired.q, &desired.dq, &desired.ddq] {
                for n in 0..N {
                    felt += signal[n].abs().if_less(zero.like(FARTHEST), zero, nan);
                }
            }
            felt.store(lost, part);
            looked.store(seen, part);
        }
    }
}

impl Load for Front<Abreast> {
    type In<S: Simd> = Front<Register<S>>;

    #[inline(always)]
    fn load<S: Simd>(&self, simd: S, part: usize) -> Front<Register<S>> {
        let Self { hand_over, velocity_filter, bumpless, delay } = self;
        let mut front =
            Front { hand_over: None, velocity_filter: None, bumpless: None, delay: *delay };
        if let Some(rate) = hand_over {
            front.hand_over = Some(rate.load(simd, part));
        }
        if let Some(cut_off) = velocity_filter {
            front.velocity_filter = Some(cut_off.load(simd, part));
        }
        if let Some(rate) = bumpless {
            front.bumpless = Some(rate.load(simd, part));
        }
        front
    }
}

impl<const N: usize> Load for View<N, Abreast> {
    type In<S: Simd> = View<N, Register<S>>;

    #[inline(always)]
    fn load<S: Simd>(&self, simd: S, part: usize) -> View<N, Register<S>> {
        let Self { age, offset: [start, slope], error: [error, rate], bump } = self;
        View {
            age: age.load(simd, part),
            offset: [start.load(simd, part), slope.load(simd, part)],
            error: [error.load(simd, part), rate.load(simd, part)],
            bump: bump.load(simd, part),
        }
    }
}

//! What stands before the law in a sampled loop: a soft hand-over from where the arm is to the
//! reference, a velocity from positions, a start without a jump in torque, and the loop's delay.
//!
//! ```text
//! hand-over   q_d' = q_d + (δ₀ + (δ̇₀ + aδ₀)t) e^(−at),  δ₀ = e(0), δ̇₀ = ė(0), both derivatives
//! velocity    ė' ← ė' + (1 − e^(−2πfh)) ((e' − e'₋)/h − ė'),  q̇ = q̇_d' + ė'
//! bumpless    τ + (τ(0₋) − τ(0)) e^(−at)
//! delay       the torque of step k acts in period k + d
//! ```
//!
//! The filter is the matched one: q_d goes through the same difference and filter as q, so its lag
//! is no error.

use core::f64::consts::TAU;

#[cfg(feature = "std")]
mod abreast;

#[cfg(feature = "std")]
pub(crate) use self::abreast::FrontsAbreast;
use super::bytes::{Numbers, put_all};
use super::{Applied, Sample};
use crate::error::{Error, Result, within};
use crate::math::{Real, Vector, fnv_of};
use crate::reference::Setpoint;

/// Most samples between a torque and the period in which it acts.
pub const MAX_DELAY: usize = 4;

/// What stands before the law. All of it is off by default.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Front<T = f64> {
    /// Rate a of the hand-over [1/s]; `None`: the error starts as it is.
    pub hand_over: Option<T>,
    /// Cut-off f of the velocity filter \[Hz\]: the measured q̇ is not used. `None`: it is.
    pub velocity_filter: Option<T>,
    /// Rate a at which the torque goes from the one at take-over, or else the law's resting torque,
    /// to the law's [1/s]; `None`: at once.
    pub bumpless: Option<T>,
    /// Samples d between a torque and its period, at most [`MAX_DELAY`]: what acted
    /// in a period is then compared with what was asked for it.
    pub delay: usize,
}

impl Default for Front {
    fn default() -> Self {
        Self { hand_over: None, velocity_filter: None, bumpless: None, delay: 0 }
    }
}

/// What the front remembers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FrontMemory<const N: usize> {
    pub view: View<N>,
    /// Length of the period that ended last \[s\].
    pub period: f64,
    /// Samples that were lost since the last step: its torque was held on.
    pub lost: f64,
    /// What was asked for and commanded in the periods that ended, the latest first.
    sent: [Applied<N>; MAX_DELAY],
}

/// What it remembers of samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct View<const N: usize, T = f64> {
    /// Time since its first sample \[s\]; negative before that.
    age: T,
    /// δ₀ and δ̇₀ + aδ₀.
    offset: [Vector<N, T>; 2],
    /// e' and ė' of the last sample.
    error: [Vector<N, T>; 2],
    /// τ(0₋) − τ(0) [N·m].
    bump: Vector<N, T>,
}

impl<const N: usize> FrontMemory<N> {
    /// Before the first sample.
    pub fn new() -> Self {
        let zeros = Vector::zeros();
        let none = Applied::new(zeros, zeros);
        let view = View { age: -1.0, offset: [zeros; 2], error: [zeros; 2], bump: zeros };
        Self { view, period: 0.0, lost: 0.0, sent: [none; MAX_DELAY] }
    }

    /// Hands over anew at the next sample.
    pub fn begin(&mut self) {
        self.view.age = -1.0;
    }

    /// What acts until the first torque arrives.
    pub fn wait(&mut self, tau: &Vector<N>) {
        self.sent = [Applied::new(*tau, *tau); MAX_DELAY];
    }

    /// Remembers what was commanded in a period of `dt` \[s\] that ends.
    pub fn ended(&mut self, commanded: &Applied<N>, dt: f64) {
        self.period = dt;
        held_on(&mut self.sent, commanded, self.lost);
        self.lost = 0.0;
    }

    /// Writes it.
    pub fn write(&self, put: &mut dyn FnMut(&[u8])) {
        put_all(put, &[self.period, self.lost, self.view.age]);
        self.parts().for_each(|part| put_all(put, part.as_slice()));
    }

    /// What a saved state says.
    pub(in crate::control) fn read(rest: &mut Numbers<'_>) -> Result<Self> {
        let mut memory = Self::new();
        (memory.period, memory.lost) = (rest.number()?, rest.number()?);
        memory.view.age = rest.number()?;
        let view = &mut memory.view;
        let [offset, slope] = &mut view.offset;
        let [error, rate] = &mut view.error;
        let sent = memory.sent.iter_mut().flat_map(|it| [&mut it.asked, &mut it.tau]);
        for part in [offset, slope, error, rate, &mut view.bump].into_iter().chain(sent) {
            *part = rest.vector()?;
        }
        memory.sent.iter_mut().for_each(|it| it.commanded = it.tau);
        let finite = memory.parts().all(|part| part.iter().all(|x| x.is_finite()));
        let timed = (0.0..=1.0).contains(&memory.period) && (0.0..=1e9).contains(&memory.lost);
        let aged = memory.view.age == -1.0 || memory.view.age >= 0.0;
        if finite && timed && aged && memory.view.age.is_finite() {
            Ok(memory)
        } else {
            Err(Error::damaged("its front is not a possible one"))
        }
    }

    /// The vectors of a saved state.
    fn parts(&self) -> impl Iterator<Item = &Vector<N>> {
        let View { offset, error, bump, .. } = &self.view;
        let sent = self.sent.iter().flat_map(|it| [&it.asked, &it.tau]);
        offset.iter().chain(error).chain([bump]).chain(sent)
    }
}

impl<const N: usize, T: Real> View<N, T> {
    /// q_d' with its derivatives at a sample.
    #[inline(always)]
    fn handed(&self, rate: T, seen: &Sample<N, T>) -> Setpoint<N, T> {
        let fading = (-rate * self.age).exp();
        let ([start, slope], mut handed) = (&self.offset, seen.desired);
        for n in 0..N {
            let along = start[n] + slope[n] * self.age;
            handed.q[n] += along * fading;
            handed.dq[n] += (slope[n] - along * rate) * fading;
            handed.ddq[n] += (along * rate - slope[n] * rate.like(2.0)) * (rate * fading);
        }
        handed
    }
}

impl Front {
    /// Refuses what makes no sense.
    ///
    /// # Errors
    /// `hand_over`, `velocity_filter`, `bumpless`: not finite or not > 0. `delay`: beyond
    /// [`MAX_DELAY`].
    pub fn validate(&self) -> Result<()> {
        let Self { hand_over, velocity_filter, bumpless, delay } = *self;
        let known = [
            ("hand_over", hand_over),
            ("velocity_filter", velocity_filter),
            ("bumpless", bumpless),
        ];
        for (name, value) in known {
            let possible = |x: f64| x > 0.0 && x.is_finite();
            within(name, &[value.unwrap_or(1.0)], possible, "a number > 0")?;
        }
        if delay > MAX_DELAY {
            return Err(Error::too_many("delay", Some(delay), MAX_DELAY));
        }
        Ok(())
    }

    /// Whether it does something.
    #[inline]
    pub(super) fn is_on(&self) -> bool {
        *self != Self::default()
    }

    /// A number for what it does, on top of the law's.
    pub(super) fn fingerprint(&self, tuning: u64) -> u64 {
        if !self.is_on() {
            return tuning;
        }
        let rates = [self.hand_over, self.velocity_filter, self.bumpless];
        let numbers = rates.map(|rate| rate.unwrap_or(0.0));
        fnv_of(fnv_of(tuning, numbers), [self.delay as f64])
    }

    /// What acts in the period for which the torque `commanded` was decided.
    pub(super) fn acting<const N: usize>(
        &self,
        memory: &FrontMemory<N>,
        commanded: &Applied<N>,
    ) -> Applied<N> {
        let FrontMemory { sent, lost, .. } = memory;
        if self.delay == 0 || *lost == 0.0 {
            return *self.delay.checked_sub(1).and_then(|k| sent.get(k)).unwrap_or(commanded);
        }
        let mean = |of: fn(&Applied<N>) -> Vector<N>| {
            mean_acting(self.delay, *lost, &of(commanded), &sent.map(|it| of(&it)))
        };
        Applied { asked: mean(|it| it.asked), tau: mean(|it| it.tau), ..*commanded }
    }
}

impl<T: Real> Front<T> {
    /// What the law is to see of a sample that comes `elapsed` \[s\] after the last one.
    #[inline(always)]
    pub(super) fn look<const N: usize>(
        &self,
        view: &mut View<N, T>,
        seen: &Sample<N, T>,
        elapsed: T,
        wraps: &[bool; N],
    ) -> Sample<N, T> {
        // At the first sample this is negative.
        let (before, zero) = (view.age, elapsed.like(0.0));
        view.age = before.if_less(zero, zero, before + elapsed);
        let rate = if let Some(rate) = self.hand_over { rate } else { zero };
        for n in 0..N {
            let [start, slope] = &mut view.offset;
            start[n] = before.if_less(zero, seen.e[n], start[n]);
            slope[n] = before.if_less(zero, seen.de[n] + seen.e[n] * rate, slope[n]);
        }
        let desired = match self.hand_over {
            Some(rate) => view.handed(rate, seen),
            None => seen.desired,
        };
        let seen = Sample::wrapped(seen.q, seen.dq, desired, wraps);
        let Some(cut_off) = self.velocity_filter else { return seen };
        let share = elapsed.like(1.0) - (elapsed.like(-TAU) * cut_off * elapsed).exp();
        let mut dq = desired.dq;
        for n in 0..N {
            let [last, rate] = &mut view.error;
            let moved = seen.e[n] - last[n];
            let moved = if wraps[n] { moved.around() } else { moved };
            let filtered = rate[n] + share * (moved / elapsed - rate[n]);
            (last[n], rate[n]) = (seen.e[n], before.if_less(zero, seen.de[n], filtered));
            dq[n] += rate[n];
        }
        Sample::wrapped(seen.q, dq, desired, wraps)
    }

    /// Adds to the model's torque of a law, which asks for `tau`, what takes the jump out of its
    /// first ones; before them it was `before` [N·m].
    #[inline(always)]
    pub(super) fn cushion<const N: usize>(
        &self,
        view: &mut View<N, T>,
        before: &Vector<N, T>,
        tau: &Vector<N, T>,
        model: &mut Vector<N, T>,
    ) {
        let (age, zero) = (view.age, view.age.like(0.0));
        let Some(rate) = self.bumpless else { return };
        let fading = (-rate * age).exp();
        for n in 0..N {
            view.bump[n] = zero.if_less(age, view.bump[n], before[n] - tau[n]);
            model[n] += view.bump[n] * fading;
        }
    }
}

/// The mean torque that acts in a period and the `lost` ones after it, in which its torque `last`
/// was held on; `older` are those of the periods before, the latest first.
pub(crate) fn mean_acting<const N: usize>(
    delay: usize,
    lost: f64,
    last: &Vector<N>,
    older: &[Vector<N>; MAX_DELAY],
) -> Vector<N> {
    let periods = lost + 1.0;
    let waited = (delay as f64).min(periods);
    let mut sum = last * (periods - waited);
    older[..delay].iter().rev().take(waited as usize).for_each(|torque| sum += torque);
    sum / periods
}

/// Puts the torque of a period and of the `lost` ones after it before those that are older.
pub(crate) fn held_on<T: Copy>(older: &mut [T; MAX_DELAY], last: &T, lost: f64) {
    let more = (lost as usize + 1).min(MAX_DELAY);
    older.rotate_right(more);
    older[..more].fill(*last);
}

//! What a torque command may be: an effort limit and a rate limit.

#[cfg(feature = "std")]
use core::array;

use super::state::IMPOSSIBLE;
use crate::error::{Result, accepted};
#[cfg(feature = "std")]
use crate::math::{Abreast, LANES};
use crate::math::{Real, Vector};

/// Limits on the torque that a controller asks for. Unlimited by default.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits<const N: usize, T = f64> {
    /// Largest |τ| of each joint [N·m]; infinite = no limit.
    pub effort_limit: [T; N],
    /// Largest change of each τ per second [N·m/s]; infinite = no limit. Needs a step, so sampled
    /// control only.
    pub effort_rate_limit: [T; N],
}

impl<const N: usize> Default for Limits<N> {
    fn default() -> Self {
        Self { effort_limit: [f64::INFINITY; N], effort_rate_limit: [f64::INFINITY; N] }
    }
}

impl<const N: usize> Limits<N> {
    /// Refuses NaN, zero and negative limits.
    pub fn validate(&self) -> Result<()> {
        let wanted = "a limit > 0 (infinite for none)";
        accepted("effort_limit", &self.effort_limit, |limit| limit > 0.0, wanted)?;
        accepted("effort_rate_limit", &self.effort_rate_limit, |limit| limit > 0.0, wanted)
    }

    /// Whether the change of any torque is limited.
    #[inline]
    pub fn limits_rate(&self) -> bool {
        self.effort_rate_limit.iter().any(|limit| limit.is_finite())
    }
}

#[cfg(feature = "std")]
impl<const N: usize> Limits<N, Abreast> {
    /// Those of eight controllers.
    pub(crate) fn abreast(each: [&Limits<N>; LANES]) -> Self {
        Self {
            effort_limit: array::from_fn(|n| Abreast::of(each, |it| it.effort_limit[n])),
            effort_rate_limit: array::from_fn(|n| Abreast::of(each, |it| it.effort_rate_limit[n])),
        }
    }
}

impl<const N: usize, T: Real> Limits<N, T> {
    /// The nearest torque inside the effort limit.
    #[inline(always)]
    pub fn clamp(&self, tau: &Vector<N, T>) -> Vector<N, T> {
        let mut within = *tau;
        for n in 0..N {
            within[n] = bound(tau[n], -self.effort_limit[n], self.effort_limit[n]);
        }
        within
    }

    /// The nearest torque inside both limits, `dt` \[s\] after `last` was applied.
    #[inline(always)]
    pub fn clamp_after(&self, last: &Vector<N, T>, tau: &Vector<N, T>, dt: f64) -> Vector<N, T> {
        let mut within = *tau;
        for n in 0..N {
            let change = self.effort_rate_limit[n] * tau[n].like(dt);
            let limit = self.effort_limit[n];
            let near = bound(tau[n], last[n] - change, last[n] + change);
            within[n] = bound(near, -limit, limit);
        }
        within
    }
}

/// x, or 0 in all joints where a limit cut the torque of any: see
/// [`Applied::limited`](super::Applied::limited).
#[cfg(feature = "std")]
#[inline(always)]
pub(super) fn unless_limited<const N: usize, T: Real>(
    mut x: Vector<N, T>,
    asked: &Vector<N, T>,
    applied: &Vector<N, T>,
) -> Vector<N, T> {
    let zero = x[0].like(0.0);
    let mut gap = zero;
    for n in 0..N {
        gap += (applied[n] - asked[n]).abs();
    }
    for n in 0..N {
        x[n] = zero.if_less(gap, zero, x[n]);
    }
    x
}

/// The nearest torque that an arm can have.
#[inline(always)]
pub(crate) fn possible<const N: usize, T: Real>(tau: &Vector<N, T>) -> Vector<N, T> {
    let mut possible = *tau;
    for n in 0..N {
        possible[n] = bound(tau[n], tau[n].like(-IMPOSSIBLE), tau[n].like(IMPOSSIBLE));
    }
    possible
}

/// As `f64::clamp`, which panics on bounds that are NaN or crossed; NaN stays NaN.
#[inline(always)]
fn bound<T: Real>(x: T, low: T, high: T) -> T {
    x.if_less(low, low, high.if_less(x, high, x))
}

//! The last word on a torque: effort, then rate, then power.
//!
//! ```text
//! |τ| ≤ effort     |τ − τ_last| ≤ rate h     τ q̇ ≤ power
//! ```
//!
//! Where they exclude each other, effort goes before rate, and rate before power. A torque that
//! takes energy out of the arm is within every limit on power.

use super::{Event, Events, GuardParameters};
use crate::math::Vector;

/// A torque that may be sent, what was done to it, and the joint whose power is beyond its limit.
pub(super) struct Bounded<const N: usize> {
    pub tau: Vector<N>,
    pub events: Events,
    pub breach: Option<usize>,
}

impl<const N: usize> GuardParameters<N> {
    /// The torque nearest to `wanted` that may be sent a period after `last`, at the velocity `dq`
    /// if that is known.
    pub(super) fn bounded(
        &self,
        last: &Vector<N>,
        wanted: &Vector<N>,
        dq: Option<&Vector<N>>,
    ) -> Bounded<N> {
        let (mut events, mut breach) = (Events::default(), None);
        let mut cut = |event, from: f64, to: f64| {
            if to != from {
                events.add(event);
            }
            to
        };
        let tau = Vector::from_fn(|n, _| {
            let (effort, change) =
                (self.effort_limit[n], self.effort_rate_limit[n] * self.control_period);
            // What was sent last may be beyond the effort limit at a take-over.
            let last = last[n].clamp(-effort, effort);
            let (low, high) = ((last - change).max(-effort), (last + change).min(effort));
            let within = cut(Event::Effort, wanted[n], wanted[n].clamp(-effort, effort));
            let within = cut(Event::EffortRate, within, within.clamp(low, high));
            let most = self.power_bound(n, dq);
            let within = cut(Event::Power, within, within.clamp(most[0], most[1]).clamp(low, high));
            if within < most[0] || within > most[1] {
                breach = Some(n);
            }
            within
        });
        Bounded { tau, events, breach }
    }

    /// Between what torques τ q̇ is within the limit.
    fn power_bound(&self, n: usize, dq: Option<&Vector<N>>) -> [f64; 2] {
        let speed = dq.map_or(0.0, |dq| dq[n]);
        let most = self.power_limit[n] / speed.abs();
        if speed > 0.0 {
            [f64::NEG_INFINITY, most]
        } else if speed < 0.0 {
            [-most, f64::INFINITY]
        } else {
            [f64::NEG_INFINITY, f64::INFINITY]
        }
    }
}

//! Whether a sample can be true, and whether what it says is allowed.

use super::{Cause, Event, GuardMemory, GuardParameters};
use crate::control::Sample;
use crate::control::controller::check_sample;
use crate::math::{Vector, around};

/// What a sample is worth.
pub(super) enum Verdict {
    /// It can be used.
    Good,
    /// It cannot be true, and is not used.
    Bad(Event),
    /// It can be true, and the guard stops.
    Breach(Cause),
}

impl<const N: usize> GuardParameters<N> {
    /// Judges a sample that came `memory.since_good` after the last good one.
    pub(super) fn judge(
        &self,
        memory: &GuardMemory<N>,
        seen: &Sample<N>,
        wraps: &[bool; N],
    ) -> Verdict {
        if check_sample(&seen.q, &seen.dq, &seen.desired).is_err() {
            return Verdict::Bad(Event::NotFinite);
        }
        let jumps = |[q, _]: [Vector<N>; 2]| {
            (0..N).any(|n| {
                let moved = seen.q[n] - q[n];
                let moved = if wraps[n] { around(moved) } else { moved }.abs();
                self.contradicts(n, moved, seen.dq[n].abs(), memory.since_good)
            })
        };
        if memory.last_good.is_some_and(jumps) {
            return Verdict::Bad(Event::Jump);
        }
        self.breach(seen, wraps).map_or(Verdict::Good, Verdict::Breach)
    }

    /// Whether the way that a joint moved in that time \[s\] and its speed contradict each other:
    /// farther than the speed limit allows at a speed within it, or a speed beyond it with less
    /// than half of its way.
    fn contradicts(&self, n: usize, moved: f64, speed: f64, time: f64) -> bool {
        if speed > self.velocity_limit[n] {
            moved + self.slack[n] < 0.5 * speed * time
        } else {
            moved > self.velocity_limit[n] * time + self.slack[n]
        }
    }

    /// What is not allowed of a sample that is true.
    fn breach(&self, seen: &Sample<N>, wraps: &[bool; N]) -> Option<Cause> {
        (0..N).find_map(|n| {
            let [lower, upper] = self.position_limits[n];
            let event = if !wraps[n] && !(lower..=upper).contains(&seen.q[n]) {
                Event::Position
            } else if seen.dq[n].abs() > self.velocity_limit[n] {
                Event::Velocity
            } else if seen.e[n].abs() > self.envelope[n] {
                Event::Envelope
            } else {
                return None;
            };
            Some(Cause { event, joint: Some(n) })
        })
    }
}

//! Whether a sample can be true, and whether what it says is allowed.

use super::{Cause, Event, GuardMemory, GuardParameters};
use crate::control::Sample;
use crate::control::checks::{check_motion, check_setpoint};
use crate::math::{Vector, around};

/// What a sample is worth.
pub(super) enum Verdict {
    /// It can be used.
    Good,
    /// It cannot be true, and is not used.
    Bad(Event),
    /// It can be true, and the guard stops.
    Breach(Cause),
    /// What was measured can be used, the set-point cannot.
    NoSetpoint,
}

impl<const N: usize> GuardParameters<N> {
    /// Judges a sample that came `memory.since_good` after the last good one.
    pub(super) fn judge(
        &self,
        memory: &GuardMemory<N>,
        seen: &Sample<N>,
        wraps: &[bool; N],
    ) -> Verdict {
        if check_motion(["q", "dq"], &seen.q, &seen.dq).is_err() {
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
        let guided = check_setpoint(&seen.desired).is_ok();
        let breach = self.leaves(seen, wraps).or_else(|| self.errs(seen).filter(|_| guided));
        match breach {
            Some(cause) => Verdict::Breach(cause),
            None if guided => Verdict::Good,
            None => Verdict::NoSetpoint,
        }
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

    /// A joint that is where it may not be, or too fast.
    fn leaves(&self, seen: &Sample<N>, wraps: &[bool; N]) -> Option<Cause> {
        (0..N).find_map(|n| {
            let [lower, upper] = self.position_limits[n];
            let event = if !wraps[n] && !(lower..=upper).contains(&seen.q[n]) {
                Event::Position
            } else if seen.dq[n].abs() > self.velocity_limit[n] {
                Event::Velocity
            } else {
                return None;
            };
            Some(Cause { event, joint: Some(n) })
        })
    }

    /// A joint whose tracking error is outside its envelope.
    fn errs(&self, seen: &Sample<N>) -> Option<Cause> {
        let joint = (0..N).find(|&n| seen.e[n].abs() > self.envelope[n])?;
        Some(Cause { event: Event::Envelope, joint: Some(joint) })
    }
}

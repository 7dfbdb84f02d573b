//! Point to point by the quintic of least jerk: `q_d = q₀ + (q₁ − q₀)(10s³ − 15s⁴ + 6s⁵)`,
//! `s = (t − t₀)/T` in [0, 1].
//!
//! Source: T. Flash, N. Hogan, "The coordination of arm movements", J. Neurosci. 5 (1985).

use super::{Reference, Setpoint};
use crate::error::{Result, finite, positive, within};
use crate::math::Vector;

/// A motion from `start` to `goal` that holds still before and after. Velocity and acceleration are
/// continuous.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quintic<const N: usize> {
    start: Vector<N>,
    goal: Vector<N>,
    start_time: f64,
    duration: f64,
    /// (q₁ − q₀)/T [rad/s] and (q₁ − q₀)/T² [rad/s²].
    velocity: Vector<N>,
    acceleration: Vector<N>,
}

impl<const N: usize> Quintic<N> {
    /// From `start` \[rad\], leaving at `start_time` \[s\], to `goal` \[rad\], reached
    /// after `duration` \[s\] > 0.
    ///
    /// # Errors
    /// `NotFinite` or `OutOfRange`, naming `start`, `goal`, `start_time` or `duration`; the last
    /// one too if the move is so short that its acceleration overflows.
    pub fn new(start: [f64; N], goal: [f64; N], start_time: f64, duration: f64) -> Result<Self> {
        finite("start", &start)?;
        finite("goal", &goal)?;
        finite("start_time", &[start_time])?;
        positive("duration", &[duration])?;
        let (start, goal) = (Vector::from(start), Vector::from(goal));
        let velocity = (goal - start) / duration;
        let acceleration = velocity / duration;
        // The largest factors met in `at` are 60 in the acceleration and 30 in the velocity.
        let slow =
            |_| (0..N).all(|i| (velocity[i].abs().max(acceleration[i].abs()) * 60.0).is_finite());
        within(
            "duration",
            &[duration],
            slow,
            "a time in which the move needs no infinite acceleration",
        )?;
        Ok(Self { start, goal, start_time, duration, velocity, acceleration })
    }
}

impl<const N: usize> Reference<N> for Quintic<N> {
    #[inline]
    fn at(&self, t: f64) -> Setpoint<N> {
        let s = (t - self.start_time) / self.duration;
        if s <= 0.0 {
            return Setpoint::at_rest(self.start);
        }
        if s >= 1.0 {
            return Setpoint::at_rest(self.goal);
        }
        // p = 10s³ − 15s⁴ + 6s⁵,  p' = 30s²(1 − s)²,  p'' = 60s(1 − s)(1 − 2s)
        let r = 1.0 - s;
        let p = s * s * s * (10.0 + s * (-15.0 + s * 6.0));
        let dp = 30.0 * (s * r) * (s * r);
        let ddp = 60.0 * (s * r) * (r - s);
        Setpoint {
            q: self.start + (self.goal - self.start) * p,
            dq: self.velocity * dp,
            ddq: self.acceleration * ddp,
        }
    }
}

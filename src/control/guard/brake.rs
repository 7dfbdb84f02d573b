//! Bringing an arm to rest: PD about a set-point that slows down, weighted with the believed
//! inertia, plus the torque that carries the arm, `τ = G(q) − M₀(q)(p² e + 2p ė)`.

use crate::error::{Result, accepted};
use crate::math::Vector;
use crate::reference::Setpoint;

/// How an arm is brought to rest, joint by joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Brake<const N: usize> {
    /// p [rad/s] of the double pole at −p, > 0, at most a quarter of a radian in a period.
    pub bandwidth: [f64; N],
    /// How fast the set-point slows down [rad/s²], > 0.
    pub deceleration: [f64; N],
}

/// Bandwidth times period: beyond, a sampled double pole is no longer sure to be stable where the
/// arm is lighter than believed.
const FASTEST: f64 = 0.25;

impl<const N: usize> Brake<N> {
    /// Refuses what is not finite or out of range for a period \[s\].
    pub(super) fn validate(&self, period: f64) -> Result<()> {
        let stable = |p: f64| p > 0.0 && p * period <= FASTEST;
        let wanted = "a number > 0, at most 0.25 / control_period";
        accepted("brake.bandwidth", &self.bandwidth, stable, wanted)?;
        let above_zero = |x: f64| x > 0.0 && x.is_finite();
        accepted("brake.deceleration", &self.deceleration, above_zero, "a number > 0")
    }

    /// Moves the set-point on by `h` \[s\].
    pub(super) fn slow_down(&self, from: &Setpoint<N>, h: f64) -> Setpoint<N> {
        let dq = Vector::from_fn(|n, _| {
            let change = self.deceleration[n] * h;
            from.dq[n] - from.dq[n].clamp(-change, change)
        });
        Setpoint { q: from.q + dq * h, dq, ddq: Vector::zeros() }
    }

    /// −p² e − 2p ė [rad/s²].
    pub(super) fn acceleration(&self, e: &Vector<N>, de: &Vector<N>) -> Vector<N> {
        let p = &self.bandwidth;
        Vector::from_fn(|n, _| -p[n] * (p[n] * e[n] + 2.0 * de[n]))
    }
}

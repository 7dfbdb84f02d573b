//! Bringing an arm to rest: PD about a set-point that slows down, plus the torque that carries the
//! arm, `τ = G(q) − k_p (q − q_r) − k_v (q̇ − q̇_r)`.

use crate::error::{Result, accepted};
use crate::math::Vector;
use crate::reference::Setpoint;

/// How an arm is brought to rest, joint by joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Brake<const N: usize> {
    /// Stiffness k_p [N·m/rad], ≥ 0.
    pub stiffness: [f64; N],
    /// Damping k_v [N·m·s/rad], ≥ 0.
    pub damping: [f64; N],
    /// How fast the set-point slows down [rad/s²], > 0.
    pub deceleration: [f64; N],
}

impl<const N: usize> Brake<N> {
    /// Refuses what is not finite or out of range.
    pub(super) fn validate(&self) -> Result<()> {
        let at_least_zero = |x: f64| x >= 0.0 && x.is_finite();
        accepted("brake.stiffness", &self.stiffness, at_least_zero, "a number >= 0")?;
        accepted("brake.damping", &self.damping, at_least_zero, "a number >= 0")?;
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

    /// −k_p e − k_v ė [N·m].
    pub(super) fn torque(&self, e: &Vector<N>, de: &Vector<N>) -> Vector<N> {
        Vector::from_fn(|n, _| -self.stiffness[n] * e[n] - self.damping[n] * de[n])
    }
}

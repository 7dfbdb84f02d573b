//! The arm that is really there: `M(q) q̈ + H(q, q̇) + s(q, q̇) + τ_d(q, q̇, t) = τ` (eq. 6, with
//! the arm's stops). τ_d opposes τ.

#[cfg(feature = "std")]
mod elastic;
#[cfg(feature = "std")]
mod noise;
mod pulses;
mod wrench;

#[cfg(feature = "std")]
pub use elastic::{Elastic, MotorState};
#[cfg(feature = "std")]
pub use noise::Noise;
pub use pulses::{Pulse, Pulses, Shape};
pub use wrench::Wrench;

use crate::arm::Arm;
use crate::control::Limits;
use crate::error::Result;
#[cfg(feature = "std")]
use crate::error::within;
use crate::math::Vector;
use crate::reference::{Harmonic, Sines};

/// A disturbance torque. Any `Fn(&q, &dq, t) -> Vector<N>` is one.
pub trait Disturbance<const N: usize> {
    /// τ_d(q, q̇, t) [N·m], opposing the applied torque.
    fn torque(&self, q: &Vector<N>, dq: &Vector<N>, t: f64) -> Vector<N>;

    /// Whether another one is surely the same: many runs under it then ask once for all of them.
    fn is_same(&self, _other: &Self) -> bool
    where
        Self: Sized,
    {
        false
    }

    /// τ_d(t) [N·m] if it depends on the time alone: stages that fall on one time then share it.
    #[inline]
    fn at_time(&self, _t: f64) -> Option<Vector<N>> {
        None
    }
}

/// No disturbance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Undisturbed;

impl<const N: usize> Disturbance<N> for Undisturbed {
    fn is_same(&self, _: &Self) -> bool {
        true
    }

    fn torque(&self, _: &Vector<N>, _: &Vector<N>, _: f64) -> Vector<N> {
        Vector::zeros()
    }

    #[inline]
    fn at_time(&self, _: f64) -> Option<Vector<N>> {
        Some(Vector::zeros())
    }
}

impl<const N: usize, T: AsRef<[Harmonic<N>]>> Disturbance<N> for Sines<N, T> {
    fn is_same(&self, other: &Self) -> bool {
        let all = |it: &Self| (*it.offset(), it.start_time());
        all(self) == all(other) && self.harmonics() == other.harmonics()
    }

    #[inline]
    fn torque(&self, _: &Vector<N>, _: &Vector<N>, t: f64) -> Vector<N> {
        self.disturbance(t)
    }

    #[inline]
    fn at_time(&self, t: f64) -> Option<Vector<N>> {
        Some(self.disturbance(t))
    }
}

impl<const N: usize, F: Fn(&Vector<N>, &Vector<N>, f64) -> Vector<N>> Disturbance<N> for F {
    fn torque(&self, q: &Vector<N>, dq: &Vector<N>, t: f64) -> Vector<N> {
        self(q, dq, t)
    }
}

/// The sum of several.
#[cfg(feature = "std")]
impl<const N: usize, D: Disturbance<N>> Disturbance<N> for Vec<D> {
    fn torque(&self, q: &Vector<N>, dq: &Vector<N>, t: f64) -> Vector<N> {
        self.iter().fold(Vector::zeros(), |sum, each| sum + each.torque(q, dq, t))
    }

    fn at_time(&self, t: f64) -> Option<Vector<N>> {
        self.iter().try_fold(Vector::zeros(), |sum, each| Some(sum + each.at_time(t)?))
    }
}

/// The true arm with what acts on it.
#[derive(Clone, Debug)]
pub struct Plant<const N: usize, A, D = Undisturbed> {
    /// The arm that is really there.
    pub arm: A,
    /// τ_d.
    pub disturbance: D,
    /// What the actuators can give; only the effort limit counts here.
    limits: Limits<N>,
    /// The arms of later times \[s\], in their order.
    #[cfg(feature = "std")]
    later: Vec<(f64, A)>,
}

impl<const N: usize, A: Arm<N>, D: Disturbance<N>> Plant<N, A, D> {
    /// An arm under a disturbance, with actuators of unlimited torque.
    pub fn new(arm: A, disturbance: D) -> Self {
        Self {
            arm,
            disturbance,
            limits: Limits::default(),
            #[cfg(feature = "std")]
            later: Vec::new(),
        }
    }

    /// The same with actuators that give at most this torque [N·m].
    ///
    /// # Errors
    /// `effort_limit`: NaN or not > 0.
    pub fn with_effort_limit(mut self, effort_limit: [f64; N]) -> Result<Self> {
        self.limits = Limits { effort_limit, ..Limits::default() };
        self.limits.validate()?;
        Ok(self)
    }

    /// The same, but from time `at` \[s\] on with another arm in the place of the one before: a
    /// payload that is picked up or put down, friction that changes. Positions and velocities go
    /// on. In a simulation it takes effect with the first step from then on.
    ///
    /// # Errors
    /// `at`: not finite, or not after the change before.
    #[cfg(feature = "std")]
    pub fn with_change(mut self, at: f64, arm: A) -> Result<Self> {
        let last = self.later.last().map_or(0.0, |(at, _)| *at);
        let after = |at: f64| at.is_finite() && at > last;
        within("at", &[at], after, "a time after that of the change before, and after 0")?;
        self.later.push((at, arm));
        Ok(self)
    }

    /// The arm that is there at time `t` \[s\].
    #[inline]
    pub fn arm_at(&self, _t: f64) -> &A {
        #[cfg(feature = "std")]
        if let Some((_, arm)) = self.later.iter().rev().find(|(at, _)| *at <= _t) {
            return arm;
        }
        &self.arm
    }

    /// Whether the arm changes.
    #[cfg(feature = "std")]
    pub fn changes(&self) -> bool {
        !self.later.is_empty()
    }

    /// Largest torque of each actuator [N·m].
    pub fn effort_limit(&self) -> &[f64; N] {
        &self.limits.effort_limit
    }

    /// The torque that arrives at the joints when `tau` is asked for [N·m].
    #[inline]
    pub fn applied(&self, tau: &Vector<N>) -> Vector<N> {
        self.limits.clamp(tau)
    }

    /// q̈ = M⁻¹(τ − τ_d − H − s) [rad/s²] for an applied torque.
    #[inline]
    pub fn acceleration(
        &self,
        q: &Vector<N>,
        dq: &Vector<N>,
        tau: &Vector<N>,
        t: f64,
    ) -> Vector<N> {
        self.arm.forward_dynamics(q, dq, &(tau - self.disturbance.torque(q, dq, t)))
    }
}

//! Joint friction: `f(q̇) = b q̇ + c tanh(q̇ / s)`, a viscous part and a smoothed Coulomb part (the
//! f of eq. 6).
//!
//! With s = 0 the Coulomb part is true dry friction: at rest it is whatever holds the joint, up to
//! the torque at which that breaks away. Simulation solves for it; see [`JointFriction::hold`].

use crate::error::{Error, Result, non_negative, positive};
use crate::math::{Real, Vector, exp};

/// Friction of `N` joints, `fᵢ = bᵢ q̇ᵢ + cᵢ tanh(q̇ᵢ / sᵢ)`. It never drives the arm: q̇ᵀf ≥ 0.
///
/// The default is no friction. Its smoothing is 0.01 rad/s, for a Coulomb part that is set later.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Friction<const N: usize> {
    /// b, viscous coefficient [N·m·s/rad], ≥ 0.
    pub viscous: [f64; N],
    /// c, Coulomb torque [N·m], ≥ 0.
    pub coulomb: [f64; N],
    /// s, the speed at which the Coulomb torque reaches 76 % [rad/s], ≥ 0; zero for dry friction
    /// that sticks.
    pub smoothing: [f64; N],
}

/// Friction of one joint of a serial arm: viscous, smoothed Coulomb with its own height in each
/// direction, and Stribeck's excess at low speed. It never drives the arm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointFriction<T = f64> {
    /// b, viscous coefficient [N·m·s/rad], ≥ 0.
    pub viscous: T,
    /// c₊ and c₋, Coulomb torque in positive and in negative motion [N·m], ≥ 0.
    pub coulomb: [T; 2],
    /// Excess of the torque at which the joint breaks away over the Coulomb torque [N·m], ≥ 0.
    pub stribeck: T,
    /// The speed at which that excess has fallen to 1/e [rad/s], > 0.
    pub stribeck_speed: T,
    /// The speed at which the Coulomb torque reaches 76 % [rad/s], ≥ 0; zero for dry friction that
    /// sticks. Above zero, a joint creeps under any torque, at the speed where friction balances
    /// it: 0.55 of the smoothing at half the Coulomb torque.
    pub smoothing: T,
}

impl Default for JointFriction {
    fn default() -> Self {
        Self {
            viscous: 0.0,
            coulomb: [0.0; 2],
            stribeck: 0.0,
            stribeck_speed: 0.1,
            smoothing: 0.01,
        }
    }
}

impl JointFriction {
    /// Refuses what is not finite, a negative coefficient, and a `stribeck_speed` of zero; `joint`
    /// becomes the error's index.
    ///
    /// # Errors
    /// `NotFinite` or `OutOfRange`, naming `friction.viscous`, `friction.coulomb`,
    /// `friction.stribeck`, `friction.stribeck_speed` or `friction.smoothing`.
    pub fn validate(&self, joint: usize) -> Result<()> {
        let at = |e: Error| e.at(joint);
        non_negative("friction.viscous", &[self.viscous]).map_err(at)?;
        non_negative("friction.coulomb", &self.coulomb).map_err(at)?;
        non_negative("friction.stribeck", &[self.stribeck]).map_err(at)?;
        positive("friction.stribeck_speed", &[self.stribeck_speed]).map_err(at)?;
        non_negative("friction.smoothing", &[self.smoothing]).map_err(at)
    }

    /// True if the joint has no friction.
    pub fn is_none(&self) -> bool {
        self.viscous == 0.0 && self.is_viscous()
    }

    /// f [N·m] and ∂f/∂q̇ [N·m·s/rad] at the velocity `dq` [rad/s]; dry friction in the branch of
    /// the direction `sign`, ±1.
    #[inline]
    pub(crate) fn in_branch(&self, dq: f64, sign: f64) -> (f64, f64) {
        let viscous = self.viscous * dq;
        if self.is_viscous() {
            return (viscous, self.viscous);
        }
        let (step, rise) = if self.smoothing > 0.0 {
            let step = nearly_tanh(dq / self.smoothing);
            (step, (1.0 - step * step) / self.smoothing)
        } else {
            (sign, 0.0)
        };
        let dry = self.dry(step, dq);
        let mut slope = self.viscous + dry * rise;
        if self.stribeck != 0.0 {
            slope -=
                step * self.excess(dq) * 2.0 * dq / (self.stribeck_speed * self.stribeck_speed);
        }
        (viscous + dry * step, slope)
    }

    /// An upper bound of ∂f/∂q̇ [N·m·s/rad]; infinite for dry friction.
    #[cfg(feature = "std")]
    pub(crate) fn steepest(&self) -> f64 {
        let [up, down] = self.coulomb;
        let dry = up.max(down) + self.stribeck;
        if dry == 0.0 { self.viscous } else { self.viscous + dry / self.smoothing }
    }

    /// An upper bound of −∂f/∂q̇ where Stribeck's friction falls [N·m·s/rad]:
    /// `√(2/e) stribeck / stribeck_speed − viscous`.
    #[cfg(feature = "std")]
    pub(crate) fn falls(&self) -> f64 {
        (0.857_763_884_960_706_8 * self.stribeck / self.stribeck_speed - self.viscous).max(0.0)
    }

    /// What dry friction holds at rest: the torques [N·m] at which the joint breaks away, c₊ +
    /// stribeck and c₋ + stribeck. `None` if the friction is smooth; the joint is then never quite
    /// at rest.
    #[inline]
    pub fn hold(&self) -> Option<[f64; 2]> {
        (self.smoothing == 0.0 && !self.is_viscous())
            .then(|| self.coulomb.map(|c| c + self.stribeck))
    }

    /// Whether `other` is a part of this friction: what is left neither drives the joint, nor falls
    /// where this friction does not.
    #[cfg(feature = "std")]
    pub(crate) fn covers(&self, other: &Self) -> bool {
        let stribeck = other.stribeck == 0.0
            || self.stribeck >= other.stribeck && self.stribeck_speed == other.stribeck_speed;
        self.viscous >= other.viscous
            && self.coulomb[0] >= other.coulomb[0]
            && self.coulomb[1] >= other.coulomb[1]
            && (self.smoothing == other.smoothing || other.is_viscous())
            && stribeck
    }
}

impl<T: Real> JointFriction<T> {
    /// `f = b q̇ + (c± + stribeck · exp(−(q̇/stribeck_speed)²)) tanh(q̇/smoothing)` [N·m] at the
    /// velocity `dq` [rad/s], with c₊ for q̇ > 0 and c₋ for q̇ < 0; f q̇ ≥ 0. With a `smoothing` of
    /// zero the tanh is the sign of q̇, 0 at rest.
    #[inline(always)]
    pub fn torque(&self, dq: T) -> T {
        let viscous = self.viscous * dq;
        if self.is_viscous() {
            return viscous;
        }
        viscous + self.dry(dq, dq) * self.step(dq)
    }

    /// Whether nothing of it is dry.
    #[inline(always)]
    pub(crate) fn is_viscous(&self) -> bool {
        let zero = self.viscous.like(0.0);
        self.coulomb == [zero; 2] && self.stribeck == zero
    }

    /// c± + stribeck · exp(−(q̇/stribeck_speed)²) in the direction that has the sign of `direction`
    /// [N·m].
    #[inline(always)]
    fn dry(&self, direction: T, dq: T) -> T {
        let [up, down] = self.coulomb;
        let mut dry = direction.if_less(dq.like(0.0), down, up);
        if self.stribeck != dq.like(0.0) {
            dry += self.excess(dq);
        }
        dry
    }

    #[inline(always)]
    fn excess(&self, dq: T) -> T {
        let ratio = dq / self.stribeck_speed;
        self.stribeck * (-(ratio * ratio)).exp()
    }

    /// tanh(q̇/smoothing), or its limit for dry friction.
    #[inline(always)]
    fn step(&self, dq: T) -> T {
        let (zero, one) = (dq.like(0.0), dq.like(1.0));
        if zero.any_less(self.smoothing) {
            (dq / self.smoothing).tanh()
        } else {
            dq.if_less(zero, -one, zero.if_less(dq, one, zero))
        }
    }
}

/// tanh x to an absolute error of 2e-16, in half the time. Good for a torque; not where the error
/// relative to x counts.
#[inline]
fn nearly_tanh(x: f64) -> f64 {
    if x.abs() > 22.0 { x.signum() } else { 1.0 - 2.0 / (exp(2.0 * x) + 1.0) }
}

impl<const N: usize> Default for Friction<N> {
    fn default() -> Self {
        Self { viscous: [0.0; N], coulomb: [0.0; N], smoothing: [0.01; N] }
    }
}

impl<const N: usize> Friction<N> {
    /// Refuses what is not finite, and what is negative.
    ///
    /// # Errors
    /// `NotFinite` or `OutOfRange`, naming `friction.viscous`, `friction.coulomb` or
    /// `friction.smoothing`.
    pub fn validate(&self) -> Result<()> {
        non_negative("friction.viscous", &self.viscous)?;
        non_negative("friction.coulomb", &self.coulomb)?;
        non_negative("friction.smoothing", &self.smoothing)
    }

    /// True if no joint has any friction.
    pub fn is_none(&self) -> bool {
        self.viscous.iter().chain(&self.coulomb).all(|&c| c == 0.0)
    }

    /// The friction of one joint.
    #[inline]
    pub fn joint(&self, joint: usize) -> JointFriction {
        JointFriction {
            viscous: self.viscous[joint],
            coulomb: [self.coulomb[joint]; 2],
            smoothing: self.smoothing[joint],
            ..JointFriction::default()
        }
    }

    /// f(q̇) [N·m] at the velocity `dq` [rad/s].
    #[inline]
    pub fn torque(&self, dq: &Vector<N>) -> Vector<N> {
        Vector::from_fn(|i, _| self.joint(i).torque(dq[i]))
    }
}

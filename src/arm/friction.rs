//! Joint friction: `f(q̇) = b q̇ + c tanh(q̇ / s)`, a viscous part and a smoothed Coulomb part (the f of eq. 6).

use crate::error::{Error, Result, non_negative, positive};
use crate::math::{Vector, exp, tanh};

/// Friction of `N` joints, `fᵢ = bᵢ q̇ᵢ + cᵢ tanh(q̇ᵢ / sᵢ)`. It never drives the arm: q̇ᵀf ≥ 0.
///
/// The default is no friction, with a smoothing of 0.01 rad/s should a Coulomb part be set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Friction<const N: usize> {
    /// b, viscous coefficient [N·m·s/rad], ≥ 0.
    pub viscous: [f64; N],
    /// c, Coulomb torque [N·m], ≥ 0.
    pub coulomb: [f64; N],
    /// s, the speed at which the Coulomb torque reaches 76 % [rad/s], > 0.
    pub smoothing: [f64; N],
}

/// Friction of one joint of a serial arm: viscous, smoothed Coulomb with its own height in each direction, and Stribeck's
/// excess at low speed. It never drives the arm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointFriction {
    /// b, viscous coefficient [N·m·s/rad], ≥ 0.
    pub viscous: f64,
    /// c₊ and c₋, Coulomb torque in positive and in negative motion [N·m], ≥ 0.
    pub coulomb: [f64; 2],
    /// Excess of the torque at which the joint breaks away over the Coulomb torque [N·m], ≥ 0.
    pub stribeck: f64,
    /// The speed at which that excess has fallen to 1/e [rad/s], > 0.
    pub stribeck_speed: f64,
    /// The speed at which the Coulomb torque reaches 76 % [rad/s], > 0.
    pub smoothing: f64,
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
    /// Refuses what is not finite, a negative coefficient, and a speed that is not positive; `joint` becomes the error's index.
    ///
    /// # Errors
    /// `NotFinite` or `OutOfRange`, naming `friction.viscous`, `friction.coulomb`, `friction.stribeck`,
    /// `friction.stribeck_speed` or `friction.smoothing`.
    pub fn validate(&self, joint: usize) -> Result<()> {
        let at = |e| at_joint(e, joint);
        non_negative("friction.viscous", &[self.viscous]).map_err(at)?;
        non_negative("friction.coulomb", &self.coulomb).map_err(at)?;
        non_negative("friction.stribeck", &[self.stribeck]).map_err(at)?;
        positive("friction.stribeck_speed", &[self.stribeck_speed]).map_err(at)?;
        positive("friction.smoothing", &[self.smoothing]).map_err(at)
    }

    /// True if the joint has no friction.
    pub fn is_none(&self) -> bool {
        self.viscous == 0.0 && self.is_viscous()
    }

    fn is_viscous(&self) -> bool {
        self.coulomb == [0.0; 2] && self.stribeck == 0.0
    }

    /// `f = b q̇ + (c± + stribeck · exp(−(q̇/stribeck_speed)²)) tanh(q̇/smoothing)` [N·m] at the velocity `dq` [rad/s], with c₊
    /// for q̇ > 0 and c₋ for q̇ < 0; f is continuous, and f q̇ ≥ 0.
    #[inline]
    pub fn torque(&self, dq: f64) -> f64 {
        let viscous = self.viscous * dq;
        if self.is_viscous() {
            return viscous;
        }
        let mut dry = self.coulomb[usize::from(dq < 0.0)];
        if self.stribeck != 0.0 {
            let ratio = dq / self.stribeck_speed;
            dry += self.stribeck * exp(-(ratio * ratio));
        }
        viscous + dry * tanh(dq / self.smoothing)
    }
}

/// The same refusal, with the joint as its place.
fn at_joint(error: Error, joint: usize) -> Error {
    let index = Some(joint);
    match error {
        Error::NotFinite { parameter, got, .. } => Error::NotFinite { parameter, index, got },
        Error::OutOfRange { parameter, got, wanted, .. } => {
            Error::OutOfRange { parameter, index, got, wanted }
        }
        other => other,
    }
}

impl<const N: usize> Default for Friction<N> {
    fn default() -> Self {
        Self { viscous: [0.0; N], coulomb: [0.0; N], smoothing: [0.01; N] }
    }
}

impl<const N: usize> Friction<N> {
    /// Refuses what is not finite, a negative coefficient, and a smoothing that is not positive.
    ///
    /// # Errors
    /// `NotFinite` or `OutOfRange`, naming `friction.viscous`, `friction.coulomb` or `friction.smoothing`.
    pub fn validate(&self) -> Result<()> {
        non_negative("friction.viscous", &self.viscous)?;
        non_negative("friction.coulomb", &self.coulomb)?;
        positive("friction.smoothing", &self.smoothing)
    }

    /// True if no joint has any friction.
    pub fn is_none(&self) -> bool {
        self.viscous.iter().chain(&self.coulomb).all(|&c| c == 0.0)
    }

    /// f(q̇) [N·m] at the velocity `dq` [rad/s].
    #[inline]
    pub fn torque(&self, dq: &Vector<N>) -> Vector<N> {
        Vector::from_fn(|i, _| {
            let viscous = self.viscous[i] * dq[i];
            if self.coulomb[i] == 0.0 {
                return viscous;
            }
            viscous + self.coulomb[i] * tanh(dq[i] / self.smoothing[i])
        })
    }
}

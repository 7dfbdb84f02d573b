//! What opposes the motion of one joint and may be stiff: `g(v) = f(v) − f̂(v) + s(q, v)`. That is
//! its friction, less the friction that the controller cancels, and its stop.

#[cfg(feature = "std")]
use super::Arm;
use super::{JointFriction, JointLimits, JointStop};

/// Friction, what is known and cancelled of it, and the stop of a joint.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Resistance {
    pub friction: JointFriction,
    /// f̂, which the joint's torque contains; [`JointFriction::covers`] it.
    pub known: JointFriction,
    pub stop: JointStop,
    pub limits: JointLimits,
}

impl Resistance {
    /// What opposes the motion of the joints of an arm.
    #[cfg(feature = "std")]
    pub fn of<const N: usize, A: Arm<N> + ?Sized>(arm: &A) -> [Self; N] {
        core::array::from_fn(|joint| {
            let (stop, limits) = arm.joint_stop(joint);
            Self { friction: arm.joint_friction(joint), stop, limits, ..Self::default() }
        })
    }

    /// A joint at rest, with nothing but what its dry friction holds.
    pub fn holding(friction: &JointFriction) -> Self {
        let coulomb = friction.hold().unwrap_or_default();
        let friction = JointFriction { coulomb, smoothing: 0.0, ..JointFriction::default() };
        Self { friction, ..Self::default() }
    }

    /// Whether nothing opposes the motion.
    #[inline]
    #[cfg(feature = "std")]
    pub fn is_none(&self) -> bool {
        self.friction == self.known && self.stop.is_none()
    }

    /// The torques at which the joint at rest breaks away [N·m], if it sticks.
    pub fn hold(&self) -> Option<[f64; 2]> {
        let [up, down] = self.friction.hold()?;
        let [known_up, known_down] = self.known.hold().unwrap_or_default();
        Some([up - known_up, down - known_down])
    }

    /// g [N·m] at the velocity `v` and the position `place + lead v`, and its slope [N·m·s/rad].
    /// The slope is 0 where g falls (Stribeck), so that a step of Newton's method still goes down.
    /// Dry friction is taken in the direction `sign`.
    #[inline]
    pub fn at(&self, v: f64, sign: f64, place: f64, lead: f64) -> (f64, f64) {
        let (mut torque, mut slope) = self.friction.in_branch(v, sign);
        if !self.known.is_none() {
            let (known, known_slope) = self.known.in_branch(v, sign);
            (torque, slope) = (torque - known, slope - known_slope);
        }
        slope = slope.max(0.0);
        if self.stop.is_none() {
            return (torque, slope);
        }
        let q = place + lead * v;
        let [by_q, by_v] = self.stop.slopes(&self.limits, q, v);
        (torque + self.stop.torque(&self.limits, q, v), slope + by_v + lead * by_q)
    }
}

//! Stops at the ends of a joint's range: springs that lose energy, after Hunt and Crossley 1975.

use super::limits::JointLimits;
use super::place::Of;
use crate::error::Result;

/// The stops of a joint, at the ends of its [`JointLimits`]. A joint that is δ beyond an end is
/// pushed back with `max(0, k δ (1 + c δ̇))`. That is continuous, never pulls, and never gives back
/// more energy than it took. The default is none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointStop {
    /// k [N·m/rad], or [N/m] for a prismatic joint, ≥ 0; zero for no stop.
    pub stiffness: f64,
    /// c [s/rad or s/m], ≥ 0; zero gives all energy back.
    pub dissipation: f64,
}

impl JointStop {
    /// Refuses what is not finite or negative; errors carry `joint` as their index.
    ///
    /// # Errors
    /// `NotFinite` or `OutOfRange`, naming `stop.stiffness` or `stop.dissipation`.
    pub fn validate(&self, joint: usize) -> Result<()> {
        let of = |parameter| Of { parameter, joint: Some(joint) };
        let Self { stiffness, dissipation } = *self;
        of("stop.stiffness").within(stiffness, stiffness >= 0.0, "a number >= 0")?;
        of("stop.dissipation").within(dissipation, dissipation >= 0.0, "a number >= 0")
    }

    /// True if the joint has no stop.
    pub fn is_none(&self) -> bool {
        self.stiffness == 0.0
    }

    /// s [N·m or N], what drives the joint on into its stop: positive beyond the upper end,
    /// negative beyond the lower one.
    #[inline]
    pub fn torque(&self, limits: &JointLimits, q: f64, dq: f64) -> f64 {
        let push = |depth: f64, rate: f64| {
            if depth > 0.0 {
                (self.stiffness * depth * (1.0 + self.dissipation * rate)).max(0.0)
            } else {
                0.0
            }
        };
        push(q - limits.upper, dq) - push(limits.lower - q, -dq)
    }

    /// ∂s/∂q [N·m/rad] and ∂s/∂q̇ [N·m·s/rad], both ≥ 0.
    pub(crate) fn slopes(&self, limits: &JointLimits, q: f64, dq: f64) -> [f64; 2] {
        let (depth, rate) =
            if q > limits.upper { (q - limits.upper, dq) } else { (limits.lower - q, -dq) };
        let rise = 1.0 + self.dissipation * rate;
        if depth > 0.0 && rise > 0.0 {
            [self.stiffness * rise, self.stiffness * self.dissipation * depth]
        } else {
            [0.0; 2]
        }
    }
}

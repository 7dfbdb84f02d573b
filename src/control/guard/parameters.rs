//! What a guard allows.

use super::Brake;
use crate::control::checks::check_period;
use crate::error::{Result, accepted};

/// Limits and times of a [`Guard`](super::Guard); infinite for no limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GuardParameters<const N: usize> {
    /// Nominal period of the loop \[s\], 1e-9 to 1.
    pub control_period: f64,
    /// Smallest and largest position of each joint \[rad\].
    pub position_limits: [[f64; 2]; N],
    /// Largest speed of each joint [rad/s]; also what a position may change between two samples.
    pub velocity_limit: [f64; N],
    /// What a position may change beyond that \[rad\]: the step of an encoder, or a noise.
    pub slack: [f64; N],
    /// Largest |τ| of each joint [N·m].
    pub effort_limit: [f64; N],
    /// Largest change of each τ per second [N·m/s], from the torque commanded last.
    pub effort_rate_limit: [f64; N],
    /// Largest mechanical power τ·q̇ that a joint gives to the arm \[W\].
    pub power_limit: [f64; N],
    /// Largest |e| of each joint \[rad\].
    pub envelope: [f64; N],
    /// Periods without a good sample in which the last torque is held.
    pub hold: u32,
    /// Further periods in which it becomes the torque that carries the arm. Then the guard stops.
    pub decay: u32,
    /// How the arm is brought to rest.
    pub brake: Brake<N>,
}

impl<const N: usize> GuardParameters<N> {
    /// No limits; twenty periods of holding, as libfranka has them, and twenty of decay.
    pub fn new(control_period: f64, brake: Brake<N>) -> Self {
        let none = [f64::INFINITY; N];
        Self {
            control_period,
            position_limits: [[f64::NEG_INFINITY, f64::INFINITY]; N],
            velocity_limit: none,
            slack: [0.0; N],
            effort_limit: none,
            effort_rate_limit: none,
            power_limit: none,
            envelope: none,
            hold: 20,
            decay: 20,
            brake,
        }
    }

    /// Refuses limits that make no sense.
    ///
    /// # Errors
    /// The name of the parameter, with the joint.
    pub fn validate(&self) -> Result<()> {
        check_period("control_period", self.control_period)?;
        let wanted = "a limit > 0 (infinite for none)";
        for (name, limits) in [
            ("velocity_limit", &self.velocity_limit),
            ("effort_limit", &self.effort_limit),
            ("effort_rate_limit", &self.effort_rate_limit),
            ("power_limit", &self.power_limit),
            ("envelope", &self.envelope),
        ] {
            accepted(name, limits, |limit| limit > 0.0, wanted)?;
        }
        let slack = |x: f64| x >= 0.0 && x.is_finite();
        accepted("slack", &self.slack, slack, "a number >= 0")?;
        for (joint, [lower, upper]) in self.position_limits.iter().enumerate() {
            let wanted = "a range whose lower end is below the upper";
            accepted("position_limits", &[*lower], |lower| lower < *upper, wanted)
                .map_err(|error| error.at(joint))?;
        }
        self.brake.validate(self.control_period)
    }
}

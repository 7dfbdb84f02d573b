//! What sensors, timing and actuators do to a sampled loop: all that stands between a controller
//! and its arm. All of it is off by default.
//!
//! The way through, in every period: `timing` says when the sample is taken and whether it is lost;
//! `sensors` make a measurement of the motion; the torque waits for its delay; `actuators` make of
//! it what arrives at the joints, through a `transmission`. `random` draws the numbers, from one
//! seed and a stream for each effect, so that none changes those of another.

mod actuators;
mod random;
mod sensors;
mod timing;
mod transmission;

pub use actuators::Actuators;
pub(crate) use actuators::Drive;
pub(crate) use sensors::Measuring;
pub use sensors::{Sensors, Velocity};
pub(crate) use timing::Clock;
pub use timing::Timing;
pub use transmission::{Side, Transmission};

use crate::error::Result;

/// What happens between controller and arm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Effects<const N: usize> {
    /// What is measured.
    pub sensors: Sensors<N>,
    /// When.
    pub timing: Timing,
    /// What becomes of the torque.
    pub actuators: Actuators<N>,
    /// Gears that give; `None`: links follow their motors.
    pub transmission: Option<Transmission<N>>,
    /// Seed of all that is random: the same seed gives the same bits.
    pub seed: u64,
}

impl<const N: usize> Effects<N> {
    /// Refuses what makes no sense.
    ///
    /// # Errors
    /// Naming the parameter, such as `encoder`, `jitter` or `lag`.
    pub fn validate(&self) -> Result<()> {
        self.sensors.validate()?;
        self.timing.validate()?;
        self.actuators.validate()
    }

    /// Whether any effect is on.
    pub fn is_on(&self) -> bool {
        let Self { sensors, timing, actuators, transmission, .. } = self;
        *sensors != Sensors::default()
            || *timing != Timing::default()
            || *actuators != Actuators::default()
            || transmission.is_some()
    }
}

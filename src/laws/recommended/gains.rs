//! Gains of the recommended controller: what its rule chooses.

use super::pull::Pull;
use crate::control::MAX_DELAY;
use crate::error::{Result, at_most, positive};

/// A joint that is quicker at its largest torque seems to lack its rotor [rad/s²].
pub(super) const QUICKEST: f64 = 5000.0;

/// Gains of the recommended controller; with `std`, `Rule` gives them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LearningGains<const N: usize> {
    /// p, at which the three poles of each joint are, and how far errors are brought back.
    pub pull: Pull<N>,
    /// f of the second velocity filter of each joint \[Hz\].
    pub cut_off: [f64; N],
    /// Cut-off of the filter through which is learnt \[Hz\].
    pub learning: f64,
    /// c.
    pub acceleration_share: f64,
    /// What a row of each joint is measured in [N·m]: what it says is good to 1 % of that.
    pub unit: [f64; N],
    /// Period of the loop \[s\], and samples between a torque and its period.
    pub control_period: f64,
    /// At most [`MAX_DELAY`].
    pub delay: usize,
    /// What the largest torque gives each joint at most, as the rule found it [rad/s²]: far more
    /// than 5000 where the model lacks a rotor. NaN for gains of one's own.
    pub quickness: [f64; N],
    /// |Δ (I − Δ)⁻¹| at its largest, as the rule found it: what is learnt converges for sure below
    /// 0.7. NaN for gains of one's own.
    pub condition: f64,
}

impl<const N: usize> LearningGains<N> {
    pub(super) fn validate(&self) -> Result<()> {
        self.pull.validate()?;
        positive("cut_off", &self.cut_off)?;
        positive("learning", &[self.learning])?;
        positive("acceleration_share", &[self.acceleration_share])?;
        positive("unit", &self.unit)?;
        positive("control_period", &[self.control_period])?;
        at_most("delay", self.delay, MAX_DELAY)
    }
}

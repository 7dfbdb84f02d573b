//! What becomes of a torque: limits of the drive, a gain that is off, a lag, cogging.
//!
//! ```text
//! told back    limited(τ): what the drive's own limits let through
//! at the joint τ_j' = (g τ − τ_j)/T,  τ_j − c sin(p q)
//! ```

use crate::control::Limits;
use crate::error::{Result, accepted, non_negative, positive};
use crate::math::{Vector, exp, sin_cos};

/// What becomes of a torque. The largest torque of each actuator is the plant's
/// [`effort_limit`](crate::plant::Plant::effort_limit).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Actuators<const N: usize> {
    /// Largest change of each torque [N·m/s]; infinite for none.
    pub effort_rate_limit: [f64; N],
    /// What arrives of a torque, as a share: 1 where the drive's constant is right.
    pub gain: [f64; N],
    /// Time constant T of each drive \[s\]; 0: none.
    pub lag: [f64; N],
    /// Largest cogging torque c [N·m].
    pub cogging: [f64; N],
    /// Periods of the cogging in a turn of the joint, p.
    pub cogging_per_turn: f64,
}

impl<const N: usize> Default for Actuators<N> {
    fn default() -> Self {
        Self {
            effort_rate_limit: [f64::INFINITY; N],
            gain: [1.0; N],
            lag: [0.0; N],
            cogging: [0.0; N],
            cogging_per_turn: 100.0,
        }
    }
}

impl<const N: usize> Actuators<N> {
    /// Refuses what makes no sense.
    ///
    /// # Errors
    /// `effort_rate_limit`: NaN or not > 0. `gain`, `cogging_per_turn`: not finite or not > 0.
    /// `lag`, `cogging`: not finite or negative.
    pub fn validate(&self) -> Result<()> {
        let wanted = "a limit > 0 (infinite for none)";
        accepted("effort_rate_limit", &self.effort_rate_limit, |limit| limit > 0.0, wanted)?;
        positive("gain", &self.gain)?;
        positive("cogging_per_turn", &[self.cogging_per_turn])?;
        non_negative("lag", &self.lag)?;
        non_negative("cogging", &self.cogging)
    }

    /// The cogging torque at a pose, which opposes the actuator's [N·m].
    pub(crate) fn cogging_torque(&self, q: &Vector<N>) -> Vector<N> {
        Vector::from_fn(|n, _| match self.cogging[n] {
            0.0 => 0.0,
            c => c * sin_cos(self.cogging_per_turn * q[n]).0,
        })
    }

    fn lags(&self) -> bool {
        self.lag.iter().any(|lag| *lag > 0.0)
    }
}

/// The drives, period after period.
pub(crate) struct Drive<const N: usize> {
    actuators: Actuators<N>,
    limits: Limits<N>,
    /// What the drives' limits let through last, what acts of it, and what arrives now [N·m].
    told: Vector<N>,
    acting: Vector<N>,
    arrived: Vector<N>,
}

impl<const N: usize> Drive<N> {
    /// Drives with these limits of effort; `begun` is the torque that is on the arm.
    pub fn new(actuators: Actuators<N>, effort_limit: [f64; N], begun: &Vector<N>) -> Self {
        let effort_rate_limit = actuators.effort_rate_limit;
        let limits = Limits { effort_limit, effort_rate_limit };
        let told = limits.clamp(begun);
        let arrived = Vector::from_fn(|n, _| actuators.gain[n] * told[n]);
        Self { actuators, limits, told, acting: told, arrived }
    }

    /// A torque that is asked for, `elapsed` \[s\] after the last one: what the drives tell back.
    pub fn ask(&mut self, tau: &Vector<N>, elapsed: f64) -> Vector<N> {
        let limited = if self.limits.limits_rate() {
            self.limits.clamp_after(&self.told, tau, elapsed)
        } else {
            self.limits.clamp(tau)
        };
        self.told = limited;
        limited
    }

    /// What acts from now on, of what was told [N·m].
    pub fn act(&mut self, acting: &Vector<N>) {
        self.acting = *acting;
        if !self.actuators.lags() {
            self.arrived = self.aim();
        }
    }

    /// What arrives at the joints now [N·m].
    pub fn arrived(&self) -> Vector<N> {
        self.arrived
    }

    /// The mean of what arrives at the joints in the next `h` \[s\] [N·m].
    pub fn arriving(&mut self, h: f64) -> Vector<N> {
        if !self.actuators.lags() {
            return self.arrived;
        }
        let (lag, aim, start) = (&self.actuators.lag, self.aim(), self.arrived);
        let fading: [f64; N] =
            core::array::from_fn(|n| if lag[n] > 0.0 { exp(-h / lag[n]) } else { 0.0 });
        self.arrived = Vector::from_fn(|n, _| aim[n] + (start[n] - aim[n]) * fading[n]);
        Vector::from_fn(|n, _| aim[n] + (start[n] - aim[n]) * (1.0 - fading[n]) * lag[n] / h)
    }

    fn aim(&self) -> Vector<N> {
        Vector::from_fn(|n, _| self.actuators.gain[n] * self.acting[n])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In 3 ms a lag of 2 ms follows by 1 − e^(−1.5), in one step or in three.
    #[test]
    fn a_lag_is_followed_exactly_whatever_the_steps() {
        let actuators = Actuators { lag: [2e-3], gain: [1.1], ..Actuators::<1>::default() };
        let mean = |steps: u32| {
            let mut drive = Drive::new(actuators, [f64::INFINITY], &Vector::zeros());
            drive.act(&Vector::<1>::new(5.0));
            let h = 3e-3 / f64::from(steps);
            let sum: f64 = (0..steps).map(|_| drive.arriving(h)[0]).sum();
            (sum / f64::from(steps), drive.arrived()[0])
        };
        let ((one, end), (three, last)) = (mean(1), mean(3));
        assert!((one - three).abs() < 1e-12 && (end - last).abs() < 1e-12);
        assert!((end - 5.5 * (1.0 - (-1.5_f64).exp())).abs() < 1e-12);
    }

    #[test]
    fn a_drive_tells_back_what_its_limits_let_through() {
        let actuators = Actuators { effort_rate_limit: [1000.0], ..Actuators::<1>::default() };
        let mut drive = Drive::new(actuators, [2.5], &Vector::zeros());
        let told = [9.0, 9.0, 9.0, -9.0].map(|tau| drive.ask(&Vector::<1>::new(tau), 1e-3)[0]);
        assert_eq!(told, [1.0, 2.0, 2.5, 1.5]);
    }
}

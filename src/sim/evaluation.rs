//! All that is known of the loop at one instant: measurement, command, what the plant made of it.

use crate::control::{Audit, Command, Sample};
use crate::math::Vector;

/// All that is known of the loop at one stage.
#[derive(Clone, Copy, Debug)]
pub struct Evaluation<const N: usize> {
    /// Time \[s\].
    pub t: f64,
    /// Measurement, set-point and error.
    pub sample: Sample<N>,
    /// What the controller asked for.
    pub command: Command<N>,
    /// What the actuators gave [N·m].
    pub applied: Vector<N>,
    /// ρ = q̈ − v + ρ̂ [rad/s²], from the applied torque.
    pub rho: Vector<N>,
    /// The terms of the dissipation identity.
    pub audit: Option<Audit<N>>,
}

impl<const N: usize> Evaluation<N> {
    /// Completes a command with what the plant made of it.
    #[inline]
    pub(super) fn new(
        t: f64,
        sample: Sample<N>,
        command: Command<N>,
        applied: Vector<N>,
        ddq: &Vector<N>,
        audit: Option<Audit<N>>,
    ) -> Self {
        let rho = ddq - command.v + command.rho_hat;
        Self { t, sample, command, applied, rho, audit }
    }
}

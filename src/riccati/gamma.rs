//! The attenuation level γ of `AᵀP + PA + γ⁻² P B BᵀP + Q = 0`, and what it leaves room for.

use crate::error::{Result, within};

/// Refuses what is no level; infinity leaves the Lyapunov equation.
pub(super) fn check_gamma(gamma: f64) -> Result<()> {
    if gamma == f64::INFINITY {
        return Ok(());
    }
    within("gamma", &[gamma], |x| x > 0.0, "a number > 0, or infinity")
}

/// The factor by which Q may be multiplied at `gamma` before there is no solution.
pub(super) fn scale(gamma: f64, gamma_opt: f64) -> f64 {
    let ratio = gamma / gamma_opt;
    ratio * ratio
}

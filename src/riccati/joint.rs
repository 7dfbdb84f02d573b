//! One joint with diagonal gains: the equation in closed form.
//!
//! A = [0 1; −k_p −k_v], B = [0; 1], Q = diag(q₁, q₂), g = γ⁻² (g = −1/r for the LQR sign):
//! `p12 = q₁/(k_p + α)`, `p22 = (q₂ + 2 p12)/(k_v + β)`, `p11 = k_v p12 + k_p p22 − g p12 p22`
//! with `α = √(k_p² − g q₁)`, `β = √(k_v² − g (q₂ + 2 p12))`. The closed loop is s² + β s + α.

use super::gamma::{check_gamma, scale};
use crate::error::{Error, Result, finite, non_negative, positive};
use crate::math::sqrt;

/// P = [p11 p12; p12 p22] of one joint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointSolution {
    /// Entry of position with position.
    pub p11: f64,
    /// Entry of position with velocity.
    pub p12: f64,
    /// Entry of velocity with velocity.
    pub p22: f64,
}

impl JointSolution {
    /// The smaller eigenvalue of P, free of cancellation.
    pub fn min_eigenvalue(&self) -> f64 {
        let largest =
            0.5 * (self.p11 + self.p22 + libm::hypot(self.p11 - self.p22, 2.0 * self.p12));
        if largest == 0.0 {
            return 0.0;
        }
        self.p11 / largest * self.p22 - self.p12 / largest * self.p12
    }

    /// The largest real part of the closed loop A + g B BᵀP [1/s], with g = γ⁻² or −1/r.
    pub fn max_real(&self, kp: f64, kv: f64, g: f64) -> f64 {
        let (alpha, beta) = (kp - g * self.p12, kv - g * self.p22);
        let discriminant = 0.25 * beta * beta - alpha;
        if discriminant <= 0.0 {
            return -0.5 * beta;
        }
        // The product of the two real roots is α: no difference of nearly equal numbers.
        let fast = -0.5 * beta - sqrt(discriminant).copysign(beta);
        if beta >= 0.0 { alpha / fast } else { fast }
    }

    /// ‖AᵀP + PA + g P B BᵀP + Q‖ / (2‖A‖‖P‖ + ‖G‖‖P‖² + ‖Q‖) with G = |g| BBᵀ, Frobenius norms.
    pub fn residual(&self, kp: f64, kv: f64, q1: f64, q2: f64, g: f64) -> f64 {
        let Self { p11, p12, p22 } = *self;
        let r11 = g * p12 * p12 - 2.0 * kp * p12 + q1;
        let r12 = p11 - kv * p12 - kp * p22 + g * p12 * p22;
        let r22 = g * p22 * p22 - 2.0 * kv * p22 + 2.0 * p12 + q2;
        let norm =
            |a: f64, b: f64, c: f64, d: f64| libm::hypot(libm::hypot(a, b), libm::hypot(c, d));
        let (a, p) = (norm(0.0, 1.0, kp, kv), norm(p11, p12, p12, p22));
        let terms = 2.0 * a * p + g.abs() * p * p + libm::hypot(q1, q2);
        if terms == 0.0 { 0.0 } else { norm(r11, r12, r12, r22) / terms }
    }
}

/// The stabilising solution for the gains `kp` [1/s²] > 0 and `kv` [1/s] > 0, Q = diag(`q1`,
/// `q2`) ≥ 0 and `gamma` > 0 (∞ gives the Lyapunov equation).
///
/// # Errors
/// `NotFinite`, `OutOfRange`, or `NoStabilizingSolution` unless both radicands are > 0.
pub fn joint(kp: f64, kv: f64, q1: f64, q2: f64, gamma: f64) -> Result<JointSolution> {
    check(kp, kv, q1, q2)?;
    check_gamma(gamma)?;
    // √(x² − y/γ²) as a product: exact at the limit, and no overflow.
    let root = |x: f64, y: f64| {
        let level = sqrt(y) / gamma;
        (level < x).then(|| sqrt(x - level) * sqrt(x + level))
    };
    let solution = root(kp, q1).and_then(|alpha| {
        let p12 = q1 / (kp + alpha);
        let beta = root(kv, q2 + 2.0 * p12)?;
        Some(assemble(kp, p12, (q2 + 2.0 * p12) / (kv + beta), beta))
    });
    match solution {
        Some(p) => finite_solution(p),
        None => {
            let gamma_opt = joint_gamma_opt(kp, kv, q1, q2)?;
            Err(Error::no_stabilizing_solution(gamma, gamma_opt, scale(gamma, gamma_opt)))
        }
    }
}

/// The same with the LQR sign: `AᵀP + PA − P B BᵀP / r + Q = 0`, `r` > 0.
///
/// # Errors
/// `NotFinite`, `OutOfRange`.
pub fn joint_lqr(kp: f64, kv: f64, q1: f64, q2: f64, r: f64) -> Result<JointSolution> {
    check(kp, kv, q1, q2)?;
    positive("r", &[r])?;
    let root = |x: f64, y: f64| libm::hypot(x, sqrt(y / r));
    let p12 = q1 / (kp + root(kp, q1));
    let beta = root(kv, q2 + 2.0 * p12);
    finite_solution(assemble(kp, p12, (q2 + 2.0 * p12) / (kv + beta), beta))
}

/// γ_opt of one joint: the maximum over x = ω² ≥ 0 of `√((q₁ + q₂x)/((k_p − x)² + k_v²x))`.
///
/// The maximum is at the root of `q₂x² + 2q₁x = q₂k_p² − q₁(k_v² − 2k_p)`, or at 0.
///
/// # Errors
/// `NotFinite`, `OutOfRange`.
pub fn joint_gamma_opt(kp: f64, kv: f64, q1: f64, q2: f64) -> Result<f64> {
    check(kp, kv, q1, q2)?;
    let c = q2 * kp * kp - q1 * (kv * kv - 2.0 * kp);
    let x = if c > 0.0 { c / (q1 + sqrt(q1 * q1 + q2 * c)) } else { 0.0 };
    let gamma_opt = libm::hypot(sqrt(q1), sqrt(q2 * x)) / libm::hypot(kp - x, kv * sqrt(x));
    finite("gamma_opt", &[gamma_opt])?;
    Ok(gamma_opt)
}

/// The factor below which Q may be multiplied at this `gamma`: (γ/γ_opt)²; ∞ for Q = 0.
///
/// # Errors
/// `NotFinite`, `OutOfRange`.
pub fn joint_max_scale(kp: f64, kv: f64, q1: f64, q2: f64, gamma: f64) -> Result<f64> {
    check_gamma(gamma)?;
    Ok(scale(gamma, joint_gamma_opt(kp, kv, q1, q2)?))
}

fn check(kp: f64, kv: f64, q1: f64, q2: f64) -> Result<()> {
    positive("kp", &[kp])?;
    positive("kv", &[kv])?;
    non_negative("q1", &[q1])?;
    non_negative("q2", &[q2])
}

/// `p11 = k_v p12 + k_p p22 − g p12 p22 = k_p p22 + β p12`, a sum of positive terms.
fn assemble(kp: f64, p12: f64, p22: f64, beta: f64) -> JointSolution {
    JointSolution { p11: kp * p22 + beta * p12, p12, p22 }
}

fn finite_solution(p: JointSolution) -> Result<JointSolution> {
    finite("p", &[p.p11, p.p12, p.p22])?;
    Ok(p)
}

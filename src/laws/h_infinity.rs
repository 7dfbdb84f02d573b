//! Nonlinear H∞: `v = q̈_d − K_v ė − K_p e − BᵀPx/r`, P from
//! `AᵀP + PA + Q − (2/r − γ⁻²) P B BᵀP = 0`.
//!
//! The robust term BᵀPx/r is the one that the paper's law leaves out. For `r ≤ 2γ²` there is a P
//! for every Q. Source: Chen, Lee, Chang 1996; Chen, Lee, Feng 1994.

use super::bandwidth::sliding_weights;
use crate::control::{Feedback, Gains, Sample, keeps_up};
use crate::error::{Result, positive};
use crate::math::{Vector, fnv_of, sqrt};
use crate::riccati::{JointSolution, joint, joint_lqr};

/// Feedback with a robust term.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HInfinity<const N: usize> {
    gains: Gains<N>,
    p: [JointSolution; N],
    r: f64,
}

impl<const N: usize> HInfinity<N> {
    /// The feedback with `q` on the diagonal of Q, for the attenuation level `gamma` and the weight
    /// `r` of the control.
    ///
    /// # Errors
    /// `q`, `gamma`, `r`: not finite or not > 0; `NoStabilizingSolution` where r > 2γ² and Q is too
    /// large.
    pub fn new(gains: Gains<N>, q: f64, gamma: f64, r: f64) -> Result<Self> {
        positive("q", &[q])?;
        Self::with(gains, [[q; N]; 2], gamma, r)
    }

    fn with(
        gains: Gains<N>,
        [q_position, q_velocity]: [[f64; N]; 2],
        gamma: f64,
        r: f64,
    ) -> Result<Self> {
        positive("gamma", &[gamma])?;
        positive("r", &[r])?;
        let push = 2.0 / r - 1.0 / (gamma * gamma);
        let mut p = [JointSolution::default(); N];
        for (n, p) in p.iter_mut().enumerate() {
            let (kp, kv, q1, q2) = (gains.kp[n], gains.kv[n], q_position[n], q_velocity[n]);
            *p = if push > 0.0 {
                joint_lqr(kp, kv, q1, q2, 1.0 / push)?
            } else if push == 0.0 {
                joint(kp, kv, q1, q2, f64::INFINITY)?
            } else {
                joint(kp, kv, q1, q2, sqrt(-1.0 / push))?
            };
        }
        Ok(Self { gains, p, r })
    }

    /// Gains from a bandwidth p [rad/s]: K_p = p², K_v = 2p, r = 1, γ² = r/2 and
    /// Q = diag(2p⁴, 2p²), so that the robust term is p (ė + pe), and what is left of an
    /// acceleration ρ that the model lacks is `2 ∫ p⁴e² + p²ė² ≤ ½ ∫ ρ²` for one joint.
    ///
    /// # Errors
    /// `bandwidth`: not finite or not > 0.
    pub fn with_bandwidth(bandwidth: [f64; N]) -> Result<Self> {
        let (gains, weights) = (Gains::with_bandwidth(bandwidth)?, sliding_weights(&bandwidth));
        let weights = weights.map(|q| core::array::from_fn(|n| q[n] * bandwidth[n]));
        Self::with(gains, weights, sqrt(0.5), 1.0)
    }

    /// Refuses gains that are too fast for a period \[s\] and a delay in samples:
    /// (K_v + p22/r) (½ + d) h ≤ 0.35.
    ///
    /// # Errors
    /// `kv`.
    pub fn suits(&self, period: f64, delay: f64) -> Result<()> {
        let rates: [f64; N] = core::array::from_fn(|n| self.gains.kv[n] + self.p[n].p22 / self.r);
        keeps_up("kv", &rates, period, delay)
    }

    /// P of each joint.
    pub fn p(&self) -> &[JointSolution; N] {
        &self.p
    }
}

impl<const N: usize> Feedback<N> for HInfinity<N> {
    fn acceleration(&self, seen: &Sample<N>) -> Vector<N> {
        let s = Vector::from_fn(|n, _| self.p[n].p12 * seen.e[n] + self.p[n].p22 * seen.de[n]);
        self.gains.acceleration(seen) - s / self.r
    }

    fn tuning(&self) -> u64 {
        let entries = self.p.iter().flat_map(|p| [p.p12, p.p22]);
        fnv_of(fnv_of(self.gains.tuning(), entries), [self.r])
    }
}

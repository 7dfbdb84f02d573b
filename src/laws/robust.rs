//! Robust computed torque: `v = q̈_d − K_v ė − K_p e − ρ σ/max(‖σ‖, ε)`, `σ = BᵀPx` of all joints
//! together, P of the Lyapunov equation `AᵀP + PA + Q = 0`.
//!
//! With `ρ ≥ (a‖v‖ + d̄)/(1 − a)` the error ends in a ball whose radius goes with √(ρε/2).
//! Source: Corless and Leitmann 1981; Spong 1992.

use super::bandwidth::sliding_weights;
use super::sliding_mode::Mismatch;
use crate::control::{Feedback, Gains, Sample, keeps_up};
use crate::error::{Result, positive, within};
use crate::math::{Vector, fnv_of, sqrt};
use crate::riccati::{JointSolution, joint};

/// Feedback with a term that pushes against σ with the size `bound`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Robust<const N: usize> {
    gains: Gains<N>,
    p: [JointSolution; N],
    bound: f64,
    layer: f64,
}

impl<const N: usize> Robust<N> {
    /// The feedback with `q` on the diagonal of Q; `bound` ρ [rad/s²], `layer` ε, in the unit of σ.
    /// A finite `gamma` takes P of (19) instead of Lyapunov's.
    ///
    /// # Errors
    /// `q`, `bound`, `layer`: not finite or not > 0; what [`joint`] names.
    pub fn new(gains: Gains<N>, q: f64, gamma: f64, bound: f64, layer: f64) -> Result<Self> {
        positive("q", &[q])?;
        positive("bound", &[bound])?;
        positive("layer", &[layer])?;
        Self::with(gains, [[q; N]; 2], gamma, bound, layer)
    }

    fn with(
        gains: Gains<N>,
        [q_position, q_velocity]: [[f64; N]; 2],
        gamma: f64,
        bound: f64,
        layer: f64,
    ) -> Result<Self> {
        let mut p = [JointSolution::default(); N];
        for (n, p) in p.iter_mut().enumerate() {
            *p = joint(gains.kp[n], gains.kv[n], q_position[n], q_velocity[n], gamma)?;
        }
        Ok(Self { gains, p, bound, layer })
    }

    /// Gains from a bandwidth p [rad/s]: K_p = p², K_v = 2p, Q with which σ is ė + pe; ρ is what
    /// the mismatch asks for and a tenth more, and ε = ρ/p of the slowest joint. Inside its layer
    /// the law feeds back ė with up to 3p.
    ///
    /// # Errors
    /// `bandwidth`, `bound`: not finite or not > 0, as without a mismatch; what
    /// [`Mismatch::needed`] names.
    pub fn with_bandwidth(bandwidth: [f64; N], mismatch: &Mismatch) -> Result<Self> {
        let (gains, bound) = (Gains::with_bandwidth(bandwidth)?, mismatch.covered()?);
        positive("bound", &[bound])?;
        let slowest = bandwidth.iter().fold(f64::INFINITY, |least, p| least.min(*p));
        Self::with(gains, sliding_weights(&bandwidth), f64::INFINITY, bound, bound / slowest)
    }

    /// Refuses gains that are too fast for a period \[s\] and a delay in samples:
    /// (K_v + ρ p22/ε) (½ + d) h ≤ 0.35.
    ///
    /// # Errors
    /// `layer`.
    pub fn suits(&self, period: f64, delay: f64) -> Result<()> {
        let steep = self.bound / self.layer;
        let rates: [f64; N] = core::array::from_fn(|n| self.gains.kv[n] + steep * self.p[n].p22);
        keeps_up("layer", &rates, period, delay)
    }

    /// Refuses a bound that does not reach over this mismatch.
    ///
    /// # Errors
    /// `bound`, or what [`Mismatch::needed`] names.
    pub fn covers(&self, mismatch: &Mismatch) -> Result<()> {
        let needed = mismatch.needed()?;
        let wanted = "at least what the mismatch asks for: (a v + d)/(1 - a)";
        within("bound", &[self.bound], |bound| bound >= needed, wanted)
    }
}

impl<const N: usize> Feedback<N> for Robust<N> {
    fn acceleration(&self, seen: &Sample<N>) -> Vector<N> {
        let sigma: Vector<N> =
            Vector::from_fn(|n, _| self.p[n].p12 * seen.e[n] + self.p[n].p22 * seen.de[n]);
        let size = sqrt(sigma.norm_squared()).max(self.layer);
        self.gains.acceleration(seen) - sigma * (self.bound / size)
    }

    fn tuning(&self) -> u64 {
        let entries = self.p.iter().flat_map(|p| [p.p12, p.p22]);
        fnv_of(fnv_of(self.gains.tuning(), entries), [self.bound, self.layer])
    }
}

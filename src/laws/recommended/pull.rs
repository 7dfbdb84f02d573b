//! How an error is brought back: `v = −2p (ė + w(e))`, with w = ½pe near the path, so that both
//! poles are at −p, and farther away no faster than the arm can brake:
//! `w = ±√(2b (|e| − ½e₁))` beyond e₁ = 4b/p².
//!
//! A PD that asks for more than the torque limit gives brakes too late, and swings about the path.

use crate::error::{Result, positive};
use crate::math::{FNV_START, Vector, fnv_of, sqrt};

/// How errors of `N` joints are brought back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pull<const N: usize> {
    /// p [rad/s].
    pub bandwidth: [f64; N],
    /// b, with which a joint brakes on its way back from far away [rad/s²].
    pub braking: [f64; N],
}

impl<const N: usize> Pull<N> {
    pub(super) fn validate(&self) -> Result<()> {
        positive("bandwidth", &self.bandwidth)?;
        positive("braking", &self.braking)
    }

    pub(super) fn fingerprint(&self) -> u64 {
        fnv_of(fnv_of(FNV_START, self.bandwidth), self.braking)
    }

    /// −2p (ė + w(e)) [rad/s²].
    pub(super) fn acceleration(&self, e: &Vector<N>, de: &Vector<N>) -> Vector<N> {
        Vector::from_fn(|n, _| -2.0 * self.bandwidth[n] * (de[n] + self.way_back(n, e[n])))
    }

    /// w(e) of joint `n` [rad/s].
    fn way_back(&self, n: usize, e: f64) -> f64 {
        let (p, b) = (self.bandwidth[n], self.braking[n]);
        let near = 4.0 * b / (p * p);
        if e.abs() <= near {
            return 0.5 * p * e;
        }
        sqrt(2.0 * b * (e.abs() - 0.5 * near)).copysign(e)
    }
}

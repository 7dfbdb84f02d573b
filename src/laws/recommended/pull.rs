//! How an error is brought back: `v = −2p (ė + w(e))`, with w = ½pe near the path, so that both
//! poles are at −p, and farther away no faster than the arm can brake:
//! `w = ±√(2b (|e| − ½e₁))` beyond e₁ = 4b/p².
//!
//! A PD that asks for more than the torque limit gives brakes too late, and swings about the path.

use crate::error::{Result, positive};
use crate::math::{FNV_START, Real, Vector, fnv_of};

/// How errors of `N` joints are brought back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pull<const N: usize, T = f64> {
    /// p [rad/s].
    pub bandwidth: [T; N],
    /// b, with which a joint brakes on its way back from far away [rad/s²].
    pub braking: [T; N],
}

impl<const N: usize> Pull<N> {
    pub(super) fn validate(&self) -> Result<()> {
        positive("bandwidth", &self.bandwidth)?;
        positive("braking", &self.braking)
    }

    pub(super) fn fingerprint(&self) -> u64 {
        fnv_of(fnv_of(FNV_START, self.bandwidth), self.braking)
    }
}

impl<const N: usize, T: Real> Pull<N, T> {
    /// −2p (ė + w(e)) [rad/s²].
    #[inline(always)]
    pub(super) fn acceleration(&self, e: &Vector<N, T>, de: &Vector<N, T>) -> Vector<N, T> {
        let mut back = *e;
        for n in 0..N {
            let way_back = self.way_back(n, e[n]);
            back[n] = way_back.like(-2.0) * self.bandwidth[n] * (de[n] + way_back);
        }
        back
    }

    /// w(e) of joint `n` [rad/s].
    #[inline(always)]
    fn way_back(&self, n: usize, e: T) -> T {
        let (p, b, half) = (self.bandwidth[n], self.braking[n], e.like(0.5));
        let near = e.like(4.0) * b / (p * p);
        let braked = (e.like(2.0) * b * (e.abs() - half * near)).sqrt();
        let far = e.if_less(e.like(0.0), -braked, braked);
        near.if_less(e.abs(), far, half * p * e)
    }
}

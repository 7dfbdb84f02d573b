//! An arm of which only the inertia is known, `M̄ = share · M₀`, and no bias: what time-delay
//! control needs.

use super::sliding_mode::Mismatch;
use crate::arm::Arm;
use crate::control::{Gains, keeps_up};
use crate::error::{Result, positive, within};
use crate::math::{FNV_START, Matrix, Vector, fnv_of};

/// The mass matrix of an arm, or a share of it, without bias.
#[derive(Clone, Copy, Debug)]
pub struct Inertia<A> {
    arm: A,
    share: f64,
}

impl<A> Inertia<A> {
    /// M̄ = `share` · M₀ of this arm.
    ///
    /// # Errors
    /// `share`: not finite or not > 0.
    pub fn new(arm: A, share: f64) -> Result<Self> {
        positive("share", &[share])?;
        Ok(Self { arm, share })
    }

    /// Time-delay control as a loop with three poles at −`bandwidth` p [rad/s] and a period h
    /// \[s\]: with M̄ = share · M₀ the acceleration follows v with the pole share/h = 3p, and
    /// K_v = p, K_p = p²/3 make it (s + p)³. The whole M₀ would be the pole 1/h, for which no
    /// velocity is quiet enough.
    ///
    /// # Errors
    /// `bandwidth`, `period`: not finite or not > 0. `bandwidth`: too fast for the period and the
    /// `delay` in samples, 3p (½ + d) h ≤ 0.35.
    pub fn with_bandwidth<const N: usize>(
        arm: A,
        bandwidth: f64,
        period: f64,
        delay: f64,
    ) -> Result<(Gains<N>, Self)> {
        positive("bandwidth", &[bandwidth])?;
        positive("period", &[period])?;
        keeps_up("bandwidth", &[3.0 * bandwidth], period, delay)?;
        let gains = Gains::new([bandwidth * bandwidth / 3.0; N], [bandwidth; N])?;
        Ok((gains, Self::new(arm, 3.0 * bandwidth * period)?))
    }

    /// Refuses a share with which time-delay control is not stable for this mismatch of the arm's
    /// M₀: ‖I − M⁻¹M̄‖ ≤ |1 − share| + share · a < 1.
    ///
    /// # Errors
    /// `share`; what [`Mismatch::needed`] names.
    pub fn covers(&self, mismatch: &Mismatch) -> Result<()> {
        mismatch.needed()?;
        let wanted = "a share with |1 - share| + share · inertia < 1";
        let stable = |share: f64| (1.0 - share).abs() + share * mismatch.inertia < 1.0;
        within("share", &[self.share], stable, wanted)
    }
}

impl<const N: usize, A: Arm<N>> Arm<N> for Inertia<A> {
    fn mass_matrix(&self, q: &Vector<N>) -> Matrix<N> {
        self.arm.mass_matrix(q) * self.share
    }

    fn rigid_bias(&self, _: &Vector<N>, _: &Vector<N>) -> Vector<N> {
        Vector::zeros()
    }

    #[inline]
    fn wraps(&self) -> [bool; N] {
        self.arm.wraps()
    }

    fn fingerprint(&self) -> u64 {
        fnv_of(FNV_START, [self.share]) ^ self.arm.fingerprint()
    }
}

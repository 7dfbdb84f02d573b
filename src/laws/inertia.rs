//! An arm of which only the inertia is known, `M̄ = share · M₀`, and no bias: what time-delay
//! control needs.

use crate::arm::Arm;
use crate::error::{Result, positive};
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

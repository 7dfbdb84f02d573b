//! Momentum observer: `p = M₀q̇`, `r = l (p̂ − p)`, `p̂' = τ_a + C₀ᵀq̇ − G₀ − f₀ − r`, which the
//! law adds to its torque: `ρ̂ = −M₀⁻¹r`.
//!
//! r is what pushes against the arm, through 1/(1 + s/l): the same pole at every joint, and no
//! acceleration is needed. τ_a is the torque that acted, so it goes on while the torque is limited.
//! Source: De Luca and Mattone 2003.

use crate::arm::{Arm, Factor};
use crate::control::{Applied, Dynamic, Moved, Sample, missed};
use crate::error::{Result, positive, within};
use crate::math::{Vector, dot, fnv_of, product};

/// The observer on the nominal arm; its memory is p̂.
#[derive(Clone, Copy, Debug)]
pub struct MomentumObserver<A> {
    arm: A,
    pole: f64,
}

impl<A> MomentumObserver<A> {
    /// The observer with the pole l [1/s].
    ///
    /// # Errors
    /// `pole`: not finite or not > 0.
    pub fn new(arm: A, pole: f64) -> Result<Self> {
        positive("pole", &[pole])?;
        Ok(Self { arm, pole })
    }

    /// The same: the pole l is the bandwidth [rad/s].
    ///
    /// # Errors
    /// `bandwidth`: not finite or not > 0.
    pub fn with_bandwidth(arm: A, bandwidth: f64) -> Result<Self> {
        Self::new(arm, bandwidth).map_err(|error| error.named("bandwidth"))
    }

    /// Refuses a pole that is too fast for a period \[s\] and a delay in samples: l h (1 + d) < ½.
    ///
    /// # Errors
    /// `pole`.
    pub fn suits(&self, period: f64, delay: f64) -> Result<()> {
        let wanted = "a slower pole or a shorter period: pole · period · (1 + delay) < 1/2";
        within("pole", &[self.pole], |l| l * period * (1.0 + delay) < 0.5, wanted)
    }

    /// r [N·m].
    fn residual<const N: usize>(&self, z: &Vector<N>, seen: &Sample<N>) -> Vector<N>
    where
        A: Arm<N>,
    {
        missed(z, &product(&self.arm.mass_matrix(&seen.q), &seen.dq), self.pole)
    }
}

impl<const N: usize, A: Arm<N>> Dynamic<N, N> for MomentumObserver<A> {
    /// r = 0.
    fn start(&self, seen: &Sample<N>) -> Vector<N> {
        product(&self.arm.mass_matrix(&seen.q), &seen.dq)
    }

    fn estimate(&self, z: &Vector<N>, seen: &Sample<N>) -> Vector<N> {
        let mass = self.arm.mass_matrix(&seen.q);
        -Factor::of(&mass).solve(&missed(z, &product(&mass, &seen.dq), self.pole))
    }

    fn rate(&self, z: &Vector<N>, seen: &Sample<N>, applied: &Applied<N>) -> Vector<N> {
        let Sample { q, dq, .. } = seen;
        let coriolis = self.arm.coriolis(q, dq);
        let carried = Vector::from_fn(|n, _| dot(&coriolis.column(n).into(), dq));
        let held = self.arm.gravity(q) + self.arm.friction(dq);
        applied.tau + carried - held - self.residual(z, seen)
    }

    fn moved(&self) -> Option<Moved<'_, N>> {
        Some(Moved::by_momentum(self.arm.side()?, self.pole))
    }

    fn tuning(&self) -> u64 {
        fnv_of(self.arm.fingerprint(), [self.pole])
    }
}

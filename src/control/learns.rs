//! What compensates, as one of several that stand side by side.

use super::Inputs;
#[cfg(feature = "std")]
use super::OwnSide;
use crate::arm::Side;
use crate::fuzzy::Spaced;
use crate::math::{Real, Vector};

/// What of a compensator and its state is put beside others, for many runs at a time.
#[derive(Clone, Copy, Debug)]
pub struct Learns<'a, const N: usize>(pub(super) Kind<'a, N>);

impl<const N: usize> Learns<'_, N> {
    /// Nothing: ρ̂ = 0.
    pub const NOTHING: Self = Self(Kind::Nothing);
}

#[cfg(feature = "std")]
impl<'a, const N: usize> Learns<'a, N> {
    /// What goes with a law that is not computed torque.
    pub(crate) fn own(side: OwnSide<'a, N>) -> Self {
        Self(Kind::Own(side))
    }

    /// That, if it is such.
    pub(crate) fn as_own(&self) -> Option<OwnSide<'a, N>> {
        if let Kind::Own(side) = self.0 { Some(side) } else { None }
    }
}

/// What it is.
#[derive(Clone, Copy, Debug)]
pub(super) enum Kind<'a, const N: usize> {
    /// ρ̂ = 0.
    Nothing,
    /// A grid a joint over two inputs, whose weights nothing pulls but a leak.
    PerJoint(PerJointSide<'a, N>),
    /// A memory of a number a joint.
    Memory(MemorySide<'a, N>),
    /// What goes with a law that is not computed torque.
    #[cfg(feature = "std")]
    Own(OwnSide<'a, N>),
}

/// What moves a memory of a number a joint, and makes ρ̂ of it; see [`Dynamic`](super::Dynamic).
#[derive(Clone, Copy, Debug)]
#[cfg_attr(not(feature = "std"), expect(dead_code, reason = "many runs need threads"))]
pub struct Moved<'a, const N: usize> {
    /// K_I, Y, or the pole.
    pub(super) gain: [f64; N],
    pub(super) by: Mover<'a, N>,
}

/// What moves it.
#[derive(Clone, Copy, Debug)]
pub(super) enum Mover<'a, const N: usize> {
    Error,
    /// An observer of the acceleration, or of the momentum, and the arm that it believes in.
    Acceleration(Side<'a, N>),
    Momentum(Side<'a, N>),
}

impl<'a, const N: usize> Moved<'a, N> {
    /// ρ̂ = K_I z by ż = e, or 0 where the torque is limited.
    pub(crate) fn by_error(ki: [f64; N]) -> Self {
        Self { gain: ki, by: Mover::Error }
    }

    /// ρ̂ = −M₀⁻¹ d̂ with d̂ = z − Y q̇ by ż = Y M₀⁻¹ (τ_a − H₀ − d̂), which is zero at first.
    pub(crate) fn by_acceleration(arm: Side<'a, N>, gain: [f64; N]) -> Self {
        Self { gain, by: Mover::Acceleration(arm) }
    }

    /// ρ̂ = −M₀⁻¹ r with r = l (z − M₀ q̇) by ż = τ_a + C₀ᵀ q̇ − G₀ − f₀ − r, which is zero at
    /// first.
    pub(crate) fn by_momentum(arm: Side<'a, N>, pole: f64) -> Self {
        Self { gain: [pole; N], by: Mover::Momentum(arm) }
    }
}

/// d̂ = z − Y q̇ [N·m].
#[inline(always)]
pub(crate) fn pushed<const N: usize, T: Real>(
    z: &Vector<N, T>,
    gain: &[T; N],
    dq: &Vector<N, T>,
) -> Vector<N, T> {
    let mut pushed = *z;
    for n in 0..N {
        pushed[n] -= gain[n] * dq[n];
    }
    pushed
}

/// r = l (z − p) [N·m].
#[inline(always)]
pub(crate) fn missed<const N: usize, T: Real>(
    z: &Vector<N, T>,
    momentum: &Vector<N, T>,
    pole: T,
) -> Vector<N, T> {
    let mut missed = *z;
    for n in 0..N {
        missed[n] -= momentum[n];
        missed[n] = missed[n] * pole;
    }
    missed
}

/// A memory, and what moves it.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(not(feature = "std"), expect(dead_code, reason = "many runs need threads"))]
pub(super) struct MemorySide<'a, const N: usize> {
    pub z: Option<Vector<N>>,
    pub moved: Moved<'a, N>,
}

/// A grid a joint, and its weights.
#[derive(Clone, Copy, Debug)]
pub(super) struct PerJointSide<'a, const N: usize> {
    pub inputs: Inputs,
    /// The sets of both inputs of each joint.
    pub sets: [[Spaced; 2]; N],
    pub normalized: bool,
    /// The last row and column of P, and the gain.
    pub p12: [f64; N],
    pub p22: [f64; N],
    pub gain: [f64; N],
    pub leak_rate: f64,
    pub dead_zone: f64,
    pub normalization: f64,
    /// The rows of weights, of this length, rule after rule.
    pub weights: &'a [f64],
    pub row: usize,
    #[cfg(feature = "std")]
    pub advances: u64,
}

impl<const N: usize> PerJointSide<'_, N> {
    /// Whether they move by the law (18) alone.
    pub fn is_plain(&self) -> bool {
        [self.leak_rate, self.dead_zone, self.normalization] == [0.0; 3]
    }
}

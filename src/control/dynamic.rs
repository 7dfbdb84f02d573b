//! A memory of a few numbers as a compensator: `ρ̂ = estimate(z, seen)` first, and once the torque
//! that acted is known, `ż = rate(z, seen, applied)`.
//!
//! PID, sliding modes, observers, adaptation of a few parameters: each is an estimate and a rate.
//! This file has the one adapter from them to the stages of a Runge-Kutta step,
//! `z = z₀ + h Σ aⱼ żⱼ`, and to a sampled controller's Euler step.

use super::bytes::{Numbers, put_all};
use super::learns::{Kind, MemorySide};
use super::{Applied, Audit, Compensator, Learns, MAX_STAGES, Moved, Sample, Saves, Stage};
use crate::error::{Result, finite};
use crate::math::Vector;

/// A way to produce ρ̂ for `N` joints from a memory z of `K` numbers. Every such type is a
/// [`Compensator<N, DynamicState<K>>`](Compensator).
///
/// The integrator's error control watches the motion, not z. If a pole of z is far faster than the
/// arm, choose steps to match. In a sampled controller z takes one Euler step per period, which is
/// stable for poles below 2/period.
pub trait Dynamic<const N: usize, const K: usize> {
    /// z at the first sample; zero by default.
    fn start(&self, _seen: &Sample<N>) -> Vector<K> {
        Vector::zeros()
    }

    /// ρ̂ [rad/s²].
    fn estimate(&self, z: &Vector<K>, seen: &Sample<N>) -> Vector<N>;

    /// ż [1/s]. An integrator of the error holds where the torque was [limited](Applied::limited).
    /// An observer of the arm goes on with the torque that acted.
    fn rate(&self, z: &Vector<K>, seen: &Sample<N>, applied: &Applied<N>) -> Vector<K>;

    /// What moves z, where that can be put beside others, for many runs at a time: z is then a
    /// number a joint. `None` by default, and for laws of your own: it is asked by itself.
    fn moved(&self) -> Option<Moved<'_, N>> {
        None
    }

    /// A number for its parameters: with others, z says something else. The default is 0.
    fn tuning(&self) -> u64 {
        0
    }
}

/// The memory of a [`Dynamic`], and what the stages of the current step recorded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DynamicState<const K: usize> {
    /// z after the last step; `None` before the first.
    z: Option<Vector<K>>,
    /// z at the start of the current step, and at the stage that was estimated last.
    start: Vector<K>,
    at: Vector<K>,
    rates: [Vector<K>; MAX_STAGES],
}

impl<const K: usize> DynamicState<K> {
    /// The memory before the first sample.
    pub fn new() -> Self {
        let zeros = Vector::zeros();
        Self { z: None, start: zeros, at: zeros, rates: [zeros; MAX_STAGES] }
    }

    /// z; `None` before the first step.
    pub fn z(&self) -> Option<&Vector<K>> {
        self.z.as_ref()
    }

    /// z₀ + h Σ aⱼ żⱼ.
    fn moved(&self, stage: &Stage<'_>) -> Vector<K> {
        let mut sum = Vector::zeros();
        for (a, rate) in stage.coefficients.iter().zip(&self.rates) {
            if *a != 0.0 {
                sum += rate * *a;
            }
        }
        self.start + sum * stage.step
    }
}

impl<const K: usize> Default for DynamicState<K> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const N: usize, const K: usize, D: Dynamic<N, K>> Compensator<N, DynamicState<K>> for D {
    #[inline]
    fn estimate(
        &self,
        state: &mut DynamicState<K>,
        stage: &Stage<'_>,
        seen: &Sample<N>,
    ) -> Vector<N> {
        if stage.index == 0 {
            state.start = state.z.unwrap_or_else(|| self.start(seen));
        }
        state.at = state.moved(stage);
        Dynamic::estimate(self, &state.at, seen)
    }

    #[inline]
    fn acted(
        &self,
        state: &mut DynamicState<K>,
        index: usize,
        seen: &Sample<N>,
        applied: &Applied<N>,
    ) {
        state.rates[index] = self.rate(&state.at, seen, applied);
    }

    fn advance(&self, state: &mut DynamicState<K>, end: &Stage<'_>) -> Result<()> {
        let z = state.moved(end);
        finite("z", z.as_slice())?;
        state.z = Some(z);
        Ok(())
    }

    fn carry(&self, state: &mut DynamicState<K>, last: usize) -> bool {
        state.rates[0] = state.rates[last];
        state.start = state.z.unwrap_or(state.start);
        true
    }

    fn learns<'a>(&'a self, state: &'a DynamicState<K>) -> Option<Learns<'a, N>> {
        let moved = self.moved().filter(|_| const { K == N })?;
        let z = state.z.map(|z| Vector::from_fn(|n, _| z[n]));
        Some(Learns(Kind::Memory(MemorySide { z, moved })))
    }

    fn reset(&self, state: &mut DynamicState<K>) {
        *state = DynamicState::new();
    }

    fn audit(&self, _: &DynamicState<K>, _: usize, _: &Sample<N>) -> Option<Audit<N>> {
        None
    }
}

/// z is there.
const BEGUN: u64 = 128;

impl<const N: usize, const K: usize, D: Dynamic<N, K>> Saves<N, DynamicState<K>> for D {
    fn known_flags(&self) -> u64 {
        BEGUN
    }

    fn entries(&self) -> &'static str {
        "numbers"
    }

    fn size(&self) -> usize {
        K
    }

    fn fingerprints(&self) -> [u64; 2] {
        [self.tuning(), 0]
    }

    fn flags(&self, state: &DynamicState<K>) -> u64 {
        if state.z.is_some() { BEGUN } else { 0 }
    }

    fn write(&self, state: &DynamicState<K>, put: &mut dyn FnMut(&[u8])) {
        put_all(put, state.z.unwrap_or_else(Vector::zeros).as_slice());
    }

    fn check(&self, _: u64, part: &[u8]) -> Result<()> {
        let mut rest = Numbers(part);
        finite("z", rest.vector::<K>()?.as_slice())?;
        rest.end()
    }

    fn take(&self, state: &mut DynamicState<K>, flags: u64, _: u64, part: &[u8]) {
        *state = DynamicState::new();
        if let (true, Ok(z)) = (flags & BEGUN != 0, Numbers(part).vector()) {
            state.z = Some(z);
        }
    }
}

//! Coloured noise as a function of time: white noise through a first-order low-pass, stationary,
//! Gaussian, of standard deviation σ and autocorrelation `σ² e^(−ω|τ|)`, ω = 2π f.
//!
//! It has no state. At times `k L`, L = 32/ω, its values are independent (e⁻³² is nothing), and in
//! between it is halved ten times by its own law, which is Markov: with ρ = e^(−ω d) over half an
//! interval d,
//!
//! ```text
//! x(m) = ρ/(1 + ρ²) (x(l) + x(r)) + σ √((1 − ρ²)/(1 + ρ²)) g
//! ```
//!
//! and g, N(0, 1), of a generator that is seeded by the seed, the joint, and the place of m. Over
//! the last interval, 1/32 of the filter's time constant, it is a straight line.
//!
//! Sources: D. T. Gillespie, "Exact numerical simulation of the Ornstein-Uhlenbeck process", Phys.
//! Rev. E 54 (1996); Lévy's construction; G. E. P. Box, M. E. Muller (1958) for g.

use core::f64::consts::TAU;

use rand_xoshiro::SplitMix64;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

use super::Disturbance;
use crate::error::{Result, non_negative, positive};
use crate::math::{Vector, decay, ln, sin_cos, sqrt};

/// How often an interval is halved.
const LEVELS: usize = 10;

/// ω L.
const SPAN: f64 = 32.0;

/// Noise in every joint, independent of each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise<const N: usize> {
    deviation: Vector<N>,
    /// 1/L [1/s].
    per_span: f64,
    seed: u64,
    /// ρ/(1 + ρ²) and √((1 − ρ²)/(1 + ρ²)) of every level.
    levels: [[f64; 2]; LEVELS],
}

impl<const N: usize> Noise<N> {
    /// Noise of this standard deviation [N·m], filtered with this cut-off f \[Hz\]. The same seed
    /// gives the same bits on every machine.
    ///
    /// # Errors
    /// `deviation`: not finite or not ≥ 0; `cutoff`: not finite or not > 0.
    pub fn new(deviation: [f64; N], cutoff: f64, seed: u64) -> Result<Self> {
        non_negative("deviation", &deviation)?;
        positive("cutoff", &[cutoff])?;
        let mut half = SPAN;
        let levels = [(); LEVELS].map(|()| {
            half *= 0.5;
            let rho = decay(half);
            let sum = 1.0 + rho * rho;
            [rho / sum, sqrt((1.0 - rho * rho) / sum)]
        });
        let seed = SplitMix64::seed_from_u64(seed).next_u64();
        Ok(Self { deviation: deviation.into(), per_span: cutoff * (TAU / SPAN), seed, levels })
    }

    /// The noise at time `t` \[s\].
    pub fn value(&self, t: f64) -> Vector<N> {
        let place = t * self.per_span;
        let mut value = Vector::<N>::zeros();
        for pair in 0..N.div_ceil(2) {
            let [even, odd] = self.pair(pair as u64, place);
            value[2 * pair] = even;
            if 2 * pair + 1 < N {
                value[2 * pair + 1] = odd;
            }
        }
        value.component_mul(&self.deviation)
    }

    /// Two joints, of standard deviation 1.
    fn pair(&self, pair: u64, place: f64) -> [f64; 2] {
        let whole = libm::floor(place);
        let mut rest = place - whole;
        // Beyond 2⁶³ intervals no time is told from the next.
        let mut index = whole as i64;
        let node = |level: u64, index: i64| self.gaussians(64 * pair + level, index);
        let [mut left, mut right] = [node(0, index), node(0, index.wrapping_add(1))];
        for (level, [toward, spread]) in (1..).zip(self.levels) {
            let g = node(level, index);
            let middle = [0, 1].map(|n| toward * (left[n] + right[n]) + spread * g[n]);
            (rest, index) = (2.0 * rest, index.wrapping_mul(2));
            if rest < 1.0 {
                right = middle;
            } else {
                (left, rest, index) = (middle, rest - 1.0, index.wrapping_add(1));
            }
        }
        [0, 1].map(|n| left[n] + (right[n] - left[n]) * rest)
    }

    /// Two numbers of N(0, 1), the same for the same place.
    fn gaussians(&self, which: u64, index: i64) -> [f64; 2] {
        let key = SplitMix64::seed_from_u64(self.seed ^ which).next_u64();
        let mut source = SplitMix64::seed_from_u64(key ^ index as u64);
        let mut source = SplitMix64::seed_from_u64(source.next_u64());
        let mut uniform = || (source.next_u64() >> 11) as f64 * (1.0 / (1u64 << 53) as f64);
        // 1 − u is in (0, 1].
        let (radius, angle) = (sqrt(-2.0 * ln(1.0 - uniform())), TAU * uniform());
        let (sin, cos) = sin_cos(angle);
        [radius * cos, radius * sin]
    }
}

impl<const N: usize> Disturbance<N> for Noise<N> {
    fn torque(&self, _: &Vector<N>, _: &Vector<N>, t: f64) -> Vector<N> {
        self.value(t)
    }

    #[inline]
    fn at_time(&self, t: f64) -> Option<Vector<N>> {
        Some(self.value(t))
    }
}

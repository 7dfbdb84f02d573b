//! Random numbers with the same bits on every machine: xoshiro256++, and Box and Muller's normal
//! ones.

use core::f64::consts::TAU;

use rand_xoshiro::rand_core::{Rng as _, SeedableRng as _};
use rand_xoshiro::{SplitMix64, Xoshiro256PlusPlus};

use crate::math::{ln, sin_cos, sqrt};

/// A source of random numbers of its own: a stream of the seed.
#[derive(Clone, Debug)]
pub struct Random(Xoshiro256PlusPlus);

impl Random {
    /// The numbers of a seed in a stream: others in every stream.
    pub fn new(seed: u64, stream: u64) -> Self {
        let of_seed = SplitMix64::seed_from_u64(seed).next_u64();
        Self(Xoshiro256PlusPlus::seed_from_u64(of_seed.wrapping_add(stream)))
    }

    /// Evenly in [0, 1).
    pub fn uniform(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 * (1.0 / (1_u64 << 53) as f64)
    }

    /// Normal, of variance 1.
    pub fn normal(&mut self) -> f64 {
        let size = sqrt(-2.0 * ln(1.0 - self.uniform()));
        size * sin_cos(TAU * self.uniform()).1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normal_numbers_have_mean_0_variance_1_and_kurtosis_3() {
        let mut random = Random::new(7, 0);
        let numbers: Vec<f64> = (0..200_000).map(|_| random.normal()).collect();
        let moment = |k| numbers.iter().map(|x: &f64| x.powi(k)).sum::<f64>() / 2e5;
        // Three standard deviations of the moments' own scatter.
        assert!(moment(1).abs() < 0.007 && (moment(2) - 1.0).abs() < 0.01);
        assert!(moment(3).abs() < 0.03 && (moment(4) - 3.0).abs() < 0.07);
    }

    #[test]
    fn streams_and_seeds_are_not_alike() {
        let first = |seed, stream| Random::new(seed, stream).uniform();
        let mut all: Vec<f64> = (0..100).flat_map(|i| [first(i, 0), first(0, i + 1)]).collect();
        all.sort_by(f64::total_cmp);
        assert!(all.windows(2).all(|pair| pair[1] > pair[0]));
        assert_eq!(first(3, 1), first(3, 1));
        let mean = all.iter().sum::<f64>() / 200.0;
        assert!((mean - 0.5).abs() < 0.07);
    }
}

//! The fastest way from 0 to 1, from rest to rest, under limits on velocity, acceleration and jerk:
//! seven phases of jerk J, 0, −J, 0, −J, 0, J, that last
//!
//! ```text
//! tⱼ tₐ tⱼ tᵥ tⱼ tₐ tⱼ,    1 = J tⱼ (tⱼ + tₐ) (2tⱼ + tₐ + tᵥ)
//! ```
//!
//! The durations are those of Ruckig (L. Berscheid, T. Kröger, "Jerk-limited real-time trajectory
//! generation with arbitrary target states", RSS 2021). Its roots are of the platform's functions,
//! and differ in their last bits from one platform to another. So the durations are rounded to 36
//! bits, J follows from them by the equation above, and where a limit would be passed, which it can
//! be by 2⁻³⁶ of itself, time is stretched by as much. What differs before the rounding is then the
//! same, unless a duration lies within a few of its last bits of the middle between two roundings,
//! which happens to one in about 10⁵.

use rsruckig::prelude::{IgnoreErrorHandler, InputParameter, Ruckig, RuckigResult, Trajectory};

use crate::math::{cbrt, sqrt};

/// Significant bits of a number of which a duration keeps 36.
const DROPPED: u64 = 17;

/// Limits of a motion from 0 to 1: velocity [1/s], acceleration [1/s²], jerk [1/s³].
#[derive(Clone, Copy, Debug)]
pub(super) struct Most {
    pub velocity: f64,
    pub acceleration: f64,
    pub jerk: f64,
}

/// The motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Profile {
    /// tⱼ, tₐ \[s\].
    ramp: f64,
    steady: f64,
    /// How long all of it takes \[s\].
    pub duration: f64,
    /// J [1/s³].
    jerk: f64,
}

impl Profile {
    /// Being there already.
    pub const NONE: Self = Self { ramp: 0.0, steady: 0.0, duration: 0.0, jerk: 0.0 };

    /// The fastest motion; `None` if it cannot be computed, as its phases differ too much in
    /// length.
    pub fn fastest(most: &Most) -> Option<Self> {
        let slowest =
            (1.0 / most.velocity).max(sqrt(1.0 / most.acceleration)).max(cbrt(1.0 / most.jerk));
        let durations =
            [1.0, power_of_two(slowest)].into_iter().find_map(|unit| phases(most, unit));
        let made = Self::of(durations?);
        let passed = made.passed(most);
        let made = if passed > 1.0 { Self::of(durations?.map(|t| t * passed)) } else { made };
        (made.duration.is_finite() && made.jerk > 0.0 && made.jerk.is_finite()).then_some(made)
    }

    /// The motion with phases of these lengths, tⱼ, tₐ and tᵥ \[s\].
    fn of([ramp, steady, cruise]: [f64; 3]) -> Self {
        // 1 = J tⱼ (tⱼ + tₐ) (2tⱼ + tₐ + tᵥ)
        let jerk = 1.0 / (ramp * (ramp + steady) * (2.0 * ramp + steady + cruise));
        Self { ramp, steady, duration: 4.0 * ramp + 2.0 * steady + cruise, jerk }
    }

    /// How many times a limit is passed at the most.
    fn passed(&self, most: &Most) -> f64 {
        let acceleration = self.jerk * self.ramp;
        let velocity = acceleration * (self.ramp + self.steady);
        let [j, a, v] =
            [self.jerk / most.jerk, acceleration / most.acceleration, velocity / most.velocity];
        j.max(a).max(v)
    }

    /// Position in [0, 1], velocity [1/s] and acceleration [1/s²] `x` \[s\] after the start.
    #[inline]
    pub fn at(&self, x: f64) -> [f64; 3] {
        let left = self.duration - x;
        if x <= 0.0 {
            [0.0; 3]
        } else if left <= 0.0 {
            [1.0, 0.0, 0.0]
        } else if left < x {
            // The second half is the first one, backwards.
            let [s, ds, dds] = self.rising(left);
            [1.0 - s, ds, -dds]
        } else {
            self.rising(x)
        }
    }

    /// The same in the first half.
    #[inline]
    fn rising(&self, x: f64) -> [f64; 3] {
        let Self { ramp, steady, jerk, .. } = *self;
        let most = jerk * ramp;
        if x <= ramp {
            return [jerk * x * x * x / 6.0, jerk * x * x / 2.0, jerk * x];
        }
        let (s, ds) = (most * ramp * ramp / 6.0, most * ramp / 2.0);
        let y = x - ramp;
        if y <= steady {
            return [s + y * (ds + y * most / 2.0), ds + y * most, most];
        }
        let (s, ds) = (s + steady * (ds + steady * most / 2.0), ds + steady * most);
        let z = y - steady;
        if z <= ramp {
            let dds = most - jerk * z;
            return [
                s + z * (ds + z * (most / 2.0 - jerk * z / 6.0)),
                ds + z * (most + dds) / 2.0,
                dds,
            ];
        }
        let cruise = most * (ramp + steady);
        // x + x = T at the middle, where s = ½: cruise is even about it.
        [0.5 - cruise * (0.5 * self.duration - x), cruise, 0.0]
    }
}

/// tⱼ, tₐ and tᵥ \[s\] by Ruckig, which computes in this unit of time, rounded.
fn phases(most: &Most, unit: f64) -> Option<[f64; 3]> {
    let mut ruckig = Ruckig::<1, IgnoreErrorHandler>::new(None, 1.0);
    let mut input = InputParameter::<1>::new(None);
    input.target_position[0] = 1.0;
    input.max_velocity[0] = most.velocity * unit;
    input.max_acceleration[0] = most.acceleration * unit * unit;
    input.max_jerk[0] = most.jerk * unit * unit * unit;
    let mut found = Trajectory::<1>::new(None);
    let done = ruckig.calculate(&input, &mut found).ok()?;
    if !matches!(done, RuckigResult::Working | RuckigResult::Finished) {
        return None;
    }
    let t = found.get_profiles()[0][0].t;
    // Ruckig makes one phase of two that meet, but for the first, second and fourth.
    let [ramp, steady, cruise] = [t[0], t[1], t[3]].map(|t| t.max(0.0));
    let all = 4.0 * ramp + 2.0 * steady + cruise;
    let as_above = ramp > 0.0 && (all - found.duration).abs() <= 1e-9 * all;
    as_above.then(|| [ramp, steady, cruise].map(|t| rounded(t) * unit))
}

/// x > 0 with 36 significant bits.
fn rounded(x: f64) -> f64 {
    let half = 1 << (DROPPED - 1);
    f64::from_bits((x.to_bits() + half) & !((1 << DROPPED) - 1))
}

/// The power of two at or below x > 0.
fn power_of_two(x: f64) -> f64 {
    f64::from_bits(x.to_bits() & !((1 << 52) - 1))
}

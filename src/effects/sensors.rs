//! What is measured: positions in steps of an encoder, with noise, and a velocity made of them.
//!
//! ```text
//! difference   v ← v + (1 − e^(−2πfh)) ((q − q₋)/h − v)
//! tracking     ẑ₁' = z₂, ẑ₂' = −r²(z₁ − q) − 2r z₂, q straight from sample to sample
//! Kalman       the steady gains α, β of a motion under noise of acceleration
//! ```
//!
//! Sources: Han 2009 for the tracking differentiator, in its linear form; Kalata 1984 for α and β.

use core::f64::consts::TAU;

use super::random::Random;
use crate::error::{Result, accepted, non_negative, within};
use crate::math::{Vector, exp, sqrt};

/// What is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensors<const N: usize> {
    /// Step of each encoder \[rad\]; 0: none.
    pub encoder: [f64; N],
    /// Standard deviation of the noise of each position, before its encoder \[rad\].
    pub noise: [f64; N],
    /// Where the velocity comes from.
    pub velocity: Velocity<N>,
}

/// Where a measured velocity comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Velocity<const N: usize> {
    /// The joint's own, with noise of this standard deviation [rad/s].
    Measured([f64; N]),
    /// The difference of two positions, through a first-order filter of this cut-off \[Hz\],
    /// infinite for none.
    Difference(f64),
    /// A tracking differentiator of this bandwidth r [rad/s].
    Tracking(f64),
    /// A Kalman filter in its steady state, for accelerations of this standard deviation [rad/s²].
    Kalman(f64),
}

impl<const N: usize> Default for Sensors<N> {
    fn default() -> Self {
        Self { encoder: [0.0; N], noise: [0.0; N], velocity: Velocity::Measured([0.0; N]) }
    }
}

/// The streams of random numbers.
const POSITION: u64 = 3;
const VELOCITY: u64 = 4;

impl<const N: usize> Sensors<N> {
    /// Refuses what makes no sense.
    ///
    /// # Errors
    /// `encoder`, `noise`: negative or not finite. `velocity`: a cut-off, a bandwidth or an
    /// acceleration that is not > 0; a filter without anything that it could filter.
    pub fn validate(&self) -> Result<()> {
        non_negative("encoder", &self.encoder)?;
        non_negative("noise", &self.noise)?;
        let finite = |x: f64| x > 0.0 && x.is_finite();
        match &self.velocity {
            Velocity::Measured(noise) => non_negative("velocity_noise", noise),
            Velocity::Difference(cut_off) => {
                accepted("velocity", &[*cut_off], |f| f > 0.0, "a cut-off > 0, infinite for none")
            }
            Velocity::Tracking(r) => within("velocity", &[*r], finite, "a bandwidth > 0"),
            Velocity::Kalman(acceleration) => {
                within("velocity", &[*acceleration], finite, "an acceleration > 0")?;
                let scatter = (0..N).map(|n| self.scatter(n)).fold(f64::INFINITY, f64::min);
                let wanted = "noise or an encoder at every joint: without them there is nothing \
                              to filter";
                within("noise", &[scatter], |x| x > 0.0, wanted)
            }
        }
    }

    /// Standard deviation of a measured position \[rad\].
    fn scatter(&self, joint: usize) -> f64 {
        let (step, noise) = (self.encoder[joint], self.noise[joint]);
        sqrt(step * step / 12.0 + noise * noise)
    }
}

/// Measures, sample after sample.
pub(crate) struct Measuring<const N: usize> {
    sensors: Sensors<N>,
    /// Position as it was filtered or measured last, and velocity; `None` before the first sample.
    last: Option<[Vector<N>; 2]>,
    /// Position as it was measured last.
    measured: Vector<N>,
    position: Random,
    velocity: Random,
}

impl<const N: usize> Measuring<N> {
    /// Before the first sample.
    pub fn new(sensors: Sensors<N>, seed: u64) -> Self {
        let (position, velocity) = (Random::new(seed, POSITION), Random::new(seed, VELOCITY));
        Self { sensors, last: None, measured: Vector::zeros(), position, velocity }
    }

    /// What is measured of a motion, `elapsed` \[s\] after the last sample. Before the second one
    /// a velocity that is made of positions is 0.
    pub fn measure(
        &mut self,
        q: &Vector<N>,
        dq: &Vector<N>,
        elapsed: f64,
    ) -> (Vector<N>, Vector<N>) {
        let Sensors { encoder, noise, velocity } = self.sensors;
        let q = Vector::from_fn(|n, _| {
            let noisy = q[n] + drawn(&mut self.position, noise[n]);
            if encoder[n] > 0.0 { libm::rint(noisy / encoder[n]) * encoder[n] } else { noisy }
        });
        if let Velocity::Measured(noise) = velocity {
            let random = &mut self.velocity;
            return (q, Vector::from_fn(|n, _| dq[n] + drawn(random, noise[n])));
        }
        let [at, v] = match self.last {
            None => [q, Vector::zeros()],
            Some([last, v]) => self.followed(&q, &last, &v, elapsed),
        };
        (self.last, self.measured) = (Some([at, v]), q);
        (q, v)
    }

    /// Position and velocity `h` \[s\] after these, with q measured.
    fn followed(&self, q: &Vector<N>, last: &Vector<N>, v: &Vector<N>, h: f64) -> [Vector<N>; 2] {
        match self.sensors.velocity {
            Velocity::Measured(_) => [*q, *v],
            Velocity::Difference(cut_off) => {
                let share = 1.0 - exp(-TAU * cut_off * h);
                [*q, v + ((q - last) / h - v) * share]
            }
            Velocity::Tracking(r) => {
                // With u the slope of q, y = z₁ − q + 2u/r and w = z₂ − u fade: exactly, as
                // (y + (w + ry)t) e^(−rt).
                let slope = (q - self.measured) / h;
                let lag = slope * (2.0 / r);
                let (apart, fading) = (last - self.measured + lag, exp(-r * h));
                let rate = v - slope + apart * r;
                let along = apart + rate * h;
                [q - lag + along * fading, slope + (rate - along * r) * fading]
            }
            Velocity::Kalman(acceleration) => {
                let foreseen = last + v * h;
                let gains = |n: usize| steady_gains(acceleration, self.sensors.scatter(n), h);
                let gains: [[f64; 2]; N] = core::array::from_fn(gains);
                let apart = q - foreseen;
                let at = Vector::from_fn(|n, _| foreseen[n] + gains[n][0] * apart[n]);
                [at, Vector::from_fn(|n, _| v[n] + gains[n][1] / h * apart[n])]
            }
        }
    }
}

fn drawn(random: &mut Random, scatter: f64) -> f64 {
    if scatter > 0.0 { scatter * random.normal() } else { 0.0 }
}

/// α and β of Kalata's tracking index λ = σ_a h²/σ_q.
fn steady_gains(acceleration: f64, scatter: f64, h: f64) -> [f64; 2] {
    let index = acceleration * h * h / scatter;
    let r = (4.0 + index - sqrt(8.0 * index + index * index)) / 4.0;
    let alpha = 1.0 - r * r;
    [alpha, 2.0 * (2.0 - alpha) - 4.0 * sqrt(1.0 - alpha)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sensors(velocity: Velocity<1>) -> Sensors<1> {
        Sensors { encoder: [1e-4], noise: [0.0], velocity }
    }

    /// The Riccati equation of the filter, iterated: position and velocity, white acceleration.
    #[test]
    fn steady_gains_are_those_of_the_kalman_filter() {
        let (acceleration, scatter, h) = (30.0, 2e-4, 1e-3);
        let mut p = [[1.0, 0.0], [0.0, 1.0]];
        let mut gains = [0.0; 2];
        let noise = acceleration * acceleration;
        for _ in 0..20_000 {
            let q = [h * h * h * h / 4.0 * noise, h * h * h / 2.0 * noise, h * h * noise];
            let p00 = p[0][0] + 2.0 * h * p[0][1] + h * h * p[1][1] + q[0];
            let p01 = p[0][1] + h * p[1][1] + q[1];
            let p11 = p[1][1] + q[2];
            let size = p00 + scatter * scatter;
            gains = [p00 / size, p01 / size];
            p = [[p00 * (1.0 - gains[0]), p01 * (1.0 - gains[0])], [0.0, p11 - gains[1] * p01]];
        }
        let [alpha, beta] = steady_gains(acceleration, scatter, h);
        assert!((alpha / gains[0] - 1.0).abs() < 1e-9 && (beta / h / gains[1] - 1.0).abs() < 1e-9);
    }

    #[test]
    fn every_velocity_settles_on_the_slope_of_a_ramp() {
        let all = [Velocity::Difference(100.0), Velocity::Tracking(300.0), Velocity::Kalman(50.0)];
        for velocity in all {
            // Every sample is a whole number of steps on.
            let exact = Sensors { encoder: [1e-5], ..sensors(velocity) };
            let mut measuring = Measuring::new(exact, 0);
            let mut v = 0.0;
            for k in 0..2000 {
                let q = Vector::<1>::new(0.7 * f64::from(k) * 1e-3);
                v = measuring.measure(&q, &Vector::<1>::new(0.7), 1e-3).1[0];
            }
            assert!((v - 0.7).abs() < 2e-4, "{velocity:?} {v}");
        }
    }

    #[test]
    fn an_encoder_rounds_to_its_steps() {
        let mut measuring = Measuring::new(sensors(Velocity::Measured([0.0])), 0);
        let (q, v) = measuring.measure(&Vector::<1>::new(0.12346), &Vector::<1>::new(3.0), 1e-3);
        assert!((q[0] - 0.1235).abs() < 1e-12 && v[0] == 3.0);
    }
}

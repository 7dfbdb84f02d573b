//! How hard the rules drive away from the path: where the error is wide, and where the loop shakes.
//!
//! Rules of the error fire more there, or less, and what is learnt at one end of a shake is used at
//! the other: `k_I = gain m ξ·ξ'`.

use super::Subject;
use super::learning::diagonals;
use super::subject::of_joint;
use crate::control::{Gains, Sample};
use crate::error::Result;
use crate::math::{Vector, sqrt};
use crate::reference::Setpoint;

/// Errors count up to this \[rad\].
const MOST_ERROR: f64 = 1.0;

/// e and ė at an end of a swing, over its amplitude and its frequency times that: in position, in
/// velocity, and between, where both are wide and of the same sign or not.
const PHASES: [(f64, f64); 4] = [(1.0, 0.0), (0.0, 1.0), (HALF, HALF), (HALF, -HALF)];
const HALF: f64 = core::f64::consts::FRAC_1_SQRT_2;

/// A compensator on a path, with its |ξ|² there.
pub(super) struct Excursions<'a, const N: usize> {
    pub subject: &'a dyn Subject<N>,
    pub gains: &'a Gains<N>,
    pub samples: Vec<Sample<N>>,
    pub on_path: &'a [[f64; N]],
}

impl<const N: usize> Excursions<'_, N> {
    /// The largest |ξ|² of each joint at every sample, and at errors of this size there \[rad\].
    pub fn strongest(&self, size: f64) -> Result<Vec<[f64; N]>> {
        let size = size.min(MOST_ERROR);
        let rate = self.gains.kp.map(sqrt);
        let mut most = self.on_path.to_vec();
        for phase in PHASES {
            for together in [true, false] {
                let ends = self.ends(size, &rate, phase, together);
                let near = diagonals::<N>(&self.subject.products(&ends)?);
                for (k, near) in near.iter().enumerate() {
                    for (most, near) in most[k % self.samples.len()].iter_mut().zip(near) {
                        *most = most.max(*near);
                    }
                }
            }
        }
        Ok(most)
    }

    /// What is left of |ξ|² of each joint where the loop shakes about every sample by this much
    /// \[rad\]: the smallest ξ·ξ' of both ends, in position and in velocity.
    pub fn shaken(&self, amplitude: f64) -> Result<Vec<[f64; N]>> {
        let mut least = self.on_path.to_vec();
        if amplitude == 0.0 {
            return Ok(least);
        }
        let rate = self.frequency();
        for phase in [PHASES[0], PHASES[1]] {
            let products = self.subject.products(&self.ends(amplitude, &rate, phase, false))?;
            for (k, least) in least.iter_mut().enumerate() {
                for (n, least) in least.iter_mut().enumerate() {
                    *least = least.min(of_joint(&products, n)[(k, self.samples.len() + k)]);
                }
            }
        }
        Ok(least)
    }

    /// The frequency that each joint shakes at, √(k_p + k_I p22) [rad/s], at most.
    pub fn frequency(&self) -> [f64; N] {
        let largest = |n: usize| self.on_path.iter().map(|it| it[n]).fold(0.0, f64::max);
        let adaptation = &self.subject.parameters().adaptation;
        let k_i = adaptation.integral_gains(&std::array::from_fn(largest));
        std::array::from_fn(|n| sqrt(self.gains.kp[n] + k_i[n] * self.subject.p()[n].p22))
    }

    /// Both ends of a swing about every sample: those of one end, then those of the other.
    /// Neighbours go all to one side, or to opposite ones.
    fn ends(
        &self,
        size: f64,
        rate: &[f64; N],
        (position, velocity): (f64, f64),
        together: bool,
    ) -> Vec<Sample<N>> {
        let away = |sample: &Sample<N>, end: f64| {
            let side = |n: usize| if together || n.is_multiple_of(2) { end } else { -end };
            let e = Vector::from_fn(|n, _| side(n) * size * position);
            let de = Vector::from_fn(|n, _| side(n) * size * rate[n] * velocity);
            let Setpoint { q, dq, .. } = sample.desired;
            Sample { q: q + e, dq: dq + de, e, de, ..*sample }
        };
        let of = |end: f64| self.samples.iter().map(move |it| away(it, end));
        of(1.0).chain(of(-1.0)).collect()
    }
}

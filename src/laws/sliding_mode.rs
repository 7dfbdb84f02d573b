//! Computed torque with variable structure:
//! `v = q̈_d − Λė − K sat(s/φ) − k₀ s`, `s = ė + Λe`.
//!
//! With `K > (a v̄ + d̄)/(1 − a) + η` s is inside its layer φ after |s(0)|/η, and then |e| ≤ φ/Λ.
//! a bounds ‖I − M⁻¹M₀‖. Source: Slotine 1983; Wijesoma and Richards 1990, the paper's ref. 2.

use super::sliding;
use crate::control::{Feedback, Sample};
use crate::error::{Error, Result, non_negative, positive, within};
use crate::math::{FNV_START, Vector, fnv_of};

/// Feedback with a switching term inside a boundary layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlidingMode<const N: usize> {
    /// Λ [1/s].
    pub lambda: [f64; N],
    /// K [rad/s²].
    pub gain: [f64; N],
    /// φ [rad/s].
    pub layer: [f64; N],
    /// k₀ [1/s].
    pub linear: [f64; N],
}

/// What is known of the mismatch between model and arm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mismatch {
    /// A bound a of ‖I − M⁻¹M₀‖, 0 ≤ a < 1.
    pub inertia: f64,
    /// A bound v̄ of the acceleration that the law asks for without its switching term [rad/s²].
    pub acceleration: f64,
    /// A bound d̄ of all else that is left out, as an acceleration [rad/s²].
    pub disturbance: f64,
}

impl Mismatch {
    /// (a v̄ + d̄)/(1 − a) [rad/s²]: what a switching term must be able to do.
    ///
    /// # Errors
    /// `inertia`: not in 0 … 1; `acceleration`, `disturbance`: negative or not finite.
    pub fn needed(&self) -> Result<f64> {
        let wanted = "a bound of |I - M⁻¹M₀| below 1: the model's inertia is too far off";
        within("inertia", &[self.inertia], |a| (0.0..1.0).contains(&a), wanted)?;
        non_negative("acceleration", &[self.acceleration])?;
        non_negative("disturbance", &[self.disturbance])?;
        Ok((self.inertia * self.acceleration + self.disturbance) / (1.0 - self.inertia))
    }

    /// What is needed and a tenth more.
    pub(super) fn covered(&self) -> Result<f64> {
        self.needed().map(|needed| 1.1 * needed)
    }
}

impl<const N: usize> SlidingMode<N> {
    /// Gains from a bandwidth p [rad/s]: Λ = k₀ = p; K is what the mismatch asks for and a tenth
    /// more, and φ = K/p. Inside its layer the law feeds back ė with 3p and e with 2p², and |e|
    /// ends within K/p².
    ///
    /// # Errors
    /// `bandwidth`, `gain`: not finite or not > 0, as without a mismatch; what [`Mismatch::needed`]
    /// names.
    pub fn with_bandwidth(bandwidth: [f64; N], mismatch: &Mismatch) -> Result<Self> {
        positive("bandwidth", &bandwidth)?;
        let gain = mismatch.covered()?;
        let layer = bandwidth.map(|p| gain / p);
        let feedback = Self { lambda: bandwidth, gain: [gain; N], layer, linear: bandwidth };
        feedback.validate()?;
        Ok(feedback)
    }

    /// Checks the parameters.
    ///
    /// # Errors
    /// `lambda`, `gain`, `layer`: not finite or not > 0; `linear`: not finite or negative.
    pub fn validate(&self) -> Result<()> {
        positive("lambda", &self.lambda)?;
        positive("gain", &self.gain)?;
        positive("layer", &self.layer)?;
        non_negative("linear", &self.linear)
    }

    /// Refuses gains that do not reach over this mismatch, with `reaching` η [rad/s²] to spare.
    ///
    /// # Errors
    /// `gain`, or what [`Mismatch::needed`] names.
    pub fn covers(&self, mismatch: &Mismatch, reaching: f64) -> Result<()> {
        let needed = mismatch.needed()? + reaching;
        let wanted = "more than the mismatch asks for: (a v + d)/(1 - a) + reaching";
        within("gain", &self.gain, |gain| gain > needed, wanted)
    }

    /// Refuses a period \[s\] and delay, in samples, for which the layer is too thin:
    /// (K/φ + k₀ + Λ) h (1 + d) < 1 keeps s from jumping across it.
    ///
    /// # Errors
    /// `layer`.
    pub fn suits(&self, period: f64, delay: f64) -> Result<()> {
        let pole = |n: usize| self.gain[n] / self.layer[n] + self.linear[n] + self.lambda[n];
        let slow = |n: &usize| pole(*n) * period * (1.0 + delay) < 1.0;
        match (0..N).find(|n| !slow(n)) {
            None => Ok(()),
            Some(n) => {
                let wanted = "a wider layer or a shorter period: (K/φ + k₀ + Λ) h (1 + delay) < 1";
                Err(Error::out_of_range("layer", self.layer[n], wanted).at(n))
            }
        }
    }
}

impl<const N: usize> Feedback<N> for SlidingMode<N> {
    fn acceleration(&self, seen: &Sample<N>) -> Vector<N> {
        let (s, Self { lambda, gain, layer, linear }) = (sliding(&self.lambda, seen), self);
        Vector::from_fn(|n, _| {
            let switching = gain[n] * (s[n] / layer[n]).clamp(-1.0, 1.0);
            seen.desired.ddq[n] - lambda[n] * seen.de[n] - switching - linear[n] * s[n]
        })
    }

    fn tuning(&self) -> u64 {
        let Self { lambda, gain, layer, linear } = self;
        [lambda, gain, layer, linear].into_iter().fold(FNV_START, |hash, of| fnv_of(hash, *of))
    }
}

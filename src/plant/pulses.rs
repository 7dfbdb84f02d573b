//! Pushes that begin and end: `τ_d(t) = Σₖ τₖ w((t − tₖ)/dₖ)`, with w = 1 or w = sin(π s) for
//! 0 ≤ s < 1, and zero elsewhere. One without an end is a step.

use core::f64::consts::PI;

use super::Disturbance;
use crate::error::{Error, Result, accepted, finite};
use crate::math::{Vector, sin_cos};

/// One of several [`Pulses`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pulse<const N: usize> {
    /// When it begins, tₖ \[s\].
    pub time: f64,
    /// How long it lasts, dₖ \[s\] > 0; infinity for a step.
    pub duration: f64,
    /// Its height τₖ [N·m].
    pub torque: [f64; N],
}

/// How a pulse rises and falls.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Shape {
    /// At once, w = 1.
    #[default]
    Rectangle,
    /// Half a sine, w = sin(π s): the area is 2/π of the rectangle's.
    HalfSine,
}

/// Steps, rectangular and half-sine impulses, in an array, a slice or a `Vec`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pulses<const N: usize, T> {
    pulses: T,
    shape: Shape,
}

impl<const N: usize, T: AsRef<[Pulse<N>]>> Pulses<N, T> {
    /// These pulses, all of one shape.
    ///
    /// # Errors
    /// With the index of the pulse: `NotFinite` naming `time`, or `torque` (index k N + i);
    /// `OutOfRange` naming `duration` for one that is not > 0, or infinite for a half sine.
    pub fn new(pulses: T, shape: Shape) -> Result<Self> {
        for (k, pulse) in pulses.as_ref().iter().enumerate() {
            finite("time", &[pulse.time]).map_err(|error| error.at(k))?;
            accepted("duration", &[pulse.duration], |d| d > 0.0, "a number > 0")
                .map_err(|error| error.at(k))?;
            if shape == Shape::HalfSine && pulse.duration.is_infinite() {
                let wanted = "an end: half a sine has one, a rectangle needs none";
                return Err(Error::out_of_range("duration", pulse.duration, wanted).at(k));
            }
            finite("torque", &pulse.torque)
                .map_err(|error| error.at(k * N + error.index().unwrap_or(0)))?;
        }
        Ok(Self { pulses, shape })
    }

    /// Their sum at time `t` \[s\].
    pub fn value(&self, t: f64) -> Vector<N> {
        let mut value = Vector::zeros();
        for Pulse { time, duration, torque } in self.pulses.as_ref() {
            let x = t - time;
            if x >= 0.0 && x < *duration {
                let weight = match self.shape {
                    Shape::Rectangle => 1.0,
                    Shape::HalfSine => sin_cos(PI * (x / duration)).0,
                };
                value += Vector::from(*torque) * weight;
            }
        }
        value
    }
}

impl<const N: usize, T: AsRef<[Pulse<N>]>> Disturbance<N> for Pulses<N, T> {
    fn torque(&self, _: &Vector<N>, _: &Vector<N>, t: f64) -> Vector<N> {
        self.value(t)
    }

    #[inline]
    fn at_time(&self, t: f64) -> Option<Vector<N>> {
        Some(self.value(t))
    }
}

//! Sums of sines: `q_d(t) = o + Σₖ sₖ sin(ωₖ t) + cₖ cos(ωₖ t)`, the paper's reference and its
//! disturbance (section 4); with t − t₀ for t where there is a start.

use super::{Reference, Setpoint};
use crate::error::{Result, finite};
use crate::math::{Vector, sin_cos};

/// One frequency of a [`Sines`], with its amplitudes in every joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Harmonic<const N: usize> {
    /// ω [rad/s].
    pub frequency: f64,
    /// s, amplitudes of sin(ω t) \[rad\].
    pub sin: [f64; N],
    /// c, amplitudes of cos(ω t) \[rad\].
    pub cos: [f64; N],
}

/// `o + Σₖ sₖ sin(ωₖ t) + cₖ cos(ωₖ t)` with its exact derivatives. Used as a disturbance, its unit
/// is N·m.
///
/// The harmonics live in an array, a slice or a `Vec`; each costs one sine and cosine, so give
/// every frequency once.
///
/// It is there at all times, or from a start t₀ on. Before, a reference stands still where it will
/// begin, at `o + Σₖ cₖ`, with the velocity `Σₖ ωₖ sₖ` at once; and a disturbance is zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sines<const N: usize, T> {
    offset: Vector<N>,
    harmonics: T,
    /// t₀ \[s\].
    start_time: Option<f64>,
}

impl<const N: usize, T: AsRef<[Harmonic<N>]>> Sines<N, T> {
    /// Checks the numbers, and that no value, velocity or acceleration can overflow.
    ///
    /// # Errors
    /// `NotFinite`, naming `offset`, `harmonics.frequency` (index k), `harmonics.sin` or
    /// `harmonics.cos` (index k N + i of harmonic k and joint i); or `acceleration` (index i) if
    /// amplitudes and frequencies overflow together.
    pub fn new(offset: [f64; N], harmonics: T) -> Result<Self> {
        finite("offset", &offset)?;
        for (k, harmonic) in harmonics.as_ref().iter().enumerate() {
            entry("harmonics.frequency", k, harmonic.frequency)?;
            for i in 0..N {
                entry("harmonics.sin", k * N + i, harmonic.sin[i])?;
                entry("harmonics.cos", k * N + i, harmonic.cos[i])?;
            }
        }
        for i in 0..N {
            // 1 + ω² bounds 1, ω and ω²: this sum is larger than the value and both derivatives.
            let bound = harmonics.as_ref().iter().fold(offset[i].abs(), |sum, h| {
                sum + (1.0 + h.frequency * h.frequency) * (h.sin[i].abs() + h.cos[i].abs())
            });
            entry("acceleration", i, bound)?;
        }
        Ok(Self { offset: offset.into(), harmonics, start_time: None })
    }

    /// The same from `start_time` \[s\] on.
    ///
    /// # Errors
    /// `NotFinite`, naming `start_time`.
    pub fn starting_at(self, start_time: f64) -> Result<Self> {
        finite("start_time", &[start_time])?;
        Ok(Self { start_time: Some(start_time), ..self })
    }

    /// t₀ \[s\], if it has a start.
    pub fn start_time(&self) -> Option<f64> {
        self.start_time
    }

    /// o, the constant part.
    pub fn offset(&self) -> &Vector<N> {
        &self.offset
    }

    /// The harmonics.
    pub fn harmonics(&self) -> &[Harmonic<N>] {
        self.harmonics.as_ref()
    }

    /// The sum alone, without its derivatives, at time `t` \[s\].
    #[inline(always)]
    pub fn value(&self, t: f64) -> Vector<N> {
        self.sum(self.since_start(t).unwrap_or(0.0))
    }

    /// The sum alone as a disturbance: zero before the start.
    #[inline(always)]
    pub fn disturbance(&self, t: f64) -> Vector<N> {
        self.since_start(t).map_or_else(Vector::zeros, |t| self.sum(t))
    }

    /// t − t₀, or t without a start; `None` before the start.
    #[inline(always)]
    fn since_start(&self, t: f64) -> Option<f64> {
        match self.start_time {
            None => Some(t),
            Some(start) if t < start => None,
            Some(start) => Some(t - start),
        }
    }

    #[inline(always)]
    fn sum(&self, t: f64) -> Vector<N> {
        let mut value = self.offset;
        for Harmonic { frequency, sin, cos } in self.harmonics.as_ref() {
            let (s, c) = sin_cos(frequency * t);
            for i in 0..N {
                value[i] += sin[i] * s + cos[i] * c;
            }
        }
        value
    }
}

impl<const N: usize, T: AsRef<[Harmonic<N>]>> Reference<N> for Sines<N, T> {
    #[inline(always)]
    fn at(&self, t: f64) -> Setpoint<N> {
        let Some(t) = self.since_start(t) else { return Setpoint::at_rest(self.sum(0.0)) };
        let mut setpoint = Setpoint::at_rest(self.offset);
        for &Harmonic { frequency, sin, cos } in self.harmonics.as_ref() {
            let (s, c) = sin_cos(frequency * t);
            for i in 0..N {
                let value = sin[i] * s + cos[i] * c;
                setpoint.q[i] += value;
                setpoint.dq[i] += frequency * (sin[i] * c - cos[i] * s);
                setpoint.ddq[i] -= frequency * frequency * value;
            }
        }
        setpoint
    }
}

fn entry(parameter: &'static str, index: usize, got: f64) -> Result<()> {
    finite(parameter, &[got]).map_err(|error| error.at(index))
}

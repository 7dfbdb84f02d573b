//! How a run is made: length, step, method, sampling.

use super::integrators::Tolerance;
use super::metrics::Window;
use crate::control::check_period;
use crate::effects::Effects;
use crate::error::{Error, Result, finite, positive, within};

/// A run has at most this many steps.
const MAX_STEPS: f64 = 1e8;

/// A record takes at most this much memory \[bytes\]. A larger one is refused before the run.
pub const MAX_RECORD_BYTES: u64 = 1 << 31;

/// How far a ratio of times may be from a whole number.
const WHOLE_TOL: f64 = 1e-6;

/// How the motion is integrated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// Classical Runge-Kutta of order 4 with the fixed step `dt`.
    Rk4,
    /// Dormand-Prince 5(4) with error control; `dt` is the spacing of the record.
    Dp54(Tolerance),
}

/// Which signals enter the record.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Record {
    /// All of them.
    #[default]
    All,
    /// Position and velocity; [`Run::add_reference`](super::Run::add_reference) adds the desired
    /// motion and the error afterwards. A row of an error-controlled run then needs only its dense
    /// output, and no evaluation of the loop.
    Motion,
    /// None of them, and no certificate: only the [metrics](super::Run::metrics) of the run over
    /// this window. Nothing grows with its length.
    Metrics(Window),
}

/// Options of a simulation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options<const N: usize> {
    /// Length \[s\].
    pub duration: f64,
    /// Step of the integrator, and spacing of the record \[s\].
    pub dt: f64,
    /// Integrator.
    pub method: Method,
    /// Period of a sampled controller that holds its torque \[s\]; `None`: it acts in continuous
    /// time.
    pub control_period: Option<f64>,
    /// Initial position \[rad\].
    pub q0: [f64; N],
    /// Initial velocity [rad/s].
    pub dq0: [f64; N],
    /// Only every so many steps enter the record.
    pub record_every: usize,
    /// Which signals enter the record.
    pub record: Record,
    /// What stands between controller and arm; a sampled controller's alone.
    pub effects: Effects<N>,
}

impl Record {
    /// Whether signals enter this record that enter those of `kind`.
    pub(super) fn takes(self, kind: Self) -> bool {
        match self {
            Self::All => true,
            Self::Motion => kind == Self::Motion,
            Self::Metrics(_) => false,
        }
    }
}

impl<const N: usize> Default for Options<N> {
    /// The paper's: 40 s of RK4 in steps of 1 ms, from rest at q = 0, in continuous time.
    fn default() -> Self {
        Self {
            duration: 40.0,
            dt: 1e-3,
            method: Method::Rk4,
            control_period: None,
            q0: [0.0; N],
            dq0: [0.0; N],
            record_every: 1,
            record: Record::All,
            effects: Effects::default(),
        }
    }
}

impl<const N: usize> Options<N> {
    /// Refuses options that make no sense.
    ///
    /// # Errors
    /// The name of the option that is not finite, out of range, or no whole number of `dt`.
    pub fn validate(&self) -> Result<()> {
        self.steps().map(drop)
    }

    /// Time of the last row \[s\], to the bit; NaN for options that make no sense.
    #[cfg(feature = "python")]
    pub(crate) fn end(&self) -> f64 {
        self.steps().map_or(f64::NAN, |(steps, _)| steps as f64 * self.dt)
    }

    /// Number of steps of `dt`, and of `dt` in a control period.
    ///
    /// # Errors
    /// The name of the option that is not finite, out of range, or no whole number of `dt`.
    pub(super) fn steps(&self) -> Result<(usize, usize)> {
        positive("dt", &[self.dt])?;
        positive("duration", &[self.duration])?;
        finite("q0", &self.q0)?;
        finite("dq0", &self.dq0)?;
        if self.record_every == 0 {
            let wanted = "a whole number >= 1";
            return Err(Error::out_of_range("record_every", 0.0, wanted));
        }
        if let Method::Dp54(Tolerance { rtol, atol }) = self.method {
            within("rtol", &[rtol], |x| (1e-14..=1e-1).contains(&x), "between 1e-14 and 0.1")?;
            within("atol", &[atol], |x| (1e-20..=1e-1).contains(&x), "between 1e-20 and 0.1")?;
        }
        self.effects.validate()?;
        let steps = self.multiples("duration", "duration / dt", self.duration)?;
        let hold = match self.control_period {
            None => 1,
            Some(period) => {
                check_period("control_period", period)?;
                self.multiples("control_period", "control_period / dt", period)?
            }
        };
        Ok((steps, hold))
    }

    fn multiples(
        &self,
        parameter: &'static str,
        ratio_name: &'static str,
        time: f64,
    ) -> Result<usize> {
        let ratio = time / self.dt;
        let whole = libm::round(ratio);
        if ratio > MAX_STEPS {
            let limit = MAX_STEPS as usize;
            return Err(Error::too_many(ratio_name, Some(whole as usize), limit));
        }
        if whole < 1.0 || (ratio - whole).abs() > WHOLE_TOL {
            let wanted = "a whole number of dt";
            return Err(Error::out_of_range(parameter, time, wanted));
        }
        Ok(whole as usize)
    }
}

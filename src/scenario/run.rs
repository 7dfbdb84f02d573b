//! How a run is made, and where it starts.

use serde::{Deserialize, Serialize};

use super::numbers::PerJoint;
use crate::error::{Result, finite};
use crate::sim::{Method, Options, Tolerance};

/// Parameters of a simulation, [`Options`]; what is recorded is not among them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RunSettings {
    /// Length \[s\].
    pub duration: f64,
    /// Step of the integrator, and spacing of the record \[s\].
    pub dt: f64,
    /// The integrator.
    pub method: MethodName,
    /// Period of a sampled controller \[s\]; absent: it acts in continuous time.
    pub control_period: Option<f64>,
    /// Initial position \[rad\].
    pub q0: PerJoint,
    /// Initial velocity \[rad/s\].
    pub dq0: PerJoint,
    /// Relative tolerance of "dp54".
    pub rtol: f64,
    /// Absolute tolerance of "dp54" [rad, rad/s].
    pub atol: f64,
}

/// An integrator by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MethodName {
    /// Fixed steps.
    Rk4,
    /// Error control to `rtol` and `atol`.
    Dp54,
}

impl MethodName {
    /// Its name, as in a file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rk4 => "rk4",
            Self::Dp54 => "dp54",
        }
    }
}

impl Default for RunSettings {
    fn default() -> Self {
        let Options { duration, dt, control_period, .. } = Options::<1>::default();
        let Tolerance { rtol, atol } = Tolerance::default();
        let (q0, dq0) = (0.0.into(), 0.0.into());
        Self { duration, dt, method: MethodName::Rk4, control_period, q0, dq0, rtol, atol }
    }
}

impl RunSettings {
    /// The options of a run of `N` joints.
    ///
    /// # Errors
    /// `WrongLength`, naming `q0` or `dq0`; as [`Options::validate`].
    pub fn options<const N: usize>(&self) -> Result<Options<N>> {
        let Self { duration, dt, control_period, rtol, atol, .. } = *self;
        let method = match self.method {
            MethodName::Rk4 => Method::Rk4,
            MethodName::Dp54 => Method::Dp54(Tolerance { rtol, atol }),
        };
        let (q0, dq0) = (self.q0.each("q0")?, self.dq0.each("dq0")?);
        let options =
            Options { duration, dt, method, control_period, q0, dq0, ..Options::default() };
        options.validate()?;
        Ok(options)
    }

    /// Refuses what is out of range, whatever the number of joints.
    ///
    /// # Errors
    /// As [`options`](Self::options).
    pub fn check(&self) -> Result<()> {
        finite("q0", self.q0.as_slice())?;
        finite("dq0", self.dq0.as_slice())?;
        // Tolerances are looked at whatever the method.
        [MethodName::Dp54, self.method].into_iter().try_for_each(|method| {
            let still = Self { q0: 0.0.into(), dq0: 0.0.into(), method, ..self.clone() };
            still.options::<1>().map(drop)
        })
    }
}

//! The names of parameters, and refusals that carry them.

use crate::error::{Error, Result, finite};

/// A parameter of one joint.
#[derive(Clone, Copy)]
pub(super) struct Of {
    pub parameter: &'static str,
    pub joint: Option<usize>,
}

impl Of {
    /// Refuses what is not finite.
    pub fn finite(self, values: &[f64]) -> Result<()> {
        finite(self.parameter, values).map_err(|error| error.at(self.joint))
    }

    /// Refuses what is not finite or not accepted.
    pub fn within(self, got: f64, accepted: bool, wanted: &'static str) -> Result<()> {
        self.finite(&[got])?;
        self.accept(got, accepted, wanted)
    }

    /// Refuses what is not accepted; infinities may be.
    pub fn accept(self, got: f64, accepted: bool, wanted: &'static str) -> Result<()> {
        if accepted {
            return Ok(());
        }
        Err(Error::out_of_range(self.parameter, got, wanted).at(self.joint))
    }
}

/// Names of an inertia's parameters.
#[derive(Clone, Copy)]
pub(super) struct InertiaNames {
    pub mass: &'static str,
    pub com: &'static str,
    pub moments: &'static str,
}

impl InertiaNames {
    /// Of a mass distribution by itself.
    pub const ALONE: Self = Self { mass: "mass", com: "com", moments: "moments" };
    /// Of a link's.
    pub const LINK: Self =
        Self { mass: "inertia.mass", com: "inertia.com", moments: "inertia.moments" };
}

/// Names of a pose's parameters.
#[derive(Clone, Copy)]
pub(super) struct PoseNames {
    pub rotation: &'static str,
    pub translation: &'static str,
}

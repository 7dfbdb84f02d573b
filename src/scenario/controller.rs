//! The two-link arm and the controller's gains and limits.

use serde::{Deserialize, Serialize};

use super::numbers::{PerJoint, agreed};
use crate::arm::{Friction, TwoLink, TwoLinkParameters};
use crate::control::{Gains, Limits};
use crate::error::Result;

/// Parameters of a [`TwoLink`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TwoLinkSettings {
    /// Mass of each link \[kg\].
    pub mass: PerJoint,
    /// Length of each link \[m\].
    pub length: PerJoint,
    /// Moment of inertia of each link about its centre of mass \[kg·m²\].
    pub inertia: PerJoint,
    /// g \[m/s²\].
    #[serde(default = "gravity")]
    pub gravity: f64,
    /// Viscous friction \[N·m·s/rad\].
    #[serde(default = "viscous")]
    pub viscous: PerJoint,
    /// Coulomb friction \[N·m\].
    #[serde(default = "coulomb")]
    pub coulomb: PerJoint,
    /// Speed at which Coulomb friction reaches 76 % \[rad/s\]; 0 for dry friction that sticks.
    #[serde(default = "smoothing")]
    pub smoothing: PerJoint,
}

fn gravity() -> f64 {
    TwoLinkParameters::default().gravity
}

fn viscous() -> PerJoint {
    Friction::<2>::default().viscous[0].into()
}

fn coulomb() -> PerJoint {
    Friction::<2>::default().coulomb[0].into()
}

fn smoothing() -> PerJoint {
    Friction::<2>::default().smoothing[0].into()
}

impl TwoLinkSettings {
    /// Without gravity and friction.
    pub fn new(mass: PerJoint, length: PerJoint, inertia: PerJoint) -> Self {
        let (viscous, coulomb, smoothing) = (viscous(), coulomb(), smoothing());
        Self { mass, length, inertia, gravity: gravity(), viscous, coulomb, smoothing }
    }

    /// The arm.
    ///
    /// # Errors
    /// As [`TwoLink::new`], naming `mass`, `viscous`, …; `WrongLength`.
    pub fn build(&self) -> Result<TwoLink> {
        let friction = Friction {
            viscous: self.viscous.each("viscous")?,
            coulomb: self.coulomb.each("coulomb")?,
            smoothing: self.smoothing.each("smoothing")?,
        };
        let parameters = TwoLinkParameters {
            mass: self.mass.each("mass")?,
            length: self.length.each("length")?,
            inertia: self.inertia.each("inertia")?,
            gravity: self.gravity,
            friction,
        };
        TwoLink::new(parameters).map_err(|error| {
            let name = error.parameter();
            error.named(name.strip_prefix("friction.").unwrap_or(name))
        })
    }
}

impl From<&TwoLinkParameters> for TwoLinkSettings {
    fn from(parameters: &TwoLinkParameters) -> Self {
        let TwoLinkParameters { mass, length, inertia, gravity, friction } = *parameters;
        let Friction { viscous, coulomb, smoothing } = friction;
        Self {
            mass: mass.into(),
            length: length.into(),
            inertia: inertia.into(),
            gravity,
            viscous: viscous.into(),
            coulomb: coulomb.into(),
            smoothing: smoothing.into(),
        }
    }
}

/// Gains and limits of a controller.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ControllerSettings {
    /// K_p \[1/s²\].
    pub kp: PerJoint,
    /// K_v \[1/s\].
    pub kv: PerJoint,
    /// Largest torque \[N·m\]; absent: none.
    #[serde(default = "none")]
    pub effort_limit: PerJoint,
    /// Largest change of torque \[N·m/s\]; absent: none.
    #[serde(default = "none")]
    pub effort_rate_limit: PerJoint,
}

fn none() -> PerJoint {
    f64::INFINITY.into()
}

impl ControllerSettings {
    /// These gains, without limits; one number for all joints where they are the same.
    pub fn new<const N: usize>(gains: &Gains<N>) -> Self {
        let of = |values: &[f64; N]| match values.first() {
            Some(&first) if values.iter().all(|&value| value == first) => first.into(),
            _ => (*values).into(),
        };
        let (kp, kv) = (of(&gains.kp), of(&gains.kv));
        Self { kp, kv, effort_limit: none(), effort_rate_limit: none() }
    }

    /// K_p and K_v of `N` joints.
    ///
    /// # Errors
    /// As [`Gains::new`]; `WrongLength`.
    pub fn gains<const N: usize>(&self) -> Result<Gains<N>> {
        Gains::new(self.kp.each("kp")?, self.kv.each("kv")?)
    }

    /// The limits of `N` joints.
    ///
    /// # Errors
    /// As [`Limits::validate`]; `WrongLength`.
    pub fn limits<const N: usize>(&self) -> Result<Limits<N>> {
        let effort_limit = self.effort_limit.each("effort_limit")?;
        let effort_rate_limit = self.effort_rate_limit.each("effort_rate_limit")?;
        let limits = Limits { effort_limit, effort_rate_limit };
        limits.validate()?;
        Ok(limits)
    }

    /// Refuses what is out of range for a joint, whatever their number.
    ///
    /// # Errors
    /// As [`gains`](Self::gains) and [`limits`](Self::limits).
    pub fn check(&self) -> Result<()> {
        let Self { kp, kv, effort_limit, effort_rate_limit } = self;
        let known = [
            ("kp", kp),
            ("kv", kv),
            ("effort_limit", effort_limit),
            ("effort_rate_limit", effort_rate_limit),
        ];
        let joints = known.map(|(name, values)| (name, values.count()));
        let joints = joints.into_iter().try_fold(None, agreed)?;
        for n in 0..joints.unwrap_or(1) {
            let [kp, kv, effort_limit, effort_rate_limit] =
                known.map(|(_, values)| values.of_joint(n).into());
            let of_one = Self { kp, kv, effort_limit, effort_rate_limit };
            let checked = of_one.gains::<1>().and_then(|_| of_one.limits::<1>());
            checked.map_err(|error| error.at(joints.map(|_| n)))?;
        }
        Ok(())
    }
}

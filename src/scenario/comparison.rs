//! What a comparison needs beside the controllers: the arm that is really there, and which figures.

use serde::{Deserialize, Serialize};

use super::TwoLinkSettings;
use super::numbers::PerJoint;
use crate::error::{Error, Result, positive, within};

/// The arm that controllers believe in, by name or file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RobotSettings {
    /// A shipped robot by its name, or the path of a URDF or TOML file.
    pub file: String,
    /// The frame at the end of its chain; absent: as the file says.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tip: Option<String>,
    /// Inertia of each rotor on the link's side of its gear \[kg·m²\], known to the controllers;
    /// absent: as the file says.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub armature: Option<PerJoint>,
}

/// What is different on the arm that is really there.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ActualSettings {
    /// Another two-link arm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub two_link: Option<TwoLinkSettings>,
    /// By how much masses and inertias are larger than believed: one for all links, or one a link.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub inertia_scale: Option<PerJoint>,
    /// Viscous friction of each joint \[N·m·s/rad\].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub viscous: Option<PerJoint>,
    /// Coulomb friction of each joint \[N·m\].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coulomb: Option<PerJoint>,
    /// Friction as a share of the effort limit, half Coulomb's, half viscous at the speed limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction_share: Option<f64>,
    /// What nobody told the controllers of.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub payload: Option<PayloadSettings>,
    /// Largest torque of each actuator \[N·m\]; absent: none, or the robot's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effort_limit: Option<PerJoint>,
    /// Friction that changes, in the order of time.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub changes: Vec<ChangeSettings>,
}

/// Friction from some time on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChangeSettings {
    /// \[s\].
    pub at: f64,
    /// Viscous friction of each joint from then on \[N·m·s/rad\].
    #[serde(default = "none")]
    pub viscous: PerJoint,
    /// Coulomb friction of each joint from then on \[N·m\].
    #[serde(default = "none")]
    pub coulomb: PerJoint,
}

fn none() -> PerJoint {
    0.0.into()
}

/// A payload at the tip.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PayloadSettings {
    /// \[kg\].
    pub mass: f64,
    /// Centre of mass in the tip's frame \[m\].
    #[serde(default)]
    pub com: [f64; 3],
    /// When it is picked up \[s\]; absent: it is there from the start.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<f64>,
    /// When it is put down \[s\]; absent: never.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub until: Option<f64>,
}

impl ActualSettings {
    /// Refuses what makes no sense, whatever the number of joints.
    ///
    /// # Errors
    /// Naming the parameter.
    pub fn check(&self) -> Result<()> {
        if let Some(scale) = &self.inertia_scale {
            positive("inertia_scale", scale.as_slice())?;
        }
        let not_negative = |x: f64| x >= 0.0 && x.is_finite();
        for (name, values) in [("viscous", &self.viscous), ("coulomb", &self.coulomb)] {
            let values = values.as_ref().map_or(&[][..], PerJoint::as_slice);
            within(name, values, not_negative, "a number >= 0")?;
        }
        let mut last = 0.0;
        for (k, ChangeSettings { at, viscous, coulomb }) in self.changes.iter().enumerate() {
            let wanted = "a time after that of the change before, and after 0";
            let friction = [("changes.viscous", viscous), ("changes.coulomb", coulomb)];
            let checked = within("changes.at", &[*at], |at| at > last, wanted).and_then(|()| {
                friction.into_iter().try_for_each(|(name, values)| {
                    within(name, values.as_slice(), not_negative, "a number >= 0")
                })
            });
            checked.map_err(|error| error.at(k))?;
            last = *at;
        }
        let share = self.friction_share.unwrap_or(0.0);
        within("friction_share", &[share], |x| (0.0..=1.0).contains(&x), "a share, 0 to 1")?;
        let limit = self.effort_limit.as_ref().map_or(&[][..], PerJoint::as_slice);
        if let Some(n) = limit.iter().position(|limit| limit.is_nan() || *limit <= 0.0) {
            return Err(Error::out_of_range("effort_limit", limit[n], "a limit > 0").at(n));
        }
        let Some(PayloadSettings { mass, from, until, .. }) = &self.payload else { return Ok(()) };
        positive("payload.mass", &[*mass])?;
        let start = from.unwrap_or(0.0);
        within("payload.from", &[start], not_negative, "a time >= 0")?;
        let end = until.unwrap_or(f64::MAX);
        within("payload.until", &[end], |end| end > start, "a time after payload.from")
    }
}

/// Which figures of a run count.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MetricsSettings {
    /// From \[s\]; absent: half of the run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub from: Option<f64>,
    /// To \[s\]; absent: the end of the run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub to: Option<f64>,
    /// What counts as settled \[rad\].
    pub band: f64,
}

impl Default for MetricsSettings {
    fn default() -> Self {
        Self { from: None, to: None, band: 0.01 }
    }
}

impl MetricsSettings {
    /// Refuses what makes no sense.
    ///
    /// # Errors
    /// `from`, `to`, `band`.
    pub fn check(&self) -> Result<()> {
        let from = self.from.unwrap_or(0.0);
        within("from", &[from], |x| x >= 0.0, "a time >= 0")?;
        within("to", &[self.to.unwrap_or(f64::MAX)], |to| to > from, "a time after from")?;
        positive("band", &[self.band])
    }
}

//! What stands between a controller and its arm: effects, and the front of a controller.

use core::f64::consts::TAU;

use serde::{Deserialize, Serialize};

use super::numbers::PerJoint;
use crate::control::Front;
use crate::effects::{Actuators, Effects, Sensors, Side, Timing, Transmission, Velocity};
use crate::error::{Error, Result, accepted, positive, within};
use crate::plant::Elastic;

/// Parameters of [`Effects`]; all of them are off by default.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct EffectsSettings {
    /// Bits of each encoder in a turn of its joint; absent: exact positions.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub encoder_bits: Option<PerJoint>,
    /// Standard deviation of the noise of positions \[rad\].
    pub noise: PerJoint,
    /// Where velocities come from.
    pub velocity: VelocityName,
    /// Standard deviation of the noise of "measured" velocities \[rad/s\].
    pub velocity_noise: PerJoint,
    /// Cut-off of the filter of "difference" \[Hz\].
    pub velocity_cutoff: f64,
    /// Bandwidth of "tracking" \[rad/s\].
    pub velocity_bandwidth: f64,
    /// Standard deviation of the accelerations that "kalman" counts with \[rad/s²\].
    pub velocity_acceleration: f64,
    /// Samples between a torque and the period in which it acts.
    pub delay: usize,
    /// By how much a period may differ from its length, as a share.
    pub jitter: f64,
    /// Probability that a sample is lost.
    pub drop: f64,
    /// Largest change of each torque \[N·m/s\].
    pub effort_rate_limit: PerJoint,
    /// What arrives of a torque, as a share.
    pub gain: PerJoint,
    /// Time constant of each drive \[s\].
    pub lag: PerJoint,
    /// Largest cogging torque \[N·m\].
    pub cogging: PerJoint,
    /// Periods of the cogging in a turn.
    pub cogging_per_turn: f64,
    /// Stiffness of the gears \[N·m/rad\]; absent: links follow their motors.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub joint_stiffness: Option<PerJoint>,
    /// Damping of the gears \[N·m·s/rad\].
    pub joint_damping: PerJoint,
    /// Inertia of each motor on the link's side of its gear \[kg·m²\]; needed with a stiffness.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotor_inertia: Option<PerJoint>,
    /// Play of the gears from end to end \[rad\].
    pub backlash: PerJoint,
    /// Where the encoders are.
    pub encoder_side: SideName,
    /// Seed of all that is random.
    pub seed: u64,
}

/// A side of the gears, by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SideName {
    /// At the motors.
    Motor,
    /// At the links.
    Link,
}

impl SideName {
    /// Its name, as in a file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Motor => "motor",
            Self::Link => "link",
        }
    }
}

/// Where a velocity comes from, by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum VelocityName {
    /// The joint's own.
    Measured,
    /// Difference of positions through a first-order filter.
    Difference,
    /// A tracking differentiator.
    Tracking,
    /// A Kalman filter in its steady state.
    Kalman,
}

impl VelocityName {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Measured, Self::Difference, Self::Tracking, Self::Kalman];

    /// Its name, as in a file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Measured => "measured",
            Self::Difference => "difference",
            Self::Tracking => "tracking",
            Self::Kalman => "kalman",
        }
    }
}

impl Default for EffectsSettings {
    fn default() -> Self {
        let Effects { timing, actuators, seed, .. } = Effects::<1>::default();
        let Timing { delay, jitter, drop } = timing;
        let Actuators { effort_rate_limit, gain, lag, cogging, cogging_per_turn } = actuators;
        Self {
            encoder_bits: None,
            noise: 0.0.into(),
            velocity: VelocityName::Measured,
            velocity_noise: 0.0.into(),
            velocity_cutoff: 100.0,
            velocity_bandwidth: 300.0,
            velocity_acceleration: 10.0,
            delay,
            jitter,
            drop,
            effort_rate_limit: effort_rate_limit[0].into(),
            gain: gain[0].into(),
            lag: lag[0].into(),
            cogging: cogging[0].into(),
            cogging_per_turn,
            joint_stiffness: None,
            joint_damping: 0.0.into(),
            rotor_inertia: None,
            backlash: 0.0.into(),
            encoder_side: SideName::Motor,
            seed,
        }
    }
}

impl EffectsSettings {
    /// The effects of `N` joints.
    ///
    /// # Errors
    /// `encoder_bits`: not in 1 … 64; as [`Effects::validate`]; `WrongLength`.
    pub fn build<const N: usize>(&self) -> Result<Effects<N>> {
        let encoder = match &self.encoder_bits {
            None => [0.0; N],
            Some(bits) => {
                let bits: [f64; N] = bits.each("encoder_bits")?;
                let possible = |bits: f64| (1.0..=64.0).contains(&bits);
                within("encoder_bits", &bits, possible, "bits in a turn, 1 to 64")?;
                bits.map(|bits| TAU / libm::exp2(bits))
            }
        };
        let wanted = "a cut-off > 0, infinite for none";
        accepted("velocity_cutoff", &[self.velocity_cutoff], |f| f > 0.0, wanted)?;
        positive("velocity_bandwidth", &[self.velocity_bandwidth])?;
        positive("velocity_acceleration", &[self.velocity_acceleration])?;
        let velocity = match self.velocity {
            VelocityName::Measured => {
                Velocity::Measured(self.velocity_noise.each("velocity_noise")?)
            }
            VelocityName::Difference => Velocity::Difference(self.velocity_cutoff),
            VelocityName::Tracking => Velocity::Tracking(self.velocity_bandwidth),
            VelocityName::Kalman => Velocity::Kalman(self.velocity_acceleration),
        };
        let effects = Effects {
            sensors: Sensors { encoder, noise: self.noise.each("noise")?, velocity },
            timing: Timing { delay: self.delay, jitter: self.jitter, drop: self.drop },
            actuators: Actuators {
                effort_rate_limit: self.effort_rate_limit.each("effort_rate_limit")?,
                gain: self.gain.each("gain")?,
                lag: self.lag.each("lag")?,
                cogging: self.cogging.each("cogging")?,
                cogging_per_turn: self.cogging_per_turn,
            },
            transmission: self.transmission().map_err(|error| self.named(error))?,
            seed: self.seed,
        };
        effects.validate().map_err(|error| self.named(error))?;
        Ok(effects)
    }

    fn transmission<const N: usize>(&self) -> Result<Option<Transmission<N>>> {
        let Some(stiffness) = &self.joint_stiffness else {
            let [damping, backlash]: [[f64; N]; 2] =
                [self.joint_damping.each("joint_damping")?, self.backlash.each("backlash")?];
            let idle = self.rotor_inertia.is_none();
            let given = damping.iter().chain(&backlash).any(|x| *x != 0.0);
            return if idle && !given { Ok(None) } else { Err(Error::missing("joint_stiffness")) };
        };
        let rotors = self.rotor_inertia.as_ref().ok_or_else(|| Error::missing("rotor_inertia"))?;
        let gears =
            Elastic::new(stiffness.each("joint_stiffness")?, rotors.each("rotor_inertia")?)?
                .with_damping(self.joint_damping.each("joint_damping")?)?
                .with_backlash(self.backlash.each("backlash")?)?;
        let encoders = match self.encoder_side {
            SideName::Motor => Side::Motor,
            SideName::Link => Side::Link,
        };
        Ok(Some(Transmission { gears, encoders }))
    }

    /// Refuses what is out of range, whatever the number of joints.
    ///
    /// # Errors
    /// As [`build`](Self::build).
    pub fn check(&self) -> Result<()> {
        let known = [
            ("encoder_bits", self.encoder_bits.as_ref().unwrap_or(&self.noise)),
            ("noise", &self.noise),
            ("velocity_noise", &self.velocity_noise),
            ("effort_rate_limit", &self.effort_rate_limit),
            ("gain", &self.gain),
            ("lag", &self.lag),
            ("cogging", &self.cogging),
            ("joint_stiffness", self.joint_stiffness.as_ref().unwrap_or(&self.backlash)),
            ("joint_damping", &self.joint_damping),
            ("rotor_inertia", self.rotor_inertia.as_ref().unwrap_or(&self.backlash)),
            ("backlash", &self.backlash),
        ];
        let counts = known.map(|(name, values)| (name, values.count()));
        let joints = counts.into_iter().try_fold(None, super::numbers::agreed)?;
        for n in 0..joints.unwrap_or(1) {
            let of = |values: &PerJoint| values.of_joint(n).into();
            let of_one = Self {
                encoder_bits: self.encoder_bits.as_ref().map(of),
                noise: of(&self.noise),
                velocity_noise: of(&self.velocity_noise),
                effort_rate_limit: of(&self.effort_rate_limit),
                gain: of(&self.gain),
                lag: of(&self.lag),
                cogging: of(&self.cogging),
                joint_stiffness: self.joint_stiffness.as_ref().map(of),
                joint_damping: of(&self.joint_damping),
                rotor_inertia: self.rotor_inertia.as_ref().map(of),
                backlash: of(&self.backlash),
                ..self.clone()
            };
            let checked = of_one.build::<1>();
            checked.map_err(|error| {
                let of_joint = known.iter().any(|(name, _)| *name == error.parameter());
                error.at(joints.filter(|_| of_joint).map(|_| n))
            })?;
        }
        Ok(())
    }

    /// An error by the names of the settings.
    fn named(&self, error: Error) -> Error {
        match (error.parameter(), self.velocity) {
            ("encoder", _) => error.named("encoder_bits"),
            ("stiffness", _) => error.named("joint_stiffness"),
            ("damping", _) => error.named("joint_damping"),
            ("velocity", VelocityName::Difference) => error.named("velocity_cutoff"),
            ("velocity", VelocityName::Tracking) => error.named("velocity_bandwidth"),
            ("velocity", VelocityName::Kalman) => error.named("velocity_acceleration"),
            _ => error,
        }
    }
}

/// Parameters of [`Front`]; all of it is off by default.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FrontSettings {
    /// Rate of the hand-over \[1/s\].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hand_over: Option<f64>,
    /// Cut-off of the velocity filter \[Hz\].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub velocity_filter: Option<f64>,
    /// Rate of the bumpless start \[1/s\].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bumpless: Option<f64>,
    /// Samples between a torque and its period; absent: what the effects say, or none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub delay: Option<usize>,
}

impl FrontSettings {
    /// The front.
    ///
    /// # Errors
    /// As [`Front::validate`].
    pub fn build(&self) -> Result<Front> {
        let Self { hand_over, velocity_filter, bumpless, delay } = *self;
        let front = Front { hand_over, velocity_filter, bumpless, delay: delay.unwrap_or(0) };
        front.validate()?;
        Ok(front)
    }
}

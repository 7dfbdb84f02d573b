//! What pushes the arm: curves as torques, pulses, noise, a wrench at the tip, and their sums.

use std::fmt;

use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{Error as _, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::curve::{Curve, CurveSettings, rows};
use super::numbers::{Numbers, PerJoint};
use super::{QuinticSettings, SinesSettings, TableSettings, WaypointsSettings};
use crate::arm::Tip;
use crate::error::{Error, Result, finite, length};
use crate::math::Vector;
use crate::plant::{Disturbance, Noise, Pulse, Pulses, Shape, Wrench};
use crate::reference::Sines;

/// A torque over time, of `N` joints; or six values, as force and moment.
#[derive(Clone, Debug)]
pub enum Signal<const N: usize> {
    /// The position of a curve.
    Curve(Curve<N>),
    /// Steps and impulses.
    Pulses(Pulses<N, Vec<Pulse<N>>>),
    /// Coloured noise.
    Noise(Noise<N>),
}

impl<const N: usize> Disturbance<N> for Signal<N> {
    fn torque(&self, q: &Vector<N>, dq: &Vector<N>, t: f64) -> Vector<N> {
        match self {
            Self::Curve(curve) => curve.torque(q, dq, t),
            Self::Pulses(pulses) => pulses.value(t),
            Self::Noise(noise) => noise.value(t),
        }
    }

    #[inline(always)]
    fn at_time(&self, t: f64) -> Option<Vector<N>> {
        Some(self.torque(&Vector::zeros(), &Vector::zeros(), t))
    }
}

/// What pushes an `A` of `N` joints.
#[derive(Clone, Debug)]
pub enum Push<const N: usize, A> {
    /// At the joints.
    Joints(Box<Signal<N>>),
    /// At the tip.
    Tip(Box<Wrench<A, Signal<6>>>),
}

impl<const N: usize, A: Tip<N>> Disturbance<N> for Push<N, A> {
    fn torque(&self, q: &Vector<N>, dq: &Vector<N>, t: f64) -> Vector<N> {
        match self {
            Self::Joints(signal) => signal.torque(q, dq, t),
            Self::Tip(wrench) => wrench.torque(q, dq, t),
        }
    }

    #[inline]
    fn at_time(&self, t: f64) -> Option<Vector<N>> {
        if let Self::Joints(signal) = self { signal.at_time(t) } else { None }
    }
}

/// What pushes an arm of any joint count.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PushSettings {
    /// A sum of sines.
    Sines(SinesSettings),
    /// From one torque to another.
    Quintic(QuinticSettings),
    /// Samples.
    Table(TableSettings),
    /// From torque to torque.
    Waypoints(WaypointsSettings),
    /// Steps and impulses.
    Pulses(PulsesSettings),
    /// Coloured noise.
    Noise(NoiseSettings),
    /// A force and a moment at the tip.
    Wrench(WrenchSettings),
}

impl From<CurveSettings> for PushSettings {
    fn from(curve: CurveSettings) -> Self {
        match curve {
            CurveSettings::Sines(sines) => Self::Sines(sines),
            CurveSettings::Quintic(quintic) => Self::Quintic(quintic),
            CurveSettings::Table(table) => Self::Table(table),
            CurveSettings::Waypoints(waypoints) => Self::Waypoints(waypoints),
        }
    }
}

impl PushSettings {
    /// For an arm of `N` joints.
    ///
    /// # Errors
    /// Naming the parameter: it is of another joint count, or as the constructor of [`Sines`],
    /// [`Pulses`], [`Noise`] and so on says.
    pub fn build<const N: usize, A: Tip<N> + Clone>(&self, arm: &A) -> Result<Push<N, A>> {
        match self {
            Self::Wrench(wrench) => {
                Ok(Push::Tip(Box::new(Wrench::new(arm.clone(), wrench.build()?))))
            }
            signal => Ok(Push::Joints(Box::new(signal.signal()?))),
        }
    }

    /// As values over time.
    ///
    /// # Errors
    /// The same; naming `curve` for a wrench.
    pub fn signal<const N: usize>(&self) -> Result<Signal<N>> {
        match (self, self.curve()) {
            (_, Some(curve)) => curve.build().map(Signal::Curve),
            (Self::Pulses(pulses), _) => pulses.build().map(Signal::Pulses),
            (Self::Noise(noise), _) => noise.build().map(Signal::Noise),
            _ => Err(Error::out_of_range("curve", 1.0, "no wrench within a wrench")),
        }
    }

    /// The curve, if it is one.
    pub fn curve(&self) -> Option<CurveSettings> {
        match self {
            Self::Sines(sines) => Some(CurveSettings::Sines(sines.clone())),
            Self::Quintic(quintic) => Some(CurveSettings::Quintic(quintic.clone())),
            Self::Table(table) => Some(CurveSettings::Table(table.clone())),
            Self::Waypoints(waypoints) => Some(CurveSettings::Waypoints(waypoints.clone())),
            Self::Pulses(_) | Self::Noise(_) | Self::Wrench(_) => None,
        }
    }

    /// Its name, as in a file.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Sines(_) => "sines",
            Self::Quintic(_) => "quintic",
            Self::Table(_) => "table",
            Self::Waypoints(_) => "waypoints",
            Self::Pulses(_) => "pulses",
            Self::Noise(_) => "noise",
            Self::Wrench(_) => "wrench",
        }
    }

    /// The joint count that it is for; `None`: any.
    ///
    /// # Errors
    /// `WrongLength`, naming a parameter that does not go with the ones before.
    pub fn joints(&self) -> Result<Option<usize>> {
        match (self, self.curve()) {
            (_, Some(curve)) => curve.joints(),
            (Self::Pulses(pulses), _) => Ok(pulses.torque.columns()),
            (Self::Noise(noise), _) => Ok(noise.deviation.count()),
            (Self::Wrench(wrench), _) => wrench.build().map(|_| None),
            _ => Ok(None),
        }
    }
}

/// All that pushes an arm: one thing, or a list of them, which add up.
#[derive(Clone, Debug, PartialEq)]
pub struct DisturbanceSettings(pub Vec<PushSettings>);

impl<T: Into<PushSettings>> From<T> for DisturbanceSettings {
    fn from(one: T) -> Self {
        Self(vec![one.into()])
    }
}

impl Serialize for DisturbanceSettings {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        if let [one] = &self.0[..] {
            one.serialize(serializer)
        } else {
            self.0.serialize(serializer)
        }
    }
}

impl<'de> Deserialize<'de> for DisturbanceSettings {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        deserializer.deserialize_any(OneOrMore)
    }
}

struct OneOrMore;

impl<'de> Visitor<'de> for OneOrMore {
    type Value = DisturbanceSettings;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a disturbance or a list of them")
    }

    fn visit_map<M: MapAccess<'de>>(
        self,
        mut map: M,
    ) -> std::result::Result<Self::Value, M::Error> {
        let push = PushSettings::deserialize(MapAccessDeserializer::new(&mut map))?;
        match map.next_key::<String>()? {
            None => Ok(push.into()),
            Some(key) => Err(M::Error::custom(format!(
                "got {key:?} beside {:?}, wants one kind; [[disturbance]] makes a list of them",
                push.name()
            ))),
        }
    }

    fn visit_seq<S: SeqAccess<'de>>(self, list: S) -> std::result::Result<Self::Value, S::Error> {
        Vec::deserialize(SeqAccessDeserializer::new(list)).map(DisturbanceSettings)
    }
}

/// Parameters of [`Pulses`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PulsesSettings {
    /// When they begin \[s\]: one, or K.
    pub time: PerJoint,
    /// Heights \[N·m\]: for one time a number or one a joint, for K of them K lists.
    pub torque: Numbers,
    /// How long they last \[s\], one for all or K; infinity for steps.
    #[serde(default = "without_end")]
    pub duration: PerJoint,
    /// How they rise and fall.
    #[serde(default)]
    pub shape: ShapeName,
}

fn without_end() -> PerJoint {
    f64::INFINITY.into()
}

/// [`Shape`] by its name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ShapeName {
    /// `"rectangle"`.
    #[default]
    Rectangle,
    /// `"half_sine"`.
    HalfSine,
}

impl ShapeName {
    /// Its name.
    pub fn name(self) -> &'static str {
        if self == Self::Rectangle { "rectangle" } else { "half_sine" }
    }
}

impl PulsesSettings {
    /// The pulses for `N` joints.
    ///
    /// # Errors
    /// As [`Pulses::new`], naming `time`, `torque` or `duration`; `WrongLength`.
    pub fn build<const N: usize>(&self) -> Result<Pulses<N, Vec<Pulse<N>>>> {
        let times = self.time.as_slice();
        let torques = rows("torque", &self.torque, &self.time, TORQUES)?;
        if let Some(count) = self.duration.count() {
            length("duration", count, times.len())?;
        }
        let pulse = |(k, (&time, torque)): (usize, (&f64, &PerJoint))| {
            let torque = torque.each("torque")?;
            Ok(Pulse { time, duration: self.duration.of_joint(k), torque })
        };
        let pulses = times.iter().zip(&torques).enumerate().map(pulse);
        let shape = match self.shape {
            ShapeName::Rectangle => Shape::Rectangle,
            ShapeName::HalfSine => Shape::HalfSine,
        };
        Pulses::new(pulses.collect::<Result<_>>()?, shape)
    }
}

/// What is wanted of heights for one time, and for several.
const TORQUES: [&str; 2] = [
    "no rows: a number or one a joint, as the time is one number",
    "a list of lists: one row of heights for each time",
];

/// Parameters of [`Noise`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NoiseSettings {
    /// Standard deviation \[N·m\].
    pub deviation: PerJoint,
    /// Cut-off of the filter \[Hz\].
    pub cutoff: f64,
    /// Seed of the generator.
    #[serde(default)]
    pub seed: u64,
}

impl NoiseSettings {
    /// The noise for `N` joints.
    ///
    /// # Errors
    /// As [`Noise::new`]; `WrongLength`.
    pub fn build<const N: usize>(&self) -> Result<Noise<N>> {
        Noise::new(self.deviation.each("deviation")?, self.cutoff, self.seed)
    }
}

/// Parameters of a [`Wrench`]: constant, or a curve of six values.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WrenchSettings {
    /// Force on the tip in the axes of the base \[N\]; none by default.
    #[serde(default)]
    pub force: Option<[f64; 3]>,
    /// Moment on the tip \[N·m\]; none by default.
    #[serde(default)]
    pub moment: Option<[f64; 3]>,
    /// Both over time, in place of constants: six columns.
    #[serde(default)]
    pub curve: Option<Box<PushSettings>>,
}

impl WrenchSettings {
    /// Force and moment over time.
    ///
    /// # Errors
    /// `NotFinite` naming `force` or `moment`; `OutOfRange` naming `curve` if it is given beside
    /// them, or is a wrench; or as the curve says.
    pub fn build(&self) -> Result<Signal<6>> {
        let constant = self.force.is_some() || self.moment.is_some();
        match &self.curve {
            Some(_) if constant => {
                let wanted = "none beside force and moment, which are constant";
                Err(Error::out_of_range("curve", 1.0, wanted))
            }
            Some(curve) => curve.signal(),
            None => {
                let [force, moment] = [self.force, self.moment].map(Option::unwrap_or_default);
                finite("force", &force)?;
                finite("moment", &moment)?;
                let [x, y, z] = force;
                let [a, b, c] = moment;
                Ok(Signal::Curve(Curve::Sines(Sines::new([x, y, z, a, b, c], Vec::new())?)))
            }
        }
    }
}

//! Curves over time, for references and disturbances: sums of sines, quintics, tables, waypoints.

use serde::{Deserialize, Serialize};

use super::numbers::{Numbers, PerJoint, agreed};
use crate::error::{Error, Problem, Result, length};
use crate::math::{Vector, part};
use crate::plant::Disturbance;
use crate::reference::{
    Harmonic, MotionLimits, Quintic, Reference, Setpoint, Sines, Table, Waypoints,
};

/// A curve over time of `N` joints: a motion, or a disturbance.
#[derive(Clone, Debug, PartialEq)]
pub enum Curve<const N: usize> {
    /// A sum of sines.
    Sines(Sines<N, Vec<Harmonic<N>>>),
    /// Point to point.
    Quintic(Quintic<N>),
    /// Samples.
    Table(Table<N, Vec<f64>>),
    /// Through poses.
    Waypoints(Waypoints<N>),
}

impl<const N: usize> Disturbance<N> for Curve<N> {
    fn is_same(&self, other: &Self) -> bool {
        self == other
    }

    #[inline]
    fn torque(&self, _: &Vector<N>, _: &Vector<N>, t: f64) -> Vector<N> {
        part::<N, _>(|| match self {
            Self::Sines(sines) => sines.disturbance(t),
            motion => motion.at(t).q,
        })
    }

    #[inline(always)]
    fn at_time(&self, t: f64) -> Option<Vector<N>> {
        Some(self.torque(&Vector::zeros(), &Vector::zeros(), t))
    }
}

impl<const N: usize> Reference<N> for Curve<N> {
    #[inline(always)]
    fn at(&self, t: f64) -> Setpoint<N> {
        part::<N, _>(|| match self {
            Self::Sines(sines) => sines.at(t),
            Self::Quintic(quintic) => quintic.at(t),
            Self::Table(table) => table.at(t),
            Self::Waypoints(waypoints) => waypoints.at(t),
        })
    }
}

/// A curve over time of any joint count.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CurveSettings {
    /// A sum of sines.
    Sines(SinesSettings),
    /// Point to point.
    Quintic(QuinticSettings),
    /// Samples.
    Table(TableSettings),
    /// Through poses.
    Waypoints(WaypointsSettings),
}

impl CurveSettings {
    /// The motion of `N` joints.
    ///
    /// # Errors
    /// Naming the parameter: it is of another joint count, or as the motion's own constructor says.
    pub fn build<const N: usize>(&self) -> Result<Curve<N>> {
        match self {
            Self::Sines(sines) => sines.build().map(Curve::Sines),
            Self::Quintic(quintic) => quintic.build().map(Curve::Quintic),
            Self::Table(table) => table.build().map(Curve::Table),
            Self::Waypoints(waypoints) => waypoints.build().map(Curve::Waypoints),
        }
    }

    /// Its name, as in a file.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Sines(_) => "sines",
            Self::Quintic(_) => "quintic",
            Self::Table(_) => "table",
            Self::Waypoints(_) => "waypoints",
        }
    }

    /// The joint count that it is for; `None`: any.
    ///
    /// # Errors
    /// `WrongLength`, naming a parameter that does not go with the ones before.
    pub fn joints(&self) -> Result<Option<usize>> {
        let found = match self {
            Self::Sines(SinesSettings { sin, cos, offset, .. }) => {
                let columns = |rows: &Option<Numbers>| rows.as_ref().and_then(Numbers::columns);
                vec![("sin", columns(sin)), ("cos", columns(cos)), ("offset", offset.count())]
            }
            Self::Quintic(QuinticSettings { start, goal, .. }) => {
                vec![("start", start.count()), ("goal", goal.count())]
            }
            Self::Table(TableSettings { q, .. }) => vec![("q", q.first().map(Vec::len))],
            Self::Waypoints(waypoints) => waypoints.counts(),
        };
        found.into_iter().try_fold(None, agreed)
    }
}

/// Parameters of [`Sines`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SinesSettings {
    /// ω \[rad/s\]: one, or K.
    pub frequency: PerJoint,
    /// Amplitudes of the sines: for one frequency a number or one a joint, for K of them K lists.
    #[serde(default)]
    pub sin: Option<Numbers>,
    /// Of the cosines.
    #[serde(default)]
    pub cos: Option<Numbers>,
    /// The constant part.
    #[serde(default = "zero")]
    pub offset: PerJoint,
    /// When it starts \[s\]; at all times without.
    #[serde(default)]
    pub start_time: Option<f64>,
}

fn zero() -> PerJoint {
    0.0.into()
}

impl SinesSettings {
    /// No amplitudes, no constant part.
    pub fn new(frequency: PerJoint) -> Self {
        Self { frequency, sin: None, cos: None, offset: zero(), start_time: None }
    }

    /// The sum for `N` joints.
    ///
    /// # Errors
    /// As [`Sines::new`], naming `frequency`, `sin`, `cos` or `offset`; `WrongLength`.
    pub fn build<const N: usize>(&self) -> Result<Sines<N, Vec<Harmonic<N>>>> {
        let [sin, cos] = [self.rows("sin", &self.sin)?, self.rows("cos", &self.cos)?];
        let frequencies = self.frequency.as_slice().iter().zip(sin.iter().zip(&cos));
        let harmonics = frequencies.map(|(&frequency, (sin, cos))| {
            Ok(Harmonic { frequency, sin: sin.each("sin")?, cos: cos.each("cos")? })
        });
        let harmonics = harmonics.collect::<Result<Vec<_>>>()?;
        let sines = Sines::new(self.offset.each("offset")?, harmonics).map_err(|error| {
            let name = error.parameter();
            error.named(name.strip_prefix("harmonics.").unwrap_or(name))
        })?;
        match self.start_time {
            None => Ok(sines),
            Some(start) => sines.starting_at(start),
        }
    }

    /// Amplitudes, an entry a frequency.
    fn rows(&self, name: &'static str, amplitudes: &Option<Numbers>) -> Result<Vec<PerJoint>> {
        match amplitudes {
            None => Ok(vec![zero(); self.frequency.as_slice().len()]),
            Some(amplitudes) => rows(name, amplitudes, &self.frequency, AMPLITUDES),
        }
    }
}

/// What is wanted of amplitudes for one frequency, and for several.
const AMPLITUDES: [&str; 2] = [
    "no rows: a number or one a joint, as the frequency is one number",
    "a list of lists: one row of amplitudes for each frequency",
];

/// Values of the joints for each entry of a list: as they are for a single entry, else a row each.
pub(super) fn rows(
    name: &'static str,
    values: &Numbers,
    list: &PerJoint,
    [wanted_of_one, wanted_of_more]: [&'static str; 2],
) -> Result<Vec<PerJoint>> {
    match (values, list) {
        (Numbers::Same(values), PerJoint::All(_)) => Ok(vec![values.clone()]),
        (Numbers::Rows(rows), PerJoint::Each(list)) => {
            length(name, rows.len(), list.len())?;
            Ok(rows.iter().cloned().map(PerJoint::Each).collect())
        }
        (Numbers::Rows(rows), PerJoint::All(_)) => {
            Err(Error::out_of_range(name, rows.len() as f64, wanted_of_one))
        }
        (Numbers::Same(values), PerJoint::Each(_)) => {
            Err(Error::out_of_range(name, values.as_slice().len() as f64, wanted_of_more))
        }
    }
}

impl<const N: usize, T: AsRef<[Harmonic<N>]>> From<&Sines<N, T>> for SinesSettings {
    fn from(sines: &Sines<N, T>) -> Self {
        let harmonics = sines.harmonics();
        let rows = |of: fn(&Harmonic<N>) -> &[f64; N]| {
            Some(Numbers::Rows(harmonics.iter().map(|harmonic| of(harmonic).to_vec()).collect()))
        };
        let frequency = PerJoint::Each(harmonics.iter().map(|it| it.frequency).collect());
        let (sin, cos) = (rows(|it| &it.sin), rows(|it| &it.cos));
        let offset = PerJoint::Each(sines.offset().as_slice().to_vec());
        Self { frequency, sin, cos, offset, start_time: sines.start_time() }
    }
}

/// Parameters of [`Quintic`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct QuinticSettings {
    /// Where it starts \[rad\].
    pub start: PerJoint,
    /// Where it ends \[rad\].
    pub goal: PerJoint,
    /// How long it takes \[s\].
    pub duration: f64,
    /// When it leaves \[s\].
    #[serde(default)]
    pub start_time: f64,
}

impl QuinticSettings {
    /// The motion of `N` joints.
    ///
    /// # Errors
    /// As [`Quintic::new`]; `WrongLength`.
    pub fn build<const N: usize>(&self) -> Result<Quintic<N>> {
        let Self { start, goal, duration, start_time } = self;
        Quintic::new(start.each("start")?, goal.each("goal")?, *start_time, *duration)
    }
}

/// Parameters of [`Table`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TableSettings {
    /// Times of the samples \[s\], increasing.
    pub t: Vec<f64>,
    /// Positions \[rad\], a list a sample.
    pub q: Vec<Vec<f64>>,
    /// Velocities \[rad/s\], with the accelerations or not at all.
    #[serde(default)]
    pub dq: Option<Vec<Vec<f64>>>,
    /// Accelerations \[rad/s²\], with the velocities or not at all.
    #[serde(default)]
    pub ddq: Option<Vec<Vec<f64>>>,
    /// When it is at the first sample \[s\]; by default when that says.
    #[serde(default)]
    pub start_time: Option<f64>,
}

impl TableSettings {
    /// The motion of `N` joints.
    ///
    /// # Errors
    /// As [`Table::new`] or [`Table::from_positions`]; `WrongLength`, naming `q`, `dq` or `ddq`
    /// with the sample.
    pub fn build<const N: usize>(&self) -> Result<Table<N, Vec<f64>>> {
        let table = self.samples::<N>()?;
        match self.start_time {
            None => Ok(table),
            Some(start) => table.starting_at(start),
        }
    }

    /// The samples, at their own times.
    fn samples<const N: usize>(&self) -> Result<Table<N, Vec<f64>>> {
        let q = flat::<N>("q", &self.q)?;
        match (&self.dq, &self.ddq) {
            (None, None) => Table::from_positions(&self.t, &q),
            (dq, ddq) => {
                let rows = |name, rows: &Option<_>| flat::<N>(name, rows.as_deref().unwrap_or(&[]));
                Table::new(self.t.clone(), q, rows("dq", dq)?, rows("ddq", ddq)?)
            }
        }
        .map_err(|error| match error.problem() {
            // Lengths and positions are of rows here.
            Problem::WrongLength { got, wanted } if error.parameter() != "t" => {
                Error::wrong_length(error.parameter(), got / N, wanted / N)
            }
            _ if error.parameter() != "t" => error.at(error.index().map(|i| i / N)),
            _ => error,
        })
    }
}

/// Parameters of [`Waypoints`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WaypointsSettings {
    /// Positions \[rad\], a list a pose.
    pub poses: Vec<Vec<f64>>,
    /// Largest velocity \[rad/s\].
    pub velocity: PerJoint,
    /// Largest acceleration \[rad/s²\].
    pub acceleration: PerJoint,
    /// Largest jerk \[rad/s³\].
    pub jerk: PerJoint,
    /// How long it rests at the poses between the first and the last \[s\]: one, or one a pose.
    #[serde(default = "zero")]
    pub pause: PerJoint,
    /// When it leaves \[s\].
    #[serde(default)]
    pub start_time: f64,
}

impl WaypointsSettings {
    /// The motion of `N` joints.
    ///
    /// # Errors
    /// As [`Waypoints::new`]; `WrongLength`, naming `poses` with the pose, or a limit.
    pub fn build<const N: usize>(&self) -> Result<Waypoints<N>> {
        let Self { poses, velocity, acceleration, jerk, pause, start_time } = self;
        let row = |(k, pose): (usize, &Vec<f64>)| {
            let pose = <[f64; N]>::try_from(pose.as_slice());
            pose.map_err(|_| Error::wrong_length("poses", poses[k].len(), N).at(k))
        };
        let rows = poses.iter().enumerate().map(row).collect::<Result<Vec<_>>>()?;
        let limits = MotionLimits {
            velocity: velocity.each("velocity")?,
            acceleration: acceleration.each("acceleration")?,
            jerk: jerk.each("jerk")?,
        };
        Waypoints::new(&rows, &limits, pause.as_slice(), *start_time)
    }

    /// The joint counts that its parameters are for.
    fn counts(&self) -> Vec<(&'static str, Option<usize>)> {
        let Self { poses, velocity, acceleration, jerk, .. } = self;
        let limits = [("velocity", velocity), ("acceleration", acceleration), ("jerk", jerk)];
        let limits = limits.into_iter().map(|(name, limit)| (name, limit.count()));
        core::iter::once(("poses", poses.first().map(Vec::len))).chain(limits).collect()
    }
}

/// Rows of `N` numbers, one after the other.
fn flat<const N: usize>(name: &'static str, rows: &[Vec<f64>]) -> Result<Vec<f64>> {
    for (k, row) in rows.iter().enumerate() {
        length(name, row.len(), N).map_err(|error| error.at(k))?;
    }
    Ok(rows.concat())
}

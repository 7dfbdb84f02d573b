//! From pose to pose, with pauses: each move is a straight line in the joints, as fast as the
//! limits on velocity, acceleration and jerk of all of them allow,
//!
//! ```text
//! q_d = qₖ + (qₖ₊₁ − qₖ) s(t − tₖ)
//! ```
//!
//! where s goes from 0 to 1 in seven phases of constant jerk.

use super::profile::{Most, Profile};
use super::{Reference, Setpoint};
use crate::error::{Error, Result, at_most, finite, length, non_negative, positive, within};
use crate::math::Vector;

/// Most poses of a motion.
pub const MAX_POSES: usize = 1 << 16;

const TOO_FAR: &str =
    "a move that takes finite time within the limits, and whose phases differ less in length";

/// What the joints may do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionLimits<const N: usize> {
    /// Largest |q̇| [rad/s], > 0.
    pub velocity: [f64; N],
    /// Largest |q̈| [rad/s²], > 0.
    pub acceleration: [f64; N],
    /// Largest |d³q/dt³| [rad/s³], > 0.
    pub jerk: [f64; N],
}

/// A motion through poses. It stands still at the first one until it starts, rests at every pose,
/// for no longer than an instant without a pause, and stands still at the last one.
///
/// The joints start and arrive together, and at every moment of a move one of them is at one of its
/// limits. Velocity and acceleration are continuous. Evaluation takes log₂(poses) comparisons.
///
/// ```
/// use steadyarm::math::Vector;
/// use steadyarm::reference::{MotionLimits, Reference, Waypoints};
///
/// let limits = MotionLimits { velocity: [1.0, 2.0], acceleration: [4.0; 2], jerk: [40.0; 2] };
/// let poses = [[0.0, 0.0], [1.0, -0.5], [0.2, 0.3]];
/// let path = Waypoints::new(&poses, &limits, &[0.5], 1.0)?;
/// assert_eq!(path.at(0.0).q, Vector::from(poses[0]));
/// assert_eq!(path.at(path.end()).q, Vector::from(poses[2]));
/// # Ok::<(), steadyarm::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Waypoints<const N: usize> {
    poses: Vec<Vector<N>>,
    /// One less than poses.
    moves: Vec<Move>,
}

/// From one pose to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Move {
    /// When it starts and when it ends \[s\].
    start: f64,
    end: f64,
    profile: Profile,
}

impl<const N: usize> Waypoints<N> {
    /// Through `poses` \[rad\], leaving the first one at `start_time` \[s\]. `pause` is how long it
    /// rests at the poses between the first and the last \[s\]: one number, or one a pose.
    ///
    /// # Errors
    /// `OutOfRange` naming `poses` for fewer than two (got = their number), and for a pose (index)
    /// that is too far; `TooMany` for more than [`MAX_POSES`]; `OutOfRange` naming `velocity`,
    /// `acceleration` or `jerk` for a limit that is not > 0, `pause` for one that is not ≥ 0;
    /// `WrongLength` naming `pause`; `NotFinite` naming any of them (`poses` with the pose) or
    /// `start_time`.
    pub fn new(
        poses: &[[f64; N]],
        limits: &MotionLimits<N>,
        pause: &[f64],
        start_time: f64,
    ) -> Result<Self> {
        check_poses(poses)?;
        positive("velocity", &limits.velocity)?;
        positive("acceleration", &limits.acceleration)?;
        positive("jerk", &limits.jerk)?;
        non_negative("pause", pause)?;
        let between = poses.len() - 2;
        if pause.len() != 1 {
            length("pause", pause.len(), between)?;
        }
        finite("start_time", &[start_time])?;
        let (mut moves, mut start) = (Vec::with_capacity(between + 1), start_time);
        for (k, pair) in poses.windows(2).enumerate() {
            let most = most(&pair[0], &pair[1], limits);
            let profile = most.map_or(Some(Profile::NONE), |most| Profile::fastest(&most));
            let profile = profile.ok_or_else(|| too_far(poses, k + 1))?;
            let end = start + profile.duration;
            if !end.is_finite() {
                return Err(too_far(poses, k + 1));
            }
            moves.push(Move { start, end, profile });
            start = end + pause.get(k).or(pause.first()).unwrap_or(&0.0);
        }
        Ok(Self { poses: poses.iter().map(|pose| (*pose).into()).collect(), moves })
    }

    /// How long it takes from the start to the last pose \[s\].
    pub fn duration(&self) -> f64 {
        self.end() - self.moves[0].start
    }

    /// When it arrives at the last pose \[s\].
    pub fn end(&self) -> f64 {
        self.moves[self.moves.len() - 1].end
    }

    /// When it arrives at each pose \[s\]; at the first one that is when it leaves.
    pub fn arrivals(&self) -> impl Iterator<Item = f64> {
        core::iter::once(self.moves[0].start).chain(self.moves.iter().map(|made| made.end))
    }
}

impl<const N: usize> Reference<N> for Waypoints<N> {
    #[inline]
    fn at(&self, t: f64) -> Setpoint<N> {
        if t.is_nan() {
            let lost = Vector::repeat(t);
            return Setpoint { q: lost, dq: lost, ddq: lost };
        }
        let k = self.moves.partition_point(|made| made.start <= t).saturating_sub(1);
        let (from, to, Move { start, end, profile }) =
            (self.poses[k], self.poses[k + 1], &self.moves[k]);
        if t < *start {
            return Setpoint::at_rest(from);
        }
        if t >= *end {
            return Setpoint::at_rest(to);
        }
        let ([s, ds, dds], way) = (profile.at(t - start), to - from);
        Setpoint { q: from + way * s, dq: way * ds, ddq: way * dds }
    }
}

fn check_poses<const N: usize>(poses: &[[f64; N]]) -> Result<()> {
    within("poses", &[poses.len() as f64], |count| count >= 2.0, "at least 2 poses")?;
    at_most("poses", poses.len(), MAX_POSES)?;
    for (k, pose) in poses.iter().enumerate() {
        finite("poses", pose).map_err(|error| error.at(k))?;
    }
    Ok(())
}

/// The limits of a move, of all joints together; `None` where none of them moves.
fn most<const N: usize>(from: &[f64; N], to: &[f64; N], limits: &MotionLimits<N>) -> Option<Most> {
    let least = |limits: &[f64; N]| {
        let allowed = (0..N).map(|i| limits[i] / (to[i] - from[i]).abs());
        allowed.fold(f64::INFINITY, f64::min)
    };
    let moves = (0..N).any(|i| to[i] != from[i]);
    moves.then(|| Most {
        velocity: least(&limits.velocity),
        acceleration: least(&limits.acceleration),
        jerk: least(&limits.jerk),
    })
}

/// The largest way of a joint to this pose is refused.
fn too_far<const N: usize>(poses: &[[f64; N]], pose: usize) -> Error {
    let ways = (0..N).map(|i| (poses[pose][i] - poses[pose - 1][i]).abs());
    Error::out_of_range("poses", ways.fold(0.0, f64::max), TOO_FAR).at(pose)
}

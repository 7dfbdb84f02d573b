//! Whether a reference stays within an arm's limits, before it runs: positions, speeds, and the
//! torque that a motion without error takes, `τ = M(q_d) q̈_d + H(q_d, q̇_d)`.

use core::fmt;

use crate::arm::{Arm, JointKind, Serial};
use crate::error::{Result, finite, positive, within};
use crate::math::Vector;
use crate::reference::{Reference, Setpoint};

/// A limit is kept by what exceeds it by this share, or a position by this much [rad or m], which
/// is rounding.
const ROUNDING: f64 = 1e-9;

/// Most times that are looked at: a few seconds of work.
const MOST_TIMES: f64 = 1e7;

/// Which of a joint's limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bound {
    /// Smallest and largest position [rad or m].
    Position,
    /// Largest speed [rad/s or m/s].
    Velocity,
    /// Largest torque [N·m] or force \[N\].
    Effort,
}

impl Bound {
    /// All of them, in order.
    pub const ALL: [Self; 3] = [Self::Position, Self::Velocity, Self::Effort];

    /// "position", "velocity" or "effort".
    pub const fn name(self) -> &'static str {
        match self {
            Self::Position => "position",
            Self::Velocity => "velocity",
            Self::Effort => "effort",
        }
    }

    /// The unit that it has for a joint of this kind.
    pub const fn unit(self, kind: JointKind) -> &'static str {
        match (self, kind.turns()) {
            (Self::Position, true) => "rad",
            (Self::Velocity, true) => "rad/s",
            (Self::Effort, true) => "N m",
            (Self::Position, false) => "m",
            (Self::Velocity, false) => "m/s",
            (Self::Effort, false) => "N",
        }
    }
}

/// A limit that a reference exceeds, where it does so most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Excess {
    /// Joint, from 0.
    pub joint: usize,
    /// How it moves.
    pub kind: JointKind,
    /// Which limit.
    pub bound: Bound,
    /// The limit.
    pub limit: f64,
    /// What the reference asks for.
    pub value: f64,
    /// When it does so \[s\].
    pub time: f64,
    /// When it first exceeds the limit \[s\].
    pub first: f64,
}

impl Excess {
    /// By how much: |value − limit|, for velocity and effort |value| − limit.
    pub fn by(&self) -> f64 {
        match self.bound {
            Bound::Position => (self.value - self.limit).abs(),
            _ => self.value.abs() - self.limit,
        }
    }
}

impl fmt::Display for Excess {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { bound, limit, value, time, first, .. } = *self;
        let unit = bound.unit(self.kind);
        write!(
            f,
            "{} {value:.4} {unit} at t = {time:.4} s, {:.4} beyond the limit of {limit:.4}",
            bound.name(),
            self.by()
        )?;
        if bound != Bound::Position {
            write!(f, " ({:.3} times)", value.abs() / limit)?;
        }
        if first < time { write!(f, ", from t = {first:.4} s on") } else { Ok(()) }
    }
}

/// What a reference exceeds of an arm's limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitCheck<const N: usize> {
    worst: [[Option<Excess>; 3]; N],
}

impl<const N: usize> LimitCheck<N> {
    /// The limits that are exceeded, joint after joint.
    pub fn excesses(&self) -> impl Iterator<Item = &Excess> {
        self.worst.iter().flatten().flatten()
    }

    /// True if none is.
    pub fn is_within(&self) -> bool {
        self.excesses().next().is_none()
    }

    fn look(&mut self, arm: &Serial<N>, setpoint: &Setpoint<N>, time: f64) -> Result<()> {
        let Setpoint { q, dq, ddq } = setpoint;
        // Stops push beyond the ends only, where the position is reported.
        let tau: Vector<N> = arm.inverse_dynamics(q, dq, ddq) - arm.stops(q, dq);
        for values in [q, dq, ddq, &tau] {
            finite("reference", values.as_slice())?;
        }
        for (joint, link) in arm.links().iter().enumerate() {
            let limits = link.limits;
            let end = if q[joint] > limits.upper { limits.upper } else { limits.lower };
            let beyond = (q[joint] - limits.upper).max(limits.lower - q[joint]);
            let asked = [
                (Bound::Position, q[joint], end, beyond),
                (Bound::Velocity, dq[joint], limits.velocity, dq[joint].abs() - limits.velocity),
                (Bound::Effort, tau[joint], limits.effort, tau[joint].abs() - limits.effort),
            ];
            for (worst, (bound, value, limit, beyond)) in self.worst[joint].iter_mut().zip(asked) {
                let size = if bound == Bound::Position { limit.abs().max(1.0) } else { limit };
                let known = worst.map_or(ROUNDING * size, |known| known.by());
                // An infinite limit is never exceeded, and would give NaN.
                if limit.is_finite() && beyond > known {
                    let first = worst.map_or(time, |known| known.first);
                    let kind = link.kind;
                    *worst = Some(Excess { joint, kind, bound, limit, value, time, first });
                }
            }
        }
        Ok(())
    }
}

/// What `reference` exceeds of the arm's [limits](Serial::limits), and where it does so most.
///
/// It is looked at when t = 0, `dt`, 2 `dt` … and last at `duration` \[s\], not between these
/// times.
///
/// # Errors
/// `NotFinite` or `OutOfRange`, naming `duration`, `dt`, or `reference` with the joint where it, or
/// the torque that it takes, is not finite.
pub fn check_limits<const N: usize>(
    arm: &Serial<N>,
    reference: &impl Reference<N>,
    duration: f64,
    dt: f64,
) -> Result<LimitCheck<N>> {
    within("duration", &[duration], |x| x >= 0.0, "a number >= 0")?;
    positive("dt", &[dt])?;
    let few = |dt: f64| duration / dt <= MOST_TIMES;
    within("dt", &[dt], few, "at least the duration / 1e7")?;
    let mut check = LimitCheck { worst: [[None; 3]; N] };
    let mut k = 0_u32;
    loop {
        let time = (f64::from(k) * dt).min(duration);
        check.look(arm, &reference.at(time), time)?;
        if time >= duration {
            return Ok(check);
        }
        k += 1;
    }
}

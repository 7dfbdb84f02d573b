//! How well the steps of a run follow the motion: the sum of their estimated errors, and what they could not follow.

use core::fmt;

use super::stiff::{Lost, Moved};
use crate::math::Vector;

/// A run whose steps are off by more than this in sum is told so [rad or m].
const MOST_ERROR: f64 = 1e-3;

/// A run that diverges did so for its steps if one of them was off by more than this share of the way that it went, when the
/// sum passed the bound above. What really runs away is followed well until it is far away.
const ASTRAY: f64 = 0.01;

/// Why a run should not be believed: its step is too long.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Doubt {
    /// The step [s].
    pub dt: f64,
    /// When it was worst [s], and for which joint.
    pub t: f64,
    /// The joint.
    pub joint: usize,
    /// What the step is too long for.
    pub coarse: Coarse,
}

/// What a step is too long for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Coarse {
    /// The motion: estimated errors of the position [rad or m].
    Motion {
        /// The largest of one step.
        largest: f64,
        /// The sum over all steps, of the joint for which that is largest.
        sum: f64,
    },
    /// The bounce of a joint in its stop.
    Bounce,
    /// Friction, which was not solved to the end.
    Friction,
    /// Viscous friction that a sampled controller cancels: the loop adds up what the steps leave of it.
    Cancelled,
}

impl fmt::Display for Doubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { dt, t, joint, coarse } = self;
        match coarse {
            Coarse::Motion { largest, sum } => write!(
                f,
                "dt = {dt} s is too long for this motion: its steps are off by an estimated {sum:.1e} rad in sum, \
                 and by up to {largest:.1e} rad each (q[{joint}] at t = {t:.6} s)"
            ),
            Coarse::Bounce => write!(
                f,
                "dt = {dt} s is too long for the stop of q[{joint}], which it met at t = {t:.6} s: the bounce is \
                 shorter than a step"
            ),
            Coarse::Cancelled => write!(
                f,
                "dt = {dt} s is too long for the viscous friction of q[{joint}], which the controller cancels from \
                 sampled velocities (from t = {t:.6} s on): the loop adds up what the steps leave of it"
            ),
            Coarse::Friction => write!(
                f,
                "dt = {dt} s is too long: friction and stops at t = {t:.6} s were not solved to the end"
            ),
        }?;
        f.write_str("; use a smaller dt")
    }
}

/// The errors of the steps so far.
#[derive(Clone, Copy, Debug)]
pub(super) struct Resolution<const N: usize> {
    dt: f64,
    sums: Vector<N>,
    largest: f64,
    /// Where that was.
    worst: (f64, usize),
    /// Whether the steps went astray when the sum passed its bound.
    astray: Option<bool>,
    lost: Option<(f64, Lost)>,
}

impl<const N: usize> Resolution<N> {
    /// Of steps of `dt` [s].
    pub fn new(dt: f64) -> Self {
        let (sums, largest, worst) = (Vector::zeros(), 0.0, (0.0, 0));
        Self { dt, sums, largest, worst, astray: None, lost: None }
    }

    /// Adds the step that began at time `t` [s].
    #[inline]
    pub fn add(&mut self, t: f64, moved: &Moved<N>) {
        for i in 0..N {
            let error = moved.error[i].abs();
            self.sums[i] += error;
            if error > self.largest {
                (self.largest, self.worst) = (error, (t, i));
            }
        }
        if self.astray.is_none() && self.sums.max() > MOST_ERROR {
            let way = self.dt * moved.motion.dq.amax();
            self.astray = Some(moved.error.amax() > ASTRAY * way);
        }
        if self.lost.is_none() {
            self.lost = moved.lost.map(|lost| (t, lost));
        }
    }

    /// What to say of these steps if the run diverged after them.
    pub fn suspicion(&self) -> Option<Doubt> {
        self.doubt().filter(|_| self.lost.is_some() || self.astray == Some(true))
    }

    /// What to say of these steps, if anything.
    pub fn doubt(&self) -> Option<Doubt> {
        let Self { dt, largest, .. } = *self;
        match self.lost {
            Some((t, Lost::Bounce(joint))) => Some(Doubt { dt, t, joint, coarse: Coarse::Bounce }),
            Some((t, Lost::Cancelled(joint))) => {
                Some(Doubt { dt, t, joint, coarse: Coarse::Cancelled })
            }
            Some((t, Lost::Friction)) => Some(Doubt { dt, t, joint: 0, coarse: Coarse::Friction }),
            None => {
                let (sum, (t, joint)) = (self.sums.max(), self.worst);
                let coarse = Coarse::Motion { largest, sum };
                (sum > MOST_ERROR).then_some(Doubt { dt, t, joint, coarse })
            }
        }
    }
}

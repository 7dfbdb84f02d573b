//! How well the steps of a run follow the motion: the sum of their estimated errors, and what they could not follow.

use core::fmt;

use super::integrators::Motion;
use super::stiff::{Lost, Moved};
use crate::math::Vector;

/// A run whose steps are off by more than this in sum is told so [rad or m].
const MOST_ERROR: f64 = 1e-3;

/// A run that diverges did so for its steps if one of them was off by more than this share of the way that it went, the first
/// one off by more than the bound above. What really runs away is followed well until it is far away.
const ASTRAY: f64 = 0.01;

/// Why a run should not be believed: its step is too long.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Doubt {
    /// The step [s].
    pub dt: f64,
    /// When it was worst, or first noticed [s].
    pub t: f64,
    /// The joint for which.
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
    /// Stribeck's friction, which makes the joint break away within a step.
    Falling,
    /// Stiff friction that the controller cancels by a law which is no part of the plant's, another smoothing for one.
    Uncovered,
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
            Coarse::Falling => write!(
                f,
                "dt = {dt} s is too long for the friction of q[{joint}], which breaks away within a step \
                 (from t = {t:.6} s on)"
            ),
            Coarse::Uncovered => write!(
                f,
                "dt = {dt} s is too long for the friction that the controller adds for q[{joint}]: it is no part of \
                 the plant's (larger, or with another smoothing), and too stiff from t = {t:.6} s on"
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
    /// The same for steps of RK4, and h/6 times the sum of their changes of velocity.
    smooth_sums: Vector<N>,
    swing: f64,
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
        let (smooth_sums, swing) = (sums, 0.0);
        Self { dt, sums, smooth_sums, swing, largest, worst, astray: None, lost: None }
    }

    /// Adds the step from `start` at time `t` [s].
    #[inline(always)]
    pub fn add(&mut self, t: f64, start: &Motion<N>, moved: &Moved<N>) {
        let sums = if moved.stiff { &mut self.sums } else { &mut self.smooth_sums };
        for i in 0..N {
            let error = moved.error[i].abs();
            sums[i] += error;
            if error > self.largest {
                (self.largest, self.worst) = (error, (t, i));
            }
        }
        if !moved.stiff {
            self.swing += self.dt / 6.0 * (moved.motion.dq - start.dq).amax();
        }
        if self.astray.is_none() && self.largest > MOST_ERROR {
            let way = self.dt * moved.motion.dq.amax();
            self.astray = Some(moved.error.amax() > ASTRAY * way);
        }
        if self.lost.is_none() {
            self.lost = moved.lost.map(|lost| (t, lost));
        }
    }

    /// The sum of the errors of all steps, of the joint where it is largest. RK4's own error is below the estimate, which is of
    /// order 3: by about the share of the estimate in the change of velocity, as both fall with the step.
    fn sum(&self) -> f64 {
        let estimate = self.smooth_sums.max();
        let share = if self.swing > 0.0 { (estimate / self.swing).min(1.0) } else { 1.0 };
        (self.sums + self.smooth_sums * share).max()
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
            Some((t, Lost::Falling(joint))) => {
                Some(Doubt { dt, t, joint, coarse: Coarse::Falling })
            }
            Some((t, Lost::Uncovered(joint))) => {
                Some(Doubt { dt, t, joint, coarse: Coarse::Uncovered })
            }
            Some((t, Lost::Friction)) => Some(Doubt { dt, t, joint: 0, coarse: Coarse::Friction }),
            None => {
                let (sum, (t, joint)) = (self.sum(), self.worst);
                let coarse = Coarse::Motion { largest, sum };
                (sum > MOST_ERROR).then_some(Doubt { dt, t, joint, coarse })
            }
        }
    }
}

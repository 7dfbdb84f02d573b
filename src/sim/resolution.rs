//! How well the steps of a run follow the motion: the sum of their estimated errors, and what they
//! could not follow.

use super::doubt::{Coarse, Doubt};
use super::integrators::Motion;
use super::stiff::Moved;
use crate::math::Vector;

/// Steps whose errors add up to more than this [rad or m] are reported.
const MOST_ERROR: f64 = 1e-3;

/// The steps are to blame for a run that diverges if, in the first step whose error is above the
/// bound, the error is also above this share of the way. A loop that really runs away is followed
/// well until it is far away.
const ASTRAY: f64 = 0.01;

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
    /// Whether the first step whose error passed the bound went astray.
    astray: Option<bool>,
    lost: Option<(f64, (usize, Coarse))>,
}

impl<const N: usize> Resolution<N> {
    /// Of steps of `dt` \[s\].
    pub fn new(dt: f64) -> Self {
        let (sums, largest, worst) = (Vector::zeros(), 0.0, (0.0, 0));
        let (smooth_sums, swing) = (sums, 0.0);
        Self { dt, sums, smooth_sums, swing, largest, worst, astray: None, lost: None }
    }

    /// Adds the step from `start` at time `t` \[s\].
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

    /// The sum of the errors of all steps, of the joint where it is largest. RK4's own error is
    /// below the estimate, which is of order 3. It is smaller by about the share of the estimate in
    /// the change of velocity: both fall with the step.
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
            Some((t, (joint, coarse))) => Some(Doubt { dt, t, joint, coarse }),
            None => {
                let (sum, (t, joint)) = (self.sum(), self.worst);
                let coarse = Coarse::Motion { largest, sum };
                (sum > MOST_ERROR).then_some(Doubt { dt, t, joint, coarse })
            }
        }
    }
}

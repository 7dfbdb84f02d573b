//! How well the steps of a run follow the motion: the sum of their estimated errors, and what they
//! could not follow.

use nalgebra::Scalar;

use super::doubt::{Coarse, Doubt};
use super::integrators::Motion;
use super::stiff::Moved;
use crate::math::{Abreast, Real, Vector};

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
    smooth: Smooth<N>,
    largest: f64,
    /// Where that was.
    worst: (f64, usize),
    /// Whether the first step whose error passed the bound went astray.
    astray: Option<bool>,
    lost: Option<(f64, (usize, Coarse))>,
}

/// What steps of RK4 add up to, in one run or in several side by side.
#[derive(Clone, Copy, Debug)]
pub(super) struct Smooth<const N: usize, T = f64> {
    /// Their errors, and h/6 times their changes of velocity.
    pub errors: Vector<N, T>,
    pub swing: T,
}

impl<const N: usize, T: Scalar> Smooth<N, T> {
    /// No step yet; `zero` is 0.
    pub fn new(zero: T) -> Self {
        Self { errors: Vector::<N, T>::repeat(zero.clone()), swing: zero }
    }
}

impl<const N: usize, T: Real> Smooth<N, T> {
    /// Adds a step of `h` \[s\].
    #[inline(always)]
    pub fn add(&mut self, h: f64, start: &Motion<N, T>, moved: &Moved<N, T>) {
        let mut change = self.swing.like(0.0);
        for i in 0..N {
            self.errors[i] += moved.error[i].abs();
            change = change.or_larger((moved.motion.dq[i] - start.dq[i]).abs());
        }
        self.swing += self.swing.like(h / 6.0) * change;
    }
}

impl<const N: usize> Smooth<N> {
    /// RK4's own error is below the estimate, which is of order 3. It is smaller by about the share
    /// of the estimate in the change of velocity: both fall with the step.
    fn share(&self) -> f64 {
        let estimate = self.errors.max();
        if self.swing > 0.0 { (estimate / self.swing).min(1.0) } else { 1.0 }
    }
}

impl<const N: usize> Smooth<N, Abreast> {
    /// Whether what the steps of the run in this lane add up to is small enough to say nothing.
    pub fn is_resolved(&self, lane: usize) -> bool {
        let errors = Vector::<N>::from_fn(|i, _| self.errors[i].0[lane]);
        let smooth = Smooth { errors, swing: self.swing.0[lane] };
        let steps = Resolution { smooth, ..Resolution::new(0.0) };
        steps.sum() <= MOST_ERROR
    }
}

impl<const N: usize> Resolution<N> {
    /// Of steps of `dt` \[s\].
    pub fn new(dt: f64) -> Self {
        let (sums, smooth) = (Vector::zeros(), Smooth::new(0.0));
        Self { dt, sums, smooth, largest: 0.0, worst: (0.0, 0), astray: None, lost: None }
    }

    /// Adds the step from `start` at time `t` \[s\].
    #[inline(always)]
    pub fn add(&mut self, t: f64, start: &Motion<N>, moved: &Moved<N>) {
        if !moved.stiff {
            self.smooth.add(self.dt, start, moved);
        }
        for i in 0..N {
            let error = moved.error[i].abs();
            if moved.stiff {
                self.sums[i] += error;
            }
            if error > self.largest {
                (self.largest, self.worst) = (error, (t, i));
            }
        }
        if self.astray.is_none() && self.largest > MOST_ERROR {
            let way = self.dt * moved.motion.dq.amax();
            self.astray = Some(moved.error.amax() > ASTRAY * way);
        }
        if self.lost.is_none() {
            self.lost = moved.lost.map(|lost| (t, lost));
        }
    }

    /// The sum of the errors of all steps, of the joint where it is largest.
    fn sum(&self) -> f64 {
        (self.sums + self.smooth.errors * self.smooth.share()).max()
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

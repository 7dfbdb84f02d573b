//! `M (V − W) + h λ = 0`, λᵢ ∈ gᵢ(Vᵢ): the velocities V of joints that friction and stops brake,
//! from those without, W.
//!
//! V is the minimum of `½ (V − W)ᵀM(V − W) + h Σ φᵢ(Vᵢ)`, φ' = g, strictly convex where no g falls.
//! Newton's method finds it in a few steps, each shortened where it overshoots. A joint with dry
//! friction either sticks, with V = 0 exactly and |λ| at most what holds it, or slips in one
//! direction. A step ends where the first slipping joint comes to rest. When nothing else is left
//! to do, the joint whose λ is furthest beyond what holds it breaks away. Each step goes down, so
//! no set of sticking joints comes twice (an active-set method; Nocedal and Wright, Numerical
//! Optimization, 16.5). Where Stribeck friction falls there may be several solutions. The one found
//! is continued from the first guess.

use super::{Factor, Resistance};
use crate::math::{Matrix, Vector};

/// Most steps of Newton's method. If they were not enough, the run says so.
const MOST_STEPS: usize = 60;
/// Most times that a step is shortened.
const MOST_CUTS: usize = 6;
/// A step overshoots if the slope along it ends higher than this share of how low it began.
const OVERSHOOT: f64 = 0.3;
/// How far a velocity may be off, relative to itself and the speed at which friction changes.
const PRECISION: f64 = 1e-6;
/// After a step that is smaller than this, relative to the same, Newton's method is within that
/// precision: the next error is about the square of the step.
const LAST_STEP: f64 = 1e-3;
/// The speed for which that counts where friction is dry [rad/s].
const SLOW: f64 = 1e-3;
/// Friction below this share of the joint's inertia is not worth another factorisation.
const NEGLIGIBLE: f64 = 1e-9;
/// A joint breaks away above what holds it by more than rounding.
const ABOVE_ROUNDING: f64 = 1.0 + 1e-12;

/// The equation, without its W.
#[derive(Clone, Copy)]
pub(crate) struct Implicit<'a, const N: usize> {
    pub mass: &'a Matrix<N>,
    pub factor: &'a Factor<N>,
    pub laws: &'a [Resistance; N],
    /// h \[s\].
    pub h: f64,
    /// The joints are at `place + h V`.
    pub place: &'a Vector<N>,
}

/// A trial: velocities, the direction in which each joint slips (0 for one that sticks), M (V − W),
/// g and its slope.
struct Trial<const N: usize> {
    v: Vector<N>,
    sign: Vector<N>,
    push: Vector<N>,
    torque: Vector<N>,
    slope: Vector<N>,
}

impl<const N: usize> Implicit<'_, N> {
    /// V for the velocities `free` = W, from a first guess, and whether it was found.
    pub fn solve(&self, free: &Vector<N>, guess: &Vector<N>) -> (Vector<N>, bool) {
        let hold = core::array::from_fn(|i| self.laws[i].hold());
        let smooth = hold.iter().all(Option::is_none);
        let sign = guess.map(|v| if v == 0.0 { 0.0 } else { v.signum() });
        let push = self.mass * (guess - free);
        let (torque, slope) = (Vector::zeros(), Vector::zeros());
        let mut at = Trial { v: *guess, sign, push, torque, slope };
        self.evaluate(&mut at);
        for _ in 0..MOST_STEPS {
            let sticks: [bool; N] =
                core::array::from_fn(|i| at.sign[i] == 0.0 && hold[i].is_some());
            let rest =
                Vector::from_fn(
                    |i, _| {
                        if sticks[i] { 0.0 } else { at.push[i] + self.h * at.torque[i] }
                    },
                );
            if self.is_small(&at, &rest) {
                let Some((i, sign)) = self.breaks_away(&at, &hold) else {
                    return (at.v, true);
                };
                at.sign[i] = sign;
                self.evaluate(&mut at);
                continue;
            }
            let step = self.newton(&at, &rest, &sticks);
            if smooth && (0..N).all(|i| step[i].abs() <= LAST_STEP * self.speed(&at, i)) {
                return (at.v + step, true);
            }
            match first_to_rest(&at, &step, &hold) {
                (_, None) => self.walk(&mut at, &rest, &step),
                (share, Some(i)) => {
                    at.v += step * share;
                    at.push += self.mass * step * share;
                    (at.v[i], at.sign[i]) = (0.0, 0.0);
                    self.evaluate(&mut at);
                }
            };
        }
        (at.v, false)
    }

    /// g and its slope at the velocities of a trial.
    #[inline(never)]
    fn evaluate(&self, at: &mut Trial<N>) {
        for (i, law) in self.laws.iter().enumerate() {
            let (torque, slope) = law.at(at.v[i], at.sign[i], self.place[i], self.h);
            (at.torque[i], at.slope[i]) = (torque, slope);
        }
    }

    /// The joint whose λ is furthest beyond what holds it, relative to that, and the direction in
    /// which it breaks away.
    fn breaks_away(&self, at: &Trial<N>, hold: &[Option<[f64; 2]>; N]) -> Option<(usize, f64)> {
        let (mut furthest, mut found) = (ABOVE_ROUNDING, None);
        for i in 0..N {
            let Some([up, down]) = hold[i].filter(|_| at.sign[i] == 0.0) else { continue };
            let lambda = -at.push[i] / self.h;
            let (sign, beyond) =
                if lambda > 0.0 { (1.0, lambda / up) } else { (-1.0, -lambda / down) };
            if beyond > furthest {
                (furthest, found) = (beyond, Some((i, sign)));
            }
        }
        found
    }

    fn is_small(&self, at: &Trial<N>, rest: &Vector<N>) -> bool {
        (0..N).all(|i| {
            let steep = self.mass[(i, i)] + self.h * at.slope[i];
            rest[i].abs() <= PRECISION * steep * self.speed(at, i)
        })
    }

    /// The speed that counts for the precision of a joint's velocity [rad/s].
    fn speed(&self, at: &Trial<N>, i: usize) -> f64 {
        let smoothing = self.laws[i].friction.smoothing;
        at.v[i].abs() + if smoothing > 0.0 { smoothing } else { SLOW }
    }

    /// −(M + h D)⁻¹ rest, where joints that stick do not move.
    fn newton(&self, at: &Trial<N>, rest: &Vector<N>, sticks: &[bool; N]) -> Vector<N> {
        let smooth = |i: usize| !sticks[i] && self.h * at.slope[i] < NEGLIGIBLE * self.mass[(i, i)];
        if (0..N).all(smooth) {
            return -self.factor.solve(rest);
        }
        let mut steep = *self.mass;
        for i in 0..N {
            steep[(i, i)] += self.h * at.slope[i];
            if sticks[i] {
                for j in 0..N {
                    (steep[(i, j)], steep[(j, i)]) = (0.0, 0.0);
                }
                steep[(i, i)] = 1.0;
            }
        }
        -Factor::of(&steep).solve(rest)
    }

    /// Goes along `step`, less far if the whole step overshoots the minimum.
    #[inline]
    fn walk(&self, at: &mut Trial<N>, rest: &Vector<N>, step: &Vector<N>) {
        let (from, push) = (at.v, at.push);
        let (before, more) = (step.dot(rest), self.mass * step);
        let mut share = 1.0;
        for cut in 0..=MOST_CUTS {
            (at.v, at.push) = (from + step * share, push + more * share);
            self.evaluate(at);
            let slope = step.dot(&(at.push + at.torque * self.h));
            if cut == MOST_CUTS || slope <= OVERSHOOT * before.abs() {
                break;
            }
            share *= before / (before - slope);
        }
    }
}

/// The share of `step` after which the first slipping joint comes to rest, and that joint; 1 and
/// none if all go on.
fn first_to_rest<const N: usize>(
    at: &Trial<N>,
    step: &Vector<N>,
    hold: &[Option<[f64; 2]>; N],
) -> (f64, Option<usize>) {
    let mut first = (1.0, None);
    for i in 0..N {
        if hold[i].is_some() && (at.v[i] + step[i]) * at.sign[i] < 0.0 {
            let share = -at.v[i] / step[i];
            if share < first.0 {
                first = (share, Some(i));
            }
        }
    }
    first
}

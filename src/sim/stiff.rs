//! RK4 with friction and stops solved for, where RK4 alone would be unstable: five stages at c = 0,
//! ½, ½, 1, 1.
//!
//! `M(q) v̇ = r − λ`, λᵢ ∈ gᵢ(vᵢ): r and q follow RK4's own tableau, λ an implicit one. With K =
//! M⁻¹r:
//!
//! ```text
//! Qᵢ = q + h Σ aᵢⱼ Vⱼ     Wᵢ = v + h Σ (aᵢⱼ Kⱼ + āᵢⱼ Fⱼ)
//! M(Qᵢ)(Vᵢ − Wᵢ) + h āᵢᵢ λᵢ = 0     Fᵢ = (Vᵢ − Wᵢ)/(h āᵢᵢ)
//!
//! a: 1 |                              ā: 1 | 0
//!    2 | 1/2                             2 | 0  1/2
//!    3 | 0    1/2                        3 | 0  0    1/2
//!    4 | 0    0    1                     4 | 0  0    0     1
//!    5 | 1/6  1/3  1/3  1/6              5 | 0  1/2  1/2  −1    1
//! ```
//!
//! The position at the end also takes the last row of ā, h (½V₂ + ½V₃ − V₄ + V₅). Then m v + b q =
//! ∫τ dt holds for viscous friction, and a loop that cancels friction needs that. Both ends of the
//! step are stages, so a joint that sticks does not move by one bit. Without friction V = W. Joints
//! without friction take RK4's position: for them the step is RK4's.
//!
//! The order is 4, and 2 in the friction and in what it couples to. Where a step is stiff, errors
//! fall about in proportion to the step. For the friction alone 0 < R(x) < 1 for all x < 0, R →
//! 3/x², and all stages lie between 0 and 1: friction never reverses a velocity. Where a held
//! torque cancels friction, the motion depends on 1 − R. A slow decay of R to 0 would show there.
//! Nothing is remembered from one step to the next.

use super::doubt::Coarse;
use super::integrators::{Motion, RK4};
use crate::arm::{Arm, Factor, Implicit, Posed, Resistance};
use crate::control::{Law, Stage};
use crate::math::{Matrix, Real, Vector};

/// Rows 2 to 5 of ā, without their first column of zeros.
const IMPLICIT: [[f64; 4]; 4] =
    [[0.5, 0.0, 0.0, 0.0], [0.0, 0.5, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.5, 0.5, -1.0, 1.0]];

/// The last row: the weights of F₂ … F₅ in the change of the velocity.
pub(super) const FRICTION_WEIGHTS: [f64; 4] = IMPLICIT[3];

/// RK4 alone is used while h times the largest rate at which friction brakes is below this. Beyond
/// 2.78 it is unstable.
pub(super) const MOST_BRAKING: f64 = 2.0;
/// It is used while h² times the largest squared frequency of a joint in its stop is below this,
/// too.
const MOST_SPRING: f64 = 1.0;
/// Beyond this many times its smoothing, friction hardly depends on the velocity.
const STEADY: f64 = 5.0;

/// Where a step led.
#[derive(Clone, Copy, Debug)]
pub struct Moved<const N: usize, T = f64> {
    /// The motion at its end.
    pub motion: Motion<N, T>,
    /// An estimate of the error of the position \[rad\], from a method of lower order.
    pub error: Vector<N, T>,
    /// Whether friction and stops were solved for.
    pub stiff: bool,
    /// The joint that the step could not follow, and in what.
    pub(super) lost: Option<(usize, Coarse)>,
}

impl<const N: usize, T: Real> Moved<N, T> {
    /// One step of RK4 of length `h` \[s\] from `start`, where q̈ = `ddq`.
    #[inline(always)]
    pub fn by_rk4(
        h: f64,
        start: &Motion<N, T>,
        ddq: &Vector<N, T>,
        acceleration: impl FnMut(&Stage<'_>, &Motion<N, T>) -> Vector<N, T>,
    ) -> Self {
        let mut rates = [Motion { q: start.dq, dq: *ddq }; 4];
        RK4.stages(h, start, 1, &mut rates, acceleration);
        Self::of_rates(h, start, &rates)
    }

    /// Where a step of RK4 led whose stages had these rates.
    #[inline(always)]
    pub fn of_rates(h: f64, start: &Motion<N, T>, rates: &[Motion<N, T>; 4]) -> Self {
        let motion = start.plus(h, &RK4.weights, rates);
        // The method of order 3 whose last stage is the end of the step.
        let mut error = rates[3].q;
        for n in 0..N {
            error[n] = (rates[3].q[n] - motion.dq[n]) * motion.dq[n].like(h / 6.0);
        }
        Self { motion, error, stiff: false, lost: None }
    }
}

/// Whether a step of `h` \[s\] from this pose is beyond RK4 alone: `h Σ (M⁻¹)ᵢᵢ max gᵢ' > 2` for
/// friction, or `h² kᵢ (M⁻¹)ᵢᵢ > 1` for a stop. The trace bounds the largest eigenvalue of M⁻¹D.
pub(super) fn beyond_rk4<const N: usize>(
    Posed { mass, factor, .. }: &Posed<N>,
    laws: &[Resistance; N],
    h: f64,
) -> bool {
    let steepest = laws.each_ref().map(|law| law.friction.steepest());
    // (M⁻¹)ᵢᵢ is at least 1/Mᵢᵢ.
    if (0..N).any(|i| h * steepest[i] > MOST_BRAKING * mass[(i, i)]) {
        return true;
    }
    let inverse = factor.inverse_diagonal();
    let braking: f64 = (0..N).map(|i| inverse[i] * steepest[i]).sum();
    h * braking > MOST_BRAKING || (0..N).any(|i| is_hard(&inverse, &laws[i], i, h))
}

/// The same of arms without stops side by side, with these largest slopes of their friction: NaN
/// where a step is beyond RK4 alone, and 0 elsewhere.
#[inline(always)]
pub(super) fn none_beyond_rk4<const N: usize, T: Real>(
    mass: &Matrix<N, T>,
    inverse: &Vector<N, T>,
    steepest: &[T; N],
    h: f64,
) -> T {
    let zero = inverse[0].like(0.0);
    let (most, lost, mut braking, mut beyond) =
        (zero.like(MOST_BRAKING), zero.like(f64::NAN), zero, zero);
    for i in 0..N {
        let rate = zero.like(h) * steepest[i];
        beyond = (most * mass[(i, i)]).if_less(rate, lost, beyond);
        braking += inverse[i] * steepest[i];
    }
    most.if_less(zero.like(h) * braking, lost, beyond)
}

/// What opposes the motion of the plant's joints, less the friction that the controller's law
/// cancels. Where that is not part of the plant's friction, nothing is taken off: the rest would
/// drive the joint.
pub(super) fn cancelled<const N: usize>(plant: &impl Arm<N>, law: &impl Law<N>) -> [Resistance; N] {
    let mut resistances = Resistance::of(plant);
    for (joint, resistance) in resistances.iter_mut().enumerate() {
        let known = law.joint_friction(joint);
        if resistance.friction.covers(&known) {
            resistance.known = known;
        }
    }
    resistances
}

/// f̂(q̇) [N·m].
pub(super) fn known<const N: usize>(laws: &[Resistance; N], dq: &Vector<N>) -> Vector<N> {
    Vector::from_fn(|i, _| laws[i].known.torque(dq[i]))
}

/// h times the largest rate at which falling friction speeds a joint up, and that joint. Beyond 1 a
/// stage has several solutions.
pub(super) fn falling<const N: usize>(
    posed: &Posed<N>,
    laws: &[Resistance; N],
    h: f64,
) -> Option<(f64, usize)> {
    if laws.iter().all(|law| law.friction.stribeck == 0.0) {
        return None;
    }
    let inverse = posed.factor.inverse_diagonal();
    let rates = Vector::<N>::from_fn(|i, _| h * inverse[i] * laws[i].friction.falls());
    Some((rates.max(), rates.imax()))
}

/// Whether a bounce of joint `i` in its stop is shorter than a step of `h` \[s\].
fn is_hard<const N: usize>(inverse: &Vector<N>, law: &Resistance, i: usize, h: f64) -> bool {
    h * h * law.stop.stiffness * inverse[i] > MOST_SPRING
}

/// The step of length `h` \[s\] from `start`, where K₁ = `free`, and F₅.
///
/// `rate` gives Kᵢ at a stage: it is told the stage, the motion there, the arm at it, and Fᵢ.
pub(super) fn step<const N: usize, A: Arm<N>>(
    arm: &A,
    laws: &[Resistance; N],
    h: f64,
    start: &Motion<N>,
    free: &Vector<N>,
    mut rate: impl FnMut(&Stage<'_>, &Motion<N>, &Posed<N>, &Vector<N>) -> Vector<N>,
) -> (Moved<N>, Vector<N>) {
    let mut rates = [Motion::zeros(); 4];
    rates[0] = Motion { q: start.dq, dq: *free };
    let (mut braking, mut solved) = ([Vector::zeros(); 3], true);
    let mut stage = |i: usize| {
        let forward = start.plus(h, &RK4.rows[i][..i], &rates[..i]);
        let mut braked = None;
        let (mass, v, rigid) = arm.rigid_dynamics(&forward.q, &mut |mass| {
            let factor = Factor::of(mass);
            let stage = Braked { laws, h, start, rates: &rates[..i], braking: &braking[..i - 1] };
            let (v, f, found) = stage.solve(mass, &factor, &forward.dq);
            braked = Some((factor, f, found));
            v
        });
        let unsolved = || (Factor::of(&mass), Vector::zeros(), false);
        let (factor, f, found) = braked.unwrap_or_else(unsolved);
        (braking[i - 1], solved) = (f, solved && found);
        let (at, posed) = (Motion { q: forward.q, dq: v }, Posed { mass, factor, rigid });
        rates[i] = Motion { q: v, dq: rate(&RK4.stage(i, h), &at, &posed, &f) };
        posed
    };
    stage(1);
    stage(2);
    // The end uses M of the fourth stage, which is at the same time and h² away. That is an error
    // of order 3, in the friction alone.
    let Posed { mass, factor, .. } = stage(3);
    let forward = start.plus(h, &RK4.weights, &rates);
    let last = Braked { laws, h, start, rates: &rates, braking: &braking };
    let (dq, f, found) = last.solve(&mass, &factor, &forward.dq);
    let error = forward.q - start.q - (start.dq + dq) * (0.5 * h);
    let mut q = last.place() + dq * last.row().1;
    for i in (0..N).filter(|&i| laws[i].is_none()) {
        q[i] = forward.q[i];
    }
    let motion = Motion { q, dq };
    let lost = if solved && found {
        last.bounce(&factor, &motion.q).map(|joint| (joint, Coarse::Bounce))
    } else {
        Some((0, Coarse::Friction))
    };
    (Moved { motion, error, stiff: true, lost }, f)
}

/// A stage whose velocity is to be found.
struct Braked<'a, const N: usize> {
    laws: &'a [Resistance; N],
    h: f64,
    start: &'a Motion<N>,
    /// Those of the stages before.
    rates: &'a [Motion<N>],
    braking: &'a [Vector<N>],
}

impl<const N: usize> Braked<'_, N> {
    /// āᵢⱼ of the stages 2, 3, … and h āᵢᵢ.
    fn row(&self) -> (&'static [f64], f64) {
        let row = &IMPLICIT[self.braking.len()];
        (&row[..self.braking.len()], self.h * row[self.braking.len()])
    }

    /// q + h Σ āᵢⱼ Vⱼ over the stages before.
    fn place(&self) -> Vector<N> {
        let mut place = self.start.q;
        for (a, rate) in self.row().0.iter().zip(&self.rates[1..]) {
            place += rate.q * (self.h * a);
        }
        place
    }

    /// V, F, and whether they were found, from the velocity `forward` that all but friction leads
    /// to.
    fn solve(
        &self,
        mass: &Matrix<N>,
        factor: &Factor<N>,
        forward: &Vector<N>,
    ) -> (Vector<N>, Vector<N>, bool) {
        let (row, h) = self.row();
        let mut free = *forward;
        for (a, f) in row.iter().zip(self.braking) {
            free += f * (self.h * a);
        }
        let guess = self.guess(&free, h);
        let place = &self.place();
        let (v, found) = Implicit { mass, factor, laws: self.laws, h, place }.solve(&free, &guess);
        (v, (v - free) / h, found)
    }

    /// A first guess of V. Where there is no friction, or about that of the stage before, it is
    /// what that friction leads to; elsewhere it is the velocity of that stage.
    fn guess(&self, free: &Vector<N>, h: f64) -> Vector<N> {
        let before = self.rates[self.rates.len() - 1].q;
        Vector::from_fn(|i, _| {
            let law = &self.laws[i];
            let on = free[i] + self.braking.last().map_or(0.0, |f| f[i] * h);
            let fast = STEADY * law.friction.smoothing;
            let steady = before[i].abs().min(on.abs()) > fast && before[i] * on > 0.0;
            if law.is_none() || steady && !self.braking.is_empty() { on } else { before[i] }
        })
    }

    /// A joint that came into a stop whose bounce is shorter than the step.
    fn bounce(&self, factor: &Factor<N>, q: &Vector<N>) -> Option<usize> {
        let came = |i: &usize| {
            let Resistance { stop, limits, .. } = &self.laws[*i];
            !stop.is_none() && limits.contain(self.start.q[*i]) && !limits.contain(q[*i])
        };
        let came = (0..N).find(came)?;
        let inverse = factor.inverse_diagonal();
        is_hard(&inverse, &self.laws[came], came, self.h).then_some(came)
    }
}

//! Computed torque of several controllers side by side, a controller a lane.

use pulp::Simd;

use super::computed_torque::{computed, feedback};
use super::{ComputedTorque, Demand, Feedback, Gains, Sample};
use crate::arm::{Arm, ArmsAbreast};
use crate::math::{Abreast, LANES, Load, Register, Vector};

/// Laws of computed torque side by side, for many runs at a time.
#[derive(Clone, Debug)]
pub struct LawsAbreast<const N: usize> {
    arms: ArmsAbreast<N>,
    kp: [Abreast; N],
    kv: [Abreast; N],
}

impl<const N: usize> LawsAbreast<N> {
    /// These laws; `None` if what they believe of the arm cannot be put side by side.
    pub fn of<A: Arm<N>, F: Feedback<N>>(each: [&ComputedTorque<N, A, F>; LANES]) -> Option<Self> {
        let mut gains = [each[0].gains.constant()?; LANES];
        for (gains, law) in gains.iter_mut().zip(each) {
            *gains = law.gains.constant()?;
        }
        let gain = |of: fn(&Gains<N>) -> &[f64; N]| {
            core::array::from_fn(|n| Abreast::of(gains, |gains| of(gains)[n]))
        };
        let arms = A::abreast(each.map(|law| &law.arm))?;
        Some(Self { arms, kp: gain(|gains| &gains.kp), kv: gain(|gains| &gains.kv) })
    }

    /// As [`Law::torque`](super::Law::torque) of a part of them.
    #[inline(always)]
    pub(crate) fn torque<S: Simd>(
        &self,
        (simd, part): (S, usize),
        seen: &Sample<N, Register<S>>,
        rho_hat: &Vector<N, Register<S>>,
    ) -> Demand<N, Register<S>> {
        let dynamics = self.arms.mass_matrix_and_bias((simd, part), &seen.q, &seen.dq);
        let (kp, kv) = (self.kp.load(simd, part), self.kv.load(simd, part));
        computed(dynamics, feedback(&kp, &kv, seen), rho_hat)
    }
}

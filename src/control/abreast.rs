//! Controllers of eight runs side by side, a controller a lane: computed torque, and what
//! compensates.

use pulp::{Arch, Simd};

use super::computed_torque::{computed, feedback};
use super::fuzzy_compensator::PerJoint;
use super::{ComputedTorque, Demand, Feedback, Gains, Sample, Stage};
use crate::arm::{Arm, ArmsAbreast, Poses};
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

    /// What they believe of the arms.
    pub(crate) fn arms(&self) -> &ArmsAbreast<N> {
        &self.arms
    }

    /// As [`Law::torque`](super::Law::torque) of a part of them.
    #[inline(always)]
    pub(crate) fn torque<S: Simd>(
        &self,
        (simd, part): (S, usize),
        poses: &Poses<N, Register<S>>,
        seen: &Sample<N, Register<S>>,
        rho_hat: &Vector<N, Register<S>>,
    ) -> Demand<N, Register<S>> {
        let dynamics = self.arms.mass_matrix_and_bias((simd, part), poses, &seen.dq);
        let (kp, kv) = (self.kp.load(simd, part), self.kv.load(simd, part));
        computed(dynamics, feedback(&kp, &kv, seen), rho_hat)
    }
}

/// Compensators of eight runs side by side, with their states.
#[derive(Clone, Debug)]
pub struct EstimatorsAbreast<const N: usize>(Kind<N>);

#[derive(Clone, Debug)]
enum Kind<const N: usize> {
    None(Vector<N, Abreast>),
    PerJoint(Box<PerJoint<N>>),
}

impl<const N: usize> EstimatorsAbreast<N> {
    /// None at all: ρ̂ = 0.
    pub(crate) fn none() -> Self {
        Self(Kind::None(Vector::<N, Abreast>::repeat(Abreast::all(0.0))))
    }

    /// A grid a joint.
    pub(super) fn per_joint(all: PerJoint<N>) -> Self {
        Self(Kind::PerJoint(Box::new(all)))
    }

    /// ρ̂ of each at a stage; one that cannot tell it is `lost`.
    pub(crate) fn estimate(
        &mut self,
        arch: Arch,
        stage: &Stage<'_>,
        seen: &Sample<N, Abreast>,
        lost: &mut Abreast,
    ) -> &Vector<N, Abreast> {
        match &mut self.0 {
            Kind::None(zeros) => zeros,
            Kind::PerJoint(all) => {
                all.estimate(arch, stage, seen, lost);
                &all.estimate
            }
        }
    }

    /// As [`Compensator::acted`](super::Compensator::acted) of each.
    pub(crate) fn acted(
        &mut self,
        arch: Arch,
        index: usize,
        asked: &Vector<N, Abreast>,
        applied: &Vector<N, Abreast>,
    ) {
        if let Kind::PerJoint(all) = &mut self.0 {
            all.acted(arch, index, asked, applied);
        }
    }

    /// As [`Compensator::advance`](super::Compensator::advance) of each.
    pub(crate) fn advance(&mut self, arch: Arch, end: &Stage<'_>) {
        if let Kind::PerJoint(all) = &mut self.0 {
            all.advance(arch, end);
        }
    }
}

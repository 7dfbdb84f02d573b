//! Controllers of eight runs side by side, a controller a lane: computed torque, and what
//! compensates.

use pulp::{Arch, Simd};

use super::computed_torque::computed;
use super::fuzzy_compensator::PerJoint;
use super::gains::feedback;
use super::learns::Kind as Side;
use super::memories::Memories;
use super::{Demand, Gains, Learns, Sample, Stage};
use crate::arm::{self, ArmsAbreast};
use crate::math::{Abreast, LANES, Load, Matrix, Register, Vector, none_missing};

/// Laws of computed torque side by side, for many runs at a time.
#[derive(Clone, Debug)]
pub(crate) struct LawsAbreast<const N: usize> {
    arms: ArmsAbreast<N>,
    kp: [Abreast; N],
    kv: [Abreast; N],
}

impl<const N: usize> LawsAbreast<N> {
    /// These laws; `None` if what they believe of the arm cannot be put side by side.
    pub fn of(each: [(arm::Side<'_, N>, &Gains<N>); LANES]) -> Option<Self> {
        let gain = |of: fn(&Gains<N>) -> &[f64; N]| {
            core::array::from_fn(|n| Abreast(each.map(|(_, gains)| of(gains)[n])))
        };
        let arms = ArmsAbreast::of(each.map(|(arm, _)| arm))?;
        Some(Self { arms, kp: gain(|gains| &gains.kp), kv: gain(|gains| &gains.kv) })
    }

    /// What they believe of the arms.
    pub fn arms(&self) -> &ArmsAbreast<N> {
        &self.arms
    }

    /// As [`Law::torque`](super::Law::torque) of a part of them, from M and H.
    #[inline(always)]
    pub fn torque<S: Simd>(
        &self,
        (simd, part): (S, usize),
        dynamics: (&Matrix<N, Register<S>>, &Vector<N, Register<S>>),
        seen: &Sample<N, Register<S>>,
        rho_hat: &Vector<N, Register<S>>,
    ) -> Demand<N, Register<S>> {
        let (kp, kv) = (self.kp.load(simd, part), self.kv.load(simd, part));
        computed(dynamics, feedback(&kp, &kv, seen), rho_hat)
    }
}

/// Compensators of eight runs side by side, with their states.
#[derive(Clone, Debug)]
pub(crate) struct EstimatorsAbreast<const N: usize>(Kind<N>);

#[derive(Clone, Debug)]
enum Kind<const N: usize> {
    Nothing(Vector<N, Abreast>),
    PerJoint(Box<PerJoint<N>>),
    Memories(Box<Memories<N>>),
}

impl<const N: usize> EstimatorsAbreast<N> {
    /// These compensators; `None` if they cannot be put side by side.
    pub fn of(each: [Learns<'_, N>; LANES]) -> Option<Self> {
        let zeros = Vector::<N, Abreast>::repeat(Abreast::all(0.0));
        let kind = match each[0].0 {
            Side::Nothing => {
                let nothing = each.iter().all(|it| matches!(it.0, Side::Nothing));
                nothing.then_some(Kind::Nothing(zeros))
            }
            Side::PerJoint(_) => {
                let sides =
                    each.map(|it| if let Side::PerJoint(it) = it.0 { Some(it) } else { None });
                PerJoint::of(none_missing(sides)?).map(Box::new).map(Kind::PerJoint)
            }
            Side::Memory(_) => {
                let sides =
                    each.map(|it| if let Side::Memory(it) = it.0 { Some(it) } else { None });
                Memories::of(none_missing(sides)?).map(Box::new).map(Kind::Memories)
            }
            // It does not go with computed torque.
            Side::Own(_) => None,
        };
        kind.map(Self)
    }

    /// ρ̂ of each at a stage; one that cannot tell it is `lost`.
    pub fn estimate(
        &mut self,
        arch: Arch,
        stage: &Stage<'_>,
        seen: &Sample<N, Abreast>,
        lost: &mut Abreast,
    ) -> &Vector<N, Abreast> {
        match &mut self.0 {
            Kind::Nothing(zeros) => zeros,
            Kind::PerJoint(all) => {
                all.estimate(arch, stage, seen, lost);
                &all.estimate
            }
            Kind::Memories(all) => {
                all.estimate(arch, stage, seen);
                &all.estimate
            }
        }
    }

    /// As [`Compensator::acted`](super::Compensator::acted) of each, where torques are `limited` or
    /// not.
    pub fn acted(
        &mut self,
        arch: Arch,
        index: usize,
        (asked, applied): (&Vector<N, Abreast>, &Vector<N, Abreast>),
        limited: bool,
    ) {
        match &mut self.0 {
            Kind::PerJoint(all) if limited => all.acted(arch, index, asked, applied),
            Kind::Memories(all) => all.acted(arch, index, asked, applied),
            _ => {}
        }
    }

    /// As [`Compensator::advance`](super::Compensator::advance) of each; one that cannot is `lost`.
    pub fn advance(&mut self, arch: Arch, end: &Stage<'_>, lost: &mut Abreast) {
        match &mut self.0 {
            Kind::Nothing(_) => {}
            Kind::PerJoint(all) => all.advance(arch, end),
            Kind::Memories(all) => all.advance(arch, end, lost),
        }
    }
}

//! Controllers of eight sampled loops side by side.

use pulp::{Arch, Simd, WithSimd};

use super::bodies::{Bodies, Drivers};
use super::case::Case;
use crate::arm::Arm;
use crate::control::{
    Compensator, Controller, EstimatorsAbreast, FARTHEST, FrontsAbreast, Law, Sample, Stage,
};
use crate::math::{
    Abreast, LANES, Load, Real, Register, TINY_SIGNAL, Vector, in_lanes, none_missing,
};
use crate::plant::Disturbance;

/// Controllers side by side: laws with constant gains, and compensators that can be.
pub(super) struct Together<const N: usize> {
    pub drivers: Drivers<N>,
    /// What stands before laws, and limits of rates, if there are any.
    pub fronts: Option<FrontsAbreast<N>>,
    compensators: EstimatorsAbreast<N>,
}

impl<const N: usize> Together<N> {
    pub fn new<A: Arm<N>, D: Disturbance<N>, L: Law<N>, C: Compensator<N, S>, R, S: Clone>(
        cases: [&Case<'_, N, A, D, L, C, R, S>; LANES],
        bodies: &Bodies<N>,
    ) -> Option<Self> {
        let mut states = cases.map(|case| case.state.clone());
        let mut learns = [None; LANES];
        for ((to, case), state) in learns.iter_mut().zip(cases).zip(&mut states) {
            let Controller { compensator, .. } = case.controller;
            *to = compensator.learns(case.controller.settle(state));
        }
        let compensators = EstimatorsAbreast::of(none_missing(learns)?)?;
        let fronts = if cases.iter().all(|case| case.controller.is_bare()) {
            None
        } else {
            Some(FrontsAbreast::of(core::array::from_fn(|i| (cases[i].controller, &states[i])))?)
        };
        Some(Self { drivers: Drivers::new(cases, bodies)?, fronts, compensators })
    }

    /// Where what is measured is so small that a controller does not feel it, or so large that it
    /// may refuse it, the run is `lost`.
    pub fn feel(arch: Arch, seen: &Sample<N, Abreast>, lost: &mut Abreast) {
        in_lanes(arch, Feel { seen, lost });
    }

    /// The estimates of the compensators for what the laws see; one that cannot tell is `lost`.
    pub fn estimate(
        &mut self,
        arch: Arch,
        seen: &Sample<N, Abreast>,
        lost: &mut Abreast,
    ) -> &Vector<N, Abreast> {
        self.compensators.estimate(arch, &Stage::NOW, seen, lost)
    }

    /// Ends a period \[s\], with the torques that were asked for and those that acted, which are
    /// `limited` or not. What drives weights is small, or the run is lost.
    pub fn end(
        &mut self,
        arch: Arch,
        torques: (&Vector<N, Abreast>, &Vector<N, Abreast>),
        limited: bool,
        period: f64,
        lost: &mut Abreast,
    ) {
        self.compensators.acted(arch, 0, torques, limited);
        self.compensators.advance(arch, &Stage::after(period), lost);
    }
}

struct Feel<'a, const N: usize> {
    seen: &'a Sample<N, Abreast>,
    lost: &'a mut Abreast,
}

impl<const N: usize> WithSimd for Feel<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { seen: Sample { q, dq, desired, .. }, lost } = self;
        for part in 0..Register::<S>::PARTS {
            let mut felt = lost.load(simd, part);
            for signal in [q, dq, &desired.q, &desired.dq, &desired.ddq] {
                for x in signal.iter() {
                    let x = x.load(simd, part);
                    let (zero, lost) = (x.like(0.0), x.like(f64::NAN));
                    let unfelt = (x - x.unless_tiny(TINY_SIGNAL)).abs();
                    felt +=
                        zero.if_less(unfelt, lost, x.like(FARTHEST).if_less(x.abs(), lost, zero));
                }
            }
            felt.store(lost, part);
        }
    }
}

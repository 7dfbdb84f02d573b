//! The compensators of eight runs: side by side where they can be, or each as it is.

use pulp::Arch;

use super::bodies::Now;
use super::case::Case;
use crate::control::{Applied, Compensator, EstimatorsAbreast, Law, Sample, Stage};
use crate::math::{Abreast, LANES, Vector, lane, none_missing};

/// The compensators of eight runs with their states.
pub(super) enum Estimators<'a, const N: usize, C, S> {
    Abreast(EstimatorsAbreast<N>),
    /// Each as it is, and ρ̂ of the latest stage.
    Each([(&'a C, S); LANES], Vector<N, Abreast>),
}

impl<'a, const N: usize, C: Compensator<N, S>, S: Clone> Estimators<'a, N, C, S> {
    /// Those of these runs, at their start.
    pub fn new<A, D, L: Law<N>, R>(cases: [&'a Case<'a, N, A, D, L, C, R, S>; LANES]) -> Self {
        let each = cases.map(|case| {
            let mut state = case.state.clone();
            (&case.controller.compensator, case.controller.settle(&mut state).clone())
        });
        let learns = each.each_ref().map(|(compensator, state)| compensator.learns(state));
        let abreast = none_missing(learns).and_then(EstimatorsAbreast::of);
        let zeros = Vector::<N, Abreast>::repeat(Abreast::all(0.0));
        abreast.map_or(Self::Each(each, zeros), Self::Abreast)
    }
}

impl<const N: usize, C: Compensator<N, S>, S> Estimators<'_, N, C, S> {
    /// ρ̂ of each at a stage; one that cannot tell it is `lost`.
    pub fn estimate(
        &mut self,
        arch: Arch,
        stage: &Stage<'_>,
        seen: &Sample<N, Abreast>,
        lost: &mut Abreast,
    ) -> &Vector<N, Abreast> {
        let (each, estimates) = match self {
            Self::Abreast(all) => return all.estimate(arch, stage, seen, lost),
            Self::Each(each, estimates) => (each, estimates),
        };
        for (i, (compensator, state)) in each.iter_mut().enumerate() {
            let estimate = compensator.estimate(state, stage, &seen.lane(i));
            for n in 0..N {
                estimates[n].0[i] = estimate[n];
            }
        }
        estimates
    }

    /// Tells each the torque that acts at a stage, and the one that was asked for; those side by
    /// side where anything is `limited`.
    pub fn acted(
        &mut self,
        arch: Arch,
        index: usize,
        Now { seen, asked, applied, .. }: &Now<N>,
        limited: bool,
    ) {
        match self {
            Self::Abreast(all) => all.acted(arch, index, (asked, applied), limited),
            Self::Each(each, _) => {
                for (i, (compensator, state)) in each.iter_mut().enumerate() {
                    let acted = Applied::new(lane(asked, i), lane(applied, i));
                    compensator.acted(state, index, &seen.lane(i), &acted);
                }
            }
        }
    }

    /// Moves each to the end of a step; one that cannot is `lost`.
    pub fn advance(&mut self, arch: Arch, end: &Stage<'_>, lost: &mut Abreast) {
        match self {
            Self::Abreast(all) => all.advance(arch, end, lost),
            Self::Each(each, _) => {
                for (i, (compensator, state)) in each.iter_mut().enumerate() {
                    if compensator.advance(state, end).is_err() {
                        lost.0[i] = f64::NAN;
                    }
                }
            }
        }
    }
}

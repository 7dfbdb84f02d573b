//! Controllers of eight sampled loops side by side.

use pulp::{Arch, Simd, WithSimd};

use super::bodies::{Bodies, Drivers};
use super::case::Case;
use crate::arm::Arm;
use crate::control::{Compensator, EstimatorsAbreast, FARTHEST, Law, Learns, Sample, Stage, State};
use crate::math::{
    Abreast, LANES, Load, Real, Register, TINY_SIGNAL, Vector, in_lanes, none_missing,
};
use crate::plant::Disturbance;

/// Controllers of computed torque side by side: laws with constant gains, and compensators that can
/// be.
pub(super) struct Together<const N: usize> {
    pub drivers: Drivers<N>,
    compensators: EstimatorsAbreast<N>,
}

impl<const N: usize> Together<N> {
    /// Those of these runs, with their states, of which no period is pending; `None` if they cannot
    /// be.
    pub fn new<A: Arm<N>, D: Disturbance<N>, L: Law<N>, C: Compensator<N, S>, R, S>(
        cases: [&Case<'_, N, A, D, L, C, R, S>; LANES],
        states: &[State<N, S>; LANES],
        bodies: &Bodies<N>,
    ) -> Option<Self> {
        let drivers = Drivers::new(cases, bodies)?;
        let compensators = EstimatorsAbreast::of(none_missing(learns(cases, states))?)?;
        Some(Self { drivers, compensators })
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

/// The states of these runs at their start, without a period that is pending.
pub(super) fn settled<const N: usize, A, D, L: Law<N>, C: Compensator<N, S>, R, S: Clone>(
    cases: [&Case<'_, N, A, D, L, C, R, S>; LANES],
) -> [State<N, S>; LANES] {
    cases.map(|case| {
        let mut state = case.state.clone();
        case.controller.settle(&mut state);
        state
    })
}

/// What compensates in these runs.
pub(super) fn learns<'a, const N: usize, A, D, L, C: Compensator<N, S>, R, S>(
    cases: [&'a Case<'_, N, A, D, L, C, R, S>; LANES],
    states: &'a [State<N, S>; LANES],
) -> [Option<Learns<'a, N>>; LANES] {
    core::array::from_fn(|i| cases[i].controller.compensator.learns(states[i].compensator()))
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

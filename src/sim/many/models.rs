//! What the laws of eight runs believe of their arms, side by side: M₀ and H₀ at the motion that is
//! measured, where a law needs nothing else of its model.

use pulp::Arch;

use super::case::Case;
use crate::arm::ModelsAbreast;
use crate::control::Law;
use crate::math::{Abreast, LANES, Matrix, Real, TINY_SIGNAL, Vector, lane, none_missing};

/// What eight laws believe of their arms, and M₀ and H₀ of the latest sample.
pub(super) struct Models<const N: usize>(ModelsAbreast<N>);

impl<const N: usize> Models<N> {
    /// Those of these runs; `None` if their laws need something else, or not at the motion that is
    /// measured.
    pub fn of<A, D, L: Law<N>, C, R, S>(
        cases: [&Case<'_, N, A, D, L, C, R, S>; LANES],
    ) -> Option<Self> {
        if cases.iter().any(|case| case.controller.front.velocity_filter.is_some()) {
            return None;
        }
        let sides = none_missing(cases.map(|case| case.controller.law.model()))?;
        ModelsAbreast::of(sides).map(Self)
    }

    /// Finds them at q and q̇, as controllers feel these.
    pub fn find(&mut self, arch: Arch, (q, dq): (&Vector<N, Abreast>, &Vector<N, Abreast>)) {
        let felt =
            |x: &Vector<N, Abreast>| x.map(|x| Abreast(x.0.map(|x| x.unless_tiny(TINY_SIGNAL))));
        self.0.find(arch, (&felt(q), &felt(dq)));
    }

    /// M₀ and H₀ of the law in a lane.
    pub fn of_lane(&self, i: usize) -> (Matrix<N>, Vector<N>) {
        let Self(ModelsAbreast { mass, bias, .. }) = self;
        (Matrix::<N>::from_fn(|row, column| mass[(row, column)].0[i]), lane(bias, i))
    }
}

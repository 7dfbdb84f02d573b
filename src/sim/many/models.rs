//! What the laws of eight runs believe of their arms, side by side: M₀ and H₀ at the motion that is
//! measured, where a law needs nothing else of its model.

use pulp::{Arch, Simd, WithSimd};

use super::case::Case;
use crate::arm::{Alike, ArmsAbreast, Kind};
use crate::control::{Front, Law};
use crate::math::{
    Abreast, LANES, Load, Matrix, Real, Register, TINY_SIGNAL, Vector, lane, none_missing, store,
};

/// What eight laws believe of their arms, and M₀ and H₀ of the latest sample.
pub(super) struct Models<const N: usize> {
    arms: ArmsAbreast<N>,
    mass: Matrix<N, Abreast>,
    bias: Vector<N, Abreast>,
}

impl<const N: usize> Models<N> {
    /// Those of these runs; `None` if their laws need something else, or not at the motion that is
    /// measured.
    pub fn of<A, D, L: Law<N>, C, R, S>(
        cases: [&Case<'_, N, A, D, L, C, R, S>; LANES],
    ) -> Option<Self> {
        let as_measured =
            |case: &&Case<'_, N, A, D, L, C, R, S>| case.controller.front == Front::default();
        if !cases.iter().all(as_measured) {
            return None;
        }
        let sides = none_missing(cases.map(|case| case.controller.law.model()))?;
        let (arms, zero) = (ArmsAbreast::of(sides)?, Abreast::all(0.0));
        let (mass, bias) = (Matrix::<N, _>::repeat(zero), Vector::<N, _>::repeat(zero));
        Some(Self { arms, mass, bias })
    }

    /// Finds them at q and q̇.
    #[inline(never)]
    pub fn find(&mut self, arch: Arch, (q, dq): (&Vector<N, Abreast>, &Vector<N, Abreast>)) {
        arch.dispatch(Find { models: self, q, dq });
    }

    /// M₀ and H₀ of the law in a lane.
    pub fn of_lane(&self, i: usize) -> (Matrix<N>, Vector<N>) {
        (Matrix::<N>::from_fn(|row, column| self.mass[(row, column)].0[i]), lane(&self.bias, i))
    }
}

struct Find<'a, const N: usize> {
    models: &'a mut Models<N>,
    q: &'a Vector<N, Abreast>,
    dq: &'a Vector<N, Abreast>,
}

impl<const N: usize> WithSimd for Find<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { models: Models { arms, mass, bias }, q, dq } = self;
        for part in 0..Register::<S>::PARTS {
            let (at, mut q, mut dq) = ((simd, part), q.load(simd, part), dq.load(simd, part));
            for n in 0..N {
                q[n] = q[n].unless_tiny(TINY_SIGNAL);
                dq[n] = dq[n].unless_tiny(TINY_SIGNAL);
            }
            let (own_mass, mut own_bias) = match &arms.kind {
                Kind::TwoLinks(arms) if const { N == 2 } => dynamics(at, &**arms, (&q, &dq)),
                Kind::Chains(arms) => dynamics(at, &**arms, (&q, &dq)),
                // Arms of two links have two joints.
                Kind::TwoLinks(_) => continue,
            };
            if let Some(friction) = arms.friction_at(at, &dq) {
                for n in 0..N {
                    own_bias[n] += friction[n];
                }
            }
            for j in 0..N {
                for i in 0..N {
                    own_mass[(i, j)].store(&mut mass[(i, j)], part);
                }
            }
            store(&own_bias, bias, part);
        }
    }
}

/// M and C q̇ + G of a part of arms.
#[inline(always)]
fn dynamics<const N: usize, S: Simd, K: Alike<N>>(
    at: (S, usize),
    arms: &K,
    (q, dq): (&Vector<N, Register<S>>, &Vector<N, Register<S>>),
) -> (Matrix<N, Register<S>>, Vector<N, Register<S>>) {
    arms.mass_matrix_and_bias(at, &arms.moves(at, q, dq))
}

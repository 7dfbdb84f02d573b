//! What the laws of eight runs believe of their arms, side by side: M₀ and H₀ at the motion that is
//! measured, where a law needs nothing else of its model.

use pulp::{Arch, Simd, WithSimd};

use super::case::Case;
use crate::arm::{Alike, ArmsAbreast, Frame, Frames, Kind};
use crate::control::{Front, Law};
use crate::math::{
    Abreast, LANES, Load, Matrix, Real, Register, TINY_SIGNAL, Vector, column, columns, in_lanes,
    lane, none_missing, store,
};

/// What eight laws believe of their arms, and M₀ and H₀ of the latest sample.
pub(super) struct Models<const N: usize> {
    arms: ArmsAbreast<N>,
    /// The motion as controllers feel it, and then friction in the place of q.
    q: Vector<N, Abreast>,
    dq: Vector<N, Abreast>,
    frames: Frames<N, Abreast>,
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
        let (mass, zeros) = (Matrix::<N, _>::repeat(zero), Vector::<N, _>::repeat(zero));
        let frames = [Frame::place(zero); N];
        Some(Self { arms, q: zeros, dq: zeros, frames, mass, bias: zeros })
    }

    /// Finds them at q and q̇.
    #[inline(never)]
    pub fn find(&mut self, arch: Arch, (q, dq): (&Vector<N, Abreast>, &Vector<N, Abreast>)) {
        let felt =
            |x: &Vector<N, Abreast>| x.map(|x| Abreast(x.0.map(|x| x.unless_tiny(TINY_SIGNAL))));
        (self.q, self.dq) = (felt(q), felt(dq));
        let Self { arms, q, dq, frames, mass, bias } = self;
        match &arms.kind {
            Kind::TwoLinks(arms) if const { N == 2 } => {
                in_lanes(arch, Find { arms: &**arms, q, dq, frames, mass, bias });
            }
            Kind::Chains(arms) => in_lanes(arch, Find { arms: &**arms, q, dq, frames, mass, bias }),
            // Arms of two links have two joints.
            Kind::TwoLinks(_) => {}
        }
        arms.resist(arch, dq, q);
        if arms.friction.is_some() {
            for n in 0..N {
                for lane in 0..LANES {
                    bias[n].0[lane] += q[n].0[lane];
                }
            }
        }
    }

    /// M₀ and H₀ of the law in a lane.
    pub fn of_lane(&self, i: usize) -> (Matrix<N>, Vector<N>) {
        (Matrix::<N>::from_fn(|row, column| self.mass[(row, column)].0[i]), lane(&self.bias, i))
    }
}

struct Find<'a, const N: usize, K> {
    arms: &'a K,
    q: &'a Vector<N, Abreast>,
    dq: &'a Vector<N, Abreast>,
    frames: &'a mut Frames<N, Abreast>,
    mass: &'a mut Matrix<N, Abreast>,
    bias: &'a mut Vector<N, Abreast>,
}

impl<const N: usize, K: Alike<N>> WithSimd for Find<'_, N, K> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { arms, q, dq, frames, mass, bias } = self;
        let zero = Abreast::all(0.0).load(simd, 0);
        let (mut own_mass, mut own_bias) = (columns([[zero; N]; N]), column([zero; N]));
        for part in 0..Register::<S>::PARTS {
            let motion = (&q.load(simd, part), &dq.load(simd, part));
            let moves = arms.moves((simd, part), motion, &mut *frames);
            arms.write_dynamics(
                (simd, part),
                (moves, &mut *frames),
                (&mut own_mass, &mut own_bias),
            );
            for j in 0..N {
                for i in 0..N {
                    own_mass[(i, j)].store(&mut mass[(i, j)], part);
                }
            }
            store(&own_bias, bias, part);
        }
    }
}

//! M and H of eight arms side by side, found at a motion and kept: what laws and observers believe
//! of their arms.

use pulp::{Arch, Simd, WithSimd};

use super::Side;
use super::abreast::{Alike, ArmsAbreast, Kind};
use super::serial::{Frame, Frames};
use crate::math::{
    Abreast, LANES, Load, Matrix, Register, Vector, column, columns, in_lanes, store,
};

/// Eight arms, with M and H = C q̇ + G + f of the motion that was asked for last; or with G + f and
/// Cᵀ q̇ in the place of H.
#[derive(Clone, Debug)]
pub(crate) struct ModelsAbreast<const N: usize> {
    arms: ArmsAbreast<N>,
    frames: Frames<N, Abreast>,
    pub mass: Matrix<N, Abreast>,
    pub bias: Vector<N, Abreast>,
    pub carried: Vector<N, Abreast>,
    friction: Vector<N, Abreast>,
}

impl<const N: usize> ModelsAbreast<N> {
    /// These arms; `None` if they cannot be put side by side.
    pub fn of(each: [Side<'_, N>; LANES]) -> Option<Self> {
        let (arms, zero) = (ArmsAbreast::of(each)?, Abreast::all(0.0));
        let (mass, zeros) = (Matrix::<N, _>::repeat(zero), Vector::<N, _>::repeat(zero));
        let frames = [Frame::place(zero); N];
        Some(Self { arms, frames, mass, bias: zeros, carried: zeros, friction: zeros })
    }

    /// Finds M and H at q and q̇.
    pub fn find(&mut self, arch: Arch, motion: (&Vector<N, Abreast>, &Vector<N, Abreast>)) {
        self.find_parts(arch, motion, false);
    }

    /// Finds M, G + f and Cᵀ q̇.
    pub fn find_momentum(
        &mut self,
        arch: Arch,
        motion: (&Vector<N, Abreast>, &Vector<N, Abreast>),
    ) {
        self.find_parts(arch, motion, true);
    }

    /// Finds M at q.
    pub fn find_mass(&mut self, arch: Arch, q: &Vector<N, Abreast>) {
        let Self { arms, frames, mass, .. } = self;
        match &arms.kind {
            Kind::TwoLinks(arms) if const { N == 2 } => {
                in_lanes(arch, FindMass { arms: &**arms, q, frames, mass });
            }
            Kind::Chains(arms) => in_lanes(arch, FindMass { arms: &**arms, q, frames, mass }),
            // Arms of two links have two joints.
            Kind::TwoLinks(_) => {}
        }
    }

    /// Writes the entries of the regressor Y(q, q̇, q̈) that are not zero for every motion into
    /// `rows`, row by row, where M was found last at this q.
    pub fn write_regressor(
        &self,
        arch: Arch,
        motion: [&Vector<N, Abreast>; 3],
        rows: &mut [Abreast],
    ) {
        let Self { arms, frames, .. } = self;
        match &arms.kind {
            Kind::TwoLinks(arms) if const { N == 2 } => {
                in_lanes(arch, Regress { arms: &**arms, frames, motion, rows });
            }
            Kind::Chains(arms) => in_lanes(arch, Regress { arms: &**arms, frames, motion, rows }),
            // Arms of two links have two joints.
            Kind::TwoLinks(_) => {}
        }
    }

    /// f(q̇) [N·m].
    pub fn friction(&self, arch: Arch, dq: &Vector<N, Abreast>, torque: &mut Vector<N, Abreast>) {
        self.arms.resist(arch, dq, torque);
    }

    #[inline(never)]
    fn find_parts(
        &mut self,
        arch: Arch,
        motion: (&Vector<N, Abreast>, &Vector<N, Abreast>),
        apart: bool,
    ) {
        let Self { arms, frames, mass, bias, carried, friction } = self;
        let to = (mass, &mut *bias, apart.then_some(carried));
        match &arms.kind {
            Kind::TwoLinks(arms) if const { N == 2 } => {
                in_lanes(arch, Find { arms: &**arms, motion, frames, to });
            }
            Kind::Chains(arms) => in_lanes(arch, Find { arms: &**arms, motion, frames, to }),
            // Arms of two links have two joints.
            Kind::TwoLinks(_) => {}
        }
        if arms.friction.is_some() {
            arms.resist(arch, motion.1, friction);
            for n in 0..N {
                for lane in 0..LANES {
                    bias[n].0[lane] += friction[n].0[lane];
                }
            }
        }
    }
}

struct Find<'a, const N: usize, K> {
    arms: &'a K,
    motion: (&'a Vector<N, Abreast>, &'a Vector<N, Abreast>),
    frames: &'a mut Frames<N, Abreast>,
    /// Places for M, and for C q̇ + G; or for G and Cᵀ q̇.
    to: (
        &'a mut Matrix<N, Abreast>,
        &'a mut Vector<N, Abreast>,
        Option<&'a mut Vector<N, Abreast>>,
    ),
}

impl<const N: usize, K: Alike<N>> WithSimd for Find<'_, N, K> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { arms, motion: (q, dq), frames, to: (mass, bias, mut carried) } = self;
        let zero = Abreast::all(0.0).load(simd, 0);
        let mut own = columns([[zero; N]; N]);
        for part in 0..Register::<S>::PARTS {
            let (at, q, dq) = ((simd, part), q.load(simd, part), dq.load(simd, part));
            arms.find(at, (&q, &dq), &mut *frames);
            arms.write_mass_matrix(at, &mut *frames, &mut own);
            put(&own, mass, part);
            let mut moving = dq;
            if let Some(carried) = &mut carried {
                store(&arms.carried(at, &mut *frames, &dq), carried, part);
                moving = column([zero; N]);
                arms.find(at, (&q, &moving), &mut *frames);
            }
            store(&arms.bias(at, &*frames, &moving), bias, part);
        }
    }
}

struct FindMass<'a, const N: usize, K> {
    arms: &'a K,
    q: &'a Vector<N, Abreast>,
    frames: &'a mut Frames<N, Abreast>,
    mass: &'a mut Matrix<N, Abreast>,
}

impl<const N: usize, K: Alike<N>> WithSimd for FindMass<'_, N, K> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { arms, q, frames, mass } = self;
        let zero = Abreast::all(0.0).load(simd, 0);
        let mut own = columns([[zero; N]; N]);
        for part in 0..Register::<S>::PARTS {
            let (at, q) = ((simd, part), q.load(simd, part));
            arms.find(at, (&q, &column([zero; N])), &mut *frames);
            arms.write_mass_matrix(at, &mut *frames, &mut own);
            put(&own, mass, part);
        }
    }
}

struct Regress<'a, const N: usize, K> {
    arms: &'a K,
    frames: &'a Frames<N, Abreast>,
    motion: [&'a Vector<N, Abreast>; 3],
    rows: &'a mut [Abreast],
}

impl<const N: usize, K: Alike<N>> WithSimd for Regress<'_, N, K> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { arms, frames, motion: [q, dq, ddq], rows } = self;
        for part in 0..Register::<S>::PARTS {
            let (q, dq) = (q.load(simd, part), dq.load(simd, part));
            let motion = [&q, &dq, &ddq.load(simd, part)];
            arms.write_regressor((simd, part), frames, motion, &mut *rows);
        }
    }
}

/// Puts M into its place.
#[inline(always)]
fn put<const N: usize, S: Simd>(
    from: &Matrix<N, Register<S>>,
    to: &mut Matrix<N, Abreast>,
    part: usize,
) {
    for j in 0..N {
        for i in 0..N {
            from[(i, j)].store(&mut to[(i, j)], part);
        }
    }
}

//! The mass matrix from composite bodies: column j is the wrench that accelerates everything beyond
//! joint j, carried inward.
//!
//! Source: Featherstone, Rigid Body Dynamics Algorithms, 6.2. The wrenches of all outer joints are
//! carried inward side by side, one per lane, while the next body is put together.

use pulp::{Arch, Simd, WithSimd};

use super::inverse::Wrench;
use super::joint::{Chain, Mass};
use super::space::{Turn, V3};
use crate::math::{LANES, Line, Matrix, Real};

/// Line k has a one in lane k.
static ONES: [Line; LANES] = {
    let mut ones = [Line([0.0; LANES]); LANES];
    let mut lane = 0;
    while lane < LANES {
        ones[lane].0[lane] = 1.0;
        lane += 1;
    }
    ones
};

/// What accelerates `body` along the axis of its joint by 1.
#[inline(always)]
pub(super) fn unit_wrench<T: Real>(body: &Mass<T>, revolute: bool) -> Wrench<T> {
    let (h, k, zero) = (body.h, &body.sigma, body.m.like(0.0));
    if revolute {
        Wrench { f: V3::new(-h.y, h.x, zero), n: V3::new(-k.xz, -k.yz, k.xx + k.yy) }
    } else {
        Wrench { f: V3::new(zero, zero, body.m), n: V3::new(h.y, -h.x, zero) }
    }
}

/// A vector a lane.
#[derive(Clone, Copy)]
struct Vectors<S: Simd> {
    x: S::f64s,
    y: S::f64s,
    z: S::f64s,
}

impl<S: Simd> Vectors<S> {
    /// Puts v into the lane in which `one` is 1, and all others are 0; the lane was zero before.
    #[inline(always)]
    fn put(&mut self, simd: S, v: V3, one: S::f64s) {
        let put = |lanes, x| simd.add_f64s(lanes, simd.mul_f64s(simd.splat_f64s(x), one));
        *self = Self { x: put(self.x, v.x), y: put(self.y, v.y), z: put(self.z, v.z) };
    }

    /// In the axes of the frame before.
    #[inline(always)]
    fn inward(&self, simd: S, turn: &Turn) -> Self {
        let Self { x, y, z } = *self;
        let [ca, sa, c, s] = [turn.ca, turn.sa, turn.c, turn.s].map(|a| simd.splat_f64s(a));
        let (x, y) = (difference(simd, c, x, s, y), sum(simd, s, x, c, y));
        Self { x, y: difference(simd, ca, y, sa, z), z: sum(simd, sa, y, ca, z) }
    }

    /// Adds p × f.
    #[inline(always)]
    fn add_cross(&mut self, simd: S, p: V3, f: &Self) {
        let [px, py, pz] = [p.x, p.y, p.z].map(|a| simd.splat_f64s(a));
        self.x = simd.add_f64s(self.x, difference(simd, py, f.z, pz, f.y));
        self.y = simd.add_f64s(self.y, difference(simd, pz, f.x, px, f.z));
        self.z = simd.add_f64s(self.z, difference(simd, px, f.y, py, f.x));
    }
}

/// a x + b y.
#[inline(always)]
fn sum<S: Simd>(simd: S, a: S::f64s, x: S::f64s, b: S::f64s, y: S::f64s) -> S::f64s {
    simd.add_f64s(simd.mul_f64s(a, x), simd.mul_f64s(b, y))
}

/// a x − b y.
#[inline(always)]
fn difference<S: Simd>(simd: S, a: S::f64s, x: S::f64s, b: S::f64s, y: S::f64s) -> S::f64s {
    simd.sub_f64s(simd.mul_f64s(a, x), simd.mul_f64s(b, y))
}

/// The upper triangle of M, without armature, in the columns of [`LANES`] joints from `first` on.
struct Columns<'a, const N: usize> {
    chain: &'a Chain<N>,
    turns: &'a [Turn; N],
    first: usize,
    /// A line a row, a column a lane.
    rows: &'a mut [Line; N],
}

impl<const N: usize> WithSimd for Columns<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { chain, turns, first, rows } = self;
        let zero = simd.splat_f64s(0.0);
        let none = Vectors::<S> { x: zero, y: zero, z: zero };
        let (mut forces, mut moments) = ([none; LANES], [none; LANES]);
        let mut beyond = Mass::ZERO;
        for i in (0..N).rev() {
            let joint = &chain.joints[i];
            let body = joint.mass.plus(&beyond);
            let own = unit_wrench(&body, joint.revolute);
            let row = S::as_mut_simd_f64s(&mut rows[i].0).0;
            for part in 0..LANES / S::F64_LANES {
                let start = first + part * S::F64_LANES;
                if start >= N || start + S::F64_LANES <= i {
                    continue;
                }
                let (f, n) = (&mut forces[part], &mut moments[part]);
                if start <= i {
                    let one = S::as_simd_f64s(&ONES[i - start].0).0[0];
                    f.put(simd, own.f, one);
                    n.put(simd, own.n, one);
                }
                row[part] = if joint.revolute { n.z } else { f.z };
                if i > 0 {
                    *f = f.inward(simd, &turns[i]);
                    *n = n.inward(simd, &turns[i]);
                    n.add_cross(simd, turns[i].p, f);
                }
            }
            if i > 0 {
                beyond = body.inward(&turns[i]);
            }
        }
    }
}

impl<const N: usize> Chain<N> {
    /// M(q), armature on the diagonal.
    #[inline(always)]
    pub fn mass_matrix(&self, turns: &[Turn; N]) -> Matrix<N> {
        let (mut m, mut rows) = (Matrix::<N>::zeros(), [Line([0.0; LANES]); N]);
        for first in (0..N).step_by(LANES) {
            Arch::new().dispatch(Columns { chain: self, turns, first, rows: &mut rows });
            for j in first..N.min(first + LANES) {
                for i in 0..=j {
                    m[(i, j)] = rows[i].0[j - first];
                    m[(j, i)] = m[(i, j)];
                }
                m[(j, j)] += self.joints[j].armature;
            }
        }
        m
    }
}

#[cfg(test)]
#[cfg(feature = "std")]
mod tests {
    use pulp::Scalar;

    use super::*;
    use crate::arm::{Inertia, JointKind, Link, Pose, SerialParameters};
    use crate::math::Vector;

    /// Joints of both kinds, each along another axis, whose links are far from symmetric.
    fn chain<const N: usize>() -> Chain<N> {
        let links = core::array::from_fn(|i| {
            let t = i as f64;
            let axis = nalgebra::Vector3::new(1.0, t.sin(), t.cos()).normalize();
            let place = Pose::at(nalgebra::Vector3::new(0.3, 0.1 * t, -0.2));
            let com = nalgebra::Vector3::new(0.1, -0.2, 0.05 * t);
            let inertia =
                Inertia { moments: Matrix::<3>::identity(), ..Inertia::point_mass(2.0, com) };
            let kind = if i % 4 == 2 { JointKind::Prismatic } else { JointKind::Revolute };
            Link::new(kind, place, axis, inertia)
        });
        Chain::new(&SerialParameters { links, tip: Pose::IDENTITY, gravity: [0.0; 3] })
    }

    fn every_instruction_set_gives_the_same_bits<const N: usize>() {
        let chain = chain::<N>();
        let turns = chain.turns(&Vector::from_fn(|i, _| 0.7 * i as f64 - 1.0));
        for first in (0..N).step_by(LANES) {
            let columns = |run: &dyn Fn(Columns<'_, N>)| {
                let mut rows = [Line([0.0; LANES]); N];
                run(Columns { chain: &chain, turns: &turns, first, rows: &mut rows });
                let upper = |i: usize| {
                    rows[i]
                        .0
                        .into_iter()
                        .enumerate()
                        .filter(move |(j, _)| (i..N).contains(&(first + j)))
                };
                (0..N).flat_map(upper).map(|(_, x)| x.to_bits()).collect::<Vec<u64>>()
            };
            let scalar = columns(&|it| it.with_simd(Scalar));
            assert_eq!(scalar, columns(&|it| Arch::new().dispatch(it)), "{N} joints");
            #[cfg(target_arch = "x86_64")]
            if let Some(v3) = pulp::x86::V3::try_new() {
                assert_eq!(scalar, columns(&|it| Simd::vectorize(v3, it)), "{N} joints");
            }
        }
    }

    #[test]
    fn the_mass_matrix_has_the_same_bits_on_every_instruction_set() {
        every_instruction_set_gives_the_same_bits::<1>();
        every_instruction_set_gives_the_same_bits::<2>();
        every_instruction_set_gives_the_same_bits::<7>();
        every_instruction_set_gives_the_same_bits::<8>();
        every_instruction_set_gives_the_same_bits::<19>();
    }
}

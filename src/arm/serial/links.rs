//! M and C q̇ + G of chains whose joints are taken one at a time: several side by side, or one in
//! single precision.

use super::composite::unit_wrench;
use super::inverse::{Moving, Wrench};
use super::joint::{Chain, Joint, Mass};
use super::space::{Sym3, Turn, V3};
use crate::math::{Matrix, Real, Vector};

/// The frames of a chain, each in the one before, and how they move.
pub(crate) type Frames<const N: usize, T> = [(Turn<T>, Moving<T>); N];

/// The joints of a chain.
pub(crate) trait Links<const N: usize, T: Real> {
    /// A joint with its link.
    fn joint(&self, i: usize) -> Joint<T>;

    /// Gravity in the prepared base's axes [m/s²].
    fn gravity(&self) -> V3<T>;

    /// The frames at q, and how they move under gravity with q̇.
    #[inline(always)]
    fn frames(&self, q: &Vector<N, T>, dq: &Vector<N, T>) -> Frames<N, T> {
        let gravity = self.gravity();
        let zero = V3::zero_like(gravity.x);
        let mut moving = Moving::base(zero - gravity);
        let mut frames = [(self.joint(0).rest, moving); N];
        for i in 0..N {
            let joint = self.joint(i);
            let turn = joint.turn(q[i]);
            moving = moving.outward(&turn, joint.revolute, dq[i], zero.x);
            frames[i] = (turn, moving);
        }
        frames
    }

    /// C q̇ + G.
    #[inline(always)]
    fn bias(&self, frames: &Frames<N, T>) -> Vector<N, T> {
        let zero = V3::zero_like(frames[0].0.c);
        let mut tau = Vector::<N, T>::repeat(zero.x);
        let mut beyond = Wrench { f: zero, n: zero };
        for i in (0..N).rev() {
            let (joint, (turn, moving)) = (self.joint(i), &frames[i]);
            let all = joint.wrench_of(moving).plus(&beyond);
            tau[i] = all.along(joint.revolute);
            if i > 0 {
                beyond = all.inward(turn);
            }
        }
        tau
    }

    /// M(q), armature on the diagonal: as [`Chain::mass_matrix`], column after column.
    #[inline(always)]
    fn mass_matrix(&self, frames: &Frames<N, T>) -> Matrix<N, T> {
        let zero = V3::zero_like(frames[0].0.c);
        let mut m = Matrix::<N, T>::repeat(zero.x);
        let mut columns = [Wrench { f: zero, n: zero }; N];
        let mut body = self.joint(N - 1).mass;
        for i in (0..N).rev() {
            let Joint { revolute, armature, .. } = self.joint(i);
            columns[i] = unit_wrench(&body, revolute);
            for j in i..N {
                let axis = columns[j].along(revolute);
                (m[(i, j)], m[(j, i)]) = (axis, axis);
                if i > 0 {
                    columns[j] = columns[j].inward(&frames[i].0);
                }
            }
            m[(i, i)] += armature;
            if i > 0 {
                body = self.joint(i - 1).mass.plus(&body.inward(&frames[i].0));
            }
        }
        m
    }
}

/// A chain in single precision.
impl<const N: usize> Links<N, f32> for Chain<N, f32> {
    #[inline(always)]
    fn joint(&self, i: usize) -> Joint<f32> {
        self.joints[i]
    }

    #[inline(always)]
    fn gravity(&self) -> V3<f32> {
        self.gravity
    }
}

impl<const N: usize> Chain<N> {
    /// The same in single precision.
    pub fn single(&self) -> Chain<N, f32> {
        let Self { joints, base, tip, gravity, ground_energy } = *self;
        let joints = joints.map(|joint| Joint {
            revolute: joint.revolute,
            rest: single_turn(&joint.rest),
            mass: single_mass(&joint.mass),
            armature: joint.armature as f32,
            friction: joint.friction,
            user: joint.user,
        });
        Chain { joints, base, tip, gravity: single_vector(gravity), ground_energy }
    }
}

fn single_vector(V3 { x, y, z }: V3) -> V3<f32> {
    V3::new(x as f32, y as f32, z as f32)
}

fn single_turn(turn: &Turn) -> Turn<f32> {
    let [ca, sa, c, s] = [turn.ca, turn.sa, turn.c, turn.s].map(|x| x as f32);
    Turn { ca, sa, c, s, p: single_vector(turn.p) }
}

fn single_mass(Mass { m, h, sigma }: &Mass) -> Mass<f32> {
    let Sym3 { xx, yy, zz, xy, xz, yz } = *sigma;
    let [xx, yy, zz, xy, xz, yz] = [xx, yy, zz, xy, xz, yz].map(|x| x as f32);
    Mass { m: *m as f32, h: single_vector(*h), sigma: Sym3 { xx, yy, zz, xy, xz, yz } }
}

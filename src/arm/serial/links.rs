//! M and C q̇ + G of chains whose joints are taken one at a time: several side by side, or one in
//! single precision.

use super::composite::unit_wrench;
use super::inverse::{Moving, Spread, Wrench};
use super::joint::{Chain, Joint, Mass};
use super::space::{Sym3, Turn, V3};
use crate::math::{Matrix, Real, Vector, column};

/// The frame of a joint in the one before; the acceleration of points that move with it is a + S r;
/// and a place for what accelerates all beyond it by 1.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame<T> {
    pub(super) turn: Turn<T>,
    pub(super) a: V3<T>,
    pub(super) s: Spread<T>,
    pub(super) column: Wrench<T>,
}

/// The frames of a chain.
pub(crate) type Frames<const N: usize, T> = [Frame<T>; N];

impl<T: Copy> Frame<T> {
    /// A place for one, of numbers that do not matter.
    pub fn place(x: T) -> Self {
        let v = V3::new(x, x, x);
        let s = Spread { xx: x, xy: x, xz: x, yx: x, yy: x, yz: x, zx: x, zy: x, zz: x };
        let column = Wrench { f: v, n: v };
        Self { turn: Turn { ca: x, sa: x, c: x, s: x, p: v }, a: v, s, column }
    }
}

/// The joints of a chain, with a place for their frames: nothing so large is passed on or begun
/// with zeros.
pub(crate) trait Links<const N: usize, T: Real> {
    /// The numbers of the frames, where they are kept.
    type Kept: Copy;

    /// A joint with its link.
    fn joint(&self, i: usize) -> Joint<T>;

    /// Gravity in the prepared base's axes [m/s²].
    fn gravity(&self) -> V3<T>;

    /// Puts what turns a frame in its place.
    fn keep_turn(&self, turn: &Turn<T>, place: &mut Frame<Self::Kept>);

    /// Puts what accelerates its points in its place.
    fn keep_motion(&self, a: V3<T>, s: &Spread<T>, place: &mut Frame<Self::Kept>);

    /// Puts what accelerates all beyond a joint in its place.
    fn keep_column(&self, column: &Wrench<T>, place: &mut Frame<Self::Kept>);

    /// The frame that was put there.
    fn kept(&self, place: &Frame<Self::Kept>) -> Frame<T>;

    /// Finds the frames at q, and how they move under gravity with q̇.
    #[inline(always)]
    fn find(&self, q: &Vector<N, T>, dq: &Vector<N, T>, frames: &mut Frames<N, Self::Kept>) {
        let gravity = self.gravity();
        let zero = V3::zero_like(gravity.x);
        let mut moving = Moving::base(zero - gravity);
        // Turns do not wait for each other, motions do.
        for i in 0..N {
            self.keep_turn(&self.joint(i).turn(q[i]), &mut frames[i]);
        }
        for i in 0..N {
            let Frame { turn, .. } = self.kept(&frames[i]);
            moving = moving.outward(&turn, self.joint(i).revolute, dq[i], zero.x);
            self.keep_motion(moving.a, &moving.s, &mut frames[i]);
        }
    }

    /// C q̇ + G.
    #[inline(always)]
    fn bias(&self, frames: &Frames<N, Self::Kept>) -> Vector<N, T> {
        let zero = V3::zero_like(self.gravity().x);
        let mut tau = column([zero.x; N]);
        let mut beyond = Wrench { f: zero, n: zero };
        for i in (0..N).rev() {
            let (joint, Frame { turn, a, s, .. }) = (self.joint(i), self.kept(&frames[i]));
            let all = joint.wrench(&s, a).plus(&beyond);
            tau[i] = all.along(joint.revolute);
            if i > 0 {
                beyond = all.inward(&turn);
            }
        }
        tau
    }

    /// Writes M(q), armature on the diagonal: as [`Chain::mass_matrix`], column after column.
    #[inline(always)]
    fn write_mass_matrix(&self, frames: &mut Frames<N, Self::Kept>, m: &mut Matrix<N, T>) {
        let mut body = self.joint(N - 1).mass;
        for i in (0..N).rev() {
            let Joint { revolute, armature, .. } = self.joint(i);
            let Frame { turn, .. } = self.kept(&frames[i]);
            self.keep_column(&unit_wrench(&body, revolute), &mut frames[i]);
            for j in i..N {
                let Frame { column, .. } = self.kept(&frames[j]);
                let axis = column.along(revolute);
                (m[(i, j)], m[(j, i)]) = (axis, axis);
                if i > 0 {
                    self.keep_column(&column.inward(&turn), &mut frames[j]);
                }
            }
            m[(i, i)] += armature;
            if i > 0 {
                body = self.joint(i - 1).mass.plus(&body.inward(&turn));
            }
        }
    }
}

/// A chain in single precision.
impl<const N: usize> Links<N, f32> for Chain<N, f32> {
    type Kept = f32;

    #[inline(always)]
    fn joint(&self, i: usize) -> Joint<f32> {
        self.joints[i]
    }

    #[inline(always)]
    fn gravity(&self) -> V3<f32> {
        self.gravity
    }

    #[inline(always)]
    fn keep_turn(&self, turn: &Turn<f32>, place: &mut Frame<f32>) {
        place.turn = *turn;
    }

    #[inline(always)]
    fn keep_motion(&self, a: V3<f32>, s: &Spread<f32>, place: &mut Frame<f32>) {
        (place.a, place.s) = (a, *s);
    }

    #[inline(always)]
    fn keep_column(&self, column: &Wrench<f32>, place: &mut Frame<f32>) {
        place.column = *column;
    }

    #[inline(always)]
    fn kept(&self, place: &Frame<f32>) -> Frame<f32> {
        *place
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

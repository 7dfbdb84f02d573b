//! Chains side by side, a chain a lane.

use super::inertia::PER_LINK;
use super::inverse::{PolarMoving, Spread, Wrench};
use super::joint::{Chain, Joint, Mass};
use super::links::{Frame, Frames, Links};
use super::regressor::Entries;
use super::space::{Sym3, Turn, V3};
use crate::math::{Abreast, LANES, Load, Real, Register, Vector, dot};
use pulp::Simd;

impl<const N: usize> Chain<N, Abreast> {
    /// Chains whose joints are of the same kinds; `None` if they are not.
    pub fn abreast(each: [&Chain<N>; LANES]) -> Option<Self> {
        let [first, ..] = each;
        let kinds = |chain: &Chain<N>| chain.joints.each_ref().map(|joint| joint.revolute);
        each.iter().all(|chain| kinds(chain) == kinds(first)).then(|| Self {
            joints: core::array::from_fn(|i| joints(each.map(|chain| &chain.joints[i]))),
            base: first.base,
            tip: first.tip,
            gravity: vectors(each.map(|chain| &chain.gravity)),
            ground_energy: first.ground_energy,
        })
    }

    /// Whether all frames of one move as those of the other, at every q and q̇.
    pub fn moves_as(&self, other: &Self) -> bool {
        let same = |(one, other): (&Joint<Abreast>, &Joint<Abreast>)| {
            one.revolute == other.revolute && one.rest == other.rest
        };
        self.gravity == other.gravity && self.joints.iter().zip(&other.joints).all(same)
    }
}

/// A part of chains side by side.
pub(crate) struct Part<'a, const N: usize, S: Simd> {
    pub chains: &'a Chain<N, Abreast>,
    pub at: (S, usize),
}

impl<const N: usize, S: Simd> Links<N, Register<S>> for Part<'_, N, S> {
    type Kept = Abreast;

    #[inline(always)]
    fn joint(&self, i: usize) -> Joint<Register<S>> {
        self.chains.joints[i].load(self.at.0, self.at.1)
    }

    #[inline(always)]
    fn gravity(&self) -> V3<Register<S>> {
        self.chains.gravity.load(self.at.0, self.at.1)
    }

    #[inline(always)]
    fn keep_turn(&self, turn: &Turn<Register<S>>, place: &mut Frame<Abreast>) {
        let (Turn { ca, sa, c, s, p }, part) = (&mut place.turn, self.at.1);
        turn.ca.store(ca, part);
        turn.sa.store(sa, part);
        turn.c.store(c, part);
        turn.s.store(s, part);
        turn.p.store(p, part);
    }

    #[inline(always)]
    fn keep_motion(&self, a: V3<Register<S>>, s: &Spread<Register<S>>, place: &mut Frame<Abreast>) {
        a.store(&mut place.a, self.at.1);
        s.store(&mut place.s, self.at.1);
    }

    #[inline(always)]
    fn keep_column(&self, column: &Wrench<Register<S>>, place: &mut Frame<Abreast>) {
        column.f.store(&mut place.column.f, self.at.1);
        column.n.store(&mut place.column.n, self.at.1);
    }

    #[inline(always)]
    fn kept(&self, Frame { turn, a, s, column }: &Frame<Abreast>) -> Frame<Register<S>> {
        let (simd, part) = self.at;
        Frame {
            turn: turn.load(simd, part),
            a: a.load(simd, part),
            s: s.load(simd, part),
            column: Wrench { f: column.f.load(simd, part), n: column.n.load(simd, part) },
        }
    }
}

impl<const N: usize, S: Simd> Part<'_, N, S> {
    /// Cᵀ q̇, from the turns that were found: a column of C is what the polar form gives for one
    /// joint that moves.
    #[inline(always)]
    pub fn carried(
        &self,
        dq: &Vector<N, Register<S>>,
        frames: &mut Frames<N, Abreast>,
    ) -> Vector<N, Register<S>> {
        let zero = V3::zero_like(self.gravity().x);
        let (mut carried, mut column) = (*dq, *dq);
        for j in 0..N {
            let mut moving = PolarMoving::base(zero);
            for i in 0..N {
                let (joint, Frame { turn, .. }) = (self.joint(i), self.kept(&frames[i]));
                let moves = zero.x.like(if i == j { 1.0 } else { 0.0 });
                moving = moving.outward(&turn, joint.revolute, [dq[i], moves, zero.x]);
                self.keep_column(&joint.wrench(&moving.s, moving.a), &mut frames[i]);
            }
            let mut beyond = Wrench { f: zero, n: zero };
            for i in (0..N).rev() {
                let (joint, Frame { turn, column: own, .. }) =
                    (self.joint(i), self.kept(&frames[i]));
                let all = own.plus(&beyond);
                column[i] = all.along(joint.revolute);
                if i > 0 {
                    beyond = all.inward(&turn);
                }
            }
            carried[j] = dot(&column, dq);
        }
        carried
    }
}

impl<const N: usize, S: Simd> Part<'_, N, S> {
    /// Writes the entries of Y(q, q̇, q̈), row by row, from the turns that were found.
    #[inline(always)]
    pub fn write_regressor(
        &self,
        frames: &Frames<N, Abreast>,
        motion: (&Vector<N, Register<S>>, &Vector<N, Register<S>>),
        rows: &mut [Abreast],
    ) {
        let (gravity, part) = (self.gravity(), self.at.1);
        let mut turns = [self.kept(&frames[0]).turn; N];
        for i in 1..N {
            turns[i] = self.kept(&frames[i]).turn;
        }
        let upward = V3::zero_like(gravity.x) - gravity;
        self.chains.write_regressor(&turns, motion, upward, &mut Rows::<N> { rows, part });
    }
}

/// Rows of a regressor of chains side by side.
struct Rows<'a, const N: usize> {
    rows: &'a mut [Abreast],
    part: usize,
}

impl<const N: usize, S: Simd> Entries<Register<S>> for Rows<'_, N> {
    #[inline(always)]
    fn put(&mut self, i: usize, j: usize, torques: &[Register<S>; PER_LINK]) {
        let cells = self.rows[(i * N + j) * PER_LINK..].iter_mut();
        for (to, torque) in cells.zip(torques) {
            torque.store(to, self.part);
        }
    }
}

impl Frame<Abreast> {
    /// Puts the sine and the cosine of a joint in its place.
    #[inline(always)]
    pub fn keep_angle<S: Simd>(&mut self, (sin, cos): (Register<S>, Register<S>), part: usize) {
        sin.store(&mut self.turn.s, part);
        cos.store(&mut self.turn.c, part);
    }

    /// Those that were put there.
    #[inline(always)]
    pub fn angle<S: Simd>(&self, (simd, part): (S, usize)) -> (Register<S>, Register<S>) {
        (self.turn.s.load(simd, part), self.turn.c.load(simd, part))
    }
}

impl<S: Simd> V3<Register<S>> {
    #[inline(always)]
    fn store(&self, V3 { x, y, z }: &mut V3<Abreast>, part: usize) {
        self.x.store(x, part);
        self.y.store(y, part);
        self.z.store(z, part);
    }
}

impl<S: Simd> Spread<Register<S>> {
    #[inline(always)]
    fn store(&self, to: &mut Spread<Abreast>, part: usize) {
        self.xx.store(&mut to.xx, part);
        self.xy.store(&mut to.xy, part);
        self.xz.store(&mut to.xz, part);
        self.yx.store(&mut to.yx, part);
        self.yy.store(&mut to.yy, part);
        self.yz.store(&mut to.yz, part);
        self.zx.store(&mut to.zx, part);
        self.zy.store(&mut to.zy, part);
        self.zz.store(&mut to.zz, part);
    }
}

impl Load for Spread<Abreast> {
    type In<S: Simd> = Spread<Register<S>>;

    #[inline(always)]
    fn load<S: Simd>(&self, simd: S, part: usize) -> Self::In<S> {
        let Self { xx, xy, xz, yx, yy, yz, zx, zy, zz } = self;
        let [xx, xy, xz] = [*xx, *xy, *xz].load(simd, part);
        let [yx, yy, yz] = [*yx, *yy, *yz].load(simd, part);
        let [zx, zy, zz] = [*zx, *zy, *zz].load(simd, part);
        Spread { xx, xy, xz, yx, yy, yz, zx, zy, zz }
    }
}

impl Load for Joint<Abreast> {
    type In<S: Simd> = Joint<Register<S>>;

    #[inline(always)]
    fn load<S: Simd>(&self, simd: S, part: usize) -> Self::In<S> {
        let Self { revolute, rest, mass, armature, friction, user } = self;
        Joint {
            revolute: *revolute,
            rest: rest.load(simd, part),
            mass: mass.load(simd, part),
            armature: armature.load(simd, part),
            friction: *friction,
            user: *user,
        }
    }
}

impl Load for V3<Abreast> {
    type In<S: Simd> = V3<Register<S>>;

    #[inline(always)]
    fn load<S: Simd>(&self, simd: S, part: usize) -> Self::In<S> {
        let Self { x, y, z } = self;
        V3::new(x.load(simd, part), y.load(simd, part), z.load(simd, part))
    }
}

impl Load for Turn<Abreast> {
    type In<S: Simd> = Turn<Register<S>>;

    #[inline(always)]
    fn load<S: Simd>(&self, simd: S, part: usize) -> Self::In<S> {
        let [ca, sa, c, s] = [self.ca, self.sa, self.c, self.s].load(simd, part);
        Turn { ca, sa, c, s, p: self.p.load(simd, part) }
    }
}

impl Load for Mass<Abreast> {
    type In<S: Simd> = Mass<Register<S>>;

    #[inline(always)]
    fn load<S: Simd>(&self, simd: S, part: usize) -> Self::In<S> {
        let Sym3 { xx, yy, zz, xy, xz, yz } = self.sigma;
        let [xx, yy, zz, xy, xz, yz] = [xx, yy, zz, xy, xz, yz].load(simd, part);
        let sigma = Sym3 { xx, yy, zz, xy, xz, yz };
        Mass { m: self.m.load(simd, part), h: self.h.load(simd, part), sigma }
    }
}

fn joints(each: [&Joint; LANES]) -> Joint<Abreast> {
    let [first, ..] = each;
    Joint {
        revolute: first.revolute,
        rest: turns(each.map(|joint| &joint.rest)),
        mass: masses(each.map(|joint| &joint.mass)),
        armature: Abreast::of(each, |joint| joint.armature),
        friction: first.friction,
        user: first.user,
    }
}

fn vectors(each: [&V3; LANES]) -> V3<Abreast> {
    let of = |number: fn(&V3) -> f64| Abreast::of(each, number);
    V3::new(of(|v| v.x), of(|v| v.y), of(|v| v.z))
}

fn turns(each: [&Turn; LANES]) -> Turn<Abreast> {
    let of = |number: fn(&Turn) -> f64| Abreast::of(each, number);
    let p = vectors(each.map(|turn| &turn.p));
    Turn { ca: of(|it| it.ca), sa: of(|it| it.sa), c: of(|it| it.c), s: of(|it| it.s), p }
}

fn masses(each: [&Mass; LANES]) -> Mass<Abreast> {
    let of = |number: fn(&Sym3) -> f64| Abreast::of(each.map(|mass| &mass.sigma), number);
    Mass {
        m: Abreast::of(each, |mass| mass.m),
        h: vectors(each.map(|mass| &mass.h)),
        sigma: Sym3 {
            xx: of(|it| it.xx),
            yy: of(|it| it.yy),
            zz: of(|it| it.zz),
            xy: of(|it| it.xy),
            xz: of(|it| it.xz),
            yz: of(|it| it.yz),
        },
    }
}

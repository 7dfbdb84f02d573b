//! Newton and Euler's recursion from q, q̇, q̈ to the joint torques, and its polar form in two
//! velocities.
//!
//! ```text
//! outward:  ω' = Rᵀω + q̇ z     ω̇' = Rᵀω̇ + Rᵀω × q̇ z + q̈ z     a' = Rᵀ(a + S p)
//! inward:   f = m a + S h + R'f'     n = ∫ r × (a + S r) dm + R'n' + p' × R'f'     τ = zᵀn
//! with      S = [ω̇]ₓ + [ω]ₓ[ω]ₓ
//! ```
//!
//! The moment is `h × a` plus the antisymmetric part of S Σ. A joint that slides adds
//! `2 Rᵀω × q̇ z + q̈ z` to a' instead. In the polar form each product of two velocities becomes
//! half of the sum over both orders, which is C(q, q̇) q̇_r with Christoffel's C. Source:
//! Featherstone, Rigid Body Dynamics Algorithms, ch. 5; Niemeyer and Slotine 1991, for the polar
//! form.

use super::joint::{Chain, Joint};
use super::space::{Turn, V3};
use crate::math::{Matrix, Real, Vector};

/// S: the acceleration of the link's points is a + S r.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spread<T = f64> {
    pub xx: T,
    pub xy: T,
    pub xz: T,
    pub yx: T,
    pub yy: T,
    pub yz: T,
    pub zx: T,
    pub zy: T,
    pub zz: T,
}

impl<T: Real> Spread<T> {
    #[inline(always)]
    pub fn new(w: V3<T>, dw: V3<T>) -> Self {
        let (xx, yy, zz) = (w.x * w.x, w.y * w.y, w.z * w.z);
        Self::from_products([xx, yy, zz], [w.x * w.y, w.x * w.z, w.y * w.z], dw)
    }

    /// With half the products of both orders.
    #[inline(always)]
    pub fn polar(w: V3<T>, wr: V3<T>, dw: V3<T>) -> Self {
        let half = w.x.like(0.5);
        let mixed = [
            half * (w.x * wr.y + w.y * wr.x),
            half * (w.x * wr.z + w.z * wr.x),
            half * (w.y * wr.z + w.z * wr.y),
        ];
        Self::from_products([w.x * wr.x, w.y * wr.y, w.z * wr.z], mixed, dw)
    }

    #[inline(always)]
    fn from_products([xx, yy, zz]: [T; 3], [xy, xz, yz]: [T; 3], dw: V3<T>) -> Self {
        Self {
            xx: -(yy + zz),
            yy: -(xx + zz),
            zz: -(xx + yy),
            xy: xy - dw.z,
            yx: xy + dw.z,
            xz: xz + dw.y,
            zx: xz - dw.y,
            yz: yz - dw.x,
            zy: yz + dw.x,
        }
    }

    /// S r.
    #[inline(always)]
    pub fn at(&self, r: V3<T>) -> V3<T> {
        V3::new(
            self.xx * r.x + self.xy * r.y + self.xz * r.z,
            self.yx * r.x + self.yy * r.y + self.yz * r.z,
            self.zx * r.x + self.zy * r.y + self.zz * r.z,
        )
    }

    /// Sᵀ r.
    #[inline(always)]
    pub fn transposed_at(&self, r: V3<T>) -> V3<T> {
        V3::new(
            self.xx * r.x + self.yx * r.y + self.zx * r.z,
            self.xy * r.x + self.yy * r.y + self.zy * r.z,
            self.xz * r.x + self.yz * r.y + self.zz * r.z,
        )
    }
}

/// Force, and moment about the frame's origin.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wrench<T = f64> {
    pub f: V3<T>,
    pub n: V3<T>,
}

impl Wrench {
    pub const ZERO: Self = Self { f: V3::ZERO, n: V3::ZERO };
}

impl<T: Real> Wrench<T> {
    #[inline(always)]
    pub fn plus(&self, other: &Self) -> Self {
        Self { f: self.f + other.f, n: self.n + other.n }
    }

    /// What of it a joint feels that turns about z, or slides along it.
    #[inline(always)]
    pub fn along(&self, revolute: bool) -> T {
        if revolute { self.n.z } else { self.f.z }
    }

    /// The same in the frame before.
    #[inline(always)]
    pub fn inward(&self, turn: &Turn<T>) -> Self {
        let f = turn.inward(self.f);
        Self { f, n: turn.inward(self.n) + turn.p.cross(f) }
    }
}

impl<T: Real> Joint<T> {
    /// What moves the link's mass. The m, h_z and Σ_zz of a turning link, and the Σ of a sliding
    /// one, belong to the link before.
    #[inline(always)]
    pub(super) fn wrench(&self, s: &Spread<T>, a: V3<T>) -> Wrench<T> {
        let (h, k) = (self.mass.h, &self.mass.sigma);
        if !self.revolute {
            return Wrench { f: a * self.mass.m + s.at(h), n: h.cross(a) };
        }
        let f = V3::new(s.xx * h.x + s.xy * h.y, s.yx * h.x + s.yy * h.y, s.zx * h.x + s.zy * h.y);
        // n = h × a + [(SΣ)_zy − (SΣ)_yz, (SΣ)_xz − (SΣ)_zx, (SΣ)_yx − (SΣ)_xy]
        let zy = s.zx * k.xy + s.zy * k.yy + s.zz * k.yz;
        let yz = s.yx * k.xz + s.yy * k.yz;
        let xz = s.xx * k.xz + s.xy * k.yz;
        let zx = s.zx * k.xx + s.zy * k.xy + s.zz * k.xz;
        let yx = s.yx * k.xx + s.yy * k.xy + s.yz * k.xz;
        let xy = s.xx * k.xy + s.xy * k.yy + s.xz * k.yz;
        let n = V3::new(
            h.y * a.z + (zy - yz),
            (xz - zx) - h.x * a.z,
            (h.x * a.y - h.y * a.x) + (yx - xy),
        );
        Wrench { f, n }
    }
}

/// How the frame of a link moves: the acceleration of its origin, gravity in it, and S, from its
/// angular velocity and acceleration.
#[derive(Clone, Copy)]
pub(super) struct Moving<T> {
    w: V3<T>,
    dw: V3<T>,
    pub a: V3<T>,
    pub s: Spread<T>,
}

impl<T: Real> Moving<T> {
    /// The base, which `upward` accelerates: −g, or zero for none.
    #[inline(always)]
    pub fn base(upward: V3<T>) -> Self {
        let zero = V3::zero_like(upward.x);
        Self { w: zero, dw: zero, a: upward, s: Spread::new(zero, zero) }
    }

    /// The frame that turns so against this one, and does so, or slides, with q̇ and q̈.
    #[inline(always)]
    pub fn outward(&self, turn: &Turn<T>, revolute: bool, dq: T, ddq: T) -> Self {
        let mut a = turn.outward(self.a + self.s.at(turn.p));
        let mut w = turn.outward(self.w);
        let mut dw = turn.outward(self.dw);
        if revolute {
            dw += V3::new(w.y * dq, -w.x * dq, ddq);
            w.z += dq;
        } else {
            let twice = dq + dq;
            a += V3::new(w.y * twice, -w.x * twice, ddq);
        }
        Self { w, dw, a, s: Spread::new(w, dw) }
    }
}

/// The same of the polar form, with both angular velocities.
#[derive(Clone, Copy)]
pub(super) struct PolarMoving<T> {
    w: V3<T>,
    wr: V3<T>,
    dw: V3<T>,
    pub a: V3<T>,
    pub s: Spread<T>,
}

impl<T: Real> PolarMoving<T> {
    /// The base, which `upward` accelerates.
    #[inline(always)]
    pub fn base(upward: V3<T>) -> Self {
        let zero = V3::zero_like(upward.x);
        Self { w: zero, wr: zero, dw: zero, a: upward, s: Spread::new(zero, zero) }
    }

    /// The frame that turns so against this one, and does so, or slides, with q̇, q̇_r and q̈_r.
    #[inline(always)]
    pub fn outward(&self, turn: &Turn<T>, revolute: bool, [dq, dq_r, ddq_r]: [T; 3]) -> Self {
        let zero = dq.like(0.0);
        let mut a = turn.outward(self.a + self.s.at(turn.p));
        let (mut w, mut wr) = (turn.outward(self.w), turn.outward(self.wr));
        let mut dw = turn.outward(self.dw);
        let turning = w.cross_z() * dq_r + wr.cross_z() * dq;
        let faster = V3::new(zero, zero, ddq_r);
        if revolute {
            dw += turning * zero.like(0.5) + faster;
            w.z += dq;
            wr.z += dq_r;
        } else {
            a += turning + faster;
        }
        Self { w, wr, dw, a, s: Spread::polar(w, wr, dw) }
    }
}

impl<const N: usize, T: Real> Chain<N, T> {
    /// M q̈ + C q̇ + G without friction and armature; `upward` is −g, or zero for none.
    #[inline(always)]
    pub fn inverse(
        &self,
        turns: &[Turn<T>; N],
        dq: &Vector<N, T>,
        ddq: Option<&Vector<N, T>>,
        upward: V3<T>,
    ) -> Vector<N, T> {
        let zero = V3::zero_like(upward.x);
        let mut moving = Moving::base(upward);
        let mut wrenches = [Wrench { f: zero, n: zero }; N];
        for i in 0..N {
            let faster = ddq.map_or(zero.x, |ddq| ddq[i]);
            moving = moving.outward(&turns[i], self.joints[i].revolute, dq[i], faster);
            wrenches[i] = self.joints[i].wrench(&moving.s, moving.a);
        }
        self.inward(turns, &wrenches)
    }

    /// The torques that the wrenches on the links ask of the joints.
    #[inline(always)]
    fn inward(&self, turns: &[Turn<T>; N], wrenches: &[Wrench<T>; N]) -> Vector<N, T> {
        let zero = V3::zero_like(self.gravity.x);
        let mut tau = Vector::<N, T>::repeat(zero.x);
        let mut beyond = Wrench { f: zero, n: zero };
        for i in (0..N).rev() {
            let all = wrenches[i].plus(&beyond);
            tau[i] = all.along(self.joints[i].revolute);
            if i > 0 {
                beyond = all.inward(&turns[i]);
            }
        }
        tau
    }
}

impl<const N: usize> Chain<N> {
    /// M q̈_r + C(q, q̇) q̇_r + G, without armature.
    #[inline]
    pub fn polar(
        &self,
        turns: &[Turn; N],
        dq: &Vector<N>,
        (dq_r, ddq_r): (&Vector<N>, &Vector<N>),
        upward: V3,
    ) -> Vector<N> {
        let mut moving = PolarMoving::base(upward);
        let mut wrenches = [Wrench::ZERO; N];
        for i in 0..N {
            let (joint, rates) = (&self.joints[i], [dq[i], dq_r[i], ddq_r[i]]);
            moving = moving.outward(&turns[i], joint.revolute, rates);
            wrenches[i] = joint.wrench(&moving.s, moving.a);
        }
        self.inward(turns, &wrenches)
    }

    /// C(q, q̇) by columns: C eⱼ is what the polar form gives for q̇_r = eⱼ.
    pub fn coriolis(&self, turns: &[Turn; N], dq: &Vector<N>) -> Matrix<N> {
        let mut c = Matrix::<N>::zeros();
        let rest = Vector::<N>::zeros();
        for j in 0..N {
            let mut unit = rest;
            unit[j] = 1.0;
            c.set_column(j, &self.polar(turns, dq, (&unit, &rest), V3::ZERO));
        }
        c
    }

    /// U(q) \[J\].
    pub fn potential_energy(&self, turns: &[Turn; N]) -> f64 {
        let (mut energy, mut g, mut weight) = (self.ground_energy, self.gravity, 0.0);
        for (joint, turn) in self.joints.iter().zip(turns) {
            // weight = gᵀ (origin), g in the axes of the link
            weight += g.dot(turn.p);
            g = turn.outward(g);
            energy -= joint.mass.m * weight + g.dot(joint.mass.h);
        }
        energy
    }
}

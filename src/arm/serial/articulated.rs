//! `q̈ = M⁻¹ τ` in one sweep inward and one outward, by articulated bodies.
//!
//! An articulated inertia takes (ω̇, a) of its link to the wrench that the link needs when the
//! joints beyond are free: `n = I ω̇ + H a`, `f = Hᵀ ω̇ + M a`. With U its column of the joint,
//! `D = zᵀU + armature` and u the torque that is left:
//!
//! ```text
//! inward:   Iᵃ = I − U Uᵀ / D,  pᵃ = p + U u / D, handed to the link before
//! outward:  q̈ = (u − Uᵀ a) / D
//! ```
//!
//! D is what Gauss leaves of M's diagonal, from the tip to the base. Velocities and gravity are in
//! τ already.
//! Source: Featherstone, Rigid Body Dynamics Algorithms, ch. 7.

use super::inverse::Wrench;
use super::joint::{Chain, Mass};
use super::space::{Sym3, Turn, V3};
use crate::math::Vector;

#[derive(Clone, Copy)]
struct Articulated {
    i: Sym3,
    /// Rows of H.
    h: [V3; 3],
    m: Sym3,
}

/// A joint's column U, 1/D and u.
#[derive(Clone, Copy)]
struct Column {
    n: V3,
    f: V3,
    inverse_d: f64,
    u: f64,
}

impl Articulated {
    const ZERO: Self = Self { i: Sym3::ZERO, h: [V3::ZERO; 3], m: Sym3::ZERO };

    /// Adds a rigid body: I = tr(Σ) 1 − Σ, H = [h]ₓ, M = m 1.
    #[inline(always)]
    fn add(&mut self, body: &Mass) {
        let (k, h) = (&body.sigma, body.h);
        self.i = self.i
            + Sym3 {
                xx: k.yy + k.zz,
                yy: k.xx + k.zz,
                zz: k.xx + k.yy,
                xy: -k.xy,
                xz: -k.xz,
                yz: -k.yz,
            };
        self.h[0] += V3::new(0.0, -h.z, h.y);
        self.h[1] += V3::new(h.z, 0.0, -h.x);
        self.h[2] += V3::new(-h.y, h.x, 0.0);
        self.m.xx += body.m;
        self.m.yy += body.m;
        self.m.zz += body.m;
    }

    /// U of a joint that turns about z, or slides along it.
    #[inline(always)]
    fn column(&self, revolute: bool) -> (V3, V3) {
        if revolute {
            (V3::new(self.i.xz, self.i.yz, self.i.zz), self.h[2])
        } else {
            let n = V3::new(self.h[0].z, self.h[1].z, self.h[2].z);
            (n, V3::new(self.m.xz, self.m.yz, self.m.zz))
        }
    }

    /// I − U Uᵀ / D.
    #[inline(always)]
    fn freed(&self, n: V3, f: V3, inverse_d: f64) -> Self {
        let (nd, fd) = (n * inverse_d, f * inverse_d);
        Self {
            i: less(&self.i, n, nd),
            h: [self.h[0] - f * nd.x, self.h[1] - f * nd.y, self.h[2] - f * nd.z],
            m: less(&self.m, f, fd),
        }
    }

    /// About the origin of the frame before, in its axes: H' = H + [p]ₓ M, I' = I − H [p]ₓ + [p]ₓ
    /// H'ᵀ.
    #[inline(always)]
    fn inward(&self, turn: &Turn) -> Self {
        let p = turn.p;
        let (i, m) = (self.i.inward(turn), self.m.inward(turn));
        let h = turned(&self.h, turn);
        let shifted = [
            h[0] + V3::new(m.xz, m.yz, m.zz) * p.y - V3::new(m.xy, m.yy, m.yz) * p.z,
            h[1] + V3::new(m.xx, m.xy, m.xz) * p.z - V3::new(m.xz, m.yz, m.zz) * p.x,
            h[2] + V3::new(m.xy, m.yy, m.yz) * p.x - V3::new(m.xx, m.xy, m.xz) * p.y,
        ];
        // (I' − I)_ab = (p × H_a)_b + (p × H'_b)_a
        let (old, new) = (h.map(|row| p.cross(row)), shifted.map(|row| p.cross(row)));
        let i = Sym3 {
            xx: i.xx + (old[0].x + new[0].x),
            yy: i.yy + (old[1].y + new[1].y),
            zz: i.zz + (old[2].z + new[2].z),
            xy: i.xy + (old[0].y + new[1].x),
            xz: i.xz + (old[0].z + new[2].x),
            yz: i.yz + (old[1].z + new[2].y),
        };
        Self { i, h: shifted, m }
    }
}

/// S − a bᵀ with b parallel to a.
#[inline(always)]
fn less(s: &Sym3, a: V3, b: V3) -> Sym3 {
    Sym3 {
        xx: s.xx - a.x * b.x,
        yy: s.yy - a.y * b.y,
        zz: s.zz - a.z * b.z,
        xy: s.xy - a.x * b.y,
        xz: s.xz - a.x * b.z,
        yz: s.yz - a.y * b.z,
    }
}

/// R H Rᵀ, by rows.
#[inline(always)]
fn turned(h: &[V3; 3], turn: &Turn) -> [V3; 3] {
    let [x, y, z] = h.map(|row| turn.inward(row));
    let (x, y) = (x * turn.c - y * turn.s, x * turn.s + y * turn.c);
    [x, y * turn.ca - z * turn.sa, y * turn.sa + z * turn.ca]
}

impl<const N: usize> Chain<N> {
    /// M(q)⁻¹ τ.
    #[inline(always)]
    pub fn accelerations(&self, turns: &[Turn; N], tau: &Vector<N>) -> Vector<N> {
        let columns = self.columns(turns, tau);
        let mut ddq = Vector::<N>::zeros();
        let (mut dw, mut a) = (V3::ZERO, V3::ZERO);
        for i in 0..N {
            let (turn, column) = (&turns[i], &columns[i]);
            a = turn.outward(a + dw.cross(turn.p));
            dw = turn.outward(dw);
            ddq[i] = (column.u - (column.n.dot(dw) + column.f.dot(a))) * column.inverse_d;
            if self.joints[i].revolute {
                dw.z += ddq[i];
            } else {
                a.z += ddq[i];
            }
        }
        ddq
    }

    /// What is left of the diagonal of M when the joints beyond are free, D; all positive where M
    /// is positive definite.
    pub fn free_inertias(&self, turns: &[Turn; N]) -> [f64; N] {
        self.columns(turns, &Vector::zeros()).map(|column| 1.0 / column.inverse_d)
    }

    #[inline(always)]
    fn columns(&self, turns: &[Turn; N], tau: &Vector<N>) -> [Column; N] {
        let mut columns = [Column { n: V3::ZERO, f: V3::ZERO, inverse_d: 0.0, u: 0.0 }; N];
        let (mut body, mut p) = (Articulated::ZERO, Wrench::ZERO);
        for i in (0..N).rev() {
            let joint = &self.joints[i];
            body.add(&joint.mass);
            let (n, f) = body.column(joint.revolute);
            let (d, load) = if joint.revolute { (n.z, p.n.z) } else { (f.z, p.f.z) };
            let (inverse_d, u) = (1.0 / (d + joint.armature), tau[i] - load);
            columns[i] = Column { n, f, inverse_d, u };
            if i > 0 {
                let rate = u * inverse_d;
                body = body.freed(n, f, inverse_d).inward(&turns[i]);
                p = Wrench { f: p.f + f * rate, n: p.n + n * rate }.inward(&turns[i]);
            }
        }
        columns
    }
}

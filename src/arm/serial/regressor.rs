//! The regressor Y(q, q̇, q̈) of the inertial parameters π: `Y π = M q̈ + C q̇ + G` without
//! friction, stops and armature.
//!
//! Ten parameters a link, about its joint's frame as the link gave it, in Pinocchio's order:
//! m, m c_x, m c_y, m c_z, I_xx, I_xy, I_yy, I_xz, I_yz, I_zz (moments about the frame's origin).
//!
//! The axis of joint i moves link j with the twist (w, v); by virtual work, with a and S of link j
//! as in the inverse dynamics, `Y_ij π_j = v·(m a + S h) + w·(h × a + I ω̇ + ω × I ω)`.

use super::Serial;
use super::inertia::PER_LINK;
use super::inverse::Spread;
use super::joint::Chain;
use super::space::{Turn, V3};
use crate::error::{Result, length};
use crate::math::{Real, Vector};

/// Motion of a link in the axes that its user gave it.
#[derive(Clone, Copy)]
struct LinkMotion<T> {
    w: V3<T>,
    dw: V3<T>,
    a: V3<T>,
}

impl<T: Real> LinkMotion<T> {
    /// The ten torques that unit parameters ask of a joint whose axis moves the link with (w, v).
    #[inline(always)]
    fn torques(&self, w: V3<T>, v: V3<T>) -> [T; PER_LINK] {
        let Self { w: spin, dw, a } = *self;
        let first = Spread::new(spin, dw).transposed_at(v) + a.cross(w);
        // w·(ω × I ω) = (w × ω)·I ω
        let u = w.cross(spin);
        [
            v.dot(a),
            first.x,
            first.y,
            first.z,
            w.x * dw.x + u.x * spin.x,
            across([w.x, dw.y, w.y, dw.x]) + across([u.x, spin.y, u.y, spin.x]),
            w.y * dw.y + u.y * spin.y,
            across([w.x, dw.z, w.z, dw.x]) + across([u.x, spin.z, u.z, spin.x]),
            across([w.y, dw.z, w.z, dw.y]) + across([u.y, spin.z, u.z, spin.y]),
            w.z * dw.z + u.z * spin.z,
        ]
    }
}

#[inline(always)]
fn across<T: Real>([p, dq, q, dp]: [T; 4]) -> T {
    p * dq + q * dp
}

/// Where entries of Y go: those of joint i and of the parameters of link j ≥ i.
pub(super) trait Entries<T> {
    fn put(&mut self, i: usize, j: usize, torques: &[T; PER_LINK]);
}

impl<F: FnMut(usize, usize, f64)> Entries<f64> for F {
    fn put(&mut self, i: usize, j: usize, torques: &[f64; PER_LINK]) {
        torques.iter().enumerate().for_each(|(k, y)| self(i, PER_LINK * j + k, *y));
    }
}

impl<const N: usize, K> Chain<N, K> {
    /// The entries of Y(q, q̇, q̈) that are not zero for every motion, from the turns at q, for a
    /// base that accelerates by `upward`.
    #[inline(always)]
    pub(super) fn write_regressor<T: Real>(
        &self,
        turns: &[Turn<T>; N],
        (dq, ddq): (&Vector<N, T>, &Vector<N, T>),
        upward: V3<T>,
        entries: &mut impl Entries<T>,
    ) {
        let still = V3::zero_like(upward.x);
        let mut motions = [LinkMotion { w: still, dw: still, a: upward }; N];
        let LinkMotion { mut w, mut dw, mut a } = motions[0];
        for i in 0..N {
            let (joint, turn) = (&self.joints[i], &turns[i]);
            a = turn.outward(a + Spread::new(w, dw).at(turn.p));
            w = turn.outward(w);
            dw = turn.outward(dw);
            let faster = V3 { z: ddq[i], ..still };
            if joint.revolute {
                dw += w.cross_z() * dq[i] + faster;
                w.z += dq[i];
            } else {
                a += w.cross_z() * (dq[i] + dq[i]) + faster;
            }
            let user = &joint.user;
            motions[i] =
                LinkMotion { w: w.rotated(user), dw: dw.rotated(user), a: a.rotated(user) };
        }
        let one = still.x.like(1.0);
        for i in 0..N {
            let (mut w, mut v) = (still, still);
            for j in i..N {
                if j > i {
                    v = turns[j].outward(v + w.cross(turns[j].p));
                    w = turns[j].outward(w);
                } else if self.joints[i].revolute {
                    w.z = one;
                } else {
                    v.z = one;
                }
                let user = &self.joints[j].user;
                entries.put(i, j, &motions[j].torques(w.rotated(user), v.rotated(user)));
            }
        }
    }
}

impl<const N: usize> Serial<N> {
    /// Y(q, q̇, q̈), `N` × 10 `N`, row-major into `out`.
    ///
    /// # Errors
    /// `WrongLength` if `out` has another length than 10 `N`².
    pub fn regressor(
        &self,
        q: &Vector<N>,
        dq: &Vector<N>,
        ddq: &Vector<N>,
        out: &mut [f64],
    ) -> Result<()> {
        length("out", out.len(), PER_LINK * N * N)?;
        out.fill(0.0);
        self.each_entry(q, dq, ddq, self.upward(), |n, k, y| out[n * PER_LINK * N + k] = y);
        Ok(())
    }

    /// Adds Y(q, q̇, q̇_r, q̈_r) with Christoffel's C entry by entry, joint and parameter.
    ///
    /// C(q, u) w is symmetric in u and w: a quarter of the difference of r(u + w) and r(u − w).
    pub(in crate::arm) fn add_slotine_li(
        &self,
        q: &Vector<N>,
        dq: &Vector<N>,
        dq_r: &Vector<N>,
        ddq_r: &Vector<N>,
        mut add: impl FnMut(usize, usize, f64),
    ) {
        let (still, flat) = (Vector::zeros(), V3::ZERO);
        self.each_entry(q, &still, ddq_r, self.upward(), &mut add);
        self.each_entry(q, &(dq + dq_r), &still, flat, |n, k, y| add(n, k, 0.25 * y));
        self.each_entry(q, &(dq - dq_r), &still, flat, |n, k, y| add(n, k, -0.25 * y));
    }

    /// The entries of Y(q, q̇, q̈), for a base that accelerates by `upward`.
    fn each_entry(
        &self,
        q: &Vector<N>,
        dq: &Vector<N>,
        ddq: &Vector<N>,
        upward: V3,
        mut entry: impl FnMut(usize, usize, f64),
    ) {
        let Self { chain, .. } = self;
        chain.write_regressor(&chain.turns(q), (dq, ddq), upward, &mut entry);
    }

    /// π, 10 a link, into `out`.
    ///
    /// # Errors
    /// `WrongLength` if `out` has another length than 10 `N`.
    pub fn inertial_parameters(&self, out: &mut [f64]) -> Result<()> {
        length("out", out.len(), PER_LINK * N)?;
        for (cell, link) in out.chunks_exact_mut(PER_LINK).zip(&self.parameters.links) {
            cell.copy_from_slice(&link.inertia.parameters());
        }
        Ok(())
    }
}

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
use super::space::V3;
use crate::error::{Result, length};
use crate::math::Vector;

/// Motion of a link in the axes that its user gave it.
#[derive(Clone, Copy)]
struct LinkMotion {
    w: V3,
    dw: V3,
    a: V3,
}

impl LinkMotion {
    /// The ten torques that unit parameters ask of a joint whose axis moves the link with (w, v).
    fn torques(&self, w: V3, v: V3) -> [f64; PER_LINK] {
        let Self { w: spin, dw, a } = *self;
        let first = Spread::new(spin, dw).transposed_at(v) + a.cross(w);
        // w·(ω × I ω) = (w × ω)·I ω
        let u = w.cross(spin);
        let across = |p: f64, dq: f64, q: f64, dp: f64| p * dq + q * dp;
        [
            v.dot(a),
            first.x,
            first.y,
            first.z,
            w.x * dw.x + u.x * spin.x,
            across(w.x, dw.y, w.y, dw.x) + across(u.x, spin.y, u.y, spin.x),
            w.y * dw.y + u.y * spin.y,
            across(w.x, dw.z, w.z, dw.x) + across(u.x, spin.z, u.z, spin.x),
            across(w.y, dw.z, w.z, dw.y) + across(u.y, spin.z, u.z, spin.y),
            w.z * dw.z + u.z * spin.z,
        ]
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

    /// The entries of Y(q, q̇, q̈) that are not zero for every motion, for a base that accelerates
    /// by `upward`.
    fn each_entry(
        &self,
        q: &Vector<N>,
        dq: &Vector<N>,
        ddq: &Vector<N>,
        upward: V3,
        mut entry: impl FnMut(usize, usize, f64),
    ) {
        let chain = &self.chain;
        let turns = chain.turns(q);
        let motions = self.motions(&turns, dq, ddq, upward);
        for i in 0..N {
            let (mut w, mut v) = (V3::ZERO, V3::ZERO);
            for j in i..N {
                if j > i {
                    v = turns[j].outward(v + w.cross(turns[j].p));
                    w = turns[j].outward(w);
                } else if chain.joints[i].revolute {
                    w.z = 1.0;
                } else {
                    v.z = 1.0;
                }
                let user = &chain.joints[j].user;
                let torques = motions[j].torques(w.rotated(user), v.rotated(user));
                torques.iter().enumerate().for_each(|(k, y)| entry(i, PER_LINK * j + k, *y));
            }
        }
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

    fn motions(
        &self,
        turns: &[super::space::Turn; N],
        dq: &Vector<N>,
        ddq: &Vector<N>,
        upward: V3,
    ) -> [LinkMotion; N] {
        let mut motions = [LinkMotion { w: V3::ZERO, dw: V3::ZERO, a: V3::ZERO }; N];
        let (mut w, mut dw, mut a) = (V3::ZERO, V3::ZERO, upward);
        for i in 0..N {
            let (joint, turn) = (&self.chain.joints[i], &turns[i]);
            a = turn.outward(a + Spread::new(w, dw).at(turn.p));
            w = turn.outward(w);
            dw = turn.outward(dw);
            let faster = V3::new(0.0, 0.0, ddq[i]);
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
        motions
    }
}

//! The mass matrix from composite bodies: column j is the wrench that accelerates everything beyond joint j, walked inward.
//!
//! Source: Featherstone, Rigid Body Dynamics Algorithms, 6.2. The wrenches of all joints beyond walk side by side.

use super::joint::{Chain, Mass};
use super::space::Turn;
use crate::math::Matrix;

/// Wrenches of `N` joints in one frame, side by side.
struct Wrenches<const N: usize> {
    f: [[f64; N]; 3],
    n: [[f64; N]; 3],
}

impl<const N: usize> Wrenches<N> {
    /// Those of the joints from `first` on, in the frame before.
    #[inline(always)]
    fn inward(&mut self, first: usize, turn: &Turn) {
        let Turn { ca, sa, c, s, p } = *turn;
        let ([fx, fy, fz], [nx, ny, nz]) = (&mut self.f, &mut self.n);
        for j in first..N {
            let (x, y) = (c * fx[j] - s * fy[j], s * fx[j] + c * fy[j]);
            let (y, z) = (ca * y - sa * fz[j], sa * y + ca * fz[j]);
            let (u, v) = (c * nx[j] - s * ny[j], s * nx[j] + c * ny[j]);
            let (v, w) = (ca * v - sa * nz[j], sa * v + ca * nz[j]);
            (fx[j], fy[j], fz[j]) = (x, y, z);
            nx[j] = u + (p.y * z - p.z * y);
            ny[j] = v + (p.z * x - p.x * z);
            nz[j] = w + (p.x * y - p.y * x);
        }
    }

    /// Sets joint j's to what accelerates `body` along its axis by 1.
    #[inline(always)]
    fn set(&mut self, j: usize, body: &Mass, revolute: bool) {
        let (h, k) = (body.h, &body.sigma);
        let (f, n) = if revolute {
            ([-h.y, h.x, 0.0], [-k.xz, -k.yz, k.xx + k.yy])
        } else {
            ([0.0, 0.0, body.m], [h.y, -h.x, 0.0])
        };
        for axis in 0..3 {
            self.f[axis][j] = f[axis];
            self.n[axis][j] = n[axis];
        }
    }
}

impl<const N: usize> Chain<N> {
    /// M(q), armature on the diagonal.
    #[inline(always)]
    pub fn mass_matrix(&self, turns: &[Turn; N]) -> Matrix<N> {
        let mut m = Matrix::<N>::zeros();
        let mut wrenches = Wrenches { f: [[0.0; N]; 3], n: [[0.0; N]; 3] };
        let mut beyond = Mass::ZERO;
        for i in (0..N).rev() {
            let joint = &self.joints[i];
            let body = joint.mass.plus(&beyond);
            wrenches.set(i, &body, joint.revolute);
            let row = if joint.revolute { &wrenches.n[2] } else { &wrenches.f[2] };
            for j in i..N {
                m[(i, j)] = row[j];
                m[(j, i)] = row[j];
            }
            m[(i, i)] += joint.armature;
            if i > 0 {
                wrenches.inward(i, &turns[i]);
                beyond = body.inward(&turns[i]);
            }
        }
        m
    }
}

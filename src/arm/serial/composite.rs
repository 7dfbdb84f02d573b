//! The mass matrix from composite bodies: column j is the wrench that accelerates everything beyond joint j, walked inward.
//!
//! Source: Featherstone, Rigid Body Dynamics Algorithms, 6.2. Force and moment turn together.

use super::joint::{Chain, Mass};
use super::space::Turn;
use crate::math::{Matrix, Vector};

/// One component of a force and of its moment, side by side.
type Pair = [f64; 2];

/// a b − c d of a pair.
#[inline(always)]
fn less(a: f64, b: Pair, c: f64, d: Pair) -> Pair {
    [a * b[0] - c * d[0], a * b[1] - c * d[1]]
}

/// a b + c d of a pair.
#[inline(always)]
fn more(a: f64, b: Pair, c: f64, d: Pair) -> Pair {
    [a * b[0] + c * d[0], a * b[1] + c * d[1]]
}

/// A wrench by components.
#[derive(Clone, Copy)]
struct Wrench([Pair; 3]);

impl Wrench {
    /// What accelerates `body` along its axis by 1.
    #[inline(always)]
    fn of(body: &Mass, revolute: bool) -> Self {
        let (h, k) = (body.h, &body.sigma);
        if revolute {
            Self([[-h.y, -k.xz], [h.x, -k.yz], [0.0, k.xx + k.yy]])
        } else {
            Self([[0.0, h.y], [0.0, -h.x], [body.m, 0.0]])
        }
    }

    /// The same in the frame before: R f, and R n + p × R f.
    #[inline(always)]
    fn inward(&self, turn: &Turn) -> Self {
        let (Turn { ca, sa, c, s, p }, [x, y, z]) = (*turn, self.0);
        let (x, y) = (less(c, x, s, y), more(s, x, c, y));
        let (y, z) = (less(ca, y, sa, z), more(sa, y, ca, z));
        let moment = [less(p.y, z, p.z, y), less(p.z, x, p.x, z), less(p.x, y, p.y, x)];
        let with = |v: Pair, m: Pair| [v[0], v[1] + m[0]];
        Self([with(x, moment[0]), with(y, moment[1]), with(z, moment[2])])
    }
}

impl<const N: usize> Chain<N> {
    /// M(q), armature on the diagonal.
    #[inline(always)]
    pub fn mass_matrix(&self, turns: &[Turn; N]) -> Matrix<N> {
        let mut columns = [[0.0; N]; N];
        let mut wrenches = [Wrench([[0.0; 2]; 3]); N];
        let mut beyond = Mass::ZERO;
        for i in (0..N).rev() {
            let joint = &self.joints[i];
            let body = joint.mass.plus(&beyond);
            wrenches[i] = Wrench::of(&body, joint.revolute);
            let along = usize::from(joint.revolute);
            for j in i..N {
                let entry = wrenches[j].0[2][along];
                columns[i][j] = entry;
                columns[j][i] = entry;
            }
            columns[i][i] += joint.armature;
            if i > 0 {
                let turn = &turns[i];
                beyond = body.inward(turn);
                for wrench in &mut wrenches[i..] {
                    *wrench = wrench.inward(turn);
                }
            }
        }
        Matrix::<N>::from(columns)
    }

    /// M(q)⁻¹ τ through `M = Lᵀ D L`, from the last joint to the first as articulated bodies go: fewer operations than theirs
    /// for a short chain.
    #[inline(always)]
    pub fn accelerations_by_factors(&self, turns: &[Turn; N], tau: &Vector<N>) -> Vector<N> {
        let mass = self.mass_matrix(turns);
        // Row k of M is column k; L replaces it below the diagonal.
        let mut rows: [[f64; N]; N] = mass.data.0;
        let mut x: [f64; N] = tau.data.0[0];
        let mut inverse_d = [0.0; N];
        for k in (0..N).rev() {
            inverse_d[k] = 1.0 / rows[k][k];
            let row = rows[k];
            for i in 0..k {
                let share = row[i] * inverse_d[k];
                for j in 0..=i {
                    rows[i][j] -= share * row[j];
                }
                x[i] -= share * x[k];
                rows[k][i] = share;
            }
        }
        for k in 0..N {
            let mut sum = x[k] * inverse_d[k];
            for i in 0..k {
                sum -= rows[k][i] * x[i];
            }
            x[k] = sum;
        }
        Vector::<N>::from(x)
    }
}

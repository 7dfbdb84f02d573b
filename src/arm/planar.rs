//! The closed form of the planar arm of two links, in the numbers of one arm, or of several side by
//! side; [`TwoLink`](super::TwoLink) has the equations.

use crate::math::{Matrix, Real, Vector, column, columns};

/// Parameters in which the dynamics are linear.
const PARAMETERS: usize = 5;

/// The numbers of the closed form, of one arm or of several side by side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Planar<T = f64> {
    /// θ₁, θ₂, θ₃ [kg·m²].
    pub theta: [T; 3],
    /// det M where sin q₂ = 0 [kg²·m⁴].
    pub det_0: T,
    /// Gravity torques of the first link with the second one's mass at its tip, and of the second
    /// link [N·m].
    pub weight: [T; 2],
    pub has_gravity: bool,
}

impl<T: Real> Planar<T> {
    /// M from cos q₂.
    #[inline(always)]
    pub fn mass(&self, cos_2: T) -> Matrix<2, T> {
        let [theta_1, theta_2, theta_3] = self.theta;
        let coupling = theta_2 * cos_2;
        let m12 = theta_3 + coupling;
        let m11 = theta_1 + theta_3 + coupling.like(2.0) * coupling;
        columns([[m11, m12], [m12, theta_3]])
    }

    /// sin q₁ and cos q₁, where there is gravity.
    #[inline(always)]
    pub fn first(&self, q1: T) -> Option<(T, T)> {
        if self.has_gravity { Some(q1.sin_cos()) } else { None }
    }

    /// C q̇ + G from sine and cosine of q₁ where there is gravity, and of q₂.
    #[inline(always)]
    pub fn rigid_at(
        &self,
        first: Option<(T, T)>,
        (sin_2, cos_2): (T, T),
        dq: &Vector<2, T>,
    ) -> Vector<2, T> {
        // C q̇ = [−θ₂ (2 q̇₁q̇₂ + q̇₂²) sin q₂, θ₂ q̇₁² sin q₂]
        let h = self.theta[1] * sin_2;
        let mixed = h.like(2.0) * dq[0] * dq[1] + dq[1] * dq[1];
        let mut bias = column([-h * mixed, h * (dq[0] * dq[0])]);
        if let Some(first) = first {
            let gravity = self.gravity_at(first, (sin_2, cos_2));
            bias[0] += gravity[0];
            bias[1] += gravity[1];
        }
        bias
    }

    /// C from sin q₂, by columns.
    #[inline(always)]
    pub fn coriolis(&self, sin_2: T, dq: &Vector<2, T>) -> [[T; 2]; 2] {
        // c = −θ₂ sin q₂,  C = [c q̇₂, c (q̇₁ + q̇₂); −c q̇₁, 0]
        let c = -self.theta[1] * sin_2;
        [[c * dq[1], -c * dq[0]], [c * (dq[0] + dq[1]), c.like(0.0)]]
    }

    /// G from sine and cosine of q₁ and of q₂, with cos(q₁ + q₂) by the addition theorem.
    #[inline(always)]
    pub fn gravity_at(&self, (sin_1, cos_1): (T, T), (sin_2, cos_2): (T, T)) -> Vector<2, T> {
        let outer = self.weight[1] * (cos_1 * cos_2 - sin_1 * sin_2);
        column([self.weight[0] * cos_1 + outer, outer])
    }

    /// M⁻¹ x with the determinant of [`TwoLink::new`], which cannot cancel.
    #[inline(always)]
    pub fn solve(&self, trig: (T, T), x: [T; 2]) -> Vector<2, T> {
        let mass = self.mass(trig.1);
        let off_axis = self.theta[1] * trig.0;
        let inverse_det = off_axis.like(1.0) / (self.det_0 + off_axis * off_axis);
        column([
            (mass[(1, 1)] * x[0] - mass[(0, 1)] * x[1]) * inverse_det,
            (mass[(0, 0)] * x[1] - mass[(0, 1)] * x[0]) * inverse_det,
        ])
    }

    /// Y(q, q̇, q̇_r, q̈_r) of θ₁, θ₂, θ₃ and the gravity torques of the two links, row by row.
    #[inline(always)]
    pub fn regressor(
        &self,
        q: &Vector<2, T>,
        dq: &Vector<2, T>,
        dq_r: &Vector<2, T>,
        ddq_r: &Vector<2, T>,
    ) -> [[T; PARAMETERS]; 2] {
        let ((sin_2, cos_2), [a1, a2]) = (q[1].sin_cos(), [ddq_r[0], ddq_r[1]]);
        // C q̇_r = θ₂ sin q₂ [−(q̇₁ q̇_r2 + q̇₂ q̇_r1 + q̇₂ q̇_r2), q̇₁ q̇_r1]
        let across = dq[0] * dq_r[1] + dq[1] * dq_r[0] + dq[1] * dq_r[1];
        let coupling = [
            (a1.like(2.0) * a1 + a2) * cos_2 - across * sin_2,
            a1 * cos_2 + dq[0] * dq_r[0] * sin_2,
        ];
        let (zero, one) = (a1.like(0.0), a1.like(1.0));
        let level = if self.has_gravity { one } else { zero };
        let (shoulder, outer) = (level * q[0].sin_cos().1, level * (q[0] + q[1]).sin_cos().1);
        [[a1, coupling[0], a1 + a2, shoulder, outer], [zero, coupling[1], a1 + a2, zero, outer]]
    }

    /// M of as many joints as there are: two.
    #[inline(always)]
    pub fn mass_matrix<const N: usize>(&self, cos_2: T) -> Matrix<N, T> {
        let own = self.mass(cos_2);
        let mut mass = columns([[own[(0, 0)]; N]; N]);
        for i in 0..N {
            for j in 0..N {
                mass[(i, j)] = own[(i.min(1), j.min(1))];
            }
        }
        mass
    }

    /// M and C q̇ + G, from sine and cosine of q₁ where there is gravity, and of q₂.
    #[inline(always)]
    pub fn dynamics<const N: usize>(
        &self,
        first: Option<(T, T)>,
        second: (T, T),
        dq: &Vector<2, T>,
    ) -> (Matrix<N, T>, Vector<N, T>) {
        (self.mass_matrix(second.1), back(&self.rigid_at(first, second, dq)))
    }
}

/// The entries of two joints. Nothing is left of this where `N` is 2; elsewhere nobody asks.
#[inline(always)]
pub(super) fn two<const N: usize, T: Real>(x: &Vector<N, T>) -> Vector<2, T> {
    column([x[0], x[1.min(N - 1)]])
}

/// The way back.
#[inline(always)]
pub(super) fn back<const N: usize, T: Real>(x: &Vector<2, T>) -> Vector<N, T> {
    let mut all = [x[0]; N];
    for n in 1..N {
        all[n] = x[1];
    }
    column(all)
}

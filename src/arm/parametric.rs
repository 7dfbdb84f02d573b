//! Arms whose rigid dynamics are linear in a few inertial parameters:
//! `Y(q, q̇, q̇_r, q̈_r) π = M q̈_r + C q̇_r + G` with Christoffel's C, without friction, stops and
//! armature.

use super::{Arm, Serial, TwoLink};
use crate::math::{Vector, sin_cos};

/// Y, `N` × `K`.
pub type Regressor<const N: usize, const K: usize> = nalgebra::SMatrix<f64, N, K>;

/// An arm of `N` joints whose rigid dynamics are linear in `K` parameters.
pub trait Parametric<const N: usize, const K: usize>: Arm<N> {
    /// Y(q, q̇, q̇_r, q̈_r).
    fn slotine_li_regressor(
        &self,
        q: &Vector<N>,
        dq: &Vector<N>,
        dq_r: &Vector<N>,
        ddq_r: &Vector<N>,
    ) -> Regressor<N, K>;

    /// π of this arm.
    fn inertial_parameters(&self) -> Vector<K>;
}

/// θ₁, θ₂, θ₃ [kg·m²], and the gravity torques of the two links [N·m].
impl Parametric<2, 5> for TwoLink {
    fn slotine_li_regressor(
        &self,
        q: &Vector<2>,
        dq: &Vector<2>,
        dq_r: &Vector<2>,
        ddq_r: &Vector<2>,
    ) -> Regressor<2, 5> {
        let ((sin_2, cos_2), [a1, a2]) = (sin_cos(q[1]), [ddq_r[0], ddq_r[1]]);
        // C q̇_r = θ₂ sin q₂ [−(q̇₁ q̇_r2 + q̇₂ q̇_r1 + q̇₂ q̇_r2), q̇₁ q̇_r1]
        let across = dq[0] * dq_r[1] + dq[1] * dq_r[0] + dq[1] * dq_r[1];
        let coupling =
            [(2.0 * a1 + a2) * cos_2 - across * sin_2, a1 * cos_2 + dq[0] * dq_r[0] * sin_2];
        let level = if self.parameters().gravity == 0.0 { 0.0 } else { 1.0 };
        let [shoulder, outer] = [q[0], q[0] + q[1]].map(|angle| level * sin_cos(angle).1);
        let [first, second] =
            [[a1, coupling[0], a1 + a2, shoulder, outer], [0.0, coupling[1], a1 + a2, 0.0, outer]];
        Regressor::<2, 5>::from_fn(|n, k| if n == 0 { first[k] } else { second[k] })
    }

    fn inertial_parameters(&self) -> Vector<5> {
        let ([one, two, three], [inner, outer]) = (self.theta(), self.weight());
        Vector::<5>::new(one, two, three, inner, outer)
    }
}

/// Ten a link, in the order of [`Serial::regressor`].
macro_rules! serial {
    ($($joints:literal $parameters:literal),*) => {$(
        impl Parametric<$joints, $parameters> for Serial<$joints> {
            fn slotine_li_regressor(
                &self,
                q: &Vector<$joints>,
                dq: &Vector<$joints>,
                dq_r: &Vector<$joints>,
                ddq_r: &Vector<$joints>,
            ) -> Regressor<$joints, $parameters> {
                let mut y = Regressor::<$joints, $parameters>::zeros();
                self.add_slotine_li(q, dq, dq_r, ddq_r, |n, k, value| y[(n, k)] += value);
                y
            }

            fn inertial_parameters(&self) -> Vector<$parameters> {
                let mut all = Vector::<$parameters>::zeros();
                for (cell, link) in all.as_mut_slice().chunks_exact_mut(10).zip(self.links()) {
                    cell.copy_from_slice(&link.inertia.parameters());
                }
                all
            }
        }
    )*};
}

serial!(1 10, 2 20, 3 30, 4 40, 5 50, 6 60, 7 70, 8 80, 9 90, 10 100, 11 110, 12 120);

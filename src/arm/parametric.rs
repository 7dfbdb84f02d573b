//! Arms whose rigid dynamics are linear in a few inertial parameters:
//! `Y(q, q̇, q̇_r, q̈_r) π = M q̈_r + C q̇_r + G` with Christoffel's C, without friction, stops and
//! armature.

use super::{Arm, Inertia, Serial, TwoLink};
use crate::error::{Result, non_negative, positive, within};
use crate::math::{Matrix, Vector};

/// Y, `N` × `K`.
pub type Regressor<const N: usize, const K: usize> = nalgebra::SMatrix<f64, N, K>;

/// An arm of `N` joints whose rigid dynamics are linear in `K` parameters.
pub trait Parametric<const N: usize, const K: usize>: Arm<N> {
    /// Whether the parameters are those of the links, ten each, and not lumped.
    const BODIES: bool = K == 10 * N;

    /// Y(q, q̇, q̇_r, q̈_r).
    fn slotine_li_regressor(
        &self,
        q: &Vector<N>,
        dq: &Vector<N>,
        dq_r: &Vector<N>,
        ddq_r: &Vector<N>,
    ) -> Regressor<N, K>;

    /// Y(q, q̇, q̈) with `Y π = M q̈ + C q̇ + G`, row-major into `rows`, which is `N` × `K` long.
    fn regressor_rows(&self, q: &Vector<N>, dq: &Vector<N>, ddq: &Vector<N>, rows: &mut [f64]) {
        let y = self.slotine_li_regressor(q, dq, dq, ddq);
        for (n, row) in rows.chunks_exact_mut(K).take(N).enumerate() {
            row.iter_mut().enumerate().for_each(|(k, entry)| *entry = y[(n, k)]);
        }
    }

    /// The first parameter that acts on each joint: all before it never do. 0 by default.
    fn first_parameters(&self) -> [usize; N] {
        [0; N]
    }

    /// π of this arm.
    fn inertial_parameters(&self) -> Vector<K>;

    /// The same arm with all its masses and moments of inertia times `scale`, and a ball of `load`
    /// \[kg\] and 5 cm radius at its tip; rotors and friction stay.
    ///
    /// # Errors
    /// `scale`: not finite or not > 0. `payload`: not finite, negative, or the arm has no tip to
    /// carry it.
    fn burdened(&self, scale: f64, load: f64) -> Result<Self>
    where
        Self: Sized;
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
        let rows = self.planar.regressor(q, dq, dq_r, ddq_r);
        Regressor::<2, 5>::from_fn(|n, k| rows[n][k])
    }

    fn inertial_parameters(&self) -> Vector<5> {
        let ([one, two, three], [inner, outer]) = (self.theta(), self.weight());
        Vector::<5>::new(one, two, three, inner, outer)
    }

    fn burdened(&self, scale: f64, load: f64) -> Result<Self> {
        positive("scale", &[scale])?;
        let wanted = "0: a two-link arm has lumped parameters; declare how far its inertia may be \
                      off instead, or use a Serial";
        within("payload", &[load], |load| load == 0.0, wanted)?;
        let mut parameters = *self.parameters();
        parameters.mass = parameters.mass.map(|mass| mass * scale);
        parameters.inertia = parameters.inertia.map(|inertia| inertia * scale);
        Self::new(parameters)
    }
}

/// Of a ball, as a share of its radius squared.
const BALL: f64 = 0.4;
/// Of the ball that stands for a load \[m\].
const LOAD_RADIUS: f64 = 0.05;

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

            fn regressor_rows(
                &self,
                q: &Vector<$joints>,
                dq: &Vector<$joints>,
                ddq: &Vector<$joints>,
                rows: &mut [f64],
            ) {
                // Only a wrong length is refused.
                _ = self.regressor(q, dq, ddq, rows);
            }

            fn first_parameters(&self) -> [usize; $joints] {
                core::array::from_fn(|n| 10 * n)
            }

            fn burdened(&self, scale: f64, load: f64) -> Result<Self> {
                positive("scale", &[scale])?;
                non_negative("payload", &[load])?;
                let parameters = Parametric::inertial_parameters(self) * scale;
                let arm = self.with_parameters(parameters.as_slice())?;
                let moments = Matrix::<3>::identity() * (BALL * load * LOAD_RADIUS * LOAD_RADIUS);
                let ball = Inertia { mass: load, com: nalgebra::Vector3::zeros(), moments };
                if load == 0.0 { Ok(arm) } else { arm.with_payload(&ball) }
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

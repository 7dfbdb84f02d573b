//! `M = Lᵀ D L`, from the last joint to the first as articulated bodies go: fewer operations than
//! theirs for a short chain.
//!
//! L is lower triangular with ones on its diagonal; `1/dₖ` is what Gauss leaves of M's diagonal
//! from the tip to the base.
//! Source: Featherstone, Rigid Body Dynamics Algorithms, 6.4.

use crate::math::{Matrix, Real, Vector, column};

/// The factors of a symmetric matrix; all solutions are NaN if it is not positive definite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Factor<const N: usize, T = f64> {
    /// Row k of L below the diagonal.
    rows: [[T; N]; N],
    inverse_d: [T; N],
}

impl<const N: usize, T: Real> Factor<N, T> {
    /// The factors of `mass`.
    #[inline(always)]
    pub fn of(mass: &Matrix<N, T>) -> Self {
        // Row k of M is column k; L replaces it below the diagonal.
        let mut rows: [[T; N]; N] = mass.data.0;
        let mut inverse_d = rows[0];
        for k in (0..N).rev() {
            let d = rows[k][k];
            inverse_d[k] = d.like(0.0).if_less(d, d.like(1.0) / d, d.like(f64::NAN));
            let row = rows[k];
            for i in 0..k {
                let share = row[i] * inverse_d[k];
                for j in 0..=i {
                    rows[i][j] -= share * row[j];
                }
                rows[k][i] = share;
            }
        }
        Self { rows, inverse_d }
    }

    /// M⁻¹ x.
    #[inline(always)]
    pub fn solve(&self, x: &Vector<N, T>) -> Vector<N, T> {
        let Self { rows, inverse_d } = self;
        let mut x: [T; N] = x.data.0[0];
        for k in (0..N).rev() {
            for i in 0..k {
                x[i] -= rows[k][i] * x[k];
            }
        }
        for k in 0..N {
            let mut sum = x[k] * inverse_d[k];
            for i in 0..k {
                sum -= rows[k][i] * x[i];
            }
            x[k] = sum;
        }
        column(x)
    }

    /// (M⁻¹)ᵢᵢ: `Σₖ (L⁻¹)ᵢₖ² / dₖ`.
    #[cfg(feature = "std")]
    #[inline(always)]
    pub fn inverse_diagonal(&self) -> Vector<N, T> {
        let Self { rows, inverse_d } = self;
        let mut diagonal = column(*inverse_d);
        let mut inverse = *rows;
        for i in 0..N {
            inverse[i][i] = inverse_d[i].like(1.0);
            for k in (0..i).rev() {
                let mut entry = inverse_d[i].like(0.0);
                for j in k..i {
                    entry -= rows[i][j] * inverse[j][k];
                }
                inverse[i][k] = entry;
                diagonal[i] += entry * entry * inverse_d[k];
            }
        }
        diagonal
    }
}

impl<const N: usize> Factor<N> {
    /// A direction x with xᵀ `mass` x ≤ 0 and xₖ = 1 for one k; `None` where `mass` is positive
    /// definite. Dₖ is the first that is not > 0, and Lx = eₖ, so that it is xᵀ `mass` x.
    pub fn indefinite(mass: &Matrix<N>) -> Option<Vector<N>> {
        let Self { rows, inverse_d } = Self::of(mass);
        let k = (0..N).rev().find(|&k| inverse_d[k].is_nan())?;
        let mut x = Vector::zeros();
        x[k] = 1.0;
        for i in k + 1..N {
            x[i] = -(k..i).map(|j| rows[i][j] * x[j]).sum::<f64>();
        }
        Some(x)
    }
}

#[cfg(test)]
#[cfg(feature = "std")]
mod tests {
    use super::*;

    /// A positive definite matrix of the kind that a wrist gives: entries over five decades.
    fn mass() -> Matrix<5> {
        let scale = [2.0, 1.0, 0.1, 1e-3, 1e-5_f64];
        let a =
            Matrix::<5>::from_fn(|i, j| f64::from(u8::from(i == j)) + 0.1 * (i * j) as f64 - 0.2);
        let a = a * a.transpose() + Matrix::<5>::identity();
        Matrix::<5>::from_fn(|i, j| a[(i, j)] * libm::sqrt(scale[i] * scale[j]))
    }

    #[test]
    fn solutions_satisfy_the_equation() {
        let x = Vector::<5>::new(1.0, -2.0, 0.3, 1e-3, -1e-4);
        let back = mass() * Factor::of(&mass()).solve(&x);
        for n in 0..5 {
            assert!((back[n] - x[n]).abs() <= 1e-12 * x.norm(), "{back} {x}");
        }
    }

    #[test]
    fn a_matrix_that_is_not_positive_has_a_direction_that_shows_it() {
        assert_eq!(Factor::indefinite(&mass()), None);
        for k in 0..5 {
            let mut shifted = mass();
            shifted[(k, k)] *= -0.5;
            let x = Factor::indefinite(&shifted).unwrap();
            assert!(x.dot(&(shifted * x)) <= 0.0 && x.amax() >= 1.0, "{x}");
        }
    }

    #[test]
    fn the_diagonal_of_the_inverse_is_that_of_the_columns() {
        let factor = Factor::of(&mass());
        let diagonal = factor.inverse_diagonal();
        for n in 0..5 {
            let mut unit = Vector::<5>::zeros();
            unit[n] = 1.0;
            let wanted = factor.solve(&unit)[n];
            assert!((diagonal[n] / wanted - 1.0).abs() < 1e-12, "{n}: {} {wanted}", diagonal[n]);
        }
    }
}

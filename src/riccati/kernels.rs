//! The two dense kernels of the doubling: product and inverse, column-major, the same bits at every vector width.

use pulp::Arch;

use crate::math::Matrix;

/// From this size on the run-time choice of vector width pays for its call.
const WIDE: usize = 8;

/// A B.
#[inline]
pub(super) fn mul<const S: usize>(a: &Matrix<S>, b: &Matrix<S>) -> Matrix<S> {
    if S < WIDE {
        return a * b;
    }
    let mut c = Matrix::<S>::zeros();
    Arch::new().dispatch(
        #[inline(always)]
        || product(S, a.as_slice(), b.as_slice(), c.as_mut_slice()),
    );
    c
}

/// Aᵀ B A for a symmetric B, exactly symmetric.
#[inline]
pub(super) fn congruence<const S: usize>(a: &Matrix<S>, b: &Matrix<S>) -> Matrix<S> {
    symmetric(&mul(&a.transpose(), &mul(b, a)))
}

/// (A + Aᵀ)/2.
#[inline]
pub(super) fn symmetric<const S: usize>(a: &Matrix<S>) -> Matrix<S> {
    let mut s = *a;
    for j in 0..S {
        for i in 0..j {
            let mean = 0.5 * (a[(i, j)] + a[(j, i)]);
            s[(i, j)] = mean;
            s[(j, i)] = mean;
        }
    }
    s
}

/// A⁻¹ by Gauss–Jordan elimination with row pivoting; `None` for a singular or a non-finite matrix.
#[inline]
pub(super) fn inverse<const S: usize>(a: &Matrix<S>) -> Option<Matrix<S>> {
    let (mut inverse, mut rows, mut factors) = (*a, [0; S], [0.0; S]);
    let regular = if S < WIDE {
        invert(S, inverse.as_mut_slice(), &mut rows, &mut factors)
    } else {
        Arch::new().dispatch(
            #[inline(always)]
            || invert(S, inverse.as_mut_slice(), &mut rows, &mut factors),
        )
    };
    regular.then_some(inverse)
}

#[inline(always)]
fn product(n: usize, a: &[f64], b: &[f64], c: &mut [f64]) {
    let mut i = 0;
    while i + 8 <= n {
        rows_of_product::<8>(n, i, a, b, c);
        i += 8;
    }
    while i + 4 <= n {
        rows_of_product::<4>(n, i, a, b, c);
        i += 4;
    }
    while i < n {
        rows_of_product::<1>(n, i, a, b, c);
        i += 1;
    }
}

#[inline(always)]
fn rows_of_product<const L: usize>(n: usize, i: usize, a: &[f64], b: &[f64], c: &mut [f64]) {
    let mut j = 0;
    while j + 2 <= n {
        tile_of_product::<L, 2>(n, i, j, a, b, c);
        j += 2;
    }
    if j < n {
        tile_of_product::<L, 1>(n, i, j, a, b, c);
    }
}

/// c_ij = Σₖ a_ik b_kj for L rows and W columns, k ascending.
#[inline(always)]
fn tile_of_product<const L: usize, const W: usize>(
    n: usize,
    i: usize,
    j: usize,
    a: &[f64],
    b: &[f64],
    c: &mut [f64],
) {
    let mut sums = [[0.0; L]; W];
    for (k, column) in a.chunks_exact(n).enumerate() {
        let left = &column[i..i + L];
        for w in 0..W {
            let right = b[(j + w) * n + k];
            for l in 0..L {
                sums[w][l] += left[l] * right;
            }
        }
    }
    for w in 0..W {
        c[(j + w) * n + i..][..L].copy_from_slice(&sums[w]);
    }
}

#[inline(always)]
fn invert(n: usize, a: &mut [f64], rows: &mut [usize], factors: &mut [f64]) -> bool {
    for k in 0..n {
        let mut pivot = k;
        for i in k + 1..n {
            if a[i + k * n].abs() > a[pivot + k * n].abs() {
                pivot = i;
            }
        }
        let size = a[pivot + k * n];
        if size == 0.0 || !size.is_finite() {
            return false;
        }
        rows[k] = pivot;
        if pivot != k {
            for j in 0..n {
                a.swap(k + j * n, pivot + j * n);
            }
        }
        factors.copy_from_slice(&a[k * n..(k + 1) * n]);
        let reciprocal = 1.0 / size;
        for (j, column) in a.chunks_exact_mut(n).enumerate() {
            if j == k {
                column.fill(0.0);
            }
            let top = if j == k { reciprocal } else { column[k] * reciprocal };
            for i in 0..n {
                column[i] -= factors[i] * top;
            }
            column[k] = top;
        }
    }
    for k in (0..n).rev() {
        if rows[k] != k {
            for i in 0..n {
                a.swap(i + k * n, i + rows[k] * n);
            }
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scrambled<const S: usize>() -> Matrix<S> {
        let mut x = 0.3;
        Matrix::from_fn(|_, _| {
            x = 3.9 * x * (1.0 - x);
            x - 0.5
        })
    }

    fn check<const S: usize>() {
        let a = scrambled::<S>();
        let b = a.transpose();
        assert!((mul(&a, &b) - a * b).amax() < 1e-14);
        let round_trip = mul(&a, &inverse(&a).unwrap());
        assert!((round_trip - Matrix::identity()).amax() < 1e-11, "{S}");
    }

    #[test]
    fn products_and_inverses_agree_with_nalgebra() {
        check::<1>();
        check::<2>();
        check::<5>();
        check::<8>();
        check::<9>();
        check::<11>();
        check::<14>();
        check::<16>();
    }

    #[test]
    fn singular_and_non_finite_matrices_have_no_inverse() {
        assert!(inverse(&Matrix::<3>::zeros()).is_none());
        assert!(inverse(&Matrix::<9>::from_element(f64::NAN)).is_none());
    }
}

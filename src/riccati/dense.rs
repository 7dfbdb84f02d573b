//! The dense matrices of the doubling: product and inverse, column-major, the same bits at every
//! vector width.
//!
//! Sizes are known when compiling (no allocation) or when running: one text for both.

use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, OMatrix};
use pulp::Arch;

use crate::eigen::Complex;

/// A square matrix of size S, on the stack (`Const<S>`) or on the heap (`Dyn`).
pub(super) type Square<S> = OMatrix<f64, S, S>;
/// A matrix of S rows and M columns.
pub(super) type Tall<S, M> = OMatrix<f64, S, M>;

/// The eigenvalues of a square matrix.
pub(super) type Modes<S> = OMatrix<Complex, S, nalgebra::U1>;

/// What has room for S states and M inputs: one bound instead of six.
pub(super) trait Room<S: Dim, M: Dim>:
    Allocator<S>
    + Allocator<M>
    // Square, then wide and tall.
    + Allocator<S, S>
    + Allocator<M, M>
    + Allocator<S, M>
    + Allocator<M, S>
{
}

impl<S: Dim, M: Dim> Room<S, M> for DefaultAllocator where
    DefaultAllocator: Allocator<S, S>
        + Allocator<S, M>
        + Allocator<M, S>
        + Allocator<M, M>
        + Allocator<S>
        + Allocator<M>
{
}

/// From this size on the run-time choice of vector width pays for its call.
const WIDE: usize = 8;
/// Up to this many terms a panel of A stays in the cache as it lies; beyond, it is copied together.
const SHALLOW: usize = 32;
/// Terms of one copied panel: 16 kB.
const DEPTH: usize = 256;
/// Rows of a panel.
const ROWS: usize = 8;
/// Columns of B worked on at once.
const COLUMNS: usize = 4;

/// A B.
#[inline]
pub(super) fn mul<R: Dim, K: Dim, C: Dim>(
    a: &OMatrix<f64, R, K>,
    b: &OMatrix<f64, K, C>,
) -> OMatrix<f64, R, C>
where
    DefaultAllocator: Allocator<R, K> + Allocator<K, C> + Allocator<R, C>,
{
    let (rows, inner) = a.shape_generic();
    let mut c = OMatrix::zeros_generic(rows, b.shape_generic().1);
    let (rows, inner) = (rows.value(), inner.value());
    let (a, b, into) = (a.as_slice(), b.as_slice(), c.as_mut_slice());
    if rows < WIDE {
        product(rows, inner, a, b, into);
    } else {
        Arch::new().dispatch(
            #[inline(always)]
            || product(rows, inner, a, b, into),
        );
    }
    c
}

/// Aᵀ B A for a symmetric B, exactly symmetric.
#[inline]
pub(super) fn congruence<S: Dim>(a: &Square<S>, b: &Square<S>) -> Square<S>
where
    DefaultAllocator: Allocator<S, S>,
{
    symmetric(mul(&a.transpose(), &mul(b, a)))
}

/// (A + Aᵀ)/2.
#[inline]
pub(super) fn symmetric<S: Dim>(mut a: Square<S>) -> Square<S>
where
    DefaultAllocator: Allocator<S, S>,
{
    for j in 0..a.ncols() {
        for i in 0..j {
            let mean = 0.5 * (a[(i, j)] + a[(j, i)]);
            a[(i, j)] = mean;
            a[(j, i)] = mean;
        }
    }
    a
}

/// A + s I.
#[inline]
pub(super) fn plus_diagonal<S: Dim>(mut a: Square<S>, s: f64) -> Square<S>
where
    DefaultAllocator: Allocator<S, S>,
{
    for i in 0..a.nrows() {
        a[(i, i)] += s;
    }
    a
}

/// A⁻¹ by Gauss–Jordan elimination with row pivoting; `None` for a singular or a non-finite matrix.
#[inline]
pub(super) fn inverse<S: Dim>(mut a: Square<S>) -> Option<Square<S>>
where
    DefaultAllocator: Allocator<S, S> + Allocator<S>,
{
    let size = a.shape_generic().0;
    let n = size.value();
    let mut rows = OMatrix::from_element_generic(size, nalgebra::U1, 0_usize);
    let mut factors = OMatrix::from_element_generic(size, nalgebra::U1, 0.0);
    let (entries, rows, factors) = (a.as_mut_slice(), rows.as_mut_slice(), factors.as_mut_slice());
    let regular = if n < WIDE {
        invert(n, entries, rows, factors)
    } else {
        Arch::new().dispatch(
            #[inline(always)]
            || invert(n, entries, rows, factors),
        )
    };
    regular.then_some(a)
}

/// C = A B for an A of `rows` × `inner`, panel by panel of its rows.
#[inline(always)]
fn product(rows: usize, inner: usize, a: &[f64], b: &[f64], c: &mut [f64]) {
    let mut i = 0;
    if inner > SHALLOW {
        let mut panel = [0.0; DEPTH * ROWS];
        while i + ROWS <= rows {
            copied_panel(rows, inner, i, a, b, c, &mut panel);
            i += ROWS;
        }
    }
    while i + ROWS <= rows {
        rows_of_product::<ROWS>(rows, inner, i, a, b, c);
        i += ROWS;
    }
    while i + 4 <= rows {
        rows_of_product::<4>(rows, inner, i, a, b, c);
        i += 4;
    }
    while i < rows {
        rows_of_product::<1>(rows, inner, i, a, b, c);
        i += 1;
    }
}

/// Rows i.. of C, [`DEPTH`] terms at a time; each sum goes on where it was, so that its bits do not
/// depend on the depth.
#[inline(always)]
fn copied_panel(
    rows: usize,
    inner: usize,
    i: usize,
    a: &[f64],
    b: &[f64],
    c: &mut [f64],
    panel: &mut [f64],
) {
    let mut first = 0;
    while first < inner {
        let depth = DEPTH.min(inner - first);
        for (k, into) in panel.chunks_exact_mut(ROWS).take(depth).enumerate() {
            into.copy_from_slice(&a[(first + k) * rows + i..][..ROWS]);
        }
        let panel = Terms { a: &panel[..depth * ROWS], stride: ROWS, b, inner, first };
        tiles::<ROWS>(&panel, &mut c[i..], rows);
        first += depth;
    }
}

#[inline(always)]
fn rows_of_product<const L: usize>(
    rows: usize,
    inner: usize,
    i: usize,
    a: &[f64],
    b: &[f64],
    c: &mut [f64],
) {
    let terms = Terms { a: a.get(i..).unwrap_or(&[]), stride: rows, b, inner, first: 0 };
    tiles::<L>(&terms, &mut c[i..], rows);
}

/// Some terms of a product: L rows of A, of which the terms from `first` on stand `stride` apart,
/// and all of B.
struct Terms<'a> {
    a: &'a [f64],
    stride: usize,
    b: &'a [f64],
    inner: usize,
    first: usize,
}

/// Adds the terms to L rows of C, of which the columns stand `rows` apart.
#[inline(always)]
fn tiles<const L: usize>(terms: &Terms, c: &mut [f64], rows: usize) {
    let columns = terms.b.len() / terms.inner.max(1);
    let mut j = 0;
    while j + COLUMNS <= columns {
        tile::<L, COLUMNS>(terms, j, c, rows);
        j += COLUMNS;
    }
    while j < columns {
        tile::<L, 1>(terms, j, c, rows);
        j += 1;
    }
}

/// c_ij += Σₖ a_ik b_kj for L rows and W columns, k ascending.
#[inline(always)]
fn tile<const L: usize, const W: usize>(terms: &Terms, j: usize, c: &mut [f64], rows: usize) {
    let mut sums = [[0.0; L]; W];
    for w in 0..W {
        sums[w].copy_from_slice(&c[(j + w) * rows..][..L]);
    }
    let right: [&[f64]; W] = core::array::from_fn(|w| {
        &terms.b[(j + w) * terms.inner + terms.first..(j + w + 1) * terms.inner]
    });
    for (k, left) in terms.a.chunks(terms.stride).enumerate() {
        let left = &left[..L];
        for w in 0..W {
            let right = right[w][k];
            for l in 0..L {
                sums[w][l] += left[l] * right;
            }
        }
    }
    for w in 0..W {
        c[(j + w) * rows..][..L].copy_from_slice(&sums[w]);
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
    use nalgebra::{Const, SMatrix};

    fn scrambled<const R: usize, const C: usize>() -> SMatrix<f64, R, C> {
        let mut x = 0.3;
        SMatrix::from_fn(|_, _| {
            x = 3.9 * x * (1.0 - x);
            x - 0.5
        })
    }

    fn check<const R: usize, const K: usize>() {
        let a = scrambled::<R, R>();
        let b = scrambled::<R, K>();
        assert!((mul(&a, &b) - a * b).amax() < 1e-14 * R as f64);
        let round_trip = mul(&a, &inverse(a).unwrap());
        assert!((round_trip - SMatrix::<f64, R, R>::identity()).amax() < 1e-11, "{R}");
    }

    #[test]
    fn products_and_inverses_agree_with_nalgebra() {
        check::<1, 3>();
        check::<2, 1>();
        check::<5, 2>();
        check::<8, 8>();
        check::<9, 4>();
        check::<11, 5>();
        check::<14, 7>();
        check::<16, 1>();
        check::<45, 3>();
    }

    #[cfg(feature = "std")]
    #[test]
    fn heap_and_stack_give_the_same_bits_at_any_depth() {
        let a =
            nalgebra::DMatrix::from_fn(19, 600, |i, j| ((i * 31 + j * 17) % 23) as f64 / 7.0 - 1.0);
        let b =
            nalgebra::DMatrix::from_fn(600, 5, |i, j| ((i * 13 + j * 29) % 31) as f64 / 9.0 - 1.0);
        let c = mul(&a, &b);
        for (i, j) in [(0, 0), (7, 4), (8, 1), (18, 3)] {
            let sum = (0..600).fold(0.0, |sum, k| sum + a[(i, k)] * b[(k, j)]);
            assert_eq!(c[(i, j)], sum);
        }
        let small = scrambled::<14, 14>();
        let heap = nalgebra::DMatrix::from_column_slice(14, 14, small.as_slice());
        assert_eq!(inverse(small).unwrap().as_slice(), inverse(heap).unwrap().as_slice());
    }

    #[test]
    fn singular_and_non_finite_matrices_have_no_inverse() {
        assert!(inverse::<Const<3>>(SMatrix::zeros()).is_none());
        assert!(inverse::<Const<9>>(SMatrix::from_element(f64::NAN)).is_none());
    }
}

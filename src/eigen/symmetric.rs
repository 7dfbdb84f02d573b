//! Eigenvalues of symmetric matrices.

use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, OMatrix, OVector, U1};

use super::power_of_two_near;
use crate::error::{Error, Result, finite};
use crate::math::{Matrix, sqrt};

/// QL sweeps allowed per eigenvalue; two is usual, EISPACK's limit is 30.
const SWEEPS: usize = 60;
/// A subdiagonal entry below this is zero, next to a largest entry of 1/2..1: what is left of a
/// block of zeros by rounding.
const NEGLIGIBLE: f64 = 1e-17;

/// The eigenvalues of the symmetric matrix `a`, in no particular order; only its lower triangle is
/// read.
///
/// # Errors
/// `NotFinite` for NaN or an infinity, `NoConvergence` if 60 QL sweeps do not suffice for one of
/// them.
pub fn symmetric_eigenvalues<const S: usize>(a: &Matrix<S>) -> Result<[f64; S]> {
    Ok(symmetric_spectrum(a)?.into())
}

/// [`symmetric_eigenvalues`] of a matrix whose size is known when compiling or when running.
pub(crate) fn symmetric_spectrum<S: Dim>(a: &OMatrix<f64, S, S>) -> Result<OVector<f64, S>>
where
    DefaultAllocator: Allocator<S, S> + Allocator<S>,
{
    finite("a", a.as_slice())?;
    let (size, mut work) = (a.shape_generic().0, a.clone());
    let mut values = OVector::zeros_generic(size, U1);
    let mut off = values.clone();
    let (into, off) = (values.as_mut_slice(), off.as_mut_slice());
    symmetric_in_place(size.value(), work.as_mut_slice(), into, off)?;
    Ok(values)
}

/// The smallest eigenvalue of the symmetric matrix `a`, to about 1e-15 of the largest.
///
/// # Errors
/// As [`symmetric_eigenvalues`].
pub fn symmetric_min<const S: usize>(a: &Matrix<S>) -> Result<f64> {
    Ok(symmetric_eigenvalues(a)?.iter().fold(f64::INFINITY, |least, &x| least.min(x)))
}

/// Eigenvalues of the finite n×n matrix in `a` (lower triangle, column-major), which is destroyed;
/// `off` is scratch.
pub(crate) fn symmetric_in_place(
    n: usize,
    a: &mut [f64],
    values: &mut [f64],
    off: &mut [f64],
) -> Result<()> {
    let scale = power_of_two_near(a.iter().fold(0.0, |most: f64, x| most.max(x.abs())));
    a.iter_mut().for_each(|x| *x /= scale);
    for k in 0..n {
        values[k] = a[k + k * n];
        off[k] = reflect(n, k, a, values);
    }
    implicit_ql(values, off)?;
    values.iter_mut().for_each(|x| *x *= scale);
    Ok(())
}

/// One Householder step: clears column k below the subdiagonal, and returns the subdiagonal entry.
///
/// `A ← A − v wᵀ − w vᵀ` on the rows and columns after k, with v the reflector, `p = A v / h`,
/// `w = p − v (pᵀv)/2h`.
fn reflect(n: usize, k: usize, a: &mut [f64], scratch: &mut [f64]) -> f64 {
    if k + 1 >= n {
        return 0.0;
    }
    let (left, right) = a.split_at_mut((k + 1) * n);
    let v = &mut left[k * n..];
    let tail: f64 = v[k + 2..].iter().map(|x| x * x).sum();
    if tail == 0.0 {
        return v[k + 1];
    }
    let alpha = -sqrt(v[k + 1] * v[k + 1] + tail).copysign(v[k + 1]);
    let h = alpha * alpha - v[k + 1] * alpha;
    v[k + 1] -= alpha;
    let p = &mut scratch[k + 1..n];
    p.fill(0.0);
    let v = &v[k + 1..];
    // Row k+1+i of the trailing block lives at right[k+1+i + j n].
    for j in 0..p.len() {
        let column = &right[j * n + k + 1..(j + 1) * n];
        p[j] += column[j] * v[j];
        for i in j + 1..p.len() {
            p[i] += column[i] * v[j];
            p[j] += column[i] * v[i];
        }
    }
    let mut overlap = 0.0;
    for j in 0..p.len() {
        p[j] /= h;
        overlap += p[j] * v[j];
    }
    for j in 0..p.len() {
        p[j] -= overlap / (2.0 * h) * v[j];
    }
    for j in 0..p.len() {
        let column = &mut right[j * n + k + 1..(j + 1) * n];
        for i in j..p.len() {
            column[i] -= v[i] * p[j] + p[i] * v[j];
        }
    }
    alpha
}

/// Eigenvalues of the tridiagonal matrix with diagonal `d` and subdiagonal `e` (its last entry is
/// ignored).
fn implicit_ql(d: &mut [f64], e: &mut [f64]) -> Result<()> {
    let n = d.len();
    for l in 0..n {
        let mut sweeps = 0;
        loop {
            let end = (l..n - 1).find(|&m| {
                let around = d[m].abs() + d[m + 1].abs();
                e[m].abs() + around == around || e[m].abs() < NEGLIGIBLE
            });
            let m = end.unwrap_or(n - 1);
            if m == l {
                break;
            }
            sweeps += 1;
            if sweeps > SWEEPS {
                return Err(Error::no_convergence("symmetric eigenvalues"));
            }
            ql_sweep(d, e, l, m);
        }
    }
    Ok(())
}

/// One QL sweep with Wilkinson's shift on rows l..=m.
fn ql_sweep(d: &mut [f64], e: &mut [f64], l: usize, m: usize) {
    let g = (d[l + 1] - d[l]) / (2.0 * e[l]);
    let r = libm::hypot(g, 1.0);
    let mut g = d[m] - d[l] + e[l] / (g + r.copysign(g));
    let (mut s, mut c, mut p) = (1.0, 1.0, 0.0);
    for i in (l..m).rev() {
        let f = s * e[i];
        let b = c * e[i];
        let r = libm::hypot(f, g);
        e[i + 1] = r;
        if r == 0.0 {
            d[i + 1] -= p;
            e[m] = 0.0;
            return;
        }
        s = f / r;
        c = g / r;
        g = d[i + 1] - p;
        let t = (d[i] - g) * s + 2.0 * c * b;
        p = s * t;
        d[i + 1] = g + p;
        g = c * t - b;
    }
    d[l] -= p;
    e[l] = g;
    e[m] = 0.0;
}

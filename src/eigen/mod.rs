//! Eigenvalues of small real matrices with a fixed limit on the iterations.
//!
//! General matrices: balancing, reduction to Hessenberg form, Francis double-shift QR. Symmetric
//! ones: Householder tridiagonalisation, implicit QL. Both are backward stable: the result is exact
//! for a matrix within a few `S ε ‖A‖` of the given one, so that a defective eigenvalue of
//! multiplicity m is good to `ε^(1/m)` only.
//!
//! Source: Wilkinson and Reinsch, Handbook for Automatic Computation II, contributions II/1, II/2,
//! II/3, II/11, II/13 and II/14 (EISPACK's balanc, elmhes, hqr, tred1, tql1).

use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, OMatrix, OVector, U1};

use crate::error::{Error, Result, finite};
use crate::math::{Matrix, sqrt};

mod symmetric;

pub use symmetric::{symmetric_eigenvalues, symmetric_min};
pub(crate) use symmetric::{symmetric_in_place, symmetric_spectrum};

/// A complex number.
pub type Complex = nalgebra::Complex<f64>;

/// QR sweeps allowed per eigenvalue, over all of them together; two or three is usual.
const SWEEPS_PER_EIGENVALUE: usize = 60;
/// An eigenvalue that takes this many sweeps more gets an exceptional shift, against cycling.
const SWEEPS_BEFORE_SHIFT: usize = 10;
/// Rounds of balancing; each one that goes on has shrunk some row and column by 5 % or more.
const BALANCING_ROUNDS: usize = 40;
/// Balancing goes on while it shrinks a row plus column below this share of what it was.
const BALANCING_GAIN: f64 = 0.95;

/// A subdiagonal entry below this is zero, next to a largest entry of 1: dividing by it would
/// overflow.
const NEGLIGIBLE: f64 = 1e-290;

/// The eigenvalues of `a`, in no particular order, complex pairs next to each other.
///
/// # Errors
/// `NotFinite` for NaN or an infinity, `NoConvergence` if 60 `S` QR sweeps do not suffice.
pub fn eigenvalues<const S: usize>(a: &Matrix<S>) -> Result<[Complex; S]> {
    Ok(spectrum(a)?.into())
}

/// [`eigenvalues`] of a matrix whose size is known when compiling or when running.
pub(crate) fn spectrum<S: Dim>(a: &OMatrix<f64, S, S>) -> Result<OVector<Complex, S>>
where
    DefaultAllocator: Allocator<S, S> + Allocator<S>,
{
    finite("a", a.as_slice())?;
    let (size, mut h) = (a.shape_generic().0, a.clone());
    let mut values = OVector::from_element_generic(size, U1, Complex::new(0.0, 0.0));
    eigenvalues_in_place(size.value(), h.as_mut_slice(), values.as_mut_slice())?;
    Ok(values)
}

/// The spectral abscissa: the largest real part of the eigenvalues of `a` [the unit of `a`].
///
/// # Errors
/// As [`eigenvalues`].
pub fn max_real<const S: usize>(a: &Matrix<S>) -> Result<f64> {
    Ok(largest_real(&eigenvalues(a)?))
}

pub(crate) fn largest_real(values: &[Complex]) -> f64 {
    values.iter().fold(f64::NEG_INFINITY, |most, z| most.max(z.re))
}

/// The spectral radius: the largest modulus of the eigenvalues of `a` [the unit of `a`].
///
/// # Errors
/// As [`eigenvalues`].
pub fn spectral_radius<const S: usize>(a: &Matrix<S>) -> Result<f64> {
    Ok(eigenvalues(a)?.iter().fold(0.0, |most: f64, &z| most.max(modulus(z))))
}

/// |z|, without overflow.
pub(crate) fn modulus(z: Complex) -> f64 {
    libm::hypot(z.re, z.im)
}

/// A power of two within a factor of 2 of |x|; 1 for zero.
pub(crate) fn power_of_two_near(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { libm::ldexp(1.0, libm::frexp(x).1.clamp(-1020, 1020)) }
}

/// Eigenvalues of the finite n×n matrix in `h` (column-major), which is destroyed.
pub(crate) fn eigenvalues_in_place(n: usize, h: &mut [f64], values: &mut [Complex]) -> Result<()> {
    // A power of two brings the largest entry to 1/2..1: sums of squares neither overflow nor
    // vanish.
    let scale = power_of_two_near(h.iter().fold(0.0, |most: f64, x| most.max(x.abs())));
    h.iter_mut().for_each(|x| *x /= scale);
    let mut h = Square { n, entries: h };
    balance(&mut h);
    hessenberg(&mut h);
    francis(&mut h, values)?;
    if values.iter().any(|z| !(z.re.is_finite() && z.im.is_finite())) {
        return Err(Error::no_convergence("eigenvalues"));
    }
    for z in values {
        *z *= scale;
    }
    Ok(())
}

struct Square<'a> {
    n: usize,
    entries: &'a mut [f64],
}

impl core::ops::Index<(usize, usize)> for Square<'_> {
    type Output = f64;
    #[inline(always)]
    fn index(&self, (i, j): (usize, usize)) -> &f64 {
        &self.entries[i + j * self.n]
    }
}

impl core::ops::IndexMut<(usize, usize)> for Square<'_> {
    #[inline(always)]
    fn index_mut(&mut self, (i, j): (usize, usize)) -> &mut f64 {
        &mut self.entries[i + j * self.n]
    }
}

/// D⁻¹ H D with powers of two in D, so that each row is about as large as its column.
fn balance(h: &mut Square) {
    for _ in 0..BALANCING_ROUNDS {
        let mut changed = false;
        for i in 0..h.n {
            let (mut row, mut column) = (0.0, 0.0);
            for j in (0..h.n).filter(|&j| j != i) {
                row += h[(i, j)].abs();
                column += h[(j, i)].abs();
            }
            let Some(d) = balancing_factor(row, column) else { continue };
            changed = true;
            for j in 0..h.n {
                h[(i, j)] /= d;
                h[(j, i)] *= d;
            }
        }
        if !changed {
            return;
        }
    }
}

/// The power of two d ≠ 1 that makes row/d and column·d about equal, if it makes their sum smaller.
pub(crate) fn balancing_factor(row: f64, column: f64) -> Option<f64> {
    if row == 0.0 || column == 0.0 {
        return None;
    }
    let d = libm::ldexp(1.0, (libm::frexp(row).1 - libm::frexp(column).1) / 2);
    (d != 1.0 && row / d + column * d < BALANCING_GAIN * (row + column)).then_some(d)
}

/// H to Hessenberg form by elimination with pivoting; the entries below the subdiagonal end as
/// zeros.
fn hessenberg(h: &mut Square) {
    for m in 1..h.n.saturating_sub(1) {
        let column = m - 1;
        let mut pivot = m;
        for i in m + 1..h.n {
            if h[(i, column)].abs() > h[(pivot, column)].abs() {
                pivot = i;
            }
        }
        if h[(pivot, column)] == 0.0 {
            continue;
        }
        if pivot != m {
            for j in column..h.n {
                h.entries.swap(pivot + j * h.n, m + j * h.n);
            }
            for i in 0..h.n {
                h.entries.swap(i + pivot * h.n, i + m * h.n);
            }
        }
        eliminate(h, m);
    }
}

/// Clears column m−1 below row m by row operations, and undoes them on the columns.
fn eliminate(h: &mut Square, m: usize) {
    let n = h.n;
    let pivot = h[(m, m - 1)];
    for i in m + 1..n {
        h[(i, m - 1)] /= pivot;
    }
    let (left, right) = h.entries.split_at_mut(m * n);
    let factors = &mut left[(m - 1) * n..];
    for column in right.chunks_exact_mut(n) {
        let top = column[m];
        for i in m + 1..n {
            column[i] -= factors[i] * top;
        }
    }
    let (target, others) = right.split_at_mut(n);
    for (i, column) in (m + 1..n).zip(others.chunks_exact(n)) {
        for k in 0..n {
            target[k] += factors[i] * column[k];
        }
        factors[i] = 0.0;
    }
}

/// The three numbers of the double shift: x = h_nn, y = h_(n−1,n−1), w = h_(n,n−1) h_(n−1,n).
struct Shift {
    x: f64,
    y: f64,
    w: f64,
}

/// Eigenvalues of the Hessenberg matrix H, one or two at a time from the bottom up.
fn francis(h: &mut Square, values: &mut [Complex]) -> Result<()> {
    let size = subdiagonal_sum(h);
    let (mut left, mut shifted, mut sweeps) = (h.n, 0.0, 0);
    for _ in 0..=SWEEPS_PER_EIGENVALUE * h.n {
        if left == 0 {
            return Ok(());
        }
        let last = left - 1;
        let first = first_of_block(h, last, size);
        if first == last {
            values[last] = Complex::new(h[(last, last)] + shifted, 0.0);
            (left, sweeps) = (last, 0);
        } else if first + 1 == last {
            (values[last - 1], values[last]) = pair(h, last, shifted);
            (left, sweeps) = (last - 1, 0);
        } else {
            sweeps += 1;
            let shift = choose_shift(h, last, sweeps, &mut shifted);
            sweep(h, first, last, shift);
        }
    }
    Err(Error::no_convergence("eigenvalues"))
}

fn subdiagonal_sum(h: &Square) -> f64 {
    (0..h.n).map(|j| (0..h.n.min(j + 2)).map(|i| h[(i, j)].abs()).sum::<f64>()).sum()
}

/// The first row of the unreduced block that ends at `last`; the negligible entry before it becomes
/// zero.
fn first_of_block(h: &mut Square, last: usize, size: f64) -> usize {
    for l in (1..=last).rev() {
        let around = h[(l - 1, l - 1)].abs() + h[(l, l)].abs();
        let around = if around == 0.0 { size } else { around };
        let below = h[(l, l - 1)].abs();
        if below + around == around || below < NEGLIGIBLE {
            h[(l, l - 1)] = 0.0;
            return l;
        }
    }
    0
}

/// The two eigenvalues of the block of rows last−1 and last.
fn pair(h: &Square, last: usize, shifted: f64) -> (Complex, Complex) {
    let x = h[(last, last)];
    let w = h[(last, last - 1)] * h[(last - 1, last)];
    let p = 0.5 * (h[(last - 1, last - 1)] - x);
    let q = p * p + w;
    let x = x + shifted;
    if q < 0.0 {
        let im = sqrt(-q);
        return (Complex::new(x + p, im), Complex::new(x + p, -im));
    }
    let z = p + sqrt(q).copysign(p);
    let other = if z == 0.0 { x } else { x - w / z };
    (Complex::new(x + z, 0.0), Complex::new(other, 0.0))
}

fn choose_shift(h: &mut Square, last: usize, sweeps: usize, shifted: &mut f64) -> Shift {
    let x = h[(last, last)];
    if !sweeps.is_multiple_of(SWEEPS_BEFORE_SHIFT) {
        let w = h[(last, last - 1)] * h[(last - 1, last)];
        return Shift { x, y: h[(last - 1, last - 1)], w };
    }
    *shifted += x;
    for i in 0..=last {
        h[(i, i)] -= x;
    }
    // Wilkinson's exceptional shift; its two constants have no meaning beyond being generic.
    let s = h[(last, last - 1)].abs() + h[(last - 1, last - 2)].abs();
    Shift { x: 0.75 * s, y: 0.75 * s, w: -0.4375 * s * s }
}

/// One Francis step on rows `first..=last`, at least three of them.
fn sweep(h: &mut Square, first: usize, last: usize, shift: Shift) {
    let (start, mut v) = start_of_sweep(h, first, last, &shift);
    for i in start + 2..=last {
        h[(i, i - 2)] = 0.0;
        if i > start + 2 {
            h[(i, i - 3)] = 0.0;
        }
    }
    for k in start..last {
        let mut length = 1.0;
        if k > start {
            let third = if k + 1 < last { h[(k + 2, k - 1)] } else { 0.0 };
            v = [h[(k, k - 1)], h[(k + 1, k - 1)], third];
            length = v[0].abs() + v[1].abs() + v[2].abs();
            v = v.map(|x| x / length);
        }
        let s = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).copysign(v[0]);
        if length == 0.0 || s == 0.0 {
            continue;
        }
        if k > start {
            h[(k, k - 1)] = -s * length;
        } else if first != start {
            h[(k, k - 1)] = -h[(k, k - 1)];
        }
        let p = v[0] + s;
        reflect(h, k, (first, last), [p / s, v[1] / s, v[2] / s], [v[1] / p, v[2] / p]);
    }
}

/// Where the sweep can start because two small subdiagonal entries meet, and the first column of
/// its reflector.
fn start_of_sweep(h: &Square, first: usize, last: usize, shift: &Shift) -> (usize, [f64; 3]) {
    let mut m = last - 2;
    loop {
        let z = h[(m, m)];
        let (r, s) = (shift.x - z, shift.y - z);
        let v = [
            (r * s - shift.w) / h[(m + 1, m)] + h[(m, m + 1)],
            h[(m + 1, m + 1)] - z - r - s,
            h[(m + 2, m + 1)],
        ];
        let length = v[0].abs() + v[1].abs() + v[2].abs();
        let v = v.map(|x| x / length);
        if m == first {
            return (m, v);
        }
        let small = h[(m, m - 1)].abs() * (v[1].abs() + v[2].abs());
        let around = h[(m - 1, m - 1)].abs() + z.abs() + h[(m + 1, m + 1)].abs();
        let large = v[0].abs() * around;
        if small + large == large {
            return (m, v);
        }
        m -= 1;
    }
}

/// H ← R H R with R = I − u wᵀ on rows and columns k, k+1, k+2; u = `u`, w = (1, `w`).
fn reflect(
    h: &mut Square,
    k: usize,
    (first, last): (usize, usize),
    [x, y, z]: [f64; 3],
    [q, r]: [f64; 2],
) {
    let n = h.n;
    let three = k + 1 < last;
    for j in k..=last {
        let column = &mut h.entries[j * n + k..(j + 1) * n];
        let mut p = column[0] + q * column[1];
        if three {
            p += r * column[2];
            column[2] -= p * z;
        }
        column[1] -= p * y;
        column[0] -= p * x;
    }
    for i in first..=last.min(k + 3) {
        let mut p = x * h[(i, k)] + y * h[(i, k + 1)];
        if three {
            p += z * h[(i, k + 2)];
            h[(i, k + 2)] -= p * r;
        }
        h[(i, k + 1)] -= p * q;
        h[(i, k)] -= p;
    }
}

//! The frequency response `σ(ω)² = λ_max(Bᵀ(−jω − A)⁻ᵀ Q (jω − A)⁻¹B)`.
//!
//! A is brought to Hessenberg form once, by reflectors; each frequency then costs elimination of
//! one subdiagonal.

use nalgebra::{DefaultAllocator, Dim, OMatrix, OVector, U1};

use super::dense::{Room, Square, Tall, mul};
use super::reflector::Reflector;
use super::scaling::Problem;
use crate::eigen::{Complex, modulus, symmetric_in_place};
use crate::math::sqrt;

/// A plant with a Hessenberg A.
pub(super) struct Response<S: Dim, M: Dim>
where
    DefaultAllocator: Room<S, M>,
{
    a: Square<S>,
    b: Tall<S, M>,
    q: Square<S>,
}

impl<S: Dim, M: Dim> Response<S, M>
where
    DefaultAllocator: Room<S, M> + Room<S, S> + Room<M, M>,
{
    /// Of the plant with A, B = F and Q of `problem`.
    pub(super) fn new(problem: &Problem<S, M>) -> Self {
        let Problem { a, f, q, .. } = problem;
        let (mut a, mut b, mut q, n) = (a.clone(), f.clone(), q.clone(), a.nrows());
        for k in 1..n.saturating_sub(1) {
            let column = &a.as_slice()[(k - 1) * n..k * n];
            let Some(reflector) = Reflector::clearing(a.shape_generic().0, column, k) else {
                continue;
            };
            reflector.left(a.as_mut_slice());
            reflector.right(a.as_mut_slice());
            reflector.left(b.as_mut_slice());
            reflector.left(q.as_mut_slice());
            reflector.right(q.as_mut_slice());
        }
        Self { a, b, q }
    }

    /// σ(ω); 0 where it cannot be computed, so that such a frequency never wins.
    pub(super) fn sigma(&self, omega: f64) -> f64 {
        let Some((re, im)) = self.states(omega) else { return 0.0 };
        let (q_re, q_im) = (mul(&self.q, &re), mul(&self.q, &im));
        let (re, im) = (re.transpose(), im.transpose());
        let (same, cross) = (mul(&re, &q_re) + mul(&im, &q_im), mul(&re, &q_im) - mul(&im, &q_re));
        // The Hermitian matrix XᴴQX as the real symmetric [Re −Im; Im Re], which has the same
        // eigenvalues, twice.
        let inputs = self.b.shape_generic().1;
        let m = inputs.value();
        let mut entries = OMatrix::from_element_generic(inputs, inputs, [0.0; 4]);
        let entries = entries.as_mut_slice().as_flattened_mut();
        for j in 0..m {
            for i in 0..m {
                entries[i + 2 * m * j] = same[(i, j)];
                entries[m + i + 2 * m * (m + j)] = same[(i, j)];
                entries[m + i + 2 * m * j] = cross[(i, j)];
                entries[i + 2 * m * (m + j)] = -cross[(i, j)];
            }
        }
        if entries.iter().any(|x| !x.is_finite()) {
            return 0.0;
        }
        let mut values = OVector::from_element_generic(inputs, U1, [0.0; 2]);
        let mut off = values.clone();
        let values = values.as_mut_slice().as_flattened_mut();
        match symmetric_in_place(2 * m, entries, values, off.as_mut_slice().as_flattened_mut()) {
            Ok(()) => sqrt(values.iter().fold(0.0, |most: f64, &x| most.max(x))),
            Err(_) => 0.0,
        }
    }

    /// Real and imaginary part of the columns of (jω − A)⁻¹ B.
    fn states(&self, omega: f64) -> Option<(Tall<S, M>, Tall<S, M>)> {
        let (size, inputs) = self.b.shape_generic();
        let (n, m) = (size.value(), inputs.value());
        // Rows side by side: the transposes of jω − A and of B.
        let mut a = self.a.transpose().map(|x| Complex::new(-x, 0.0));
        let mut x = self.b.transpose().map(|x| Complex::new(x, 0.0));
        for i in 0..n {
            a[(i, i)].im = omega;
        }
        solve_hessenberg(n, m, a.as_mut_slice(), x.as_mut_slice())?;
        Some((x.map(|z| z.re).transpose(), x.map(|z| z.im).transpose()))
    }
}

/// Solves A X = B for an n×n Hessenberg A and m right sides, both stored by rows; `x` holds B, then
/// X.
fn solve_hessenberg(n: usize, m: usize, a: &mut [Complex], x: &mut [Complex]) -> Option<()> {
    for k in 0..n - 1 {
        let (upper, lower) = a[k * n..(k + 2) * n].split_at_mut(n);
        let (x_upper, x_lower) = x[k * m..(k + 2) * m].split_at_mut(m);
        if modulus(lower[k]) > modulus(upper[k]) {
            upper[k..].swap_with_slice(&mut lower[k..]);
            x_upper.swap_with_slice(x_lower);
        }
        if modulus(upper[k]) == 0.0 {
            return None;
        }
        let factor = lower[k] / upper[k];
        lower[k..].iter_mut().zip(&upper[k..]).for_each(|(low, up)| *low -= factor * up);
        x_lower.iter_mut().zip(&*x_upper).for_each(|(low, up)| *low -= factor * up);
    }
    for k in (0..n).rev() {
        let row = &a[k * n..(k + 1) * n];
        if modulus(row[k]) == 0.0 {
            return None;
        }
        let (here, below) = x[k * m..].split_at_mut(m);
        for (factor, known) in row[k + 1..].iter().zip(below.chunks_exact(m)) {
            here.iter_mut().zip(known).for_each(|(x, known)| *x -= factor * known);
        }
        here.iter_mut().for_each(|x| *x /= row[k]);
    }
    Some(())
}

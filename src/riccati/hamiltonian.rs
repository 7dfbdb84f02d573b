//! The Hamiltonian matrix `[A −G; −Q −Aᵀ]`, whose eigenvalues off the imaginary axis are those of
//! the closed loop and their mirror images; with one on the axis no solution is stabilising.

use nalgebra::{DefaultAllocator, Dim, OMatrix, OVector, U1};

use super::dense::Room;
use super::scaling::Problem;
use crate::eigen::{Complex, eigenvalues_in_place};
use crate::error::Result;

/// The 2S eigenvalues of the Hamiltonian matrix of `problem`, two by two.
pub(super) fn eigenvalues<S: Dim, M: Dim>(
    problem: &Problem<S, M>,
) -> Result<OVector<[Complex; 2], S>>
where
    DefaultAllocator: Room<S, M>,
{
    let Problem { a, g, q, .. } = problem;
    let size = a.shape_generic().0;
    let n = size.value();
    let mut entries = OMatrix::from_element_generic(size, size, [0.0; 4]);
    let entries = entries.as_mut_slice().as_flattened_mut();
    let mut put = |i: usize, j: usize, x: f64| entries[i + 2 * n * j] = x;
    for j in 0..n {
        for i in 0..n {
            put(i, j, a[(i, j)]);
            put(n + i, j, -q[(i, j)]);
            put(i, n + j, -g[(i, j)]);
            put(n + i, n + j, -a[(j, i)]);
        }
    }
    let mut values = OVector::from_element_generic(size, U1, [Complex::new(0.0, 0.0); 2]);
    eigenvalues_in_place(2 * n, entries, values.as_mut_slice().as_flattened_mut())?;
    Ok(values)
}

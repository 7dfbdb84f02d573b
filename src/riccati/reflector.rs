//! Householder's reflectors `I − β v vᵀ` on the last rows or columns of a matrix, column-major.

use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, OVector, U1};

use crate::math::sqrt;

/// `I − β v vᵀ`, with v zero before row `first`.
pub(super) struct Reflector<S: Dim>
where
    DefaultAllocator: Allocator<S>,
{
    first: usize,
    v: OVector<f64, S>,
    beta: f64,
}

impl<S: Dim> Reflector<S>
where
    DefaultAllocator: Allocator<S>,
{
    /// The one that clears `column` after row `first`; `None` if it is clear.
    pub(super) fn clearing(size: S, column: &[f64], first: usize) -> Option<Self> {
        let tail: f64 = column[first + 1..].iter().map(|x| x * x).sum();
        if tail == 0.0 {
            return None;
        }
        let mut v = OVector::zeros_generic(size, U1);
        v.as_mut_slice()[first..].copy_from_slice(&column[first..]);
        let head = column[first];
        let alpha = -sqrt(head * head + tail).copysign(head);
        v[first] = head - alpha;
        Some(Self { first, beta: 1.0 / (alpha * alpha - head * alpha), v })
    }

    /// H X.
    pub(super) fn left(&self, x: &mut [f64]) {
        let v = &self.v.as_slice()[self.first..];
        for column in x.chunks_exact_mut(self.v.len()) {
            let column = &mut column[self.first..];
            let along: f64 = column.iter().zip(v).map(|(x, v)| x * v).sum();
            column.iter_mut().zip(v).for_each(|(x, v)| *x -= self.beta * along * v);
        }
    }

    /// X H.
    pub(super) fn right(&self, x: &mut [f64]) {
        let n = self.v.len();
        let mut along = self.v.clone();
        along.fill(0.0);
        let columns = x.chunks_exact(n).zip(&self.v).skip(self.first);
        for (column, &v) in columns {
            along.iter_mut().zip(column).for_each(|(sum, x)| *sum += x * v);
        }
        let columns = x.chunks_exact_mut(n).zip(&self.v).skip(self.first);
        for (column, &v) in columns {
            column.iter_mut().zip(&along).for_each(|(x, sum)| *x -= self.beta * v * sum);
        }
    }
}

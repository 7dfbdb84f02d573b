//! The modes that the inputs do not reach, by the controllability staircase.
//!
//! Reflectors turn (A, F) into `[A₁ *; 0 A₂]`, `[F₁; 0]`, step by step: the rank of F, then the
//! rank of what those states drive, and so on. The pair is stabilisable iff A₂ is Hurwitz. What a
//! weight Q does not see are the modes of Aᵀ that it does not reach.
//!
//! Source: Van Dooren, "The generalized eigenstructure problem in linear system theory", IEEE
//! Transactions on Automatic Control 26 (1981).

use core::ops::Range;

use nalgebra::{DefaultAllocator, Dim, U1};

use super::dense::{Modes, Room, Square, Tall};
use super::reflector::Reflector;
use crate::eigen::{Complex, eigenvalues_in_place};
use crate::error::Result;
use crate::math::sqrt;

/// A column this small, relative to the whole matrix, drives nothing.
const NOTHING: f64 = 1e-10;

/// What `judge` says of the modes of A that F does not reach.
pub(super) fn unreached<S: Dim, M: Dim, T>(
    a: &Square<S>,
    f: &Tall<S, M>,
    judge: impl Fn(&[Complex]) -> T,
) -> Result<T>
where
    DefaultAllocator: Room<S, M>,
{
    let n = a.nrows();
    let mut pair = Pair { a: a.clone(), f: f.clone() };
    let mut reached = pair.climb(None, NOTHING * f.norm());
    let mut before = 0;
    while before < reached && reached < n {
        let drivers = before..reached;
        before = reached;
        reached = pair.climb(Some(drivers), NOTHING * a.norm());
    }
    let left = n - reached;
    let mut rest = Square::zeros_generic(a.shape_generic().0, a.shape_generic().1);
    let rest = &mut rest.as_mut_slice()[..left * left];
    for (k, entry) in rest.iter_mut().enumerate() {
        *entry = pair.a[(reached + k % left, reached + k / left)];
    }
    let zero = Complex::new(0.0, 0.0);
    let mut modes = Modes::from_element_generic(a.shape_generic().0, U1, zero);
    let modes = &mut modes.as_mut_slice()[..left];
    eigenvalues_in_place(left, rest, modes)?;
    Ok(judge(modes))
}

struct Pair<S: Dim, M: Dim>
where
    DefaultAllocator: Room<S, M>,
{
    a: Square<S>,
    f: Tall<S, M>,
}

impl<S: Dim, M: Dim> Pair<S, M>
where
    DefaultAllocator: Room<S, M>,
{
    /// Turns the states that `drivers` (columns of A before its end, or all of F) drive to the next
    /// rows; the first row after them.
    fn climb(&mut self, drivers: Option<Range<usize>>, least: f64) -> usize {
        let size = self.a.shape_generic().0;
        let n = size.value();
        let mut top = drivers.as_ref().map_or(0, |columns| columns.end);
        while top < n {
            let columns = match &drivers {
                Some(columns) => &self.a.as_slice()[columns.start * n..columns.end * n],
                None => self.f.as_slice(),
            };
            let length = |column: &[f64]| sqrt(column[top..].iter().map(|x| x * x).sum());
            let longer = |a: &&[f64], b: &&[f64]| length(a).total_cmp(&length(b));
            let Some(column) = columns.chunks_exact(n).max_by(longer) else { break };
            if length(column) <= least {
                break;
            }
            if let Some(reflector) = Reflector::clearing(size, column, top) {
                reflector.left(self.f.as_mut_slice());
                reflector.left(self.a.as_mut_slice());
                reflector.right(self.a.as_mut_slice());
            }
            top += 1;
        }
        top
    }
}

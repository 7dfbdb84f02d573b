//! The product of all combinations of sets, ξ = ⊗ᵢ pᵢ, from the memberships in their tables.

use pulp::Simd;

use super::lanes::BLOCK;
use super::places::Span;
use crate::math::{LANES, TINY_STRENGTH, lanes_unless_tiny};

/// The memberships of one input: every [`LANES`]th entry from `first` on, `len` of them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Column {
    first: u16,
    len: u16,
}

impl Column {
    pub const EMPTY: Self = Self { first: 0, len: 0 };

    /// A column of one of the tables of [`MAX_SETS`](super::MAX_SETS) sets at the most.
    pub fn new(first: usize, len: usize) -> Self {
        Self { first: first as u16, len: len as u16 }
    }

    #[inline]
    pub fn first(&self) -> usize {
        self.first.into()
    }

    #[inline]
    pub fn len(&self) -> usize {
        self.len.into()
    }

    #[inline]
    pub fn of<'a>(&self, memberships: &'a [f64]) -> impl Iterator<Item = &'a f64> {
        memberships[self.first()..].iter().step_by(LANES).take(self.len())
    }

    /// The stretch of memory from the first entry to the last.
    #[inline]
    pub fn span(&self) -> Span {
        Span { first: self.first(), len: (self.len() * LANES + 1).saturating_sub(LANES) }
    }
}

/// out[..] = ⊗ factors, from the last factor to the first, then zeros up to whole lanes. Rows are
/// written in whole lanes; what a row writes too far, the next one, or the zeros, cover.
///
/// `out` and `scratch` have room for one more run of lanes.
#[inline(always)]
pub(crate) fn kronecker<S: Simd>(
    simd: S,
    memberships: &[f64],
    factors: &[Column],
    out: &mut [f64],
    scratch: &mut [f64],
) {
    let Some((last, others)) = factors.split_last() else {
        out[..LANES].copy_from_slice(&[1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        return;
    };
    let (mut from, mut to) = if others.len() % 2 == 0 { (out, scratch) } else { (scratch, out) };
    from.iter_mut().zip(last.of(memberships)).for_each(|(y, p)| *y = *p);
    let mut len = last.len();
    for (k, factor) in others.iter().rev().enumerate() {
        match len {
            2 if k == 0 => pair::<2>(memberships, *factor, *last, to),
            3 if k == 0 => pair::<3>(memberships, *factor, *last, to),
            4 if k == 0 => pair::<4>(memberships, *factor, *last, to),
            5 if k == 0 => pair::<5>(memberships, *factor, *last, to),
            6 if k == 0 => pair::<6>(memberships, *factor, *last, to),
            7 if k == 0 => pair::<7>(memberships, *factor, *last, to),
            _ => {
                long_rows(simd, memberships, *factor, &from[..len.next_multiple_of(LANES)], len, to)
            }
        }
        len *= factor.len();
        (from, to) = (to, from);
    }
    from[len..len + LANES].copy_from_slice(&[0.0; LANES]);
}

/// out[..] = left ⊗ right for a right factor of L sets, which stays in registers. Products of two
/// memberships that are not zero are not tiny.
#[inline(always)]
fn pair<const L: usize>(memberships: &[f64], left: Column, right: Column, out: &mut [f64]) {
    let mut row = [0.0; L];
    for set in 0..L {
        row[set] = memberships[right.first() + set * LANES];
    }
    let (mut place, mut rest) = (left.first(), out);
    for _ in 0..left.len() {
        let p = memberships[place];
        let Some((to, others)) = rest.split_first_chunk_mut::<L>() else { return };
        for set in 0..L {
            to[set] = p * row[set];
        }
        (place, rest) = (place + LANES, others);
    }
}

/// out[..] = factor ⊗ row for a row of any length `len`, read in whole lanes.
#[inline(always)]
fn long_rows<S: Simd>(
    simd: S,
    memberships: &[f64],
    factor: Column,
    row: &[f64],
    len: usize,
    out: &mut [f64],
) {
    let runs = S::as_simd_f64s(row).0.as_chunks::<BLOCK>();
    let (mut rest, mut place) = (out, factor.first());
    for _ in 0..factor.len() {
        scale(simd, memberships[place], runs, rest);
        place += LANES;
        rest = &mut rest[len..];
    }
}

/// y = p x, over the length of x.
#[inline(always)]
fn scale<S: Simd>(
    simd: S,
    p: f64,
    (blocks, rest): (&[[S::f64s; BLOCK]], &[S::f64s]),
    y: &mut [f64],
) {
    let p = simd.splat_f64s(p);
    let (y, last) = S::as_mut_simd_f64s(y).0.split_at_mut(blocks.len() * BLOCK);
    for (x, y) in blocks.iter().zip(y.as_chunks_mut::<BLOCK>().0) {
        for i in 0..BLOCK {
            y[i] = lanes_unless_tiny(simd, simd.mul_f64s(p, x[i]), TINY_STRENGTH);
        }
    }
    for (x, y) in rest.iter().zip(last) {
        *y = lanes_unless_tiny(simd, simd.mul_f64s(p, *x), TINY_STRENGTH);
    }
}

#[cfg(test)]
#[cfg(feature = "std")]
mod tests {
    use approx::assert_relative_eq;
    use pulp::{Arch, Scalar, WithSimd};

    use super::*;

    /// Inputs with these numbers of sets, side by side.
    fn columns_of(sets: &[usize]) -> Vec<Column> {
        sets.iter().enumerate().map(|(first, &len)| Column::new(first, len)).collect()
    }

    struct Product<'a>(&'a [f64], &'a [Column], usize);

    impl WithSimd for Product<'_> {
        type Output = Vec<f64>;

        fn with_simd<S: Simd>(self, simd: S) -> Vec<f64> {
            let (mut out, mut scratch) = (vec![9.0; self.2], vec![9.0; self.2]);
            kronecker(simd, self.0, self.1, &mut out, &mut scratch);
            out
        }
    }

    #[test]
    fn kronecker_is_the_product_of_its_factors_first_slowest() {
        let table: Vec<f64> = (0..16 * LANES).map(|k| 0.5 + (k * 37 % 101) as f64).collect();
        let lengths = [1, 2, 3, 4, 5, 6, 7, 8, 9, 13];
        let last = lengths.map(|len| vec![len]);
        let pairs = lengths.map(|len| vec![3, len]);
        let triples = lengths.map(|len| vec![2, 3, len]);
        for sets in [vec![]].into_iter().chain(last).chain(pairs).chain(triples) {
            let factors = columns_of(&sets);
            let mut wanted = vec![1.0];
            for column in &factors {
                let with = |x: f64| column.of(&table).map(move |p| x * p);
                wanted = wanted.into_iter().flat_map(with).collect();
            }
            let room = wanted.len().next_multiple_of(LANES) + LANES;
            let (mut out, mut scratch) = (vec![9.0; room], vec![9.0; room]);
            kronecker(Scalar, &table, &factors, &mut out, &mut scratch);
            assert_eq!(out, Arch::new().dispatch(Product(&table, &factors, room)), "{sets:?}");
            let (product, padding) = out.split_at(wanted.len());
            product
                .iter()
                .zip(&wanted)
                .for_each(|(a, b)| assert_relative_eq!(a, b, max_relative = 1e-15));
            let padding = &padding[..wanted.len().next_multiple_of(LANES) - wanted.len()];
            assert!(padding.iter().all(|zero| *zero == 0.0), "{sets:?}");
        }
    }
}

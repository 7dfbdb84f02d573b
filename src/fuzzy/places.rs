//! Where things stand in longer arrays.

/// A stretch of a longer array.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Span {
    pub first: usize,
    pub len: usize,
}

impl Span {
    pub const EMPTY: Self = Self { first: 0, len: 0 };

    #[inline]
    pub fn of<'a, T>(&self, array: &'a [T]) -> &'a [T] {
        &array[self.first..self.first + self.len]
    }

    #[inline]
    pub fn of_mut<'a, T>(&self, array: &'a mut [T]) -> &'a mut [T] {
        &mut array[self.first..self.first + self.len]
    }
}

/// Where the factors of a product u ⊗ v stand; v is padded with zeros to whole lanes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Dyad {
    pub u: Span,
    pub v: Span,
}

impl Dyad {
    /// The product of nothing.
    pub const EMPTY: Self = Self { u: Span::EMPTY, v: Span::EMPTY };

    /// Its entries, padding included.
    pub fn len(&self) -> usize {
        self.u.len * self.v.len
    }
}

/// A vector ξ in the order of its weights: one product after the other.
pub(crate) type Dyads = [Dyad; 2];

//! The numbers of a saved state: eight bytes each, little-endian.

use crate::error::{Error, Result};
use crate::math::Vector;

/// Puts numbers.
#[inline(never)]
pub(crate) fn put_all(put: &mut dyn FnMut(&[u8]), values: &[f64]) {
    values.iter().for_each(|x| put(&x.to_le_bytes()));
}

/// Bytes that are numbers of eight bytes each.
#[derive(Clone, Copy)]
pub(crate) struct Numbers<'a>(pub &'a [u8]);

impl<'a> Numbers<'a> {
    fn word(&mut self) -> Result<[u8; 8]> {
        let Some((word, rest)) = self.0.split_first_chunk::<8>() else {
            return Err(Error::damaged("it is too short"));
        };
        self.0 = rest;
        Ok(*word)
    }

    pub fn count(&mut self) -> Result<u64> {
        self.word().map(u64::from_le_bytes)
    }

    pub fn number(&mut self) -> Result<f64> {
        self.word().map(f64::from_le_bytes)
    }

    #[inline(never)]
    pub fn vector<const N: usize>(&mut self) -> Result<Vector<N>> {
        let mut vector = Vector::<N>::zeros();
        for x in vector.iter_mut() {
            *x = self.number()?;
        }
        Ok(vector)
    }

    /// The next `count` numbers.
    pub fn split(&mut self, count: usize) -> Result<Self> {
        let bytes = count.checked_mul(8).and_then(|len| self.0.split_at_checked(len));
        let Some((numbers, rest)) = bytes else {
            return Err(Error::damaged("it is too short"));
        };
        self.0 = rest;
        Ok(Self(numbers))
    }

    /// Refuses bytes that are left over.
    pub fn end(&self) -> Result<()> {
        if self.0.is_empty() { Ok(()) } else { Err(OTHER) }
    }

    /// All of them.
    pub fn iter(self) -> impl Iterator<Item = f64> + 'a {
        let (words, _) = self.0.as_chunks::<8>();
        words.iter().map(|word| f64::from_le_bytes(*word))
    }
}

pub(super) const OTHER: Error =
    Error::damaged("it belongs to a controller with other modifications");

//! The memory of a basis or of a compensator, lent by the caller and aligned to cache lines: a
//! register that straddles two lines takes twice as long to read.

use crate::error::{Error, Result};
use crate::math::LANES;

/// Memory for a basis or for a compensator's state: an array, a slice, a vector.
pub trait Buffer: AsRef<[f64]> + AsMut<[f64]> {}

impl<B: AsRef<[f64]> + AsMut<[f64]>> Buffer for B {}

/// Where the sets of a basis stand that is lent no buffer: on the heap.
#[cfg(feature = "std")]
pub type Room = Vec<f64>;

/// Where the sets of a basis stand that is lent no buffer: 1.5 kB in the basis itself, enough for
/// 16 inputs that share five sets.
#[cfg(not(feature = "std"))]
pub type Room = [f64; 192];

/// A buffer with the start of its first whole line.
#[derive(Debug)]
pub(crate) struct Memory<B> {
    buffer: B,
    offset: usize,
    len: usize,
}

impl<B: Buffer> Memory<B> {
    /// Length of the buffer that memory of `len` numbers needs.
    pub fn buffer_len(len: usize) -> usize {
        len + LANES - 1
    }

    /// Memory of `len` zeros.
    ///
    /// # Errors
    /// `buffer`: shorter than [`buffer_len`](Self::buffer_len).
    pub fn new(mut buffer: B, len: usize) -> Result<Self> {
        let (got, wanted) = (buffer.as_ref().len(), Self::buffer_len(len));
        if got < wanted {
            return Err(Error::wrong_length("buffer", got, wanted));
        }
        buffer.as_mut().fill(0.0);
        let offset = first_lane(buffer.as_ref());
        Ok(Self { buffer, offset, len })
    }

    #[inline]
    pub fn as_slice(&self) -> &[f64] {
        &self.buffer.as_ref()[self.offset..][..self.len]
    }

    #[inline]
    pub fn as_mut_slice(&mut self) -> &mut [f64] {
        &mut self.buffer.as_mut()[self.offset..][..self.len]
    }
}

impl Memory<Room> {
    /// Memory of `len` zeros that nobody lends.
    ///
    /// # Errors
    /// Without `std`, `buffer`: as [`new`](Self::new).
    #[inline]
    pub fn own(len: usize) -> Result<Self> {
        #[cfg(feature = "std")]
        return Ok(Self::on_heap(len));
        #[cfg(not(feature = "std"))]
        return Self::new([0.0; 192], len);
    }
}

#[cfg(feature = "std")]
impl Memory<Vec<f64>> {
    /// Memory of `len` zeros on the heap.
    pub fn on_heap(len: usize) -> Self {
        let buffer = vec![0.0; Self::buffer_len(len)];
        let offset = first_lane(&buffer);
        Self { buffer, offset, len }
    }
}

impl<B: Buffer + Clone> Clone for Memory<B> {
    /// The same numbers, in the lines of the new buffer.
    fn clone(&self) -> Self {
        let mut buffer = self.buffer.clone();
        let offset = first_lane(buffer.as_ref());
        buffer.as_mut().copy_within(self.offset..self.offset + self.len, offset);
        Self { buffer, offset, len: self.len }
    }
}

/// Start of the first whole lane in a buffer: cache lines are read whole from there.
fn first_lane(buffer: &[f64]) -> usize {
    match buffer.as_ptr().align_offset(LANES * size_of::<f64>()) {
        offset if offset < LANES => offset,
        _ => 0,
    }
}

#[cfg(test)]
#[cfg(feature = "std")]
mod tests {
    use super::*;

    #[test]
    fn a_clone_has_the_same_numbers_in_whole_lines() {
        let mut memory = Memory::on_heap(20);
        (0..20).for_each(|i| memory.as_mut_slice()[i] = i as f64);
        let mut keep = Vec::new();
        for extra in 0..32 {
            // Allocations of other sizes, so that the clones begin at other places.
            keep.push((vec![0_u8; 16 * extra + 1], memory.clone()));
        }
        for (_, clone) in &keep {
            assert_eq!(clone.as_slice(), memory.as_slice());
            assert_eq!(clone.as_slice().as_ptr() as usize % 64, 0);
        }
    }
}

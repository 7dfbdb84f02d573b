//! Numbers of eight runs side by side, in memory.

use super::LANES;

/// A number of each of eight runs.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(64))]
pub(crate) struct Abreast(pub [f64; LANES]);

impl Abreast {
    /// The same number in each.
    #[inline(always)]
    pub fn all(x: f64) -> Self {
        Self([x; LANES])
    }

    /// A number of each of eight things.
    #[inline(always)]
    pub fn of<X>(each: [&X; LANES], number: impl Fn(&X) -> f64) -> Self {
        Self(each.map(number))
    }
}

//! Numbers of eight runs side by side, in memory.

use pulp::{Arch, WithSimd};

use super::{LANES, Vector};

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

/// The vector in a lane.
#[inline(always)]
pub(crate) fn lane<const N: usize>(x: &Vector<N, Abreast>, lane: usize) -> Vector<N> {
    Vector::<N>::from_fn(|n, _| x[n].0[lane])
}

/// Puts a vector into a lane.
#[inline(always)]
pub(crate) fn put<const N: usize>(from: &Vector<N>, to: &mut Vector<N, Abreast>, lane: usize) {
    for n in 0..N {
        to[n].0[lane] = from[n];
    }
}

/// Vectors, a lane each.
pub(crate) fn side_by_side<const N: usize>(each: &[Vector<N>; LANES]) -> Vector<N, Abreast> {
    let mut all = Vector::<N, Abreast>::repeat(Abreast::all(0.0));
    for (i, one) in each.iter().enumerate() {
        put(one, &mut all, i);
    }
    all
}

/// All eight, if none is missing.
pub(crate) fn none_missing<T: Copy>(each: [Option<T>; LANES]) -> Option<[T; LANES]> {
    let mut all = [each[0]?; LANES];
    for (to, from) in all.iter_mut().zip(each) {
        *to = from?;
    }
    Some(all)
}

/// Whether runs go side by side on this instruction set. For one number in a register all of it
/// would have to be compiled once more; tests do so.
pub(crate) const fn has_lanes(arch: Arch) -> bool {
    !matches!(arch, Arch::Scalar) || cfg!(any(test, not(target_arch = "x86_64")))
}

/// Does a task on numbers side by side, on an instruction set that [`has_lanes`].
#[inline(always)]
pub(crate) fn in_lanes(arch: Arch, task: impl WithSimd<Output = ()>) {
    match arch {
        #[cfg(target_arch = "x86_64")]
        Arch::V4(simd) => pulp::Simd::vectorize(simd, task),
        #[cfg(target_arch = "x86_64")]
        Arch::V3(simd) => pulp::Simd::vectorize(simd, task),
        #[cfg(any(test, not(target_arch = "x86_64")))]
        _ => arch.dispatch(task),
        #[cfg(not(any(test, not(target_arch = "x86_64"))))]
        _ => {}
    }
}

//! The elementary functions, the matrix types and the lanes of every room, with the same bits on
//! every machine.
//!
//! The platform's `exp` or `sin` differs between C libraries; these come from the `libm` crate.

#[cfg(feature = "std")]
mod abreast;
#[cfg(feature = "std")]
mod exp_tanh;
mod exponential;
mod real;
#[cfg(feature = "std")]
mod register;
#[cfg(feature = "std")]
mod sines;
mod single;

#[cfg(feature = "std")]
pub(crate) use abreast::{Abreast, has_lanes, in_lanes, lane, none_missing, put, side_by_side};
pub(crate) use exponential::exponential;
#[cfg(feature = "std")]
pub(crate) use exponential::exponentials;
pub use real::Real;
pub(crate) use real::{dot, product};
#[cfg(feature = "std")]
pub(crate) use register::store;
#[cfg(feature = "std")]
pub(crate) use register::{Load, Register};

use pulp::{Arch, Simd, WithSimd};

use core::f64::consts::{PI, TAU};

/// A column of `N` joint values.
pub type Vector<const N: usize, T = f64> = nalgebra::SVector<T, N>;

/// A square matrix over `N` joints (or `N` states).
pub type Matrix<const N: usize, T = f64> = nalgebra::SMatrix<T, N, N>;

/// The vector of these entries. Of registers, nalgebra's own constructors copy each several times.
#[inline(always)]
pub(crate) const fn column<const N: usize, T>(x: [T; N]) -> Vector<N, T> {
    Vector::<N, T>::from_array_storage(nalgebra::ArrayStorage([x]))
}

/// The matrix of these columns.
#[inline(always)]
pub(crate) const fn columns<const N: usize, T>(x: [[T; N]; N]) -> Matrix<N, T> {
    Matrix::<N, T>::from_array_storage(nalgebra::ArrayStorage(x))
}

/// Up to so many joints a stage is compiled as a whole, in line with each caller: it then computes
/// only what its caller uses, and its numbers stay in registers. Written to memory one by one and
/// read back as a vector, they would miss store forwarding. Beyond, a stage takes far longer than
/// a call, and all callers share its parts.
pub(crate) const WHOLE: usize = 2;

/// What `body`, a part of a stage, gives: in line up to [`WHOLE`] joints, and beyond in a copy that
/// all callers of the function around it share.
#[cfg(feature = "std")]
#[inline(always)]
pub(crate) fn part<const N: usize, T>(body: impl FnOnce() -> T) -> T {
    if N <= WHOLE { body() } else { apart(body) }
}

#[cfg(feature = "std")]
#[inline(never)]
fn apart<T>(body: impl FnOnce() -> T) -> T {
    body()
}

/// Numbers that are worked on side by side, however many a register holds. Rows of weights are
/// whole multiples of this long.
pub(crate) const LANES: usize = 8;

/// Numbers of all lanes in one cache line: a register across two lines costs twice.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct Line(pub [f64; LANES]);

/// How a loop over lanes runs: in line, in a caller that is compiled for the instruction set at
/// hand, or in a copy of its own.
pub(crate) trait Runs: Copy {
    fn run<T: WithSimd>(self, task: T) -> T::Output;
}

impl<S: Simd> Runs for S {
    #[inline(always)]
    fn run<T: WithSimd>(self, task: T) -> T::Output {
        task.with_simd(self)
    }
}

/// In a copy of its own, which all callers share.
#[derive(Clone, Copy)]
pub(crate) struct Shared;

impl Runs for Shared {
    #[inline(never)]
    fn run<T: WithSimd>(self, task: T) -> T::Output {
        Arch::new().dispatch(task)
    }
}

/// eˣ.
#[inline]
pub fn exp(x: f64) -> f64 {
    libm::exp(x)
}

/// Natural logarithm.
#[inline]
pub fn ln(x: f64) -> f64 {
    libm::log(x)
}

/// (sin x, cos x), x in radians.
#[inline]
pub fn sin_cos(x: f64) -> (f64, f64) {
    libm::sincos(x)
}

/// What [`fnv`] starts from.
pub(crate) const FNV_START: u64 = 0xcbf2_9ce4_8422_2325;

/// FNV-1a, 64 bits, of more bytes.
#[inline(never)]
pub(crate) fn fnv(start: u64, bytes: &[u8]) -> u64 {
    bytes
        .iter()
        .fold(start, |hash, &byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3))
}

/// FNV-1a of the bits of more numbers; both zeros are the same.
pub(crate) fn fnv_of(start: u64, values: impl IntoIterator<Item = f64>) -> u64 {
    values.into_iter().fold(start, |hash, x| fnv(hash, &(x + 0.0).to_bits().to_le_bytes()))
}

/// x plus or minus the turns that bring it into [−π, π); as it is, to the bit, where it lies there.
/// Exact for turns of the f64 next to 2π.
#[inline]
pub(crate) fn around(x: f64) -> f64 {
    if (-PI..PI).contains(&x) { x } else { brought_around(x) }
}

#[cold]
#[inline(never)]
fn brought_around(x: f64) -> f64 {
    let rest = libm::remainder(x, TAU);
    if rest >= PI { rest - TAU } else { rest }
}

/// Hyperbolic tangent.
#[inline]
pub fn tanh(x: f64) -> f64 {
    libm::tanh(x)
}

/// What is smaller than these is zero, so that no product of a step is a subnormal number, with
/// which a processor is many times slower. With signals of 1e-30, s and dt make terms of 1e-50;
/// with the two factors of a firing strength, 1e-45 each, they change weights by 1e-140, whose
/// squares are normal. The product of two memberships is no smaller factor. All of them are far
/// below what a signal, rule or weight can mean.
pub(crate) const TINY_SIGNAL: f64 = 1e-30;
pub(crate) const TINY_MEMBERSHIP: f64 = 1e-22;
pub(crate) const TINY_STRENGTH: f64 = 1e-45;
pub(crate) const TINY_TERM: f64 = 1e-50;
pub(crate) const TINY_ESTIMATE: f64 = 1e-100;
pub(crate) const TINY_WEIGHT: f64 = 1e-120;
/// The same for ξ(x)·ξ(y), and for squared norms.
pub(crate) const TINY_KERNEL: f64 = 1e-120;
pub(crate) const TINY_SQUARE: f64 = 1e-200;

/// x, or 0 where |x| is smaller than `least`.
#[inline(always)]
pub(crate) fn unless_tiny(x: f64, least: f64) -> f64 {
    if x.abs() < least { 0.0 } else { x }
}

/// The same where that is rare, for a number that others wait for: with a branch, which the
/// processor foresees. Zeros are not rare, and stay.
#[inline(always)]
pub(crate) fn unless_rarely_tiny(x: f64, least: f64) -> f64 {
    #[cold]
    #[inline(never)]
    fn zero() -> f64 {
        0.0
    }
    if x.abs() < least && x != 0.0 { zero() } else { x }
}

/// The same in every lane.
#[inline(always)]
pub(crate) fn lanes_unless_tiny<S: Simd>(simd: S, x: S::f64s, least: f64) -> S::f64s {
    let tiny = simd.less_than_f64s(simd.abs_f64s(x), simd.splat_f64s(least));
    simd.select_f64s(tiny, simd.splat_f64s(0.0), x)
}

/// e^(−x) for x ≥ 0, or 0 below [`TINY_TERM`].
#[inline]
pub(crate) fn decay(x: f64) -> f64 {
    const LARGEST: f64 = 115.0;
    if x > LARGEST { 0.0 } else { exp(-x) }
}

/// √x, correctly rounded.
#[inline]
pub fn sqrt(x: f64) -> f64 {
    libm::sqrt(x)
}

/// ∛x.
#[inline]
pub fn cbrt(x: f64) -> f64 {
    libm::cbrt(x)
}

#[cfg(test)]
mod tests {
    use super::{PI, TAU, around};

    #[test]
    fn an_angle_is_brought_into_its_turn_and_not_touched_there() {
        let below = f64::from_bits(PI.to_bits() - 1);
        for x in [0.0, -0.0, 1e-320, 0.3, -3.0, below, -below, -PI] {
            assert_eq!(around(x).to_bits(), x.to_bits());
        }
        // By IEEE 754's remainder, which is exact; the half turn goes to the lower end.
        for (x, wanted) in
            [(PI, -PI), (3.0 * PI, -PI), (-3.0 * PI, -PI), (TAU, 0.0), (4.0, 4.0 - TAU)]
        {
            assert_eq!(around(x), wanted, "{x}");
        }
        for turns in [-1024.0, -1.0, 1.0, 2.0, 1024.0] {
            // 0.375 and 1024 · 2π have no more digits together than a number holds but for the last
            // few.
            let (x, rounding) = (0.375 + turns * TAU, 1e-15 * (1.0_f64 + f64::abs(turns)));
            assert!((around(x) - 0.375).abs() <= rounding, "{turns}");
        }
        for x in [1e10, -1e10, 1e300, f64::MAX, -f64::MAX] {
            assert!((-PI..PI).contains(&around(x)), "{x}");
        }
        assert!([f64::NAN, f64::INFINITY].iter().all(|x| around(*x).is_nan()));
    }
}

//! The elementary functions, the matrix types and the lanes of every room, with the same bits on every machine.
//!
//! The platform's `exp` or `sin` differs between C libraries; these come from the `libm` crate.

/// A column of `N` joint values.
pub type Vector<const N: usize> = nalgebra::SVector<f64, N>;

/// A square matrix over `N` joints (or `N` states).
pub type Matrix<const N: usize> = nalgebra::SMatrix<f64, N, N>;

/// Numbers that are worked on side by side, however many a register holds. Rows of weights are whole multiples of this long.
pub(crate) const LANES: usize = 8;

/// Numbers of all lanes in one cache line: a register across two lines costs twice.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct Line(pub [f64; LANES]);

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

/// Hyperbolic tangent.
#[inline]
pub fn tanh(x: f64) -> f64 {
    libm::tanh(x)
}

/// √x, correctly rounded.
#[inline]
pub fn sqrt(x: f64) -> f64 {
    libm::sqrt(x)
}

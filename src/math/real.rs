//! What the arithmetic of a step is done on: one number, or those of several runs side by side.
//!
//! A formula over [`Real`] is written once. It has no branch on a value: [`Real::if_less`] takes
//! one of two. Numbers side by side do not see each other, so each has the bits of its own run.

use core::fmt::Debug;
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use super::{Matrix, Vector};

/// 1.5 · 2⁵²: a float this large holds whole numbers only, in its lowest bits.
pub(super) const ROUNDER: f64 = 6755399441055744.0;

/// A number, or several side by side.
pub trait Real:
    Copy
    + Debug
    + PartialEq
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
{
    /// One of the numbers.
    type Number: Copy + Debug + PartialEq;

    /// The same number x everywhere, in a value of the kind of this one.
    fn like(self, x: f64) -> Self;

    /// The same for one of the numbers.
    fn all(self, x: Self::Number) -> Self;

    /// `then` where `self` < `other`, and `otherwise` elsewhere, also at NaN.
    fn if_less(self, other: Self, then: Self, otherwise: Self) -> Self;

    /// Whether any is less than that of `other`.
    fn any_less(self, other: Self) -> bool;

    /// |x|.
    fn abs(self) -> Self;

    /// √x, correctly rounded.
    fn sqrt(self) -> Self;

    /// eˣ by a series, for −690 ≤ x ≤ 690, and as at the nearer end beyond.
    fn series_exp(self) -> Self;

    /// The same of several.
    #[inline(always)]
    fn series_exps<const M: usize>(mut x: [Self; M]) -> [Self; M] {
        for m in 0..M {
            x[m] = x[m].series_exp();
        }
        x
    }

    /// eˣ.
    fn exp(self) -> Self;

    /// tanh x.
    fn tanh(self) -> Self;

    /// (sin x, cos x), x in radians.
    fn sin_cos(self) -> (Self, Self);

    /// 2ᵏ x, where that and x are normal numbers and k is a whole one.
    fn scaled(self, k: Self) -> Self;

    /// x plus or minus the turns that bring it into [−π, π).
    fn around(self) -> Self;

    /// The whole number next to x, |x| < 2⁵¹, or 2²² in single precision.
    #[inline(always)]
    fn whole(self) -> Self {
        let rounder = self.like(ROUNDER);
        (self + rounder) - rounder
    }

    /// x, or 0 where |x| is smaller than `least`.
    #[inline(always)]
    fn unless_tiny(self, least: f64) -> Self {
        self.abs().if_less(self.like(least), self.like(0.0), self)
    }

    /// The same for a number that is neither negative nor NaN: a sign less to look at.
    #[inline(always)]
    fn positive_unless_tiny(self, least: f64) -> Self {
        self.like(least.next_down()).if_less(self, self, self.like(0.0))
    }

    /// `other` where it is larger, and `self` elsewhere: NaN is never larger.
    #[inline(always)]
    fn or_larger(self, other: Self) -> Self {
        self.if_less(other, other, self)
    }
}

impl Real for f64 {
    type Number = Self;

    #[inline(always)]
    fn like(self, x: f64) -> Self {
        x
    }

    #[inline(always)]
    fn all(self, x: Self) -> Self {
        x
    }

    #[inline(always)]
    fn if_less(self, other: Self, then: Self, otherwise: Self) -> Self {
        if self < other { then } else { otherwise }
    }

    #[inline(always)]
    fn any_less(self, other: Self) -> bool {
        self < other
    }

    #[inline(always)]
    fn abs(self) -> Self {
        f64::abs(self)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        super::sqrt(self)
    }

    #[inline(always)]
    fn exp(self) -> Self {
        super::exp(self)
    }

    #[inline(always)]
    fn tanh(self) -> Self {
        super::tanh(self)
    }

    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        super::sin_cos(self)
    }

    #[inline(always)]
    fn scaled(self, k: Self) -> Self {
        f64::from_bits(self.to_bits().wrapping_add((k + ROUNDER).to_bits() << 52))
    }

    #[inline(always)]
    fn series_exp(self) -> Self {
        super::exponential(pulp::Scalar, self)
    }

    #[inline(always)]
    fn around(self) -> Self {
        super::around(self)
    }
}

/// x·y, entry after entry.
#[inline(always)]
pub(crate) fn dot<const N: usize, T: Real>(x: &Vector<N, T>, y: &Vector<N, T>) -> T {
    let mut sum = x[0] * y[0];
    for n in 1..N {
        sum += x[n] * y[n];
    }
    sum
}

/// M x, column by column.
#[inline(always)]
pub(crate) fn product<const N: usize, T: Real>(
    matrix: &Matrix<N, T>,
    x: &Vector<N, T>,
) -> Vector<N, T> {
    let mut product = *x;
    for i in 0..N {
        let mut sum = matrix[(i, 0)] * x[0];
        for j in 1..N {
            sum += matrix[(i, j)] * x[j];
        }
        product[i] = sum;
    }
    product
}

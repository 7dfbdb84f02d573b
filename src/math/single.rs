//! Arithmetic in single precision, where no double is touched: many microcontrollers have none in
//! hardware. To about the last bit.

use core::f32::consts::FRAC_2_PI;

use super::Real;

/// 1.5 · 2²³: a number this large holds whole numbers only, in its lowest bits.
const ROUNDER: f32 = 12_582_912.0;
/// Exponents are clamped to this: e^±87 is a normal number.
const LARGEST_EXPONENT: f32 = 87.0;
/// π/2 in three pieces; products of the first two with whole numbers up to 2⁹ are exact.
const QUARTER: [f32; 3] = [1.570_312_5, 4.837_513e-4, 7.549_79e-8];
/// Coefficients of the series for the sine and for the cosine, for |x| ≤ π/4. Source: Moshier,
/// Cephes, `sinf`.
const SINE: [f32; 3] = [-1.666_665_5e-1, 8.332_161e-3, -1.951_529_6e-4];
const COSINE: [f32; 3] = [4.166_664_6e-2, -1.388_731_6e-3, 2.443_315_7e-5];
/// Angles beyond this are left to the libm crate, which needs doubles for them.
const NEAR: f32 = 700.0;

impl Real for f32 {
    type Number = Self;

    #[inline(always)]
    fn like(self, x: f64) -> Self {
        x as Self
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
        Self::abs(self)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        libm::sqrtf(self)
    }

    #[inline]
    fn exp(self) -> Self {
        libm::expf(self)
    }

    #[inline]
    fn tanh(self) -> Self {
        libm::tanhf(self)
    }

    #[inline]
    fn series_exp(self) -> Self {
        libm::expf(self.clamp(-LARGEST_EXPONENT, LARGEST_EXPONENT))
    }

    #[inline]
    fn sin_cos(self) -> (Self, Self) {
        if self.abs() < NEAR { near(self) } else { libm::sincosf(self) }
    }

    #[inline(always)]
    fn scaled(self, k: Self) -> Self {
        Self::from_bits(self.to_bits().wrapping_add((k + ROUNDER).to_bits() << 23))
    }

    #[inline]
    fn around(self) -> Self {
        super::around(self.into()) as Self
    }

    #[inline(always)]
    fn whole(self) -> Self {
        (self + ROUNDER) - ROUNDER
    }
}

/// (sin x, cos x), x = n π/2 + y.
#[inline]
fn near(x: f32) -> (f32, f32) {
    let n = (x * FRAC_2_PI).whole();
    let y = ((x - n * QUARTER[0]) - n * QUARTER[1]) - n * QUARTER[2];
    let z = y * y;
    let sine = y + y * z * (SINE[0] + z * (SINE[1] + z * SINE[2]));
    let cosine = (1.0 - 0.5 * z) + z * z * (COSINE[0] + z * (COSINE[1] + z * COSINE[2]));
    match n as i32 & 3 {
        0 => (sine, cosine),
        1 => (cosine, -sine),
        2 => (-sine, -cosine),
        _ => (-cosine, sine),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sine_and_cosine_are_right_to_the_last_bit_or_two() {
        let mut x = -690.0_f32;
        while x < 690.0 {
            let ((sin, cos), wanted) = (Real::sin_cos(x), libm::sincos(x.into()));
            assert!((f64::from(sin) - wanted.0).abs() < 1.2e-7, "{x}");
            assert!((f64::from(cos) - wanted.1).abs() < 1.2e-7, "{x}");
            x += 0.001_7;
        }
        assert_eq!(Real::sin_cos(0.0_f32), (0.0, 1.0));
        assert!([f32::NAN, f32::INFINITY].iter().all(|x| Real::sin_cos(*x).0.is_nan()));
    }

    #[test]
    fn whole_numbers_and_powers_of_two_are_exact() {
        assert_eq!([2.4_f32, -2.6, 0.2, 7.0].map(f32::whole), [2.0, -3.0, 0.0, 7.0]);
        assert_eq!([1.5_f32.scaled(4.0), 1.5_f32.scaled(-4.0)], [24.0, 0.09375]);
        assert_eq!([100.0_f32, -100.0].map(Real::series_exp), [87.0_f32, -87.0].map(libm::expf));
    }
}

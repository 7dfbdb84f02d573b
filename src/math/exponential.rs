//! eˣ in registers, by a series: the same operations in every lane, so that numbers side by side
//! have the bits of one.

use pulp::Simd;

use super::real::ROUNDER;

/// Exponents are clamped to this: e^±690 is a normal float, and nearly the largest.
const LARGEST_EXPONENT: f64 = 690.0;

/// ln 2 in two pieces; the first has so few digits that its products with exponents are exact.
const LN_2: [f64; 2] = [6.931_471_803_691_238e-1, 1.908_214_929_270_587_7e-10];

/// 1/k!
const FACTORS: [f64; 14] = [
    1.0,
    1.0,
    1.0 / 2.0,
    1.0 / 6.0,
    1.0 / 24.0,
    1.0 / 120.0,
    1.0 / 720.0,
    1.0 / 5040.0,
    1.0 / 40320.0,
    1.0 / 362880.0,
    1.0 / 3628800.0,
    1.0 / 39916800.0,
    1.0 / 479001600.0,
    1.0 / 6227020800.0,
];

/// eˣ in every lane, to two units in the last place; x is clamped to ±690. The `libm` crate has no
/// exponential of several numbers at once.
///
/// x = n ln 2 + r with |r| ≤ ½ ln 2, the series of eʳ to r¹³, and n goes into the exponent.
#[inline(always)]
pub(crate) fn exponential<S: Simd>(simd: S, x: S::f64s) -> S::f64s {
    let splat = |x| simd.splat_f64s(x);
    let x = simd.min_f64s(simd.max_f64s(x, splat(-LARGEST_EXPONENT)), splat(LARGEST_EXPONENT));
    let shifted = fused(simd, splat(ROUNDER), x, splat(core::f64::consts::LOG2_E));
    let n = simd.sub_f64s(shifted, splat(ROUNDER));
    let mut r = x;
    for ln in LN_2 {
        r = simd.sub_f64s(r, simd.mul_f64s(n, splat(ln)));
    }
    let r2 = simd.mul_f64s(r, r);
    let r4 = simd.mul_f64s(r2, r2);
    let upper = fused(simd, quad(simd, 8, r, r2), pair(simd, 12, r), r4);
    let lower = fused(simd, quad(simd, 0, r, r2), quad(simd, 4, r, r2), r4);
    let series = fused(simd, lower, upper, simd.mul_f64s(r4, r4));
    let exponent = simd.mul_u64s(simd.transmute_u64s_f64s(shifted), simd.splat_u64s(1 << 52));
    simd.transmute_f64s_u64s(simd.add_u64s(simd.transmute_u64s_f64s(series), exponent))
}

/// a + b c, rounded twice.
#[inline(always)]
fn fused<S: Simd>(simd: S, a: S::f64s, b: S::f64s, c: S::f64s) -> S::f64s {
    simd.add_f64s(a, simd.mul_f64s(b, c))
}

/// Two terms of the series from rᵏ on, over rᵏ.
#[inline(always)]
fn pair<S: Simd>(simd: S, k: usize, r: S::f64s) -> S::f64s {
    fused(simd, simd.splat_f64s(FACTORS[k]), simd.splat_f64s(FACTORS[k + 1]), r)
}

/// Four terms of the series from rᵏ on, over rᵏ.
#[inline(always)]
fn quad<S: Simd>(simd: S, k: usize, r: S::f64s, r2: S::f64s) -> S::f64s {
    fused(simd, pair(simd, k, r), pair(simd, k + 2, r), r2)
}

#[cfg(test)]
mod tests {
    use pulp::{Arch, Scalar, WithSimd};

    use super::*;
    use crate::math::{LANES, exp};

    struct Exponentials([f64; LANES]);

    impl WithSimd for Exponentials {
        type Output = [f64; LANES];

        fn with_simd<S: Simd>(mut self, simd: S) -> Self::Output {
            for x in S::as_mut_simd_f64s(&mut self.0).0 {
                *x = exponential(simd, *x);
            }
            self.0
        }
    }

    #[test]
    fn exponential_is_that_of_libm_to_two_units_in_the_last_place() {
        for k in -69_000..69_000 {
            let x = [0.0, 0.001, 0.002, 0.0037, 0.005, 0.0061, 0.007, 0.0099]
                .map(|offset| f64::from(k) * 0.01 + offset);
            let y = Exponentials(x).with_simd(Scalar);
            for (x, y) in x.iter().zip(y) {
                assert!((y - exp(*x)).abs() <= 2.0 * f64::EPSILON * y, "{x}");
            }
            assert_eq!(y, Arch::new().dispatch(Exponentials(x)));
        }
        let far = Exponentials([700.0, -700.0, 1e300, -1e300, 0.0, -0.0, 690.0, -690.0]);
        let y = far.with_simd(Scalar);
        assert_eq!([y[0], y[2], y[1], y[3]], [y[6], y[6], y[7], y[7]]);
        assert_eq!([y[4], y[5]], [1.0, 1.0]);
        assert!(y[6].is_normal() && y[7].is_normal());
    }
}

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
#[inline(always)]
pub(crate) fn exponential<S: Simd>(simd: S, x: S::f64s) -> S::f64s {
    let [y] = exponentials(simd, [x]);
    y
}

/// The same of several registers, step by step of all: a processor looks only so far ahead for what
/// it can do at a time.
///
/// x = n ln 2 + r with |r| ≤ ½ ln 2, the series of eʳ to r¹³, and n goes into the exponent.
#[inline(always)]
pub(crate) fn exponentials<S: Simd, const M: usize>(simd: S, x: [S::f64s; M]) -> [S::f64s; M] {
    let splat = |x| simd.splat_f64s(x);
    let (mut r, mut shifted, mut r2, mut r4, mut lower, mut upper) = (x, x, x, x, x, x);
    for m in 0..M {
        r[m] =
            simd.min_f64s(simd.max_f64s(x[m], splat(-LARGEST_EXPONENT)), splat(LARGEST_EXPONENT));
        shifted[m] = fused(simd, splat(ROUNDER), r[m], splat(core::f64::consts::LOG2_E));
    }
    for ln in LN_2 {
        for m in 0..M {
            let n = simd.sub_f64s(shifted[m], splat(ROUNDER));
            r[m] = simd.sub_f64s(r[m], simd.mul_f64s(n, splat(ln)));
        }
    }
    for m in 0..M {
        r2[m] = simd.mul_f64s(r[m], r[m]);
        r4[m] = simd.mul_f64s(r2[m], r2[m]);
    }
    for m in 0..M {
        upper[m] = fused(simd, quad(simd, 8, r[m], r2[m]), pair(simd, 12, r[m]), r4[m]);
    }
    for m in 0..M {
        lower[m] = fused(simd, quad(simd, 0, r[m], r2[m]), quad(simd, 4, r[m], r2[m]), r4[m]);
    }
    for m in 0..M {
        let series = fused(simd, lower[m], upper[m], simd.mul_f64s(r4[m], r4[m]));
        let exponent =
            simd.mul_u64s(simd.transmute_u64s_f64s(shifted[m]), simd.splat_u64s(1 << 52));
        let scaled = simd.add_u64s(simd.transmute_u64s_f64s(series), exponent);
        r[m] = simd.transmute_f64s_u64s(scaled);
    }
    r
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

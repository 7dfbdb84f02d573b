//! eˣ and tanh x side by side, with the bits of the libm crate's.
//!
//! x = k ln 2 + r. eʳ is a quotient of series, and 2ᵏ goes into the exponent; tanh is made of
//! e^2x − 1. Each case of libm's is one choice of the numbers that go into one formula.
//! Source: the same series, FreeBSD's `e_exp`, `s_expm1` and `s_tanh`.

use super::Real;

/// 1/ln 2; ln 2 in two pieces, of which products of the first with whole numbers are exact.
const INVERSE_LN_2: f64 = core::f64::consts::LOG2_E;
const LN_2: [f64; 2] = [6.931_471_803_691_238e-1, 1.908_214_929_270_587_7e-10];
/// Coefficients of r − c(r) for eˣ, and of the series for eˣ − 1.
const EXP: [f64; 5] = [
    1.666_666_666_666_660_2e-1,
    -2.777_777_777_701_559_3e-3,
    6.613_756_321_437_934e-5,
    -1.653_390_220_546_525_2e-6,
    4.138_136_797_057_238_5e-8,
];
const EXP_MINUS_1: [f64; 5] = [
    -3.333_333_333_333_313e-2,
    1.587_301_587_254_814_6e-3,
    -7.936_507_578_674_88e-5,
    4.008_217_827_329_362e-6,
    -2.010_992_181_836_243_7e-7,
];
/// Sizes below which k = 0, and below which it is ±1: ½ ln 2 and 1½ ln 2, to libm's digits.
const HALF_LN_2: f64 = f64::from_bits(0x3fd6_2e43 << 32);
const MOST_OF_ONE: f64 = f64::from_bits(0x3ff0_a2b2 << 32);
/// Sizes below which eˣ = 1 + x, and eˣ − 1 = x.
const LINEAR: f64 = f64::from_bits(0x3e30_0001 << 32);
const ITSELF: f64 = f64::from_bits(0x3c90_0000 << 32);
/// Beyond these eˣ is no normal number, or might not be.
const NORMAL: f64 = 700.0;
/// eˣ is 0 below this.
const NOTHING: f64 = -745.133_219_101_941_1;
/// Sizes above which tanh x = ±1, is 1 − 2/(e^2x + 1), and is made of e^2x − 1.
const FLAT: f64 = f64::from_bits(0x4034_0001 << 32);
const UPPER: f64 = f64::from_bits(0x3fe1_93eb << 32);
const MIDDLE: f64 = f64::from_bits(0x3fd0_58af << 32);

/// k, and x − k ln 2 = high − low, rounded as libm does.
struct Reduced<T> {
    k: T,
    high: T,
    low: T,
}

#[inline(always)]
fn reduced<T: Real>(x: T) -> Reduced<T> {
    let (zero, one, size) = (x.like(0.0), x.like(1.0), x.abs());
    let many = floor(x.like(INVERSE_LN_2) * size + x.like(0.5));
    let k = size.if_less(x.like(MOST_OF_ONE), one, many);
    let k = size.if_less(x.like(HALF_LN_2), zero, k);
    let k = x.if_less(zero, -k, k);
    Reduced { k, high: x - k * x.like(LN_2[0]), low: k * x.like(LN_2[1]) }
}

/// The largest whole number up to x ≥ 0.
#[inline(always)]
fn floor<T: Real>(x: T) -> T {
    let near = x.whole();
    x.if_less(near, near - x.like(1.0), near)
}

/// 1 where [`near_exp`] is not as the libm crate, and 0 elsewhere.
#[inline(always)]
pub(super) fn rare_exp<T: Real>(x: T) -> T {
    let (zero, one) = (x.like(0.0), x.like(1.0));
    let rare = x.abs().if_less(x.like(NORMAL), zero, one);
    x.if_less(x.like(NOTHING), zero, rare)
}

/// eˣ where that is a normal number, or 0.
#[inline(always)]
pub(super) fn near_exp<T: Real>(x: T) -> T {
    let (one, size) = (x.like(1.0), x.abs());
    let Reduced { k, high, low } = reduced(x);
    let r = high - low;
    let square = r * r;
    let c = r - square * series(square, EXP);
    let y = one + (r * c / (x.like(2.0) - c) - low + high);
    let y = size.if_less(x.like(LINEAR), one + x, y.scaled(k));
    x.if_less(x.like(NOTHING), x.like(0.0), y)
}

/// tanh x.
#[inline(always)]
pub(super) fn near_tanh<T: Real>(x: T) -> T {
    let (zero, one, two, size) = (x.like(0.0), x.like(1.0), x.like(2.0), x.abs());
    let twice = two * size;
    let t = exp_minus_1(size.if_less(x.like(MIDDLE), -twice, twice));
    let over = size.if_less(x.like(UPPER), size.if_less(x.like(MIDDLE), -t, t), two);
    let share = over / (t + two);
    let tanh = size.if_less(x.like(UPPER), share, one - share);
    let tanh = size.if_less(x.like(FLAT), tanh, one - zero / size);
    size.if_less(x.like(f64::MIN_POSITIVE), x, x.if_less(zero, -tanh, tanh))
}

/// eˣ − 1 for −0.52 < x < 41.
#[inline(always)]
fn exp_minus_1<T: Real>(x: T) -> T {
    let (zero, half, one, two) = (x.like(0.0), x.like(0.5), x.like(1.0), x.like(2.0));
    let Reduced { k, high, low } = reduced(x);
    let r = high - low;
    let c = (high - r) - low;
    let half_r = half * r;
    let half_square = r * half_r;
    let r1 = one + half_square * series(half_square, EXP_MINUS_1);
    let t = x.like(3.0) - r1 * half_r;
    let e = half_square * ((r1 - t) / (x.like(6.0) - r * t));
    let plain = r - (r * e - half_square);
    let e = (r * (e - c) - c) - half_square;
    let halved = half * (r - e) - half;
    let steep = -two * (e - (r + half));
    let doubled = r.if_less(x.like(-0.25), steep, one + two * (r - e));
    let small = one.scaled(-k);
    let few = ((r - e) + (one - small)).scaled(k);
    let some = ((r - (e + small)) + one).scaled(k);
    let many = ((r - e) + one).scaled(k) - one;
    let above = k.if_less(x.like(19.5), few, k.if_less(x.like(56.5), some, many));
    let above = k.if_less(x.like(1.5), doubled, above);
    let y = k.abs().if_less(half, plain, k.if_less(zero, halved, above));
    x.abs().if_less(x.like(ITSELF), x, y)
}

/// c₁ + z (c₂ + z (…)).
#[inline(always)]
fn series<T: Real>(z: T, [c1, c2, c3, c4, c5]: [f64; 5]) -> T {
    z.like(c1) + z * (z.like(c2) + z * (z.like(c3) + z * (z.like(c4) + z * z.like(c5))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{exp, tanh};

    /// Numbers over all decades, of both signs, and near the ends of each case.
    fn numbers() -> Vec<f64> {
        let ends = [
            HALF_LN_2,
            MOST_OF_ONE,
            LINEAR,
            ITSELF,
            NORMAL,
            NOTHING,
            FLAT,
            UPPER,
            MIDDLE,
            f64::MIN_POSITIVE,
        ];
        let mut all = vec![0.0, -0.0, f64::INFINITY, f64::NEG_INFINITY, 5e-324, 1e300];
        for end in ends {
            for share in [0.25, 0.5, 1.0, 2.0] {
                for step in -40_i64..=40 {
                    let x = f64::from_bits((share * end).to_bits().wrapping_add_signed(step));
                    all.extend([x, -x]);
                }
            }
        }
        for k in 1..=60 {
            for step in -20_i32..=20 {
                let x = (f64::from(k) + 0.5) * core::f64::consts::LN_2 + f64::from(step) * 1e-13;
                all.extend([x, -x, 0.5 * x, -0.5 * x]);
            }
        }
        let mut x = 1e-20_f64;
        while x < 800.0 {
            all.extend([x, -x]);
            x *= 1.000_61;
        }
        all
    }

    #[test]
    fn coefficients_are_those_of_the_source_to_the_last_bit() {
        let exp = "1.66666666666666019037e-01 -2.77777777770155933842e-03 \
                   6.61375632143793436117e-05 -1.65339022054652515390e-06 \
                   4.13813679705723846039e-08";
        let minus_1 = "-3.33333333333331316428e-02 1.58730158725481460165e-03 \
                       -7.93650757867487942473e-05 4.00821782732936239552e-06 \
                       -2.01099218183624371326e-07";
        for (own, source) in [(EXP, exp), (EXP_MINUS_1, minus_1)] {
            let source: Vec<f64> =
                source.split(' ').map(|digits| digits.parse().unwrap()).collect();
            assert_eq!(own[..], source);
        }
    }

    #[test]
    fn exponentials_have_the_bits_of_the_libm_crate() {
        let mut common = 0;
        for x in numbers() {
            if rare_exp(x) == 0.0 {
                assert_eq!(near_exp(x).to_bits(), exp(x).to_bits(), "{x:e}");
                common += 1;
            }
        }
        assert!(common > 100_000, "{common}");
        assert_eq!([f64::NAN, f64::INFINITY, -740.0].map(rare_exp), [1.0; 3]);
    }

    #[test]
    fn hyperbolic_tangents_have_the_bits_of_the_libm_crate() {
        for x in numbers() {
            assert_eq!(near_tanh(x).to_bits(), tanh(x).to_bits(), "{x:e}");
        }
        assert!(near_tanh(f64::NAN).is_nan());
    }
}

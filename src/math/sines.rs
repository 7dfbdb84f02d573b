//! Sine and cosine side by side, with the bits of the libm crate's.
//!
//! An angle is `x = n π/2 + y + rest`; the sine and cosine of y + rest are a series each, and n
//! says which is which, and with what sign. libm reduces some angles in another way. These are
//! [`rare`], and are left to it.
//! Source: the same series, FreeBSD's `k_sin` and `k_cos`, and its `rem_pio2`.

use super::Real;

/// 2/π; the first 33 digits of π/2, and the rest.
const TURNS: f64 = core::f64::consts::FRAC_2_PI;
const QUARTER: [f64; 2] = [1.570_796_326_734_125_6, 6.077_100_506_506_192e-11];
/// Below these an angle is not reduced, and its sine is itself.
const UNREDUCED: f64 = f64::from_bits(0x3fe9_21fc << 32);
const OWN_SINE: f64 = f64::from_bits(0x3e46_a09e << 32);
/// Coefficients of the series for the sine and for the cosine.
const SINE: [f64; 6] = [
    -1.666_666_666_666_663_2e-1,
    8.333_333_333_322_49e-3,
    -1.984_126_982_985_795e-4,
    2.755_731_370_707_006_8e-6,
    -2.505_076_025_340_686_3e-8,
    1.589_690_995_211_55e-10,
];
const COSINE: [f64; 6] = [
    4.166_666_666_666_66e-2,
    -1.388_888_888_887_411e-3,
    2.480_158_728_947_673e-5,
    -2.755_731_435_139_066_3e-7,
    2.087_572_321_298_175e-9,
    -1.135_964_755_778_819_5e-11,
];
/// Angles this near to the middle between two quarters, in quarters, or to a multiple of one,
/// relative, and those this large, are rare.
const MIDDLE: f64 = 1e-4;
const MULTIPLE: f64 = 1e-4;
const LARGE: f64 = 1e5;

/// An angle as n quarters and what is left, y + rest.
struct Reduced<T> {
    n: T,
    y: T,
    rest: T,
}

#[inline(always)]
fn reduced<T: Real>(x: T) -> Reduced<T> {
    let n = (x * x.like(TURNS)).whole();
    let (r, w) = (x - n * x.like(QUARTER[0]), n * x.like(QUARTER[1]));
    let y = r - w;
    Reduced { n, y, rest: (r - y) - w }
}

/// 1 where [`near`] is not as the libm crate, and 0 elsewhere.
#[inline(always)]
pub(super) fn rare<T: Real>(x: T) -> T {
    let (zero, one, size) = (x.like(0.0), x.like(1.0), x.abs());
    let Reduced { n, y, .. } = reduced(x);
    let from_middle = ((x * x.like(TURNS) - n).abs() - x.like(0.5)).abs();
    let rare = from_middle.if_less(x.like(MIDDLE), one, zero);
    let rare = y.abs().if_less(x.like(MULTIPLE) * size, one, rare);
    let rare = size.if_less(x.like(LARGE), rare, one);
    size.if_less(x.like(UNREDUCED), zero, rare)
}

/// (sin x, cos x) of angles that are not rare.
#[inline(always)]
pub(super) fn near<T: Real>(x: T) -> (T, T) {
    let (zero, size, small) = (x.like(0.0), x.abs(), x.like(UNREDUCED));
    let Reduced { n, y, rest } = reduced(x);
    let n = size.if_less(small, zero, n);
    let y = size.if_less(small, x, y);
    let rest = size.if_less(small, zero, rest);
    let (sin, cos) = (sine(y, rest, size), cosine(y, rest, size));
    // n mod 2, and n mod 4 in −2 … 2.
    let odd = (n - x.like(2.0) * (n * x.like(0.5)).whole()).abs();
    let quarter = n - x.like(4.0) * (n * x.like(0.25)).whole();
    let half = x.like(0.5);
    let (s, c) = (odd.if_less(half, sin, cos), odd.if_less(half, cos, sin));
    // In quarters 2 and 3 the sine is negative, in 1 and 2 the cosine.
    let s = quarter.if_less(x.like(-0.5), -s, x.like(1.5).if_less(quarter, -s, s));
    let c = half.if_less(quarter, -c, quarter.if_less(x.like(-1.5), -c, c));
    (s, c)
}

#[inline(always)]
fn sine<T: Real>(x: T, rest: T, size: T) -> T {
    let [s1, s2, s3, s4, s5, s6] = SINE;
    let z = x * x;
    let w = z * z;
    let r = x.like(s2) + z * (x.like(s3) + z * x.like(s4)) + z * w * (x.like(s5) + z * x.like(s6));
    let v = z * x;
    let small = x + v * (x.like(s1) + z * r);
    let reduced = x - ((z * (x.like(0.5) * rest - v * r) - rest) - v * x.like(s1));
    let sine = size.if_less(x.like(UNREDUCED), small, reduced);
    size.if_less(x.like(OWN_SINE), x, sine)
}

#[inline(always)]
fn cosine<T: Real>(x: T, rest: T, size: T) -> T {
    let [c1, c2, c3, c4, c5, c6] = COSINE;
    let z = x * x;
    let w = z * z;
    let r = z * (x.like(c1) + z * (x.like(c2) + z * x.like(c3)))
        + w * w * (x.like(c4) + z * (x.like(c5) + z * x.like(c6)));
    let half = x.like(0.5) * z;
    let one = x.like(1.0);
    let w = one - half;
    let cosine = w + (((one - w) - half) + (z * r - x * rest));
    size.if_less(x.like(OWN_SINE), one, cosine)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::sin_cos;

    #[test]
    fn coefficients_are_those_of_the_source_to_the_last_bit() {
        let sine = "-1.66666666666666324348e-01 8.33333333332248946124e-03 \
                    -1.98412698298579493134e-04 2.75573137070700676789e-06 \
                    -2.50507602534068634195e-08 1.58969099521155010221e-10";
        let cosine = "4.16666666666666019037e-02 -1.38888888888741095749e-03 \
                      2.48015872894767294178e-05 -2.75573143513906633035e-07 \
                      2.08757232129817482790e-09 -1.13596475577881948265e-11";
        for (own, source) in [(SINE, sine), (COSINE, cosine)] {
            let source: Vec<f64> =
                source.split(' ').map(|digits| digits.parse().unwrap()).collect();
            assert_eq!(own[..], source);
        }
    }

    /// Against libm, bit for bit: near all multiples of π/4, over many decades, and at both zeros.
    #[test]
    fn sine_and_cosine_have_the_bits_of_the_libm_crate() {
        let mut angles =
            vec![0.0, -0.0, f64::NAN, f64::INFINITY, -1e300, 5e-324, 2.0_f64.powi(-27)];
        // One of forty million that a wrong last digit of a coefficient shows in.
        angles.push(-0.815_092_611_687_436_9);
        for k in -40_i32..=40 {
            let middle = f64::from(k) * core::f64::consts::FRAC_PI_4;
            for step in -60_i32..=60 {
                angles.push(middle + f64::from(step) * 1.7e-6);
                angles.push(f64::from_bits(middle.to_bits().wrapping_add_signed(step.into())));
            }
        }
        let mut x = 1e-12_f64;
        while x < 1e9 {
            angles.extend([x, -x]);
            x *= 1.000_37;
        }
        let mut common = 0;
        for x in angles {
            if rare(x) == 0.0 {
                let (sin, cos) = near(x);
                let wanted = sin_cos(x);
                assert_eq!(
                    (sin.to_bits(), cos.to_bits()),
                    (wanted.0.to_bits(), wanted.1.to_bits())
                );
                common += 1;
            }
        }
        assert!(common > 50_000, "{common}");
        assert_eq!([f64::NAN, f64::INFINITY, 1e300].map(rare), [1.0; 3]);
    }
}

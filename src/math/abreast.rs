//! Numbers of eight runs side by side, in as many registers as they take.
//!
//! Plain loops over eight entries: a caller that is compiled for the instruction set at hand has
//! them in its registers. What a loop cannot do side by side is done one after the other.

use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use super::{LANES, Real, around, sin_cos, sqrt};

/// A number of each of eight runs.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(64))]
pub struct Abreast(pub [f64; LANES]);

macro_rules! entrywise {
    ($($trait:ident::$method:ident by $op:tt)*) => {$(
        impl $trait for Abreast {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                let mut all = self.0;
                for lane in 0..LANES {
                    all[lane] = self.0[lane] $op other.0[lane];
                }
                Self(all)
            }
        }
    )*};
}

entrywise! { Add::add by + Sub::sub by - Mul::mul by * Div::div by / }

impl Neg for Abreast {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        self.each(|x| -x)
    }
}

impl AddAssign for Abreast {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Abreast {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

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

    /// f of each.
    #[inline(always)]
    fn each(self, f: impl Fn(f64) -> f64) -> Self {
        let mut all = self.0;
        for x in &mut all {
            *x = f(*x);
        }
        Self(all)
    }
}

impl Real for Abreast {
    #[inline(always)]
    fn like(self, x: f64) -> Self {
        Self::all(x)
    }

    #[inline(always)]
    fn if_less(self, other: Self, then: Self, otherwise: Self) -> Self {
        let mut all = otherwise.0;
        for lane in 0..LANES {
            all[lane] = if self.0[lane] < other.0[lane] { then.0[lane] } else { otherwise.0[lane] };
        }
        Self(all)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        self.each(f64::abs)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        self.each(sqrt)
    }

    #[inline(always)]
    fn around(self) -> Self {
        Self(self.0.map(around))
    }

    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos, common) = near(self);
        if common { (sin, cos) } else { one_by_one(self) }
    }
}

/// Sine and cosine one after the other, where an argument is a rare one.
#[cold]
#[inline(never)]
fn one_by_one(x: Abreast) -> (Abreast, Abreast) {
    let both = x.0.map(sin_cos);
    (Abreast(both.map(|(sin, _)| sin)), Abreast(both.map(|(_, cos)| cos)))
}

/// 2/π; 1.5 · 2⁵², which rounds what it is added to; the first 33 digits of π/2, and the rest.
const TURNS: f64 = 6.366_197_723_675_814e-1;
const ROUNDER: f64 = 6755399441055744.0;
const QUARTER: [f64; 2] = [1.570_796_326_734_125_6, 6.077_100_506_506_192e-11];
/// Below these an angle is not reduced, and its sine is itself.
const UNREDUCED: f64 = f64::from_bits(0x3fe9_21fc << 32);
const OWN_SINE: f64 = f64::from_bits(0x3e46_a09e << 32);
/// Coefficients of the series for the sine and for the cosine.
const SINE: [f64; 6] = [
    -1.666_666_666_666_663_2e-1,
    8.333_333_333_322_49e-3,
    -1.984_126_982_985_795e-4,
    2.755_731_370_707_007e-6,
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
/// Arguments this near to the middle between two quarters, in quarters, or to a multiple of one,
/// relative, and those this large, are rare: libm reduces them in another way.
const MIDDLE: f64 = 1e-4;
const MULTIPLE: f64 = 1e-4;
const LARGE: f64 = 1e5;

/// Sine and cosine as the libm crate makes them of what is not rare, and whether none is.
///
/// Source: the same series as there, FreeBSD's `k_sin` and `k_cos`.
#[inline(always)]
fn near(x: Abreast) -> (Abreast, Abreast, bool) {
    let all = Abreast::all;
    let turns = x * all(TURNS);
    let shifted = turns + all(ROUNDER);
    let n = shifted - all(ROUNDER);
    let size = x.abs();
    let whole = |reduced| size.if_less(all(UNREDUCED), x, reduced);
    // x = n π/2 + y + rest
    let (r, w) = (x - n * all(QUARTER[0]), n * all(QUARTER[1]));
    let y = whole(r - w);
    let rest = size.if_less(all(UNREDUCED), all(0.0), (r - (r - w)) - w);
    let far = ((turns - n).abs() - all(0.5)).abs();
    let mut common = true;
    for lane in 0..LANES {
        let (size, y) = (size.0[lane], y.0[lane].abs());
        let reduced = far.0[lane] > MIDDLE && y > MULTIPLE * size && size < LARGE;
        common &= size < UNREDUCED || reduced;
    }
    let (sin, cos) = (sine(y, rest, size), cosine(y, rest, size));
    let (mut sines, mut cosines) = (sin, cos);
    for lane in 0..LANES {
        let quarter = if size.0[lane] < UNREDUCED { 0 } else { shifted.0[lane].to_bits() };
        let (s, c) = (sin.0[lane].to_bits(), cos.0[lane].to_bits());
        let (s, c) = if quarter & 1 == 0 { (s, c) } else { (c, s) };
        // In quarters 2 and 3 the sine is negative, in 1 and 2 the cosine.
        sines.0[lane] = f64::from_bits(s ^ ((quarter & 2) << 62));
        cosines.0[lane] = f64::from_bits(c ^ ((quarter.wrapping_add(1) & 2) << 62));
    }
    (sines, cosines, common)
}

#[inline(always)]
fn sine(x: Abreast, rest: Abreast, size: Abreast) -> Abreast {
    let all = Abreast::all;
    let [s1, s2, s3, s4, s5, s6] = SINE.map(all);
    let z = x * x;
    let w = z * z;
    let r = s2 + z * (s3 + z * s4) + z * w * (s5 + z * s6);
    let v = z * x;
    let whole = x + v * (s1 + z * r);
    let reduced = x - ((z * (all(0.5) * rest - v * r) - rest) - v * s1);
    let sine = size.if_less(all(UNREDUCED), whole, reduced);
    size.if_less(all(OWN_SINE), x, sine)
}

#[inline(always)]
fn cosine(x: Abreast, rest: Abreast, size: Abreast) -> Abreast {
    let all = Abreast::all;
    let [c1, c2, c3, c4, c5, c6] = COSINE.map(all);
    let z = x * x;
    let w = z * z;
    let r = z * (c1 + z * (c2 + z * c3)) + w * w * (c4 + z * (c5 + z * c6));
    let half = all(0.5) * z;
    let w = all(1.0) - half;
    let cosine = w + (((all(1.0) - w) - half) + (z * r - x * rest));
    size.if_less(all(OWN_SINE), all(1.0), cosine)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against libm, bit for bit: near all multiples of π/4, over many decades, and at both zeros.
    #[test]
    fn sine_and_cosine_have_the_bits_of_one_at_a_time() {
        let mut angles =
            vec![0.0, -0.0, f64::NAN, f64::INFINITY, -1e300, 5e-324, 2.0_f64.powi(-27)];
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
        angles.resize(angles.len().next_multiple_of(LANES), 1.0);
        for eight in angles.as_chunks::<LANES>().0 {
            let (sines, cosines) = Abreast(*eight).sin_cos();
            for lane in 0..LANES {
                let (sin, cos) = sin_cos(eight[lane]);
                let same = |a: f64, b: f64| a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan();
                assert!(same(sines.0[lane], sin) && same(cosines.0[lane], cos), "{}", eight[lane]);
            }
        }
    }
}

//! A register of numbers of several runs: half or all of what is [`Abreast`].
//!
//! The type carries the instruction set, so its operations are registers' own. They must be in line
//! in a caller that is compiled for it: nothing in such a caller is a closure over numbers.

use core::fmt::{self, Debug};
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use nalgebra::{ArrayStorage, SMatrix};
use pulp::Simd;

use super::exp_tanh::{near_exp, near_tanh, rare_exp};
use super::real::ROUNDER;
use super::sines::{near, rare};
use super::{Abreast, LANES, Real, Vector, around, exp, exponential, exponentials, sin_cos};

/// As many numbers as a register of the instruction set `S` holds; in memory, in one cache line.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub(crate) struct Register<S: Simd> {
    simd: S,
    numbers: S::f64s,
}

impl<S: Simd> Register<S> {
    /// Registers that hold what is abreast.
    pub const PARTS: usize = LANES / S::F64_LANES;

    /// Puts them in their place.
    #[inline(always)]
    pub fn store(self, to: &mut Abreast, part: usize) {
        S::as_mut_simd_f64s(&mut to.0).0[part] = self.numbers;
    }

    /// f of each, one after the other.
    #[inline(never)]
    fn one_by_one<const K: usize>(self, f: fn(f64) -> [f64; K]) -> [Self; K] {
        let (mut from, mut to) = (Abreast::all(0.0), [Abreast::all(0.0); K]);
        self.store(&mut from, 0);
        for lane in 0..S::F64_LANES {
            for (to, x) in to.iter_mut().zip(f(from.0[lane])) {
                to.0[lane] = x;
            }
        }
        to.map(|to| to.load(self.simd, 0))
    }
}

impl<S: Simd> Debug for Register<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        Debug::fmt(&self.numbers, f)
    }
}

/// Of all numbers; NaN is equal to nothing.
impl<S: Simd> PartialEq for Register<S> {
    fn eq(&self, other: &Self) -> bool {
        let same = self.simd.equal_f64s(self.numbers, other.numbers);
        self.simd.first_true_m64s(self.simd.not_m64s(same)) == S::F64_LANES
    }
}

macro_rules! operations {
    ($($trait:ident::$method:ident by $op:ident)*) => {$(
        impl<S: Simd> $trait for Register<S> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self { numbers: self.simd.$op(self.numbers, other.numbers), ..self }
            }
        }
    )*};
}

operations! {
    Add::add by add_f64s
    Sub::sub by sub_f64s
    Mul::mul by mul_f64s
    Div::div by div_f64s
}

impl<S: Simd> Neg for Register<S> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self { numbers: self.simd.neg_f64s(self.numbers), ..self }
    }
}

impl<S: Simd> AddAssign for Register<S> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<S: Simd> SubAssign for Register<S> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl<S: Simd> Real for Register<S> {
    type Number = f64;

    #[inline(always)]
    fn all(self, x: f64) -> Self {
        self.like(x)
    }

    #[inline(always)]
    fn like(self, x: f64) -> Self {
        Self { numbers: self.simd.splat_f64s(x), ..self }
    }

    #[inline(always)]
    fn if_less(self, other: Self, then: Self, otherwise: Self) -> Self {
        let less = self.simd.less_than_f64s(self.numbers, other.numbers);
        Self { numbers: self.simd.select_f64s(less, then.numbers, otherwise.numbers), ..self }
    }

    #[inline(always)]
    fn any_less(self, other: Self) -> bool {
        let less = self.simd.less_than_f64s(self.numbers, other.numbers);
        self.simd.first_true_m64s(less) != S::F64_LANES
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self { numbers: self.simd.abs_f64s(self.numbers), ..self }
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self { numbers: self.simd.sqrt_f64s(self.numbers), ..self }
    }

    #[inline(always)]
    fn exp(self) -> Self {
        if self.like(0.0).any_less(rare_exp(self)) {
            let [y] = self.one_by_one(|x| [exp(x)]);
            return y;
        }
        near_exp(self)
    }

    #[inline(always)]
    fn tanh(self) -> Self {
        near_tanh(self)
    }

    #[inline(always)]
    fn scaled(self, k: Self) -> Self {
        let (simd, k) = (self.simd, (k + k.like(ROUNDER)).numbers);
        let exponent = simd.mul_u64s(simd.transmute_u64s_f64s(k), simd.splat_u64s(1 << 52));
        let bits = simd.add_u64s(simd.transmute_u64s_f64s(self.numbers), exponent);
        Self { numbers: simd.transmute_f64s_u64s(bits), ..self }
    }

    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        if !self.like(0.0).any_less(rare(self)) {
            return near(self);
        }
        let [sin, cos] = self.one_by_one(|x| sin_cos(x).into());
        (sin, cos)
    }

    #[inline(always)]
    fn series_exp(self) -> Self {
        Self { numbers: exponential(self.simd, self.numbers), ..self }
    }

    #[inline(always)]
    fn series_exps<const M: usize>(mut x: [Self; M]) -> [Self; M] {
        let Some(first) = x.first() else { return x };
        let (simd, mut numbers) = (first.simd, [first.numbers; M]);
        for m in 0..M {
            numbers[m] = x[m].numbers;
        }
        numbers = exponentials(simd, numbers);
        for m in 0..M {
            x[m].numbers = numbers[m];
        }
        x
    }

    #[inline(always)]
    fn around(self) -> Self {
        let [x] = self.one_by_one(|x| [around(x)]);
        x
    }
}

/// What is abreast in memory, and is worked on in registers.
pub(crate) trait Load {
    /// It in registers of an instruction set.
    type In<S: Simd>;

    /// That part of its numbers.
    fn load<S: Simd>(&self, simd: S, part: usize) -> Self::In<S>;
}

impl Load for Abreast {
    type In<S: Simd> = Register<S>;

    #[inline(always)]
    fn load<S: Simd>(&self, simd: S, part: usize) -> Register<S> {
        Register { simd, numbers: S::as_simd_f64s(&self.0).0[part] }
    }
}

impl<const N: usize> Load for [Abreast; N] {
    type In<S: Simd> = [Register<S>; N];

    #[inline(always)]
    fn load<S: Simd>(&self, simd: S, part: usize) -> [Register<S>; N] {
        let mut registers = [self[0].load(simd, part); N];
        for n in 1..N {
            registers[n] = self[n].load(simd, part);
        }
        registers
    }
}

impl<const R: usize, const C: usize> Load for SMatrix<Abreast, R, C> {
    type In<S: Simd> = SMatrix<Register<S>, R, C>;

    #[inline(always)]
    fn load<S: Simd>(&self, simd: S, part: usize) -> SMatrix<Register<S>, R, C> {
        let columns = &self.data.0;
        let mut registers = [columns[0].load(simd, part); C];
        for c in 1..C {
            registers[c] = columns[c].load(simd, part);
        }
        SMatrix::from_array_storage(ArrayStorage(registers))
    }
}

/// Puts a part of all numbers into its place.
#[inline(always)]
pub(crate) fn store<const N: usize, S: Simd>(
    from: &Vector<N, Register<S>>,
    to: &mut Vector<N, Abreast>,
    part: usize,
) {
    for n in 0..N {
        from[n].store(&mut to[n], part);
    }
}

//! A stage of eight compensators side by side: memberships, ρ̂, and what drives the weights.

use pulp::{Simd, WithSimd};

use super::per_joint::{INPUTS, Pattern, PerJoint, Shape};
use crate::control::adaptation::{size, weakened};
use crate::control::{Sample, Stage};
use crate::fuzzy::MOST_SPACED;
use crate::math::{
    Abreast, LANES, Load, Real, Register, TINY_ESTIMATE, TINY_KERNEL, TINY_TERM, column,
};

/// What drives the weights beyond this is not ordinary: they might come to be refused.
const MOST_DRIVE: f64 = 1e100;

pub(super) struct Estimate<'a, const N: usize> {
    pub it: &'a mut PerJoint<N>,
    pub stage: &'a Stage<'a>,
    pub seen: &'a Sample<N, Abreast>,
    pub lost: &'a mut Abreast,
}

impl<const N: usize> WithSimd for Estimate<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Shape { sets, pattern } = self.it.shape;
        match pattern {
            Pattern::Even3 => self.of(simd, [3; 2], Some([0, 1, 2])),
            Pattern::Even5 => self.of(simd, [5; 2], Some([0, 1, 2, 3, 4])),
            Pattern::Paper => self.of(simd, [5; 2], Some([0, 2, 3, 4, 6])),
            Pattern::Even7 => self.of(simd, [7; 2], Some([0, 1, 2, 3, 4, 5, 6])),
            Pattern::Any => self.of::<MOST_SPACED, S>(simd, sets, None),
        }
    }
}

impl<const N: usize> Estimate<'_, N> {
    /// The work on inputs of so many sets, `L` at the most, where all are known to be on the same
    /// `steps` or not: numbers stay in registers where `L` is few.
    #[inline(always)]
    fn of<const L: usize, S: Simd>(
        self,
        simd: S,
        lengths: [usize; INPUTS],
        steps: Option<[u8; L]>,
    ) {
        let Self { it, stage, seen, lost } = self;
        let mixed = &it.mixes[stage.index];
        let (before, rest) = it.stages.split_at_mut(stage.index);
        let here = &mut rest[0];
        for part in 0..Register::<S>::PARTS {
            let mut missed = lost.load(simd, part);
            let mut inputs = [[missed; INPUTS]; N];
            let mut ratios = inputs;
            for (k, (signal, scale)) in it.inputs.signals().iter().enumerate() {
                let signal = signal.of(seen);
                for n in 0..N {
                    let x = signal[n].load(simd, part);
                    inputs[n][k] = x.like(*scale) * x;
                    let (exponent, beyond) = it.sets[n][k].exponent(inputs[n][k]);
                    missed += beyond;
                    ratios[n][k] = exponent;
                }
            }
            let (fours, rest) = ratios.as_flattened_mut().as_chunks_mut::<4>();
            for four in fours {
                *four = Real::series_exps(*four);
            }
            // Of an odd number of joints.
            if let [first, second] = rest {
                [*first, *second] = Real::series_exps([*first, *second]);
            }
            // Each waits for its own sum: all are begun before what is made of them.
            for n in 0..N {
                let ([first, second], [rows, columns]) = (&it.sets[n], lengths);
                let x = [(inputs[n][0], ratios[n][0]), (inputs[n][1], ratios[n][1])];
                let rules = match &steps {
                    Some(steps) => [
                        first.memberships::<L, _>(x[0], steps, it.normalized),
                        second.memberships::<L, _>(x[1], steps, it.normalized),
                    ],
                    None => [
                        first.memberships::<L, _>(x[0], first.steps(), it.normalized),
                        second.memberships::<L, _>(x[1], second.steps(), it.normalized),
                    ],
                };
                keep((simd, part), &rules[0], &mut here.memberships[n][0], rows);
                keep((simd, part), &rules[1], &mut here.memberships[n][1], columns);
            }
            let mut s = column([missed; N]);
            for n in 0..N {
                let (e, de) = (seen.e[n].load(simd, part), seen.de[n].load(simd, part));
                s[n] = it.p12[n].load(simd, part) * e + it.p22[n].load(simd, part) * de;
            }
            for n in 0..N {
                let [first, second] = &here.memberships[n];
                let rules = [kept::<S, L>((simd, part), first), kept((simd, part), second)];
                let mut learnt = contract((simd, part), &it.weights[n], &rules, lengths);
                if it.leaks {
                    learnt = mixed.keep.load(simd, part) * learnt;
                }
                for (j, (past, a)) in before.iter().zip(stage.coefficients).enumerate() {
                    if *a != 0.0 {
                        let gram = correlate((simd, part), &rules, &past.memberships[n], lengths);
                        let share = mixed.shares[j].load(simd, part);
                        learnt += past.drive[n].load(simd, part) * share * gram;
                    }
                }
                (learnt.like(0.0) + learnt).store(&mut it.estimate[n], part);
                let mut drive = it.gain[n].load(simd, part) * s[n];
                if let Some(weakens) = &it.weakens {
                    let [dead_zone, normalization] = weakens.load(simd, part);
                    let xi_squared = correlate((simd, part), &rules, &here.memberships[n], lengths);
                    let factor = weakened(dead_zone, normalization, size(&s), xi_squared);
                    drive = factor * it.gain[n].load(simd, part) * s[n];
                }
                let (most, zero) = (drive.like(MOST_DRIVE), drive.like(0.0));
                missed += most.if_less(drive.abs(), drive.like(f64::NAN), zero);
                drive.unless_tiny(TINY_TERM).store(&mut here.drive[n], part);
            }
            missed.store(lost, part);
        }
    }
}

/// The memberships of both inputs in registers.
type Rules<S, const L: usize> = [[Register<S>; L]; INPUTS];

/// Puts so many of them in their place.
#[inline(always)]
fn keep<S: Simd, const L: usize>(
    (_, part): (S, usize),
    from: &[Register<S>; L],
    to: &mut [Abreast; MOST_SPACED],
    sets: usize,
) {
    for set in 0..sets.min(L) {
        from[set].store(&mut to[set], part);
    }
}

/// The first of them from their place.
#[inline(always)]
fn kept<S: Simd, const L: usize>(
    (simd, part): (S, usize),
    from: &[Abreast; MOST_SPACED],
) -> [Register<S>; L] {
    let mut registers = [from[0].load(simd, part); L];
    for set in 1..L {
        registers[set] = from[set].load(simd, part);
    }
    registers
}

/// w·ξ, in the order of sums of one run: over lanes of rules first. A lane begins with its first
/// term, and not with 0: a zero may have another sign in between, but not at the end.
#[inline(always)]
fn contract<S: Simd, const L: usize>(
    (simd, part): (S, usize),
    weights: &[Abreast],
    [first, second]: &Rules<S, L>,
    [rows, columns]: [usize; INPUTS],
) -> Register<S> {
    let weights = &weights[..rows * columns];
    let mut lanes = [first[0].like(0.0); LANES];
    for a in 0..rows.min(L) {
        for b in 0..columns.min(L) {
            let rule = a * columns + b;
            let term = weights[rule].load(simd, part) * (first[a] * second[b]);
            lanes[rule % LANES] = if rule < LANES { term } else { lanes[rule % LANES] + term };
        }
    }
    let [a, b, c, d, e, f, g, h] = lanes;
    let total = ((a + e) + (c + g)) + ((b + f) + (d + h));
    total.unless_tiny(TINY_ESTIMATE)
}

/// ξ·ξ' of two stages.
#[inline(always)]
fn correlate<S: Simd, const L: usize>(
    at: (S, usize),
    [first, second]: &Rules<S, L>,
    [past_first, past_second]: &[[Abreast; MOST_SPACED]; INPUTS],
    [rows, columns]: [usize; INPUTS],
) -> Register<S> {
    let product = inner(at, first, past_first, rows).positive_unless_tiny(TINY_KERNEL);
    (product * inner(at, second, past_second, columns)).positive_unless_tiny(TINY_KERNEL)
}

#[inline(always)]
fn inner<S: Simd, const L: usize>(
    (simd, part): (S, usize),
    left: &[Register<S>; L],
    right: &[Abreast; MOST_SPACED],
    sets: usize,
) -> Register<S> {
    let mut sum = left[0] * right[0].load(simd, part);
    for set in 1..sets.min(L) {
        sum += left[set] * right[set].load(simd, part);
    }
    sum
}

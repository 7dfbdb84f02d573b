//! Compensators of eight runs side by side, a run a lane: a grid a joint over two inputs, as
//! [`step`](super::step) computes it of one run, with the same sums in the same order.
//!
//! The rules of a joint are products of two memberships, so the memberships of each stage are all
//! that is kept of it.

use core::array::from_fn;

use pulp::{Arch, Simd, WithSimd};

use crate::control::learns::PerJointSide;
use crate::control::{Inputs, Sample, Stage};
use crate::fuzzy::lanes::FLUSH_EVERY;
use crate::fuzzy::{MOST_SPACED, Spaced};
use crate::math::{
    Abreast, LANES, Load, Real, Register, TINY_ESTIMATE, TINY_KERNEL, TINY_TERM, TINY_WEIGHT,
    Vector, in_lanes, store,
};

/// Inputs of a joint.
const INPUTS: usize = 2;
/// Stages of the only method that runs side by side.
const STAGES: usize = 4;
/// What drives the weights beyond this is not ordinary: they might come to be refused.
const MOST_DRIVE: f64 = 1e100;

/// Compensators of eight runs with their states.
#[derive(Clone, Debug)]
pub(in crate::control) struct PerJoint<const N: usize> {
    inputs: Inputs,
    /// The sets of both inputs of each joint.
    sets: [[Spaced; INPUTS]; N],
    shape: Shape,
    normalized: bool,
    /// The last row and column of P, and the gain.
    p12: [Abreast; N],
    p22: [Abreast; N],
    gain: [Abreast; N],
    /// The weights of each joint, rule after rule.
    weights: [Vec<Abreast>; N],
    stages: [Recorded<N>; STAGES],
    /// ρ̂ of the latest stage.
    pub estimate: Vector<N, Abreast>,
    advances: u64,
}

/// How many sets the inputs of every joint have, and on which steps.
#[derive(Clone, Copy, Debug)]
struct Shape {
    sets: [usize; INPUTS],
    pattern: Pattern,
}

/// The steps of the sets of all inputs: those for which there is a kernel that knows them, or any.
#[derive(Clone, Copy, Debug)]
enum Pattern {
    Even3,
    Even5,
    /// Five, of which the outer ones are farther away.
    Paper,
    Even7,
    Any,
}

impl Pattern {
    fn of<const N: usize>(sets: &[[Spaced; INPUTS]; N]) -> Self {
        let steps = sets[0][0].steps();
        if sets.iter().flatten().any(|own| own.steps() != steps) {
            return Self::Any;
        }
        match steps {
            [0, 1, 2] => Self::Even3,
            [0, 1, 2, 3, 4] => Self::Even5,
            [0, 2, 3, 4, 6] => Self::Paper,
            [0, 1, 2, 3, 4, 5, 6] => Self::Even7,
            _ => Self::Any,
        }
    }
}

/// What is kept of a stage: the memberships of each input of each joint, and what drives the
/// weights.
#[derive(Clone, Debug)]
struct Recorded<const N: usize> {
    memberships: [[[Abreast; MOST_SPACED]; INPUTS]; N],
    drive: Vector<N, Abreast>,
}

impl<const N: usize> PerJoint<N> {
    /// These compensators; `None` if they are not on the same sets of the same inputs.
    pub fn of(each: [PerJointSide<'_, N>; LANES]) -> Option<Self> {
        let [first, ..] = each;
        let PerJointSide { inputs, sets, normalized, row, advances, .. } = first;
        let alike = each.iter().all(|it| {
            let clock = it.advances == advances;
            it.inputs == inputs && it.sets == sets && it.normalized == normalized && clock
        });
        let of = |numbers: fn(&PerJointSide<'_, N>) -> [f64; N]| {
            from_fn(|n| Abreast(each.each_ref().map(|it| numbers(it)[n])))
        };
        let lengths = sets[0].each_ref().map(Spaced::len);
        let alike = alike && sets.iter().all(|own| own.each_ref().map(Spaced::len) == lengths);
        let zeros = Vector::<N, Abreast>::repeat(Abreast::all(0.0));
        let memberships = [[[Abreast::all(0.0); MOST_SPACED]; INPUTS]; N];
        alike.then(|| Self {
            inputs,
            sets,
            shape: Shape { sets: lengths, pattern: Pattern::of(&sets) },
            normalized,
            p12: of(|it| it.p12),
            p22: of(|it| it.p22),
            gain: of(|it| it.gain),
            weights: from_fn(|n| {
                let own = |rule| Abreast(each.map(|it| it.weights[n * row + rule]));
                (0..lengths[0] * lengths[1]).map(own).collect()
            }),
            stages: from_fn(|_| Recorded { memberships, drive: zeros }),
            estimate: zeros,
            advances,
        })
    }

    /// ρ̂ at a stage, and what drives the weights there; an input out of reach is `lost`.
    #[inline(never)]
    pub fn estimate(
        &mut self,
        arch: Arch,
        stage: &Stage<'_>,
        seen: &Sample<N, Abreast>,
        lost: &mut Abreast,
    ) {
        in_lanes(arch, Estimate { it: self, stage, seen, lost });
    }

    /// Holds the weights of the runs whose torque was limited.
    #[inline(never)]
    pub fn acted(
        &mut self,
        arch: Arch,
        index: usize,
        asked: &Vector<N, Abreast>,
        applied: &Vector<N, Abreast>,
    ) {
        in_lanes(arch, Acted { drive: &mut self.stages[index].drive, asked, applied });
    }

    /// Moves the weights to the end of a step.
    #[inline(never)]
    pub fn advance(&mut self, arch: Arch, end: &Stage<'_>) {
        self.advances += 1;
        in_lanes(arch, Advance { it: self, end });
    }
}

struct Estimate<'a, const N: usize> {
    it: &'a mut PerJoint<N>,
    stage: &'a Stage<'a>,
    seen: &'a Sample<N, Abreast>,
    lost: &'a mut Abreast,
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
            for n in 0..N {
                let [first, second] = &here.memberships[n];
                let rules = [kept::<S, L>((simd, part), first), kept((simd, part), second)];
                let (e, de) = (seen.e[n].load(simd, part), seen.de[n].load(simd, part));
                let s = it.p12[n].load(simd, part) * e + it.p22[n].load(simd, part) * de;
                let mut learnt = contract((simd, part), &it.weights[n], &rules, lengths);
                for (past, a) in before.iter().zip(stage.coefficients) {
                    let factor = stage.step * a;
                    if factor != 0.0 {
                        let gram = correlate((simd, part), &rules, &past.memberships[n], lengths);
                        learnt += past.drive[n].load(simd, part) * s.like(factor) * gram;
                    }
                }
                (s.like(0.0) + learnt).store(&mut it.estimate[n], part);
                let drive = it.gain[n].load(simd, part) * s;
                missed += s.like(MOST_DRIVE).if_less(drive.abs(), s.like(f64::NAN), s.like(0.0));
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

struct Acted<'a, const N: usize> {
    drive: &'a mut Vector<N, Abreast>,
    asked: &'a Vector<N, Abreast>,
    applied: &'a Vector<N, Abreast>,
}

impl<const N: usize> WithSimd for Acted<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { drive, asked, applied } = self;
        for part in 0..Register::<S>::PARTS {
            let (asked, applied) = (asked.load(simd, part), applied.load(simd, part));
            let mut gap = asked[0].like(0.0);
            for n in 0..N {
                gap += (applied[n] - asked[n]).abs();
            }
            let mut held = drive.load(simd, part);
            for n in 0..N {
                held[n] = gap.like(0.0).if_less(gap, gap.like(0.0), held[n]);
            }
            store(&held, drive, part);
        }
    }
}

struct Advance<'a, const N: usize> {
    it: &'a mut PerJoint<N>,
    end: &'a Stage<'a>,
}

impl<const N: usize> WithSimd for Advance<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        match (self.it.shape.sets, self.end.index) {
            ([3, 3], STAGES) => self.of(simd, [3, 3], STAGES),
            ([5, 5], STAGES) => self.of(simd, [5, 5], STAGES),
            ([7, 7], STAGES) => self.of(simd, [7, 7], STAGES),
            (sets, stages) => self.of(simd, sets, stages.min(STAGES)),
        }
    }
}

impl<const N: usize> Advance<'_, N> {
    /// As [`Estimate::of`].
    #[inline(always)]
    fn of<S: Simd>(self, simd: S, [rows, columns]: [usize; INPUTS], stages: usize) {
        let Self { it, end } = self;
        let flushes = it.advances.is_multiple_of(FLUSH_EVERY);
        for n in 0..N {
            for part in 0..Register::<S>::PARTS {
                let mut terms = [it.gain[n].load(simd, part); STAGES];
                for (j, a) in end.coefficients.iter().enumerate().take(stages) {
                    let drive = it.stages[j].drive[n].load(simd, part);
                    terms[j] = (drive * drive.like(end.step * a)).unless_tiny(TINY_TERM);
                }
                for a in 0..rows {
                    let mut firsts = terms;
                    for (j, first) in firsts.iter_mut().enumerate().take(stages) {
                        *first = it.stages[j].memberships[n][0][a].load(simd, part);
                    }
                    for b in 0..columns {
                        let kept = &mut it.weights[n][a * columns + b];
                        let mut weight = kept.load(simd, part);
                        for j in 0..stages {
                            let second = it.stages[j].memberships[n][1][b].load(simd, part);
                            weight += terms[j] * (firsts[j] * second);
                        }
                        if flushes {
                            weight = weight.unless_tiny(TINY_WEIGHT);
                        }
                        weight.store(kept, part);
                    }
                }
            }
        }
    }
}

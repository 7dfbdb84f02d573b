//! Compensators of eight runs side by side, a run a lane: a grid a joint over two inputs, as
//! [`step`](super::step) computes it of one run, with the same sums in the same order.
//!
//! The rules of a joint are products of two memberships, so the memberships of each stage are all
//! that is kept of it.

use core::array::from_fn;

use pulp::{Arch, Simd, WithSimd};

use crate::control::learns::PerJointSide;
use crate::control::{Inputs, MAX_STAGES, Sample, Stage};
use crate::fuzzy::Spaced;
use crate::fuzzy::lanes::FLUSH_EVERY;
use crate::math::{
    Abreast, LANES, Load, Real, Register, TINY_ESTIMATE, TINY_KERNEL, TINY_TERM, TINY_WEIGHT,
    Vector, store,
};

/// Inputs of a joint.
const INPUTS: usize = 2;
/// Stages of the only method that runs side by side.
const STAGES: usize = 4;

/// Compensators of eight runs with their states.
#[derive(Clone, Debug)]
pub(in crate::control) struct PerJoint<const N: usize> {
    inputs: Inputs,
    /// The sets of both inputs of each joint.
    sets: [[Spaced; INPUTS]; N],
    normalized: bool,
    /// The last row and column of P, and the gain.
    p12: [Abreast; N],
    p22: [Abreast; N],
    gain: [Abreast; N],
    /// The weights of each joint, rule after rule, and zeros up to whole lanes of rules.
    weights: [Vec<Abreast>; N],
    /// ξ of a joint, likewise.
    xi: Vec<Abreast>,
    stages: [Recorded<N>; STAGES],
    /// ρ̂ of the latest stage.
    pub estimate: Vector<N, Abreast>,
    advances: u64,
}

/// What is kept of a stage: the memberships of each input of each joint, and what drives the
/// weights.
#[derive(Clone, Debug)]
struct Recorded<const N: usize> {
    memberships: [[[Abreast; Spaced::MOST]; INPUTS]; N],
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
        let rules = sets[0].iter().map(Spaced::len).product::<usize>();
        let zeros = Vector::<N, Abreast>::repeat(Abreast::all(0.0));
        let memberships = [[[Abreast::all(0.0); Spaced::MOST]; INPUTS]; N];
        let whole = vec![Abreast::all(0.0); rules.next_multiple_of(LANES)];
        alike.then(|| Self {
            inputs,
            sets,
            normalized,
            p12: of(|it| it.p12),
            p22: of(|it| it.p22),
            gain: of(|it| it.gain),
            weights: from_fn(|n| {
                let mut own = whole.clone();
                for (rule, weight) in own[..rules].iter_mut().enumerate() {
                    *weight = Abreast(each.map(|it| it.weights[n * row + rule]));
                }
                own
            }),
            xi: whole,
            stages: from_fn(|_| Recorded { memberships, drive: zeros }),
            estimate: zeros,
            advances,
        })
    }

    /// ρ̂ at a stage, and what drives the weights there; an input out of reach is `lost`.
    pub fn estimate(
        &mut self,
        arch: Arch,
        stage: &Stage<'_>,
        seen: &Sample<N, Abreast>,
        lost: &mut Abreast,
    ) {
        arch.dispatch(Estimate { it: self, stage, seen, lost });
    }

    /// Holds the weights of the runs whose torque was limited.
    pub fn acted(
        &mut self,
        arch: Arch,
        index: usize,
        asked: &Vector<N, Abreast>,
        applied: &Vector<N, Abreast>,
    ) {
        arch.dispatch(Acted { drive: &mut self.stages[index].drive, asked, applied });
    }

    /// Moves the weights to the end of a step.
    pub fn advance(&mut self, arch: Arch, end: &Stage<'_>) {
        self.advances += 1;
        arch.dispatch(Advance { it: self, end });
    }
}

/// The factors of the drives of earlier stages in a sum, h aⱼ.
fn factors(stage: &Stage<'_>) -> [f64; MAX_STAGES] {
    from_fn(|j| stage.coefficients.get(j).map_or(0.0, |a| stage.step * a))
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
        let Self { it, stage, seen, lost } = self;
        let (i, factors) = (stage.index, factors(stage));
        let (before, rest) = it.stages.split_at_mut(i);
        let here = &mut rest[0];
        for part in 0..Register::<S>::PARTS {
            let mut missed = lost.load(simd, part);
            for n in 0..N {
                for (k, (signal, scale)) in it.inputs.signals().iter().enumerate() {
                    let x = signal.of(seen)[n].load(simd, part);
                    let x = x.like(*scale) * x;
                    let sets = &it.sets[n][k];
                    missed += sets.beyond(x);
                    let out = &mut here.memberships[n][k];
                    sets.memberships((simd, part), x, it.normalized, out);
                }
                let (e, de) = (seen.e[n].load(simd, part), seen.de[n].load(simd, part));
                let s = it.p12[n].load(simd, part) * e + it.p22[n].load(simd, part) * de;
                let [first, second] = &here.memberships[n];
                let lengths = [it.sets[n][0].len(), it.sets[n][1].len()];
                let rules = (&first[..lengths[0]], &second[..lengths[1]]);
                multiply((simd, part), rules, &mut it.xi);
                let mut learnt = contract((simd, part), &it.weights[n], &it.xi, s);
                for (j, past) in before.iter().enumerate() {
                    if factors[j] != 0.0 {
                        let [first, second] = &past.memberships[n];
                        let past_rules = (&first[..lengths[0]], &second[..lengths[1]]);
                        let gram = correlate((simd, part), rules, past_rules, s);
                        learnt += past.drive[n].load(simd, part) * s.like(factors[j]) * gram;
                    }
                }
                (s.like(0.0) + learnt).store(&mut it.estimate[n], part);
                let drive = it.gain[n].load(simd, part) * s;
                drive.unless_tiny(TINY_TERM).store(&mut here.drive[n], part);
            }
            missed.store(lost, part);
        }
    }
}

/// The memberships of both inputs.
type Rules<'a> = (&'a [Abreast], &'a [Abreast]);

/// ξ from the memberships.
#[inline(always)]
fn multiply<S: Simd>((simd, part): (S, usize), (first, second): Rules<'_>, xi: &mut [Abreast]) {
    for (row, p) in xi.chunks_exact_mut(second.len()).zip(first) {
        let p = p.load(simd, part);
        for (xi, q) in row.iter_mut().zip(second) {
            (p * q.load(simd, part)).store(xi, part);
        }
    }
}

/// w·ξ, in the order of sums of one run: over lanes of rules first.
#[inline(always)]
fn contract<S: Simd>(
    (simd, part): (S, usize),
    weights: &[Abreast],
    xi: &[Abreast],
    like: Register<S>,
) -> Register<S> {
    let mut lanes = [like.like(0.0); LANES];
    for (w, xi) in weights.as_chunks::<LANES>().0.iter().zip(xi.as_chunks::<LANES>().0) {
        for lane in 0..LANES {
            lanes[lane] += w[lane].load(simd, part) * xi[lane].load(simd, part);
        }
    }
    let [a, b, c, d, e, f, g, h] = lanes;
    let total = ((a + e) + (c + g)) + ((b + f) + (d + h));
    total.unless_tiny(TINY_ESTIMATE)
}

/// ξ·ξ' of two stages.
#[inline(always)]
fn correlate<S: Simd>(
    at: (S, usize),
    (first, second): Rules<'_>,
    (past_first, past_second): Rules<'_>,
    like: Register<S>,
) -> Register<S> {
    let product = inner(at, first, past_first, like).unless_tiny(TINY_KERNEL);
    (product * inner(at, second, past_second, like)).unless_tiny(TINY_KERNEL)
}

#[inline(always)]
fn inner<S: Simd>(
    (simd, part): (S, usize),
    left: &[Abreast],
    right: &[Abreast],
    like: Register<S>,
) -> Register<S> {
    let mut sum = like.like(0.0);
    for (x, y) in left.iter().zip(right) {
        sum += x.load(simd, part) * y.load(simd, part);
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
        let Self { it, end } = self;
        let (factors, flushes) = (factors(end), it.advances.is_multiple_of(FLUSH_EVERY));
        for n in 0..N {
            let lengths = [it.sets[n][0].len(), it.sets[n][1].len()];
            for part in 0..Register::<S>::PARTS {
                let mut terms = [it.gain[n].load(simd, part); STAGES];
                for (j, term) in terms.iter_mut().enumerate() {
                    let drive = it.stages[j].drive[n].load(simd, part);
                    *term = (drive * drive.like(factors[j])).unless_tiny(TINY_TERM);
                }
                for a in 0..lengths[0] {
                    let mut firsts = terms;
                    for (j, first) in firsts.iter_mut().enumerate() {
                        *first = it.stages[j].memberships[n][0][a].load(simd, part);
                    }
                    for b in 0..lengths[1] {
                        let kept = &mut it.weights[n][a * lengths[1] + b];
                        let mut weight = kept.load(simd, part);
                        for j in 0..STAGES {
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

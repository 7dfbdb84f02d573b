//! What follows a stage, and ends a step, of eight compensators side by side.

use pulp::{Simd, WithSimd};

use super::per_joint::{INPUTS, Mixed, PerJoint};
use crate::control::Stage;
use crate::control::limits::unless_limited;
use crate::control::stages::STAGES;
use crate::fuzzy::lanes::FLUSH_EVERY;
use crate::math::{Abreast, Load, Real, Register, TINY_TERM, TINY_WEIGHT, Vector, store};

pub(super) struct Acted<'a, const N: usize> {
    pub drive: &'a mut Vector<N, Abreast>,
    pub asked: &'a Vector<N, Abreast>,
    pub applied: &'a Vector<N, Abreast>,
}

impl<const N: usize> WithSimd for Acted<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { drive, asked, applied } = self;
        for part in 0..Register::<S>::PARTS {
            let (asked, applied) = (asked.load(simd, part), applied.load(simd, part));
            let held = unless_limited(drive.load(simd, part), &asked, &applied);
            store(&held, drive, part);
        }
    }
}

pub(super) struct Advance<'a, const N: usize> {
    pub it: &'a mut PerJoint<N>,
    pub end: &'a Stage<'a>,
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
        let (flushes, leaks) = (it.advances.is_multiple_of(FLUSH_EVERY), it.leaks);
        let Mixed { keep, least, shares, .. } = &it.mixes[end.index];
        for n in 0..N {
            for part in 0..Register::<S>::PARTS {
                let mut terms = [it.gain[n].load(simd, part); STAGES];
                for j in 0..stages {
                    let drive = it.stages[j].drive[n].load(simd, part);
                    terms[j] = (drive * shares[j].load(simd, part)).unless_tiny(TINY_TERM);
                }
                let (keep, least) = (keep.load(simd, part), least.load(simd, part));
                for a in 0..rows {
                    let mut firsts = terms;
                    for (j, first) in firsts.iter_mut().enumerate().take(stages) {
                        *first = it.stages[j].memberships[n][0][a].load(simd, part);
                    }
                    for b in 0..columns {
                        let kept = &mut it.weights[n][a * columns + b];
                        let mut weight = kept.load(simd, part);
                        if leaks {
                            weight = keep * weight;
                            weight = weight.abs().if_less(least, weight.like(0.0), weight);
                        }
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

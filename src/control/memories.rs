//! Memories of a number a joint, of eight runs side by side, as [`dynamic`](super::dynamic) moves
//! them of one run: the integral of the error, and observers of what pushes the arm.

use core::array::from_fn;

use pulp::{Arch, Simd, WithSimd};

use super::learns::{MemorySide, Mover, missed, pushed};
use super::limits::unless_limited;
use super::stages::STAGES;
use super::{Sample, Stage};
use crate::arm::{Factor, ModelsAbreast};
use crate::math::{
    Abreast, LANES, Load, Real, Register, Vector, in_lanes, none_missing, product, store,
};

/// Memories of eight runs, and what moves them.
#[derive(Clone, Debug)]
pub(super) struct Memories<const N: usize> {
    /// K_I of the integrals, Y or poles of the observers.
    gain: [Abreast; N],
    law: Law<N>,
    /// Whether there is a z after the last step, and that.
    begun: bool,
    z: Vector<N, Abreast>,
    /// z at the start of the current step, and at the stage that was estimated last, with e, or q̇
    /// for observers.
    start: Vector<N, Abreast>,
    at: Vector<N, Abreast>,
    seen: Vector<N, Abreast>,
    rates: [Vector<N, Abreast>; STAGES],
    /// ρ̂ of the latest stage.
    pub estimate: Vector<N, Abreast>,
}

/// What moves them, and what observers believe of their arms.
#[derive(Clone, Debug)]
enum Law<const N: usize> {
    Integral,
    Acceleration(Box<ModelsAbreast<N>>),
    Momentum(Box<ModelsAbreast<N>>),
}

impl<const N: usize> Memories<N> {
    /// These; `None` if they are not moved alike, or not all have begun.
    pub fn of(each: [MemorySide<'_, N>; LANES]) -> Option<Self> {
        let begun = each[0].z.is_some();
        if each.iter().any(|it| it.z.is_some() != begun) {
            return None;
        }
        let arms = each.map(|it| match (it.moved.by, each[0].moved.by) {
            (Mover::Acceleration(arm), Mover::Acceleration(_))
            | (Mover::Momentum(arm), Mover::Momentum(_)) => Some(arm),
            _ => None,
        });
        let models = || none_missing(arms).and_then(ModelsAbreast::of).map(Box::new);
        let law = match each[0].moved.by {
            Mover::Acceleration(_) => Law::Acceleration(models()?),
            Mover::Momentum(_) => Law::Momentum(models()?),
            Mover::Error if each.iter().all(|it| matches!(it.moved.by, Mover::Error)) => {
                Law::Integral
            }
            Mover::Error => return None,
        };
        let zeros = Vector::<N, Abreast>::repeat(Abreast::all(0.0));
        let mut z = zeros;
        for n in 0..N {
            z[n] = Abreast(each.map(|it| it.z.map_or(0.0, |z| z[n])));
        }
        Some(Self {
            gain: from_fn(|n| Abreast(each.map(|it| it.moved.gain[n]))),
            law,
            begun,
            z,
            start: zeros,
            at: zeros,
            seen: zeros,
            rates: [zeros; STAGES],
            estimate: zeros,
        })
    }

    /// ρ̂ at a stage.
    pub fn estimate(&mut self, arch: Arch, stage: &Stage<'_>, seen: &Sample<N, Abreast>) {
        let motion = (&seen.q, &seen.dq);
        match &mut self.law {
            Law::Integral => {}
            Law::Acceleration(models) => models.find(arch, motion),
            Law::Momentum(models) => models.find_momentum(arch, motion),
        }
        self.seen = if matches!(self.law, Law::Integral) { seen.e } else { seen.dq };
        if stage.index == 0 {
            self.start = self.z;
        }
        let first = stage.index == 0 && !self.begun;
        in_lanes(arch, Estimate { it: &mut *self, stage, first });
        if first {
            self.start = self.at;
        }
    }

    /// The rates at a stage under what was asked for and what acts.
    pub fn acted(
        &mut self,
        arch: Arch,
        index: usize,
        asked: &Vector<N, Abreast>,
        applied: &Vector<N, Abreast>,
    ) {
        in_lanes(arch, Rate { it: self, index, asked, applied });
    }

    /// Moves them to the end of a step; one that is not finite is `lost`.
    pub fn advance(&mut self, arch: Arch, end: &Stage<'_>, lost: &mut Abreast) {
        self.begun = true;
        in_lanes(arch, Advance { it: self, end, lost });
    }

    /// z₀ + h Σ aⱼ żⱼ.
    #[inline(always)]
    fn moved<S: Simd>(
        &self,
        (simd, part): (S, usize),
        stage: &Stage<'_>,
    ) -> Vector<N, Register<S>> {
        let mut z = self.start.load(simd, part);
        for n in 0..N {
            let mut sum = z[n].like(0.0);
            for (a, rate) in stage.coefficients.iter().zip(&self.rates) {
                if *a != 0.0 {
                    sum += rate[n].load(simd, part) * sum.like(*a);
                }
            }
            z[n] += sum * sum.like(stage.step);
        }
        z
    }
}

struct Estimate<'a, const N: usize> {
    it: &'a mut Memories<N>,
    stage: &'a Stage<'a>,
    /// Whether z is what lets an observer begin with nothing.
    first: bool,
}

impl<const N: usize> WithSimd for Estimate<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { it, stage, first } = self;
        for part in 0..Register::<S>::PARTS {
            let (gain, seen) = (it.gain.load(simd, part), it.seen.load(simd, part));
            let mut z = it.moved((simd, part), stage);
            let mut rho_hat = z;
            match &it.law {
                Law::Integral => {
                    for n in 0..N {
                        rho_hat[n] = gain[n] * z[n];
                    }
                }
                Law::Acceleration(models) => {
                    for n in 0..N {
                        z[n] = if first { gain[n] * seen[n] } else { z[n] };
                    }
                    let mass = models.mass.load(simd, part);
                    rho_hat = minus(Factor::of(&mass).solve(&pushed(&z, &gain, &seen)));
                }
                Law::Momentum(models) => {
                    let mass = models.mass.load(simd, part);
                    let momentum = product(&mass, &seen);
                    z = if first { momentum } else { z };
                    rho_hat = minus(Factor::of(&mass).solve(&missed(&z, &momentum, gain[0])));
                }
            }
            store(&z, &mut it.at, part);
            store(&rho_hat, &mut it.estimate, part);
        }
    }
}

struct Rate<'a, const N: usize> {
    it: &'a mut Memories<N>,
    index: usize,
    asked: &'a Vector<N, Abreast>,
    applied: &'a Vector<N, Abreast>,
}

impl<const N: usize> WithSimd for Rate<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { it, index, asked, applied } = self;
        for part in 0..Register::<S>::PARTS {
            let (gain, seen) = (it.gain.load(simd, part), it.seen.load(simd, part));
            let (z, applied) = (it.at.load(simd, part), applied.load(simd, part));
            let mut rate = seen;
            match &it.law {
                Law::Integral => {
                    rate = unless_limited(seen, &asked.load(simd, part), &applied);
                }
                Law::Acceleration(models) => {
                    let (d, bias) = (pushed(&z, &gain, &seen), models.bias.load(simd, part));
                    for n in 0..N {
                        rate[n] = (applied[n] - d[n]) - bias[n];
                    }
                    let mass = models.mass.load(simd, part);
                    let solved = Factor::of(&mass).solve(&rate);
                    for n in 0..N {
                        rate[n] = gain[n] * solved[n];
                    }
                }
                Law::Momentum(models) => {
                    let mass = models.mass.load(simd, part);
                    let residual = missed(&z, &product(&mass, &seen), gain[0]);
                    for n in 0..N {
                        let carried = models.carried[n].load(simd, part);
                        let held = models.bias[n].load(simd, part);
                        rate[n] = ((applied[n] + carried) - held) - residual[n];
                    }
                }
            }
            store(&rate, &mut it.rates[index], part);
        }
    }
}

struct Advance<'a, const N: usize> {
    it: &'a mut Memories<N>,
    end: &'a Stage<'a>,
    lost: &'a mut Abreast,
}

impl<const N: usize> WithSimd for Advance<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { it, end, lost } = self;
        for part in 0..Register::<S>::PARTS {
            let z = it.moved((simd, part), end);
            let mut infinite = lost.load(simd, part);
            for n in 0..N {
                infinite += z[n] * infinite.like(0.0);
            }
            store(&z, &mut it.z, part);
            infinite.store(lost, part);
        }
    }
}

/// −x.
#[inline(always)]
fn minus<const N: usize, S: Simd>(mut x: Vector<N, Register<S>>) -> Vector<N, Register<S>> {
    for n in 0..N {
        x[n] = -x[n];
    }
    x
}

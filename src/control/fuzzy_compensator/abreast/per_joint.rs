//! Compensators of eight runs side by side, with their states, and what stages keep.

use core::array::from_fn;

use crate::control::adaptation::left;
use crate::control::learns::PerJointSide;
use crate::control::stages::STAGES;
use crate::control::{Inputs, Stage};
use crate::fuzzy::lanes::FADES_FAST;
use crate::fuzzy::{MOST_SPACED, Spaced};
use crate::math::{Abreast, LANES, TINY_WEIGHT, Vector};

/// Inputs of a joint.
pub const INPUTS: usize = 2;

/// Compensators of eight runs with their states.
#[derive(Clone, Debug)]
pub struct PerJoint<const N: usize> {
    pub inputs: Inputs,
    /// The sets of both inputs of each joint.
    pub sets: [[Spaced; INPUTS]; N],
    pub shape: Shape,
    pub normalized: bool,
    /// The last row and column of P, and the gain.
    pub p12: [Abreast; N],
    pub p22: [Abreast; N],
    pub gain: [Abreast; N],
    /// The rates of the leaks, and whether there are any.
    pub leak_rate: Abreast,
    pub leaks: bool,
    /// Dead zone and normalisation, where there are any.
    pub weakens: Option<[Abreast; 2]>,
    /// What each stage, and the end of a step, makes of the step so far.
    pub mixes: [Mixed; STAGES + 1],
    /// The weights of each joint, rule after rule.
    pub weights: [Vec<Abreast>; N],
    pub stages: [Recorded<N>; STAGES],
    /// ρ̂ of the latest stage.
    pub estimate: Vector<N, Abreast>,
    pub advances: u64,
}

/// How many sets the inputs of every joint have, and on which steps.
#[derive(Clone, Copy, Debug)]
pub struct Shape {
    pub sets: [usize; INPUTS],
    pub pattern: Pattern,
}

/// The steps of the sets of all inputs: those for which there is a kernel that knows them, or any.
#[derive(Clone, Copy, Debug)]
pub enum Pattern {
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
pub struct Recorded<const N: usize> {
    pub memberships: [[[Abreast; MOST_SPACED]; INPUTS]; N],
    pub drive: Vector<N, Abreast>,
}

/// What a stage makes of the step so far: `keep` of the weights that were there, and of each rate
/// before it a share, h aⱼ and what a leak left of it.
#[derive(Clone, Copy, Debug)]
pub struct Mixed {
    /// The step that this is for.
    pub step: f64,
    pub keep: Abreast,
    /// Smaller weights are zero, where a leak is fast.
    pub least: Abreast,
    pub shares: [Abreast; STAGES],
}

impl Mixed {
    /// For no step at all.
    fn nothing() -> Self {
        let zero = Abreast::all(0.0);
        Self { step: f64::NAN, keep: zero, least: zero, shares: [zero; STAGES] }
    }

    fn of(stage: &Stage<'_>, leak_rate: &Abreast) -> Self {
        let keep = Abreast(leak_rate.0.map(|rate| left(rate, stage, 0.0)));
        let least = Abreast(keep.0.map(|keep| if keep < FADES_FAST { TINY_WEIGHT } else { 0.0 }));
        let mut shares = [Abreast::all(0.0); STAGES];
        for (share, (a, node)) in shares.iter_mut().zip(stage.coefficients.iter().zip(stage.nodes))
        {
            *share = Abreast(leak_rate.0.map(|rate| stage.step * a * left(rate, stage, *node)));
        }
        Self { step: stage.step, keep, least, shares }
    }
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
        let one = |number: fn(&PerJointSide<'_, N>) -> f64| Abreast(each.each_ref().map(number));
        let of = |numbers: fn(&PerJointSide<'_, N>) -> [f64; N]| {
            from_fn(|n| Abreast(each.each_ref().map(|it| numbers(it)[n])))
        };
        let (leak_rate, dead_zone) = (one(|it| it.leak_rate), one(|it| it.dead_zone));
        let weakens = [dead_zone, one(|it| it.normalization)];
        let none = Abreast::all(0.0);
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
            leak_rate,
            leaks: leak_rate != none,
            weakens: Some(weakens).filter(|weakens| *weakens != [none; 2]),
            mixes: [Mixed::nothing(); STAGES + 1],
            weights: from_fn(|n| {
                let own = |rule| Abreast(each.map(|it| it.weights[n * row + rule]));
                (0..lengths[0] * lengths[1]).map(own).collect()
            }),
            stages: from_fn(|_| Recorded { memberships, drive: zeros }),
            estimate: zeros,
            advances,
        })
    }

    /// Finds what a stage makes of the step so far, unless it is known: steps are alike.
    pub fn mix(&mut self, stage: &Stage<'_>) {
        let mixed = &mut self.mixes[stage.index];
        if mixed.step != stage.step {
            *mixed = Mixed::of(stage, &self.leak_rate);
        }
    }
}

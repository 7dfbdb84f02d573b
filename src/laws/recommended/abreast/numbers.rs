//! What eight recommended controllers know and remember.

use std::vec::Vec;

use crate::arm::ModelsAbreast;
use crate::control::{Beliefs, MAX_DELAY, OwnSide};
use crate::fuzzy::Memory;
use crate::laws::recommended::features::{Residual, Shape};
use crate::laws::recommended::gains::LearningGains;
use crate::laws::recommended::learning::{FRICTION_CUT_OFF, Turns, filter};
use crate::laws::recommended::memory::{Decided, Filtered, Now};
use crate::laws::recommended::pull::Pull;
use crate::laws::recommended::regression::Regression;
use crate::math::{Abreast, LANES, Vector, none_missing};

/// Eight recommended controllers side by side.
#[derive(Debug)]
pub(crate) struct LearnedAbreast<const N: usize> {
    pub pull: Pull<N, Abreast>,
    pub gains: [LearningGains<N>; LANES],
    pub shape: Shape<N>,
    pub turns: Turns,
    /// Periods that ended.
    pub periods: u64,
    /// M₀ and H₀ of the desired motion, and D there.
    pub arm: ModelsAbreast<N>,
    pub weight: ModelsAbreast<N>,
    pub shares: Shares<N>,
    /// θ, LP[Φ] in two parts, and the columns of the last samples in turn, as in the memory of one.
    pub theta: Vec<Abreast>,
    pub inertial: Vec<Abreast>,
    pub own: Vec<Abreast>,
    pub columns: Vec<Abreast>,
    /// The bases of the residuals, if there are any, with room for a sample's columns of one.
    pub residuals: Option<[Residual; LANES]>,
    pub room: [Vec<f64>; 2],
    pub learnt: [Learnt; LANES],
    pub filtered: Filtered<N, Abreast>,
    pub decided: [Decided<N, Abreast>; MAX_DELAY + 1],
    pub now: Now<N, Abreast>,
    pub momentum: Vector<N, Abreast>,
    /// The velocity on which friction is learnt, and what is known of friction there and at the
    /// desired one.
    pub moving: Vector<N, Abreast>,
    pub rubbed: [Vector<N, Abreast>; 2],
    pub wanted: Vector<N, Abreast>,
}

/// Shares that filters take of new values in a period of this length \[s\].
#[derive(Debug)]
pub(super) struct Shares<const N: usize> {
    pub dt: f64,
    pub velocity: [Abreast; N],
    pub slow: Abreast,
    pub learning: Abreast,
    pub acceleration: Abreast,
}

/// θ, P, room for Pφᵀ, and the diagonal of P₀ of one run; and room for a row.
#[derive(Debug)]
pub(super) struct Learnt {
    pub memory: Memory<Vec<f64>>,
    pub prior: Vec<f64>,
    pub row: Vec<f64>,
}

impl<const N: usize> LearnedAbreast<N> {
    /// These laws with what learns; `None` where they cannot be put side by side.
    pub fn of(laws: [Beliefs<'_, N>; LANES], each: [OwnSide<'_, N>; LANES]) -> Option<Self> {
        let zero = Abreast::all(0.0);
        let zeros = Vector::<N, Abreast>::repeat(zero);
        let pulls = none_missing(laws.map(|law| law.numbers.downcast_ref::<Pull<N>>()))?;
        let gains = each.map(|side| side.beliefs.numbers.downcast_ref::<LearningGains<N>>());
        let gains = none_missing(gains)?;
        let shapes = none_missing(each.map(|side| side.shape.downcast_ref::<Shape<N>>()))?;
        let arms = each.map(|side| side.beliefs.arms);
        let alike = (0..LANES).all(|i| {
            *pulls[i] == gains[i].pull
                && laws[i].arms == arms[i]
                && shapes[i].counts_as(shapes[0])
                && shapes[i].work() == shapes[0].work()
                && gains[i].delay == gains[0].delay
                && gains[i].control_period == gains[0].control_period
                && arms[i][0].is_named_as(&arms[0][0])
        });
        if !alike {
            return None;
        }
        let shape = shapes[0].clone();
        let (own, columns) = (N * shape.own(), shape.columns());
        let learnt = core::array::from_fn(|i| Learnt::of(&each[i], shapes[i]));
        let theta = &each.map(|side| side.known[0]);
        Some(Self {
            pull: Pull {
                bandwidth: core::array::from_fn(|n| Abreast::of(pulls, |it| it.bandwidth[n])),
                braking: core::array::from_fn(|n| Abreast::of(pulls, |it| it.braking[n])),
            },
            gains: gains.map(|gains| *gains),
            turns: Turns::new(N, gains[0].control_period),
            periods: 0,
            arm: ModelsAbreast::of(arms.map(|[arm, _]| arm))?,
            weight: ModelsAbreast::of(arms.map(|[_, weight]| weight))?,
            shares: Shares::of(gains, 0.0),
            theta: (0..shape.parameters()).map(|k| Abreast(theta.map(|it| it[k]))).collect(),
            inertial: std::vec![zero; N * shape.inertial()],
            own: std::vec![zero; own],
            columns: std::vec![zero; (gains[0].delay + 1) * columns],
            residuals: none_missing(shapes.map(|shape| shape.residual.as_ref()))
                .map(|each| each.map(Residual::clone)),
            room: [std::vec![0.0; shape.places().len()], std::vec![0.0; shape.work()]],
            learnt,
            filtered: Filtered::of(zero),
            decided: [Decided::nothing(zero); MAX_DELAY + 1],
            now: Now::of(zero),
            momentum: zeros,
            moving: zeros,
            rubbed: [zeros; 2],
            wanted: zeros,
            shape,
        })
    }
}

impl<const N: usize> Shares<N> {
    pub fn of(gains: [&LearningGains<N>; LANES], dt: f64) -> Self {
        Self {
            dt,
            velocity: core::array::from_fn(|n| Abreast::of(gains, |it| filter(it.cut_off[n], dt))),
            slow: Abreast::all(filter(FRICTION_CUT_OFF, dt)),
            learning: Abreast::of(gains, |it| filter(it.learning, dt)),
            acceleration: Abreast::of(gains, |it| it.acceleration_share),
        }
    }
}

impl Learnt {
    fn of<const N: usize>(side: &OwnSide<'_, N>, shape: &Shape<N>) -> Self {
        let [theta, p, inertial] = side.known;
        let mut memory = Memory::on_heap((shape.parameters() + 2) * shape.stride());
        let own = regression(&mut memory, shape);
        own.theta[..theta.len()].copy_from_slice(theta);
        own.p.copy_from_slice(p);
        Self { memory, prior: shape.prior(inertial).collect(), row: Vec::new() }
    }
}

/// The parts of such a memory.
pub(super) fn regression<'a, const N: usize>(
    memory: &'a mut Memory<Vec<f64>>,
    shape: &Shape<N>,
) -> Regression<'a> {
    let (theta, rest) = memory.as_mut_slice().split_at_mut(shape.stride());
    let (p, gain) = rest.split_at_mut(shape.parameters() * shape.stride());
    Regression { theta, p, gain }
}

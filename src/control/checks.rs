//! What a sampled controller refuses of a sample, and what it does not feel.

use super::state::IMPOSSIBLE;
use crate::error::{Result, finite, within};
use crate::math::{TINY_SIGNAL, Vector, unless_tiny};
use crate::reference::Setpoint;

/// Positions beyond this are refused: sine and cosine of such angles have few right digits left,
/// and take many times as long.
pub(crate) const FARTHEST: f64 = 1e5;

/// Periods of a sampled controller \[s\].
const SHORTEST_PERIOD: f64 = 1e-9;
const LONGEST_PERIOD: f64 = 1.0;

/// A signal whose entries are zero where they are too small to mean anything.
#[inline(always)]
pub(super) fn felt<const N: usize>(signal: &Vector<N>) -> Vector<N> {
    signal.map(|x| unless_tiny(x, TINY_SIGNAL))
}

#[inline(always)]
pub(super) fn desired_felt<const N: usize>(desired: &Setpoint<N>) -> Setpoint<N> {
    let Setpoint { q, dq, ddq } = desired;
    Setpoint { q: felt(q), dq: felt(dq), ddq: felt(ddq) }
}

/// Refuses periods that are too short or too long for a sampled controller.
pub(crate) fn check_period(parameter: &'static str, period: f64) -> Result<()> {
    let possible = |dt: f64| (SHORTEST_PERIOD..=LONGEST_PERIOD).contains(&dt);
    within(parameter, &[period], possible, "a period between 1e-9 and 1 s")
}

pub(super) fn check_applied<const N: usize>(applied: Option<&Vector<N>>) -> Result<()> {
    applied.map_or(Ok(()), |tau| finite("applied", tau.as_slice()))
}

pub(super) fn check_sample<const N: usize>(
    q: &Vector<N>,
    dq: &Vector<N>,
    desired: &Setpoint<N>,
) -> Result<()> {
    check_motion(["q", "dq"], q, dq)?;
    check_setpoint(desired)
}

/// Refuses positions and velocities that no arm can have.
pub(super) fn check_motion<const N: usize>(
    [position, velocity]: [&'static str; 2],
    q: &Vector<N>,
    dq: &Vector<N>,
) -> Result<()> {
    within(position, q.as_slice(), |x| x.abs() <= FARTHEST, NEAR)?;
    within(velocity, dq.as_slice(), possible, POSSIBLE)
}

pub(super) fn check_setpoint<const N: usize>(desired: &Setpoint<N>) -> Result<()> {
    check_motion(["q_d", "dq_d"], &desired.q, &desired.dq)?;
    within("ddq_d", desired.ddq.as_slice(), possible, POSSIBLE)
}

fn possible(x: f64) -> bool {
    x.abs() <= IMPOSSIBLE
}

/// What is wanted of a position, and of a velocity or an acceleration.
pub(super) const NEAR: &str =
    "a value an arm can have (at most 1e5 rad or m); take whole turns away";
pub(super) const POSSIBLE: &str = "a value an arm can have (at most 1e10)";

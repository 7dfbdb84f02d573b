//! Error-controlled steps of Dormand-Prince.

use super::integrators::{DP54, DP54_ERROR, Motion, Rates, Tolerance};
use crate::control::Stage;
use crate::math::{Vector, exp, ln};

/// Safety factor of the step size, and bounds of its change from one step to the next.
const SAFETY: f64 = 0.9;
const MIN_FACTOR: f64 = 0.2;
const MAX_FACTOR: f64 = 5.0;

/// A step shorter than this fraction of the time no longer advances it.
const SHORTEST_STEP: f64 = 1e-13;

/// A step that met the tolerance.
pub(super) struct Accepted<const N: usize> {
    /// Where it led.
    pub motion: Motion<N>,
    /// Its length [s].
    pub h: f64,
    /// Its end [s].
    pub end: f64,
    /// The length to try next [s].
    pub next_h: f64,
}

/// Tries steps from `t`, first of length `h`, none beyond `end`, until one meets the tolerance; `None` if none does.
///
/// Stage 0 is already in `rates`; `acceleration` is told the stage, its time and the motion there.
#[inline]
pub(super) fn attempt<const N: usize>(
    (t, mut h, end): (f64, f64, f64),
    start: &Motion<N>,
    rates: &mut Rates<N, 7>,
    tolerance: Tolerance,
    mut acceleration: impl FnMut(&Stage<'_>, f64, &Motion<N>) -> Vector<N>,
) -> Option<Accepted<N>> {
    while h > SHORTEST_STEP * t.max(1.0) {
        let last = t + h >= end;
        let (step, end) = if last { (end - t, end) } else { (h, t + h) };
        DP54.stages(step, start, 1, rates, |stage, at| {
            let time = if stage.node == 1.0 { end } else { t + stage.node * step };
            acceleration(stage, time, at)
        });
        let motion = start.plus(step, &DP54.weights, rates);
        let error = Motion::error(step, &DP54_ERROR, rates, [start, &motion], tolerance);
        let factor = (SAFETY * exp(-0.2 * ln(error))).clamp(MIN_FACTOR, MAX_FACTOR);
        if error <= 1.0 {
            return Some(Accepted { motion, h: step, end, next_h: h.max(step) * factor });
        }
        h = step * if error.is_finite() { factor } else { MIN_FACTOR };
    }
    None
}

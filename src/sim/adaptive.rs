//! Steps under error control: Dormand-Prince's, and those in which friction is solved for.

use super::doubt::Coarse;
use super::integrators::{DP54, DP54_ERROR, Motion, Rates, Tolerance};
use super::stiff::Moved;
use crate::control::Stage;
use crate::math::{Vector, exp, ln};

/// Safety factor of the step size, and the largest factor by which it falls.
const SAFETY: f64 = 0.9;
const MIN_FACTOR: f64 = 0.2;

/// A step shorter than this fraction of the time no longer advances it.
const SHORTEST_STEP: f64 = 1e-13;

/// How the next step size follows from an error: the power of the error, and the largest factor by
/// which the step grows.
struct Growth {
    power: f64,
    max_factor: f64,
}

const DORMAND_PRINCE: Growth = Growth { power: -0.2, max_factor: 5.0 };
const STIFF: Growth = Growth { power: -1.0 / 3.0, max_factor: 3.0 };

/// A step that met the tolerance.
pub(super) struct Accepted<const N: usize> {
    /// Where it led.
    pub motion: Motion<N>,
    /// Its length \[s\].
    pub h: f64,
    /// Its end \[s\].
    pub end: f64,
    /// The length to try next \[s\].
    pub next_h: f64,
}

/// Tries steps of Dormand-Prince from `t` until one meets the tolerance. The first has the length
/// `h`, and none goes beyond `end`. `None` if no step meets it.
///
/// Stage 0 is already in `rates`; `acceleration` is told the stage, its time and the motion there.
#[inline]
pub(super) fn attempt<const N: usize>(
    (t, h, end): (f64, f64, f64),
    start: &Motion<N>,
    rates: &mut Rates<N, 7>,
    tolerance: Tolerance,
    mut acceleration: impl FnMut(&Stage<'_>, f64, &Motion<N>) -> Vector<N>,
) -> Option<Accepted<N>> {
    until_accepted((t, h, end), &DORMAND_PRINCE, |step, end| {
        DP54.stages(step, start, 1, rates, |stage, at| {
            let time = if stage.node == 1.0 { end } else { t + stage.node * step };
            acceleration(stage, time, at)
        });
        let motion = start.plus(step, &DP54.weights, rates);
        let error = Motion::error(step, &DP54_ERROR, rates, [start, &motion], tolerance);
        (motion, error)
    })
}

/// The same for steps in which friction is solved for. `step` is told the length of a step and the
/// time of its end.
pub(super) fn attempt_stiff<const N: usize>(
    (t, h, end): (f64, f64, f64),
    start: &Motion<N>,
    tolerance: Tolerance,
    mut step: impl FnMut(f64, f64) -> Moved<N>,
) -> Option<Accepted<N>> {
    until_accepted((t, h, end), &STIFF, |h, end| {
        let Moved { motion, error, lost, .. } = step(h, end);
        let size = |i: usize| start.q[i].abs().max(motion.q[i].abs());
        let scaled = |i: usize| error[i].abs() / (tolerance.atol + tolerance.rtol * size(i));
        let largest =
            (0..N).map(scaled).fold(0.0, |a: f64, b| if b > a || b.is_nan() { b } else { a });
        (motion, if matches!(lost, Some((_, Coarse::Friction))) { f64::INFINITY } else { largest })
    })
}

/// Tries steps until the error of one, relative to its tolerance, is at most 1.
#[inline(always)]
fn until_accepted<const N: usize>(
    (t, mut h, end): (f64, f64, f64),
    growth: &Growth,
    mut trial: impl FnMut(f64, f64) -> (Motion<N>, f64),
) -> Option<Accepted<N>> {
    while h > SHORTEST_STEP * t.max(1.0) {
        let last = t + h >= end;
        let (step, end) = if last { (end - t, end) } else { (h, t + h) };
        let (motion, error) = trial(step, end);
        let factor = (SAFETY * exp(growth.power * ln(error))).clamp(MIN_FACTOR, growth.max_factor);
        if error <= 1.0 {
            return Some(Accepted { motion, h: step, end, next_h: h.max(step) * factor });
        }
        h = step * if error.is_finite() { factor } else { MIN_FACTOR };
    }
    None
}

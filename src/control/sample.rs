//! What a controller sees at one instant: the measurement, the set-point, and `e = q − q_d`, around
//! the circle where a joint turns without an end.

use crate::math::{Vector, around};
use crate::reference::Setpoint;

/// What a controller sees at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample<const N: usize> {
    /// Measured position q \[rad\].
    pub q: Vector<N>,
    /// Measured velocity q̇ [rad/s].
    pub dq: Vector<N>,
    /// Where the arm should be.
    pub desired: Setpoint<N>,
    /// Tracking error e = q − q_d \[rad\], in [−π, π) for a joint that turns without an end.
    pub e: Vector<N>,
    /// ė = q̇ − q̇_d [rad/s].
    pub de: Vector<N>,
}

impl<const N: usize> Sample<N> {
    /// Measurement and set-point, with their difference, for an arm none of whose joints turns
    /// without an end.
    #[inline]
    pub fn new(q: Vector<N>, dq: Vector<N>, desired: Setpoint<N>) -> Self {
        Self { q, dq, desired, e: q - desired.q, de: dq - desired.dq }
    }

    /// As [`new`](Self::new), with the error of the joints that
    /// [`Arm::wraps`](crate::arm::Arm::wraps) names taken around the circle: −π ≤ e < π. q and q_d
    /// stay as they are.
    #[inline]
    pub fn wrapped(q: Vector<N>, dq: Vector<N>, desired: Setpoint<N>, wraps: &[bool; N]) -> Self {
        let mut e = q - desired.q;
        // Asked of all joints at once: most arms have none.
        if wraps.iter().fold(false, |any, wraps| any | wraps) {
            e = around_where(wraps, &e);
        }
        Self { q, dq, desired, e, de: dq - desired.dq }
    }
}

/// The error of the joints that wrap around the circle. Out of the way of arms without such joints.
#[inline(never)]
fn around_where<const N: usize>(wraps: &[bool; N], e: &Vector<N>) -> Vector<N> {
    Vector::from_fn(|n, _| if wraps[n] { around(e[n]) } else { e[n] })
}

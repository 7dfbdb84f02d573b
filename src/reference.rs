//! Where the arm should be: a desired motion as a function of time.

use crate::math::Vector;

/// Desired position [rad], velocity [rad/s] and acceleration [rad/s²] at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setpoint<const N: usize> {
    /// q_d [rad].
    pub q: Vector<N>,
    /// q̇_d [rad/s].
    pub dq: Vector<N>,
    /// q̈_d [rad/s²].
    pub ddq: Vector<N>,
}

/// A desired motion. Any `Fn(f64) -> Setpoint<N>` is one.
pub trait Reference<const N: usize> {
    /// The set-point at time `t` [s].
    fn at(&self, t: f64) -> Setpoint<N>;
}

impl<const N: usize, F: Fn(f64) -> Setpoint<N>> Reference<N> for F {
    fn at(&self, t: f64) -> Setpoint<N> {
        self(t)
    }
}

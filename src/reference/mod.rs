//! Where the arm should be: a desired motion as a function of time.

#[cfg(feature = "std")]
mod profile;
mod quintic;
mod sines;
mod table;
#[cfg(feature = "std")]
mod waypoints;

pub use quintic::Quintic;
pub use sines::{Harmonic, Sines};
pub use table::Table;
#[cfg(feature = "std")]
pub use waypoints::{MAX_POSES, MotionLimits, Waypoints};

use crate::math::Vector;

/// Desired position \[rad\], velocity [rad/s] and acceleration [rad/s²] at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setpoint<const N: usize, T = f64> {
    /// q_d \[rad\].
    pub q: Vector<N, T>,
    /// q̇_d [rad/s].
    pub dq: Vector<N, T>,
    /// q̈_d [rad/s²].
    pub ddq: Vector<N, T>,
}

impl<const N: usize> Setpoint<N> {
    /// Standing still at `q` \[rad\].
    #[inline]
    pub fn at_rest(q: Vector<N>) -> Self {
        Self { q, dq: Vector::zeros(), ddq: Vector::zeros() }
    }
}

/// A desired motion. Any `Fn(f64) -> Setpoint<N>` is one.
pub trait Reference<const N: usize> {
    /// The set-point at time `t` \[s\].
    fn at(&self, t: f64) -> Setpoint<N>;
}

impl<const N: usize, F: Fn(f64) -> Setpoint<N>> Reference<N> for F {
    #[inline]
    fn at(&self, t: f64) -> Setpoint<N> {
        self(t)
    }
}

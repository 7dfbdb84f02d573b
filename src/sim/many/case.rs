//! One of many runs.

use crate::control::{Controller, State};
use crate::effects::Effects;
use crate::plant::Plant;
use crate::sim::options::Method;
use crate::sim::sampled::Sampled;

/// What is other from one of many runs to the next.
#[derive(Debug)]
pub struct Case<'a, const N: usize, A, D, L, C, R, S> {
    /// What is really there.
    pub plant: &'a Plant<N, A, D>,
    /// The controller.
    pub controller: &'a Controller<N, L, C>,
    /// The controller's state at the start of the run.
    pub state: &'a State<N, S>,
    /// The motion that is wanted.
    pub reference: &'a R,
    /// Initial position \[rad\].
    pub q0: [f64; N],
    /// Initial velocity [rad/s].
    pub dq0: [f64; N],
    /// What stands between controller and arm.
    pub effects: Effects<N>,
}

impl<'a, const N: usize, A, D, L, C, R, S> Case<'a, N, A, D, L, C, R, S> {
    /// Its loop, sampled once in `hold` steps of `dt` \[s\], by RK4.
    pub(super) fn sampled(&self, hold: usize, dt: f64) -> Sampled<'a, N, A, D, L, C, R> {
        let Self { plant, controller, reference, .. } = *self;
        Sampled { plant, controller, reference, hold, dt, method: Method::Rk4 }
    }
}

//! A guard and its controller as one: what a loop calls.

use super::turn::{Guarded, Seen, Turn};
use super::{GuardMemory, GuardParameters};
use crate::control::{Compensator, Controller, Law, State};
use crate::error::Result;
use crate::math::Vector;
use crate::reference::Setpoint;

/// A guard around a controller. Immutable; one can drive many states.
#[derive(Clone, Copy, Debug)]
pub struct Guard<const N: usize, L, C> {
    /// The controller.
    pub controller: Controller<N, L, C>,
    parameters: GuardParameters<N>,
}

/// What a guard and its controller remember.
#[derive(Clone, Debug, PartialEq)]
pub struct GuardState<const N: usize, S = ()> {
    /// The controller's state.
    pub controller: State<N, S>,
    /// The guard's own.
    pub guard: GuardMemory<N>,
}

impl<const N: usize, S> GuardState<N, S> {
    /// A guard's state before its first sample, around its controller's.
    pub fn new(controller: State<N, S>) -> Self {
        let guard = GuardMemory::new(controller.last_tau);
        Self { controller, guard }
    }
}

impl<const N: usize, L: Law<N>, C> Guard<N, L, C> {
    /// A guard with these limits.
    ///
    /// # Errors
    /// As [`GuardParameters::validate`].
    pub fn new(controller: Controller<N, L, C>, parameters: GuardParameters<N>) -> Result<Self> {
        parameters.validate()?;
        Ok(Self { controller, parameters })
    }

    /// Its limits and times.
    pub fn parameters(&self) -> &GuardParameters<N> {
        &self.parameters
    }

    /// One sample, `elapsed` \[s\] after the last call: the torque to send. Allocates nothing, and
    /// does not fail: whatever came, the torque can be sent.
    ///
    /// `applied` is the torque that the drive let through since the last call [N·m], if it says so;
    /// without it that is what was sent. One that is not finite is an event
    /// ([`Event::NotFinite`](super::Event)), and nothing is learnt from that period.
    pub fn step<S>(
        &self,
        state: &mut GuardState<N, S>,
        applied: Option<&Vector<N>>,
        (q, dq): (&Vector<N>, &Vector<N>),
        desired: &Setpoint<N>,
        elapsed: f64,
    ) -> Guarded<N>
    where
        C: Compensator<N, S>,
    {
        self.turn(state).step(&Seen { q, dq, desired, applied, elapsed })
    }

    /// A period in which no sample came: the torque to send.
    pub fn missed<S>(&self, state: &mut GuardState<N, S>) -> Guarded<N>
    where
        C: Compensator<N, S>,
    {
        self.turn(state).missed()
    }

    /// Stops: from the next sample on the arm is braked, until the state is
    /// [rearmed](GuardMemory::rearm).
    pub fn stop<S>(&self, state: &mut GuardState<N, S>)
    where
        C: Compensator<N, S>,
    {
        self.turn(state).stop();
    }

    /// Forgets everything: the state is then as a new one, to the bit, and the guard runs.
    pub fn reset<S>(&self, state: &mut GuardState<N, S>)
    where
        C: Compensator<N, S>,
    {
        self.controller.reset(&mut state.controller);
        state.guard = GuardMemory::default();
    }

    fn turn<'a, S>(&'a self, state: &'a mut GuardState<N, S>) -> Turn<'a, N, L, C, S> {
        let GuardState { controller: state, guard: memory } = state;
        Turn { guard: &self.parameters, memory, controller: &self.controller, state }
    }
}

//! Any compensator with its state behind pointers, where the type is known only at run time: from a
//! scenario file, in Python, in a list of rivals. A step allocates nothing.

use core::any::Any;
use core::marker::PhantomData;
use std::boxed::Box;

use super::saved::Saves;
use super::{Applied, Audit, Beliefs, Channel, Compensator, Gains, Law, Learns, Sample, Stage};
use crate::arm::Side;
use crate::error::Result;
use crate::math::{Matrix, Vector};

/// Any law.
pub type BoxedLaw<const N: usize> = Box<dyn Law<N> + Send + Sync>;

/// Any compensator whose state can be saved.
pub struct BoxedCompensator<const N: usize>(Box<dyn Erased<N>>);

/// What it remembers; made by [`BoxedCompensator::state`].
#[derive(Clone)]
pub struct BoxedState {
    inner: Box<dyn Remembers>,
    /// Whether it only looks, and changes nothing.
    frozen: bool,
}

impl<const N: usize> BoxedCompensator<N> {
    /// This compensator; `new` makes a state before the first sample.
    pub fn new<S, C, F>(compensator: C, new: F) -> Self
    where
        S: Clone + Send + Sync + 'static,
        C: Saves<N, S> + Send + Sync + 'static,
        F: Fn(&C) -> S + Send + Sync + 'static,
    {
        Self(Box::new(With { compensator, new, state: PhantomData }))
    }

    /// A state before the first sample.
    pub fn state(&self) -> BoxedState {
        BoxedState { inner: self.0.state(), frozen: false }
    }
}

impl BoxedState {
    /// Stops learning, or lets it go on; what was learnt stays in use.
    pub fn set_frozen(&mut self, frozen: bool) {
        self.frozen = frozen;
    }

    /// Whether learning is stopped.
    pub fn frozen(&self) -> bool {
        self.frozen
    }
}

/// A state, of whatever type.
trait Remembers: Any + Send + Sync {
    fn boxed(&self) -> Box<dyn Remembers>;
}

impl<S: Clone + Send + Sync + 'static> Remembers for S {
    fn boxed(&self) -> Box<dyn Remembers> {
        Box::new(self.clone())
    }
}

impl Clone for Box<dyn Remembers> {
    fn clone(&self) -> Self {
        (**self).boxed()
    }
}

/// A compensator, of whatever type, with states of its own.
trait Erased<const N: usize>: Send + Sync {
    fn state(&self) -> Box<dyn Remembers>;
    fn learns<'a>(&'a self, state: &'a dyn Any) -> Option<Learns<'a, N>>;
    fn sampled_only(&self) -> bool;
    fn channels(&self) -> &'static [Channel];
    fn form(&self) -> Form;
    fn estimate(&self, state: &mut dyn Any, stage: &Stage<'_>, seen: &Sample<N>) -> Vector<N>;
    fn acted(&self, state: &mut dyn Any, i: usize, seen: &Sample<N>, applied: &Applied<N>);
    fn admit(&self, state: &dyn Any, seen: &Sample<N>, dt: f64) -> Result<()>;
    fn advance(&self, state: &mut dyn Any, end: &Stage<'_>) -> Result<()>;
    fn coast(&self, state: &mut dyn Any, end: &Stage<'_>) -> Result<()>;
    fn carry(&self, state: &mut dyn Any, last: usize) -> bool;
    fn audit(&self, state: &dyn Any, i: usize, seen: &Sample<N>) -> Option<Audit<N>>;
    fn signals(&self, state: &dyn Any, seen: &Sample<N>, row: &mut [f64]);
    fn describe(&self, state: &dyn Any, put: &mut dyn FnMut(&'static str, &[f64]));
    fn counts(&self, state: &dyn Any) -> [u64; 2];
    fn write(&self, state: &dyn Any, put: &mut dyn FnMut(&[u8]));
    fn check(&self, flags: u64, part: &[u8]) -> Result<()>;
    fn take(&self, state: &mut dyn Any, flags: u64, advances: u64, part: &[u8]);
}

/// What a compensator says of the form of its saved state.
struct Form {
    known_flags: u64,
    has_counter: bool,
    entries: &'static str,
    size: usize,
    fingerprints: [u64; 2],
}

struct With<S, C, F> {
    compensator: C,
    new: F,
    state: PhantomData<fn() -> S>,
}

/// `$body` for a state of the right type, which [`BoxedCompensator::state`] sees to.
macro_rules! own {
    ($state:ident, $cast:ident, $body:expr, $none:expr) => {
        match $state.$cast::<S>() {
            Some($state) => $body,
            None => $none,
        }
    };
}

impl<const N: usize, S, C, F> Erased<N> for With<S, C, F>
where
    S: Clone + Send + Sync + 'static,
    C: Saves<N, S> + Send + Sync,
    F: Fn(&C) -> S + Send + Sync,
{
    fn state(&self) -> Box<dyn Remembers> {
        Box::new((self.new)(&self.compensator))
    }

    fn learns<'a>(&'a self, state: &'a dyn Any) -> Option<Learns<'a, N>> {
        own!(state, downcast_ref, self.compensator.learns(state), None)
    }

    fn sampled_only(&self) -> bool {
        self.compensator.sampled_only()
    }

    fn channels(&self) -> &'static [Channel] {
        self.compensator.channels()
    }

    fn form(&self) -> Form {
        let it = &self.compensator;
        Form {
            known_flags: it.known_flags(),
            has_counter: it.has_counter(),
            entries: it.entries(),
            size: it.size(),
            fingerprints: it.fingerprints(),
        }
    }

    fn estimate(&self, state: &mut dyn Any, stage: &Stage<'_>, seen: &Sample<N>) -> Vector<N> {
        let it = &self.compensator;
        own!(state, downcast_mut, it.estimate(state, stage, seen), Vector::zeros())
    }

    fn acted(&self, state: &mut dyn Any, i: usize, seen: &Sample<N>, applied: &Applied<N>) {
        own!(state, downcast_mut, self.compensator.acted(state, i, seen, applied), ());
    }

    fn admit(&self, state: &dyn Any, seen: &Sample<N>, dt: f64) -> Result<()> {
        own!(state, downcast_ref, self.compensator.admit(state, seen, dt), Ok(()))
    }

    fn advance(&self, state: &mut dyn Any, end: &Stage<'_>) -> Result<()> {
        own!(state, downcast_mut, self.compensator.advance(state, end), Ok(()))
    }

    fn coast(&self, state: &mut dyn Any, end: &Stage<'_>) -> Result<()> {
        own!(state, downcast_mut, self.compensator.coast(state, end), Ok(()))
    }

    fn carry(&self, state: &mut dyn Any, last: usize) -> bool {
        own!(state, downcast_mut, self.compensator.carry(state, last), false)
    }

    fn audit(&self, state: &dyn Any, i: usize, seen: &Sample<N>) -> Option<Audit<N>> {
        own!(state, downcast_ref, self.compensator.audit(state, i, seen), None)
    }

    fn signals(&self, state: &dyn Any, seen: &Sample<N>, row: &mut [f64]) {
        own!(state, downcast_ref, self.compensator.signals(state, seen, row), ());
    }

    fn describe(&self, state: &dyn Any, put: &mut dyn FnMut(&'static str, &[f64])) {
        own!(state, downcast_ref, self.compensator.describe(state, put), ());
    }

    fn counts(&self, state: &dyn Any) -> [u64; 2] {
        let it = &self.compensator;
        own!(state, downcast_ref, [it.flags(state), it.advances(state)], [0; 2])
    }

    fn write(&self, state: &dyn Any, put: &mut dyn FnMut(&[u8])) {
        own!(state, downcast_ref, self.compensator.write(state, put), ());
    }

    fn check(&self, flags: u64, part: &[u8]) -> Result<()> {
        self.compensator.check(flags, part)
    }

    fn take(&self, state: &mut dyn Any, flags: u64, advances: u64, part: &[u8]) {
        own!(state, downcast_mut, self.compensator.take(state, flags, advances, part), ());
    }
}

/// The flag of a frozen state, as the fuzzy compensators have it.
const FROZEN: u64 = super::fuzzy_compensator::FROZEN;

impl<const N: usize> Compensator<N, BoxedState> for BoxedCompensator<N> {
    fn estimate(&self, state: &mut BoxedState, stage: &Stage<'_>, seen: &Sample<N>) -> Vector<N> {
        self.0.estimate(&mut *state.inner, stage, seen)
    }

    fn acted(&self, state: &mut BoxedState, i: usize, seen: &Sample<N>, applied: &Applied<N>) {
        self.0.acted(&mut *state.inner, i, seen, applied);
    }

    fn admit(&self, state: &BoxedState, seen: &Sample<N>, dt: f64) -> Result<()> {
        self.0.admit(&*state.inner, seen, dt)
    }

    fn advance(&self, state: &mut BoxedState, end: &Stage<'_>) -> Result<()> {
        let BoxedState { inner, frozen } = state;
        if *frozen { self.0.coast(&mut **inner, end) } else { self.0.advance(&mut **inner, end) }
    }

    fn coast(&self, state: &mut BoxedState, end: &Stage<'_>) -> Result<()> {
        self.0.coast(&mut *state.inner, end)
    }

    fn carry(&self, state: &mut BoxedState, last: usize) -> bool {
        !state.frozen && self.0.carry(&mut *state.inner, last)
    }

    fn reset(&self, state: &mut BoxedState) {
        *state = self.state();
    }

    fn audit(&self, state: &BoxedState, i: usize, seen: &Sample<N>) -> Option<Audit<N>> {
        self.0.audit(&*state.inner, i, seen)
    }

    fn learns<'a>(&'a self, state: &'a BoxedState) -> Option<Learns<'a, N>> {
        if state.frozen { None } else { self.0.learns(&*state.inner) }
    }

    fn sampled_only(&self) -> bool {
        self.0.sampled_only()
    }

    fn channels(&self) -> &'static [Channel] {
        self.0.channels()
    }

    fn describe(&self, state: &BoxedState, put: &mut dyn FnMut(&'static str, &[f64])) {
        self.0.describe(&*state.inner, put);
    }

    fn signals(&self, state: &BoxedState, seen: &Sample<N>, row: &mut [f64]) {
        self.0.signals(&*state.inner, seen, row);
    }
}

impl<const N: usize> Saves<N, BoxedState> for BoxedCompensator<N> {
    fn known_flags(&self) -> u64 {
        self.0.form().known_flags | FROZEN
    }

    fn entries(&self) -> &'static str {
        self.0.form().entries
    }

    fn size(&self) -> usize {
        self.0.form().size
    }

    fn fingerprints(&self) -> [u64; 2] {
        self.0.form().fingerprints
    }

    fn flags(&self, state: &BoxedState) -> u64 {
        self.0.counts(&*state.inner)[0] | if state.frozen { FROZEN } else { 0 }
    }

    fn has_counter(&self) -> bool {
        self.0.form().has_counter
    }

    fn advances(&self, state: &BoxedState) -> u64 {
        self.0.counts(&*state.inner)[1]
    }

    fn write(&self, state: &BoxedState, put: &mut dyn FnMut(&[u8])) {
        self.0.write(&*state.inner, put);
    }

    fn check(&self, flags: u64, part: &[u8]) -> Result<()> {
        self.0.check(flags & self.0.form().known_flags, part)
    }

    fn take(&self, state: &mut BoxedState, flags: u64, advances: u64, part: &[u8]) {
        state.frozen = flags & FROZEN != 0;
        // What is inside is never frozen itself.
        let known = self.0.form().known_flags & !FROZEN;
        self.0.take(&mut *state.inner, flags & known, advances, part);
    }
}

/// A law behind a pointer is a law.
impl<const N: usize> Law<N> for BoxedLaw<N> {
    fn torque(&self, seen: &Sample<N>, rho_hat: &Vector<N>) -> super::Demand<N> {
        (**self).torque(seen, rho_hat)
    }

    fn model(&self) -> Option<Side<'_, N>> {
        (**self).model()
    }

    fn torque_by(
        &self,
        dynamics: &(Matrix<N>, Vector<N>),
        seen: &Sample<N>,
        rho_hat: &Vector<N>,
    ) -> super::Demand<N> {
        (**self).torque_by(dynamics, seen, rho_hat)
    }

    fn constant_gains(&self) -> Option<&Gains<N>> {
        (**self).constant_gains()
    }

    fn beliefs(&self) -> Option<Beliefs<'_, N>> {
        (**self).beliefs()
    }

    fn resting_torque(&self, q: &Vector<N>) -> Vector<N> {
        (**self).resting_torque(q)
    }

    fn inertia_torque(&self, q: &Vector<N>, acceleration: &Vector<N>) -> Vector<N> {
        (**self).inertia_torque(q, acceleration)
    }

    fn joint_friction(&self, joint: usize) -> crate::arm::JointFriction {
        (**self).joint_friction(joint)
    }

    fn wraps(&self) -> [bool; N] {
        (**self).wraps()
    }

    fn fingerprint(&self) -> u64 {
        (**self).fingerprint()
    }

    fn tuning(&self) -> u64 {
        (**self).tuning()
    }
}

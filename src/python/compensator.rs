//! Any compensator behind one type, for a tracker: none, the fuzzy one in either form, or what
//! another law remembers.

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::convert::{Any, array1, object};
use super::fuzzy::PyFuzzyCompensator;
use crate::control::{
    Applied, Audit, BoxedCompensator, BoxedState, Channel, Compensator, FuzzyCompensator,
    FuzzyState, KernelCompensator, KernelState, Learns, NoCompensation, Sample, Saves, Stage,
};
use crate::design::Subject;
use crate::error::Result;
use crate::math::Vector;

/// Any compensator. One without a matrix of weights raises TypeError when it is asked for them.
pub(super) enum AnyCompensator<const N: usize> {
    None,
    Fuzzy(Box<FuzzyCompensator<N>>),
    Kernel(Box<KernelCompensator<N>>),
    /// That of another law, and whether it learns something that stays right.
    Other(BoxedCompensator<N>, bool),
    /// None, of a controller of one's own, which works from sample to sample.
    Own,
}

/// What it remembers: the variant of its compensator, which [`AnyCompensator::state`] sees to.
#[derive(Clone)]
pub(super) enum Memory<const N: usize> {
    None,
    Fuzzy(Box<FuzzyState<N, Vec<f64>>>),
    Kernel(Box<KernelState<N, Vec<f64>>>),
    Other(BoxedState),
}

/// `$body` for a compensator with its own state, or `$none`.
macro_rules! both {
    ($any:expr, $memory:expr, |$compensator:ident, $state:ident| $body:expr, $none:expr) => {
        match ($any, $memory) {
            (AnyCompensator::Fuzzy($compensator), Memory::Fuzzy($state)) => $body,
            (AnyCompensator::Kernel($compensator), Memory::Kernel($state)) => $body,
            (AnyCompensator::Other($compensator, _), Memory::Other($state)) => $body,
            _ => $none,
        }
    };
}

impl<const N: usize> Compensator<N, Memory<N>> for AnyCompensator<N> {
    #[inline]
    fn estimate(&self, memory: &mut Memory<N>, stage: &Stage<'_>, sample: &Sample<N>) -> Vector<N> {
        both!(self, memory, |it, state| it.estimate(state, stage, sample), Vector::zeros())
    }

    #[inline(always)]
    fn acted(&self, memory: &mut Memory<N>, i: usize, sample: &Sample<N>, applied: &Applied<N>) {
        both!(self, memory, |it, state| it.acted(state, i, sample, applied), ());
    }

    #[inline]
    fn admit(&self, memory: &Memory<N>, sample: &Sample<N>, dt: f64) -> Result<()> {
        both!(self, memory, |it, state| it.admit(state, sample, dt), Ok(()))
    }

    #[inline]
    fn advance(&self, memory: &mut Memory<N>, end: &Stage<'_>) -> Result<()> {
        both!(self, memory, |it, state| it.advance(state, end), Ok(()))
    }

    #[inline]
    fn carry(&self, memory: &mut Memory<N>, last: usize) -> bool {
        both!(self, memory, |it, state| it.carry(state, last), true)
    }

    fn reset(&self, memory: &mut Memory<N>) {
        both!(self, memory, |it, state| it.reset(state), ());
    }

    #[inline(always)]
    fn audit(&self, memory: &Memory<N>, i: usize, sample: &Sample<N>) -> Option<Audit<N>> {
        both!(self, memory, |it, state| it.audit(state, i, sample), None)
    }

    fn learns<'a>(&'a self, memory: &'a Memory<N>) -> Option<Learns<'a, N>> {
        match (self, memory) {
            (Self::None, _) => Some(Learns::NOTHING),
            (Self::Fuzzy(fuzzy), Memory::Fuzzy(state)) => fuzzy.learns(state),
            (Self::Other(it, _), Memory::Other(state)) => Compensator::learns(it, state),
            _ => None,
        }
    }

    fn channels(&self) -> &'static [Channel] {
        match self {
            Self::None | Self::Own => &[],
            Self::Other(it, _) => Compensator::<N, BoxedState>::channels(it),
            Self::Fuzzy(fuzzy) => Compensator::<N, FuzzyState<N, Vec<f64>>>::channels(&**fuzzy),
            Self::Kernel(kernel) => Compensator::<N, KernelState<N, Vec<f64>>>::channels(&**kernel),
        }
    }

    fn sampled_only(&self) -> bool {
        match self {
            Self::Own => true,
            Self::Other(it, _) => it.sampled_only(),
            _ => false,
        }
    }

    fn describe(&self, memory: &Memory<N>, put: &mut dyn FnMut(&'static str, &[f64])) {
        both!(self, memory, |it, state| it.describe(state, put), ());
    }

    fn signals(&self, memory: &Memory<N>, sample: &Sample<N>, row: &mut [f64]) {
        both!(self, memory, |it, state| it.signals(state, sample, row), ());
    }
}

/// What a compensator says of its state's form, whatever the state.
macro_rules! any {
    ($any:expr, $method:ident($($argument:expr),*)) => {
        match $any {
            AnyCompensator::Other(it, _) => Saves::<N, BoxedState>::$method(it, $($argument),*),
            AnyCompensator::None | AnyCompensator::Own => {
                Saves::<N, ()>::$method(&NoCompensation, $($argument),*)
            }
            AnyCompensator::Fuzzy(it) => {
                Saves::<N, FuzzyState<N, Vec<f64>>>::$method(&**it, $($argument),*)
            }
            AnyCompensator::Kernel(it) => {
                Saves::<N, KernelState<N, Vec<f64>>>::$method(&**it, $($argument),*)
            }
        }
    };
}

impl<const N: usize> Saves<N, Memory<N>> for AnyCompensator<N> {
    fn known_flags(&self) -> u64 {
        any!(self, known_flags())
    }

    fn entries(&self) -> &'static str {
        any!(self, entries())
    }

    fn size(&self) -> usize {
        any!(self, size())
    }

    fn fingerprints(&self) -> [u64; 2] {
        any!(self, fingerprints())
    }

    fn flags(&self, memory: &Memory<N>) -> u64 {
        both!(self, memory, |it, state| it.flags(state), 0)
    }

    fn has_counter(&self) -> bool {
        any!(self, has_counter())
    }

    fn advances(&self, memory: &Memory<N>) -> u64 {
        both!(self, memory, |it, state| it.advances(state), 0)
    }

    fn write(&self, memory: &Memory<N>, put: &mut dyn FnMut(&[u8])) {
        both!(self, memory, |it, state| it.write(state, put), ());
    }

    fn check(&self, flags: u64, part: &[u8]) -> Result<()> {
        any!(self, check(flags, part))
    }

    fn take(&self, memory: &mut Memory<N>, flags: u64, advances: u64, part: &[u8]) {
        both!(self, memory, |it, state| it.take(state, flags, advances, part), ());
    }
}

impl<const N: usize> AnyCompensator<N> {
    /// A state before the first step.
    pub fn state(&self) -> Memory<N> {
        match self {
            Self::None | Self::Own => Memory::None,
            Self::Other(it, _) => Memory::Other(it.state()),
            Self::Fuzzy(fuzzy) => Memory::Fuzzy(Box::new(fuzzy.state())),
            Self::Kernel(kernel) => Memory::Kernel(Box::new(kernel.state())),
        }
    }

    /// Whether it remembers something, so that it can be frozen.
    pub fn remembers(&self) -> bool {
        !matches!(self, Self::None | Self::Own)
    }

    /// Whether what it learns stays right when learning stops.
    pub fn learns(&self) -> bool {
        match self {
            Self::None | Self::Own => false,
            Self::Fuzzy(_) | Self::Kernel(_) => true,
            Self::Other(_, learns) => *learns,
        }
    }

    /// Columns of W.
    pub fn rules(&self) -> PyResult<usize> {
        Ok(self.dense()?.weights_len() / N)
    }

    /// It, as the one that has a matrix of weights.
    fn dense(&self) -> PyResult<&FuzzyCompensator<N>> {
        match self {
            Self::None | Self::Other(..) | Self::Own => Err(no_compensator()),
            Self::Fuzzy(fuzzy) => Ok(fuzzy),
            Self::Kernel(_) => Err(no_matrix()),
        }
    }

    /// It, as the subject of a design report; `None` where there is nothing to report on.
    pub fn subject(&self) -> Option<&dyn Subject<N>> {
        match self {
            Self::None | Self::Other(..) | Self::Own => None,
            Self::Fuzzy(fuzzy) => Some(&**fuzzy),
            Self::Kernel(kernel) => Some(&**kernel),
        }
    }

    /// W, row-major with n rows.
    pub fn weights(&self, memory: &Memory<N>) -> PyResult<Vec<f64>> {
        let dense = self.dense()?;
        let mut weights = vec![0.0; dense.weights_len()];
        if let Memory::Fuzzy(state) = memory {
            dense.read_weights(state, &mut weights)?;
        }
        Ok(weights)
    }

    /// Whether these can be W, or with `prior` W₀ too.
    pub fn check_weights(&self, weights: &[f64], prior: bool) -> PyResult<()> {
        Ok(self.dense()?.check_weights(weights, prior)?)
    }

    /// Sets W, and with `prior` W₀ too.
    pub fn set_weights(
        &self,
        memory: &mut Memory<N>,
        weights: &[f64],
        prior: bool,
    ) -> PyResult<()> {
        let dense = self.dense()?;
        let Memory::Fuzzy(state) = memory else { return Ok(()) };
        let set = if prior {
            dense.warm_start(state, weights)
        } else {
            dense.load_weights(state, weights)
        };
        Ok(set?)
    }

    /// The dictionary in figures; `None` but for the kernel form.
    pub fn dictionary<'py>(
        &self,
        py: Python<'py>,
        memory: &Memory<N>,
    ) -> PyResult<Option<Bound<'py, PyDict>>> {
        let (Self::Kernel(kernel), Memory::Kernel(state)) = (self, memory) else {
            return Ok(None);
        };
        let dict = PyDict::new(py);
        dict.set_item("atoms", state.atoms())?;
        dict.set_item("capacity", kernel.kernel_parameters().capacity)?;
        dict.set_item("merged", state.merged())?;
        dict.set_item("dropped", state.dropped())?;
        dict.set_item("error_bound", array1(py, state.error_bound().as_slice()))?;
        Ok(Some(dict))
    }
}

impl<const N: usize> Memory<N> {
    /// Stops the adaptation, or lets it go on.
    pub fn set_frozen(&mut self, frozen: bool) -> PyResult<()> {
        match (self, frozen) {
            (Self::None, _) => return Err(no_compensator()),
            (Self::Fuzzy(state), true) => state.freeze(),
            (Self::Fuzzy(state), false) => state.unfreeze(),
            (Self::Kernel(state), true) => state.freeze(),
            (Self::Kernel(state), false) => state.unfreeze(),
            (Self::Other(state), frozen) => state.set_frozen(frozen),
        }
        Ok(())
    }

    pub fn frozen(&self) -> bool {
        match self {
            Self::None => false,
            Self::Fuzzy(state) => state.frozen(),
            Self::Kernel(state) => state.frozen(),
            Self::Other(state) => state.frozen(),
        }
    }
}

pub(super) fn no_compensator() -> PyErr {
    PyTypeError::new_err("compensator: this controller has none, so it has no weights")
}

fn no_matrix() -> PyErr {
    PyTypeError::new_err(
        "weights: this compensator has a dictionary, the kernel form, so it has no matrix of \
         weights; see the tracker's dictionary, or build it with dictionary=None",
    )
}

/// What was given as the argument `compensator`.
pub(super) fn compensator_of<'a>(value: Any<'a, '_>) -> PyResult<&'a PyFuzzyCompensator> {
    let wanted = "a FuzzyCompensator or None";
    Ok(object::<PyFuzzyCompensator>(value, "compensator", wanted)?.get())
}

//! Any compensator behind one type, for the tracker.

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::convert::{array1, type_name};
use super::dispatch::same_joints;
use super::fuzzy::PyFuzzyCompensator;
use super::value_error;
use crate::control::{
    Audit, Compensator, FuzzyCompensator, FuzzyState, Gains, KernelCompensator, KernelState,
    Sample, Stage,
};
use crate::error::Result;
use crate::math::Vector;

type Any<'a, 'py> = &'a Bound<'py, PyAny>;

/// Any compensator.
pub(super) enum AnyCompensator<const N: usize> {
    None,
    Fuzzy(Box<FuzzyCompensator<N>>),
    Kernel(Box<KernelCompensator<N>>),
}

/// Its state.
#[derive(Clone)]
pub(super) enum AnyState<const N: usize> {
    None,
    Fuzzy(Box<FuzzyState<N, Vec<f64>>>),
    Kernel(Box<KernelState<N, Vec<f64>>>),
}

impl<const N: usize> Compensator<N, AnyState<N>> for AnyCompensator<N> {
    #[inline(always)]
    fn estimate(
        &self,
        state: &mut AnyState<N>,
        stage: &Stage<'_>,
        sample: &Sample<N>,
    ) -> Vector<N> {
        match (self, state) {
            (Self::Fuzzy(fuzzy), AnyState::Fuzzy(state)) => fuzzy.estimate(state, stage, sample),
            (Self::Kernel(kernel), AnyState::Kernel(state)) => {
                kernel.estimate(state, stage, sample)
            }
            _ => Vector::zeros(),
        }
    }

    #[inline(always)]
    fn hold(&self, state: &mut AnyState<N>, index: usize) {
        match (self, state) {
            (Self::Fuzzy(fuzzy), AnyState::Fuzzy(state)) => fuzzy.hold(state, index),
            (Self::Kernel(kernel), AnyState::Kernel(state)) => kernel.hold(state, index),
            _ => {}
        }
    }

    #[inline]
    fn advance(&self, state: &mut AnyState<N>, end: &Stage<'_>) -> Result<()> {
        match (self, state) {
            (Self::Fuzzy(fuzzy), AnyState::Fuzzy(state)) => fuzzy.advance(state, end),
            (Self::Kernel(kernel), AnyState::Kernel(state)) => kernel.advance(state, end),
            _ => Ok(()),
        }
    }

    #[inline]
    fn carry(&self, state: &mut AnyState<N>, last: usize) -> bool {
        match (self, state) {
            (Self::Fuzzy(fuzzy), AnyState::Fuzzy(state)) => fuzzy.carry(state, last),
            (Self::Kernel(kernel), AnyState::Kernel(state)) => kernel.carry(state, last),
            _ => true,
        }
    }

    fn reset(&self, state: &mut AnyState<N>) {
        match (self, state) {
            (Self::Fuzzy(fuzzy), AnyState::Fuzzy(state)) => fuzzy.reset(state),
            (Self::Kernel(kernel), AnyState::Kernel(state)) => kernel.reset(state),
            _ => {}
        }
    }

    #[inline(always)]
    fn audit(&self, state: &AnyState<N>, index: usize, sample: &Sample<N>) -> Option<Audit<N>> {
        match (self, state) {
            (Self::Fuzzy(fuzzy), AnyState::Fuzzy(state)) => fuzzy.audit(state, index, sample),
            (Self::Kernel(kernel), AnyState::Kernel(state)) => kernel.audit(state, index, sample),
            _ => None,
        }
    }
}

/// W of a state, row-major with n rows; `None` without a compensator, or in the kernel form.
pub(super) fn weights_of<const N: usize>(
    compensator: &AnyCompensator<N>,
    state: &AnyState<N>,
) -> Result<Option<Vec<f64>>> {
    let (AnyCompensator::Fuzzy(fuzzy), AnyState::Fuzzy(state)) = (compensator, state) else {
        return Ok(None);
    };
    let mut weights = vec![0.0; fuzzy.weights_len()];
    fuzzy.read_weights(state, &mut weights)?;
    Ok(Some(weights))
}

/// The dictionary of a state in figures; `None` but for the kernel form.
pub(super) fn dictionary_of<'py, const N: usize>(
    py: Python<'py>,
    compensator: &AnyCompensator<N>,
    state: &AnyState<N>,
) -> PyResult<Option<Bound<'py, PyDict>>> {
    let (AnyCompensator::Kernel(kernel), AnyState::Kernel(state)) = (compensator, state) else {
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

/// The compensator of these gains that a Python argument asks for, and its state.
pub(super) fn compensator_for<const N: usize>(
    value: Option<Any<'_, '_>>,
    gains: &Gains<N>,
) -> PyResult<(AnyCompensator<N>, AnyState<N>)> {
    let Some(value) = value else { return Ok((AnyCompensator::None, AnyState::None)) };
    let fuzzy = compensator_of(value)?;
    if let Some(joints) = fuzzy.joints {
        same_joints("compensator", joints, N)?;
    }
    let parameters = fuzzy.parameters()?;
    if let Some(kernel) = fuzzy.kernel {
        let basis = fuzzy.basis.kernel_for_arm(N)?;
        let kernel = KernelCompensator::new(basis, gains, parameters, kernel);
        let kernel = Box::new(kernel.map_err(value_error)?);
        let state = Box::new(kernel.state());
        return Ok((AnyCompensator::Kernel(kernel), AnyState::Kernel(state)));
    }
    let basis = fuzzy.basis.for_arm(N)?;
    let fuzzy = Box::new(FuzzyCompensator::new(basis, gains, parameters).map_err(value_error)?);
    let state = Box::new(fuzzy.state());
    Ok((AnyCompensator::Fuzzy(fuzzy), AnyState::Fuzzy(state)))
}

/// What was given as the argument `compensator`.
pub(super) fn compensator_of<'a>(value: Any<'a, '_>) -> PyResult<&'a PyFuzzyCompensator> {
    let fuzzy = value.cast::<PyFuzzyCompensator>().map_err(|_| {
        let got = type_name(value);
        PyTypeError::new_err(format!("compensator: got {got}, wants a FuzzyCompensator or None"))
    })?;
    Ok(fuzzy.get())
}

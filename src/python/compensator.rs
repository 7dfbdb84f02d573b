//! Any compensator behind one type, for the tracker.

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;

use super::convert::{Array2, owned2, type_name};
use super::dispatch::{JOINTS, JointVector};
use super::fuzzy::PyFuzzyCompensator;
use super::value_error;
use crate::control::{Audit, Compensator, FuzzyCompensator, FuzzyState, Gains, Sample, Stage};
use crate::error::Result;

type Any<'a, 'py> = &'a Bound<'py, PyAny>;

/// Any compensator.
pub(super) enum AnyCompensator {
    None,
    Fuzzy(Box<FuzzyCompensator<JOINTS>>),
}

/// Its state.
#[derive(Clone)]
pub(super) enum AnyState {
    None,
    Fuzzy(Box<FuzzyState<JOINTS, Vec<f64>>>),
}

impl Compensator<JOINTS, AnyState> for AnyCompensator {
    #[inline]
    fn estimate(
        &self,
        state: &mut AnyState,
        stage: &Stage<'_>,
        sample: &Sample<JOINTS>,
    ) -> JointVector {
        match (self, state) {
            (Self::Fuzzy(fuzzy), AnyState::Fuzzy(state)) => fuzzy.estimate(state, stage, sample),
            _ => JointVector::zeros(),
        }
    }

    #[inline]
    fn hold(&self, state: &mut AnyState, index: usize) {
        if let (Self::Fuzzy(fuzzy), AnyState::Fuzzy(state)) = (self, state) {
            fuzzy.hold(state, index);
        }
    }

    #[inline]
    fn advance(&self, state: &mut AnyState, end: &Stage<'_>) -> Result<()> {
        match (self, state) {
            (Self::Fuzzy(fuzzy), AnyState::Fuzzy(state)) => fuzzy.advance(state, end),
            _ => Ok(()),
        }
    }

    fn reset(&self, state: &mut AnyState) {
        if let (Self::Fuzzy(fuzzy), AnyState::Fuzzy(state)) = (self, state) {
            fuzzy.reset(state);
        }
    }

    #[inline]
    fn audit(
        &self,
        state: &AnyState,
        index: usize,
        sample: &Sample<JOINTS>,
    ) -> Option<Audit<JOINTS>> {
        match (self, state) {
            (Self::Fuzzy(fuzzy), AnyState::Fuzzy(state)) => fuzzy.audit(state, index, sample),
            _ => None,
        }
    }
}

/// W of a state, (n, rules); `None` without a compensator.
pub(super) fn weights_of<'py>(
    py: Python<'py>,
    compensator: &AnyCompensator,
    state: &AnyState,
) -> PyResult<Option<Array2<'py>>> {
    let (AnyCompensator::Fuzzy(fuzzy), AnyState::Fuzzy(state)) = (compensator, state) else {
        return Ok(None);
    };
    let mut weights = vec![0.0; fuzzy.weights_len()];
    fuzzy.read_weights(state, &mut weights).map_err(value_error)?;
    owned2(py, weights, fuzzy.weights_len() / JOINTS).map(Some)
}

/// The compensator of these gains that a Python argument asks for, and its state.
pub(super) fn compensator_for(
    value: Option<Any<'_, '_>>,
    gains: &Gains<JOINTS>,
) -> PyResult<(AnyCompensator, AnyState)> {
    let Some(value) = value else { return Ok((AnyCompensator::None, AnyState::None)) };
    let fuzzy = value.cast::<PyFuzzyCompensator>().map_err(|_| {
        let got = type_name(value);
        PyTypeError::new_err(format!("compensator: got {got}, wants a FuzzyCompensator or None"))
    })?;
    let PyFuzzyCompensator { basis, parameters } = fuzzy.get();
    let (basis, _) = basis.for_arm()?;
    let fuzzy = Box::new(FuzzyCompensator::new(basis, gains, *parameters).map_err(value_error)?);
    let state = Box::new(fuzzy.state());
    Ok((AnyCompensator::Fuzzy(fuzzy), AnyState::Fuzzy(state)))
}

//! What a tracker asks of its compensator beyond ρ̂: its weights, and itself in words and bytes.

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::convert::{Any, array1, type_name};
use super::fuzzy::PyFuzzyCompensator;
use super::value_error;
use crate::control::{
    Compensator, FuzzyCompensator, FuzzyState, KernelCompensator, KernelState, NoCompensation,
    State,
};
use crate::design::Subject;
use crate::error::Result;

/// A compensator of a tracker. One without a matrix of weights raises TypeError when it is asked
/// for them.
pub(super) trait Compensation<const N: usize>:
    Compensator<N, Self::State> + Send + Sync + 'static
{
    /// What it remembers.
    type State: Clone + Send + Sync;

    /// It in words.
    fn words(&self) -> String;

    /// The controller's state as bytes.
    fn save(&self, state: &State<N, Self::State>) -> Vec<u8>;

    /// Takes over what [`save`](Self::save) gave.
    fn restore(&self, state: &mut State<N, Self::State>, bytes: &[u8]) -> Result<()>;

    /// Stops the adaptation, or lets it go on.
    fn set_frozen(&self, state: &mut Self::State, frozen: bool) -> PyResult<()>;

    fn frozen(state: &Self::State) -> bool;

    /// It, as the one that has a matrix of weights.
    fn dense(&self) -> PyResult<&FuzzyCompensator<N>>;

    /// W, row-major with n rows.
    fn weights(&self, state: &Self::State) -> PyResult<Vec<f64>>;

    /// Sets W, and with `prior` W₀ too.
    fn set_weights(&self, state: &mut Self::State, weights: &[f64], prior: bool) -> PyResult<()>;

    /// It, as the subject of a design report; `None` where there is nothing to report on.
    fn subject(&self) -> Option<&dyn Subject<N>> {
        None
    }

    /// The dictionary in figures; `None` but for the kernel form.
    fn dictionary<'py>(
        &self,
        _py: Python<'py>,
        _state: &Self::State,
    ) -> PyResult<Option<Bound<'py, PyDict>>> {
        Ok(None)
    }
}

impl<const N: usize> Compensation<N> for NoCompensation {
    type State = ();

    fn words(&self) -> String {
        "none".into()
    }

    fn save(&self, state: &State<N>) -> Vec<u8> {
        state.save()
    }

    fn restore(&self, state: &mut State<N>, bytes: &[u8]) -> Result<()> {
        *state = State::restore(bytes)?;
        Ok(())
    }

    fn set_frozen(&self, (): &mut (), _: bool) -> PyResult<()> {
        Err(no_compensator())
    }

    fn frozen((): &()) -> bool {
        false
    }

    fn dense(&self) -> PyResult<&FuzzyCompensator<N>> {
        Err(no_compensator())
    }

    fn weights(&self, (): &()) -> PyResult<Vec<f64>> {
        Err(no_compensator())
    }

    fn set_weights(&self, (): &mut (), _: &[f64], _: bool) -> PyResult<()> {
        Err(no_compensator())
    }
}

fn no_compensator() -> PyErr {
    PyTypeError::new_err("compensator: this controller has none, so it has no weights")
}

impl<const N: usize> Compensation<N> for FuzzyCompensator<N> {
    type State = FuzzyState<N, Vec<f64>>;

    fn words(&self) -> String {
        format!("fuzzy, {} rules", self.basis().rules())
    }

    fn save(&self, state: &State<N, Self::State>) -> Vec<u8> {
        self.save(state)
    }

    fn restore(&self, state: &mut State<N, Self::State>, bytes: &[u8]) -> Result<()> {
        self.restore(state, bytes)
    }

    fn set_frozen(&self, state: &mut Self::State, frozen: bool) -> PyResult<()> {
        if frozen {
            state.freeze()
        } else {
            state.unfreeze()
        }
        Ok(())
    }

    fn frozen(state: &Self::State) -> bool {
        state.frozen()
    }

    fn dense(&self) -> PyResult<&Self> {
        Ok(self)
    }

    fn weights(&self, state: &Self::State) -> PyResult<Vec<f64>> {
        let mut weights = vec![0.0; self.weights_len()];
        self.read_weights(state, &mut weights).map_err(value_error)?;
        Ok(weights)
    }

    fn set_weights(&self, state: &mut Self::State, weights: &[f64], prior: bool) -> PyResult<()> {
        let set =
            if prior { self.warm_start(state, weights) } else { self.load_weights(state, weights) };
        set.map_err(value_error)
    }

    fn subject(&self) -> Option<&dyn Subject<N>> {
        Some(self)
    }
}

impl<const N: usize> Compensation<N> for KernelCompensator<N> {
    type State = KernelState<N, Vec<f64>>;

    fn words(&self) -> String {
        let (rules, parameters) = (self.basis().rules(), self.kernel_parameters());
        format!("fuzzy, {rules:.3e} rules in {} atoms", parameters.capacity)
    }

    fn save(&self, state: &State<N, Self::State>) -> Vec<u8> {
        self.save(state)
    }

    fn restore(&self, state: &mut State<N, Self::State>, bytes: &[u8]) -> Result<()> {
        self.restore(state, bytes)
    }

    fn set_frozen(&self, state: &mut Self::State, frozen: bool) -> PyResult<()> {
        if frozen {
            state.freeze()
        } else {
            state.unfreeze()
        }
        Ok(())
    }

    fn frozen(state: &Self::State) -> bool {
        state.frozen()
    }

    fn dense(&self) -> PyResult<&FuzzyCompensator<N>> {
        Err(no_matrix())
    }

    fn weights(&self, _: &Self::State) -> PyResult<Vec<f64>> {
        Err(no_matrix())
    }

    fn set_weights(&self, _: &mut Self::State, _: &[f64], _: bool) -> PyResult<()> {
        Err(no_matrix())
    }

    fn subject(&self) -> Option<&dyn Subject<N>> {
        Some(self)
    }

    fn dictionary<'py>(
        &self,
        py: Python<'py>,
        state: &Self::State,
    ) -> PyResult<Option<Bound<'py, PyDict>>> {
        let dict = PyDict::new(py);
        dict.set_item("atoms", state.atoms())?;
        dict.set_item("capacity", self.kernel_parameters().capacity)?;
        dict.set_item("merged", state.merged())?;
        dict.set_item("dropped", state.dropped())?;
        dict.set_item("error_bound", array1(py, state.error_bound().as_slice()))?;
        Ok(Some(dict))
    }
}

fn no_matrix() -> PyErr {
    PyTypeError::new_err(
        "weights: this compensator has a dictionary, the kernel form, so it has no matrix of \
         weights; \
         see the tracker's dictionary, or build it with dictionary=None",
    )
}

/// What was given as the argument `compensator`.
pub(super) fn compensator_of<'a>(value: Any<'a, '_>) -> PyResult<&'a PyFuzzyCompensator> {
    let fuzzy = value.cast::<PyFuzzyCompensator>().map_err(|_| {
        let got = type_name(value);
        PyTypeError::new_err(format!("compensator: got {got}, wants a FuzzyCompensator or None"))
    })?;
    Ok(fuzzy.get())
}

//! `ComputedTorque`: the stepwise controller, with its state.

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use super::arm::PyTwoLink;
use super::convert::{Array1, Array2, array1, joints, matrix_of, owned2, type_name, vector};
use super::dispatch::{JOINTS, JointVector};
use super::fuzzy::PyFuzzyCompensator;
use super::value_error;
use crate::arm::TwoLink;
use crate::control::{
    Audit, Command, Compensator, ComputedTorque, FuzzyCompensator, FuzzyState, Gains, Limits,
    Sample, Stage, State,
};
use crate::error::Result;
use crate::reference::Setpoint;

type Any<'a, 'py> = &'a Bound<'py, PyAny>;
type Fuzzy = FuzzyCompensator<JOINTS>;

/// Any compensator.
pub(super) enum AnyCompensator {
    None,
    Fuzzy(Box<Fuzzy>),
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

/// The controller with its state.
#[pyclass(name = "ComputedTorque", module = "steadyarm")]
pub(super) struct PyComputedTorque {
    arguments: Py<PyAny>,
    pub controller: ComputedTorque<JOINTS, TwoLink, AnyCompensator>,
    pub state: State<JOINTS, AnyState>,
    latest: Option<Command<JOINTS>>,
}

impl PyComputedTorque {
    /// W of a state, (n, rules); `None` without a compensator.
    pub fn weights_of<'py>(
        &self,
        py: Python<'py>,
        state: &AnyState,
    ) -> PyResult<Option<Array2<'py>>> {
        let (AnyCompensator::Fuzzy(fuzzy), AnyState::Fuzzy(state)) =
            (&self.controller.compensator, state)
        else {
            return Ok(None);
        };
        let mut weights = vec![0.0; fuzzy.weights_len()];
        fuzzy.read_weights(state, &mut weights).map_err(value_error)?;
        owned2(py, weights, fuzzy.weights_len() / JOINTS).map(Some)
    }

    /// The compensator with its state.
    fn fuzzy(&mut self) -> PyResult<(&Fuzzy, &mut FuzzyState<JOINTS, Vec<f64>>)> {
        match (&self.controller.compensator, &mut self.state.compensator) {
            (AnyCompensator::Fuzzy(fuzzy), AnyState::Fuzzy(state)) => Ok((fuzzy, state)),
            _ => Err(PyTypeError::new_err(
                "compensator: this controller has none, so it has no weights",
            )),
        }
    }

    fn latest<'py>(
        &self,
        py: Python<'py>,
        part: impl Fn(&Command<JOINTS>) -> JointVector,
    ) -> Option<Array1<'py>> {
        self.latest.as_ref().map(|command| array1(py, part(command).as_slice()))
    }
}

#[pymethods]
impl PyComputedTorque {
    #[new]
    #[pyo3(signature = (arm, kp, kv, compensator=None, effort_limit=None, effort_rate_limit=None))]
    fn new(
        py: Python<'_>,
        arm: Any<'_, '_>,
        kp: Any<'_, '_>,
        kv: Any<'_, '_>,
        compensator: Option<Any<'_, '_>>,
        effort_limit: Option<Any<'_, '_>>,
        effort_rate_limit: Option<Any<'_, '_>>,
    ) -> PyResult<Self> {
        let arguments = (arm, kp, kv, compensator, effort_limit, effort_rate_limit);
        let arguments = arguments.into_pyobject(py)?.into_any().unbind();
        let arm = arm.cast::<PyTwoLink>().map_err(|_| {
            PyTypeError::new_err(format!("arm: got {}, wants a TwoLink", type_name(arm)))
        })?;
        let gains = Gains::new(joints(kp, "kp")?, joints(kv, "kv")?).map_err(value_error)?;
        let limit = |value: Option<Any<'_, '_>>, name| {
            value.map_or(Ok([f64::INFINITY; JOINTS]), |v| joints(v, name))
        };
        let limits = Limits {
            effort_limit: limit(effort_limit, "effort_limit")?,
            effort_rate_limit: limit(effort_rate_limit, "effort_rate_limit")?,
        };
        let (compensator, state) = compensator_for(compensator, &gains)?;
        let controller = ComputedTorque::new(arm.get().arm, gains, compensator)
            .with_limits(limits)
            .map_err(value_error)?;
        Ok(Self { arguments, controller, state: State::new(state), latest: None })
    }

    #[inline]
    fn step<'py>(
        &mut self,
        py: Python<'py>,
        q: Any<'_, 'py>,
        dq: Any<'_, 'py>,
        q_d: Any<'_, 'py>,
        dq_d: Any<'_, 'py>,
        ddq_d: Any<'_, 'py>,
        dt: f64,
    ) -> PyResult<Array1<'py>> {
        let (q, dq) = (vector(q, "q")?, vector(dq, "dq")?);
        let (q_d, dq_d) = (vector(q_d, "q_d")?, vector(dq_d, "dq_d")?);
        let desired = Setpoint { q: q_d, dq: dq_d, ddq: vector(ddq_d, "ddq_d")? };
        let command =
            self.controller.step(&mut self.state, &q, &dq, &desired, dt).map_err(value_error)?;
        self.latest = Some(command);
        Ok(array1(py, command.tau.as_slice()))
    }

    fn reset(&mut self) {
        self.controller.compensator.reset(&mut self.state.compensator);
        self.state.last_tau = None;
        self.state.steps = 0;
        self.latest = None;
    }

    #[getter]
    fn tau_model<'py>(&self, py: Python<'py>) -> Option<Array1<'py>> {
        self.latest(py, |command| command.model)
    }

    #[getter]
    fn tau_compensation<'py>(&self, py: Python<'py>) -> Option<Array1<'py>> {
        self.latest(py, |command| command.compensation)
    }

    #[getter]
    fn rho_hat<'py>(&self, py: Python<'py>) -> Option<Array1<'py>> {
        self.latest(py, |command| command.rho_hat)
    }

    #[getter]
    fn limited(&self) -> bool {
        self.latest.as_ref().is_some_and(|command| command.limited)
    }

    #[getter]
    fn steps(&self) -> u64 {
        self.state.steps
    }

    #[getter]
    fn kp<'py>(&self, py: Python<'py>) -> Array1<'py> {
        array1(py, &self.controller.gains.kp)
    }

    #[getter]
    fn kv<'py>(&self, py: Python<'py>) -> Array1<'py> {
        array1(py, &self.controller.gains.kv)
    }

    #[getter]
    fn arm(&self, py: Python<'_>) -> PyResult<Py<PyTwoLink>> {
        Py::new(py, PyTwoLink { arm: self.controller.arm })
    }

    #[getter]
    fn compensator<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.arguments.bind(py).get_item(3)
    }

    /// P of (19), (2 n, 2 n); None without a compensator.
    #[getter]
    #[pyo3(name = "P")]
    fn p<'py>(&self, py: Python<'py>) -> PyResult<Option<Array2<'py>>> {
        let AnyCompensator::Fuzzy(fuzzy) = &self.controller.compensator else { return Ok(None) };
        let size = 2 * JOINTS;
        let mut p = vec![0.0; size * size];
        for (n, joint) in fuzzy.p().iter().enumerate() {
            let m = n + JOINTS;
            p[n * size + n] = joint.p11;
            p[n * size + m] = joint.p12;
            p[m * size + n] = joint.p12;
            p[m * size + m] = joint.p22;
        }
        owned2(py, p, size).map(Some)
    }

    #[getter]
    fn weights<'py>(&self, py: Python<'py>) -> PyResult<Option<Array2<'py>>> {
        self.weights_of(py, &self.state.compensator)
    }

    #[setter]
    fn set_weights(&mut self, weights: Any<'_, '_>) -> PyResult<()> {
        let (fuzzy, state) = self.fuzzy()?;
        let weights = matrix_of(weights, "weights", JOINTS, fuzzy.weights_len() / JOINTS)?;
        fuzzy.load_weights(state, &weights).map_err(value_error)
    }

    fn warm_start(&mut self, weights: Any<'_, '_>) -> PyResult<()> {
        let (fuzzy, state) = self.fuzzy()?;
        let weights = matrix_of(weights, "weights", JOINTS, fuzzy.weights_len() / JOINTS)?;
        fuzzy.warm_start(state, &weights).map_err(value_error)
    }

    fn freeze(&mut self) -> PyResult<()> {
        self.fuzzy().map(|(_, state)| state.freeze())
    }

    fn unfreeze(&mut self) -> PyResult<()> {
        self.fuzzy().map(|(_, state)| state.unfreeze())
    }

    #[getter]
    fn frozen(&self) -> bool {
        matches!(&self.state.compensator, AnyState::Fuzzy(state) if state.frozen())
    }

    /// The state as bytes; None without a compensator.
    fn __getstate__<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyBytes>> {
        let (AnyCompensator::Fuzzy(fuzzy), AnyState::Fuzzy(state)) =
            (&self.controller.compensator, &self.state.compensator)
        else {
            return None;
        };
        let State { last_tau, steps, .. } = self.state;
        let state = State { compensator: (**state).clone(), last_tau, steps };
        Some(PyBytes::new(py, &fuzzy.save(&state)))
    }

    fn __setstate__(&mut self, bytes: &[u8]) -> PyResult<()> {
        let (fuzzy, fuzzy_state) = self.fuzzy()?;
        let mut state = State::new(fuzzy_state.clone());
        fuzzy.restore(&mut state, bytes).map_err(value_error)?;
        let State { compensator, last_tau, steps } = state;
        self.state = State { compensator: AnyState::Fuzzy(Box::new(compensator)), last_tau, steps };
        self.latest = None;
        Ok(())
    }

    fn __reduce__<'py>(
        slf: &Bound<'py, Self>,
    ) -> PyResult<(Bound<'py, PyAny>, Py<PyAny>, Option<Bound<'py, PyBytes>>)> {
        let this = slf.borrow();
        let arguments = this.arguments.clone_ref(slf.py());
        Ok((slf.get_type().into_any(), arguments, this.__getstate__(slf.py())))
    }

    fn __repr__(&self) -> String {
        let Gains { kp, kv } = self.controller.gains;
        let compensator = match &self.controller.compensator {
            AnyCompensator::None => "none".into(),
            AnyCompensator::Fuzzy(fuzzy) => format!("fuzzy, {} rules", fuzzy.basis().rules()),
        };
        format!("ComputedTorque(kp={kp:?}, kv={kv:?}, compensator: {compensator})")
    }
}

fn compensator_for(
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

//! `ComputedTorque`: the stepwise controller, with its state.

use std::path::PathBuf;
use std::sync::Arc;

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use super::arm::PyTwoLink;
use super::compensator::{AnyCompensator, AnyState, compensator_for, weights_of};
use super::convert::{
    Array1, Array2, array1, joints, matrix_of, owned2, scalar, type_name, vector, wrong_type,
};
use super::dispatch::{JOINTS, JointVector};
use super::{saving, value_error};
use crate::arm::TwoLink;
use crate::control::{
    Command, Compensator, ComputedTorque, FuzzyCompensator, FuzzyState, Gains, Limits, State,
};
use crate::error::Result;
use crate::reference::Setpoint;

type Any<'a, 'py> = &'a Bound<'py, PyAny>;
type Fuzzy = FuzzyCompensator<JOINTS>;

/// Computed torque for the nominal arm, τ = M₀(v - ρ̂) + H₀ with v = ddq_d - K_v de - K_p e (eqs. 7, 11, 12).
///
/// arm: TwoLink. kp [1/s²], kv [1/s]: scalar or (2,), > 0. compensator: FuzzyCompensator, or None for ρ̂ = 0.
/// effort_limit [N·m], effort_rate_limit [N·m/s]: scalar or (2,); none by default. The object holds the state: weights,
/// last torque, number of steps.
#[pyclass(name = "ComputedTorque", module = "steadyarm")]
pub(super) struct PyComputedTorque {
    arguments: Py<PyAny>,
    pub controller: Arc<ComputedTorque<JOINTS, TwoLink, AnyCompensator>>,
    pub state: State<JOINTS, AnyState>,
    latest: Option<Command<JOINTS>>,
}

impl PyComputedTorque {
    /// The compensator with its state.
    fn fuzzy(&mut self) -> PyResult<(&Fuzzy, &mut FuzzyState<JOINTS, Vec<f64>>)> {
        match (&self.controller.compensator, &mut self.state.compensator) {
            (AnyCompensator::Fuzzy(fuzzy), AnyState::Fuzzy(state)) => Ok((fuzzy, state)),
            _ => Err(PyTypeError::new_err(
                "compensator: this controller has none, so it has no weights",
            )),
        }
    }

    /// What the controller remembers, as bytes.
    fn saved(&self) -> Vec<u8> {
        let State { last_tau, steps, .. } = self.state;
        match (&self.controller.compensator, &self.state.compensator) {
            (AnyCompensator::Fuzzy(fuzzy), AnyState::Fuzzy(state)) => {
                fuzzy.save(&State { compensator: (**state).clone(), last_tau, steps })
            }
            _ => State { compensator: (), last_tau, steps }.save(),
        }
    }

    /// Takes over what [`saved`](Self::saved) gave, or changes nothing.
    fn restore(&mut self, bytes: &[u8]) -> Result<()> {
        let (compensator, last_tau, steps) =
            match (&self.controller.compensator, &self.state.compensator) {
                (AnyCompensator::Fuzzy(fuzzy), AnyState::Fuzzy(state)) => {
                    let mut state = State::new((**state).clone());
                    fuzzy.restore(&mut state, bytes)?;
                    let State { compensator, last_tau, steps } = state;
                    (AnyState::Fuzzy(Box::new(compensator)), last_tau, steps)
                }
                _ => {
                    let State { last_tau, steps, .. } = State::restore(bytes)?;
                    (AnyState::None, last_tau, steps)
                }
            };
        self.state = State { compensator, last_tau, steps };
        self.latest = None;
        Ok(())
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
        let given = (arm, compensator);
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
        let Limits { effort_limit, effort_rate_limit } = controller.limits;
        let arguments = (given.0, gains.kp, gains.kv, given.1, effort_limit, effort_rate_limit);
        let arguments = arguments.into_pyobject(py)?.into_any().unbind();
        let (controller, state) = (Arc::new(controller), State::new(state));
        Ok(Self { arguments, controller, state, latest: None })
    }

    /// One sample: the torque [N·m], (2,), to hold for dt [s]; adapts the weights.
    ///
    /// q, q_d [rad], dq, dq_d [rad/s], ddq_d [rad/s²]: (2,). A sample that is refused (ValueError) changes nothing.
    #[inline]
    #[expect(clippy::too_many_arguments, reason = "a Python method")]
    fn step<'py>(
        &mut self,
        py: Python<'py>,
        q: Any<'_, 'py>,
        dq: Any<'_, 'py>,
        q_d: Any<'_, 'py>,
        dq_d: Any<'_, 'py>,
        ddq_d: Any<'_, 'py>,
        dt: Any<'_, 'py>,
    ) -> PyResult<Array1<'py>> {
        let (q, dq) = (vector(q, "q")?, vector(dq, "dq")?);
        let (q_d, dq_d) = (vector(q_d, "q_d")?, vector(dq_d, "dq_d")?);
        let desired = Setpoint { q: q_d, dq: dq_d, ddq: vector(ddq_d, "ddq_d")? };
        let dt = scalar(dt, "dt")?;
        let command =
            self.controller.step(&mut self.state, &q, &dq, &desired, dt).map_err(value_error)?;
        self.latest = Some(command);
        Ok(array1(py, command.tau.as_slice()))
    }

    /// Forget the weights, the last torque and the count of steps.
    fn reset(&mut self) {
        self.controller.compensator.reset(&mut self.state.compensator);
        self.state.last_tau = None;
        self.state.steps = 0;
        self.latest = None;
    }

    /// M₀v + H₀ of the latest step [N·m], (2,); None before it.
    #[getter]
    fn tau_model<'py>(&self, py: Python<'py>) -> Option<Array1<'py>> {
        self.latest(py, |command| command.model)
    }

    /// -M₀ρ̂ of the latest step [N·m], (2,); None before it.
    #[getter]
    fn tau_compensation<'py>(&self, py: Python<'py>) -> Option<Array1<'py>> {
        self.latest(py, |command| command.compensation)
    }

    /// ρ̂ of the latest step [rad/s²], (2,); None before it.
    #[getter]
    fn rho_hat<'py>(&self, py: Python<'py>) -> Option<Array1<'py>> {
        self.latest(py, |command| command.rho_hat)
    }

    /// Whether a limit cut the latest torque; nothing was learnt then.
    #[getter]
    fn limited(&self) -> bool {
        self.latest.as_ref().is_some_and(|command| command.limited)
    }

    /// Number of samples accepted.
    #[getter]
    fn steps(&self) -> u64 {
        self.state.steps
    }

    /// K_p [1/s²], (2,).
    #[getter]
    fn kp<'py>(&self, py: Python<'py>) -> Array1<'py> {
        array1(py, &self.controller.gains.kp)
    }

    /// K_v [1/s], (2,).
    #[getter]
    fn kv<'py>(&self, py: Python<'py>) -> Array1<'py> {
        array1(py, &self.controller.gains.kv)
    }

    /// The nominal arm.
    #[getter]
    fn arm(&self, py: Python<'_>) -> PyResult<Py<PyTwoLink>> {
        Py::new(py, PyTwoLink { arm: self.controller.arm })
    }

    /// The compensator, or None.
    #[getter]
    fn compensator<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.arguments.bind(py).get_item(3)
    }

    /// P of (19), (4, 4); None without a compensator.
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

    /// W, (2, rules), a copy; None without a compensator. Assign to set it: adaptation goes on from there.
    #[getter]
    fn weights<'py>(&self, py: Python<'py>) -> PyResult<Option<Array2<'py>>> {
        weights_of(py, &self.controller.compensator, &self.state.compensator)
    }

    #[setter]
    fn set_weights(&mut self, weights: Any<'_, '_>) -> PyResult<()> {
        let (fuzzy, state) = self.fuzzy()?;
        let weights = matrix_of(weights, "weights", JOINTS, fuzzy.weights_len() / JOINTS)?;
        fuzzy.load_weights(state, &weights).map_err(value_error)
    }

    /// Set W, and make it the W₀ that leak, e-modification and projection pull to.
    fn warm_start(&mut self, weights: Any<'_, '_>) -> PyResult<()> {
        let (fuzzy, state) = self.fuzzy()?;
        let weights = matrix_of(weights, "weights", JOINTS, fuzzy.weights_len() / JOINTS)?;
        fuzzy.warm_start(state, &weights).map_err(value_error)
    }

    /// Stop adapting; the weights stay in use.
    fn freeze(&mut self) -> PyResult<()> {
        self.fuzzy().map(|(_, state)| state.freeze())
    }

    /// Adapt again.
    fn unfreeze(&mut self) -> PyResult<()> {
        self.fuzzy().map(|(_, state)| state.unfreeze())
    }

    /// Whether adaptation is stopped.
    #[getter]
    fn frozen(&self) -> bool {
        matches!(&self.state.compensator, AnyState::Fuzzy(state) if state.frozen())
    }

    /// What the controller remembers, as bytes: versioned, checksummed, exact to the bit.
    fn __getstate__<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, &self.saved())
    }

    fn __setstate__(&mut self, bytes: Any<'_, '_>) -> PyResult<()> {
        let bytes =
            bytes.cast::<PyBytes>().map_err(|_| wrong_type("saved state", bytes, "bytes"))?;
        self.restore(bytes.as_bytes()).map_err(value_error)
    }

    /// Write what the controller remembers (weights, last torque, steps) to a file, which is replaced as a whole.
    fn save(&self, path: PathBuf) -> PyResult<()> {
        saving::write(&path, &self.saved())
    }

    /// Read what `save` wrote; the next torques are then the same to the bit. Raises ValueError, with nothing changed,
    /// for a damaged file or one of another controller.
    fn load(&mut self, path: PathBuf) -> PyResult<()> {
        let bytes = saving::read(&path)?;
        self.restore(&bytes).map_err(|error| {
            let path = path.display();
            PyValueError::new_err(format!(
                "path: got {path}, wants a file of this controller ({error})"
            ))
        })
    }

    fn __reduce__<'py>(
        slf: &Bound<'py, Self>,
    ) -> PyResult<(Bound<'py, PyAny>, Py<PyAny>, Bound<'py, PyBytes>)> {
        let this = slf.try_borrow()?;
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

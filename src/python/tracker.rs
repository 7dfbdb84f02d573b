//! `ComputedTorque`: the stepwise controller, with its state.

use std::path::PathBuf;

use pyo3::PyTraverseError;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::gc::PyVisit;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use super::any_arm::joints_of;
use super::compensator::compensator_of;
use super::convert::{Any, Array1, Array2, array1, matrix_of, owned2, wrong_type};
use super::dispatch::for_joints;
use super::tracked::{Arguments, Part, Tracked, tracker};
use super::{saving, value_error};

/// Computed torque for the nominal arm, τ = M₀(v - ρ̂) + H₀ with v = ddq_d - K_v de - K_p e (eqs.
/// 7, 11, 12).
///
/// arm: TwoLink or Serial, of n joints. kp [1/s²], kv [1/s]: scalar or (n,), > 0. compensator:
/// FuzzyCompensator, or None for ρ̂ = 0. effort_limit [N·m], effort_rate_limit [N·m/s]: scalar or
/// (n,); none by default. The object holds the state: weights, last torque, number of steps.
#[pyclass(name = "ComputedTorque", module = "steadyarm")]
pub(super) struct PyComputedTorque {
    arguments: Py<PyAny>,
    pub tracked: Box<dyn Tracked>,
}

impl PyComputedTorque {
    fn latest<'py>(&self, py: Python<'py>, part: Part) -> Option<Array1<'py>> {
        self.tracked.latest(part).map(|values| array1(py, values))
    }

    /// The same tracker in the same state, of which one may go on alone.
    pub fn twin(tracker: &Bound<'_, Self>) -> PyResult<Self> {
        let this = tracker.try_borrow().map_err(|_| {
            PyRuntimeError::new_err("tracker: it is in the middle of a step, wants one that is not")
        })?;
        Ok(Self { arguments: this.arguments.clone_ref(tracker.py()), tracked: this.tracked.twin() })
    }

    /// What it is made of: its arguments, and what it remembers.
    pub fn parts<'py>(&self, py: Python<'py>) -> (Py<PyAny>, Bound<'py, PyBytes>) {
        (self.arguments.clone_ref(py), self.__getstate__(py))
    }

    fn restore(&mut self, bytes: &[u8]) -> crate::error::Result<()> {
        self.tracked.restore(bytes)
    }

    fn write_weights(&mut self, weights: Any<'_, '_>, prior: bool) -> PyResult<()> {
        let (rows, columns) = (self.tracked.joints(), self.tracked.weights_columns()?);
        let weights = matrix_of(weights, "weights", rows, columns)?;
        self.tracked.set_weights(&weights, prior)
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
        let given = Arguments { arm, kp, kv, compensator, effort_limit, effort_rate_limit };
        let joints = joints_of(arm)?;
        let tracked = for_joints!(joints, tracker(&given))?;
        let ([kp, kv], [effort, effort_rate]) = (tracked.gains(), tracked.limits());
        // Scalars of the compensator count for the joints of this arm.
        let compensator =
            compensator.map(|c| compensator_of(c)?.of_joints(py, joints)).transpose()?;
        let arguments =
            (arm, kp.to_vec(), kv.to_vec(), compensator, effort.to_vec(), effort_rate.to_vec());
        let arguments = arguments.into_pyobject(py)?.into_any().unbind();
        Ok(Self { arguments, tracked })
    }

    /// One sample: the torque [N·m], (n,), to hold for dt [s]; adapts the weights.
    ///
    /// q, q_d [rad], dq, dq_d [rad/s], ddq_d [rad/s²]: (n,). A sample that is refused (ValueError)
    /// changes nothing.
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
        self.tracked.step(py, [q, dq, q_d, dq_d, ddq_d], dt)
    }

    /// Forget everything: weights, prior, last torque, count of steps. As a new one, to the bit,
    /// and not frozen.
    fn reset(&mut self) {
        self.tracked.reset();
    }

    /// M₀v + H₀ of the latest step [N·m], (n,); None before it.
    #[getter]
    fn tau_model<'py>(&self, py: Python<'py>) -> Option<Array1<'py>> {
        self.latest(py, Part::Model)
    }

    /// -M₀ρ̂ of the latest step [N·m], (n,); None before it.
    #[getter]
    fn tau_compensation<'py>(&self, py: Python<'py>) -> Option<Array1<'py>> {
        self.latest(py, Part::Compensation)
    }

    /// ρ̂ of the latest step [rad/s²], (n,); None before it.
    #[getter]
    fn rho_hat<'py>(&self, py: Python<'py>) -> Option<Array1<'py>> {
        self.latest(py, Part::RhoHat)
    }

    /// Whether a limit cut the latest torque; nothing was learnt then.
    #[getter]
    fn limited(&self) -> bool {
        self.tracked.limited()
    }

    /// Number of samples accepted.
    #[getter]
    fn steps(&self) -> u64 {
        self.tracked.steps()
    }

    /// K_p [1/s²], (n,).
    #[getter]
    fn kp<'py>(&self, py: Python<'py>) -> Array1<'py> {
        array1(py, self.tracked.gains()[0])
    }

    /// K_v [1/s], (n,).
    #[getter]
    fn kv<'py>(&self, py: Python<'py>) -> Array1<'py> {
        array1(py, self.tracked.gains()[1])
    }

    /// The nominal arm.
    #[getter]
    fn arm<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.arguments.bind(py).get_item(0)
    }

    /// The compensator, or None.
    #[getter]
    fn compensator<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.arguments.bind(py).get_item(3)
    }

    /// P of (19), (2n, 2n); None without a compensator.
    #[getter]
    #[pyo3(name = "P")]
    fn p<'py>(&self, py: Python<'py>) -> PyResult<Option<Array2<'py>>> {
        self.tracked.p().map(|p| owned2(py, p, 2 * self.tracked.joints())).transpose()
    }

    /// W, (n, rules), a copy; None without a compensator; TypeError in the kernel form, which has
    /// none. Assign to set it: adaptation goes on from there.
    #[getter]
    fn weights<'py>(&self, py: Python<'py>) -> PyResult<Option<Array2<'py>>> {
        if self.compensator(py)?.is_none() {
            return Ok(None);
        }
        owned2(py, self.tracked.weights()?, self.tracked.weights_columns()?).map(Some)
    }

    #[setter]
    fn set_weights(&mut self, weights: Any<'_, '_>) -> PyResult<()> {
        self.write_weights(weights, false)
    }

    /// Set W, and make it the W₀ that leak, e-modification and projection pull to.
    fn warm_start(&mut self, weights: Any<'_, '_>) -> PyResult<()> {
        self.write_weights(weights, true)
    }

    /// The kernel form's dictionary in figures; None for any other compensator, and without one.
    ///
    /// atoms, capacity; merged: terms that went into an atom that was there; dropped: atoms that
    /// went because it was full; error_bound (n,): of |W - W_exact|, what both lost [rad/s²].
    #[getter]
    fn dictionary<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        self.tracked.dictionary(py)
    }

    /// Stop adapting; the weights stay in use.
    fn freeze(&mut self) -> PyResult<()> {
        self.tracked.set_frozen(true)
    }

    /// Adapt again.
    fn unfreeze(&mut self) -> PyResult<()> {
        self.tracked.set_frozen(false)
    }

    /// Whether adaptation is stopped.
    #[getter]
    fn frozen(&self) -> bool {
        self.tracked.frozen()
    }

    /// What the controller remembers, as bytes: versioned, checksummed, exact to the bit.
    fn __getstate__<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, &self.tracked.saved())
    }

    fn __setstate__(&mut self, bytes: Any<'_, '_>) -> PyResult<()> {
        let bytes =
            bytes.cast::<PyBytes>().map_err(|_| wrong_type("saved state", bytes, "bytes"))?;
        self.restore(bytes.as_bytes()).map_err(value_error)
    }

    /// Write what the controller remembers (weights, last torque, steps) to a file, which is
    /// replaced as a whole.
    fn save(slf: &Bound<'_, Self>, path: PathBuf) -> PyResult<()> {
        // Not borrowed while the disk is waited for: other threads may step it.
        let saved = slf.try_borrow()?.__getstate__(slf.py());
        saving::write(&path, &saved)
    }

    /// Read what `save` wrote; the next torques are then the same to the bit. Raises ValueError,
    /// with nothing changed, for a damaged file or one of another controller.
    fn load(slf: &Bound<'_, Self>, path: PathBuf) -> PyResult<()> {
        let bytes = saving::read(slf.py(), &path)?;
        slf.try_borrow_mut()?.restore(bytes.as_bytes()).map_err(|error| {
            let path = path.display();
            PyValueError::new_err(format!(
                "path: got {path}, wants a file of this controller ({error})"
            ))
        })
    }

    fn __reduce__<'py>(
        slf: &Bound<'py, Self>,
    ) -> PyResult<(Bound<'py, PyAny>, Py<PyAny>, Bound<'py, PyBytes>)> {
        let (arguments, state) = slf.try_borrow()?.parts(slf.py());
        Ok((slf.get_type().into_any(), arguments, state))
    }

    // As for a plant: no `__clear__`.
    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        visit.call(&self.arguments)
    }

    fn __repr__(&self) -> String {
        let [kp, kv] = self.tracked.gains();
        let compensator = self.tracked.compensator();
        format!("ComputedTorque(kp={kp:?}, kv={kv:?}, compensator: {compensator})")
    }
}

//! `ComputedTorque`: computed torque with a compensator.

use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::arm::PyArm;
use super::compensator::compensator_of;
use super::controller::PyController;
use super::convert::{Any, Array, Given, matrix_of};
use super::dispatch::{each, for_joints};
use super::form::Objects;
use super::tracked::{Arguments, Fronted, Limited, Trackers, front, said, tracker};
use crate::control::{Front, Gains};

/// The arguments of the class.
const NAMES: [&str; 11] = [
    "arm",
    "kp",
    "kv",
    "compensator",
    "effort_limit",
    "effort_rate_limit",
    "last_tau",
    "hand_over",
    "velocity_filter",
    "bumpless",
    "delay",
];

/// Computed torque for the nominal arm with a compensator (7), (11), (12), and its state.
///
/// ``tau = M₀ (v - ρ̂) + H₀`` with ``v = ddq_d - K_v de - K_p e``, ``e = q - q_d``. Where a joint
/// of ``arm`` is continuous, e is taken around the circle, -π <= e < π.
///
/// The object remembers its weights, its last torque, the number of its steps, and the period that
/// is going on. Pickled or saved and restored, its next torques are the same to the bit. What
/// remembers is equal to itself alone; ``copy.replace(tracker, kp=9.0)`` is another, before its
/// first step.
///
/// Parameters
/// ----------
/// arm: what the controller believes of the arm, with n joints.
/// kp: K_p [1/s²], scalar or (n,), > 0.
/// kv: K_v [1/s], scalar or (n,), > 0.
/// compensator: produces ρ̂; None for plain computed torque.
/// effort_limit: largest torque of each joint [N·m], scalar or (n,), > 0; None or inf for none.
/// effort_rate_limit: largest change of each torque [N·m/s], likewise; for `step` and sampled
///     simulations only. It counts from the torque commanded last.
/// last_tau: the torque that is on the robot when the controller takes over [N·m], scalar or (n,),
///     at most 1e10: what the rate limit of the first sample counts from. None: what holds ``arm``
///     at rest there.
/// hand_over, velocity_filter, bumpless, delay: what stands before the law; see `Controller`.
///
/// Raises
/// ------
/// NoStabilizingSolution
///     If (19) has no solution for these gains and the compensator's Q and γ.
/// ValueError, TypeError
///     Naming the parameter.
#[pyclass(name = "ComputedTorque", module = "steadyarm", extends = PyController)]
pub(super) struct PyComputedTorque;

/// Sets W, and with `prior` W₀ too.
fn write_weights(base: &mut PyController, weights: Any<'_, '_>, prior: bool) -> PyResult<()> {
    let rows = base.trackers.joints();
    each!(&mut base.trackers, Trackers, it => {
        let compensator = &it.controller.compensator;
        let weights = matrix_of(weights, "weights", rows, compensator.rules()?)?;
        compensator.check_weights(&weights, prior)?;
        compensator.set_weights(it.controller.settle(&mut it.state), &weights, prior)
    })
}

#[pymethods]
impl PyComputedTorque {
    #[new]
    #[pyo3(signature = (arm, kp, kv, compensator=None, effort_limit=None, effort_rate_limit=None,
        last_tau=None, hand_over=None, velocity_filter=None, bumpless=None, delay=None))]
    #[expect(clippy::too_many_arguments, reason = "a Python class")]
    fn new(
        py: Python<'_>,
        arm: Any<'_, '_>,
        kp: Any<'_, '_>,
        kv: Any<'_, '_>,
        compensator: Given<'_, '_>,
        effort_limit: Given<'_, '_>,
        effort_rate_limit: Given<'_, '_>,
        last_tau: Given<'_, '_>,
        hand_over: Given<'_, '_>,
        velocity_filter: Given<'_, '_>,
        bumpless: Given<'_, '_>,
        delay: Given<'_, '_>,
    ) -> PyResult<PyClassInitializer<Self>> {
        let limited = Limited { effort_limit, effort_rate_limit, last_tau };
        let fronted = Fronted { hand_over, velocity_filter, bumpless, delay };
        let given = Arguments { arm, kp, kv, compensator };
        let joints = PyArm::of(arm)?.joints();
        let trackers = for_joints!(joints, tracker(&given, &limited, &fronted))?;
        let (kp, kv) = each!(&trackers, Trackers, it => {
            let Gains { kp, kv } = &it.controller.law.computed()?.gains;
            (kp.to_vec(), kv.to_vec())
        });
        // Scalars of the compensator count for the joints of this arm.
        let compensator =
            compensator.map(|it| compensator_of(it)?.of_joints(joints)).transpose()?;
        let [effort, effort_rate, last_tau] = said(&trackers);
        let Front { hand_over, velocity_filter, bumpless, delay } = front(&trackers);
        let values = (
            arm,
            kp,
            kv,
            compensator,
            effort,
            effort_rate,
            last_tau,
            hand_over,
            velocity_filter,
            bumpless,
            delay,
        );
        let arguments = Objects::new(py, &NAMES, values)?;
        Ok(PyClassInitializer::from(PyController { arguments, trackers }).add_subclass(Self))
    }

    /// K_p [1/s²], (n,).
    #[getter]
    fn kp(slf: PyRef<'_, Self>) -> PyResult<Array<1>> {
        each!(&slf.as_super().trackers, Trackers, it => {
            Ok(it.controller.law.computed()?.gains.kp[..].into())
        })
    }

    /// K_v [1/s], (n,).
    #[getter]
    fn kv(slf: PyRef<'_, Self>) -> PyResult<Array<1>> {
        each!(&slf.as_super().trackers, Trackers, it => {
            Ok(it.controller.law.computed()?.gains.kv[..].into())
        })
    }

    /// The compensator, or None.
    #[getter]
    fn compensator<'py>(slf: PyRef<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.as_super().arguments.get(slf.py(), 3)
    }

    /// P of (19), (2n, 2n); None without a compensator.
    #[getter]
    #[pyo3(name = "P")]
    fn p(slf: PyRef<'_, Self>) -> Option<Array<2>> {
        let trackers = &slf.as_super().trackers;
        let p = each!(trackers, Trackers, it => it.p());
        p.map(|p| Array::rows(p, 2 * trackers.joints()))
    }

    /// W, (n, rules) (per_joint: the rules of one joint), a copy; None without a compensator.
    ///
    /// What the latest period taught is in it, as if the torque of `step` acted; the next step may
    /// still tell another one. Assign to set it: adaptation goes on from there, without a prior W₀.
    /// Raises ValueError for a wrong shape, entries that are not finite or beyond 1e150, or weights
    /// beyond the ``projection_radius``; TypeError without a compensator. With a ``dictionary``
    /// there is no such matrix: reading and setting raise TypeError.
    #[getter]
    fn weights(slf: PyRef<'_, Self>) -> PyResult<Option<Array<2>>> {
        if slf.as_super().arguments.get(slf.py(), 3)?.is_none() {
            return Ok(None);
        }
        each!(&slf.as_super().trackers, Trackers, it => {
            let compensator = &it.controller.compensator;
            let weights = compensator.weights(&it.ended())?;
            Ok(Some(Array::rows(weights, compensator.rules()?)))
        })
    }

    #[setter]
    fn set_weights(mut slf: PyRefMut<'_, Self>, weights: Any<'_, '_>) -> PyResult<()> {
        write_weights(slf.as_super(), weights, false)
    }

    /// Set W, and make it the W₀ that leak, e-modification and projection pull to.
    fn warm_start(mut slf: PyRefMut<'_, Self>, weights: Any<'_, '_>) -> PyResult<()> {
        write_weights(slf.as_super(), weights, true)
    }

    /// The kernel form in figures; None for a compensator without a dictionary.
    ///
    /// ``atoms`` of ``capacity`` states are in it. ``merged`` terms went into a state that was
    /// there; ``dropped`` states made room when it was full. ``error_bound`` (n,) bounds what all
    /// that lost, |W - W_exact| of each joint, and fades as W does. The error of ρ̂ [rad/s²] is at
    /// most |ξ| times that, with |ξ| <= 1 for a normalised basis.
    #[getter]
    fn dictionary<'py>(slf: PyRef<'py, Self>) -> PyResult<Option<Bound<'py, PyDict>>> {
        each!(&slf.as_super().trackers, Trackers, it => {
            it.controller.compensator.dictionary(slf.py(), &it.ended())
        })
    }
}

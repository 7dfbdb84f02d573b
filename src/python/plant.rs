//! `Plant`: what is really there.

use std::sync::Arc;

use pyo3::gc::PyVisit;
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use super::any_arm::AnyArm;
use super::arm::PyArm;
use super::convert::{
    Any, Array, Array1, Given, array1, finite_scalar, finite_vector, joints, scalar, wrong_type,
};
use super::dispatch::{by_joints, each, for_joints, same_joints};
use super::form::{Objects, PyForm, limits};
use super::sources::Source;
use crate::error::{finite, positive};
use crate::plant;
use crate::sim::{self, Motion};

/// A plant of `N` joints.
pub(super) type Plant<const N: usize> = plant::Plant<N, AnyArm<N>, Option<Source<N>>>;

by_joints! {
    /// A plant of any joint count.
    Plants of Plant
}

/// What is really there: ``M(q) ddq + H(q, dq) + s(q, dq) + τ_d = τ``, τ limited by actuators.
///
/// That is (6) with the `Serial.stops` of the arm, if it has any. Two are equal when arm, limits
/// and disturbance are; a callable is as Python says, mostly to itself alone.
///
/// Parameters
/// ----------
/// arm: the true arm.
/// disturbance: τ_d [N·m], which opposes τ: `Pulses`, `Noise`, `Wrench`; `Sines`, `Quintic`,
///     `Table` or `Waypoints` (their position is the torque); a callable ``(q, dq, t) -> (n,)``; or
///     a list of these, which add up; None for none.
/// effort_limit: what each actuator can give [N·m], scalar or (n,), > 0; None or inf for no limit.
/// changes: pairs (time [s], arm), times increasing: from then on another arm in the place of the
///     one before, such as one with a payload that is picked up, or with other friction. Position
///     and velocity go on. For sampled simulations only.
#[pyclass(name = "Plant", module = "steadyarm", frozen, extends = PyForm)]
pub(super) struct PyPlant {
    pub plants: Plants,
    arguments: Arc<Objects>,
}

#[pymethods]
impl PyPlant {
    #[new]
    #[pyo3(signature = (arm, disturbance=None, effort_limit=None, changes=None))]
    fn new(
        py: Python<'_>,
        arm: Any<'_, '_>,
        disturbance: Given<'_, '_>,
        effort_limit: Given<'_, '_>,
        changes: Given<'_, '_>,
    ) -> PyResult<PyClassInitializer<Self>> {
        let joints = PyArm::of(arm)?.joints();
        let changes = changes.map(pairs).transpose()?.filter(|pairs| !pairs.is_empty());
        let later = changes.as_deref().unwrap_or(&[]);
        let plants = for_joints!(joints, plant(arm, disturbance, effort_limit, later))?;
        let limit = each!(&plants, Plants, plant => limits(plant.effort_limit()));
        let names = &["arm", "disturbance", "effort_limit", "changes"];
        let changes = changes.map(|pairs| PyTuple::new(py, pairs)).transpose()?;
        let arguments = Arc::new(Objects::new(py, names, (arm, disturbance, limit, changes))?);
        Ok(PyForm::under(arguments.clone(), Self { plants, arguments }))
    }

    /// The true arm.
    #[getter]
    fn arm<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.arguments.get(py, 0)
    }

    /// τ_d as it was given.
    #[getter]
    fn disturbance<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.arguments.get(py, 1)
    }

    /// Pairs (time [s], arm) of what changes, or None.
    #[getter]
    fn changes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.arguments.get(py, 3)
    }

    /// Largest torque of each actuator [N·m], (n,); inf without a limit.
    #[getter]
    fn effort_limit(&self) -> Array<1> {
        each!(&self.plants, Plants, plant => plant.effort_limit()[..].into())
    }

    /// Move on by ``dt`` [s] from time ``t`` [s] under the held torque ``tau`` [N·m].
    ///
    /// As a sampled simulation does: one step of RK4, with friction and stops solved for where RK4
    /// would be unstable. Returns q [rad] and dq [rad/s] at t + dt.
    /// Raises ValueError naming what is not finite, and whatever a callable disturbance raises.
    fn step<'py>(
        &self,
        py: Python<'py>,
        q: Any<'_, 'py>,
        dq: Any<'_, 'py>,
        tau: Any<'_, 'py>,
        t: Any<'_, 'py>,
        dt: Any<'_, 'py>,
    ) -> PyResult<(Array1<'py>, Array1<'py>)> {
        each!(&self.plants, Plants, plant => step(py, plant, [q, dq, tau], t, dt))
    }

    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), pyo3::PyTraverseError> {
        each!(&self.plants, Plants, plant => {
            plant.disturbance.as_ref().map_or(Ok(()), |source| source.traverse(&visit))
        })
    }
}

/// A plant from the arguments of the class.
fn plant<const N: usize>(
    arm: Any<'_, '_>,
    disturbance: Given<'_, '_>,
    effort_limit: Given<'_, '_>,
    changes: &[(f64, Bound<'_, PyAny>)],
) -> PyResult<Plants>
where
    Plants: From<Plant<N>>,
{
    let arm: AnyArm<N> = PyArm::of(arm)?.any()?.clone();
    let disturbance = disturbance.map_or(Ok(None), |it| Source::disturbance(it, &arm))?;
    let mut plant: Plant<N> = plant::Plant::new(arm, disturbance);
    if let Some(limit) = effort_limit {
        plant = plant.with_effort_limit(joints(limit, "effort_limit")?)?;
    }
    for (i, (at, arm)) in changes.iter().enumerate() {
        let arm = PyArm::of(arm)?;
        same_joints("changes: arm", arm.joints(), N)?;
        let changed = plant.with_change(*at, arm.any()?.clone());
        plant = changed.map_err(|error| error.named("changes").at(i))?;
    }
    Ok(plant.into())
}

/// Pairs of a time and an arm.
fn pairs<'py>(changes: Any<'_, 'py>) -> PyResult<Vec<(f64, Bound<'py, PyAny>)>> {
    changes.extract().map_err(|_| wrong_type("changes", changes, "pairs (time, arm)"))
}

/// The motion (q, dq) after a step from (q, dq) under the held torque.
fn step<'py, const N: usize>(
    py: Python<'py>,
    plant: &Plant<N>,
    [q, dq, tau]: [Any<'_, 'py>; 3],
    t: Any<'_, 'py>,
    dt: Any<'_, 'py>,
) -> PyResult<(Array1<'py>, Array1<'py>)> {
    let motion = Motion { q: finite_vector(q, "q")?, dq: finite_vector(dq, "dq")? };
    let (tau, t) = (finite_vector(tau, "tau")?, finite_scalar(t, "t")?);
    let dt = scalar(dt, "dt")?;
    positive("dt", &[dt])?;
    let next = sim::hold_torque(plant, &motion, &tau, t, dt);
    if let Some(error) = plant.disturbance.as_ref().and_then(Source::raised) {
        return Err(error);
    }
    let motion = [next.q.as_slice(), next.dq.as_slice()].concat();
    finite("disturbance, tau or dt: next motion", &motion)?;
    Ok((array1(py, next.q.as_slice()), array1(py, next.dq.as_slice())))
}

//! A plant of any joint count: what `Plant` holds.

use core::any::Any as Type;

use pyo3::prelude::*;

use super::any_arm::AnyArm;
use super::convert::{Any, Array1, array1, finite_scalar, finite_vector, joints, scalar};
use super::sources::{AnyDisturbance, Callback};
use super::value_error;
use crate::error::{finite, positive};
use crate::plant;
use crate::sim::{self, Motion};

/// What is really there.
pub(super) trait Planted: Send + Sync {
    fn joints(&self) -> usize;

    /// Largest torque of each actuator [N·m].
    fn effort_limit(&self) -> &[f64];

    /// The motion (q, dq) after a step of RK4 from (q, dq) under the held torque.
    fn step<'py>(
        &self,
        py: Python<'py>,
        sample: [Any<'_, 'py>; 3],
        t: Any<'_, 'py>,
        dt: Any<'_, 'py>,
    ) -> PyResult<(Array1<'py>, Array1<'py>)>;

    /// The disturbance, if it is a Python function.
    fn callback(&self) -> Option<&Callback>;

    /// The [`Plant`] itself.
    fn as_any(&self) -> &dyn Type;
}

/// A plant of `N` joints.
pub(super) type Plant<const N: usize> = plant::Plant<N, AnyArm<N>, AnyDisturbance<N>>;

/// A plant from the arguments of the class `Plant`.
pub(super) fn planted<const N: usize>(
    arm: Any<'_, '_>,
    disturbance: Option<Any<'_, '_>>,
    effort_limit: Option<Any<'_, '_>>,
) -> PyResult<Box<dyn Planted>> {
    let disturbance = disturbance.map_or(Ok(AnyDisturbance::NONE), AnyDisturbance::new)?;
    let mut plant: Plant<N> = plant::Plant::new(AnyArm::new(arm)?, disturbance);
    if let Some(limit) = effort_limit {
        plant = plant.with_effort_limit(joints(limit, "effort_limit")?).map_err(value_error)?;
    }
    Ok(Box::new(plant))
}

impl<const N: usize> Planted for Plant<N> {
    fn joints(&self) -> usize {
        N
    }

    fn effort_limit(&self) -> &[f64] {
        plant::Plant::effort_limit(self)
    }

    fn step<'py>(
        &self,
        py: Python<'py>,
        [q, dq, tau]: [Any<'_, 'py>; 3],
        t: Any<'_, 'py>,
        dt: Any<'_, 'py>,
    ) -> PyResult<(Array1<'py>, Array1<'py>)> {
        let motion = Motion { q: finite_vector(q, "q")?, dq: finite_vector(dq, "dq")? };
        let (tau, t) = (finite_vector(tau, "tau")?, finite_scalar(t, "t")?);
        let dt = scalar(dt, "dt")?;
        positive("dt", &[dt]).map_err(value_error)?;
        let next = sim::hold_torque(self, &motion, &tau, t, dt);
        if let Some(error) = self.callback().and_then(Callback::raised) {
            return Err(error);
        }
        let motion = [next.q.as_slice(), next.dq.as_slice()].concat();
        finite("disturbance, tau or dt: next motion", &motion).map_err(value_error)?;
        Ok((array1(py, next.q.as_slice()), array1(py, next.dq.as_slice())))
    }

    fn callback(&self) -> Option<&Callback> {
        self.disturbance.callback()
    }

    fn as_any(&self) -> &dyn Type {
        self
    }
}

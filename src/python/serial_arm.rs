//! A serial arm of any joint count: what `Serial` holds.

use core::any::Any as Type;

use pyo3::prelude::*;

use super::convert::{Any, Array1, Array2, array1, finite_vector, owned1, owned2, square, written};
use super::{limits, value_error};
use crate::arm::{Arm, Inertia, Link, Perturbation, Pose, Serial};
use crate::design::Excess;
use crate::error::Result;
use crate::robot::Description;

/// The dynamics of a chain. The arguments are Python's, of shape (n,).
pub(super) trait SerialArm: Send + Sync {
    fn joints(&self) -> usize;
    fn links(&self) -> &[Link];

    /// The [`Serial`] itself.
    fn as_any(&self) -> &dyn Type;

    /// The links with a body fixed to the tip.
    fn with_payload(&self, payload: &Inertia) -> Result<Vec<Link>>;

    /// The links of a neighbour.
    fn perturb(&self, seed: u64, perturbation: &Perturbation) -> Result<Vec<Link>>;

    /// What a reference exceeds of the limits, looked at every dt up to the duration.
    fn check(
        &self,
        py: Python<'_>,
        reference: Any<'_, '_>,
        times: [f64; 2],
    ) -> PyResult<Vec<Excess>>;

    fn mass_matrix<'py>(&self, py: Python<'py>, q: Any<'_, 'py>) -> PyResult<Array2<'py>>;
    fn coriolis<'py>(
        &self,
        py: Python<'py>,
        q: Any<'_, 'py>,
        dq: Any<'_, 'py>,
    ) -> PyResult<Array2<'py>>;
    fn gravity<'py>(&self, py: Python<'py>, q: Any<'_, 'py>) -> PyResult<Array1<'py>>;
    fn friction<'py>(&self, py: Python<'py>, dq: Any<'_, 'py>) -> PyResult<Array1<'py>>;
    fn stops<'py>(
        &self,
        py: Python<'py>,
        q: Any<'_, 'py>,
        dq: Any<'_, 'py>,
    ) -> PyResult<Array1<'py>>;
    fn bias<'py>(
        &self,
        py: Python<'py>,
        q: Any<'_, 'py>,
        dq: Any<'_, 'py>,
    ) -> PyResult<Array1<'py>>;

    /// Of (q, dq, ddq).
    fn inverse_dynamics<'py>(
        &self,
        py: Python<'py>,
        motion: [Any<'_, 'py>; 3],
        out: Option<Any<'_, 'py>>,
    ) -> PyResult<Bound<'py, PyAny>>;

    /// Of (q, dq, tau).
    fn forward_dynamics<'py>(
        &self,
        py: Python<'py>,
        state: [Any<'_, 'py>; 3],
        out: Option<Any<'_, 'py>>,
    ) -> PyResult<Bound<'py, PyAny>>;

    /// Of (q, dq, dq_r, ddq_r).
    fn slotine_li<'py>(&self, py: Python<'py>, motion: [Any<'_, 'py>; 4]) -> PyResult<Array1<'py>>;

    /// Of (q, dq, ddq).
    fn regressor<'py>(&self, py: Python<'py>, motion: [Any<'_, 'py>; 3]) -> PyResult<Array2<'py>>;

    fn inertial_parameters<'py>(&self, py: Python<'py>) -> PyResult<Array1<'py>>;
    fn kinetic_energy(&self, q: Any<'_, '_>, dq: Any<'_, '_>) -> PyResult<f64>;
    fn potential_energy(&self, q: Any<'_, '_>) -> PyResult<f64>;
    fn pose(&self, q: Any<'_, '_>) -> PyResult<Pose>;
    fn link_poses(&self, q: Any<'_, '_>) -> PyResult<Vec<Pose>>;
    fn jacobian<'py>(&self, py: Python<'py>, q: Any<'_, 'py>) -> PyResult<Array2<'py>>;
}

/// The arm of a description.
pub(super) fn serial_arm<const N: usize>(
    description: &Description,
) -> PyResult<Box<dyn SerialArm>> {
    let arm: Serial<N> = description.arm().map_err(super::read_error)?;
    Ok(Box::new(arm))
}

impl<const N: usize> SerialArm for Serial<N> {
    fn joints(&self) -> usize {
        N
    }

    fn links(&self) -> &[Link] {
        Serial::links(self)
    }

    fn as_any(&self) -> &dyn Type {
        self
    }

    fn with_payload(&self, payload: &Inertia) -> Result<Vec<Link>> {
        Ok(Serial::with_payload(self, payload)?.links().to_vec())
    }

    fn perturb(&self, seed: u64, perturbation: &Perturbation) -> Result<Vec<Link>> {
        Ok(Serial::perturb(self, seed, perturbation)?.links().to_vec())
    }

    fn check(
        &self,
        py: Python<'_>,
        reference: Any<'_, '_>,
        times: [f64; 2],
    ) -> PyResult<Vec<Excess>> {
        limits::check(py, self, reference, times)
    }

    fn mass_matrix<'py>(&self, py: Python<'py>, q: Any<'_, 'py>) -> PyResult<Array2<'py>> {
        square(py, &Arm::mass_matrix(self, &finite_vector(q, "q")?))
    }

    fn coriolis<'py>(
        &self,
        py: Python<'py>,
        q: Any<'_, 'py>,
        dq: Any<'_, 'py>,
    ) -> PyResult<Array2<'py>> {
        square(py, &Arm::coriolis(self, &finite_vector(q, "q")?, &finite_vector(dq, "dq")?))
    }

    fn gravity<'py>(&self, py: Python<'py>, q: Any<'_, 'py>) -> PyResult<Array1<'py>> {
        Ok(array1(py, Arm::gravity(self, &finite_vector(q, "q")?).as_slice()))
    }

    fn friction<'py>(&self, py: Python<'py>, dq: Any<'_, 'py>) -> PyResult<Array1<'py>> {
        Ok(array1(py, Arm::friction(self, &finite_vector(dq, "dq")?).as_slice()))
    }

    fn stops<'py>(
        &self,
        py: Python<'py>,
        q: Any<'_, 'py>,
        dq: Any<'_, 'py>,
    ) -> PyResult<Array1<'py>> {
        let stops = Arm::stops(self, &finite_vector(q, "q")?, &finite_vector(dq, "dq")?);
        Ok(array1(py, stops.as_slice()))
    }

    fn bias<'py>(
        &self,
        py: Python<'py>,
        q: Any<'_, 'py>,
        dq: Any<'_, 'py>,
    ) -> PyResult<Array1<'py>> {
        let bias = Arm::bias(self, &finite_vector(q, "q")?, &finite_vector(dq, "dq")?);
        Ok(array1(py, bias.as_slice()))
    }

    fn inverse_dynamics<'py>(
        &self,
        py: Python<'py>,
        [q, dq, ddq]: [Any<'_, 'py>; 3],
        out: Option<Any<'_, 'py>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (q, dq, ddq) =
            (finite_vector(q, "q")?, finite_vector(dq, "dq")?, finite_vector(ddq, "ddq")?);
        written(py, Arm::inverse_dynamics(self, &q, &dq, &ddq).as_slice(), out)
    }

    fn forward_dynamics<'py>(
        &self,
        py: Python<'py>,
        [q, dq, tau]: [Any<'_, 'py>; 3],
        out: Option<Any<'_, 'py>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (q, dq, tau) =
            (finite_vector(q, "q")?, finite_vector(dq, "dq")?, finite_vector(tau, "tau")?);
        written(py, Arm::forward_dynamics(self, &q, &dq, &tau).as_slice(), out)
    }

    fn slotine_li<'py>(
        &self,
        py: Python<'py>,
        [q, dq, dq_r, ddq_r]: [Any<'_, 'py>; 4],
    ) -> PyResult<Array1<'py>> {
        let (q, dq) = (finite_vector(q, "q")?, finite_vector(dq, "dq")?);
        let (dq_r, ddq_r) = (finite_vector(dq_r, "dq_r")?, finite_vector(ddq_r, "ddq_r")?);
        Ok(array1(py, Serial::slotine_li(self, &q, &dq, &dq_r, &ddq_r).as_slice()))
    }

    fn regressor<'py>(
        &self,
        py: Python<'py>,
        [q, dq, ddq]: [Any<'_, 'py>; 3],
    ) -> PyResult<Array2<'py>> {
        let (q, dq, ddq) =
            (finite_vector(q, "q")?, finite_vector(dq, "dq")?, finite_vector(ddq, "ddq")?);
        let mut y = vec![0.0; 10 * N * N];
        Serial::regressor(self, &q, &dq, &ddq, &mut y).map_err(value_error)?;
        owned2(py, y, 10 * N)
    }

    fn inertial_parameters<'py>(&self, py: Python<'py>) -> PyResult<Array1<'py>> {
        let mut pi = vec![0.0; 10 * N];
        Serial::inertial_parameters(self, &mut pi).map_err(value_error)?;
        Ok(owned1(py, pi))
    }

    fn kinetic_energy(&self, q: Any<'_, '_>, dq: Any<'_, '_>) -> PyResult<f64> {
        Ok(Arm::kinetic_energy(self, &finite_vector(q, "q")?, &finite_vector(dq, "dq")?))
    }

    fn potential_energy(&self, q: Any<'_, '_>) -> PyResult<f64> {
        Ok(Serial::potential_energy(self, &finite_vector(q, "q")?))
    }

    fn pose(&self, q: Any<'_, '_>) -> PyResult<Pose> {
        Ok(Serial::pose(self, &finite_vector(q, "q")?))
    }

    fn link_poses(&self, q: Any<'_, '_>) -> PyResult<Vec<Pose>> {
        Ok(Serial::link_poses(self, &finite_vector(q, "q")?).to_vec())
    }

    fn jacobian<'py>(&self, py: Python<'py>, q: Any<'_, 'py>) -> PyResult<Array2<'py>> {
        let jacobian = Serial::jacobian(self, &finite_vector(q, "q")?);
        owned2(py, jacobian.transpose().as_slice().to_vec(), N)
    }
}

/// A pose as a 4 × 4 matrix, row-major.
pub(super) fn homogeneous(pose: &Pose) -> [f64; 16] {
    let (r, p) = (&pose.rotation, &pose.translation);
    std::array::from_fn(|i| match (i / 4, i % 4) {
        (3, 3) => 1.0,
        (3, _) => 0.0,
        (row, 3) => p[row],
        (row, column) => r[(row, column)],
    })
}

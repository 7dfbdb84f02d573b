//! `Arm`: what every arm can do.

use std::sync::Arc;

use pyo3::PyClass;
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use super::any_arm::{AnyArm, Arms};
use super::convert::{Any, Array, Given, finite_vector, object, written};
use super::dispatch::{each, of_joints, other_joints};
use super::form::{Form, New, PyForm};
use crate::arm::{Arm, Pose};

/// An arm of n joints, 1 to 12: the base class of `TwoLink` and `Serial`.
///
/// ``M(q) ddq + H(q, dq) + s(q, dq) = tau`` with ``H = C dq + G + f`` (6).
///
/// ``q`` [rad], ``dq`` [rad/s], ``ddq`` [rad/s²], ``tau`` [N·m]: (n,), finite; float64 arrays are
/// fastest. ``out``: a float64 array (n,) that is written to and returned. For a prismatic joint,
/// read m for rad and N for N·m.
#[pyclass(name = "Arm", module = "steadyarm", subclass, frozen, extends = PyForm)]
pub(super) struct PyArm {
    pub arms: Arms,
}

impl PyArm {
    /// A class of arms, above what it is made of.
    pub fn under<T>(settings: Arc<impl Form + 'static>, arms: Arms, class: T) -> New<T>
    where
        T: PyClass<BaseType = Self>,
    {
        New(PyForm::under(settings, Self { arms }).add_subclass(class))
    }

    /// The argument `arm`.
    pub fn of<'a>(arm: Any<'a, '_>) -> PyResult<&'a Self> {
        Ok(object::<Self>(arm, "arm", "a TwoLink or a Serial")?.get())
    }

    /// For what is made for `N` joints.
    pub fn any<const N: usize>(&self) -> PyResult<&AnyArm<N>> {
        let arm = each!(&self.arms, Arms, arm => of_joints(&**arm));
        arm.ok_or_else(|| other_joints("arm", self.joints(), N))
    }
}

#[pymethods]
impl PyArm {
    /// Number of joints n.
    #[getter]
    pub fn joints(&self) -> usize {
        self.arms.joints()
    }

    /// How the joints move, from the base on: "revolute", "continuous" or "prismatic".
    ///
    /// A continuous joint turns without an end, and positions a turn apart are the same. A tracker
    /// with this nominal arm takes its error around the circle, -π <= e < π.
    #[getter]
    fn joint_kinds<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        each!(&self.arms, Arms, arm => PyTuple::new(py, arm.joint_kinds().map(|kind| kind.name())))
    }

    /// M(q) [kg·m²], (n, n), symmetric positive definite.
    fn mass_matrix(&self, q: Any<'_, '_>) -> PyResult<Array<2>> {
        each!(&self.arms, Arms, arm => Ok(arm.mass_matrix(&finite_vector(q, "q")?).into()))
    }

    /// C(q, dq) [N·m·s], (n, n), by Christoffel symbols: dM/dt - 2C is skew-symmetric.
    fn coriolis(&self, q: Any<'_, '_>, dq: Any<'_, '_>) -> PyResult<Array<2>> {
        each!(&self.arms, Arms, arm => {
            Ok(arm.coriolis(&finite_vector(q, "q")?, &finite_vector(dq, "dq")?).into())
        })
    }

    /// G(q) [N·m], (n,).
    fn gravity(&self, q: Any<'_, '_>) -> PyResult<Array<1>> {
        each!(&self.arms, Arms, arm => Ok(arm.gravity(&finite_vector(q, "q")?).into()))
    }

    /// f(dq) [N·m], (n,): viscous, Coulomb and Stribeck friction.
    fn friction(&self, dq: Any<'_, '_>) -> PyResult<Array<1>> {
        each!(&self.arms, Arms, arm => Ok(arm.friction(&finite_vector(dq, "dq")?).into()))
    }

    /// s(q, dq) [N·m], (n,): what drives the joints on into the stops of `with_stops`.
    fn stops(&self, q: Any<'_, '_>, dq: Any<'_, '_>) -> PyResult<Array<1>> {
        each!(&self.arms, Arms, arm => {
            Ok(arm.stops(&finite_vector(q, "q")?, &finite_vector(dq, "dq")?).into())
        })
    }

    /// H(q, dq) = C dq + G + f [N·m], (n,), without stops; eq. (6).
    fn bias(&self, q: Any<'_, '_>, dq: Any<'_, '_>) -> PyResult<Array<1>> {
        each!(&self.arms, Arms, arm => {
            Ok(arm.bias(&finite_vector(q, "q")?, &finite_vector(dq, "dq")?).into())
        })
    }

    /// tau = M(q) ddq + H(q, dq) + s(q, dq) [N·m], (n,), written to ``out`` if it is given.
    #[inline]
    #[pyo3(signature = (q, dq, ddq, out=None))]
    fn inverse_dynamics<'py>(
        &self,
        py: Python<'py>,
        q: Any<'_, 'py>,
        dq: Any<'_, 'py>,
        ddq: Any<'_, 'py>,
        out: Given<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        each!(&self.arms, Arms, arm => {
            let (q, dq) = (finite_vector(q, "q")?, finite_vector(dq, "dq")?);
            let tau = arm.inverse_dynamics(&q, &dq, &finite_vector(ddq, "ddq")?);
            written(py, tau.as_slice(), out)
        })
    }

    /// ddq = M(q)⁻¹ (tau - H(q, dq) - s(q, dq)) [rad/s²], (n,), written to ``out`` if given.
    #[pyo3(signature = (q, dq, tau, out=None))]
    fn forward_dynamics<'py>(
        &self,
        py: Python<'py>,
        q: Any<'_, 'py>,
        dq: Any<'_, 'py>,
        tau: Any<'_, 'py>,
        out: Given<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        each!(&self.arms, Arms, arm => {
            let (q, dq) = (finite_vector(q, "q")?, finite_vector(dq, "dq")?);
            let ddq = arm.forward_dynamics(&q, &dq, &finite_vector(tau, "tau")?);
            written(py, ddq.as_slice(), out)
        })
    }

    /// dq' M(q) dq / 2 [J].
    fn kinetic_energy(&self, q: Any<'_, '_>, dq: Any<'_, '_>) -> PyResult<f64> {
        each!(&self.arms, Arms, arm => {
            Ok(arm.kinetic_energy(&finite_vector(q, "q")?, &finite_vector(dq, "dq")?))
        })
    }

    /// U(q) [J]; its gradient is G(q).
    fn potential_energy(&self, q: Any<'_, '_>) -> PyResult<f64> {
        each!(&self.arms, Arms, arm => Ok(arm.potential_energy(&finite_vector(q, "q")?)))
    }

    /// Pose of the tip in the base, (4, 4).
    fn pose(&self, q: Any<'_, '_>) -> PyResult<Array<2>> {
        let pose = each!(&self.arms, Arms, arm => arm.pose(&finite_vector(q, "q")?));
        Ok(Array::rows(homogeneous(&pose).to_vec(), 4))
    }

    /// Poses of the joints' frames in the base, (n, 4, 4); x is along the link in a TwoLink.
    fn link_poses(&self, q: Any<'_, '_>) -> PyResult<Array<3>> {
        let poses = each!(&self.arms, Arms, arm => arm.link_poses(&finite_vector(q, "q")?));
        Ok(Array::matrices(poses.iter().flat_map(homogeneous).collect(), 4))
    }
}

/// A pose as a 4 × 4 matrix, row-major.
fn homogeneous(pose: &Pose) -> [f64; 16] {
    let (r, p) = (&pose.rotation, &pose.translation);
    std::array::from_fn(|i| match (i / 4, i % 4) {
        (3, 3) => 1.0,
        (3, _) => 0.0,
        (row, 3) => p[row],
        (row, column) => r[(row, column)],
    })
}

//! `TwoLink`.

use pyo3::prelude::*;

use super::convert::{
    Any, Array1, Array2, Array3, array1, finite_vector, joints, matrices, owned2, renamed, scalar,
    scalar_or, square,
};
use super::serial_arm::homogeneous;
use super::value_error;
use crate::arm::{Arm, Friction, JointKind, TwoLink, TwoLinkParameters};

/// A planar arm of two links, in closed form (section 4 of the paper).
///
/// mass [kg], length [m], inertia about the centres of mass [kg·m²]: scalar or (2,), > 0. gravity
/// [m/s²]: 0 for an arm that lies flat. viscous [N·m·s/rad], coulomb [N·m], smoothing [rad/s]:
/// friction of the joints.
#[pyclass(name = "TwoLink", module = "steadyarm", frozen)]
pub(super) struct PyTwoLink {
    pub arm: TwoLink,
}

/// The constructor's arguments.
type Arguments = (Vec<f64>, Vec<f64>, Vec<f64>, f64, Vec<f64>, Vec<f64>, Vec<f64>);

/// The argument that a parameter of the core comes from.
fn argument(parameter: &'static str) -> &'static str {
    parameter.strip_prefix("friction.").unwrap_or(parameter)
}

/// Friction, where stated.
fn friction_of(
    viscous: Option<Any<'_, '_>>,
    coulomb: Option<Any<'_, '_>>,
    smoothing: Option<Any<'_, '_>>,
) -> PyResult<Friction<2>> {
    let mut friction = Friction::default();
    for (field, value, name) in [
        (&mut friction.viscous, viscous, "viscous"),
        (&mut friction.coulomb, coulomb, "coulomb"),
        (&mut friction.smoothing, smoothing, "smoothing"),
    ] {
        if let Some(value) = value {
            *field = joints(value, name)?;
        }
    }
    Ok(friction)
}

#[pymethods]
impl PyTwoLink {
    #[new]
    #[pyo3(
        signature = (mass, length, inertia, gravity=None, viscous=None, coulomb=None,
            smoothing=None)
    )]
    fn new(
        mass: Any<'_, '_>,
        length: Any<'_, '_>,
        inertia: Any<'_, '_>,
        gravity: Option<Any<'_, '_>>,
        viscous: Option<Any<'_, '_>>,
        coulomb: Option<Any<'_, '_>>,
        smoothing: Option<Any<'_, '_>>,
    ) -> PyResult<Self> {
        let friction = friction_of(viscous, coulomb, smoothing)?;
        let parameters = TwoLinkParameters {
            mass: joints(mass, "mass")?,
            length: joints(length, "length")?,
            inertia: joints(inertia, "inertia")?,
            gravity: scalar_or(gravity, 0.0, "gravity")?,
            friction,
        };
        let arm =
            TwoLink::new(parameters).map_err(|error| value_error(renamed(error, argument)))?;
        Ok(Self { arm })
    }

    /// The same arm with this friction in its joints, in place of what they had.
    #[pyo3(
        signature = (viscous=None, coulomb=None, smoothing=None),
        text_signature = "(self, viscous=0.0, coulomb=0.0, smoothing=0.01)"
    )]
    fn with_friction(
        &self,
        viscous: Option<Any<'_, '_>>,
        coulomb: Option<Any<'_, '_>>,
        smoothing: Option<Any<'_, '_>>,
    ) -> PyResult<Self> {
        let arm = self.arm.with_friction(friction_of(viscous, coulomb, smoothing)?);
        Ok(Self { arm: arm.map_err(|error| value_error(renamed(error, argument)))? })
    }

    /// The same arm under another gravity [m/s²]; 0 for an arm that lies flat.
    fn with_gravity(&self, gravity: Any<'_, '_>) -> PyResult<Self> {
        let arm = self.arm.with_gravity(scalar(gravity, "gravity")?);
        Ok(Self { arm: arm.map_err(value_error)? })
    }

    /// Number of joints, 2.
    #[getter]
    fn joints(&self) -> usize {
        2
    }

    /// How the joints move: both are revolute.
    #[getter]
    fn joint_kinds(&self) -> (&'static str, &'static str) {
        let kind = JointKind::Revolute.name();
        (kind, kind)
    }

    /// (mass, length, inertia, gravity, viscous, coulomb, smoothing), as the class takes them.
    #[getter]
    fn parameters(&self) -> Arguments {
        let TwoLinkParameters { mass, length, inertia, gravity, friction } = self.arm.parameters();
        let Friction { viscous, coulomb, smoothing } = friction;
        let list = |x: &[f64; 2]| x.to_vec();
        let rigid = (list(mass), list(length), list(inertia));
        (rigid.0, rigid.1, rigid.2, *gravity, list(viscous), list(coulomb), list(smoothing))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let arguments = slf.get().parameters().into_pyobject(slf.py())?;
        Ok((slf.get_type().into_any(), arguments.into_any()))
    }

    fn __repr__(&self) -> String {
        let TwoLinkParameters { mass, length, inertia, gravity, .. } = self.arm.parameters();
        format!("TwoLink(mass={mass:?}, length={length:?}, inertia={inertia:?}, gravity={gravity})")
    }

    /// M(q) [kg·m²], (2, 2), symmetric positive definite.
    fn mass_matrix<'py>(&self, py: Python<'py>, q: Any<'_, 'py>) -> PyResult<Array2<'py>> {
        square(py, &self.arm.mass_matrix(&finite_vector(q, "q")?))
    }

    /// C(q, dq) [N·m·s], (2, 2), by Christoffel symbols: dM/dt - 2C is skew-symmetric.
    fn coriolis<'py>(
        &self,
        py: Python<'py>,
        q: Any<'_, 'py>,
        dq: Any<'_, 'py>,
    ) -> PyResult<Array2<'py>> {
        square(py, &self.arm.coriolis(&finite_vector(q, "q")?, &finite_vector(dq, "dq")?))
    }

    /// G(q) [N·m], (2,).
    fn gravity<'py>(&self, py: Python<'py>, q: Any<'_, 'py>) -> PyResult<Array1<'py>> {
        Ok(array1(py, self.arm.gravity(&finite_vector(q, "q")?).as_slice()))
    }

    /// f(dq) = viscous dq + coulomb tanh(dq / smoothing) [N·m], (2,).
    fn friction<'py>(&self, py: Python<'py>, dq: Any<'_, 'py>) -> PyResult<Array1<'py>> {
        Ok(array1(py, self.arm.friction(&finite_vector(dq, "dq")?).as_slice()))
    }

    /// H(q, dq) = C dq + G + f [N·m], (2,); eq. 6.
    fn bias<'py>(
        &self,
        py: Python<'py>,
        q: Any<'_, 'py>,
        dq: Any<'_, 'py>,
    ) -> PyResult<Array1<'py>> {
        Ok(array1(py, self.arm.bias(&finite_vector(q, "q")?, &finite_vector(dq, "dq")?).as_slice()))
    }

    /// tau = M(q) ddq + H(q, dq) [N·m], (2,).
    fn inverse_dynamics<'py>(
        &self,
        py: Python<'py>,
        q: Any<'_, 'py>,
        dq: Any<'_, 'py>,
        ddq: Any<'_, 'py>,
    ) -> PyResult<Array1<'py>> {
        let (q, dq, ddq) =
            (finite_vector(q, "q")?, finite_vector(dq, "dq")?, finite_vector(ddq, "ddq")?);
        Ok(array1(py, self.arm.inverse_dynamics(&q, &dq, &ddq).as_slice()))
    }

    /// ddq = M(q)^-1 (tau - H(q, dq)) [rad/s²], (2,).
    fn forward_dynamics<'py>(
        &self,
        py: Python<'py>,
        q: Any<'_, 'py>,
        dq: Any<'_, 'py>,
        tau: Any<'_, 'py>,
    ) -> PyResult<Array1<'py>> {
        let (q, dq, tau) =
            (finite_vector(q, "q")?, finite_vector(dq, "dq")?, finite_vector(tau, "tau")?);
        Ok(array1(py, self.arm.forward_dynamics(&q, &dq, &tau).as_slice()))
    }

    /// dq' M(q) dq / 2 [J].
    fn kinetic_energy(&self, q: Any<'_, '_>, dq: Any<'_, '_>) -> PyResult<f64> {
        Ok(self.arm.kinetic_energy(&finite_vector(q, "q")?, &finite_vector(dq, "dq")?))
    }

    /// U(q) [J]; its gradient is G(q).
    fn potential_energy(&self, q: Any<'_, '_>) -> PyResult<f64> {
        Ok(self.arm.potential_energy(&finite_vector(q, "q")?))
    }

    /// Pose of the tip in the base, (4, 4).
    fn pose<'py>(&self, py: Python<'py>, q: Any<'_, 'py>) -> PyResult<Array2<'py>> {
        owned2(py, homogeneous(&self.arm.pose(&finite_vector(q, "q")?)).to_vec(), 4)
    }

    /// Poses of the joints' frames in the base, (2, 4, 4): x along the link.
    fn link_poses<'py>(&self, py: Python<'py>, q: Any<'_, 'py>) -> PyResult<Array3<'py>> {
        let poses = self.arm.link_poses(&finite_vector(q, "q")?);
        matrices(py, poses.iter().flat_map(homogeneous).collect(), 4)
    }
}

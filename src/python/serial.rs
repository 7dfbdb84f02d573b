//! `Serial`: any chain of up to eight joints, from a file, a table or the wheel.

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use super::convert::{Array1, Array2, Array3, matrices, owned1, owned2, renamed, scalar_or, whole};
use super::dispatch::for_joints;
use super::serial_arm::{SerialArm, serial_arm};
use super::serial_files::{self, dh_rows, moments, triple};
use super::{read_error, value_error};
use crate::arm::{Inertia, Perturbation, Pose};
use crate::math::Matrix;
use crate::robot::{Description, GRAVITY, UrdfOptions, shipped};

type Any<'a, 'py> = &'a Bound<'py, PyAny>;

/// A serial arm of 1 to 8 revolute and prismatic joints.
///
/// Made by from_urdf, from_dh, from_toml or shipped. Its methods are those of TwoLink, and more.
#[pyclass(name = "Serial", module = "steadyarm", frozen)]
pub(super) struct PySerial {
    description: Description,
    pub arm: Box<dyn SerialArm>,
}

impl PySerial {
    fn new(description: Description) -> PyResult<Self> {
        let arm = for_joints!(description.joints.len(), serial_arm(&description))?;
        Ok(Self { description, arm })
    }

    /// The same robot with other links.
    fn changed(&self, arm: Box<dyn SerialArm>) -> Self {
        let mut description = self.description.clone();
        for (joint, link) in description.joints.iter_mut().zip(arm.links()) {
            joint.link = *link;
        }
        Self { description, arm }
    }

    fn column<'py>(&self, py: Python<'py>, of: impl Fn(&crate::arm::Link) -> f64) -> Array1<'py> {
        owned1(py, self.arm.links().iter().map(of).collect())
    }
}

/// The argument of `with_payload` that a parameter of the core comes from.
fn payload(parameter: &'static str) -> &'static str {
    match parameter.strip_prefix("payload.") {
        Some("moments") => "inertia",
        Some(name) => name,
        None => parameter,
    }
}

#[pymethods]
impl PySerial {
    /// From a URDF: a path, or the text itself.
    #[staticmethod]
    #[pyo3(
        signature = (path_or_text, base=None, tip=None, gravity=None, *, masses=None,
            inertials=None),
        text_signature = "(path_or_text, base=None, tip=None, gravity=(0.0, 0.0, -9.81), *, \
            masses=None, inertials=None)"
    )]
    fn from_urdf(
        path_or_text: Any<'_, '_>,
        base: Option<String>,
        tip: Option<String>,
        gravity: Option<Any<'_, '_>>,
        masses: Option<Any<'_, '_>>,
        inertials: Option<Any<'_, '_>>,
    ) -> PyResult<Self> {
        let options = UrdfOptions {
            base,
            tip,
            gravity: gravity.map_or(Ok(GRAVITY), |value| triple(value, "gravity"))?,
            masses: serial_files::masses(masses)?,
            inertials: serial_files::inertials(inertials)?,
        };
        Self::new(serial_files::urdf(path_or_text, &options)?)
    }

    /// From a Denavit-Hartenberg table.
    #[staticmethod]
    #[pyo3(
        signature = (a, alpha, d, theta_offset=None, *, convention=None, kind=None, mass=None, com=None, inertia=None,
            viscous=None, coulomb=None, armature=None, gravity=None, name="arm"),
        text_signature = "(a, alpha, d, theta_offset=0.0, *, convention='standard', kind='revolute', mass=0.0, \
            com=0.0, inertia=0.0, viscous=0.0, coulomb=0.0, armature=0.0, gravity=(0.0, 0.0, -9.81), name='arm')"
    )]
    #[expect(clippy::too_many_arguments, reason = "columns of a table")]
    fn from_dh(
        a: Any<'_, '_>,
        alpha: Any<'_, '_>,
        d: Any<'_, '_>,
        theta_offset: Option<Any<'_, '_>>,
        convention: Option<Any<'_, '_>>,
        kind: Option<Any<'_, '_>>,
        mass: Option<Any<'_, '_>>,
        com: Option<Any<'_, '_>>,
        inertia: Option<Any<'_, '_>>,
        viscous: Option<Any<'_, '_>>,
        coulomb: Option<Any<'_, '_>>,
        armature: Option<Any<'_, '_>>,
        gravity: Option<Any<'_, '_>>,
        name: &str,
    ) -> PyResult<Self> {
        let gravity = gravity.map_or(Ok(GRAVITY), |value| triple(value, "gravity"))?;
        let columns = serial_files::Columns {
            lengths: [Some(a), Some(alpha), Some(d), theta_offset],
            kind,
            mass,
            com,
            inertia,
            joint: [viscous, coulomb, armature],
        };
        let (rows, convention) = (dh_rows(&columns)?, serial_files::convention(convention)?);
        let description = Description::from_dh(name, &rows, convention, gravity);
        Self::new(description.map_err(read_error)?)
    }

    /// From our own TOML: a path, or the text itself.
    #[staticmethod]
    fn from_toml(path_or_text: Any<'_, '_>) -> PyResult<Self> {
        Self::new(serial_files::toml(path_or_text)?)
    }

    /// One of the arms that come with the wheel, by name.
    #[staticmethod]
    #[pyo3(name = "shipped")]
    fn from_wheel(name: &str) -> PyResult<Self> {
        Self::new(shipped(name).map_err(read_error)?)
    }

    /// The arm as TOML; from_toml gives it back, bit for bit.
    fn to_toml(&self) -> String {
        self.description.to_toml()
    }

    /// The same arm with no friction in any joint.
    fn without_friction(&self) -> Self {
        self.changed(self.arm.without_friction())
    }

    /// The same arm with stops at the ends of its joints' ranges, where `limits` are finite: δ beyond an end, they push back
    /// with max(0, stiffness δ (1 + dissipation dδ/dt)).
    #[pyo3(signature = (stiffness, dissipation=None), text_signature = "(self, stiffness, dissipation=1.0)")]
    fn with_stops(
        &self,
        stiffness: Any<'_, '_>,
        dissipation: Option<Any<'_, '_>>,
    ) -> PyResult<Self> {
        Ok(self.changed(self.arm.with_stops(stiffness, dissipation)?))
    }

    /// The same arm with a body fixed to its tip: mass [kg], com [m] and inertia [kg·m²] about it in the tip's frame.
    #[pyo3(signature = (mass, com=None, inertia=None), text_signature = "(self, mass, com=(0.0, 0.0, 0.0), inertia=0.0)")]
    fn with_payload(
        &self,
        mass: Any<'_, '_>,
        com: Option<Any<'_, '_>>,
        inertia: Option<Any<'_, '_>>,
    ) -> PyResult<Self> {
        let com = com.map_or(Ok([0.0; 3]), |value| triple(value, "com"))?.into();
        let moments =
            inertia.map_or(Ok(Matrix::<3>::zeros()), |value| moments(value, "inertia"))?;
        let mass = super::convert::scalar(mass, "mass")?;
        let body = Inertia { mass, com, moments };
        let arm =
            self.arm.with_payload(&body).map_err(|error| value_error(renamed(error, payload)))?;
        Ok(self.changed(arm))
    }

    /// A neighbour, the same for the same seed: masses, moments and friction off by these shares, centres of mass by `com` [m].
    #[pyo3(
        signature = (seed, mass=None, com=None, inertia=None, friction=None),
        text_signature = "(self, seed, mass=0.2, com=0.01, inertia=0.2, friction=0.2)"
    )]
    fn perturb(
        &self,
        seed: Any<'_, '_>,
        mass: Option<Any<'_, '_>>,
        com: Option<Any<'_, '_>>,
        inertia: Option<Any<'_, '_>>,
        friction: Option<Any<'_, '_>>,
    ) -> PyResult<Self> {
        let perturbation = Perturbation {
            mass: scalar_or(mass, 0.2, "mass")?,
            com: scalar_or(com, 0.01, "com")?,
            inertia: scalar_or(inertia, 0.2, "inertia")?,
            friction: scalar_or(friction, 0.2, "friction")?,
        };
        let arm = self.arm.perturb(whole(seed, "seed")?, &perturbation).map_err(value_error)?;
        Ok(self.changed(arm))
    }

    /// Number of joints.
    #[getter]
    fn joints(&self) -> usize {
        self.arm.joints()
    }

    /// What the robot is called.
    #[getter]
    fn name(&self) -> &str {
        &self.description.name
    }

    /// Names of the joints, from the base on.
    #[getter]
    fn joint_names(&self) -> Vec<&str> {
        self.description.joints.iter().map(|joint| joint.name.as_str()).collect()
    }

    /// Names of the links that they move.
    #[getter]
    fn link_names(&self) -> Vec<&str> {
        self.description.joints.iter().map(|joint| joint.link_name.as_str()).collect()
    }

    /// How the joints move: "revolute", "continuous" (its error is taken around the circle) or "prismatic".
    #[getter]
    fn joint_kinds<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, self.arm.links().iter().map(|link| link.kind.name()))
    }

    /// What the file says that was not used.
    #[getter]
    fn notes(&self) -> Vec<&str> {
        self.description.notes.iter().map(String::as_str).collect()
    }

    /// Limits of the joints, (n,) each, infinite for none: lower, upper [rad or m], velocity [rad/s or m/s], effort
    /// [N·m or N].
    #[getter]
    fn limits<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        dict.set_item("lower", self.column(py, |link| link.limits.lower))?;
        dict.set_item("upper", self.column(py, |link| link.limits.upper))?;
        dict.set_item("velocity", self.column(py, |link| link.limits.velocity))?;
        dict.set_item("effort", self.column(py, |link| link.limits.effort))?;
        Ok(dict)
    }

    /// M(q) [kg·m²], (n, n), symmetric positive definite.
    fn mass_matrix<'py>(&self, py: Python<'py>, q: Any<'_, 'py>) -> PyResult<Array2<'py>> {
        self.arm.mass_matrix(py, q)
    }

    /// C(q, dq) [N·m·s], (n, n), by Christoffel symbols: dM/dt - 2C is skew-symmetric.
    fn coriolis<'py>(
        &self,
        py: Python<'py>,
        q: Any<'_, 'py>,
        dq: Any<'_, 'py>,
    ) -> PyResult<Array2<'py>> {
        self.arm.coriolis(py, q, dq)
    }

    /// G(q) [N·m], (n,).
    fn gravity<'py>(&self, py: Python<'py>, q: Any<'_, 'py>) -> PyResult<Array1<'py>> {
        self.arm.gravity(py, q)
    }

    /// f(dq) [N·m], (n,).
    fn friction<'py>(&self, py: Python<'py>, dq: Any<'_, 'py>) -> PyResult<Array1<'py>> {
        self.arm.friction(py, dq)
    }

    /// s(q, dq) [N·m], (n,): what drives the joints on into their stops; part of inverse and forward dynamics.
    fn stops<'py>(
        &self,
        py: Python<'py>,
        q: Any<'_, 'py>,
        dq: Any<'_, 'py>,
    ) -> PyResult<Array1<'py>> {
        self.arm.stops(py, q, dq)
    }

    /// H(q, dq) = C dq + G + f [N·m], (n,), without stops; eq. 6.
    fn bias<'py>(
        &self,
        py: Python<'py>,
        q: Any<'_, 'py>,
        dq: Any<'_, 'py>,
    ) -> PyResult<Array1<'py>> {
        self.arm.bias(py, q, dq)
    }

    /// tau = M(q) ddq + H(q, dq) + s(q, dq) [N·m], (n,), written to `out` if it is given.
    #[inline]
    #[pyo3(signature = (q, dq, ddq, out=None))]
    fn inverse_dynamics<'py>(
        &self,
        py: Python<'py>,
        q: Any<'_, 'py>,
        dq: Any<'_, 'py>,
        ddq: Any<'_, 'py>,
        out: Option<Any<'_, 'py>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.arm.inverse_dynamics(py, [q, dq, ddq], out)
    }

    /// ddq = M(q)^-1 (tau - H(q, dq) - s(q, dq)) [rad/s²], (n,), written to `out` if it is given.
    #[pyo3(signature = (q, dq, tau, out=None))]
    fn forward_dynamics<'py>(
        &self,
        py: Python<'py>,
        q: Any<'_, 'py>,
        dq: Any<'_, 'py>,
        tau: Any<'_, 'py>,
        out: Option<Any<'_, 'py>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.arm.forward_dynamics(py, [q, dq, tau], out)
    }

    /// M ddq_r + C(q, dq) dq_r + G [N·m], (n,), without friction and stops.
    fn slotine_li<'py>(
        &self,
        py: Python<'py>,
        q: Any<'_, 'py>,
        dq: Any<'_, 'py>,
        dq_r: Any<'_, 'py>,
        ddq_r: Any<'_, 'py>,
    ) -> PyResult<Array1<'py>> {
        self.arm.slotine_li(py, [q, dq, dq_r, ddq_r])
    }

    /// Y(q, dq, ddq), (n, 10n): Y times the inertial parameters is the torque without friction, stops and armature.
    fn regressor<'py>(
        &self,
        py: Python<'py>,
        q: Any<'_, 'py>,
        dq: Any<'_, 'py>,
        ddq: Any<'_, 'py>,
    ) -> PyResult<Array2<'py>> {
        self.arm.regressor(py, [q, dq, ddq])
    }

    /// π, (10n,): m, m c, and the moments xx, xy, yy, xz, yz, zz about the frame's origin, link after link.
    fn inertial_parameters<'py>(&self, py: Python<'py>) -> PyResult<Array1<'py>> {
        self.arm.inertial_parameters(py)
    }

    /// dq' M(q) dq / 2 [J].
    fn kinetic_energy(&self, q: Any<'_, '_>, dq: Any<'_, '_>) -> PyResult<f64> {
        self.arm.kinetic_energy(q, dq)
    }

    /// U(q) [J]; its gradient is G(q).
    fn potential_energy(&self, q: Any<'_, '_>) -> PyResult<f64> {
        self.arm.potential_energy(q)
    }

    /// Pose of the tip in the base, (4, 4).
    fn pose<'py>(&self, py: Python<'py>, q: Any<'_, 'py>) -> PyResult<Array2<'py>> {
        owned2(py, homogeneous(&self.arm.pose(q)?).to_vec(), 4)
    }

    /// Poses of the joints' frames in the base, (n, 4, 4).
    fn link_poses<'py>(&self, py: Python<'py>, q: Any<'_, 'py>) -> PyResult<Array3<'py>> {
        matrices(py, self.arm.link_poses(q)?.iter().flat_map(homogeneous).collect(), 4)
    }

    /// Jacobian of the tip in the axes of the base, (6, n): dq to its velocity [m/s] and angular velocity [rad/s].
    fn jacobian<'py>(&self, py: Python<'py>, q: Any<'_, 'py>) -> PyResult<Array2<'py>> {
        self.arm.jacobian(py, q)
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, (String,))> {
        Ok((slf.get_type().getattr("from_toml")?, (slf.get().to_toml(),)))
    }

    fn __repr__(&self) -> String {
        format!("Serial({:?}, {} joints)", self.description.name, self.arm.joints())
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

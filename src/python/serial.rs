//! `Serial`: any chain, from a file, a table or the wheel.

use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::any_arm::{AnyArm, Arms};
use super::arm::{New, PyArm};
use super::convert::{Any, Array1, Array2, Given, array1, finite_vector, owned1, owned2};
use super::dispatch::{by_joints, each, for_joints};
use super::errors::{read_error, value_error};
use super::limits::PyExcess;
use super::serial_files::{self, triple};
use crate::arm::{JointFriction, Link, Serial};
use crate::robot::{Description, UrdfOptions, shipped};

/// A serial arm of 1 to 12 revolute and prismatic joints.
///
/// Made by from_urdf, from_dh, from_toml or shipped. Its methods are those of Arm, and more.
#[pyclass(name = "Serial", extends = PyArm, module = "steadyarm", frozen)]
pub(super) struct PySerial {
    pub description: Description,
    pub chain: Chains,
}

by_joints! {
    /// A chain of any joint count.
    Chains of Serial
}

impl PySerial {
    pub fn new(description: Description) -> PyResult<New<Self>> {
        let (chain, arms) = for_joints!(description.joints.len(), chain(&description))?;
        Ok(New(PyClassInitializer::from(PyArm { arms }).add_subclass(Self { description, chain })))
    }

    pub fn links(&self) -> &[Link] {
        each!(&self.chain, Chains, chain => chain.links())
    }

    fn column<'py>(&self, py: Python<'py>, of: impl Fn(&Link) -> f64) -> Array1<'py> {
        owned1(py, self.links().iter().map(of).collect())
    }
}

/// The chain of a description, also as any arm.
fn chain<const N: usize>(description: &Description) -> PyResult<(Chains, Arms)>
where
    Chains: From<Serial<N>>,
    Arms: From<AnyArm<N>>,
{
    let chain: Serial<N> = description.arm().map_err(read_error)?;
    Ok((chain.into(), AnyArm::Serial(Box::new(chain)).into()))
}

#[pymethods]
impl PySerial {
    /// From a URDF: a path, or the text itself.
    #[staticmethod]
    #[pyo3(
        signature = (path_or_text, base=None, tip=None, gravity=None, *, masses=None,
            inertials=None, unphysical=None),
        text_signature = "(path_or_text, base=None, tip=None, gravity=(0.0, 0.0, -9.81), *, \
            masses=None, inertials=None, unphysical='refuse')"
    )]
    fn from_urdf(
        path_or_text: Any<'_, '_>,
        base: Option<String>,
        tip: Option<String>,
        gravity: Given<'_, '_>,
        masses: Given<'_, '_>,
        inertials: Given<'_, '_>,
        unphysical: Given<'_, '_>,
    ) -> PyResult<New<Self>> {
        let options = UrdfOptions {
            base,
            tip,
            gravity: serial_files::gravity(gravity)?,
            masses: serial_files::masses(masses)?,
            inertials: serial_files::inertials(inertials)?,
            unphysical: serial_files::unphysical(unphysical)?.unwrap_or_default(),
        };
        Self::new(serial_files::urdf(path_or_text, &options)?)
    }

    /// From a Denavit-Hartenberg table.
    #[staticmethod]
    #[pyo3(
        signature = (a, alpha, d, theta_offset=None, *, convention=None, kind=None, mass=None,
            com=None, inertia=None, viscous=None, coulomb=None, armature=None, gravity=None,
            name="arm", unphysical=None),
        text_signature = "(a, alpha, d, theta_offset=0.0, *, convention='standard', \
            kind='revolute', mass=0.0, com=0.0, inertia=0.0, viscous=0.0, coulomb=0.0, \
            armature=0.0, gravity=(0.0, 0.0, -9.81), name='arm', unphysical='refuse')"
    )]
    #[expect(clippy::too_many_arguments, reason = "columns of a table")]
    fn from_dh(
        a: Any<'_, '_>,
        alpha: Any<'_, '_>,
        d: Any<'_, '_>,
        theta_offset: Given<'_, '_>,
        convention: Given<'_, '_>,
        kind: Given<'_, '_>,
        mass: Given<'_, '_>,
        com: Given<'_, '_>,
        inertia: Given<'_, '_>,
        viscous: Given<'_, '_>,
        coulomb: Given<'_, '_>,
        armature: Given<'_, '_>,
        gravity: Given<'_, '_>,
        name: &str,
        unphysical: Given<'_, '_>,
    ) -> PyResult<New<Self>> {
        let columns = serial_files::Columns {
            lengths: [Some(a), Some(alpha), Some(d), theta_offset],
            kind,
            mass,
            com,
            inertia,
            joint: [viscous, coulomb, armature],
        };
        Self::new(serial_files::dh(&columns, convention, gravity, name, unphysical)?)
    }

    /// From our own TOML: a path, or the text itself.
    #[staticmethod]
    #[pyo3(signature = (path_or_text, *, unphysical=None))]
    fn from_toml(path_or_text: Any<'_, '_>, unphysical: Given<'_, '_>) -> PyResult<New<Self>> {
        Self::new(serial_files::toml(path_or_text, unphysical)?)
    }

    /// One of the arms that come with the wheel, by name.
    #[staticmethod]
    #[pyo3(name = "shipped")]
    fn from_wheel(name: &str) -> PyResult<New<Self>> {
        Self::new(shipped(name).map_err(read_error)?)
    }

    /// The arm as TOML; from_toml gives it back, bit for bit.
    fn to_toml(&self) -> String {
        self.description.to_toml()
    }

    /// The same arm with no friction in any joint.
    fn without_friction(&self) -> PyResult<New<Self>> {
        self.each(|_, link| link.friction = JointFriction::default())
    }

    /// The same arm with this friction in its joints, in place of what they had: scalars or (n,).
    #[pyo3(
        signature = (viscous=None, coulomb=None, stribeck=None, stribeck_speed=None,
            smoothing=None),
        text_signature = "(self, viscous=0.0, coulomb=0.0, stribeck=0.0, stribeck_speed=0.1, \
            smoothing=0.01)"
    )]
    fn with_friction(
        &self,
        viscous: Given<'_, '_>,
        coulomb: Given<'_, '_>,
        stribeck: Given<'_, '_>,
        stribeck_speed: Given<'_, '_>,
        smoothing: Given<'_, '_>,
    ) -> PyResult<New<Self>> {
        self.rubbing([viscous, coulomb, stribeck, stribeck_speed, smoothing])
    }

    /// The same arm with rotors of this inertia, seen through their gears: a scalar or (n,).
    fn with_armature(&self, armature: Any<'_, '_>) -> PyResult<New<Self>> {
        self.geared(armature)
    }

    /// The same arm under another gravity, (3,) in the axes of the base.
    fn with_gravity(&self, gravity: Any<'_, '_>) -> PyResult<New<Self>> {
        let gravity = triple(gravity, "gravity")?;
        Self::new(Description { gravity, ..self.description.clone() })
    }

    /// The same arm with other inertial parameters, (10n,): the way back from inertial_parameters.
    fn with_parameters(&self, parameters: Any<'_, '_>) -> PyResult<New<Self>> {
        self.identified(parameters)
    }

    /// The same arm with stops δ beyond its `limits`: max(0, stiffness δ (1 + dissipation dδ/dt)).
    #[pyo3(
        signature = (stiffness, dissipation=None),
        text_signature = "(self, stiffness, dissipation=1.0)"
    )]
    fn with_stops(
        &self,
        stiffness: Any<'_, '_>,
        dissipation: Given<'_, '_>,
    ) -> PyResult<New<Self>> {
        self.stopped(stiffness, dissipation)
    }

    /// The same arm with a body at its tip: mass [kg], com [m], inertia [kg·m²], in its frame.
    #[pyo3(
        signature = (mass, com=None, inertia=None),
        text_signature = "(self, mass, com=(0.0, 0.0, 0.0), inertia=0.0)"
    )]
    fn with_payload(
        &self,
        mass: Any<'_, '_>,
        com: Given<'_, '_>,
        inertia: Given<'_, '_>,
    ) -> PyResult<New<Self>> {
        self.loaded(mass, com, inertia)
    }

    /// A neighbour, the same for one seed: all off by these shares, centres of mass by `com` [m].
    #[pyo3(
        signature = (seed, mass=None, com=None, inertia=None, friction=None),
        text_signature = "(self, seed, mass=0.2, com=0.01, inertia=0.2, friction=0.2)"
    )]
    fn perturb(
        &self,
        seed: Any<'_, '_>,
        mass: Given<'_, '_>,
        com: Given<'_, '_>,
        inertia: Given<'_, '_>,
        friction: Given<'_, '_>,
    ) -> PyResult<New<Self>> {
        self.neighbour(seed, [mass, com, inertia, friction])
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

    /// What the file says that was not used.
    #[getter]
    fn notes(&self) -> Vec<&str> {
        self.description.notes.iter().map(String::as_str).collect()
    }

    /// What is done about links that no body is: "refuse", "note" or "nearest".
    #[getter]
    fn unphysical(&self) -> &str {
        self.description.unphysical.name()
    }

    /// What a reference exceeds of these limits, at every `dt` from 0 to `duration` [s]: a list.
    #[pyo3(
        signature = (reference, duration, dt=None),
        text_signature = "(self, reference, duration, dt=0.001)"
    )]
    fn check(
        &self,
        py: Python<'_>,
        reference: Any<'_, '_>,
        duration: Any<'_, '_>,
        dt: Given<'_, '_>,
    ) -> PyResult<Vec<PyExcess>> {
        self.excesses(py, reference, duration, dt)
    }

    /// Limits, (n,) each, infinite for none: lower, upper [rad], velocity [rad/s], effort [N·m].
    #[getter]
    fn limits<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        dict.set_item("lower", self.column(py, |link| link.limits.lower))?;
        dict.set_item("upper", self.column(py, |link| link.limits.upper))?;
        dict.set_item("velocity", self.column(py, |link| link.limits.velocity))?;
        dict.set_item("effort", self.column(py, |link| link.limits.effort))?;
        Ok(dict)
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
        each!(&self.chain, Chains, chain => {
            let (q, dq) = (finite_vector(q, "q")?, finite_vector(dq, "dq")?);
            let (dq_r, ddq_r) = (finite_vector(dq_r, "dq_r")?, finite_vector(ddq_r, "ddq_r")?);
            Ok(array1(py, chain.slotine_li(&q, &dq, &dq_r, &ddq_r).as_slice()))
        })
    }

    /// Y(q, dq, ddq), (n, 10n): Y π is the torque without friction, stops and armature.
    fn regressor<'py>(
        &self,
        py: Python<'py>,
        q: Any<'_, 'py>,
        dq: Any<'_, 'py>,
        ddq: Any<'_, 'py>,
    ) -> PyResult<Array2<'py>> {
        let width = 10 * self.chain.joints();
        let mut y = vec![0.0; width * self.chain.joints()];
        each!(&self.chain, Chains, chain => {
            let (q, dq) = (finite_vector(q, "q")?, finite_vector(dq, "dq")?);
            chain.regressor(&q, &dq, &finite_vector(ddq, "ddq")?, &mut y).map_err(value_error)?;
        });
        owned2(py, y, width)
    }

    /// π, (10n,), link after link: m, m c, moments xx, xy, yy, xz, yz, zz about the frame's origin.
    fn inertial_parameters<'py>(&self, py: Python<'py>) -> PyResult<Array1<'py>> {
        let mut pi = vec![0.0; 10 * self.chain.joints()];
        each!(&self.chain, Chains, chain => chain.inertial_parameters(&mut pi))
            .map_err(value_error)?;
        Ok(owned1(py, pi))
    }

    /// Jacobian of the tip in the base's axes, (6, n): dq to its velocity and angular velocity.
    fn jacobian<'py>(&self, py: Python<'py>, q: Any<'_, 'py>) -> PyResult<Array2<'py>> {
        each!(&self.chain, Chains, chain => {
            let jacobian = chain.jacobian(&finite_vector(q, "q")?);
            owned2(py, jacobian.transpose().as_slice().to_vec(), self.chain.joints())
        })
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, (String,))> {
        Ok((slf.get_type().getattr("from_toml")?, (slf.get().to_toml(),)))
    }

    fn __repr__(&self) -> String {
        format!("Serial({:?}, {} joints)", self.description.name, self.chain.joints())
    }
}

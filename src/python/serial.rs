//! `Serial`: any chain, from a file, a table or the wheel.

use std::sync::Arc;

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::any_arm::{Chains, chain};
use super::arm::PyArm;
use super::convert::{Any, Array, Given, columns, finite_vector};
use super::dispatch::{each, for_joints};
use super::form::{Fields, New};
use super::limits::PyExcess;
use super::serial_files::{self, triple};
use crate::arm::{JointFriction, Link};
use crate::robot::{Description, UrdfOptions, shipped};

/// A serial arm of 1 to 12 revolute and prismatic joints on a fixed base.
///
/// Made by `from_urdf`, `from_dh`, `from_toml` or `shipped`. Pickles by its TOML, bit for bit, and
/// two are equal when all that it says is. `with_payload` and the like are copies with changes.
///
/// Raises
/// ------
/// ValueError, TypeError
///     Naming the argument; for a description with the line, what it got and what it wants.
/// OSError
///     For a file that cannot be opened.
#[pyclass(name = "Serial", extends = PyArm, module = "steadyarm", frozen)]
pub(super) struct PySerial {
    pub description: Arc<Description>,
    pub chain: Chains,
}

impl PySerial {
    pub fn new(description: Description) -> PyResult<New<Self>> {
        let (chain, arms) = for_joints!(description.joints.len(), chain(&description))?;
        let description = Arc::new(description);
        Ok(PyArm::under(description.clone(), arms, Self { description, chain }))
    }

    pub fn links(&self) -> &[Link] {
        each!(&self.chain, Chains, chain => chain.links())
    }
}

impl Fields for Description {
    fn fields<'py>(&self, _: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        Err(PyTypeError::new_err(
            "Serial: an arm from a file has no arguments to replace, wants with_payload, \
             with_friction, with_gravity, with_armature, with_stops or with_parameters",
        ))
    }
}

#[pymethods]
impl PySerial {
    /// Read the chain from link ``base`` (default: the root) to link ``tip`` (the only end).
    ///
    /// A string that starts with ``<`` is the text itself. Fixed joints are merged; other joints
    /// are held at 0. ``gravity`` [m/s²] is in the axes of the file's root, even if ``base`` is
    /// turned against it. Faults outside the chain do not matter. What was not used, or looks odd,
    /// stands in `notes`. Expand a file with macros first: ``pip install xacrodoc`` and
    /// ``xacrodoc robot.urdf.xacro -o robot.urdf``.
    ///
    /// ``masses``: {link: kg}, in place of those that the file states. Centres of mass stay, and
    /// moments are scaled with the mass. Where the file states no mass, the body is uniform in the
    /// shape of ``<collision>``, or else of ``<visual>``, if that is of boxes, cylinders and balls.
    /// Meshes are not opened.
    ///
    /// ``inertials``: {link: (mass [kg], com [m], moments [kg·m²])} in the link's frame, in place
    /// of what the file states, if it states any. com is (3,); moments are about it: a scalar for
    /// all axes, a diagonal (3,), or (3, 3). Links that are fixed to others may be named too, here
    /// and in ``masses``.
    ///
    /// ``unphysical``: what is done about a link that no rigid body can be, with all that is fixed
    /// to it (negative mass or moments, a broken triangle inequality). "refuse": raise ValueError.
    /// "note": take it as it stands, as Pinocchio does. "nearest": take the nearest body with the
    /// same mass and centre of mass; what is negative of ½ tr(I) 1 - I is left out. `notes` say how
    /// far off the link is. M must be positive definite in any case. The arm and its TOML keep the
    /// policy.
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

    /// Build from a Denavit-Hartenberg table: ``a``, ``d`` [m]; ``alpha``, ``theta_offset``.
    ///
    /// Each column is a scalar for all joints or (n,); angles [rad]. ``mass`` [kg]; ``com`` [m],
    /// (n, 3), in the table's frame i; ``inertia`` [kg·m²] about it: (n, 3) for a
    /// diagonal, or (n, 3, 3). ``viscous`` [N·m·s/rad], ``coulomb`` [N·m], ``armature`` [kg·m²].
    /// ``unphysical``: as in `from_urdf`.
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

    /// Read what `to_toml` wrote. A string of several lines is the text itself.
    ///
    /// ``unphysical``: as in `from_urdf`; by default what the file says, "refuse" if nothing.
    #[staticmethod]
    #[pyo3(signature = (path_or_text, *, unphysical=None))]
    fn from_toml(path_or_text: Any<'_, '_>, unphysical: Given<'_, '_>) -> PyResult<New<Self>> {
        Self::new(serial_files::toml(path_or_text, unphysical)?)
    }

    /// Take one of the arms that come with the wheel: "panda", "puma560", "ur5e".
    #[staticmethod]
    #[pyo3(name = "shipped")]
    fn from_wheel(name: &str) -> PyResult<New<Self>> {
        Self::new(shipped(name)?)
    }

    /// Return the arm as TOML; `from_toml` gives it back, bit for bit.
    fn to_toml(&self) -> String {
        self.description.to_toml()
    }

    /// Return the same arm with no friction in any joint.
    fn without_friction(&self) -> PyResult<New<Self>> {
        self.each(|_, link| link.friction = JointFriction::default())
    }

    /// Return the same arm with this friction in place of its own; scalars or (n,).
    ///
    /// ``viscous`` [N·m·s/rad], ``coulomb`` [N·m], ``stribeck``: by how much breaking away takes
    /// more [N·m], ``stribeck_speed``: where that has fallen to 1/e [rad/s], ``smoothing``: where
    /// Coulomb friction reaches 76 % [rad/s]; 0 for dry friction that sticks.
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

    /// Return the same arm with rotors of this inertia in place of its own; scalar or (n,).
    ///
    /// Seen through the gears: gear² · rotor inertia [kg·m²].
    fn with_armature(&self, armature: Any<'_, '_>) -> PyResult<New<Self>> {
        self.geared(armature)
    }

    /// Return the same arm under another ``gravity`` (3,) [m/s²], in the axes of the base.
    fn with_gravity(&self, gravity: Any<'_, '_>) -> PyResult<New<Self>> {
        let gravity = triple(gravity, "gravity")?;
        Self::new(Description { gravity, ..(*self.description).clone() })
    }

    /// Return the same arm with inertial parameters π, (10n,), as `inertial_parameters` gives.
    ///
    /// There and back is the same to rounding. `unphysical` says what is done about a link that no
    /// rigid body can be. Raises ValueError for first moments m c without a mass m.
    fn with_parameters(&self, parameters: Any<'_, '_>) -> PyResult<New<Self>> {
        self.identified(parameters)
    }

    /// Return the same arm with stops at the ends of its joints' ranges, if they have ends.
    ///
    /// A joint that is δ beyond an end is pushed back with
    /// max(0, ``stiffness`` δ (1 + ``dissipation`` dδ/dt)), after Hunt and Crossley. Stiffness is
    /// in N·m/rad, or N/m for a prismatic joint, 0 for none; dissipation in s/rad or s/m. Both are
    /// scalars or (n,). Stops are part of inverse and forward dynamics, so of a `Plant`. They are
    /// not part of `bias`: a `ComputedTorque` of this arm does not count on them.
    ///
    /// A joint rests in a stop of any stiffness. A bounce is followed while
    /// ``dt`` < 1 / √(stiffness (M⁻¹)ⱼⱼ). Here 1/(M⁻¹)ⱼⱼ is the inertia that the stop meets, often
    /// far less than Mⱼⱼ. A shorter bounce is lost, and `Run.status` is "unresolved". "dp54" finds
    /// its own step. Raises ValueError for an arm whose joints have no ends.
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

    /// Return the same arm with a body fixed to its tip.
    ///
    /// ``mass`` [kg], ``com`` (3,) [m] in the tip's frame, ``inertia`` [kg·m²] about it: a scalar
    /// for all axes, a diagonal (3,), or (3, 3). It must be one that a rigid body can have,
    /// whatever `unphysical` says.
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

    /// Return a neighbour, physically valid, and the same for the same seed on any machine.
    ///
    /// Masses, moments and friction are off by shares up to ±``mass``, ±``inertia`` and
    /// ±``friction``, centres of mass by up to ±``com`` [m] along each axis.
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

    /// What the description says that was not used, or not taken as it stands.
    #[getter]
    fn notes(&self) -> Vec<&str> {
        self.description.notes.iter().map(String::as_str).collect()
    }

    /// What is done about links that no rigid body can be; see `from_urdf`.
    #[getter]
    fn unphysical(&self) -> &str {
        self.description.unphysical.name()
    }

    /// Return what ``reference`` exceeds of `limits`, before it runs: an empty list if nothing.
    ///
    /// Every ``dt`` from 0 to ``duration`` [s], at most 1e7 times, this looks at position,
    /// velocity, and the torque that the motion takes, M(q_d) ddq_d + H(q_d, dq_d). The list has
    /// the worst of each, joint by joint: ``for excess in arm.check(path, 2.0): print(excess)``.
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
    ) -> PyResult<Vec<New<PyExcess>>> {
        self.excesses(py, reference, duration, dt)
    }

    /// Limits by name, (n,) each, infinite for none.
    ///
    /// "lower" and "upper" [rad], "velocity" [rad/s], "effort" [N·m].
    #[getter]
    fn limits<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        Ok(columns!(py, self.links(), |link|
            lower: link.limits.lower, upper: link.limits.upper,
            velocity: link.limits.velocity, effort: link.limits.effort,
        ))
    }

    /// M ddq_r + C(q, dq) dq_r + G [N·m], (n,), without friction and stops.
    fn slotine_li(
        &self,
        q: Any<'_, '_>,
        dq: Any<'_, '_>,
        dq_r: Any<'_, '_>,
        ddq_r: Any<'_, '_>,
    ) -> PyResult<Array<1>> {
        each!(&self.chain, Chains, chain => {
            let (q, dq) = (finite_vector(q, "q")?, finite_vector(dq, "dq")?);
            let (dq_r, ddq_r) = (finite_vector(dq_r, "dq_r")?, finite_vector(ddq_r, "ddq_r")?);
            Ok(chain.slotine_li(&q, &dq, &dq_r, &ddq_r).into())
        })
    }

    /// Y(q, dq, ddq), (n, 10n): ``Y @ inertial_parameters()`` = M ddq + C dq + G.
    ///
    /// Without friction, stops and armature.
    fn regressor(&self, q: Any<'_, '_>, dq: Any<'_, '_>, ddq: Any<'_, '_>) -> PyResult<Array<2>> {
        let width = 10 * self.chain.joints();
        let mut y = vec![0.0; width * self.chain.joints()];
        each!(&self.chain, Chains, chain => {
            let (q, dq) = (finite_vector(q, "q")?, finite_vector(dq, "dq")?);
            chain.regressor(&q, &dq, &finite_vector(ddq, "ddq")?, &mut y)?;
        });
        Ok(Array::rows(y, width))
    }

    /// π, (10n,), of each link: m, m c, moments xx, xy, yy, xz, yz, zz about its origin.
    fn inertial_parameters(&self) -> PyResult<Array<1>> {
        let mut pi = vec![0.0; 10 * self.chain.joints()];
        each!(&self.chain, Chains, chain => chain.inertial_parameters(&mut pi))?;
        Ok(pi.into())
    }

    /// Jacobian of the tip in the axes of the base, (6, n).
    ///
    /// ``J @ dq`` is the velocity of the tip [m/s] (rows 0 to 2) and its angular velocity [rad/s]
    /// (rows 3 to 5).
    fn jacobian(&self, q: Any<'_, '_>) -> PyResult<Array<2>> {
        each!(&self.chain, Chains, chain => {
            let jacobian = chain.jacobian(&finite_vector(q, "q")?);
            Ok(Array::rows(jacobian.transpose().as_slice().to_vec(), self.chain.joints()))
        })
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, (String,))> {
        Ok((slf.get_type().getattr("from_toml")?, (slf.get().to_toml(),)))
    }

    fn __repr__(&self) -> String {
        format!("Serial({:?}, {} joints)", self.description.name, self.chain.joints())
    }
}

//! `TwoLink`.

use pyo3::prelude::*;

use super::any_arm::AnyArm;
use super::arm::{New, PyArm};
use super::convert::{Any, Given, joints, renamed, scalar, scalar_or};
use super::errors::value_error;
use crate::arm::{Friction, TwoLink, TwoLinkParameters};
use crate::error::Result;

/// The paper's planar arm of two links, in closed form (section 4).
///
/// ``M(q) ddq + H(q, dq) = tau`` with ``H = C dq + G + f`` (6). q₁ is measured from the horizontal
/// axis, q₂ from the first link. Centres of mass are at mid-link.
///
/// Parameters
/// ----------
/// mass: m of each link [kg], > 0; scalar or (2,), as all that follow but ``gravity``.
/// length: l of each link [m], > 0.
/// inertia: I of each link about its centre of mass [kg·m²], > 0.
/// gravity: g [m/s²], downwards; 0 by default, an arm that lies flat as the paper's.
/// viscous: viscous friction of each joint [N·m·s/rad], >= 0; 0 by default.
/// coulomb: Coulomb friction [N·m], >= 0; 0 by default.
/// smoothing: the speed at which Coulomb friction reaches 76 % [rad/s], ≥ 0; 0.01 by
///     default, 0 for dry friction that sticks.
///
/// Raises
/// ------
/// ValueError, TypeError
///     Naming the parameter. It is ``mass_matrix.det`` or ``gravity_torque`` if numbers that are
///     valid one by one overflow or underflow together.
#[pyclass(name = "TwoLink", extends = PyArm, module = "steadyarm", frozen)]
pub(super) struct PyTwoLink {
    arm: TwoLink,
}

/// The constructor's arguments.
type Arguments = (Vec<f64>, Vec<f64>, Vec<f64>, f64, Vec<f64>, Vec<f64>, Vec<f64>);

/// The object of an arm; an error with the parameter named as the argument that it comes from.
fn made(arm: Result<TwoLink>) -> PyResult<New<PyTwoLink>> {
    let argument = |name: &'static str| name.strip_prefix("friction.").unwrap_or(name);
    let arm = arm.map_err(|error| value_error(renamed(error, argument)))?;
    let base = PyArm { arms: AnyArm::<2>::TwoLink(arm).into() };
    Ok(New(PyClassInitializer::from(base).add_subclass(PyTwoLink { arm })))
}

/// Friction, where stated.
fn friction_of(
    viscous: Given<'_, '_>,
    coulomb: Given<'_, '_>,
    smoothing: Given<'_, '_>,
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
        gravity: Given<'_, '_>,
        viscous: Given<'_, '_>,
        coulomb: Given<'_, '_>,
        smoothing: Given<'_, '_>,
    ) -> PyResult<PyClassInitializer<Self>> {
        let friction = friction_of(viscous, coulomb, smoothing)?;
        let parameters = TwoLinkParameters {
            mass: joints(mass, "mass")?,
            length: joints(length, "length")?,
            inertia: joints(inertia, "inertia")?,
            gravity: scalar_or(gravity, 0.0, "gravity")?,
            friction,
        };
        Ok(made(TwoLink::new(parameters))?.0)
    }

    /// Return the same arm with this friction in place of its own; scalars or (2,).
    #[pyo3(
        signature = (viscous=None, coulomb=None, smoothing=None),
        text_signature = "(self, viscous=0.0, coulomb=0.0, smoothing=0.01)"
    )]
    fn with_friction(
        &self,
        viscous: Given<'_, '_>,
        coulomb: Given<'_, '_>,
        smoothing: Given<'_, '_>,
    ) -> PyResult<New<Self>> {
        made(self.arm.with_friction(friction_of(viscous, coulomb, smoothing)?))
    }

    /// Return the same arm under another ``gravity`` [m/s²]; 0 for one that lies flat.
    fn with_gravity(&self, gravity: Any<'_, '_>) -> PyResult<New<Self>> {
        made(self.arm.with_gravity(scalar(gravity, "gravity")?))
    }

    /// (mass, length, inertia, gravity, viscous, coulomb, smoothing), as they were given.
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
}

//! `TwoLink`.

use pyo3::prelude::*;

use super::any_arm::AnyArm;
use super::arm::{New, PyArm};
use super::convert::{Any, Given, joints, renamed, scalar, scalar_or};
use super::errors::value_error;
use crate::arm::{Friction, TwoLink, TwoLinkParameters};
use crate::error::Result;

/// A planar arm of two links, in closed form (section 4 of the paper).
///
/// mass [kg], length [m], inertia about the centres of mass [kg·m²]: scalar or (2,), > 0. gravity
/// [m/s²]: 0 for an arm that lies flat. viscous [N·m·s/rad], coulomb [N·m], smoothing [rad/s]:
/// friction of the joints.
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

    /// The same arm with this friction in its joints, in place of what they had.
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

    /// The same arm under another gravity [m/s²]; 0 for an arm that lies flat.
    fn with_gravity(&self, gravity: Any<'_, '_>) -> PyResult<New<Self>> {
        made(self.arm.with_gravity(scalar(gravity, "gravity")?))
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
}

//! `TwoLink`.

use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::PyTuple;

use super::any_arm::AnyArm;
use super::arm::PyArm;
use super::convert::{Any, Given, joints, scalar, scalar_or};
use super::form::{self, New};
use crate::scenario::TwoLinkSettings;

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
    settings: Arc<TwoLinkSettings>,
}

impl PyTwoLink {
    /// The arm of these settings.
    pub fn made(settings: TwoLinkSettings) -> PyResult<New<Self>> {
        let arm = settings.build()?;
        // A number a joint, however they were said.
        let settings = Arc::new(TwoLinkSettings::from(arm.parameters()));
        let arms = AnyArm::<2>::TwoLink(arm).into();
        Ok(PyArm::under(settings.clone(), arms, Self { settings }))
    }
}

/// The same with this friction, where it is given.
fn with_friction(
    mut settings: TwoLinkSettings,
    [viscous, coulomb, smoothing]: [Given<'_, '_>; 3],
) -> PyResult<New<PyTwoLink>> {
    for (field, value, name) in [
        (&mut settings.viscous, viscous, "viscous"),
        (&mut settings.coulomb, coulomb, "coulomb"),
        (&mut settings.smoothing, smoothing, "smoothing"),
    ] {
        if let Some(value) = value {
            *field = joints::<2>(value, name)?.into();
        }
    }
    PyTwoLink::made(settings)
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
        let [mass, length, inertia] = [(mass, "mass"), (length, "length"), (inertia, "inertia")]
            .map(|(value, name)| joints::<2>(value, name));
        let mut settings = TwoLinkSettings::new(mass?.into(), length?.into(), inertia?.into());
        settings.gravity = scalar_or(gravity, settings.gravity, "gravity")?;
        Ok(with_friction(settings, [viscous, coulomb, smoothing])?.0)
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
        let TwoLinkSettings { mass, length, inertia, gravity, .. } = (*self.settings).clone();
        let settings = TwoLinkSettings { gravity, ..TwoLinkSettings::new(mass, length, inertia) };
        with_friction(settings, [viscous, coulomb, smoothing])
    }

    /// Return the same arm under another ``gravity`` [m/s²]; 0 for one that lies flat.
    fn with_gravity(&self, gravity: Any<'_, '_>) -> PyResult<New<Self>> {
        let gravity = scalar(gravity, "gravity")?;
        Self::made(TwoLinkSettings { gravity, ..(*self.settings).clone() })
    }

    /// (mass, length, inertia, gravity, viscous, coulomb, smoothing), as they were given.
    #[getter]
    fn parameters<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        form::values(slf.as_super().as_super())
    }
}

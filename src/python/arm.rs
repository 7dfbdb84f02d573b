//! `TwoLink`.

use pyo3::prelude::*;

use super::convert::{Array1, Array2, array1, joints, owned2, scalar, vector};
use super::dispatch::{JOINTS, rows};
use super::value_error;
use crate::arm::{Arm, Friction, TwoLink, TwoLinkParameters};

/// The paper's two-link arm.
#[pyclass(name = "TwoLink", module = "steadyarm", frozen)]
pub(super) struct PyTwoLink {
    pub arm: TwoLink,
}

type Any<'a, 'py> = &'a Bound<'py, PyAny>;

#[pymethods]
impl PyTwoLink {
    #[new]
    #[pyo3(signature = (mass, length, inertia, gravity=None, viscous=None, coulomb=None, smoothing=None))]
    fn new(
        mass: Any<'_, '_>,
        length: Any<'_, '_>,
        inertia: Any<'_, '_>,
        gravity: Option<Any<'_, '_>>,
        viscous: Option<Any<'_, '_>>,
        coulomb: Option<Any<'_, '_>>,
        smoothing: Option<Any<'_, '_>>,
    ) -> PyResult<Self> {
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
        let parameters = TwoLinkParameters {
            mass: joints(mass, "mass")?,
            length: joints(length, "length")?,
            inertia: joints(inertia, "inertia")?,
            gravity: gravity.map_or(Ok(0.0), |g| scalar(g, "gravity"))?,
            friction,
        };
        Ok(Self { arm: TwoLink::new(parameters).map_err(value_error)? })
    }

    #[getter]
    fn joints(&self) -> usize {
        JOINTS
    }

    #[getter]
    fn parameters(&self) -> (Vec<f64>, Vec<f64>, Vec<f64>, f64, Vec<f64>, Vec<f64>, Vec<f64>) {
        let TwoLinkParameters { mass, length, inertia, gravity, friction } = self.arm.parameters();
        let Friction { viscous, coulomb, smoothing } = friction;
        let list = |x: &[f64; JOINTS]| x.to_vec();
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

    fn mass_matrix<'py>(&self, py: Python<'py>, q: Any<'_, 'py>) -> PyResult<Array2<'py>> {
        owned2(py, rows(&self.arm.mass_matrix(&vector(q, "q")?)), JOINTS)
    }

    fn coriolis<'py>(
        &self,
        py: Python<'py>,
        q: Any<'_, 'py>,
        dq: Any<'_, 'py>,
    ) -> PyResult<Array2<'py>> {
        owned2(py, rows(&self.arm.coriolis(&vector(q, "q")?, &vector(dq, "dq")?)), JOINTS)
    }

    fn gravity<'py>(&self, py: Python<'py>, q: Any<'_, 'py>) -> PyResult<Array1<'py>> {
        Ok(array1(py, self.arm.gravity(&vector(q, "q")?).as_slice()))
    }

    fn friction<'py>(&self, py: Python<'py>, dq: Any<'_, 'py>) -> PyResult<Array1<'py>> {
        Ok(array1(py, self.arm.friction(&vector(dq, "dq")?).as_slice()))
    }

    fn bias<'py>(
        &self,
        py: Python<'py>,
        q: Any<'_, 'py>,
        dq: Any<'_, 'py>,
    ) -> PyResult<Array1<'py>> {
        Ok(array1(py, self.arm.bias(&vector(q, "q")?, &vector(dq, "dq")?).as_slice()))
    }

    fn inverse_dynamics<'py>(
        &self,
        py: Python<'py>,
        q: Any<'_, 'py>,
        dq: Any<'_, 'py>,
        ddq: Any<'_, 'py>,
    ) -> PyResult<Array1<'py>> {
        let (q, dq, ddq) = (vector(q, "q")?, vector(dq, "dq")?, vector(ddq, "ddq")?);
        Ok(array1(py, self.arm.inverse_dynamics(&q, &dq, &ddq).as_slice()))
    }

    fn forward_dynamics<'py>(
        &self,
        py: Python<'py>,
        q: Any<'_, 'py>,
        dq: Any<'_, 'py>,
        tau: Any<'_, 'py>,
    ) -> PyResult<Array1<'py>> {
        let (q, dq, tau) = (vector(q, "q")?, vector(dq, "dq")?, vector(tau, "tau")?);
        Ok(array1(py, self.arm.forward_dynamics(&q, &dq, &tau).as_slice()))
    }

    fn kinetic_energy(&self, q: Any<'_, '_>, dq: Any<'_, '_>) -> PyResult<f64> {
        Ok(self.arm.kinetic_energy(&vector(q, "q")?, &vector(dq, "dq")?))
    }

    fn potential_energy(&self, q: Any<'_, '_>) -> PyResult<f64> {
        Ok(self.arm.potential_energy(&vector(q, "q")?))
    }
}

//! Arms from an arm: what is behind the `with_…` of `Serial`.

use pyo3::prelude::*;

use super::any_arm::Chains;
use super::convert::{
    Any, Given, Numbers, each_joint, numbers, renamed, scalar, scalar_or, whole, wrong_shape,
};
use super::dispatch::each;
use super::errors::value_error;
use super::form::New;
use super::limits::{PyExcess, check};
use super::serial::PySerial;
use super::serial_files::{moments, refuse_stops_without_ends, triple};
use crate::arm::{Inertia, JointFriction, JointStop, Link, Perturbation};
use crate::error::{Error, finite, non_negative};
use crate::math::Matrix;

/// Of stops, unless something else is asked for [s/rad].
const DISSIPATION: f64 = 1.0;

/// The period at which a reference is looked at, unless something else is asked for [s].
const PERIOD: f64 = 1e-3;

impl PySerial {
    /// The same robot with other links.
    fn changed(&self, links: Vec<Link>) -> PyResult<New<Self>> {
        Self::new(self.description.with_links(links)?)
    }

    /// The same robot, each joint and its link changed.
    pub fn each(&self, change: impl Fn(usize, &mut Link)) -> PyResult<New<Self>> {
        let mut links = self.links().to_vec();
        links.iter_mut().enumerate().for_each(|(joint, link)| change(joint, link));
        self.changed(links)
    }

    /// A value a joint, from an argument.
    fn values(&self, value: Given<'_, '_>, default: f64, name: &str) -> PyResult<Vec<f64>> {
        each_joint(value, default, self.chain.joints(), name)
    }

    /// From viscous, coulomb, stribeck, stribeck_speed and smoothing.
    pub fn rubbing(&self, arguments: [Given<'_, '_>; 5]) -> PyResult<New<Self>> {
        let none = JointFriction::default();
        let [viscous, coulomb, stribeck, stribeck_speed, smoothing] = arguments;
        let viscous = self.values(viscous, none.viscous, "viscous")?;
        let coulomb = self.values(coulomb, none.coulomb[0], "coulomb")?;
        let stribeck = self.values(stribeck, none.stribeck, "stribeck")?;
        let speed = self.values(stribeck_speed, none.stribeck_speed, "stribeck_speed")?;
        let smoothing = self.values(smoothing, none.smoothing, "smoothing")?;
        let friction = |joint: usize| JointFriction {
            viscous: viscous[joint],
            coulomb: [coulomb[joint]; 2],
            stribeck: stribeck[joint],
            stribeck_speed: speed[joint],
            smoothing: smoothing[joint],
        };
        let refused =
            (0..self.chain.joints()).try_for_each(|joint| friction(joint).validate(joint));
        refused.map_err(of_argument)?;
        self.each(|joint, link| link.friction = friction(joint))
    }

    pub fn geared(&self, armature: Any<'_, '_>) -> PyResult<New<Self>> {
        let armature = self.values(Some(armature), 0.0, "armature")?;
        non_negative("armature", &armature)?;
        self.each(|joint, link| link.armature = armature[joint])
    }

    /// From π.
    pub fn identified(&self, parameters: Any<'_, '_>) -> PyResult<New<Self>> {
        let Numbers { shape, values } = numbers(parameters, "parameters")?;
        let (of_links, rest) = values.as_chunks();
        if shape.len() != 1 || of_links.len() != self.chain.joints() || !rest.is_empty() {
            let wanted = format!("({},)", 10 * self.chain.joints());
            return Err(wrong_shape("parameters", &shape, &wanted));
        }
        finite("parameters", &values)?;
        self.each(|joint, link| link.inertia = Inertia::from_parameters(&of_links[joint]))
    }

    pub fn stopped(
        &self,
        stiffness: Any<'_, '_>,
        dissipation: Given<'_, '_>,
    ) -> PyResult<New<Self>> {
        let stiffness = self.values(Some(stiffness), 0.0, "stiffness")?;
        let dissipation = self.values(dissipation, DISSIPATION, "dissipation")?;
        refuse_stops_without_ends(self.links(), &stiffness)?;
        let stop = |joint: usize| JointStop {
            stiffness: stiffness[joint],
            dissipation: dissipation[joint],
        };
        let refused = (0..self.chain.joints()).try_for_each(|joint| stop(joint).validate(joint));
        refused.map_err(of_argument)?;
        self.each(|joint, link| link.stop = stop(joint))
    }

    pub fn loaded(
        &self,
        mass: Any<'_, '_>,
        com: Given<'_, '_>,
        inertia: Given<'_, '_>,
    ) -> PyResult<New<Self>> {
        let com = com.map_or(Ok([0.0; 3]), |value| triple(value, "com"))?.into();
        let moments =
            inertia.map_or(Ok(Matrix::<3>::zeros()), |value| moments(value, "inertia"))?;
        let body = Inertia { mass: scalar(mass, "mass")?, com, moments };
        let links = each!(&self.chain, Chains, chain => {
            chain.with_payload(&body).map(|arm| arm.links().to_vec())
        });
        self.changed(links.map_err(of_argument)?)
    }

    /// From shares of mass, inertia and friction, and a shift of com.
    pub fn neighbour(
        &self,
        seed: Any<'_, '_>,
        [mass, com, inertia, friction]: [Given<'_, '_>; 4],
    ) -> PyResult<New<Self>> {
        let perturbation = Perturbation {
            mass: scalar_or(mass, 0.2, "mass")?,
            com: scalar_or(com, 0.01, "com")?,
            inertia: scalar_or(inertia, 0.2, "inertia")?,
            friction: scalar_or(friction, 0.2, "friction")?,
        };
        let seed = whole(seed, "seed")?;
        let links = each!(&self.chain, Chains, chain => {
            chain.perturb(seed, &perturbation).map(|arm| arm.links().to_vec())
        });
        self.changed(links?)
    }

    /// What a reference exceeds of the limits.
    pub fn excesses(
        &self,
        py: Python<'_>,
        reference: Any<'_, '_>,
        duration: Any<'_, '_>,
        dt: Given<'_, '_>,
    ) -> PyResult<Vec<New<PyExcess>>> {
        let times = [scalar(duration, "duration")?, scalar_or(dt, PERIOD, "dt")?];
        let excesses = each!(&self.chain, Chains, chain => check(py, chain, reference, times))?;
        let joints = &self.description.joints;
        let named = |excess: crate::design::Excess| {
            PyExcess::new(joints[excess.joint].name.clone(), excess)
        };
        Ok(excesses.into_iter().map(named).collect())
    }
}

/// An error of the core, its parameter named as the argument that it comes from.
fn of_argument(error: Error) -> PyErr {
    let name = |parameter: &'static str| match parameter.rsplit_once('.') {
        Some(("payload", "moments")) => "inertia",
        Some(("payload" | "friction" | "stop", argument)) => argument,
        _ => parameter,
    };
    value_error(renamed(error, name))
}

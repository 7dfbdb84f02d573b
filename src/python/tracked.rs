//! A tracker of any joint count: what `ComputedTorque` holds.

use std::sync::Arc;

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::any_arm::AnyArm;
use super::compensator::{Compensation, compensator_of};
use super::convert::{Any, Array1, array1, joints, scalar, vector};
use super::monitor::Monitor;
use super::planted::Planted;
use super::simulate::{Settings, simulated};
use super::value_error;
use crate::control::{
    self, Command, ComputedTorque, FuzzyCompensator, Gains, KernelCompensator, Limits,
    NoCompensation, State,
};
use crate::design::{Conditions, Finding, JointReport, Report};
use crate::error::Result;
use crate::reference::Setpoint;

/// A part of the latest command.
#[derive(Clone, Copy)]
pub(super) enum Part {
    Model,
    Compensation,
    RhoHat,
}

/// A controller with its state.
pub(super) trait Tracked: Send + Sync {
    fn joints(&self) -> usize;

    /// One sample (q, dq, q_d, dq_d, ddq_d), and dt.
    fn step<'py>(
        &mut self,
        py: Python<'py>,
        sample: [Any<'_, 'py>; 5],
        dt: Any<'_, 'py>,
    ) -> PyResult<Array1<'py>>;

    /// A run from the present state, which ends as the run left it.
    fn simulate<'py>(
        &mut self,
        py: Python<'py>,
        plant: &dyn Planted,
        reference: Any<'_, 'py>,
        settings: Settings<'_, 'py>,
        monitor: Monitor,
    ) -> PyResult<(Bound<'py, PyDict>, Option<PyErr>)>;

    /// The same controller in the same state, of which one may go on alone.
    fn twin(&self) -> Box<dyn Tracked>;

    fn reset(&mut self);
    fn latest(&self, part: Part) -> Option<&[f64]>;
    fn limited(&self) -> bool;
    fn steps(&self) -> u64;

    /// K_p and K_v.
    fn gains(&self) -> [&[f64]; 2];

    /// Effort and effort rate.
    fn limits(&self) -> [&[f64]; 2];

    /// P, row-major; `None` without a compensator.
    fn p(&self) -> Option<Vec<f64>>;

    /// The compensator in words.
    fn compensator(&self) -> String;

    /// The dictionary in figures; `None` but for the kernel form.
    fn dictionary<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>>;

    /// Columns of W.
    fn weights_columns(&self) -> PyResult<usize>;

    fn weights(&self) -> PyResult<Vec<f64>>;

    /// Sets W, and with `prior` W₀ too.
    fn set_weights(&mut self, weights: &[f64], prior: bool) -> PyResult<()>;

    fn set_frozen(&mut self, frozen: bool) -> PyResult<()>;
    fn frozen(&self) -> bool;

    /// What the controller remembers, as bytes.
    fn saved(&self) -> Vec<u8>;

    /// Takes over what [`saved`](Self::saved) gave, or changes nothing.
    fn restore(&mut self, bytes: &[u8]) -> Result<()>;

    /// The design report: figures joint by joint, findings.
    fn report(&self, conditions: &Conditions<'_>) -> PyResult<(Vec<JointReport>, Vec<Finding>)>;
}

pub(super) type Controller<const N: usize, C> =
    control::Controller<N, ComputedTorque<N, AnyArm<N>>, C>;

struct Tracker<const N: usize, C: Compensation<N>> {
    controller: Arc<Controller<N, C>>,
    state: State<N, C::State>,
    latest: Option<Command<N>>,
}

/// Arguments of the class `ComputedTorque` that depend on the joint count.
pub(super) struct Arguments<'a, 'py> {
    pub arm: Any<'a, 'py>,
    pub kp: Any<'a, 'py>,
    pub kv: Any<'a, 'py>,
    pub compensator: Option<Any<'a, 'py>>,
    pub effort_limit: Option<Any<'a, 'py>>,
    pub effort_rate_limit: Option<Any<'a, 'py>>,
}

/// A tracker before its first step.
pub(super) fn tracker<const N: usize>(arguments: &Arguments<'_, '_>) -> PyResult<Box<dyn Tracked>> {
    let Arguments { arm, kp, kv, compensator, effort_limit, effort_rate_limit } = *arguments;
    let gains = Gains::<N>::new(joints(kp, "kp")?, joints(kv, "kv")?).map_err(value_error)?;
    let limit = |value: Option<Any<'_, '_>>, name| {
        value.map_or(Ok([f64::INFINITY; N]), |value| joints(value, name))
    };
    let limits = Limits {
        effort_limit: limit(effort_limit, "effort_limit")?,
        effort_rate_limit: limit(effort_rate_limit, "effort_rate_limit")?,
    };
    let Some(compensator) = compensator else {
        return boxed(arm, gains, limits, NoCompensation, ());
    };
    let fuzzy = compensator_of(compensator)?;
    if let Some(got) = fuzzy.joints
        && got != N
    {
        let why = fuzzy
            .basis
            .other_joints(N, "the arm")
            .map_or_else(String::new, |why| format!("; {why}"));
        let message = format!("compensator: got one of {got} joints, wants one of {N}{why}");
        return Err(PyValueError::new_err(message));
    }
    let parameters = fuzzy.parameters()?;
    if let Some(kernel) = fuzzy.kernel {
        let basis = fuzzy.basis.kernel_for_arm(N)?;
        let kernel = KernelCompensator::new(basis, &gains, parameters, kernel);
        let kernel = kernel.map_err(value_error)?;
        let state = kernel.state();
        return boxed(arm, gains, limits, kernel, state);
    }
    let basis = fuzzy.basis.for_arm(N)?;
    let fuzzy = FuzzyCompensator::new(basis, &gains, parameters).map_err(value_error)?;
    let state = fuzzy.state();
    boxed(arm, gains, limits, fuzzy, state)
}

fn boxed<const N: usize, C: Compensation<N>>(
    arm: Any<'_, '_>,
    gains: Gains<N>,
    limits: Limits<N>,
    compensator: C,
    state: C::State,
) -> PyResult<Box<dyn Tracked>> {
    let law = ComputedTorque::new(AnyArm::new(arm)?, gains);
    let controller = Controller::new(law, compensator).with_limits(limits).map_err(value_error)?;
    let (controller, state) = (Arc::new(controller), State::new(state));
    Ok(Box::new(Tracker { controller, state, latest: None }))
}

impl<const N: usize, C: Compensation<N>> Tracked for Tracker<N, C> {
    fn joints(&self) -> usize {
        N
    }

    fn step<'py>(
        &mut self,
        py: Python<'py>,
        [q, dq, q_d, dq_d, ddq_d]: [Any<'_, 'py>; 5],
        dt: Any<'_, 'py>,
    ) -> PyResult<Array1<'py>> {
        let (q, dq) = (vector(q, "q")?, vector(dq, "dq")?);
        let (q_d, dq_d) = (vector(q_d, "q_d")?, vector(dq_d, "dq_d")?);
        let desired = Setpoint { q: q_d, dq: dq_d, ddq: vector(ddq_d, "ddq_d")? };
        let dt = scalar(dt, "dt")?;
        let command =
            self.controller.step(&mut self.state, &q, &dq, &desired, dt).map_err(value_error)?;
        self.latest = Some(command);
        Ok(array1(py, command.tau.as_slice()))
    }

    fn simulate<'py>(
        &mut self,
        py: Python<'py>,
        plant: &dyn Planted,
        reference: Any<'_, 'py>,
        settings: Settings<'_, 'py>,
        monitor: Monitor,
    ) -> PyResult<(Bound<'py, PyDict>, Option<PyErr>)> {
        let Self { controller, state, latest } = self;
        *latest = None;
        simulated(py, plant, controller, state, reference, settings, monitor)
    }

    fn twin(&self) -> Box<dyn Tracked> {
        let Self { controller, state, latest } = self;
        let (controller, state) = (Arc::clone(controller), state.clone());
        Box::new(Self { controller, state, latest: *latest })
    }

    fn reset(&mut self) {
        self.controller.reset(&mut self.state);
        self.latest = None;
    }

    fn latest(&self, part: Part) -> Option<&[f64]> {
        let command = self.latest.as_ref()?;
        Some(match part {
            Part::Model => command.model.as_slice(),
            Part::Compensation => command.compensation.as_slice(),
            Part::RhoHat => command.rho_hat.as_slice(),
        })
    }

    fn limited(&self) -> bool {
        self.latest.as_ref().is_some_and(|command| command.limited)
    }

    fn steps(&self) -> u64 {
        self.state.steps
    }

    fn gains(&self) -> [&[f64]; 2] {
        let Gains { kp, kv } = &self.controller.law.gains;
        [kp, kv]
    }

    fn limits(&self) -> [&[f64]; 2] {
        let Limits { effort_limit, effort_rate_limit } = &self.controller.limits;
        [effort_limit, effort_rate_limit]
    }

    fn p(&self) -> Option<Vec<f64>> {
        let joints = self.controller.compensator.subject()?.p();
        let size = 2 * N;
        let mut p = vec![0.0; size * size];
        for (n, joint) in joints.iter().enumerate() {
            let m = n + N;
            p[n * size + n] = joint.p11;
            p[n * size + m] = joint.p12;
            p[m * size + n] = joint.p12;
            p[m * size + m] = joint.p22;
        }
        Some(p)
    }

    fn compensator(&self) -> String {
        self.controller.compensator.words()
    }

    fn dictionary<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        self.controller.compensator.dictionary(py, &self.state.compensator)
    }

    fn weights_columns(&self) -> PyResult<usize> {
        Ok(self.controller.compensator.dense()?.weights_len() / N)
    }

    fn weights(&self) -> PyResult<Vec<f64>> {
        self.controller.compensator.weights(&self.state.compensator)
    }

    fn set_weights(&mut self, weights: &[f64], prior: bool) -> PyResult<()> {
        self.controller.compensator.set_weights(&mut self.state.compensator, weights, prior)
    }

    fn set_frozen(&mut self, frozen: bool) -> PyResult<()> {
        self.controller.compensator.set_frozen(&mut self.state.compensator, frozen)
    }

    fn frozen(&self) -> bool {
        C::frozen(&self.state.compensator)
    }

    fn saved(&self) -> Vec<u8> {
        self.controller.compensator.save(&self.state)
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<()> {
        let mut state = self.state.clone();
        self.controller.compensator.restore(&mut state, bytes)?;
        (self.state, self.latest) = (state, None);
        Ok(())
    }

    fn report(&self, conditions: &Conditions<'_>) -> PyResult<(Vec<JointReport>, Vec<Finding>)> {
        let Controller { law, compensator, .. } = &*self.controller;
        let subject = compensator.subject().ok_or_else(|| {
            PyTypeError::new_err("tracker: got one without a compensator, wants one to report on")
        })?;
        let report = Report::new(&law.gains, subject, conditions).map_err(value_error)?;
        Ok((report.joints.to_vec(), report.findings))
    }
}

//! A tracker of any joint count: what `ComputedTorque` holds.

use std::sync::Arc;

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::any_arm::AnyArm;
use super::compensator::{AnyCompensator, AnyState, compensator_for, dictionary_of, weights_of};
use super::convert::{Array1, array1, joints, scalar, vector};
use super::planted::Planted;
use super::simulate::{Monitor, Settings, simulated};
use super::value_error;
use crate::control::{
    Command, Compensator, ComputedTorque, FuzzyCompensator, FuzzyState, Gains, Limits, State,
};
use crate::design::{Conditions, Finding, JointReport, Report};
use crate::error::Result;
use crate::reference::Setpoint;

type Any<'a, 'py> = &'a Bound<'py, PyAny>;

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

    /// A run from the present state, which stays as it is.
    fn simulate<'py>(
        self: Box<Self>,
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

    fn weights(&self) -> PyResult<Option<Vec<f64>>>;

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

pub(super) type Controller<const N: usize> = ComputedTorque<N, AnyArm<N>, AnyCompensator<N>>;
type Fuzzy<'a, const N: usize> = (&'a FuzzyCompensator<N>, &'a mut FuzzyState<N, Vec<f64>>);

struct Tracker<const N: usize> {
    controller: Arc<Controller<N>>,
    state: State<N, AnyState<N>>,
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
    let (compensator, state) = compensator_for(compensator, &gains)?;
    let controller = ComputedTorque::new(AnyArm::new(arm)?, gains, compensator)
        .with_limits(limits)
        .map_err(value_error)?;
    let (controller, state) = (Arc::new(controller), State::new(state));
    Ok(Box::new(Tracker { controller, state, latest: None }))
}

impl<const N: usize> Tracker<N> {
    /// The compensator with its state.
    fn fuzzy(&mut self) -> PyResult<Fuzzy<'_, N>> {
        match (&self.controller.compensator, &mut self.state.compensator) {
            (AnyCompensator::Fuzzy(fuzzy), AnyState::Fuzzy(state)) => Ok((fuzzy, state)),
            _ => Err(no_weights(&self.controller.compensator)),
        }
    }
}

fn no_weights<const N: usize>(compensator: &AnyCompensator<N>) -> PyErr {
    PyTypeError::new_err(match compensator {
        AnyCompensator::Kernel(_) => {
            "weights: this compensator has a dictionary, the kernel form, so it has no matrix of weights; \
             see the tracker's dictionary, or build it with dictionary=None"
        }
        _ => "compensator: this controller has none, so it has no weights",
    })
}

impl<const N: usize> Tracked for Tracker<N> {
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
        mut self: Box<Self>,
        py: Python<'py>,
        plant: &dyn Planted,
        reference: Any<'_, 'py>,
        settings: Settings<'_, 'py>,
        monitor: Monitor,
    ) -> PyResult<(Bound<'py, PyDict>, Option<PyErr>)> {
        let Self { controller, state, .. } = &mut *self;
        simulated(py, plant, controller, state, reference, settings, monitor)
    }

    fn twin(&self) -> Box<dyn Tracked> {
        let Self { controller, state, latest } = self;
        let (controller, state) = (Arc::clone(controller), state.clone());
        Box::new(Self { controller, state, latest: *latest })
    }

    fn reset(&mut self) {
        self.controller.compensator.reset(&mut self.state.compensator);
        self.state.last_tau = None;
        self.state.steps = 0;
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
        let Gains { kp, kv } = &self.controller.gains;
        [kp, kv]
    }

    fn limits(&self) -> [&[f64]; 2] {
        let Limits { effort_limit, effort_rate_limit } = &self.controller.limits;
        [effort_limit, effort_rate_limit]
    }

    fn p(&self) -> Option<Vec<f64>> {
        let joints = match &self.controller.compensator {
            AnyCompensator::None => return None,
            AnyCompensator::Fuzzy(fuzzy) => fuzzy.p(),
            AnyCompensator::Kernel(kernel) => kernel.p(),
        };
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
        match &self.controller.compensator {
            AnyCompensator::None => "none".into(),
            AnyCompensator::Fuzzy(fuzzy) => format!("fuzzy, {} rules", fuzzy.basis().rules()),
            AnyCompensator::Kernel(kernel) => {
                let (rules, parameters) = (kernel.basis().rules(), kernel.kernel_parameters());
                format!("fuzzy, {rules:.3e} rules in {} atoms", parameters.capacity)
            }
        }
    }

    fn dictionary<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        dictionary_of(py, &self.controller.compensator, &self.state.compensator)
    }

    fn weights_columns(&self) -> PyResult<usize> {
        match &self.controller.compensator {
            AnyCompensator::Fuzzy(fuzzy) => Ok(fuzzy.weights_len() / N),
            other => Err(no_weights(other)),
        }
    }

    fn weights(&self) -> PyResult<Option<Vec<f64>>> {
        let compensator = &self.controller.compensator;
        if let AnyCompensator::Kernel(_) = compensator {
            return Err(no_weights(compensator));
        }
        weights_of(compensator, &self.state.compensator).map_err(value_error)
    }

    fn set_weights(&mut self, weights: &[f64], prior: bool) -> PyResult<()> {
        let (fuzzy, state) = self.fuzzy()?;
        let set = if prior {
            fuzzy.warm_start(state, weights)
        } else {
            fuzzy.load_weights(state, weights)
        };
        set.map_err(value_error)
    }

    fn set_frozen(&mut self, frozen: bool) -> PyResult<()> {
        match (&mut self.state.compensator, frozen) {
            (AnyState::None, _) => return Err(no_weights(&self.controller.compensator)),
            (AnyState::Fuzzy(state), true) => state.freeze(),
            (AnyState::Fuzzy(state), false) => state.unfreeze(),
            (AnyState::Kernel(state), true) => state.freeze(),
            (AnyState::Kernel(state), false) => state.unfreeze(),
        }
        Ok(())
    }

    fn frozen(&self) -> bool {
        match &self.state.compensator {
            AnyState::None => false,
            AnyState::Fuzzy(state) => state.frozen(),
            AnyState::Kernel(state) => state.frozen(),
        }
    }

    fn saved(&self) -> Vec<u8> {
        let State { last_tau, steps, .. } = self.state;
        match (&self.controller.compensator, &self.state.compensator) {
            (AnyCompensator::Fuzzy(fuzzy), AnyState::Fuzzy(state)) => {
                fuzzy.save(&State { compensator: (**state).clone(), last_tau, steps })
            }
            (AnyCompensator::Kernel(kernel), AnyState::Kernel(state)) => {
                kernel.save(&State { compensator: (**state).clone(), last_tau, steps })
            }
            _ => State { compensator: (), last_tau, steps }.save(),
        }
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<()> {
        let (compensator, last_tau, steps) =
            match (&self.controller.compensator, &self.state.compensator) {
                (AnyCompensator::Fuzzy(fuzzy), AnyState::Fuzzy(state)) => {
                    let mut state = State::new((**state).clone());
                    fuzzy.restore(&mut state, bytes)?;
                    let State { compensator, last_tau, steps } = state;
                    (AnyState::Fuzzy(Box::new(compensator)), last_tau, steps)
                }
                (AnyCompensator::Kernel(kernel), AnyState::Kernel(state)) => {
                    let mut state = State::new((**state).clone());
                    kernel.restore(&mut state, bytes)?;
                    let State { compensator, last_tau, steps } = state;
                    (AnyState::Kernel(Box::new(compensator)), last_tau, steps)
                }
                _ => {
                    let State { last_tau, steps, .. } = State::restore(bytes)?;
                    (AnyState::None, last_tau, steps)
                }
            };
        self.state = State { compensator, last_tau, steps };
        self.latest = None;
        Ok(())
    }

    fn report(&self, conditions: &Conditions<'_>) -> PyResult<(Vec<JointReport>, Vec<Finding>)> {
        let AnyCompensator::Fuzzy(fuzzy) = &self.controller.compensator else {
            let got = match &self.controller.compensator {
                AnyCompensator::Kernel(_) => "with a dictionary, wants one with dictionary=None",
                _ => "without a compensator, wants one",
            };
            return Err(PyTypeError::new_err(format!("tracker: got one {got} to report on")));
        };
        let report = Report::new(&self.controller.gains, fuzzy, conditions).map_err(value_error)?;
        Ok((report.joints.to_vec(), report.findings))
    }
}

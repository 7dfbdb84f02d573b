//! A controller with its state, of any joint count: what `Controller` holds.

use std::collections::BTreeMap;
use std::sync::Arc;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::any_arm::AnyArm;
use super::any_law::{AnyLaw, Own};
use super::arm::PyArm;
use super::compensator::{AnyCompensator, Memory, compensator_of};
use super::convert::{Any, Given, count, joints, scalar};
use super::dispatch::{by_joints, each};
use super::effects::settings;
use super::errors::value_error;
use super::form::limits;
use crate::arm::Serial;
use crate::control::{
    self, Command, Compensator, ComputedTorque, Front, FuzzyCompensator, Gains, KernelCompensator,
    Limits, Origin, State,
};
use crate::design::{Conditions, Course, Report};
use crate::error::Result;
use crate::math::Vector;
use crate::reference::Setpoint;
use crate::scenario::{Adapts, Around, LawSettings};

/// A controller of `N` joints.
pub(super) type Controller<const N: usize> = control::Controller<N, AnyLaw<N>, AnyCompensator<N>>;

/// A controller with its state.
#[derive(Clone)]
pub(super) struct Tracker<const N: usize> {
    pub controller: Arc<Controller<N>>,
    pub state: State<N, Memory<N>>,
    pub latest: Option<Command<N>>,
    /// The torque at take-over that it was made with.
    pub last_tau: Option<Vector<N>>,
}

by_joints! {
    /// A tracker of any joint count.
    Trackers of Tracker
}

/// Arguments of the class `ComputedTorque` that depend on the joint count.
pub(super) struct Arguments<'a, 'py> {
    pub arm: Any<'a, 'py>,
    pub kp: Any<'a, 'py>,
    pub kv: Any<'a, 'py>,
    pub compensator: Given<'a, 'py>,
}

/// What limits any controller, and the torque at take-over.
pub(super) struct Limited<'a, 'py> {
    pub effort_limit: Given<'a, 'py>,
    pub effort_rate_limit: Given<'a, 'py>,
    pub last_tau: Given<'a, 'py>,
}

/// What stands before any law.
pub(super) struct Fronted<'a, 'py> {
    pub hand_over: Given<'a, 'py>,
    pub velocity_filter: Given<'a, 'py>,
    pub bumpless: Given<'a, 'py>,
    pub delay: Given<'a, 'py>,
}

impl Limited<'_, '_> {
    fn limits<const N: usize>(&self) -> PyResult<Limits<N>> {
        let limit = |value: Given<'_, '_>, name| {
            value.map_or(Ok([f64::INFINITY; N]), |value| joints(value, name))
        };
        Ok(Limits {
            effort_limit: limit(self.effort_limit, "effort_limit")?,
            effort_rate_limit: limit(self.effort_rate_limit, "effort_rate_limit")?,
        })
    }
}

impl Fronted<'_, '_> {
    fn front(&self) -> PyResult<Front> {
        let number = |value: Given<'_, '_>, name| value.map(|it| scalar(it, name)).transpose();
        Ok(Front {
            hand_over: number(self.hand_over, "hand_over")?,
            velocity_filter: number(self.velocity_filter, "velocity_filter")?,
            bumpless: number(self.bumpless, "bumpless")?,
            delay: self.delay.map_or(Ok(0), |it| count(it, "delay", 0))?,
        })
    }
}

/// A tracker of computed torque, before its first step.
pub(super) fn tracker<const N: usize>(
    arguments: &Arguments<'_, '_>,
    limited: &Limited<'_, '_>,
    fronted: &Fronted<'_, '_>,
) -> PyResult<Trackers>
where
    Trackers: From<Tracker<N>>,
{
    let Arguments { arm, kp, kv, compensator } = *arguments;
    let gains = Gains::<N>::new(joints(kp, "kp")?, joints(kv, "kv")?).map_err(value_error)?;
    let compensator = compensator.map_or(Ok(AnyCompensator::None), |it| fuzzy(it, &gains))?;
    let law = ComputedTorque::new(PyArm::of(arm)?.any()?.clone(), gains);
    begun(AnyLaw::Computed(law), compensator, limited, fronted)
}

/// A tracker of another law, before its first step.
pub(super) fn other_law<const N: usize>(
    arm: Any<'_, '_>,
    law: Any<'_, '_>,
    limited: &Limited<'_, '_>,
    fronted: &Fronted<'_, '_>,
    period: Option<f64>,
) -> PyResult<Trackers>
where
    Trackers: From<Tracker<N>>,
    Serial<N>: Adapts<N>,
{
    let arm: AnyArm<N> = PyArm::of(arm)?.any()?.clone();
    let Ok(law) = law.cast::<PyDict>() else {
        let own = AnyLaw::Own(arm, Own::new(law, period.unwrap_or(f64::NAN))?);
        return begun(own, AnyCompensator::Own, limited, fronted);
    };
    let law: LawSettings = settings(law, "law")?;
    let around =
        Around { period, front: fronted.front()?, effort_limit: limited.limits()?.effort_limit };
    let built = law.build(&arm, &around).map_err(value_error)?;
    let compensator = built
        .compensator
        .map_or(AnyCompensator::None, |it| AnyCompensator::Other(it, law.learns()));
    begun(AnyLaw::Other(arm, built.law), compensator, limited, fronted)
}

/// A tracker of these before its first step.
fn begun<const N: usize>(
    law: AnyLaw<N>,
    compensator: AnyCompensator<N>,
    limited: &Limited<'_, '_>,
    fronted: &Fronted<'_, '_>,
) -> PyResult<Trackers>
where
    Trackers: From<Tracker<N>>,
{
    let limits = limited.limits()?;
    let last_tau =
        limited.last_tau.map(|tau| joints(tau, "last_tau").map(Vector::from)).transpose()?;
    let state = State::new(compensator.state());
    let controller = Controller::new(law, compensator).with_limits(limits).map_err(value_error)?;
    let controller = controller.with_front(fronted.front()?).map_err(value_error)?;
    let controller = Arc::new(controller);
    let mut tracker = Tracker { controller, state, latest: None, last_tau };
    tracker.reset(None).map_err(value_error)?;
    Ok(tracker.into())
}

/// The compensator of that argument, in the form that it asks for.
fn fuzzy<const N: usize>(
    compensator: Any<'_, '_>,
    gains: &Gains<N>,
) -> PyResult<AnyCompensator<N>> {
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
    Ok(if let Some(kernel) = fuzzy.kernel {
        let basis = fuzzy.basis.kernel_for_arm(N)?;
        let kernel = KernelCompensator::new(basis, gains, parameters, kernel);
        AnyCompensator::Kernel(Box::new(kernel.map_err(value_error)?))
    } else {
        let basis = fuzzy.basis.for_arm(N)?;
        let fuzzy = FuzzyCompensator::new(basis, gains, parameters).map_err(value_error)?;
        AnyCompensator::Fuzzy(Box::new(fuzzy))
    })
}

impl<const N: usize> Tracker<N> {
    pub fn step(
        &mut self,
        applied: Option<&Vector<N>>,
        q: &Vector<N>,
        dq: &Vector<N>,
        desired: &Setpoint<N>,
        dt: f64,
        elapsed: Option<f64>,
    ) -> Result<Vector<N>> {
        let Self { controller, state, .. } = self;
        let length = |state: &State<N, _>| state.pending.as_ref().map(|it| it.dt);
        let (told, front) = (length(state), state.front);
        if let Some(elapsed) = elapsed {
            controller.lasted(state, elapsed)?;
        }
        controller.law.tell(dt);
        let command = controller.step_after(state, applied, q, dq, desired, dt);
        if command.is_err() && length(state).is_some() == told.is_some() {
            // The sample is refused, and what was told with it is forgotten.
            state.front = front;
            if let (Some(pending), Some(dt)) = (&mut state.pending, told) {
                pending.dt = dt;
            }
        }
        let command = command?;
        self.latest = Some(command);
        Ok(command.tau)
    }

    /// A new one that takes over at this torque; `None`: at the one that it was made with.
    pub fn reset(&mut self, last_tau: Option<Vector<N>>) -> Result<()> {
        let mut new = State::new(());
        if let Some(tau) = last_tau.or(self.last_tau) {
            new.take_over(&tau)?;
        }
        self.controller.reset(&mut self.state);
        (self.state.last_tau, self.latest) = (new.last_tau, None);
        Ok(())
    }

    /// Takes what was saved; with `other`, the state of another controller of the same size too.
    pub fn restore(&mut self, bytes: &[u8], other: bool) -> Result<Origin> {
        let Self { controller, state, .. } = self;
        let origin = if other {
            controller.restore_from_other(state, bytes)
        } else {
            controller.restore(state, bytes)
        }?;
        self.latest = None;
        Ok(origin)
    }

    /// What the compensator remembers at the end of the period that is pending, without ending it:
    /// what acted in it may still be told.
    pub fn ended(&self) -> Memory<N> {
        let mut state = self.state.clone();
        self.controller.settle(&mut state);
        state.compensator
    }

    /// What the compensator says of itself at the end of the period that is pending.
    pub fn described(&self) -> BTreeMap<&'static str, Vec<f64>> {
        let mut all = BTreeMap::<_, Vec<f64>>::new();
        let put = &mut |name, numbers: &[f64]| all.entry(name).or_default().extend(numbers);
        self.controller.compensator.describe(&self.ended(), put);
        all
    }

    /// P, row-major; `None` without a compensator.
    pub fn p(&self) -> Option<Vec<f64>> {
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

    /// The design report, along a course if there is one.
    pub fn report(
        &self,
        course: Option<&Course<N>>,
        conditions: &Conditions<'_>,
    ) -> PyResult<Report<N>> {
        let Controller { law, compensator, limits, .. } = &*self.controller;
        let law = law.computed()?;
        let report = Report::new(law, limits, compensator.subject(), course, conditions);
        // As Python names it.
        report.map_err(|error| match error.parameter() {
            "delay_samples" => value_error(error.named("delay")),
            _ => value_error(error),
        })
    }
}

/// Limits of effort and of its rate, and the torque at take-over, as arguments.
pub(super) fn said(trackers: &Trackers) -> [Option<Vec<f64>>; 3] {
    each!(trackers, Trackers, it => {
        let Limits { effort_limit, effort_rate_limit } = &it.controller.limits;
        let last_tau = it.last_tau.map(|tau| tau.as_slice().to_vec());
        [limits(effort_limit), limits(effort_rate_limit), last_tau]
    })
}

pub(super) fn front(trackers: &Trackers) -> Front {
    each!(trackers, Trackers, it => it.controller.front)
}

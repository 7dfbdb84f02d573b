//! The design report as a dict, and the choices that do nothing.

use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::controller::PyController;
use super::convert::{Any, Array, Given, count, joints, numbers, object, scalar, wrong_shape};
use super::dispatch::{each, of_joints, other_joints};
use super::guard::PyGuard;
use super::plant::{Plant, Plants, PyPlant};
use super::sources::Source;
use super::tracked::{Tracker, Trackers, front};
use crate::arm::Arm;
use crate::control::Sample;
use crate::design::{ArmFacts, Conditions, Course, Finding, JointReport, Learning, Report};
use crate::math::Vector;
use crate::reference::Reference;

/// The path of a design, and the plant.
struct Along<'a, 'py> {
    path: Given<'a, 'py>,
    duration: Option<f64>,
    plant: Option<&'a Plants>,
    inertia_ratio: f64,
}

impl<'a, 'py> Along<'a, 'py> {
    fn new(
        path: Given<'a, 'py>,
        duration: Given<'_, 'py>,
        plant: Given<'a, 'py>,
        inertia_ratio: f64,
    ) -> PyResult<Self> {
        let duration = duration.map(|it| scalar(it, "duration")).transpose()?;
        let plant = plant.map(|plant| object::<PyPlant>(plant, "plant", "a Plant")).transpose()?;
        let plant = plant.map(|plant| &plant.get().plants);
        Ok(Self { path, duration, plant, inertia_ratio })
    }

    fn plant<const N: usize>(&self) -> PyResult<Option<&'a Plant<N>>> {
        let Some(plants) = self.plant else { return Ok(None) };
        let plant = each!(plants, Plants, plant => of_joints::<Plant<N>>(&**plant));
        plant.map(Some).ok_or_else(|| other_joints("plant", plants.joints(), N))
    }

    /// The path with the arms along it. What a callable raises is raised; `quiet`: disturbances
    /// that are callables are left out, and nothing is called.
    fn course<const N: usize>(
        &self,
        tracker: &Tracker<N>,
        quiet: bool,
    ) -> PyResult<Option<Course<N>>> {
        let plant = self.plant()?;
        let (Some(path), Some(duration)) = (self.path, self.duration) else { return Ok(None) };
        let reference = Source::<N>::reference(path, "path")?;
        let arm = tracker.controller.law.arm();
        let course = match plant {
            Some(plant) if quiet && plant.disturbance.as_ref().is_some_and(Source::calls) => {
                let still = crate::plant::Plant::new(plant.arm.clone(), None::<Source<N>>);
                let still = still.with_effort_limit(*plant.effort_limit())?;
                Course::new(arm, &still, &reference, duration)
            }
            Some(plant) => Course::new(arm, plant, &reference, duration),
            None => Course::believed(arm, self.inertia_ratio, &reference, duration),
        };
        let of_plant = plant.filter(|_| !quiet).and_then(|plant| plant.disturbance.as_ref());
        if let Some(error) = reference.raised().or(of_plant.and_then(Source::raised)) {
            return Err(error);
        }
        Ok(Some(course?.limited(&tracker.controller.limits.effort_limit)))
    }
}

/// Run `steadyarm.design`: figures joint by joint, findings in words, and the verdict.
///
/// ``delay``: None is what the tracker knows of. ``velocity_filter``: of the loop, where the
/// tracker has none [Hz].
#[pyfunction]
#[pyo3(signature = (tracker, control_period, delay, velocity_filter, disturbance, inertia_ratio,
    path, plant, duration))]
#[expect(clippy::too_many_arguments, reason = "called from one Python function")]
pub(super) fn design<'py>(
    py: Python<'py>,
    tracker: Any<'_, 'py>,
    control_period: Any<'_, 'py>,
    delay: Given<'_, 'py>,
    velocity_filter: Given<'_, 'py>,
    disturbance: Given<'_, 'py>,
    inertia_ratio: Any<'_, 'py>,
    path: Given<'_, 'py>,
    plant: Given<'_, 'py>,
    duration: Given<'_, 'py>,
) -> PyResult<Bound<'py, PyDict>> {
    let tracker =
        object::<PyController>(tracker, "tracker", "a Controller, such as a ComputedTorque")?;
    let tracker = tracker.try_borrow()?;
    let control_period = scalar(control_period, "control_period")?;
    let inertia_ratio = scalar(inertia_ratio, "inertia_ratio")?;
    let along = Along::new(path, duration, plant, inertia_ratio)?;
    let own = front(&tracker.trackers);
    let delay_samples = delay.map_or(Ok(own.delay), |delay| count(delay, "delay", 0))?;
    let given = velocity_filter.map(|it| scalar(it, "velocity_filter")).transpose()?;
    let disturbance = disturbance.map(harmonics).transpose()?;
    let conditions = Conditions {
        control_period,
        delay_samples,
        velocity_filter: own.velocity_filter.or(given),
        disturbance: disturbance.as_deref(),
        inertia_ratio,
    };
    each!(&tracker.trackers, Trackers, it => report(py, it, &along, &conditions))
}

fn report<'py, const N: usize>(
    py: Python<'py>,
    tracker: &Tracker<N>,
    along: &Along<'_, 'py>,
    conditions: &Conditions<'_>,
) -> PyResult<Bound<'py, PyDict>> {
    let course = along.course(tracker, false)?;
    let report = tracker.report(course.as_ref(), conditions)?;
    let (known, sound, verdict) = (report.known(), report.sound(), report.verdict());
    let Report { joints, learning, findings, left_out } = report;
    let dict = figures(py, &joints, if conditions.velocity_filter.is_some() { 4 } else { 3 })?;
    dict.set_item("known", known)?;
    dict.set_item("sound", sound)?;
    dict.set_item("verdict", verdict)?;
    dict.set_item("findings", words(&findings))?;
    dict.set_item("left_out", left_out)?;
    let Some(Learning { directions, rules_excited, survives, rules, .. }) = learning else {
        return Ok(dict);
    };
    dict.set_item("rules", rules)?;
    dict.set_item("rules_excited", rules_excited.map(Vec::from))?;
    dict.set_item("directions", Vec::from(directions))?;
    dict.set_item("survives", survives.map(|it| Array::from(Vec::from(it))))?;
    Ok(dict)
}

/// With so many poles of each joint.
fn figures<'py>(
    py: Python<'py>,
    joints: &[JointReport],
    order: usize,
) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    let set = |name, value: fn(&JointReport) -> f64| {
        let values: Vec<f64> = joints.iter().map(value).collect();
        dict.set_item(name, Array::from(values))
    };
    set("p11", |j| j.p.p11)?;
    set("p12", |j| j.p.p12)?;
    set("p22", |j| j.p.p22)?;
    set("min_eigenvalue", |j| j.min_eigenvalue)?;
    set("max_real", |j| j.max_real)?;
    set("gamma_opt", |j| j.gamma_opt)?;
    set("max_scale", |j| j.max_scale)?;
    set("k_i", |j| j.k_i)?;
    set("rms_without", |j| j.rms[0])?;
    set("rms", |j| j.rms[1])?;
    set("sampled_radius", |j| j.sampled_radius)?;
    set("max_period", |j| j.max_period)?;
    set("stiffness", |j| j.stiffness)?;
    set("damping", |j| j.damping)?;
    set("inertia_ratio", |j| j.inertia_ratio)?;
    let poles = joints.iter().map(|j| j.poles.map(|z| (z.re, z.im))[..order].to_vec());
    dict.set_item("poles", poles.collect::<Vec<_>>())?;
    Ok(dict)
}

/// Tell the choices of a simulation that do nothing, or ruin it, in words.
///
/// ``tracker`` may be a guard. ``path`` is the reference, or what was recorded of it; None if it is
/// not known. No callable of the plant is called.
#[pyfunction]
#[pyo3(signature = (tracker, plant, path, duration, q0))]
pub(super) fn choices<'py>(
    tracker: Any<'_, 'py>,
    plant: Any<'_, 'py>,
    path: Given<'_, 'py>,
    duration: Any<'_, 'py>,
    q0: Given<'_, 'py>,
) -> PyResult<Vec<String>> {
    let along = Along::new(path, Some(duration), Some(plant), 1.0)?;
    let guard = tracker.cast::<PyGuard>().ok().map(|guard| guard.try_borrow()).transpose()?;
    if let Some(guard) = guard {
        let limit = guard.effort_limit();
        let tracker = guard.tracker.bind(tracker.py()).try_borrow()?;
        return each!(&tracker.trackers, Trackers, it => chosen(it, &along, q0, Some(&limit)));
    }
    let tracker =
        object::<PyController>(tracker, "tracker", "a Controller, such as a ComputedTorque")?;
    let tracker = tracker.try_borrow()?;
    each!(&tracker.trackers, Trackers, it => chosen(it, &along, q0, None))
}

/// With the `effort_limit` of a guard, if there is one.
fn chosen<const N: usize>(
    tracker: &Tracker<N>,
    along: &Along<'_, '_>,
    q0: Given<'_, '_>,
    effort_limit: Option<&[f64]>,
) -> PyResult<Vec<String>> {
    // Nothing is known of another law's choices.
    let Ok(law) = tracker.controller.law.computed() else { return Ok(Vec::new()) };
    let mut course = along.course(tracker, true)?;
    if let Some(limit) = effort_limit.and_then(|limit| <&[f64; N]>::try_from(limit).ok()) {
        course = course.map(|course| course.limited(limit));
    }
    let q0 = q0.map_or(Ok([0.0; N]), |q0| joints(q0, "q0"))?;
    let start =
        along.path.map(|path| Source::<N>::reference(path, "path")).transpose()?.map(|reference| {
            let wraps = law.arm.wraps();
            Sample::wrapped(Vector::from(q0), Vector::zeros(), reference.at(0.0), &wraps)
        });
    let limits = &tracker.controller.limits;
    let arm = ArmFacts::of(&law.arm, course.as_ref(), limits);
    let compensator = tracker.controller.compensator.subject();
    let mut choices = arm.choices(&law.gains, compensator, course.as_ref());
    choices.start = start;
    Ok(words(&choices.findings()?))
}

fn words(findings: &[Finding]) -> Vec<String> {
    findings.iter().map(ToString::to_string).collect()
}

/// (K, 2): amplitude, frequency.
fn harmonics(value: Any<'_, '_>) -> PyResult<Vec<(f64, f64)>> {
    let pairs = numbers(value, "disturbance")?;
    if !matches!(pairs.shape[..], [0] | [_, 2]) {
        return Err(wrong_shape("disturbance", &pairs.shape, "(K, 2): amplitude, frequency"));
    }
    let pairs = pairs.values.as_chunks().0.iter();
    Ok(pairs.map(|&[amplitude, frequency]| (amplitude, frequency)).collect())
}

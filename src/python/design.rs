//! The design report as a dict.

use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::convert::{Any, Array, count, numbers, scalar, wrong_shape, wrong_type};
use super::dispatch::each;
use super::tracked::Trackers;
use super::tracker::PyComputedTorque;
use crate::design::{Conditions, Finding, JointReport};

/// Run `steadyarm.design`: figures joint by joint, findings in words, and the verdict.
#[pyfunction]
pub(super) fn design<'py>(
    py: Python<'py>,
    tracker: Any<'_, 'py>,
    period: Any<'_, 'py>,
    delay: Any<'_, 'py>,
    disturbance: Any<'_, 'py>,
    inertia_ratio: Any<'_, 'py>,
) -> PyResult<Bound<'py, PyDict>> {
    let tracker = tracker
        .cast::<PyComputedTorque>()
        .map_err(|_| wrong_type("tracker", tracker, "a ComputedTorque"))?
        .try_borrow()?;
    let period = scalar(period, "period")?;
    let inertia_ratio = scalar(inertia_ratio, "inertia_ratio")?;
    let delay = samples(delay)?;
    let pairs = numbers(disturbance, "disturbance")?;
    if !matches!(pairs.shape[..], [0] | [_, 2]) {
        return Err(wrong_shape("disturbance", &pairs.shape, "(K, 2): amplitude, frequency"));
    }
    let disturbance: Vec<(f64, f64)> = pairs
        .values
        .as_chunks()
        .0
        .iter()
        .map(|&[amplitude, frequency]| (amplitude, frequency))
        .collect();
    let disturbance = disturbance.as_slice();
    let conditions = Conditions { period, delay_samples: delay, disturbance, inertia_ratio };
    let (joints, findings) = each!(&tracker.trackers, Trackers, it => it.report(&conditions))?;
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
    let poles = joints.iter().map(|j| j.poles.map(|z| (z.re, z.im)).to_vec());
    dict.set_item("poles", poles.collect::<Vec<_>>())?;
    dict.set_item("sound", !findings.iter().any(Finding::refuses))?;
    let findings: Vec<String> = findings.iter().map(ToString::to_string).collect();
    dict.set_item("findings", findings)?;
    Ok(dict)
}

/// Samples of delay, a whole number ≥ 0.
fn samples(delay: Any<'_, '_>) -> PyResult<usize> {
    count(delay, "delay", 0)
}

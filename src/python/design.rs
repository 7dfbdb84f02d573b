//! The design report as a dict.

use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::convert::{Any, columns, count, numbers, object, scalar, wrong_shape};
use super::dispatch::each;
use super::tracked::Trackers;
use super::tracker::PyComputedTorque;
use crate::design::{Conditions, Finding};

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
    let tracker =
        object::<PyComputedTorque>(tracker, "tracker", "a ComputedTorque")?.try_borrow()?;
    let period = scalar(period, "period")?;
    let inertia_ratio = scalar(inertia_ratio, "inertia_ratio")?;
    let delay_samples = count(delay, "delay", 0)?;
    let pairs = numbers(disturbance, "disturbance")?;
    if !matches!(pairs.shape[..], [0] | [_, 2]) {
        return Err(wrong_shape("disturbance", &pairs.shape, "(K, 2): amplitude, frequency"));
    }
    let disturbance: Vec<(f64, f64)> =
        pairs.values.as_chunks().0.iter().map(|&x: &[f64; 2]| x.into()).collect();
    let disturbance = disturbance.as_slice();
    let conditions = Conditions { period, delay_samples, disturbance, inertia_ratio };
    let (joints, findings) = each!(&tracker.trackers, Trackers, it => it.report(&conditions))?;
    let dict = columns!(py, joints, |j|
        p11: j.p.p11, p12: j.p.p12, p22: j.p.p22, min_eigenvalue: j.min_eigenvalue,
        max_real: j.max_real, gamma_opt: j.gamma_opt, max_scale: j.max_scale, k_i: j.k_i,
        rms_without: j.rms[0], rms: j.rms[1], sampled_radius: j.sampled_radius,
        max_period: j.max_period,
    );
    let poles = joints.iter().map(|j| j.poles.map(|z| (z.re, z.im)).to_vec());
    dict.set_item("poles", poles.collect::<Vec<_>>())?;
    dict.set_item("sound", !findings.iter().any(Finding::refuses))?;
    let findings: Vec<String> = findings.iter().map(ToString::to_string).collect();
    dict.set_item("findings", findings)?;
    Ok(dict)
}

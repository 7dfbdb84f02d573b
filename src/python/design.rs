//! The design report as a dict.

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::convert::owned1;
use super::tracker::{AnyCompensator, PyComputedTorque};
use super::value_error;
use crate::design::{Conditions, JointReport, Report};

/// Figures joint by joint, findings in words, and the verdict.
#[pyfunction]
pub(super) fn design<'py>(
    py: Python<'py>,
    tracker: &Bound<'py, PyComputedTorque>,
    period: f64,
    delay: usize,
    disturbance: Vec<(f64, f64)>,
    inertia_ratio: f64,
) -> PyResult<Bound<'py, PyDict>> {
    let tracker = tracker.borrow();
    let AnyCompensator::Fuzzy(fuzzy) = &tracker.controller.compensator else {
        return Err(PyTypeError::new_err(
            "tracker: got one without a compensator, wants one to report on",
        ));
    };
    let disturbance = disturbance.as_slice();
    let conditions = Conditions { period, delay_samples: delay, disturbance, inertia_ratio };
    let report = Report::new(&tracker.controller.gains, fuzzy, &conditions).map_err(value_error)?;
    let dict = PyDict::new(py);
    let set = |name, value: fn(&JointReport) -> f64| {
        let values: Vec<f64> = report.joints.iter().map(value).collect();
        dict.set_item(name, owned1(py, values))
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
    let poles = report.joints.iter().map(|j| j.poles.map(|z| (z.re, z.im)).to_vec());
    dict.set_item("poles", poles.collect::<Vec<_>>())?;
    let findings: Vec<String> = report.findings.iter().map(ToString::to_string).collect();
    dict.set_item("findings", findings)?;
    dict.set_item("sound", report.sound())?;
    Ok(dict)
}

//! The Python extension module `steadyarm._core`. Documentation for users stands in `_core.pyi` and
//! in the package.

mod any_arm;
mod any_law;
mod arm;
mod basis;
mod compensator;
mod controller;
mod convert;
mod curves;
mod describe;
mod design;
mod dispatch;
mod disturbances;
mod effects;
mod errors;
mod form;
mod fuzzy;
mod guard;
mod guarding;
mod limits;
mod many;
mod monitor;
mod per_joint;
mod plant;
mod riccati;
mod saving;
mod scenario;
mod serial;
mod serial_changes;
mod serial_files;
mod simulate;
mod sources;
mod tracked;
mod tracker;
mod two_link;

use pyo3::prelude::*;

/// Python places objects at multiples of 16 bytes: what wants more has to stand in a box.
const fn fits_python<T>() -> bool {
    align_of::<T>() <= 16
}

const _: () = {
    assert!(fits_python::<two_link::PyTwoLink>() && fits_python::<serial::PySerial>());
    assert!(fits_python::<basis::PyFuzzyBasis>() && fits_python::<riccati::PySolution>());
    assert!(fits_python::<fuzzy::PyFuzzyApproximator>());
    assert!(fits_python::<fuzzy::PyFuzzyCompensator>());
    assert!(fits_python::<curves::PyCurve>() && fits_python::<plant::PyPlant>());
    assert!(fits_python::<controller::PyController>());
    assert!(fits_python::<tracker::PyComputedTorque>());
};

/// The compiled core; `steadyarm` has all but the functions that its own are made of.
///
/// Equation numbers are those of the paper. Arrays may be lists, tuples, or numpy arrays of any
/// real type, order and stride. They are copied, and what comes back is always a new float64 array.
///
/// Arms have n joints, 1 to 12. Where a scalar stands for a vector it counts for all joints. What
/// was given scalars only fits any arm; where there is no arm, it is taken for one of two joints.
///
/// Errors name the argument, what it got and what it wants: ``TypeError`` for a wrong type,
/// ``ValueError`` for a wrong shape or value (NaN and infinity included).
#[pymodule]
#[pyo3(name = "_core")]
mod core_module {
    #[pymodule_export]
    const MAX_RECORD_BYTES: u64 = crate::sim::MAX_RECORD_BYTES;

    #[pymodule_export]
    use super::arm::PyArm;
    #[pymodule_export]
    use super::basis::PyFuzzyBasis;
    #[pymodule_export]
    use super::controller::PyController;
    #[pymodule_export]
    use super::curves::{PyCurve, PyQuintic, PySines, PyTable, PyWaypoints};
    #[pymodule_export]
    use super::describe::describe;
    #[pymodule_export]
    use super::design::{choices, design};
    #[pymodule_export]
    use super::disturbances::{PyDisturbance, PyNoise, PyPulses, PyWrench};
    #[pymodule_export]
    use super::effects::PyEffects;
    #[pymodule_export]
    use super::errors::NoStabilizingSolution;
    #[pymodule_export]
    use super::form::PyForm;
    #[pymodule_export]
    use super::fuzzy::{PyFuzzyApproximator, PyFuzzyCompensator};
    #[pymodule_export]
    use super::guard::PyGuard;
    #[pymodule_export]
    use super::limits::PyExcess;
    #[pymodule_export]
    use super::many::simulate_many;
    #[pymodule_export]
    use super::plant::PyPlant;
    #[pymodule_export]
    use super::riccati::{PySolution, bounded_real_riccati, care};
    #[pymodule_export]
    use super::scenario::{canonical_scenario, paper_scenario, read_scenario};
    #[pymodule_export]
    use super::serial::PySerial;
    #[pymodule_export]
    use super::simulate::{channels, metrics, simulate};
    #[pymodule_export]
    use super::sources::desired_motion;
    #[pymodule_export]
    use super::tracker::PyComputedTorque;
    #[pymodule_export]
    use super::two_link::PyTwoLink;
}

//! Numbers that may be said once for all joints, before an arm says how many there are.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use super::convert::{Any, numbers, wrong_shape};
use super::dispatch::MAX_JOINTS;
use super::errors::value_error;
use crate::error::{Error, Problem};
use crate::scenario::{Numbers, PerJoint};

/// From a scalar or an array (n,), as `name`.
pub(super) fn per_joint(value: Any<'_, '_>, name: &str) -> PyResult<PerJoint> {
    let list = numbers(value, name)?;
    match list.shape[..] {
        [] => Ok(PerJoint::All(list.values[0])),
        [1..=MAX_JOINTS] => Ok(PerJoint::Each(list.values)),
        _ => {
            let wanted = format!("a scalar or (n,) with n from 1 to {MAX_JOINTS}");
            Err(wrong_shape(name, &list.shape, &wanted))
        }
    }
}

/// Rows of so many finite numbers.
pub(super) fn rows(values: &[f64], columns: usize) -> Vec<Vec<f64>> {
    values.chunks_exact(columns).map(Vec::from).collect()
}

/// Amplitudes of harmonics: as [`per_joint`] for a single frequency, else (K, n).
pub(super) fn amplitudes(
    value: Any<'_, '_>,
    name: &str,
    frequency: &PerJoint,
) -> PyResult<Numbers> {
    let Some(count) = frequency.count() else { return per_joint(value, name).map(Numbers::Same) };
    let list = numbers(value, name)?;
    match list.shape[..] {
        [rows_given, columns @ 1..=MAX_JOINTS] if rows_given == count => {
            super::convert::finite_entries(name, columns, &list.values)?;
            Ok(Numbers::Rows(rows(&list.values, columns)))
        }
        _ => {
            let wanted = format!("({count}, n) with n from 1 to {MAX_JOINTS}");
            Err(wrong_shape(name, &list.shape, &wanted))
        }
    }
}

/// The error of arguments that are for different joint counts.
pub(super) fn other_count(error: Error) -> PyErr {
    let Problem::WrongLength { got, wanted, .. } = error.problem() else {
        return value_error(error);
    };
    let name = error.parameter();
    PyValueError::new_err(format!("{name}: got values for {got} joints, wants {wanted}"))
}

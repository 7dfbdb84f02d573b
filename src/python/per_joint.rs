//! One number for all joints, or one a joint, before an arm says how many there are.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use super::convert::{Array1, Numbers, numbers, owned1, wrong_shape};
use super::dispatch::{DEFAULT_JOINTS, MAX_JOINTS};

/// One number for all joints, or one a joint.
#[derive(Clone, PartialEq)]
pub(super) enum PerJoint {
    All(f64),
    Each(Vec<f64>),
}

impl core::fmt::Debug for PerJoint {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::All(value) => value.fmt(f),
            Self::Each(values) => values.fmt(f),
        }
    }
}

impl PerJoint {
    /// From a scalar or an array (n,), as `name`.
    pub fn new(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Self> {
        let Numbers { shape, values } = numbers(value, name)?;
        match shape[..] {
            [] => Ok(Self::All(values[0])),
            [1..=MAX_JOINTS] => Ok(Self::Each(values)),
            _ => {
                let wanted = format!("a scalar or (n,) with n from 1 to {MAX_JOINTS}");
                Err(wrong_shape(name, &shape, &wanted))
            }
        }
    }

    /// As [`new`](Self::new), or what to take without an argument.
    pub fn or(value: Option<&Bound<'_, PyAny>>, default: f64, name: &str) -> PyResult<Self> {
        value.map_or(Ok(Self::All(default)), |value| Self::new(value, name))
    }

    /// The number of values, if it is one a joint.
    pub fn len(&self) -> Option<usize> {
        if let Self::Each(values) = self { Some(values.len()) } else { None }
    }

    /// The values of `count` joints.
    pub fn values(&self, count: usize) -> Vec<f64> {
        match self {
            Self::All(value) => vec![*value; count],
            Self::Each(values) => values.clone(),
        }
    }

    /// The values of `N` joints.
    pub fn each<const N: usize>(&self, name: &str) -> PyResult<[f64; N]> {
        match self {
            Self::All(value) => Ok([*value; N]),
            Self::Each(values) => values
                .as_slice()
                .try_into()
                .map_err(|_| wrong_shape(name, &[values.len()], &format!("a scalar or ({N},)"))),
        }
    }

    /// A new array with a value a joint.
    pub fn array<'py>(&self, py: Python<'py>, joints: Option<usize>) -> Array1<'py> {
        owned1(py, self.values(joints.unwrap_or(DEFAULT_JOINTS)))
    }

    /// As it was given: a float or a list.
    pub fn to_python<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        Ok(match self {
            Self::All(value) => value.into_pyobject(py)?.into_any(),
            Self::Each(values) => values.into_pyobject(py)?.into_any(),
        })
    }
}

/// The joint count that some arguments agree on; `None` if none of them says.
pub(super) fn common_joints<'a>(
    known: Option<usize>,
    arguments: impl IntoIterator<Item = (&'a str, Option<usize>)>,
) -> PyResult<Option<usize>> {
    arguments.into_iter().try_fold(known, |joints, (name, found)| match (joints, found) {
        (Some(wanted), Some(got)) if got != wanted => {
            let message = format!("{name}: got values for {got} joints, wants {wanted}");
            Err(PyValueError::new_err(message))
        }
        (known, found) => Ok(known.or(found)),
    })
}

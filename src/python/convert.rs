//! Between numpy and the core: the only file that names numpy. Arrays are copied at the edge, so that a caller may
//! pass lists, other types, strided or read-only arrays, and may reuse one array for several arguments.

use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

use super::dispatch::{JOINTS, JointVector};

/// A one-dimensional array.
pub(super) type Array1<'py> = Bound<'py, PyArray1<f64>>;

/// A two-dimensional array.
pub(super) type Array2<'py> = Bound<'py, PyArray2<f64>>;

/// Numbers of any shape, row-major.
pub(super) struct Numbers {
    pub shape: Vec<usize>,
    pub values: Vec<f64>,
}

/// Anything numpy takes for an array of real numbers.
pub(super) fn numbers(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Numbers> {
    let numpy = value.py().import("numpy")?;
    let array = numpy.call_method1("asarray", (value,)).map_err(|error| {
        PyTypeError::new_err(format!("{name}: got {}, wants numbers ({error})", type_name(value)))
    })?;
    let kind: String = array.getattr("dtype")?.getattr("kind")?.extract()?;
    if !matches!(kind.as_str(), "b" | "i" | "u" | "f") {
        let dtype = array.getattr("dtype")?.str()?;
        let message = format!("{name}: got an array of dtype {dtype}, wants real numbers");
        return Err(PyTypeError::new_err(message));
    }
    let shape: Vec<usize> = array.getattr("shape")?.extract()?;
    let flat = numpy.call_method1("ascontiguousarray", (array, "float64"))?;
    let flat = flat.call_method1("reshape", (-1,))?;
    let flat: PyReadonlyArray1<'_, f64> = flat.extract()?;
    Ok(Numbers { shape, values: flat.as_slice()?.to_vec() })
}

/// One value a joint: shape (n,).
#[inline]
pub(super) fn vector(value: &Bound<'_, PyAny>, name: &str) -> PyResult<JointVector> {
    if let Ok(array) = value.cast::<PyArray1<f64>>()
        && let Ok(array) = array.try_readonly()
        && let Ok(&values) =
            array.as_slice().map_err(|_| ()).and_then(|s| s.try_into().map_err(|_| ()))
    {
        let values: [f64; JOINTS] = values;
        return Ok(values.into());
    }
    let Numbers { shape, values } = numbers(value, name)?;
    match <[f64; JOINTS]>::try_from(values) {
        Ok(values) if shape.len() == 1 => Ok(values.into()),
        _ => Err(wrong_shape(name, &shape, &format!("({JOINTS},)"))),
    }
}

/// One value a joint, or a scalar for all joints.
pub(super) fn joints(value: &Bound<'_, PyAny>, name: &str) -> PyResult<[f64; JOINTS]> {
    let Numbers { shape, values } = numbers(value, name)?;
    match (shape.len(), values.as_slice().try_into()) {
        (0, _) => Ok([values[0]; JOINTS]),
        (1, Ok(values)) => Ok(values),
        _ => Err(wrong_shape(name, &shape, &format!("a scalar or ({JOINTS},)"))),
    }
}

/// A single finite or infinite number.
pub(super) fn scalar(value: &Bound<'_, PyAny>, name: &str) -> PyResult<f64> {
    let Numbers { shape, values } = numbers(value, name)?;
    match values.as_slice() {
        [x] if shape.is_empty() => Ok(*x),
        _ => Err(wrong_shape(name, &shape, "a scalar")),
    }
}

/// A matrix of any size: rows, columns, values row-major.
pub(super) fn matrix(value: &Bound<'_, PyAny>, name: &str) -> PyResult<(usize, usize, Vec<f64>)> {
    let Numbers { shape, values } = numbers(value, name)?;
    match shape[..] {
        [rows, columns] => Ok((rows, columns, values)),
        _ => Err(wrong_shape(name, &shape, "two dimensions")),
    }
}

/// A matrix of this size, row-major.
pub(super) fn matrix_of(
    value: &Bound<'_, PyAny>,
    name: &str,
    rows: usize,
    columns: usize,
) -> PyResult<Vec<f64>> {
    let Numbers { shape, values } = numbers(value, name)?;
    if shape == [rows, columns] {
        Ok(values)
    } else {
        Err(wrong_shape(name, &shape, &format!("({rows}, {columns})")))
    }
}

/// "name: got shape …, wants …".
pub(super) fn wrong_shape(name: &str, shape: &[usize], wanted: &str) -> PyErr {
    let got: Vec<String> = shape.iter().map(ToString::to_string).collect();
    let comma = if shape.len() == 1 { "," } else { "" };
    PyValueError::new_err(format!("{name}: got shape ({}{comma}), wants {wanted}", got.join(", ")))
}

/// A new array of shape (n,).
#[inline]
pub(super) fn array1<'py>(py: Python<'py>, values: &[f64]) -> Array1<'py> {
    PyArray1::from_slice(py, values)
}

/// A new array of shape (len,), without a copy.
pub(super) fn owned1<'py>(py: Python<'py>, values: Vec<f64>) -> Array1<'py> {
    PyArray1::from_vec(py, values)
}

/// A new array of shape (rows, columns), without a copy.
pub(super) fn owned2<'py>(
    py: Python<'py>,
    values: Vec<f64>,
    columns: usize,
) -> PyResult<Array2<'py>> {
    let rows = values.len() / columns.max(1);
    PyArray1::from_vec(py, values).reshape([rows, columns])
}

/// Name of a value's type, for messages.
pub(super) fn type_name(value: &Bound<'_, PyAny>) -> String {
    value.get_type().name().map_or_else(|_| "an object".into(), |name| name.to_string())
}

//! Between numpy and the core: the only file that names numpy. Arrays are copied at the edge, so
//! that a caller may pass lists, other types, strided or read-only arrays, and may reuse one array
//! for several arguments.

use numpy::{PyArray1, PyArrayMethods, PyReadonlyArray1, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::PyTypeCheck;
use pyo3::exceptions::{PyException, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyFloat, PyList, PyTuple};

use crate::error::{Error, finite};
use crate::math::{Matrix, Vector};

/// Lists in lists that numpy takes for an array, at the most.
const MAX_DIMENSIONS: usize = 64;

/// An argument of any type.
pub(super) type Any<'a, 'py> = &'a Bound<'py, PyAny>;
/// One that may be left out.
pub(super) type Given<'a, 'py> = Option<Any<'a, 'py>>;

/// A one-dimensional array.
pub(super) type Array1<'py> = Bound<'py, PyArray1<f64>>;

/// Up to this many numbers are copied: that takes less time than to hand a vector over.
const FEW: usize = 64;

/// Numbers that become a new array of D dimensions.
pub(super) struct Array<const D: usize> {
    values: Vec<f64>,
    shape: [usize; D],
}

impl From<Vec<f64>> for Array<1> {
    fn from(values: Vec<f64>) -> Self {
        Self { shape: [values.len()], values }
    }
}

impl From<&[f64]> for Array<1> {
    fn from(values: &[f64]) -> Self {
        values.to_vec().into()
    }
}

impl<const N: usize> From<Vector<N>> for Array<1> {
    fn from(values: Vector<N>) -> Self {
        values.as_slice().into()
    }
}

impl<const N: usize> From<Matrix<N>> for Array<2> {
    fn from(matrix: Matrix<N>) -> Self {
        Self { values: matrix.transpose().as_slice().to_vec(), shape: [N, N] }
    }
}

impl Array<2> {
    /// (rows, columns), from its rows.
    pub fn rows(values: Vec<f64>, columns: usize) -> Self {
        Self { shape: [values.len() / columns.max(1), columns], values }
    }
}

impl Array<3> {
    /// (count, size, size).
    pub fn matrices(values: Vec<f64>, size: usize) -> Self {
        Self { shape: [values.len() / (size * size).max(1), size, size], values }
    }
}

impl<'py, const D: usize> IntoPyObject<'py> for Array<D> {
    type Target = PyAny;
    type Output = Bound<'py, PyAny>;
    type Error = PyErr;

    fn into_pyobject(self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let Self { values, shape } = self;
        let few = values.len() <= FEW;
        let flat = if few { array1(py, &values) } else { PyArray1::from_vec(py, values) };
        Ok(if D == 1 { flat.into_any() } else { flat.reshape(&shape[..])?.into_any() })
    }
}

/// Numbers of any shape, row-major.
pub(super) struct Numbers {
    pub shape: Vec<usize>,
    pub values: Vec<f64>,
}

/// An object of a class.
pub(super) fn object<'a, 'py, T: PyTypeCheck>(
    value: Any<'a, 'py>,
    name: &str,
    wanted: &str,
) -> PyResult<&'a Bound<'py, T>> {
    value.cast::<T>().map_err(|_| wrong_type(name, value, wanted))
}

/// Anything numpy takes for an array of real numbers.
pub(super) fn numbers(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Numbers> {
    let numpy = value.py().import("numpy")?;
    refuse_masked(&numpy, value, name, MAX_DIMENSIONS)?;
    let array = numpy.call_method1("asarray", (value,)).map_err(|error| {
        match error.is_instance_of::<PyException>(value.py()) {
            true => wrong_type(name, value, &format!("real numbers ({error})")),
            false => error, // Ctrl-C is no fault of the value
        }
    })?;
    let kind: String = array.getattr("dtype")?.getattr("kind")?.extract()?;
    if !matches!(kind.as_str(), "b" | "i" | "u" | "f") {
        if array.getattr("ndim")?.extract::<usize>()? == 0 && !value.is(&array) {
            return Err(wrong_type(name, value, "real numbers"));
        }
        let dtype = array.getattr("dtype")?.str()?;
        let message = format!("{name}: got an array of dtype {dtype}, wants real numbers");
        return Err(PyTypeError::new_err(message));
    }
    let shape: Vec<usize> = array.getattr("shape")?.extract()?;
    // A copy of our own: contiguous, aligned, in native byte order.
    let flat = numpy.call_method1("array", (array, "float64"))?;
    let flat = flat.call_method1("reshape", (-1,))?;
    let flat: PyReadonlyArray1<'_, f64> = flat.extract()?;
    Ok(Numbers { shape, values: flat.as_slice()?.to_vec() })
}

/// Refuses masked entries, which would count as the numbers that are hidden there: in a masked
/// array, or a list of them.
fn refuse_masked(
    numpy: &Bound<'_, PyModule>,
    value: &Bound<'_, PyAny>,
    name: &str,
    depth: usize,
) -> PyResult<()> {
    if depth == 0 || is_ndarray(value) || value.is_exact_instance_of::<PyFloat>() {
        return Ok(());
    }
    if value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>() {
        let mut entries = value.try_iter()?;
        return entries.try_for_each(|entry| refuse_masked(numpy, &entry?, name, depth - 1));
    }
    let ma = numpy.getattr("ma")?;
    if !value.is_instance(&ma.getattr("MaskedArray")?)? {
        return Ok(());
    }
    let masked: usize = ma.call_method1("count_masked", (value,))?.extract()?;
    if masked == 0 {
        return Ok(());
    }
    let size: usize = value.getattr("size")?.extract()?;
    Err(PyValueError::new_err(format!(
        "{name}: got a masked array with {masked} of {size} entries masked, wants a number in \
         each; \
         its method filled puts some there"
    )))
}

/// Whether it is an array of numpy's own, and not of a class made of it, which may mean something
/// else.
#[inline]
fn is_ndarray(value: &Bound<'_, PyAny>) -> bool {
    value.is_exact_instance_of::<PyUntypedArray>()
}

/// The entries of a plain array of so many numbers; `None` for anything else.
#[inline]
fn plain<'a>(value: Any<'a, '_>, count: usize) -> Option<impl Fn(usize) -> f64 + 'a> {
    let array = value.cast::<PyArray1<f64>>().ok().filter(|_| is_ndarray(value))?;
    let whole = array.strides()[0] % (align_of::<f64>() as isize) == 0;
    let readable = array.len() == count && array.data().is_aligned() && whole;
    readable.then_some(|n| array.get_owned([n]).unwrap_or(f64::NAN))
}

/// One value a joint: shape (n,).
#[inline]
pub(super) fn vector<const N: usize>(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Vector<N>> {
    if let Some(entry) = plain(value, N) {
        return Ok(Vector::from_fn(|n, _| entry(n)));
    }
    let Numbers { shape, values } = numbers(value, name)?;
    match <[f64; N]>::try_from(values) {
        Ok(values) if shape.len() == 1 => Ok(values.into()),
        _ => Err(wrong_shape(name, &shape, &format!("({N},)"))),
    }
}

/// One value a joint, or a scalar for all joints.
pub(super) fn joints<const N: usize>(value: &Bound<'_, PyAny>, name: &str) -> PyResult<[f64; N]> {
    let values = each_joint(Some(value), 0.0, N, name)?;
    Ok(std::array::from_fn(|n| values[n]))
}

/// One value a joint, or a scalar for all joints, or without an argument this one for all.
pub(super) fn each_joint(
    value: Option<&Bound<'_, PyAny>>,
    default: f64,
    joints: usize,
    name: &str,
) -> PyResult<Vec<f64>> {
    let Some(value) = value else { return Ok(vec![default; joints]) };
    if let Some(entry) = plain(value, joints) {
        return Ok((0..joints).map(entry).collect());
    }
    let Numbers { shape, values } = numbers(value, name)?;
    match shape[..] {
        [] => Ok(vec![values[0]; joints]),
        [count] if count == joints => Ok(values),
        _ => Err(wrong_shape(name, &shape, &format!("a scalar or ({joints},)"))),
    }
}

/// One value a joint, each of them finite.
pub(super) fn finite_vector<const N: usize>(
    value: &Bound<'_, PyAny>,
    name: &'static str,
) -> PyResult<Vector<N>> {
    let vector: Vector<N> = vector(value, name)?;
    finite(name, vector.as_slice())?;
    Ok(vector)
}

/// A single finite or infinite number.
#[inline]
pub(super) fn scalar(value: &Bound<'_, PyAny>, name: &str) -> PyResult<f64> {
    if let Ok(value) = value.cast_exact::<PyFloat>() {
        return Ok(value.value());
    }
    let Numbers { shape, values } = numbers(value, name)?;
    match values.as_slice() {
        [x] if shape.is_empty() => Ok(*x),
        _ => Err(wrong_shape(name, &shape, "a scalar")),
    }
}

/// A single number, or what to take without one.
pub(super) fn scalar_or(
    value: Option<&Bound<'_, PyAny>>,
    default: f64,
    name: &str,
) -> PyResult<f64> {
    value.map_or(Ok(default), |value| scalar(value, name))
}

/// A single finite number.
pub(super) fn finite_scalar(value: &Bound<'_, PyAny>, name: &'static str) -> PyResult<f64> {
    let number = scalar(value, name)?;
    finite(name, &[number])?;
    Ok(number)
}

/// A whole number ≥ `least` that a machine can count to.
pub(super) fn count(value: &Bound<'_, PyAny>, name: &str, least: usize) -> PyResult<usize> {
    integer(value, name, &format!("a whole number >= {least}"), |count| *count >= least)
}

/// A whole number from 0 to 2⁶⁴ - 1.
pub(super) fn whole(value: &Bound<'_, PyAny>, name: &str) -> PyResult<u64> {
    integer(value, name, "a whole number from 0 to 2^64 - 1", |_| true)
}

fn integer<T: for<'a, 'py> FromPyObject<'a, 'py, Error = PyErr>>(
    value: &Bound<'_, PyAny>,
    name: &str,
    wanted: &str,
    fits: impl Fn(&T) -> bool,
) -> PyResult<T> {
    match value.extract::<T>() {
        Ok(number) if fits(&number) => Ok(number),
        Err(error) if error.is_instance_of::<PyTypeError>(value.py()) => {
            Err(wrong_type(name, value, wanted))
        }
        _ => Err(PyValueError::new_err(format!("{name}: got {}, wants {wanted}", value.str()?))),
    }
}

/// What one of a few words stands for.
pub(super) fn word<T, const W: usize>(
    value: &Bound<'_, PyAny>,
    name: &str,
    words: [(&str, T); W],
) -> PyResult<T> {
    let wanted = words.each_ref().map(|(word, _)| format!("{word:?}")).join(" or ");
    let text: String = value.extract().map_err(|_| wrong_type(name, value, &wanted))?;
    let found = words.into_iter().find(|(word, _)| *word == text).map(|(_, meant)| meant);
    found.ok_or_else(|| PyValueError::new_err(format!("{name}: got {text:?}, wants {wanted}")))
}

/// True or false.
pub(super) fn flag(value: &Bound<'_, PyAny>, name: &str) -> PyResult<bool> {
    value.extract().map_err(|_| wrong_type(name, value, "True or False"))
}

/// A matrix of any size, finite: rows, columns, values row-major.
pub(super) fn matrix(
    value: &Bound<'_, PyAny>,
    name: &str,
    wanted: &str,
) -> PyResult<(usize, usize, Vec<f64>)> {
    let Numbers { shape, values } = numbers(value, name)?;
    let [rows, columns] = shape[..] else { return Err(wrong_shape(name, &shape, wanted)) };
    finite_entries(name, columns, &values)?;
    Ok((rows, columns, values))
}

/// Refuses NaN and infinities by their row and column.
pub(super) fn finite_entries(name: &str, columns: usize, values: &[f64]) -> PyResult<()> {
    let Some(i) = values.iter().position(|x| !x.is_finite()) else { return Ok(()) };
    let (row, column, got) = (i / columns, i % columns, values[i]);
    let message = format!("{name}[{row}, {column}]: got {got}, wants a finite number");
    Err(PyValueError::new_err(message))
}

/// A finite matrix of this size, row-major.
pub(super) fn matrix_of(
    value: &Bound<'_, PyAny>,
    name: &str,
    rows: usize,
    columns: usize,
) -> PyResult<Vec<f64>> {
    let Numbers { shape, values } = numbers(value, name)?;
    if shape == [rows, columns] {
        finite_entries(name, columns, &values)?;
        Ok(values)
    } else {
        Err(wrong_shape(name, &shape, &format!("({rows}, {columns})")))
    }
}

/// "name: got …, wants …" for a value of the wrong type.
pub(super) fn wrong_type(name: &str, value: &Bound<'_, PyAny>, wanted: &str) -> PyErr {
    PyTypeError::new_err(format!("{name}: got {}, wants {wanted}", type_name(value)))
}

/// The core's error, its parameter under another name.
pub(super) fn renamed(error: Error, name: impl Fn(&'static str) -> &'static str) -> Error {
    error.named(name(error.parameter()))
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

/// Figures of each thing in a slice, as a dict of arrays by name.
macro_rules! columns {
    ($py:expr, $of:expr, |$it:ident| $($name:ident: $figure:expr),* $(,)?) => {{
        let dict = PyDict::new($py);
        $({
            let figures: Vec<f64> = $of.iter().map(|$it| $figure).collect();
            dict.set_item(stringify!($name), $crate::python::convert::Array::from(figures))?;
        })*
        dict
    }};
}

pub(super) use columns;

/// The values in `out`, a float64 array of shape (n,), or in a new array without it.
#[inline]
pub(super) fn written<'py>(
    py: Python<'py>,
    values: &[f64],
    out: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let Some(out) = out else { return Ok(array1(py, values).into_any()) };
    let wanted = "a float64 array that can be written to";
    let array = object::<PyArray1<f64>>(out, "out", wanted)?;
    if array.len() != values.len() {
        return Err(wrong_shape("out", array.shape(), &format!("({},)", values.len())));
    }
    let mut array = array.try_readwrite().map_err(|error| {
        PyValueError::new_err(format!("out: got one that is read-only ({error}), wants {wanted}"))
    })?;
    for (n, value) in values.iter().enumerate() {
        if let Some(entry) = array.get_mut([n]) {
            *entry = *value;
        }
    }
    Ok(out.clone())
}

/// Name of a value's type, for messages.
pub(super) fn type_name(value: &Bound<'_, PyAny>) -> String {
    value.get_type().name().map_or_else(|_| "an object".into(), |name| name.to_string())
}

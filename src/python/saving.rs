//! Files: written by the one writer of the Python package, and read by its reader.

use std::ffi::CString;
use std::fs;
use std::path::Path;

use pyo3::exceptions::{PyOSError, PyUserWarning};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

/// No state is larger: two matrices of 2^20 rules for twelve joints, and a header [bytes].
const MAX_BYTES: u64 = (3 << 26) + (1 << 20);

/// Replaces the file by these bytes: whole or not at all.
pub(super) fn write(path: &Path, bytes: &Bound<'_, PyBytes>) -> PyResult<()> {
    files(bytes.py())?.call_method1("content", (path, bytes)).map(drop)
}

/// The bytes of a file.
pub(super) fn read<'py>(py: Python<'py>, path: &Path) -> PyResult<Bound<'py, PyBytes>> {
    Ok(files(py)?.call_method1("read", (path, MAX_BYTES))?.cast_into()?)
}

/// Warns that a file does not say which controller wrote it.
pub(super) fn warn_of_unknown(py: Python<'_>, path: &Path) -> PyResult<()> {
    let text = format!(
        "path: got {}, written before files said which controller wrote them; whether its weights \
         are right for these gains, arm and sets was not looked at; save it again",
        path.display()
    );
    let text = CString::new(text.replace('\0', " ")).unwrap_or_default();
    PyErr::warn(py, &py.get_type::<PyUserWarning>(), &text, 1)
}

fn files(py: Python<'_>) -> PyResult<Bound<'_, PyModule>> {
    py.import("steadyarm._files")
}

/// Refuses a path that leads nowhere: `OSError` with number, text and path, of which Python makes
/// the class, such as `FileNotFoundError`.
pub(super) fn exists(path: &Path) -> PyResult<()> {
    fs::metadata(path).map(drop).map_err(|error| {
        let path = path.to_path_buf();
        PyOSError::new_err((error.raw_os_error().unwrap_or(0), error.to_string(), path))
    })
}

//! Files: written by the one writer of the Python package, and read by its reader.

use std::fs;
use std::path::Path;

use pyo3::exceptions::PyOSError;
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

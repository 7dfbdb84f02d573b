//! Files: written as a whole or not at all, read up to a limit.

use std::fs::{self, File};
use std::io::{Error, Read, Write};
use std::path::Path;

use pyo3::exceptions::{PyOSError, PyValueError};
use pyo3::prelude::*;

/// No state is larger: two matrices of 2^20 rules for eight joints, and a header [bytes].
const MAX_BYTES: u64 = (1 << 27) + (1 << 20);

/// Replaces the file by these bytes; what was there stays if that fails.
pub(super) fn write(path: &Path, bytes: &[u8]) -> PyResult<()> {
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(format!(".{}.tmp", std::process::id()));
    let temporary = path.with_file_name(name);
    let written = File::create(&temporary).and_then(|mut file| {
        file.write_all(bytes)?;
        file.sync_all()?;
        fs::rename(&temporary, path)
    });
    written.map_err(|error| {
        // The file may not even exist; the first error is the one to tell.
        let _ = fs::remove_file(&temporary);
        os_error(&error, path)
    })
}

/// The bytes of a file.
pub(super) fn read(path: &Path) -> PyResult<Vec<u8>> {
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(|error| os_error(&error, path))?;
    file.take(MAX_BYTES + 1).read_to_end(&mut bytes).map_err(|error| os_error(&error, path))?;
    if bytes.len() as u64 > MAX_BYTES {
        let path = path.display();
        let message = format!("path: got {path}, wants a file of at most {MAX_BYTES} bytes");
        return Err(PyValueError::new_err(message));
    }
    Ok(bytes)
}

/// Refuses a path that leads nowhere.
pub(super) fn exists(path: &Path) -> PyResult<()> {
    fs::metadata(path).map(drop).map_err(|error| os_error(&error, path))
}

/// `OSError` with number, text and path: Python picks the class, such as `FileNotFoundError`.
fn os_error(error: &Error, path: &Path) -> PyErr {
    let path = path.to_path_buf();
    PyOSError::new_err((error.raw_os_error().unwrap_or(0), error.to_string(), path))
}

//! Reading a file of limited size as text.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::ReadError;

/// Largest description that is read [bytes]: the largest of the common robots' is below 1 MiB.
pub(super) const LARGEST: usize = 16 << 20;

/// Refuses a text that is too large.
pub(super) fn limited(text: &str) -> Result<(), ReadError> {
    match text.len() <= LARGEST {
        true => Ok(()),
        false => Err(too_large(text.len() as u64)),
    }
}

fn too_large(bytes: u64) -> ReadError {
    ReadError::new(format!(
        "got {bytes} bytes, wants at most {LARGEST}; meshes belong in files of their own"
    ))
}

/// The text of a file, whose size is looked at before it is read.
pub(super) fn read(path: &Path) -> Result<String, ReadError> {
    read_here(path).map_err(|error| named(path, error))
}

/// The error, with the file's name.
pub(super) fn named(path: &Path, error: ReadError) -> ReadError {
    ReadError { file: Some(path.display().to_string()), ..error }
}

fn read_here(path: &Path) -> Result<String, ReadError> {
    let of_system = |error: std::io::Error| ReadError::new(format!("cannot be read: {error}"));
    let metadata = std::fs::metadata(path).map_err(of_system)?;
    if !metadata.is_file() {
        return Err(ReadError::new("got a directory or a device, wants a file"));
    }
    if metadata.len() > LARGEST as u64 {
        return Err(too_large(metadata.len()));
    }
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(of_system)?;
    // A file that grows while it is read stays limited.
    file.take(LARGEST as u64 + 1).read_to_end(&mut bytes).map_err(of_system)?;
    if bytes.len() > LARGEST {
        return Err(too_large(bytes.len() as u64));
    }
    String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        let before = &error.as_bytes()[..at];
        let line = 1 + before.iter().filter(|&&byte| byte == b'\n').count();
        let message = "got bytes that are not UTF-8, wants text in UTF-8";
        ReadError { line: Some(line), ..ReadError::new(message) }
    })
}

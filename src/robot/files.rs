//! Reading a file of limited size as text.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::ReadError;

/// Largest description that is read [bytes]: the largest of the common robots' is below 1 MiB.
pub(super) const LARGEST: usize = 16 << 20;

/// Refuses a text that is too large.
pub(crate) fn limited(text: &str) -> Result<(), ReadError> {
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

/// The text of a file in UTF-8, whose size is looked at before it is read.
pub(super) fn read(path: &Path) -> Result<String, ReadError> {
    let bytes = bytes(path).map_err(|error| error.in_file(path))?;
    String::from_utf8(bytes).map_err(|error| {
        let line = line_of_other(error.as_bytes(), &error.utf8_error());
        let message = "got bytes that are not UTF-8, wants text in UTF-8";
        ReadError::new(message).on_line(line).in_file(path)
    })
}

/// The text of a file in UTF-8 or else in Latin-1, where every byte is a character. XML's other
/// characters (`<`, `"`, `=`) are the same bytes in both, and in the encodings that are mistaken
/// for them. A note says so, unless the file does.
pub(super) fn read_any(path: &Path) -> Result<(String, Option<String>), ReadError> {
    let bytes = bytes(path).map_err(|error| error.in_file(path))?;
    let error = match String::from_utf8(bytes) {
        Ok(text) => return Ok((text, None)),
        Err(error) => error,
    };
    let bytes = error.as_bytes();
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        let message = "got text in UTF-16, wants UTF-8 or Latin-1";
        return Err(ReadError::new(message).in_file(path));
    }
    let text: String = bytes.iter().copied().map(char::from).collect();
    let head = text.get(..text.find("?>").unwrap_or(0)).unwrap_or_default().to_lowercase();
    let declared = ["iso-8859-1", "latin1", "latin-1"].iter().any(|name| head.contains(name));
    let line = line_of_other(bytes, &error.utf8_error());
    let note = format!("bytes that are not UTF-8, first in line {line}: taken as Latin-1");
    Ok((text, (!declared).then_some(note)))
}

/// The line of the first byte that is not UTF-8.
fn line_of_other(bytes: &[u8], error: &core::str::Utf8Error) -> usize {
    let before = bytes.iter().take(error.valid_up_to());
    1 + before.filter(|&&byte| byte == b'\n').count()
}

fn bytes(path: &Path) -> Result<Vec<u8>, ReadError> {
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
    Ok(bytes)
}

//! Our own format: a description as TOML, the same bits after writing and reading.

mod form;
mod write;

use std::path::Path;

use super::error::quoted;
use super::{Description, ReadError, checks, files};
use crate::arm::Unphysical;
use write::FORMAT;

impl Description {
    /// The description as TOML, with its units; [`Description::from_toml`] gives it back bit for
    /// bit.
    pub fn to_toml(&self) -> String {
        write::text(self)
    }

    /// A description from TOML. Unknown entries are refused. Absent are: a rotation by nothing, a
    /// limit that is infinite, friction and stops that are none, gravity that is the usual one.
    ///
    /// # Errors
    /// With the line: what is not TOML or not of the format, a number that is not finite, a mass
    /// distribution that no body has, unless the file's `unphysical` takes it.
    pub fn from_toml(text: &str) -> Result<Self, ReadError> {
        Self::toml(text, None)
    }

    /// [`Description::from_toml`], with another say than the file's in what is done about a mass
    /// distribution that no body has.
    ///
    /// # Errors
    /// As there, but for what is to be taken.
    pub fn from_toml_taking(text: &str, unphysical: Unphysical) -> Result<Self, ReadError> {
        Self::toml(text, Some(unphysical))
    }

    fn toml(text: &str, unphysical: Option<Unphysical>) -> Result<Self, ReadError> {
        files::limited(text)?;
        let file: form::File = toml::from_str(text).map_err(|error| syntax(text, &error))?;
        if file.format != FORMAT {
            return Err(ReadError::new(format!(
                "format: got {}, wants {FORMAT}; the file is of another version",
                file.format
            )));
        }
        let starts: Vec<usize> = file.joint.iter().map(|joint| joint.span().start).collect();
        let mut description = file.description();
        description.unphysical = unphysical.unwrap_or(description.unphysical);
        checks::take(&mut description).map_err(|problem| {
            match problem.joint.and_then(|joint| starts.get(joint)) {
                Some(&at) => ReadError::at(text, at, problem.message),
                None => ReadError::new(problem.message),
            }
        })?;
        Ok(description)
    }

    /// [`Description::from_toml`] of a file.
    ///
    /// # Errors
    /// As there, and if the file cannot be read.
    pub fn from_toml_file(path: impl AsRef<Path>) -> Result<Self, ReadError> {
        Self::from_file(path, Self::from_toml)
    }
}

/// The parser's complaint, in one line and with the line it is about.
fn syntax(text: &str, error: &toml::de::Error) -> ReadError {
    let message = quoted(error.message());
    let message = format!("not the TOML of a robot description: {}", message.trim_matches('"'));
    match error.span() {
        Some(span) => ReadError::at(text, span.start, message),
        None => ReadError::new(message),
    }
}

//! Numbers that may be said once for all: for all joints, all inputs, all sets.

use std::fmt;

use serde::de::{Deserializer, Error as _, SeqAccess, Visitor};
use serde::{Deserialize, Serialize};

use crate::error::{Error, Result, length};

/// One number for all joints, or one a joint.
#[derive(Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum PerJoint {
    /// The same for all.
    All(f64),
    /// One a joint.
    Each(Vec<f64>),
}

impl PerJoint {
    /// How many there are, if it is one a joint.
    pub fn count(&self) -> Option<usize> {
        if let Self::Each(values) = self { Some(values.len()) } else { None }
    }

    /// The numbers as a slice: one for all, or one a joint.
    pub fn as_slice(&self) -> &[f64] {
        match self {
            Self::All(value) => std::slice::from_ref(value),
            Self::Each(values) => values,
        }
    }

    /// The number of a joint there is.
    pub(super) fn of_joint(&self, n: usize) -> f64 {
        match self {
            Self::All(value) => *value,
            Self::Each(values) => values[n],
        }
    }

    /// The numbers of `count` joints; those that were said one by one as they are.
    pub fn values(&self, count: usize) -> Vec<f64> {
        match self {
            Self::All(value) => vec![*value; count],
            Self::Each(values) => values.clone(),
        }
    }

    /// The numbers of `N` joints.
    ///
    /// # Errors
    /// `WrongLength`, naming `parameter`: they are for another number of joints.
    #[inline(never)]
    pub fn each<const N: usize>(&self, parameter: &'static str) -> Result<[f64; N]> {
        match self {
            Self::All(value) => Ok([*value; N]),
            Self::Each(values) => values
                .as_slice()
                .try_into()
                .map_err(|_| Error::wrong_length(parameter, values.len(), N)),
        }
    }
}

impl fmt::Debug for PerJoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::All(value) => value.fmt(f),
            Self::Each(values) => values.fmt(f),
        }
    }
}

impl From<f64> for PerJoint {
    fn from(value: f64) -> Self {
        Self::All(value)
    }
}

impl<const N: usize> From<[f64; N]> for PerJoint {
    fn from(values: [f64; N]) -> Self {
        Self::Each(values.to_vec())
    }
}

/// A number, a list of numbers, or a list of such lists.
#[derive(Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Numbers {
    /// A number, or a list.
    Same(PerJoint),
    /// A list of lists.
    Rows(Vec<Vec<f64>>),
}

impl Numbers {
    /// Length of the rows, or of the one that counts for all; `None` for a number, or where there
    /// are no rows.
    pub(super) fn columns(&self) -> Option<usize> {
        match self {
            Self::Same(values) => values.count(),
            Self::Rows(rows) => rows.first().map(Vec::len),
        }
    }
}

impl fmt::Debug for Numbers {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Same(values) => values.fmt(f),
            Self::Rows(rows) => rows.fmt(f),
        }
    }
}

impl<T: Into<PerJoint>> From<T> for Numbers {
    fn from(values: T) -> Self {
        Self::Same(values.into())
    }
}

impl<'de> Deserialize<'de> for PerJoint {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        match Numbers::deserialize(deserializer)? {
            Numbers::Same(values) => Ok(values),
            Numbers::Rows(_) => {
                Err(D::Error::custom("got a list of lists, wants a number or a list of numbers"))
            }
        }
    }
}

impl<'de> Deserialize<'de> for Numbers {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        deserializer.deserialize_any(NumbersVisitor)
    }
}

struct NumbersVisitor;

impl<'de> Visitor<'de> for NumbersVisitor {
    type Value = Numbers;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number or a list of numbers")
    }

    fn visit_f64<E>(self, value: f64) -> std::result::Result<Numbers, E> {
        Ok(value.into())
    }

    fn visit_i64<E>(self, value: i64) -> std::result::Result<Numbers, E> {
        Ok((value as f64).into())
    }

    fn visit_u64<E>(self, value: u64) -> std::result::Result<Numbers, E> {
        Ok((value as f64).into())
    }

    fn visit_seq<A: SeqAccess<'de>>(
        self,
        mut entries: A,
    ) -> std::result::Result<Numbers, A::Error> {
        let (mut values, mut rows) = (Vec::new(), Vec::new());
        while let Some(entry) = entries.next_element::<Numbers>()? {
            match entry {
                Numbers::Same(PerJoint::All(value)) if rows.is_empty() => values.push(value),
                Numbers::Same(PerJoint::Each(row)) if values.is_empty() => rows.push(row),
                _ => {
                    return Err(A::Error::custom("got a mixture, wants numbers, or lists of them"));
                }
            }
        }
        Ok(if rows.is_empty() { PerJoint::Each(values).into() } else { Numbers::Rows(rows) })
    }
}

/// The joint count that what was said so far and another parameter agree on; `None` if neither
/// says.
///
/// # Errors
/// `WrongLength`, naming the parameter.
pub(super) fn agreed(
    known: Option<usize>,
    (parameter, found): (&'static str, Option<usize>),
) -> Result<Option<usize>> {
    if let (Some(wanted), Some(got)) = (known, found) {
        length(parameter, got, wanted)?;
    }
    Ok(known.or(found))
}

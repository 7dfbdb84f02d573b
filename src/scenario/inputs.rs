//! The signals that a compensator sees, by name.

use std::fmt;

use serde::de::{Deserializer, Error as _, MapAccess, SeqAccess, Visitor};
use serde::ser::{SerializeMap, Serializer};
use serde::{Deserialize, Serialize};

use crate::control::{Inputs, Signal};
use crate::error::Result;

type Preset = (&'static str, fn() -> Inputs);

/// Names of usual choices.
const PRESETS: [Preset; 4] = [
    ("error", Inputs::error),
    ("state", Inputs::state),
    ("reference", Inputs::reference),
    ("trajectory", Inputs::trajectory),
];

/// Signals with their scales, in order. In a file: the name of a preset or a signal, a list of
/// names, or a table name → scale.
#[derive(Clone, Debug, PartialEq)]
pub struct InputSettings(pub Vec<(String, f64)>);

impl Default for InputSettings {
    fn default() -> Self {
        Inputs::error().into()
    }
}

impl From<Inputs> for InputSettings {
    fn from(inputs: Inputs) -> Self {
        let chosen = inputs.signals().iter();
        Self(chosen.map(|&(signal, scale)| (signal.name().to_owned(), scale)).collect())
    }
}

impl InputSettings {
    /// What a single name stands for: a preset or a signal. `None`: nothing has this name.
    pub fn named(name: &str) -> Option<Self> {
        let preset = PRESETS.iter().find(|(known, _)| *known == name);
        preset
            .map(|(_, inputs)| inputs().into())
            .or_else(|| signal(name).map(|_| Self(vec![(name.to_owned(), 1.0)])))
    }

    /// Whether a signal has this name.
    pub fn is_signal(name: &str) -> bool {
        signal(name).is_some()
    }

    /// What was wanted where a name was none.
    pub fn wanted() -> String {
        let list =
            |names: &mut dyn Iterator<Item = &'static str>| names.collect::<Vec<_>>().join(", ");
        let known = list(&mut Signal::ALL.iter().map(|signal| signal.name()));
        let presets = list(&mut PRESETS.iter().map(|(name, _)| *name));
        format!("wants one of {known}, or a preset: {presets}")
    }

    /// Number of scalar inputs for `joints` joints.
    pub fn len(&self, joints: usize) -> usize {
        self.0.len().saturating_mul(joints)
    }

    /// The core's choice.
    ///
    /// # Errors
    /// `inputs`: none, one twice, or (with its index) one of no such name; `scale`.
    pub fn build(&self) -> Result<Inputs> {
        let unknown = |i: usize| {
            crate::error::Error::out_of_range("inputs", i as f64, "names of signals").at(i)
        };
        let chosen = self.0.iter().enumerate().map(|(i, (name, scale))| {
            signal(name).map(|signal| (signal, *scale)).ok_or_else(|| unknown(i))
        });
        Inputs::new(&chosen.collect::<Result<Vec<_>>>()?)
    }
}

/// The signal of a name.
fn signal(name: &str) -> Option<Signal> {
    Signal::ALL.into_iter().find(|signal| signal.name() == name)
}

impl Serialize for InputSettings {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (name, scale) in &self.0 {
            map.serialize_entry(name, scale)?;
        }
        map.end()
    }
}

impl<'de> Deserialize<'de> for InputSettings {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        let inputs = deserializer.deserialize_any(InputsVisitor)?;
        let unknown = inputs.0.iter().find(|(name, _)| !Self::is_signal(name));
        match unknown {
            Some((name, _)) => Err(D::Error::custom(format!("got {name:?}, {}", Self::wanted()))),
            None => Ok(inputs),
        }
    }
}

struct InputsVisitor;

impl<'de> Visitor<'de> for InputsVisitor {
    type Value = InputSettings;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a name, a list of names or a table name = scale")
    }

    fn visit_str<E: serde::de::Error>(self, name: &str) -> std::result::Result<InputSettings, E> {
        InputSettings::named(name)
            .ok_or_else(|| E::custom(format!("got {name:?}, {}", InputSettings::wanted())))
    }

    fn visit_seq<A: SeqAccess<'de>>(
        self,
        mut names: A,
    ) -> std::result::Result<InputSettings, A::Error> {
        let mut chosen = Vec::new();
        while let Some(name) = names.next_element()? {
            chosen.push((name, 1.0));
        }
        Ok(InputSettings(chosen))
    }

    fn visit_map<A: MapAccess<'de>>(
        self,
        mut scales: A,
    ) -> std::result::Result<InputSettings, A::Error> {
        let mut chosen = Vec::new();
        while let Some(entry) = scales.next_entry()? {
            chosen.push(entry);
        }
        Ok(InputSettings(chosen))
    }
}

//! A controller's memory as bytes: versioned, checksummed, and exact to the bit.
//!
//! Layout, little-endian: `steadyarm` magic and version · joints, rules, flags · steps, advances · last torque · W − W₀ · W₀ ·
//! FNV-1a checksum of all that.

use super::{FuzzyCompensator, FuzzyState, State};
use crate::error::{Error, Result};
use crate::math::Vector;

const MAGIC: &[u8; 12] = b"steadyarm\0\0\x01";
const FROZEN: u64 = 1;
const PRIOR: u64 = 2;
const TORQUE: u64 = 4;

impl<const N: usize> FuzzyCompensator<N> {
    /// The controller's state as bytes.
    pub fn save(&self, state: &State<N, FuzzyState<N, Vec<f64>>>) -> Vec<u8> {
        let fuzzy = &state.compensator;
        let flags = if fuzzy.frozen { FROZEN } else { 0 }
            | if fuzzy.prior { PRIOR } else { 0 }
            | if state.last_tau.is_some() { TORQUE } else { 0 };
        let mut bytes = MAGIC.to_vec();
        let counts =
            [N as u64, self.basis().block_rules() as u64, flags, state.steps, fuzzy.advances];
        counts.iter().for_each(|n| bytes.extend(n.to_le_bytes()));
        let mut floats = state.last_tau.unwrap_or_else(Vector::zeros).as_slice().to_vec();
        floats.resize(N + self.weights_len(), 0.0);
        self.read_matrix(fuzzy, 0, &mut floats[N..]);
        if fuzzy.prior {
            let start = floats.len();
            floats.resize(start + self.weights_len(), 0.0);
            self.read_matrix(fuzzy, 1, &mut floats[start..]);
        }
        floats.iter().for_each(|x| bytes.extend(x.to_le_bytes()));
        bytes.extend(checksum(&bytes).to_le_bytes());
        bytes
    }

    /// Restores what [`save`](Self::save) wrote, bit for bit.
    ///
    /// # Errors
    /// [`Error::Damaged`] for bytes that were cut, changed, or written by another version; `joints`, `rules`: the state of
    /// another controller. The state is then as before.
    pub fn restore(
        &self,
        state: &mut State<N, FuzzyState<N, Vec<f64>>>,
        bytes: &[u8],
    ) -> Result<()> {
        let mut reader = Reader::open(bytes)?;
        wanted("joints", reader.count()? as usize, N)?;
        wanted("rules", reader.count()? as usize, self.basis().block_rules())?;
        let (flags, steps, advances) = (reader.count()?, reader.count()?, reader.count()?);
        let tau = reader.floats(N)?;
        let weights = reader.floats(self.weights_len())?;
        let prior =
            if flags & PRIOR != 0 { reader.floats(self.weights_len())? } else { Vec::new() };
        if !reader.rest.is_empty() || (flags & PRIOR != 0 && self.matrices() == 1) {
            return Err(Error::Damaged {
                problem: "it belongs to a controller with other modifications",
            });
        }
        self.check_weights(&weights)?;
        let fuzzy = &mut state.compensator;
        self.write(fuzzy, &weights, 0);
        if flags & PRIOR != 0 {
            self.check_weights(&prior)?;
            self.write_matrix(fuzzy, &prior, 1);
        }
        fuzzy.frozen = flags & FROZEN != 0;
        fuzzy.advances = advances;
        state.steps = steps;
        state.last_tau = (flags & TORQUE != 0).then(|| Vector::from_column_slice(&tau));
        Ok(())
    }
}

fn wanted(parameter: &'static str, got: usize, wanted: usize) -> Result<()> {
    if got == wanted { Ok(()) } else { Err(Error::WrongLength { parameter, got, wanted }) }
}

/// FNV-1a, 64 bits.
fn checksum(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, &byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}

struct Reader<'a> {
    rest: &'a [u8],
}

impl<'a> Reader<'a> {
    /// Checks magic, version and checksum.
    fn open(bytes: &'a [u8]) -> Result<Self> {
        let Some((body, sum)) = bytes.split_last_chunk::<8>() else {
            return Err(Error::Damaged { problem: "it is too short" });
        };
        let Some(rest) = body.strip_prefix(MAGIC) else {
            return Err(Error::Damaged {
                problem: "it was not saved by this version of steadyarm",
            });
        };
        if u64::from_le_bytes(*sum) != checksum(body) {
            return Err(Error::Damaged {
                problem: "its checksum does not match: it was changed or cut",
            });
        }
        Ok(Self { rest })
    }

    fn word(&mut self) -> Result<[u8; 8]> {
        let Some((word, rest)) = self.rest.split_first_chunk::<8>() else {
            return Err(Error::Damaged { problem: "it is too short" });
        };
        self.rest = rest;
        Ok(*word)
    }

    fn count(&mut self) -> Result<u64> {
        self.word().map(u64::from_le_bytes)
    }

    fn floats(&mut self, count: usize) -> Result<Vec<f64>> {
        (0..count).map(|_| self.word().map(f64::from_le_bytes)).collect()
    }
}

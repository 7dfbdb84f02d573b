//! A controller's memory as bytes: versioned, checksummed, and exact to the bit.
//!
//! Layout, little-endian: `steadyarm` magic and version · joints, rules, flags · steps,
//! advances · last torque · W − W₀ · W₀ · |W − W₀|² of each joint · FNV-1a checksum of all that. A
//! dictionary takes the place of the weights in the kernel form.

use super::{FuzzyCompensator, FuzzyState, State};
use crate::error::{Error, Result, length};
use crate::math::{FNV_START, Vector, fnv};

const MAGIC: &[u8; 12] = b"steadyarm\0\0\x01";
pub(super) const FROZEN: u64 = 1;
const PRIOR: u64 = 2;
const TORQUE: u64 = 4;
/// A dictionary, with its sets instead of the rules.
pub(super) const KERNEL: u64 = 8;
/// The norms of the weights. They are stored because adding them up again, in another order than a
/// step does, would change their last bits.
const NORMS: u64 = 16;

impl<const N: usize> State<N, ()> {
    /// The state of a controller without a compensator as bytes.
    pub fn save(&self) -> Vec<u8> {
        sealed(header(self, 0, 0, 0))
    }

    /// Restores what [`save`](Self::save) wrote, bit for bit.
    ///
    /// # Errors
    /// As [`FuzzyCompensator::restore`].
    pub fn restore(bytes: &[u8]) -> Result<Self> {
        let mut reader = Reader::open(bytes)?;
        let header = reader.header::<N>(0, 0)?;
        if !reader.rest.is_empty() {
            return Err(OTHER);
        }
        let Header { steps, last_tau, .. } = header;
        Ok(Self { compensator: (), last_tau, steps })
    }
}

impl<const N: usize> FuzzyCompensator<N> {
    /// The controller's state as bytes.
    pub fn save(&self, state: &State<N, FuzzyState<N, Vec<f64>>>) -> Vec<u8> {
        let fuzzy = &state.compensator;
        let flags = if fuzzy.frozen { FROZEN } else { 0 } | if fuzzy.prior { PRIOR } else { 0 };
        let rules = self.basis().block_rules();
        let mut bytes = header(state, rules, flags | NORMS, fuzzy.advances);
        for matrix in 0..if fuzzy.prior { 2 } else { 1 } {
            let mut weights = vec![0.0; self.weights_len()];
            self.read_matrix(fuzzy, matrix, &mut weights);
            weights.iter().for_each(|x| bytes.extend(x.to_le_bytes()));
        }
        fuzzy.norms.iter().for_each(|x| bytes.extend(x.to_le_bytes()));
        sealed(bytes)
    }

    /// Restores what [`save`](Self::save) wrote, bit for bit.
    ///
    /// # Errors
    /// [`Damaged`](crate::Problem::Damaged) for bytes that were cut, changed, or written by another
    /// version; `joints`, `rules`: the state of another controller. The state is then as before.
    pub fn restore(
        &self,
        state: &mut State<N, FuzzyState<N, Vec<f64>>>,
        bytes: &[u8],
    ) -> Result<()> {
        let mut reader = Reader::open(bytes)?;
        let header = reader.header::<N>(self.basis().block_rules(), 0)?;
        let weights = reader.floats(self.weights_len())?;
        let has_prior = header.flags & PRIOR != 0;
        let prior = if has_prior { reader.floats(self.weights_len())? } else { Vec::new() };
        // Older files, which have no norms, are read too.
        let has_norms = header.flags & NORMS != 0;
        let norms = if has_norms { reader.floats(N)? } else { Vec::new() };
        if !reader.rest.is_empty() || (has_prior && self.matrices() == 1) {
            return Err(OTHER);
        }
        if !norms.iter().all(|x| x.is_finite() && *x >= 0.0) {
            return Err(Error::damaged("its weights have no such norms"));
        }
        self.check_weights(&weights)?;
        if has_prior {
            self.check_weights(&prior)?;
        }
        let fuzzy = &mut state.compensator;
        self.write(fuzzy, &weights, 0);
        if has_prior {
            self.write_matrix(fuzzy, &prior, 1);
        }
        if has_norms {
            fuzzy.norms.copy_from_slice(&norms);
        }
        fuzzy.frozen = header.flags & FROZEN != 0;
        fuzzy.advances = header.advances;
        state.steps = header.steps;
        state.last_tau = header.last_tau;
        Ok(())
    }
}

pub(super) const OTHER: Error =
    Error::damaged("it belongs to a controller with other modifications");

/// Everything before the weights.
pub(super) struct Header<const N: usize> {
    pub flags: u64,
    pub steps: u64,
    pub advances: u64,
    pub last_tau: Option<Vector<N>>,
}

pub(super) fn header<const N: usize, S>(
    state: &State<N, S>,
    rules: usize,
    flags: u64,
    advances: u64,
) -> Vec<u8> {
    let flags = flags | if state.last_tau.is_some() { TORQUE } else { 0 };
    let mut bytes = MAGIC.to_vec();
    let counts = [N as u64, rules as u64, flags, state.steps, advances];
    counts.iter().for_each(|n| bytes.extend(n.to_le_bytes()));
    let tau = state.last_tau.unwrap_or_else(Vector::zeros);
    tau.iter().for_each(|x| bytes.extend(x.to_le_bytes()));
    bytes
}

pub(super) fn sealed(mut bytes: Vec<u8>) -> Vec<u8> {
    bytes.extend(fnv(FNV_START, &bytes).to_le_bytes());
    bytes
}

pub(super) struct Reader<'a> {
    pub rest: &'a [u8],
}

impl<'a> Reader<'a> {
    /// Checks magic, version and checksum.
    pub fn open(bytes: &'a [u8]) -> Result<Self> {
        let Some((body, sum)) = bytes.split_last_chunk::<8>() else {
            return Err(Error::damaged("it is too short"));
        };
        let Some(rest) = body.strip_prefix(MAGIC) else {
            return Err(Error::damaged("it was not saved by this version of steadyarm"));
        };
        if u64::from_le_bytes(*sum) != fnv(FNV_START, body) {
            return Err(Error::damaged("its checksum does not match: it was changed or cut"));
        }
        Ok(Self { rest })
    }

    /// The header for `N` joints and so many rules, of the `kind` [`KERNEL`] or 0.
    pub fn header<const N: usize>(&mut self, rules: usize, kind: u64) -> Result<Header<N>> {
        let (joints, found) = (self.count()?, self.count()?);
        let (flags, steps, advances) = (self.count()?, self.count()?, self.count()?);
        length("joints", joints as usize, N)?;
        if flags & KERNEL != kind {
            let problem = "it belongs to a controller with a compensator of another kind: one of \
                           them has a dictionary";
            return Err(Error::damaged(problem));
        }
        length(if kind == KERNEL { "sets" } else { "rules" }, found as usize, rules)?;
        let tau: Vector<N> = Vector::from_column_slice(&self.floats(N)?);
        if !tau.iter().all(|x| x.is_finite()) {
            return Err(Error::damaged("its last torque is not finite"));
        }
        Ok(Header { flags, steps, advances, last_tau: (flags & TORQUE != 0).then_some(tau) })
    }

    fn word(&mut self) -> Result<[u8; 8]> {
        let Some((word, rest)) = self.rest.split_first_chunk::<8>() else {
            return Err(Error::damaged("it is too short"));
        };
        self.rest = rest;
        Ok(*word)
    }

    pub fn count(&mut self) -> Result<u64> {
        self.word().map(u64::from_le_bytes)
    }

    pub fn floats(&mut self, count: usize) -> Result<Vec<f64>> {
        (0..count).map(|_| self.word().map(f64::from_le_bytes)).collect()
    }
}

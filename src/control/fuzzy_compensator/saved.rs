//! Weights as bytes: W − W₀ · W₀ · |W − W₀|² of each joint, row-major in the order of the rules.

use super::{FuzzyCompensator, FuzzyState, USABLE, usable};
use crate::control::bytes::{Numbers, OTHER, put_all};
use crate::control::{Buffer, Saves};
use crate::error::{Error, Result, within};
use crate::math::unless_tiny;

pub(in crate::control) const FROZEN: u64 = 1;
const PRIOR: u64 = 2;
/// The norms of the weights. They are stored because adding them up again, in another order than a
/// step does, would change their last bits.
const NORMS: u64 = 16;

/// How far stored norms may be from those of the weights, relative.
const NORM_TOL: f64 = 1e-9;
/// No step leaves smaller weights.
const FORGED: f64 = 1e-150;
/// Squares below this are lost in a sum.
const TINY: f64 = 1e-280;

impl<const N: usize, T: Buffer, B: Buffer> Saves<N, FuzzyState<N, B>> for FuzzyCompensator<N, T> {
    fn known_flags(&self) -> u64 {
        FROZEN | PRIOR | NORMS
    }

    fn entries(&self) -> &'static str {
        "rules"
    }

    fn size(&self) -> usize {
        self.basis.block_rules()
    }

    fn fingerprints(&self) -> [u64; 2] {
        [self.update.fingerprint(), self.update.inputs_fingerprint(self.basis.fingerprint())]
    }

    fn flags(&self, state: &FuzzyState<N, B>) -> u64 {
        let flag = |on: bool, flag: u64| if on { flag } else { 0 };
        NORMS | flag(state.frozen, FROZEN) | flag(state.prior, PRIOR)
    }

    fn has_counter(&self) -> bool {
        true
    }

    fn advances(&self, state: &FuzzyState<N, B>) -> u64 {
        state.advances
    }

    fn write(&self, state: &FuzzyState<N, B>, put: &mut dyn FnMut(&[u8])) {
        for matrix in 0..if state.prior { 2 } else { 1 } {
            for row in state.rows(matrix, self.places.matrix, self.basis.row_len()) {
                self.basis.places().for_each(|place| put_all(put, &[row[place]]));
            }
        }
        put_all(put, state.norms.as_slice());
    }

    fn check(&self, flags: u64, part: &[u8]) -> Result<()> {
        let mut rest = Numbers(part);
        let weights = rest.split(self.weights_len())?;
        let has_prior = flags & PRIOR != 0;
        let prior = if has_prior { rest.split(self.weights_len())? } else { Numbers(&[]) };
        // Older files, which have no norms, are read too.
        let norms = if flags & NORMS != 0 { Some(rest.vector::<N>()?) } else { None };
        rest.end()?;
        if has_prior && self.matrices() == 1 {
            return Err(OTHER);
        }
        for w in weights.iter().chain(prior.iter()) {
            within("weights", &[w], usable, USABLE)?;
        }
        let (mut all, rules) = (weights, self.basis.block_rules());
        let mut total = 0.0;
        for n in 0..N {
            let own: f64 = all.split(rules)?.iter().map(|w| w * w).sum();
            total += own;
            let stored = norms.map_or(own, |norms| norms[n]);
            if !((stored - own).abs() <= NORM_TOL * own + TINY && stored >= 0.0) {
                return Err(Error::damaged("its weights have no such norms"));
            }
        }
        self.update.check_radius(total)
    }

    fn take(&self, state: &mut FuzzyState<N, B>, flags: u64, advances: u64, part: &[u8]) {
        let mut rest = Numbers(part);
        let len = self.weights_len();
        state.clear();
        let mut matrix = |matrix: usize| {
            if let Ok(weights) = rest.split(len) {
                let weights = weights.iter().map(|w| unless_tiny(w, FORGED));
                self.write_matrix(state, weights, matrix);
            }
        };
        matrix(0);
        if flags & PRIOR != 0 {
            matrix(1);
        }
        if let (true, Ok(norms)) = (flags & NORMS != 0, rest.vector()) {
            state.norms = norms;
        }
        state.frozen = flags & FROZEN != 0;
        state.advances = advances;
    }
}

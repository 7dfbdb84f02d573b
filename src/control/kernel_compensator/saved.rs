//! A dictionary as bytes, exact to the bit: capacity, atoms, merged, dropped · scale, |W|² and
//! error bound of each joint · memberships and coefficients of every atom. The kernels of the atoms
//! with each other are worked out again.

use super::dictionary::SMALLEST_SIZE;
use super::{KernelCompensator, KernelState, Places};
use crate::control::bytes::{Numbers, OTHER, put_all};
use crate::control::fuzzy_compensator::FROZEN;
use crate::control::saved::{KERNEL, MAX_COUNT};
use crate::control::update::MAX_WEIGHT;
use crate::control::{Buffer, Saves};
use crate::error::{Error, Result, length};
use crate::fuzzy::Compare;
use crate::math::{Runs, Shared, Vector, fnv_of};

const IMPOSSIBLE: Error = Error::damaged("its dictionary is not a possible one");

/// How far stored norms may be from those of the atoms: relative to the sum of the sizes that were
/// added up. What merged or dropped atoms left of rounding is within the square of the error bound.
const NORM_TOL: f64 = 1e-6;
/// Squares below this are lost in a sum.
const TINY: f64 = 1e-280;

/// The numbers of a saved dictionary.
struct Saved<'a, const N: usize> {
    capacity: u64,
    count: u64,
    merged: u64,
    dropped: u64,
    scale: Vector<N>,
    norms: Vector<N>,
    errors: Vector<N>,
    /// Memberships and coefficients of each atom, without the scale.
    atoms: Numbers<'a>,
}

impl<'a, const N: usize> Saved<'a, N> {
    fn read(part: &'a [u8]) -> Result<Self> {
        let mut rest = Numbers(part);
        let (capacity, count) = (rest.count()?, rest.count()?);
        let (merged, dropped) = (rest.count()?, rest.count()?);
        let (scale, norms, errors) = (rest.vector()?, rest.vector()?, rest.vector()?);
        Ok(Self { capacity, count, merged, dropped, scale, norms, errors, atoms: rest })
    }
}

impl<const N: usize, T: Buffer, B: Buffer> Saves<N, KernelState<N, B>> for KernelCompensator<N, T> {
    fn known_flags(&self) -> u64 {
        FROZEN | KERNEL
    }

    fn entries(&self) -> &'static str {
        "sets"
    }

    fn size(&self) -> usize {
        self.basis.sets()
    }

    fn fingerprints(&self) -> [u64; 2] {
        let law = fnv_of(self.update.fingerprint(), [self.kernel.merge_tolerance]);
        [law, self.update.inputs_fingerprint(self.basis.fingerprint())]
    }

    fn flags(&self, state: &KernelState<N, B>) -> u64 {
        KERNEL | if state.frozen { FROZEN } else { 0 }
    }

    fn write(&self, state: &KernelState<N, B>, put: &mut dyn FnMut(&[u8])) {
        let counts = [self.kernel.capacity as u64, state.atoms as u64, state.merged, state.dropped];
        counts.iter().for_each(|count| put(&count.to_le_bytes()));
        [state.scale, state.norms, state.errors]
            .iter()
            .for_each(|row| put_all(put, row.as_slice()));
        let Places { row, coefficients, .. } = self.places;
        let memory = state.memory.as_slice();
        for atom in 0..state.atoms {
            self.basis.atom(memory, atom).for_each(|p| put_all(put, &[p]));
            (0..N).for_each(|n| put_all(put, &[memory[coefficients + n * row + atom]]));
        }
    }

    fn check(&self, _: u64, part: &[u8]) -> Result<()> {
        let saved = Saved::<N>::read(part)?;
        length("capacity", saved.capacity as usize, self.kernel.capacity)?;
        let Saved { count, merged, dropped, scale, norms, errors, mut atoms, .. } = saved;
        let usable = scale.iter().all(|x| *x > 0.0 && *x <= 1.0)
            && norms.iter().all(|x| *x >= 0.0 && x.is_finite())
            && errors.iter().all(|x| (0.0..=MAX_WEIGHT).contains(x));
        if !usable || count > saved.capacity || merged.max(dropped) > MAX_COUNT {
            return Err(IMPOSSIBLE);
        }
        let (sets, count) = (self.basis.sets(), count as usize);
        let all = atoms.split(count * (sets + N))?;
        if atoms.end() == Err(OTHER) {
            return Err(IMPOSSIBLE);
        }
        for atom in 0..count {
            let (memberships, coefficients) = self.atom_of(all, atom)?;
            let size = self.basis.kernel_of_memberships(memberships.iter(), memberships.iter());
            let possible = memberships.iter().all(|p| (0.0..=1.0 + 1e-9).contains(&p))
                && coefficients.iter().all(|c| c.abs() <= MAX_WEIGHT)
                && size >= SMALLEST_SIZE;
            if !possible {
                return Err(IMPOSSIBLE);
            }
        }
        self.check_norms(&saved, all)
    }

    fn take(&self, state: &mut KernelState<N, B>, flags: u64, _: u64, part: &[u8]) {
        state.clear();
        let Ok(saved) = Saved::<N>::read(part) else { return };
        (state.merged, state.dropped) = (saved.merged, saved.dropped);
        (state.scale, state.norms, state.errors) = (saved.scale, saved.norms, saved.errors);
        for atom in 0..saved.count as usize {
            if let Ok((memberships, coefficients)) = self.atom_of(saved.atoms, atom) {
                self.take_atom(state, memberships, coefficients);
            }
        }
        state.frozen = flags & FROZEN != 0;
    }
}

impl<const N: usize, T: Buffer> KernelCompensator<N, T> {
    /// Memberships and coefficients of an atom.
    fn atom_of<'a>(&self, mut all: Numbers<'a>, atom: usize) -> Result<(Numbers<'a>, Numbers<'a>)> {
        let sets = self.basis.sets();
        all.split(atom * (sets + N))?;
        Ok((all.split(sets)?, all.split(N)?))
    }

    /// Refuses |Wₙ|² that is not that of the atoms: Σ cᵢ cⱼ k(xᵢ, xⱼ).
    fn check_norms(&self, saved: &Saved<'_, N>, all: Numbers<'_>) -> Result<()> {
        let (mut squares, mut sizes) = (Vector::<N>::zeros(), Vector::<N>::zeros());
        for i in 0..saved.count as usize {
            let (own, mut factors) = self.atom_of(all, i)?;
            let own_factors: Vector<N> = factors.vector()?;
            for j in 0..=i {
                let (other, mut factors) = self.atom_of(all, j)?;
                let k = self.basis.kernel_of_memberships(own.iter(), other.iter());
                let twice = if i == j { 1.0 } else { 2.0 };
                let product = own_factors.component_mul(&factors.vector()?) * (twice * k);
                squares += product;
                sizes += product.abs();
            }
        }
        for n in 0..N {
            let scale = saved.scale[n] * saved.scale[n];
            let off = (saved.norms[n] - scale * squares[n]).abs();
            let lost = saved.errors[n] * saved.errors[n];
            let right = off <= NORM_TOL * scale * sizes[n] + lost + TINY;
            if !right {
                return Err(Error::damaged("its atoms have no such norms"));
            }
        }
        self.update.check_radius(saved.norms.sum())
    }

    /// Adds an atom to the dictionary, with its kernels with those before.
    fn take_atom<B: Buffer>(
        &self,
        state: &mut KernelState<N, B>,
        memberships: Numbers<'_>,
        factors: Numbers<'_>,
    ) {
        let Places { row, coefficients, gram, gram_row, sizes, inverses, .. } = self.places;
        let Places { kernels, stages, stage, .. } = self.places;
        let atom = state.atoms;
        state.atoms += 1;
        let used = Self::used_row(state.atoms);
        let (dictionary, rest) = state.memory.as_mut_slice().split_at_mut(kernels);
        let (rows, rest) = rest.split_at_mut(stages - kernels);
        let (evaluated, out) = (&mut rest[..stage], &mut rows[..used]);
        self.basis.tabulate(memberships.iter(), evaluated);
        self.basis.write_atom(dictionary, atom, evaluated);
        let atoms = &dictionary[..used * self.basis.sets()];
        let memberships = &*evaluated;
        Shared.run(Compare { basis: &self.basis, memberships, atoms, out: &mut *out });
        for (other, k) in out[..state.atoms].iter().enumerate() {
            dictionary[gram + atom * gram_row + other] = *k;
            dictionary[gram + other * gram_row + atom] = *k;
        }
        for (n, c) in factors.iter().enumerate() {
            dictionary[coefficients + n * row + atom] = c;
        }
        let size = out[atom];
        dictionary[sizes + atom] = size;
        dictionary[inverses + atom] = 1.0 / size;
    }
}

//! A dictionary as bytes, exact to the bit; the kernels of the atoms with each other are worked out
//! again.

use super::dictionary::SMALLEST_SIZE;
use super::{KernelCompensator, KernelState, Places};
use crate::control::State;
use crate::control::saved::{FROZEN, Header, KERNEL, Reader, header, sealed};
use crate::error::{Error, Result, length};
use crate::math::Vector;

const IMPOSSIBLE: Error = Error::damaged("its dictionary is not a possible one");

/// The numbers of a saved dictionary.
struct Saved<const N: usize> {
    merged: u64,
    dropped: u64,
    scale: Vector<N>,
    norms: Vector<N>,
    errors: Vector<N>,
    /// Memberships and coefficients of each atom, without the scale.
    atoms: Vec<(Vec<f64>, Vec<f64>)>,
}

impl<const N: usize> KernelCompensator<N> {
    /// The controller's state as bytes.
    pub fn save(&self, state: &State<N, KernelState<N, Vec<f64>>>) -> Vec<u8> {
        let kernel = &state.compensator;
        let flags = KERNEL | if kernel.frozen { FROZEN } else { 0 };
        let mut bytes = header(state, self.basis.sets(), flags, 0);
        let counts = [self.kernel.capacity as u64, kernel.atoms as u64];
        for count in counts.iter().chain(&[kernel.merged, kernel.dropped]) {
            bytes.extend(count.to_le_bytes());
        }
        let mut put = |values: &[f64]| values.iter().for_each(|x| bytes.extend(x.to_le_bytes()));
        [kernel.scale, kernel.norms, kernel.errors].iter().for_each(|row| put(row.as_slice()));
        let Places { row, coefficients, .. } = self.places;
        let mut memberships = vec![0.0; self.basis.sets()];
        for atom in 0..kernel.atoms {
            self.basis.read_atom(kernel.memory.as_slice(), atom, &mut memberships);
            put(&memberships);
            (0..N).for_each(|n| put(&[kernel.memory.as_slice()[coefficients + n * row + atom]]));
        }
        sealed(bytes)
    }

    /// Restores what [`save`](Self::save) wrote, bit for bit.
    ///
    /// # Errors
    /// [`Damaged`](crate::Problem::Damaged) for bytes that were cut, changed, or written by another
    /// version or kind of controller; `joints`, `sets`, `capacity`: the state of another
    /// controller. The state is then as before.
    pub fn restore(
        &self,
        state: &mut State<N, KernelState<N, Vec<f64>>>,
        bytes: &[u8],
    ) -> Result<()> {
        let mut reader = Reader::open(bytes)?;
        let Header { flags, steps, last_tau, .. } = reader.header(self.basis.sets(), KERNEL)?;
        let saved = self.read(&mut reader)?;
        let kernel = &mut state.compensator;
        kernel.clear();
        (kernel.merged, kernel.dropped) = (saved.merged, saved.dropped);
        (kernel.scale, kernel.norms, kernel.errors) = (saved.scale, saved.norms, saved.errors);
        self.write_dictionary(kernel, &saved.atoms);
        kernel.frozen = flags & FROZEN != 0;
        (state.steps, state.last_tau) = (steps, last_tau);
        Ok(())
    }

    /// Everything after the header, checked.
    fn read(&self, reader: &mut Reader<'_>) -> Result<Saved<N>> {
        length("capacity", reader.count()? as usize, self.kernel.capacity)?;
        let count = reader.count()?;
        if count > self.kernel.capacity as u64 {
            return Err(IMPOSSIBLE);
        }
        let (merged, dropped) = (reader.count()?, reader.count()?);
        let mut vector =
            || -> Result<Vector<N>> { Ok(Vector::from_column_slice(&reader.floats(N)?)) };
        let (scale, norms, errors) = (vector()?, vector()?, vector()?);
        let usable = scale.iter().all(|x| *x > 0.0 && *x <= 1.0)
            && norms.iter().chain(errors.iter()).all(|x| *x >= 0.0 && x.is_finite());
        let mut atoms = Vec::new();
        for _ in 0..count {
            let (memberships, coefficients) =
                (reader.floats(self.basis.sets())?, reader.floats(N)?);
            let evaluated = self.basis.tabulate(&memberships);
            let possible = memberships.iter().all(|p| (0.0..=1.0 + 1e-9).contains(p))
                && coefficients.iter().all(|c| c.is_finite())
                && self.basis.kernel_of(&evaluated, &evaluated) >= SMALLEST_SIZE;
            if !possible {
                return Err(IMPOSSIBLE);
            }
            atoms.push((evaluated, coefficients));
        }
        if !usable || !reader.rest.is_empty() {
            return Err(IMPOSSIBLE);
        }
        Ok(Saved { merged, dropped, scale, norms, errors, atoms })
    }

    /// Writes the atoms and their kernels into an empty dictionary.
    fn write_dictionary(
        &self,
        state: &mut KernelState<N, Vec<f64>>,
        atoms: &[(Vec<f64>, Vec<f64>)],
    ) {
        let Places { row, coefficients, gram, gram_row, sizes, inverses, .. } = self.places;
        state.atoms = atoms.len();
        let memory = state.memory.as_mut_slice();
        for (atom, (evaluated, own)) in atoms.iter().enumerate() {
            self.basis.write_atom(memory, atom, evaluated);
            own.iter().enumerate().for_each(|(n, c)| memory[coefficients + n * row + atom] = *c);
            for (other, (theirs, _)) in atoms[..=atom].iter().enumerate() {
                let k = self.basis.kernel_of(evaluated, theirs);
                memory[gram + atom * gram_row + other] = k;
                memory[gram + other * gram_row + atom] = k;
            }
            let size = memory[gram + atom * gram_row + atom];
            memory[sizes + atom] = size;
            memory[inverses + atom] = 1.0 / size;
        }
    }
}

//! The product grid in kernel form: ξ(x)·ξ(y) without the rules.
//!
//! ```text
//! ξ = ⊗ᵢ pᵢ   so that   k(x, y) = ξ(x)·ξ(y) = ∏ᵢ pᵢ(x)·pᵢ(y)
//! ```
//!
//! with pᵢ the memberships of input i. Five sets on each of 14 inputs make 6.1 billion rules, and
//! 70 memberships.

use pulp::{Simd, WithSimd};

use super::axes::{Axes, Axis};
use super::form::MAX_INPUTS;
use super::memory::{Buffer, Memory, Room};
use crate::error::{Result, finite, length};
use crate::math::{
    FNV_START, LANES, Runs, Shared, TINY_KERNEL, lanes_unless_tiny, sqrt, unless_tiny,
};

/// Blocks of atoms that are compared side by side.
const BATCH: usize = 2;

/// A product grid over any number of inputs, known by its memberships alone. Immutable; the caller
/// may lend the buffer that its sets stand in.
#[derive(Clone, Debug)]
pub struct KernelBasis<B: Buffer = Room> {
    axes: Axes,
    numbers: Memory<B>,
}

impl KernelBasis {
    /// A grid over `axes.len()` inputs, normalised (fuzzy basis functions) or raw (firing
    /// strengths).
    ///
    /// # Errors
    /// `centers`, `width`: not finite, empty, of unequal length, or a width outside 1e-9 … 1e9.
    /// `inputs`, `sets`: more than [`MAX_INPUTS`](super::MAX_INPUTS),
    /// [`MAX_SETS`](super::MAX_SETS). There is no limit to the rules. Without `std`, `buffer`: more
    /// sets than the basis has [`Room`] for; lend memory by [`new_in`](Self::new_in).
    pub fn new(normalized: bool, axes: &[Axis<'_>]) -> Result<Self> {
        Self::over(normalized, axes, Memory::own)
    }
}

impl<B: Buffer> KernelBasis<B> {
    /// The same with its sets in a buffer of the caller's: an array, a slice, a vector. Its length
    /// is that of [`FuzzyBasis::buffer_len`](super::FuzzyBasis::buffer_len).
    ///
    /// # Errors
    /// As [`new`](KernelBasis::new). `buffer`: too short.
    pub fn new_in(normalized: bool, axes: &[Axis<'_>], buffer: B) -> Result<Self> {
        Self::over(normalized, axes, |len| Memory::new(buffer, len))
    }

    #[inline(never)]
    fn over(
        normalized: bool,
        sets: &[Axis<'_>],
        memory: impl FnOnce(usize) -> Result<Memory<B>>,
    ) -> Result<Self> {
        let axes = Axes::new(normalized, sets)?;
        let mut numbers = memory(axes.numbers())?;
        axes.write(sets, numbers.as_mut_slice());
        Ok(Self { axes, numbers })
    }

    /// Whether ξ is normalised.
    pub fn normalized(&self) -> bool {
        self.axes.normalized()
    }

    /// Number of inputs, the length of x.
    pub fn inputs(&self) -> usize {
        self.axes.inputs()
    }

    /// Number of sets of all inputs, which is the number of memberships.
    pub fn sets(&self) -> usize {
        self.axes.sets()
    }

    /// Number of rules, the product of the numbers of sets; it may fit no integer.
    pub fn rules(&self) -> f64 {
        self.axes.columns().iter().map(|column| column.len() as f64).product()
    }

    /// Length of the `work` buffer of [`kernel`](Self::kernel).
    pub fn work_len(&self) -> usize {
        2 * self.activation_len()
    }

    /// k(x, y) = ξ(x)·ξ(y).
    ///
    /// # Errors
    /// `x`, `y`: wrong length or not finite. `work`: wrong length.
    pub fn kernel(&self, x: &[f64], y: &[f64], work: &mut [f64]) -> Result<f64> {
        length("x", x.len(), self.inputs())?;
        length("y", y.len(), self.inputs())?;
        length("work", work.len(), self.work_len())?;
        finite("x", x)?;
        finite("y", y)?;
        let (left, right) = work.split_at_mut(self.activation_len());
        Shared.run(Memberships { basis: self, x, memberships: left });
        Shared.run(Memberships { basis: self, x: y, memberships: right });
        Ok(self.kernel_of(left, right))
    }

    /// Centre and width of each set of each input.
    #[cfg(feature = "std")]
    pub(crate) fn reaches(&self) -> impl Iterator<Item = Vec<(f64, f64)>> {
        self.axes.reaches(self.numbers.as_slice())
    }

    /// An upper bound of |ξ|.
    pub(crate) fn xi_bound(&self) -> f64 {
        if self.normalized() { 1.0 } else { sqrt(self.rules()) }
    }

    /// A bound of the relative error of k(x, y)² / k(x, x) k(y, y): each sum over sets, and each
    /// product over inputs, is of terms that are not negative.
    pub(crate) fn rounding(&self) -> f64 {
        4.0 * f64::EPSILON * (self.sets() + self.inputs() + 2) as f64
    }

    /// FNV-1a of all that ξ depends on.
    pub(crate) fn fingerprint(&self) -> u64 {
        self.axes.fingerprint(self.numbers.as_slice(), FNV_START)
    }

    /// Length of an evaluated basis, a whole number of lanes.
    pub(crate) fn activation_len(&self) -> usize {
        self.axes.len()
    }

    /// Writes the memberships of a finite x.
    #[inline(always)]
    fn activate<S: Simd>(&self, simd: S, x: &[f64], memberships: &mut [f64]) {
        self.axes.memberships(simd, self.numbers.as_slice(), x, memberships);
    }

    /// k of two evaluated bases.
    pub(crate) fn kernel_of(&self, left: &[f64], right: &[f64]) -> f64 {
        Shared.run(Kernel { basis: self, left, right })
    }

    /// k of two evaluated bases, with the same sums as [`compare`](Self::compare).
    #[inline(always)]
    fn dot<S: Simd>(&self, simd: S, left: &[f64], right: &[f64]) -> f64 {
        let mut sums = [0.0; MAX_INPUTS];
        self.axes.products(simd, (left, right), |input, sum| sums[input] = sum);
        let product = |k: f64, sum: &f64| unless_tiny(k * sum, TINY_KERNEL);
        sums[..self.inputs()].iter().fold(1.0, product)
    }

    /// k of `memberships` with every atom, for whole blocks of them; `atoms` are block after block,
    /// set after set, the atoms of a block in the lanes.
    #[inline(always)]
    fn compare<S: Simd>(&self, simd: S, memberships: &[f64], atoms: &[f64], out: &mut [f64]) {
        let block = self.sets() * LANES;
        let mut outs = out.chunks_exact_mut(BATCH * LANES);
        let mut batches = atoms.chunks_exact(BATCH * block);
        for (atoms, out) in (&mut batches).zip(&mut outs) {
            let (left, right) = atoms.split_at(block);
            self.compare_blocks(simd, memberships, [left, right], out);
        }
        for (atoms, out) in batches
            .remainder()
            .chunks_exact(block)
            .zip(outs.into_remainder().chunks_exact_mut(LANES))
        {
            self.compare_blocks(simd, memberships, [atoms], out);
        }
    }

    #[inline(always)]
    fn compare_blocks<S: Simd, const W: usize>(
        &self,
        simd: S,
        memberships: &[f64],
        atoms: [&[f64]; W],
        out: &mut [f64],
    ) {
        let parts = LANES / S::F64_LANES;
        let mut atoms = atoms.map(|block| S::as_simd_f64s(block).0.chunks_exact(parts));
        let mut products = [[simd.splat_f64s(1.0); LANES]; W];
        for column in self.axes.columns() {
            let mut sums = [[simd.splat_f64s(0.0); LANES]; W];
            for p in column.of(memberships) {
                let p = simd.splat_f64s(*p);
                for (sums, atoms) in sums.iter_mut().zip(&mut atoms) {
                    let Some(lanes) = atoms.next() else { return };
                    for part in 0..parts {
                        sums[part] = simd.add_f64s(sums[part], simd.mul_f64s(p, lanes[part]));
                    }
                }
            }
            for (products, sums) in products.iter_mut().zip(&sums) {
                for part in 0..parts {
                    let product = simd.mul_f64s(products[part], sums[part]);
                    products[part] = lanes_unless_tiny(simd, product, TINY_KERNEL);
                }
            }
        }
        let outs = S::as_mut_simd_f64s(out).0.chunks_exact_mut(parts);
        for (out, products) in outs.zip(&products) {
            out.copy_from_slice(&products[..parts]);
        }
    }

    /// Writes an evaluated basis into the place of an atom.
    pub(crate) fn write_atom(&self, atoms: &mut [f64], atom: usize, memberships: &[f64]) {
        let block = self.sets() * LANES;
        let place = &mut atoms[atom / LANES * block..][..block];
        let all = self.axes.columns().iter().flat_map(|column| column.of(memberships));
        for (lanes, p) in place.chunks_exact_mut(LANES).zip(all) {
            lanes[atom % LANES] = *p;
        }
    }

    /// An evaluated basis from its memberships, input after input.
    pub(crate) fn tabulate(&self, memberships: impl Iterator<Item = f64>, table: &mut [f64]) {
        table.fill(0.0);
        let mut rest = memberships;
        for column in self.axes.columns() {
            let places = column.span().of_mut(table).iter_mut().step_by(LANES);
            places.zip(&mut rest).for_each(|(y, p)| *y = p);
        }
    }

    /// k of two evaluated bases from their memberships, input after input, to rounding.
    pub(crate) fn kernel_of_memberships(
        &self,
        mut left: impl Iterator<Item = f64>,
        mut right: impl Iterator<Item = f64>,
    ) -> f64 {
        let columns = self.axes.columns().iter();
        let sums = columns.map(|column| {
            let pairs = (&mut left).take(column.len()).zip((&mut right).take(column.len()));
            pairs.map(|(p, other)| p * other).sum::<f64>()
        });
        sums.product()
    }

    /// The memberships of an atom, input after input.
    pub(crate) fn atom(&self, atoms: &[f64], atom: usize) -> impl Iterator<Item = f64> {
        let block = self.sets() * LANES;
        let place = &atoms[atom / LANES * block..][..block];
        place.chunks_exact(LANES).map(move |lanes| lanes[atom % LANES])
    }
}

/// Writes the memberships of a finite x.
pub(crate) struct Memberships<'a, B: Buffer> {
    pub basis: &'a KernelBasis<B>,
    pub x: &'a [f64],
    pub memberships: &'a mut [f64],
}

impl<B: Buffer> WithSimd for Memberships<'_, B> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.basis.activate(simd, self.x, self.memberships);
    }
}

/// k of two evaluated bases.
pub(crate) struct Kernel<'a, B: Buffer> {
    pub basis: &'a KernelBasis<B>,
    pub left: &'a [f64],
    pub right: &'a [f64],
}

impl<B: Buffer> WithSimd for Kernel<'_, B> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        self.basis.dot(simd, self.left, self.right)
    }
}

/// k of `memberships` with every atom.
pub(crate) struct Compare<'a, B: Buffer> {
    pub basis: &'a KernelBasis<B>,
    pub memberships: &'a [f64],
    pub atoms: &'a [f64],
    pub out: &'a mut [f64],
}

impl<B: Buffer> WithSimd for Compare<'_, B> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.basis.compare(simd, self.memberships, self.atoms, self.out);
    }
}

/// The atom with the largest k²/k(atom, atom), and that ratio; the first of equals. Whole blocks of
/// kernels, and of inverses 1/k(atom, atom), which are 0 where no atom is.
pub(crate) struct Nearest<'a> {
    pub kernels: &'a [f64],
    pub inverses: &'a [f64],
}

impl WithSimd for Nearest<'_> {
    type Output = (usize, f64);

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> (usize, f64) {
        nearest(simd, self.kernels, self.inverses)
    }
}

#[inline(always)]
fn nearest<S: Simd>(simd: S, kernels: &[f64], inverses: &[f64]) -> (usize, f64) {
    let parts = LANES / S::F64_LANES;
    let mut best = [simd.splat_f64s(-1.0); LANES];
    let mut at = [simd.splat_f64s(0.0); LANES];
    let (kernels, inverses) = (S::as_simd_f64s(kernels).0, S::as_simd_f64s(inverses).0);
    let blocks = kernels.chunks_exact(parts).zip(inverses.chunks_exact(parts));
    for (block, (kernels, inverses)) in blocks.enumerate() {
        let number = simd.splat_f64s(block as f64);
        for part in 0..parts {
            let k = kernels[part];
            let ratio = simd.mul_f64s(simd.mul_f64s(k, inverses[part]), k);
            let better = simd.less_than_f64s(best[part], ratio);
            best[part] = simd.select_f64s(better, ratio, best[part]);
            at[part] = simd.select_f64s(better, number, at[part]);
        }
    }
    let (mut ratios, mut blocks) = ([0.0; LANES], [0.0; LANES]);
    S::as_mut_simd_f64s(&mut ratios).0.copy_from_slice(&best[..parts]);
    S::as_mut_simd_f64s(&mut blocks).0.copy_from_slice(&at[..parts]);
    let mut found = (0, -1.0);
    for lane in 0..LANES {
        let atom = blocks[lane] as usize * LANES + lane;
        if ratios[lane] > found.1 || ratios[lane] == found.1 && atom < found.0 {
            found = (atom, ratios[lane]);
        }
    }
    found
}

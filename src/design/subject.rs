//! What a report asks of a compensator: the parameters of its law, P, and which rules fire where.

use nalgebra::DMatrix;
use pulp::Scalar;

use crate::control::{
    FuzzyCompensator, FuzzyParameters, KernelCompensator, KernelParameters, Sample,
};
use crate::error::Result;
use crate::fuzzy::{FuzzyBasis, KernelBasis, Memberships};
use crate::math::{Runs, Shared};
use crate::riccati::JointSolution;

/// A rule counts as excited where it fires with this share of the strongest.
const EXCITED: f64 = 0.05;

/// A compensator that can be reported on: one under the law (18), in either form.
pub trait Subject<const N: usize> {
    /// The parameters of the law.
    fn parameters(&self) -> &FuzzyParameters<N>;

    /// P, joint by joint.
    fn p(&self) -> &[JointSolution; N];

    /// ξ·ξ' of every pair of samples, for each block of rules: one for all joints, or one a joint.
    ///
    /// # Errors
    /// As [`rules_excited`](Self::rules_excited).
    fn products(&self, samples: &[Sample<N>]) -> Result<Vec<DMatrix<f64>>>;

    /// How many rules fire somewhere with 5 % of the strongest, for each block; `None` where the
    /// rules are not written out.
    ///
    /// # Errors
    /// `x`: an input that is not finite.
    fn rules_excited(&self, samples: &[Sample<N>]) -> Result<Option<Vec<usize>>>;

    /// Number of rules of a block; it may fit no integer.
    fn rules(&self) -> f64;

    /// Centre and width of each set of each input.
    fn reaches(&self) -> Vec<Vec<(f64, f64)>>;

    /// The dictionary, and the number of states that it wants for samples in this order, up to one
    /// more than it holds; `None` without one.
    fn dictionary(&self, samples: &[Sample<N>]) -> Option<(KernelParameters, usize)>;
}

/// The block of joint `n`.
pub(super) fn of_joint<T>(blocks: &[T], n: usize) -> &T {
    &blocks[n.min(blocks.len() - 1)]
}

fn inputs<const N: usize>(parameters: &FuzzyParameters<N>, sample: &Sample<N>) -> Vec<f64> {
    let mut x = vec![0.0; parameters.inputs.len(N)];
    parameters.inputs.gather(sample, &mut x);
    x
}

impl<const N: usize> Subject<N> for FuzzyCompensator<N> {
    fn parameters(&self) -> &FuzzyParameters<N> {
        self.parameters()
    }

    fn p(&self) -> &[JointSolution; N] {
        self.p()
    }

    fn products(&self, samples: &[Sample<N>]) -> Result<Vec<DMatrix<f64>>> {
        let basis = self.basis();
        let mut scratch = vec![0.0; basis.scratch_len()];
        let evaluated: Vec<Vec<f64>> = samples
            .iter()
            .map(|sample| {
                let mut activation = vec![0.0; basis.activation_len()];
                let x = inputs(self.parameters(), sample);
                basis.activate(Scalar, &x, &mut scratch, &mut activation);
                activation
            })
            .collect();
        let mut blocks = vec![DMatrix::zeros(samples.len(), samples.len()); basis.blocks()];
        let mut out = vec![0.0; basis.blocks()];
        for (i, left) in evaluated.iter().enumerate() {
            for (j, right) in evaluated.iter().enumerate() {
                basis.dots(Scalar, left, right, &mut out);
                blocks.iter_mut().zip(&out).for_each(|(block, k)| block[(i, j)] = *k);
            }
        }
        Ok(blocks)
    }

    fn rules_excited(&self, samples: &[Sample<N>]) -> Result<Option<Vec<usize>>> {
        let basis = self.basis();
        let (mut xi, mut work) = (vec![0.0; basis.rules()], vec![0.0; basis.work_len()]);
        let mut strongest = vec![0.0_f64; basis.rules()];
        for sample in samples {
            basis.evaluate(&inputs(self.parameters(), sample), &mut work, &mut xi)?;
            strongest.iter_mut().zip(&xi).for_each(|(most, xi)| *most = most.max(*xi));
        }
        let count = |block: &[f64]| {
            let most = block.iter().copied().fold(0.0, f64::max);
            block.iter().filter(|&&xi| xi > 0.0 && xi >= EXCITED * most).count()
        };
        Ok(Some(strongest.chunks_exact(basis.block_rules()).map(count).collect()))
    }

    fn rules(&self) -> f64 {
        self.basis().block_rules() as f64
    }

    fn reaches(&self) -> Vec<Vec<(f64, f64)>> {
        FuzzyBasis::reaches(self.basis()).collect()
    }

    fn dictionary(&self, _: &[Sample<N>]) -> Option<(KernelParameters, usize)> {
        None
    }
}

impl<const N: usize> KernelCompensator<N> {
    fn evaluated(&self, sample: &Sample<N>) -> Vec<f64> {
        let (basis, x) = (self.basis(), inputs(self.parameters(), sample));
        let mut memberships = vec![0.0; basis.activation_len()];
        Shared.run(Memberships { basis, x: &x, memberships: &mut memberships });
        memberships
    }
}

impl<const N: usize> Subject<N> for KernelCompensator<N> {
    fn parameters(&self) -> &FuzzyParameters<N> {
        self.parameters()
    }

    fn p(&self) -> &[JointSolution; N] {
        self.p()
    }

    fn products(&self, samples: &[Sample<N>]) -> Result<Vec<DMatrix<f64>>> {
        let evaluated: Vec<_> = samples.iter().map(|sample| self.evaluated(sample)).collect();
        let kernel = |i: usize, j: usize| self.basis().kernel_of(&evaluated[i], &evaluated[j]);
        Ok(vec![DMatrix::from_fn(samples.len(), samples.len(), kernel)])
    }

    fn rules_excited(&self, _: &[Sample<N>]) -> Result<Option<Vec<usize>>> {
        Ok(None)
    }

    fn rules(&self) -> f64 {
        self.basis().rules()
    }

    fn reaches(&self) -> Vec<Vec<(f64, f64)>> {
        KernelBasis::reaches(self.basis()).collect()
    }

    fn dictionary(&self, samples: &[Sample<N>]) -> Option<(KernelParameters, usize)> {
        let (basis, parameters) = (self.basis(), *self.kernel_parameters());
        let smallest = parameters.merge_tolerance * parameters.merge_tolerance;
        let mut atoms: Vec<(Vec<f64>, f64)> = Vec::new();
        for sample in samples {
            let new = self.evaluated(sample);
            let size = basis.kernel_of(&new, &new);
            let lost = |(atom, own): &(Vec<f64>, f64)| {
                let k = basis.kernel_of(&new, atom);
                1.0 - k * k / (own * size)
            };
            if size > 0.0 && atoms.iter().all(|atom| lost(atom) >= smallest) {
                atoms.push((new, size));
            }
            if atoms.len() > parameters.capacity {
                break;
            }
        }
        Some((parameters, atoms.len()))
    }
}

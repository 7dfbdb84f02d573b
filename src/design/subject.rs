//! What a report asks of a compensator: the parameters of its law, P, and how much of it acts near
//! zero.

use crate::control::{FuzzyCompensator, FuzzyParameters, KernelCompensator};
use crate::error::Result;
use crate::riccati::JointSolution;

/// A compensator that can be reported on: one under the law (18), in either form.
pub trait Subject<const N: usize> {
    /// The parameters of the law.
    fn parameters(&self) -> &FuzzyParameters<N>;

    /// P, joint by joint.
    fn p(&self) -> &[JointSolution; N];

    /// |ξ(0)|² of each joint's rules.
    ///
    /// # Errors
    /// None for a compensator that was built.
    fn xi_squared_at_zero(&self) -> Result<[f64; N]>;
}

impl<const N: usize> Subject<N> for FuzzyCompensator<N> {
    fn parameters(&self) -> &FuzzyParameters<N> {
        self.parameters()
    }

    fn p(&self) -> &[JointSolution; N] {
        self.p()
    }

    fn xi_squared_at_zero(&self) -> Result<[f64; N]> {
        let basis = self.basis();
        let mut xi = vec![0.0; basis.rules()];
        basis.evaluate(&vec![0.0; basis.inputs()], &mut vec![0.0; basis.work_len()], &mut xi)?;
        // One block for each joint, or one for all.
        let blocks: Vec<f64> =
            xi.chunks_exact(basis.block_rules()).map(|xi| xi.iter().map(|x| x * x).sum()).collect();
        Ok(std::array::from_fn(|n| blocks[n.min(blocks.len() - 1)]))
    }
}

impl<const N: usize> Subject<N> for KernelCompensator<N> {
    fn parameters(&self) -> &FuzzyParameters<N> {
        self.parameters()
    }

    fn p(&self) -> &[JointSolution; N] {
        self.p()
    }

    fn xi_squared_at_zero(&self) -> Result<[f64; N]> {
        let (basis, zero) = (self.basis(), vec![0.0; self.basis().inputs()]);
        Ok([basis.kernel(&zero, &zero, &mut vec![0.0; basis.work_len()])?; N])
    }
}

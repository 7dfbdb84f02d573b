//! Computed torque with a network of radial basis functions: `ρ̂ = Wφ(x)`,
//! `φⱼ = exp(−‖x − cⱼ1‖²/2b²)` over x = (e, ė), `Ẇ = g BᵀPx φᵀ`, P of Lyapunov's equation.
//!
//! It is the fuzzy compensator with shared rules, raw: rule j has the centre cⱼ on every input. The
//! paper's refs. 3 and 4. Source: Feng 1995.

use super::bandwidth::sliding_weights;
use crate::control::{Adaptation, FuzzyCompensator, FuzzyParameters, Gains, Inputs};
use crate::error::{Result, positive};
use crate::fuzzy::{Axis, Form, FuzzyBasis, MAX_INPUTS};

/// Where the functions of a network are: the same on every input.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RbfNetwork<'a> {
    /// cⱼ \[rad\] for e, [rad/s] for ė.
    pub centers: &'a [f64],
    /// b, of the same unit.
    pub width: f64,
}

impl RbfNetwork<'_> {
    /// The compensator for these gains of computed torque, Q = `q` I and the gain `gain`, from
    /// W = 0.
    ///
    /// # Errors
    /// `q`, `gain`: not finite or not > 0. What [`FuzzyBasis::new`] names.
    pub fn compensator<const N: usize>(
        &self,
        gains: &Gains<N>,
        q: f64,
        gain: f64,
    ) -> Result<FuzzyCompensator<N>> {
        positive("q", &[q])?;
        self.with([[q; N]; 2], gains, [gain; N])
    }

    /// Computed torque with both poles at −`bandwidth` p [rad/s], and the network: BᵀPx is then
    /// s = ė + pe, and the gain p²/4|φ|² of the largest |φ|: beside `ṡ + ps`, it puts both poles of
    /// s at −p/2 at the fastest.
    ///
    /// # Errors
    /// `bandwidth`: not finite or not > 0. As [`compensator`](Self::compensator).
    pub fn with_bandwidth<const N: usize>(
        &self,
        bandwidth: [f64; N],
    ) -> Result<(Gains<N>, FuzzyCompensator<N>)> {
        let gains = Gains::with_bandwidth(bandwidth)?;
        let largest = self.basis(N)?.xi_bound();
        let gain = bandwidth.map(|p| p * p / (4.0 * largest * largest));
        let compensator = self.with(sliding_weights(&bandwidth), &gains, gain)?;
        Ok((gains, compensator))
    }

    fn with<const N: usize>(
        &self,
        [q_position, q_velocity]: [[f64; N]; 2],
        gains: &Gains<N>,
        gain: [f64; N],
    ) -> Result<FuzzyCompensator<N>> {
        let adaptation = Adaptation { gain, ..Adaptation::default() };
        let (inputs, gamma) = (Inputs::error(), f64::INFINITY);
        let parameters = FuzzyParameters { inputs, q_position, q_velocity, gamma, adaptation };
        FuzzyCompensator::new(self.basis(N)?, gains, parameters)
    }

    fn basis(&self, joints: usize) -> Result<FuzzyBasis> {
        let axis = Axis { centers: self.centers, widths: &[self.width] };
        let inputs = (2 * joints).min(MAX_INPUTS);
        FuzzyBasis::new(Form::Shared, false, &[axis; MAX_INPUTS][..inputs])
    }
}

//! The update law (18) of the weights, stage by stage: `(W − W₀)ξ = keep Dξ + Σ cⱼ (ξⱼ·ξ)`,
//! `Ẇ = drive ξᵀ − pull D`.
//!
//! The compensator that holds the weights brings `own = Dξ` of every stage and the products
//! `gram = ξᵢ·ξⱼ`. All else is here.

use super::adaptation::{left, size};
use super::stages::{DENSE, Stages};
use super::{Adaptation, Audit, Gains, Inputs, Sample, Stage};
use crate::error::{Error, Result};
use crate::math::{FNV_START, TINY_TERM, Vector, fnv_of, sqrt, unless_tiny};
use crate::riccati::{JointSolution, joint};

/// Weights stay below this, so that their squares are finite.
pub(super) const MAX_WEIGHT: f64 = 1e150;

/// How far beyond the projection's radius rounding may leave weights, relative.
const RADIUS_TOL: f64 = 1e-9;

/// What a fuzzy compensator is made from, beside its basis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FuzzyParameters<const N: usize> {
    /// The signals that the basis sees.
    pub inputs: Inputs,
    /// Diagonal of Q for e, of each joint.
    pub q_position: [f64; N],
    /// Diagonal of Q for ė, of each joint.
    pub q_velocity: [f64; N],
    /// Attenuation level γ of (19); the paper's is 1.
    pub gamma: f64,
    /// Gain and robust modifications.
    pub adaptation: Adaptation<N>,
}

impl<const N: usize> Default for FuzzyParameters<N> {
    /// The paper's: inputs (e, ė), Q = 10 I, γ = 1.
    fn default() -> Self {
        let adaptation = Adaptation::default();
        let (q_position, q_velocity) = ([10.0; N], [10.0; N]);
        Self { inputs: Inputs::error(), q_position, q_velocity, gamma: 1.0, adaptation }
    }
}

/// The update law (18): its parameters, with P solved for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Update<const N: usize> {
    pub parameters: FuzzyParameters<N>,
    pub p: [JointSolution; N],
    /// An upper bound of |ξ|.
    xi_bound: f64,
}

impl<const N: usize> Update<N> {
    /// Checks the parameters and solves (19) for P.
    pub fn new(gains: &Gains<N>, parameters: FuzzyParameters<N>, xi_bound: f64) -> Result<Self> {
        parameters.adaptation.validate()?;
        let mut p = [JointSolution::default(); N];
        for (n, solution) in p.iter_mut().enumerate() {
            let (q1, q2) = (parameters.q_position[n], parameters.q_velocity[n]);
            *solution = joint(gains.kp[n], gains.kv[n], q1, q2, parameters.gamma)?;
        }
        Ok(Self { parameters, p, xi_bound })
    }

    /// FNV-1a of what gives weights their meaning, but for the inputs and the basis: gain, Q, γ,
    /// and the modifications.
    pub fn fingerprint(&self) -> u64 {
        let FuzzyParameters { q_position, q_velocity, gamma, adaptation, .. } = &self.parameters;
        let of_joints = fnv_of(FNV_START, adaptation.gain.iter().chain(q_position).copied());
        let of_joints = fnv_of(of_joints, *q_velocity);
        let Adaptation { leak_rate, error_modification, .. } = *adaptation;
        let Adaptation { projection_radius, dead_zone, normalization, .. } = *adaptation;
        let rates = [*gamma, leak_rate, error_modification];
        fnv_of(fnv_of(of_joints, rates), [projection_radius, dead_zone, normalization])
    }

    /// FNV-1a of the inputs that a basis of this fingerprint sees.
    pub fn inputs_fingerprint(&self, basis: u64) -> u64 {
        let signals = self.parameters.inputs.signals().iter();
        signals.fold(basis, |hash, (signal, scale)| fnv_of(hash, [*signal as u8 as f64, *scale]))
    }

    /// Refuses weights of this squared |W − W₀| beyond the projection's radius: the next step would
    /// draw them back at once.
    ///
    /// # Errors
    /// `weights`: [`BeyondRadius`](crate::Problem::BeyondRadius).
    pub fn check_radius(&self, norm_squared: f64) -> Result<()> {
        let (norm, radius) = (sqrt(norm_squared), self.parameters.adaptation.projection_radius);
        if norm <= radius * (1.0 + RADIUS_TOL) {
            return Ok(());
        }
        Err(Error::beyond_radius(norm, radius))
    }

    /// s = BᵀPx [the unit of Q over 1/s²].
    #[inline]
    pub fn s(&self, sample: &Sample<N>) -> Vector<N> {
        Vector::from_fn(|n, _| self.p[n].p12 * sample.e[n] + self.p[n].p22 * sample.de[n])
    }

    /// The leak [1/s], while anything is learnt.
    #[inline]
    pub fn leak_rate(&self, frozen: bool) -> f64 {
        if frozen { 0.0 } else { self.parameters.adaptation.leak_rate }
    }

    /// Whether the size of the weights matters at stage i: to the law, or to a record between
    /// steps.
    #[inline]
    pub fn needs_norms(&self, i: usize) -> bool {
        i == DENSE || self.parameters.adaptation.pulls()
    }

    /// The weights of every joint at a stage, in terms of those at the start of the step.
    #[inline(always)]
    pub fn mix(&self, stages: &mut Stages<N>, stage: &Stage<'_>, leak_rate: f64) {
        let fade = |from| left(leak_rate, stage, from);
        let Stages { drive, pull, mixes, .. } = stages;
        let (past, rest) = mixes.split_at_mut(stage.index);
        let mix = &mut rest[0];
        mix.keep = Vector::repeat(fade(0.0));
        for (j, (a, &node)) in stage.coefficients.iter().zip(stage.nodes).enumerate() {
            if *a == 0.0 {
                mix.terms[j] = Vector::zeros();
                continue;
            }
            let weight = stage.step * a * fade(node);
            mix.terms[j] = drive[j] * weight;
            if self.parameters.adaptation.pulls_by_state() {
                mix.subtract(&(pull[j] * weight), &past[j], j);
            }
        }
    }

    /// (W − W₀)ξ at stage i, and the rates of the law there; `norms` are |Dₙ|² at the start of the
    /// step.
    #[inline(always)]
    pub fn learn(
        &self,
        stages: &mut Stages<N>,
        norms: &Vector<N>,
        i: usize,
        sample: &Sample<N>,
        frozen: bool,
    ) {
        let mix = &stages.mixes[i];
        let mut learnt = mix.keep.component_mul(&stages.own[i]);
        for (j, terms) in mix.terms[..i].iter().enumerate() {
            if stages.known[i] >> j & 1 != 0 {
                learnt += terms.component_mul(&stages.gram[i][j]);
            }
        }
        stages.learnt[i] = learnt;
        if i == 0 || self.needs_norms(i) {
            stages.norms[i] = stages.norms_squared(mix, i, norms);
        }
        if frozen {
            return stages.hold(i);
        }
        self.record_rates(stages, i, &self.s(sample));
    }

    /// Before a period of `dt` \[s\]: refuses a sample whose drive could take the weights, of the
    /// squared norms `norms`, beyond what [`finish`](Self::finish) accepts.
    ///
    /// # Errors
    /// `weights`: they could become larger than 1e150.
    #[inline]
    pub fn admit(&self, norms: &Vector<N>, sample: &Sample<N>, dt: f64) -> Result<()> {
        let (s, gain) = (self.s(sample), &self.parameters.adaptation.gain);
        let mut squares = 0.0;
        for n in 0..N {
            let drive = gain[n] * s[n] * dt * self.xi_bound;
            squares += norms[n] + drive * drive;
        }
        // A sum of 2N sizes is at most √2N times the root of the sum of their squares.
        if squares * ((2 * N) as f64) <= MAX_WEIGHT * MAX_WEIGHT {
            return Ok(());
        }
        Err(too_large(sqrt(squares)))
    }

    /// The change of the weights over a step, from stage to stage and at its `end`; `norms` as
    /// above.
    ///
    /// # Errors
    /// `weights`: they could become larger than 1e150.
    pub fn finish(&self, stages: &mut Stages<N>, norms: &Vector<N>, end: &Stage<'_>) -> Result<()> {
        self.mix(stages, end, self.leak_rate(false));
        let got = stages.mixes[end.index].norm_bound(end.index, norms, self.xi_bound);
        if got > MAX_WEIGHT || got.is_nan() {
            return Err(too_large(got));
        }
        Ok(())
    }

    /// The rates of the law at stage i.
    #[inline(always)]
    fn record_rates(&self, stages: &mut Stages<N>, i: usize, s: &Vector<N>) {
        let adaptation = &self.parameters.adaptation;
        let (weakens, pulls) = (adaptation.weakens_drive(), adaptation.pulls_by_state());
        let s_norm = if weakens || pulls { size(s) } else { 0.0 };
        for n in 0..N {
            let xi_squared = stages.gram[i][i][n];
            let factor = if weakens { adaptation.drive_factor(s_norm, xi_squared) } else { 1.0 };
            stages.factor[i][n] = factor;
            stages.drive[i][n] = unless_tiny(factor * adaptation.gain[n] * s[n], TINY_TERM);
        }
        if pulls {
            let growth = stages.drive[i].dot(&stages.learnt[i]);
            let pull = adaptation.pull(s_norm, &stages.norms[i], growth);
            stages.pull[i] = Vector::from_fn(|n, _| adaptation.gain[n] * pull);
        }
    }

    /// The terms of the dissipation identity at stage i.
    #[inline(always)]
    pub fn audit(
        &self,
        stages: &Stages<N>,
        i: usize,
        sample: &Sample<N>,
        frozen: bool,
    ) -> Audit<N> {
        let (s, leak) = (self.s(sample), self.leak_rate(frozen));
        let FuzzyParameters { gamma, q_position, q_velocity, adaptation, .. } = &self.parameters;
        let (prior, inverse_gamma) = (stages.prior[i], 1.0 / gamma);
        let (mut value, mut state_cost, mut loss) = (0.0, 0.0, 0.0);
        for n in 0..N {
            let (e, de, p) = (sample.e[n], sample.de[n], &self.p[n]);
            let stored = stages.norms[i][n] / adaptation.gain[n];
            let pulled = (leak + stages.pull[i][n]) * stored;
            let withheld = (1.0 - stages.factor[i][n]) * s[n] * stages.learnt[i][n];
            value += (p.p11 * e + 2.0 * p.p12 * de) * e + p.p22 * de * de + stored;
            state_cost += q_position[n] * e * e + q_velocity[n] * de * de;
            loss += inverse_gamma * inverse_gamma * s[n] * s[n]
                + 2.0 * (s[n] * prior[n] + withheld + pulled);
        }
        let weights_norm = sqrt(stages.norms[i].sum());
        let (gamma, loss) = (*gamma, loss + state_cost);
        Audit { value, state_cost, s, prior, loss, gamma, weights_norm }
    }
}

#[cold]
fn too_large(got: f64) -> Error {
    Error::out_of_range("weights", got, "weights of at most 1e150; lower the gain")
}

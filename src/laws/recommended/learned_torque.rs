//! What goes with the law [`FeedForward`](super::FeedForward): the torque that the arm was seen to
//! need on top of the model, learnt and fed forward, and an observer for the rest,
//! `ρ̂ = −D⁻¹Φ(q_d)θ − α − 2p(ė − ė')`.
//!
//! ```text
//! velocity  ė' ← ė' + a (ė − ė')                      a = 1 − e^(−2πfh), joint by joint
//! observer  α = ζ − pė'     ζ ← ζ + hp (v + D⁻¹(τ_a − τ_asked) − α)
//! ```
//!
//! τ_a is the torque that acted in a period, `v = −2p (ė' + w(e)) + α`, ID₀ and Φ are those of the
//! sample for which it was asked, `delay` samples before. The columns of friction are learnt on the
//! velocity of the arm, and fed forward on the desired one. `learning` has how.

use super::features::{Features, Learns};
use super::gains::LearningGains;
use crate::arm::Parametric;
use crate::error::{Result, length, positive};

/// The compensator; its memory is [`LearnedTorqueState`](super::LearnedTorqueState).
#[derive(Clone, Debug)]
pub struct LearnedTorque<const N: usize, const K: usize, A> {
    pub(super) arm: A,
    pub(super) weight: A,
    pub(super) gains: LearningGains<N>,
    pub(super) features: Features<N, K>,
}

impl<const N: usize, const K: usize, A: Parametric<N, K>> LearnedTorque<N, K, A> {
    /// The compensator for what is believed of the arm, with the mass matrix of `weight` for D, and
    /// the largest torque of each joint [N·m].
    ///
    /// # Errors
    /// Naming a gain that is not finite or not > 0, or `delay` beyond 4; `effort_limit`: not finite
    /// or not > 0; `residual`: its basis is for other inputs.
    pub fn new(
        arm: A,
        weight: A,
        gains: LearningGains<N>,
        effort_limit: [f64; N],
        learns: Learns,
    ) -> Result<Self> {
        gains.validate()?;
        positive("effort_limit", &effort_limit)?;
        if let Some((basis, inputs)) = &learns.residual {
            length("residual", basis.inputs(), inputs.len(N))?;
        }
        let scale = effort_limit.map(|tau| tau / 4.0);
        let features = Features::new(&arm, scale, learns.payload_only, learns.residual);
        Ok(Self { arm, weight, gains, features })
    }

    /// Its gains.
    pub fn gains(&self) -> &LearningGains<N> {
        &self.gains
    }
}

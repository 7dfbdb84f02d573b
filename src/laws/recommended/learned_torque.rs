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

use super::features::{FRICTION, Features, Learns, friction};
use super::gains::LearningGains;
use super::learning::{FAR, filter};
use super::memory::{Decided, LearnedTorqueState, Now, Parts};
use crate::arm::{Factor, Parametric};
use crate::control::{Applied, Audit, Channel, Compensator, Sample, Stage, Width};
use crate::error::{Result, finite, length, positive};
use crate::fuzzy::Buffer;
use crate::math::Vector;

/// No limit cuts more of a torque [N·m].
const MOST: f64 = 1e10;

/// The compensator; its memory is [`LearnedTorqueState`].
#[derive(Clone, Debug)]
pub struct LearnedTorque<const N: usize, const K: usize, A> {
    pub(super) arm: A,
    pub(super) weight: A,
    pub(super) gains: LearningGains<N>,
    pub(super) features: Features<N, K>,
}

/// What was learnt, as a torque [N·m].
static CHANNELS: [Channel; 2] = [
    Channel {
        name: "tau_learned",
        unit: "N·m",
        width: Width::Joints,
        doc: "torque that was learnt and is fed forward, Φθ",
    },
    Channel {
        name: "tau_observed",
        unit: "N·m",
        width: Width::Joints,
        doc: "torque of the observer for the rest, Dα",
    },
];

impl<const N: usize, const K: usize, A: Parametric<N, K>> LearnedTorque<N, K, A> {
    /// The compensator for what is believed of the arm, with the mass matrix of `weight` for D, and
    /// the largest torque of each joint [N·m].
    ///
    /// # Errors
    /// Naming a gain that is not finite or not > 0, or `delay` beyond [`MAX_DELAY`](crate::control::MAX_DELAY);
    /// `effort_limit`: not finite or not > 0; `residual`: its basis is for other inputs.
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
        let unit = effort_limit.map(|tau| tau / 4.0);
        let features = Features::new(&arm, unit, learns.payload_only, learns.residual);
        Ok(Self { arm, weight, gains, features })
    }

    /// Its gains.
    pub fn gains(&self) -> &LearningGains<N> {
        &self.gains
    }

    /// Φθ [N·m], of columns with the friction at the desired velocity.
    fn learned(&self, theta: &[f64], columns: &[f64], dq: &Vector<N>) -> Vector<N> {
        Vector::from_fn(|n, _| {
            let own = &theta[K + n * self.features.own()..][..self.features.own()];
            let rubbed = own.iter().zip(friction(dq[n])).map(|(a, b)| a * b).sum::<f64>();
            let placed = own[FRICTION..].iter().zip(&columns[N * K..]);
            let inertial = &columns[self.features.acting(n)];
            let first = K - inertial.len();
            let moved = inertial.iter().zip(&theta[first..]).map(|(a, b)| a * b).sum::<f64>();
            moved + rubbed + placed.map(|(a, b)| a * b).sum::<f64>()
        })
    }
}

impl<const N: usize, const K: usize, A, B> Compensator<N, LearnedTorqueState<N, B>>
    for LearnedTorque<N, K, A>
where
    A: Parametric<N, K>,
    B: Buffer,
{
    fn estimate(
        &self,
        state: &mut LearnedTorqueState<N, B>,
        _: &Stage<'_>,
        seen: &Sample<N>,
    ) -> Vector<N> {
        let LearnedTorqueState { memory, filtered, periods, now, .. } = state;
        let p = Vector::from(self.gains.pull.bandwidth);
        let velocity = Vector::from_fn(|n, _| {
            let last = filtered.velocity[n];
            let share = filter(self.gains.cut_off[n], filtered.period);
            if *periods == 0 { seen.de[n] } else { last + share * (seen.de[n] - last) }
        });
        let alpha = filtered.zeta - p.component_mul(&velocity);
        let v = alpha + self.gains.pull.acceleration(&seen.e, &velocity);
        let weight = self.weight.mass_matrix(&seen.desired.q);
        let Parts { regression, columns, work, .. } = self.parts(memory.as_mut_slice());
        let size = self.features.columns();
        let columns = &mut columns[self.turn(*periods) * size..][..size];
        self.features.write(&self.arm, seen, columns, work);
        let learned = self.learned(regression.theta, columns, &seen.desired.dq);
        let decided = Decided { torque: learned + weight * v, v, dq: seen.desired.dq };
        let (cut, observed) = (Vector::zeros(), weight * alpha);
        let far = seen.e.amax() > FAR;
        *now = Now { velocity, alpha, weight, cut, far, decided, learned, observed };
        let slowed = p.component_mul(&(seen.de - velocity)) * 2.0;
        -(Factor::of(&weight).solve(&learned) + alpha + slowed)
    }

    fn acted(
        &self,
        state: &mut LearnedTorqueState<N, B>,
        _: usize,
        _: &Sample<N>,
        applied: &Applied<N>,
    ) {
        state.now.cut = (applied.tau - applied.asked).map(|cut| cut.clamp(-MOST, MOST));
    }

    fn advance(&self, state: &mut LearnedTorqueState<N, B>, end: &Stage<'_>) -> Result<()> {
        finite("tau", state.now.decided.torque.as_slice())?;
        let learns = !state.frozen;
        self.end(state, end.step, learns);
        Ok(())
    }

    fn coast(&self, state: &mut LearnedTorqueState<N, B>, end: &Stage<'_>) -> Result<()> {
        finite("tau", state.now.decided.torque.as_slice())?;
        self.end(state, end.step, false);
        Ok(())
    }

    fn reset(&self, state: &mut LearnedTorqueState<N, B>) {
        self.begin(state);
    }

    fn audit(&self, _: &LearnedTorqueState<N, B>, _: usize, _: &Sample<N>) -> Option<Audit<N>> {
        None
    }

    fn sampled_only(&self) -> bool {
        true
    }

    fn channels(&self) -> &'static [Channel] {
        &CHANNELS
    }

    fn describe(
        &self,
        state: &LearnedTorqueState<N, B>,
        put: &mut dyn FnMut(&'static str, &[f64]),
    ) {
        let LearningGains { pull, cut_off, learning, acceleration_share, condition, .. } =
            &self.gains;
        put("bandwidth", &pull.bandwidth);
        put("braking", &pull.braking);
        put("cut_off", cut_off);
        put("learning", &[*learning]);
        put("acceleration_share", &[*acceleration_share]);
        put("condition", &[*condition]);
        put("weight", state.now.weight.diagonal().as_slice());
        put("unit", &self.features.unit);
        let [theta, p, _] = self.kept(state.memory.as_slice());
        put("parameters", theta);
        let rows = p.chunks_exact(self.features.stride());
        rows.for_each(|row| put("covariance", &row[..theta.len()]));
        self.features.prior().for_each(|variance| put("prior", &[variance]));
    }

    fn signals(&self, state: &LearnedTorqueState<N, B>, _: &Sample<N>, row: &mut [f64]) {
        let signals = state.now.learned.iter().chain(&state.now.observed);
        row.iter_mut().zip(signals).for_each(|(cell, signal)| *cell = *signal);
    }
}

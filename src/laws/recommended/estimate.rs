//! What [`LearnedTorque`] gives for a sample, and how it speaks as a compensator:
//! `ρ̂ = −D⁻¹Φθ − α − 2p(ė − ė')`.

use super::features::{FRICTION, WIDTHS, friction};
use super::gains::{LearningGains, QUICKEST};
use super::learned_torque::LearnedTorque;
use super::learning::{FAR, filter};
use super::memory::{Decided, LearnedTorqueState, Now, Parts};
use crate::arm::{Factor, Parametric};
use crate::control::{Applied, Audit, Channel, Compensator, Sample, Stage, Width};
use crate::error::{Result, finite};
use crate::fuzzy::Buffer;
use crate::math::Vector;

/// No limit cuts more of a torque [N·m].
const MOST: f64 = 1e10;

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
        let LearningGains { pull, cut_off, learning, acceleration_share, .. } = &self.gains;
        put("bandwidth", &pull.bandwidth);
        put("braking", &pull.braking);
        put("cut_off", cut_off);
        put("learning", &[*learning]);
        put("acceleration_share", &[*acceleration_share]);
        put("quickness", &self.gains.quickness);
        put("quickest", &[QUICKEST]);
        put("condition", &[self.gains.condition]);
        put("friction_widths", &WIDTHS);
        put("of_links", &[if A::BODIES { K as f64 } else { 0.0 }]);
        put("weight", state.now.weight.diagonal().as_slice());
        put("unit", &self.gains.unit);
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

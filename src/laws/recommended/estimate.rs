//! What [`LearnedTorque`] gives for a sample, and how it speaks as a compensator:
//! `ρ̂ = −D⁻¹Φθ − α − 2p(ė − ė')`.

#[cfg(feature = "std")]
use super::abreast::put;
use super::features::{FRICTION, WIDTHS, friction};
use super::gains::{LearningGains, QUICKEST};
use super::learned_torque::LearnedTorque;
use super::learning::{FAR, filter};
use super::memory::{Decided, Filtered, LearnedTorqueState, Now, Parts};
use super::pull::Pull;
use crate::arm::{Factor, Parametric};
use crate::control::{Applied, Audit, Channel, Compensator, Sample, Stage, Width, possible};
#[cfg(feature = "std")]
use crate::control::{Beliefs, Learns, OwnSide};
use crate::error::{Result, finite};
use crate::fuzzy::Buffer;
use crate::math::{Matrix, Real, Vector, column, product};

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

impl<const N: usize, T: Real> Now<N, T> {
    /// What a sample gives, the `first` or not, with D and what was learnt, Φθ; the filters of
    /// velocity take these `shares`.
    #[inline(always)]
    pub fn seen(
        filtered: &Filtered<N, T>,
        (pull, shares): (&Pull<N, T>, &[T; N]),
        first: bool,
        Sample { desired, e, de, .. }: &Sample<N, T>,
        (weight, learned): (&Matrix<N, T>, &Vector<N, T>),
    ) -> Self {
        let (mut velocity, mut alpha, zero) = (*de, filtered.zeta, filtered.astray.like(0.0));
        let mut far = zero;
        for n in 0..N {
            let last = filtered.velocity[n];
            velocity[n] = if first { de[n] } else { last + shares[n] * (de[n] - last) };
            alpha[n] -= pull.bandwidth[n] * velocity[n];
            far = zero.like(FAR).if_less(e[n].abs(), zero.like(1.0), far);
        }
        let mut v = pull.acceleration(e, &velocity);
        for n in 0..N {
            v[n] = alpha[n] + v[n];
        }
        let mut torque = product(weight, &v);
        for n in 0..N {
            torque[n] = learned[n] + torque[n];
        }
        let decided = Decided { torque, v, dq: desired.dq };
        Self { velocity, alpha, cut: column([zero; N]), far, decided, learned: *learned }
    }

    /// ρ̂ = −D⁻¹Φθ − α − 2p(ė − ė').
    #[inline(always)]
    pub fn rho_hat(
        &self,
        pull: &Pull<N, T>,
        weight: &Matrix<N, T>,
        de: &Vector<N, T>,
    ) -> Vector<N, T> {
        let mut rho_hat = Factor::of(weight).solve(&self.learned);
        for n in 0..N {
            let slowed = pull.bandwidth[n] * (de[n] - self.velocity[n]);
            rho_hat[n] = -(rho_hat[n] + self.alpha[n] + slowed * slowed.like(2.0));
        }
        rho_hat
    }
}

impl<const N: usize, const K: usize, A: Parametric<N, K>> LearnedTorque<N, K, A> {
    /// Φθ [N·m], of columns with the friction at the desired velocity.
    fn learned(&self, theta: &[f64], columns: &[f64], dq: &Vector<N>) -> Vector<N> {
        Vector::from_fn(|n, _| {
            let own = &theta[K + n * self.features.shape.own()..][..self.features.shape.own()];
            let rubbed = own.iter().zip(friction(dq[n])).map(|(a, b)| a * b).sum::<f64>();
            let placed = own[FRICTION..].iter().zip(&columns[self.features.shape.places()]);
            let inertial = &columns[self.features.shape.acting(n)];
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
        let LearnedTorqueState { memory, filtered, periods, now, weight, observed, .. } = state;
        *weight = self.weight.mass_matrix(&seen.desired.q);
        let Parts { regression, columns, work, .. } = self.parts(memory.as_mut_slice());
        let size = self.features.shape.columns();
        let columns = &mut columns[self.turn(*periods) * size..][..size];
        self.features.write(&self.arm, seen, columns, work);
        let learned = self.learned(regression.theta, columns, &seen.desired.dq);
        let LearningGains { pull, cut_off, .. } = &self.gains;
        let shares = cut_off.map(|cut_off| filter(cut_off, filtered.period));
        let first = *periods == 0;
        *now = Now::seen(filtered, (pull, &shares), first, seen, (weight, &learned));
        *observed = *weight * now.alpha;
        now.rho_hat(pull, weight, &seen.de)
    }

    fn acted(
        &self,
        state: &mut LearnedTorqueState<N, B>,
        _: usize,
        _: &Sample<N>,
        applied: &Applied<N>,
    ) {
        state.now.cut = possible(&(applied.tau - applied.asked));
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

    #[cfg(feature = "std")]
    fn learns<'a>(&'a self, state: &'a LearnedTorqueState<N, B>) -> Option<Learns<'a, N>> {
        let [theta, p, columns] = self.kept(state.memory.as_slice());
        let new = state.periods == 0
            && state.filtered == Filtered::of(0.0)
            && columns.iter().all(|column| *column == 0.0);
        if !new || state.frozen {
            return None;
        }
        let beliefs =
            Beliefs { arms: [self.arm.side()?, self.weight.side()?], numbers: &self.gains };
        let known = [theta, p, self.features.inertial_prior.as_slice()];
        let (shape, put) = (&self.features.shape, put as _);
        Some(Learns::own(OwnSide { beliefs, shape, known, put }))
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
        put("weight", state.weight.diagonal().as_slice());
        put("unit", &self.gains.unit);
        let [theta, p, _] = self.kept(state.memory.as_slice());
        put("parameters", theta);
        let rows = p.chunks_exact(self.features.shape.stride());
        rows.for_each(|row| put("covariance", &row[..theta.len()]));
        self.features.prior().for_each(|variance| put("prior", &[variance]));
    }

    fn signals(&self, state: &LearnedTorqueState<N, B>, _: &Sample<N>, row: &mut [f64]) {
        let signals = state.now.learned.iter().chain(&state.observed);
        row.iter_mut().zip(signals).for_each(|(cell, signal)| *cell = *signal);
    }
}

//! Craig, Hsu and Sastry's adaptive computed torque (MRAC): `τ = M̂v + Ĥ`,
//! `θ̂' = −g Yᵀ(q, q̇, q̈) M̂⁻¹ BᵀPx`, P of Lyapunov's equation; θ̂ is projected to where M̂ > 0.
//!
//! For computed torque with the same gains: `ρ̂ = −M₀⁻¹Y(q, q̇, v)θ̃`, θ̃ what is added to the
//! nominal parameters. q̈ is the difference of q̇ of two samples through a low-pass filter, so it
//! is sampled only, and noise of the velocity about doubles its error. θ̃ holds while the torque is
//! limited.
//! Source: Craig, Hsu, Sastry 1987.

use core::f64::consts::TAU;

use super::bandwidth::{Pace, adaptation_gain, sliding_weights};
use crate::arm::{Factor, Parametric, Regressor};
use crate::control::{
    Applied, Audit, Compensator, Feedback, Gains, Numbers, Sample, Saves, Stage, put_all,
};
use crate::error::{Result, finite, positive, within};
use crate::math::{FNV_START, Matrix, Vector, exp, fnv_of};
use crate::riccati::{JointSolution, joint};

/// The projection keeps M̂ above this share of M₀, and where it acts it goes to twice as much. An
/// arm with less than that is another arm.
const LEAST: f64 = 0.2;

/// Planes that a projection goes to at the most; a sample needs one as a rule.
const PLANES: usize = 8;

/// How often what is still outside is halved at the most.
const HALVINGS: usize = 60;

/// The adaptation of the nominal arm's parameters, for computed torque.
#[derive(Clone, Copy, Debug)]
pub struct AdaptiveComputedTorque<const N: usize, const K: usize, A> {
    arm: A,
    gains: Gains<N>,
    p: [JointSolution; N],
    gain: [f64; K],
    cutoff: f64,
}

/// What was learnt, and what was seen in this sample and in the last one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdaptiveComputedTorqueState<const N: usize, const K: usize> {
    /// θ̃.
    theta: Vector<K>,
    rate: Vector<K>,
    now: Moving<N>,
    past: Option<(Moving<N>, f64)>,
}

/// q̇ and q̈ after the filter.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Moving<const N: usize> {
    dq: Vector<N>,
    ddq: Vector<N>,
}

impl<const N: usize, const K: usize> AdaptiveComputedTorqueState<N, K> {
    /// The memory before the first sample.
    pub fn new() -> Self {
        let now = Moving { dq: Vector::zeros(), ddq: Vector::zeros() };
        Self { theta: Vector::zeros(), rate: Vector::zeros(), now, past: None }
    }

    /// θ̃: what is added to the nominal parameters.
    pub fn theta(&self) -> &Vector<K> {
        &self.theta
    }
}

impl<const N: usize, const K: usize> Default for AdaptiveComputedTorqueState<N, K> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const N: usize, const K: usize, A: Parametric<N, K>> AdaptiveComputedTorque<N, K, A> {
    /// The adaptation for computed torque with these gains: Q = `q` I, g = diag(`gain`), and the
    /// filter's `cutoff` \[Hz\].
    ///
    /// # Errors
    /// `q`, `gain`, `cutoff`: not finite or not > 0.
    pub fn new(arm: A, gains: Gains<N>, q: f64, gain: [f64; K], cutoff: f64) -> Result<Self> {
        positive("q", &[q])?;
        Self::with(arm, gains, [[q; N]; 2], gain, cutoff)
    }

    /// Gains and one gain for all parameters, for a bandwidth p [rad/s] and a pace: K_p = p²,
    /// K_v = 2p, Q with which BᵀPx is s = ė + pe, and 4 g Σₙ |Zₙ|²/pₙ² = 1 at the one of 24 poses
    /// where it acts most, Zₙ a row of M₀⁻¹Y: both poles of s are then at −p/2 at the fastest. The
    /// filter of q̈ is ten times as fast as the fastest joint.
    ///
    /// # Errors
    /// `bandwidth`: not finite or not > 0. `speed`, `acceleration`: not finite, negative, or
    /// nothing acts at this pace.
    pub fn with_bandwidth(arm: A, bandwidth: [f64; N], pace: &Pace<N>) -> Result<(Gains<N>, Self)> {
        let gains = Gains::with_bandwidth(bandwidth)?;
        let strengths = pace.regressors(&arm)?.map(|(q, y)| {
            let factor = Factor::of(&arm.mass_matrix(&q));
            let columns = y.column_iter().map(|column| factor.solve(&column.into_owned()));
            let of_joints = |z: Vector<N>| {
                (0..N).map(|n| z[n] * z[n] / (bandwidth[n] * bandwidth[n])).sum::<f64>()
            };
            columns.map(of_joints).sum()
        });
        let gain = adaptation_gain(strengths)?;
        let cutoff = 10.0 * bandwidth.iter().fold(0.0, |most: f64, p| most.max(*p)) / TAU;
        let own = Self::with(arm, gains, sliding_weights(&bandwidth), [gain; K], cutoff)?;
        Ok((gains, own))
    }

    fn with(
        arm: A,
        gains: Gains<N>,
        [q_position, q_velocity]: [[f64; N]; 2],
        gain: [f64; K],
        cutoff: f64,
    ) -> Result<Self> {
        positive("gain", &gain)?;
        positive("cutoff", &[cutoff])?;
        let mut p = [JointSolution::default(); N];
        for (n, p) in p.iter_mut().enumerate() {
            let (kp, kv) = (gains.kp[n], gains.kv[n]);
            *p = joint(kp, kv, q_position[n], q_velocity[n], f64::INFINITY)?;
        }
        Ok(Self { arm, gains, p, gain, cutoff })
    }

    /// Y(q, 0, 0, `ddq`) without gravity, times the parameters M `ddq`.
    fn inertial(
        &self,
        q: &Vector<N>,
        ddq: &Vector<N>,
        weight: &Regressor<N, K>,
    ) -> Regressor<N, K> {
        let still = Vector::zeros();
        self.arm.slotine_li_regressor(q, &still, &still, ddq) - weight
    }

    /// Y(q, 0, 0, 0): gravity.
    fn weight(&self, q: &Vector<N>) -> Regressor<N, K> {
        let still = Vector::zeros();
        self.arm.slotine_li_regressor(q, &still, &still, &still)
    }

    /// −g Yᵀ M̂⁻¹ BᵀPx; zero where M̂ could not be made positive.
    fn rate(&self, seen: &Sample<N>, ddq: &Vector<N>, mass: &Matrix<N>) -> Vector<K> {
        let Sample { q, dq, e, de, .. } = seen;
        let pushed = Vector::from_fn(|n, _| self.p[n].p12 * e[n] + self.p[n].p22 * de[n]);
        let force = Factor::of(mass).solve(&pushed);
        let shares = self.arm.slotine_li_regressor(q, dq, dq, ddq).tr_mul(&force);
        let known = shares.iter().all(|x| x.is_finite());
        if known { Vector::from_fn(|k, _| -self.gain[k] * shares[k]) } else { Vector::zeros() }
    }

    /// θ̃ in the half-spaces xᵀM̂x ≥ xᵀM₀x · 2 LEAST, as far as it violates one, and M̂ there. The
    /// distance to every θ̃ within them falls, in the metric of the gain. What is too far off for
    /// that goes towards the nominal parameters.
    fn kept(&self, q: &Vector<N>, mut theta: Vector<K>) -> (Vector<K>, Matrix<N>) {
        let (nominal, weight) = (self.arm.mass_matrix(q), self.weight(q));
        let unit = |j: usize| Vector::from_fn(|i, _| if i == j { 1.0 } else { 0.0 });
        let columns: [_; N] = core::array::from_fn(|j| self.inertial(q, &unit(j), &weight));
        let mass_of = |theta: &Vector<K>| {
            let mut mass = nominal;
            for (j, column) in columns.iter().enumerate() {
                let grown = mass.column(j) + column * theta;
                mass.set_column(j, &grown);
            }
            mass
        };
        let mut mass = mass_of(&theta);
        for tried in 0..PLANES + HALVINGS {
            let Some(x) = Factor::indefinite(&(mass - nominal * LEAST)) else { break };
            if tried < PLANES {
                let plane = self.inertial(q, &x, &weight).tr_mul(&x);
                let steps = Vector::from_fn(|k, _| self.gain[k] * plane[k]);
                let missing = x.dot(&((nominal * (2.0 * LEAST) - mass) * x));
                theta += steps * (missing / plane.dot(&steps));
            } else {
                theta *= 0.5;
            }
            mass = mass_of(&theta);
        }
        (theta, mass)
    }
}

impl<const N: usize, const K: usize, A: Parametric<N, K>>
    Compensator<N, AdaptiveComputedTorqueState<N, K>> for AdaptiveComputedTorque<N, K, A>
{
    fn estimate(
        &self,
        state: &mut AdaptiveComputedTorqueState<N, K>,
        _: &Stage<'_>,
        seen: &Sample<N>,
    ) -> Vector<N> {
        let Sample { q, dq, .. } = seen;
        let ddq = state.past.map_or_else(Vector::zeros, |(past, dt)| {
            let share = 1.0 - exp(-TAU * self.cutoff * dt);
            past.ddq + ((dq - past.dq) / dt - past.ddq) * share
        });
        state.now = Moving { dq: *dq, ddq };
        let (theta, mass) = self.kept(q, state.theta);
        state.theta = theta;
        // Without a sample before there is no q̈.
        state.rate =
            if state.past.is_none() { Vector::zeros() } else { self.rate(seen, &ddq, &mass) };
        let v = self.gains.acceleration(seen);
        let torque = self.arm.slotine_li_regressor(q, dq, dq, &v) * theta;
        -Factor::of(&self.arm.mass_matrix(q)).solve(&torque)
    }

    fn acted(
        &self,
        state: &mut AdaptiveComputedTorqueState<N, K>,
        _: usize,
        _: &Sample<N>,
        applied: &Applied<N>,
    ) {
        if applied.limited() {
            state.rate = Vector::zeros();
        }
    }

    fn advance(
        &self,
        state: &mut AdaptiveComputedTorqueState<N, K>,
        end: &Stage<'_>,
    ) -> Result<()> {
        let theta = state.theta + state.rate * end.step;
        finite("theta", theta.as_slice())?;
        state.theta = theta;
        state.past = Some((state.now, end.step));
        Ok(())
    }

    fn reset(&self, state: &mut AdaptiveComputedTorqueState<N, K>) {
        *state = AdaptiveComputedTorqueState::new();
    }

    fn sampled_only(&self) -> bool {
        true
    }

    fn audit(
        &self,
        _: &AdaptiveComputedTorqueState<N, K>,
        _: usize,
        _: &Sample<N>,
    ) -> Option<Audit<N>> {
        None
    }
}

/// A sample was seen.
const BEGUN: u64 = 128;

impl<const N: usize, const K: usize, A: Parametric<N, K>>
    Saves<N, AdaptiveComputedTorqueState<N, K>> for AdaptiveComputedTorque<N, K, A>
{
    fn known_flags(&self) -> u64 {
        BEGUN
    }

    fn entries(&self) -> &'static str {
        "numbers"
    }

    fn size(&self) -> usize {
        K + 2 * N + 1
    }

    fn fingerprints(&self) -> [u64; 2] {
        let p = self.p.iter().flat_map(|p| [p.p12, p.p22]);
        [fnv_of(fnv_of(self.gains.tuning(), p), self.gain), fnv_of(FNV_START, [self.cutoff])]
    }

    fn flags(&self, state: &AdaptiveComputedTorqueState<N, K>) -> u64 {
        if state.past.is_some() { BEGUN } else { 0 }
    }

    fn write(&self, state: &AdaptiveComputedTorqueState<N, K>, put: &mut dyn FnMut(&[u8])) {
        let none = Moving { dq: Vector::zeros(), ddq: Vector::zeros() };
        let (Moving { dq, ddq }, dt) = state.past.unwrap_or((none, 0.0));
        let parts = [state.theta.as_slice(), dq.as_slice(), ddq.as_slice(), &[dt]];
        parts.into_iter().for_each(|part| put_all(put, part));
    }

    fn check(&self, flags: u64, part: &[u8]) -> Result<()> {
        let (theta, Moving { dq, ddq }, dt) = opened::<N, K>(part)?;
        finite("theta", theta.as_slice())?;
        finite("past", dq.as_slice())?;
        finite("past", ddq.as_slice())?;
        let possible = |dt| if flags & BEGUN != 0 { dt > 0.0 && dt <= 1.0 } else { dt == 0.0 };
        within("past", &[dt], possible, "the length of a period")
    }

    fn take(&self, state: &mut AdaptiveComputedTorqueState<N, K>, flags: u64, _: u64, part: &[u8]) {
        *state = AdaptiveComputedTorqueState::new();
        if let Ok((theta, past, dt)) = opened(part) {
            state.theta = theta;
            state.past = (flags & BEGUN != 0).then_some((past, dt));
        }
    }
}

/// θ̃, what the last sample was, and the period since then.
fn opened<const N: usize, const K: usize>(part: &[u8]) -> Result<(Vector<K>, Moving<N>, f64)> {
    let mut rest = Numbers(part);
    let theta = rest.vector()?;
    let past = Moving { dq: rest.vector()?, ddq: rest.vector()? };
    let dt = rest.number()?;
    rest.end()?;
    Ok((theta, past, dt))
}

#[cfg(test)]
#[cfg(feature = "std")]
mod tests {
    use super::*;
    use crate::arm::{Arm, TwoLink, TwoLinkParameters};

    /// The distance to the nominal parameters falls: they are inside.
    #[test]
    fn projected_parameters_have_a_positive_mass_matrix_and_are_nearer() -> Result<()> {
        let arm = TwoLink::new(TwoLinkParameters::default())?;
        let gains = Gains::with_bandwidth([5.0; 2])?;
        let gain = [1.0, 2.0, 0.5, 1.0, 1.0];
        let law = AdaptiveComputedTorque::new(arm, gains, 10.0, gain, 100.0)?;
        let size = |theta: &Vector<5>| (0..5).map(|k| theta[k] * theta[k] / gain[k]).sum::<f64>();
        let mut moved = 0;
        for k in 0..500 {
            let part = |i: usize| libm::sin(1.7 * (k * (i + 1)) as f64);
            let theta = Vector::<5>::from_fn(|i, _| if i < 3 { 4.0 * part(i) } else { 0.0 });
            let q = Vector::<2>::new(0.3, 3.0 * part(4));
            let (kept, mass) = law.kept(&q, theta);
            assert_eq!(Factor::indefinite(&(mass - arm.mass_matrix(&q) * LEAST)), None);
            assert!(size(&kept) <= size(&theta), "{theta} {kept}");
            moved += usize::from(kept != theta);
        }
        assert!(moved > 100, "{moved}");
        Ok(())
    }
}

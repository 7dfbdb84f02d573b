//! What goes with the law [`FeedForward`](super::FeedForward): the torque that the arm was seen to
//! need on top of the model, learnt and fed forward, and an observer for the rest,
//! `ρ̂ = −D⁻¹Φ(q_d)θ − α − 2p(ė − ė')`.
//!
//! ```text
//! velocity  ė' ← ė' + a (ė − ė')                      a = 1 − e^(−2πfh), joint by joint
//! observer  α = ζ − pė'     ζ ← ζ + hp (v + D⁻¹(τ_a − τ_asked) − α)
//! learn     y = LP[τ_a − ID₀] − c d/dt LP[Dė']    φ = LP[Φ]    one row of y = φθ a period
//! ```
//!
//! τ_a is the torque that acted in a period, `v = −2p (ė' + w(e)) + α`, ID₀ and Φ are those of the
//! sample for which it was asked, `delay` samples before. The columns of friction are learnt on the
//! velocity of the arm, and fed forward on the desired one. A row is left out while its torque is
//! limited, its joint rests, for friction at rest may be anything, or the arm is far from its path.

use core::f64::consts::TAU;

use super::features::{FRICTION, Features, friction};
use super::pull::Pull;
use super::regression::{Regression, unless_tiny};
use crate::arm::{Factor, Parametric};
use crate::control::{
    Applied, Audit, Channel, Compensator, Inputs, MAX_DELAY, Sample, Stage, Width,
};
use crate::error::{Result, at_most, finite, length, positive};
use crate::fuzzy::{Buffer, FuzzyBasis, Memory};
use crate::math::{Matrix, Vector, decay};

/// Every row is learnt once in this time \[s\].
const CYCLE: f64 = 0.02;
/// In this time what was learnt is half forgotten, or more: T_f of P \[s\].
const FORGETTING: f64 = 100.0;
/// Cut-off of the velocity on which friction is learnt \[Hz\].
const FRICTION_CUT_OFF: f64 = 15.0;
/// Where a joint is farther from the desired motion \[rad\], Φ(q_d) is not what acts; a row is learnt
/// if that was so, or a torque limited, in less than this share of the time that the filter sees.
const FAR: f64 = 0.1;
const ASTRAY: f64 = 0.02;
/// A joint that is slower rests [rad/s]; a row is learnt if it rested less than this share of the
/// time that the filter sees.
const REST: f64 = 0.02;
const RESTED: f64 = 0.3;
/// No limit cuts more of a torque [N·m].
const MOST: f64 = 1e10;

/// Gains of the recommended controller; [`Rule`](super::Rule) gives them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LearningGains<const N: usize> {
    /// p, at which the three poles of each joint are, and how far errors are brought back.
    pub pull: Pull<N>,
    /// f of the second velocity filter of each joint \[Hz\].
    pub cut_off: [f64; N],
    /// Cut-off of the filter through which is learnt \[Hz\].
    pub learning: f64,
    /// c.
    pub acceleration_share: f64,
    /// Period of the loop \[s\], and samples between a torque and its period.
    pub control_period: f64,
    /// At most [`MAX_DELAY`].
    pub delay: usize,
    /// |Δ (I − Δ)⁻¹| at its largest, as the rule found it: what is learnt converges for sure below
    /// 0.7. NaN for gains of one's own.
    pub condition: f64,
}

/// What is learnt.
#[derive(Clone, Debug, Default)]
pub struct Learns {
    /// Of the inertial parameters, those of the last link alone, and so of a load that it carries.
    pub payload_only: bool,
    /// A basis for what no parameter describes, and its inputs. What it learns does not hold on
    /// another path.
    pub residual: Option<(FuzzyBasis, Inputs)>,
}

/// The compensator; its memory is [`LearnedTorqueState`].
#[derive(Clone, Debug)]
pub struct LearnedTorque<const N: usize, const K: usize, A> {
    pub(super) arm: A,
    pub(super) weight: A,
    pub(super) gains: LearningGains<N>,
    pub(super) features: Features<N, K>,
}

/// What it remembers.
#[derive(Clone, Debug)]
pub struct LearnedTorqueState<const N: usize, B: Buffer> {
    /// θ, P, room for a gain, LP[Φ], the columns of the last samples, scratch.
    pub(super) memory: Memory<B>,
    pub(super) filtered: Filtered<N>,
    /// What was decided in the last samples, in turn.
    pub(super) decided: [Decided<N>; MAX_DELAY + 1],
    /// Periods that ended.
    pub(super) periods: u64,
    pub(super) frozen: bool,
    now: Now<N>,
}

/// Signals through filters, after the last period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Filtered<const N: usize> {
    /// ė' [rad/s], and the same through the filter of friction.
    pub velocity: Vector<N>,
    pub slow: Vector<N>,
    /// ζ [rad/s²].
    pub zeta: Vector<N>,
    /// LP[τ_a − ID₀] [N·m], and LP[Dė'] [N·m·s].
    pub torque: Vector<N>,
    pub momentum: Vector<N>,
    /// LP of whether a joint rests, and of whether the arm is far off or its torque limited.
    pub rest: Vector<N>,
    pub astray: f64,
    /// Length of the last period, and time since P last forgot \[s\].
    pub period: f64,
    pub since: f64,
}

/// What was decided for a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Decided<const N: usize> {
    /// Φθ + Dv [N·m].
    pub torque: Vector<N>,
    /// v [rad/s²].
    pub v: Vector<N>,
    /// q̇_d [rad/s].
    pub dq: Vector<N>,
}

/// What the sample at hand gave, worked out again for one that is pending after a load.
#[derive(Clone, Copy, Debug)]
struct Now<const N: usize> {
    /// ė' [rad/s].
    velocity: Vector<N>,
    /// α [rad/s²].
    alpha: Vector<N>,
    weight: Matrix<N>,
    /// τ_a − τ_asked [N·m].
    cut: Vector<N>,
    far: bool,
    decided: Decided<N>,
    /// Φθ and Dα [N·m].
    learned: Vector<N>,
    observed: Vector<N>,
}

/// The parts of the memory.
struct Parts<'a> {
    regression: Regression<'a>,
    /// LP[Φ]: `N` rows of K, and `N` of a joint's own.
    inertial: &'a mut [f64],
    own: &'a mut [f64],
    /// Columns of the last samples, in turn.
    columns: &'a mut [f64],
    work: &'a mut [f64],
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

impl<const N: usize> LearningGains<N> {
    fn validate(&self) -> Result<()> {
        self.pull.validate()?;
        positive("cut_off", &self.cut_off)?;
        positive("learning", &[self.learning])?;
        positive("acceleration_share", &[self.acceleration_share])?;
        positive("control_period", &[self.control_period])?;
        at_most("delay", self.delay, MAX_DELAY)
    }
}

impl<const N: usize> Filtered<N> {
    fn new() -> Self {
        let zeros = Vector::zeros();
        Self {
            velocity: zeros,
            slow: zeros,
            zeta: zeros,
            torque: zeros,
            momentum: zeros,
            rest: zeros,
            astray: 0.0,
            period: 0.0,
            since: 0.0,
        }
    }
}

impl<const N: usize> Decided<N> {
    pub fn nothing() -> Self {
        let zeros = Vector::zeros();
        Self { torque: zeros, v: zeros, dq: zeros }
    }
}

impl<const N: usize> Now<N> {
    fn new() -> Self {
        let zeros = Vector::zeros();
        let (weight, decided) = (Matrix::zeros(), Decided::nothing());
        Self {
            velocity: zeros,
            alpha: zeros,
            weight,
            cut: zeros,
            far: false,
            decided,
            learned: zeros,
            observed: zeros,
        }
    }
}

impl<const N: usize, B: Buffer> LearnedTorqueState<N, B> {
    /// Stops learning; what was learnt stays in use, and the observer goes on.
    pub fn freeze(&mut self) {
        self.frozen = true;
    }

    /// Lets learning go on.
    pub fn unfreeze(&mut self) {
        self.frozen = false;
    }

    /// Whether learning is stopped.
    pub fn frozen(&self) -> bool {
        self.frozen
    }
}

impl<const N: usize, const K: usize, A: Parametric<N, K>> LearnedTorque<N, K, A> {
    /// The compensator for what is believed of the arm, with the mass matrix of `weight` for D, and
    /// the largest torque of each joint [N·m].
    ///
    /// # Errors
    /// Naming a gain that is not finite or not > 0, or `delay` beyond [`MAX_DELAY`];
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

    /// Length of the buffer of [`state_in`](Self::state_in).
    pub fn buffer_len(&self) -> usize {
        Memory::<&mut [f64]>::buffer_len(self.len())
    }

    /// A state before the first sample, in memory that the caller lends.
    ///
    /// # Errors
    /// `buffer`: shorter than [`buffer_len`](Self::buffer_len).
    pub fn state_in<B: Buffer>(&self, buffer: B) -> Result<LearnedTorqueState<N, B>> {
        Ok(self.over(Memory::new(buffer, self.len())?))
    }

    /// A state before the first sample.
    #[cfg(feature = "std")]
    pub fn state(&self) -> LearnedTorqueState<N, Vec<f64>> {
        self.over(Memory::on_heap(self.len()))
    }

    fn over<B: Buffer>(&self, memory: Memory<B>) -> LearnedTorqueState<N, B> {
        let mut state = LearnedTorqueState {
            memory,
            filtered: Filtered::new(),
            decided: [Decided::nothing(); MAX_DELAY + 1],
            periods: 0,
            frozen: false,
            now: Now::new(),
        };
        self.begin(&mut state);
        state
    }

    fn len(&self) -> usize {
        self.sizes().iter().sum()
    }

    /// Of θ, P, a gain, LP[Φ] in two parts, columns, scratch.
    fn sizes(&self) -> [usize; 7] {
        let it = &self.features;
        let (stride, rows) = (it.stride(), it.parameters());
        let turns = self.gains.delay + 1;
        [stride, stride * rows, stride, N * K, N * it.own(), turns * it.columns(), it.work()]
    }

    fn parts<'s>(&self, mut rest: &'s mut [f64]) -> Parts<'s> {
        let [theta, p, gain, inertial, own, columns, work] = self.sizes().map(|size| {
            let (part, more) = core::mem::take(&mut rest).split_at_mut(size);
            rest = more;
            part
        });
        Parts { regression: Regression { theta, p, gain }, inertial, own, columns, work }
    }

    /// θ, P, and the filtered and last columns: what is saved of the memory.
    pub(super) fn kept<'s>(&self, memory: &'s [f64]) -> [&'s [f64]; 3] {
        let [stride, cells, gain, ..] = self.sizes();
        let (theta, rest) = memory.split_at(stride);
        let (p, rest) = rest.split_at(cells);
        [&theta[..self.features.parameters()], p, &rest[gain..][..self.columns_kept()]]
    }

    /// Length of the last of them.
    pub(super) fn columns_kept(&self) -> usize {
        self.sizes()[3..6].iter().sum()
    }

    /// As before the first sample.
    pub(super) fn begin<B: Buffer>(&self, state: &mut LearnedTorqueState<N, B>) {
        state.memory.as_mut_slice().fill(0.0);
        self.parts(state.memory.as_mut_slice()).regression.reset(self.features.prior());
        state.filtered = Filtered::new();
        state.decided = [Decided::nothing(); MAX_DELAY + 1];
        (state.periods, state.frozen, state.now) = (0, false, Now::new());
    }

    /// Where the columns of period `k` are.
    fn turn(&self, k: u64) -> usize {
        (k % (self.gains.delay as u64 + 1)) as usize
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

    /// The end of a period of `dt` \[s\].
    fn end<B: Buffer>(&self, state: &mut LearnedTorqueState<N, B>, dt: f64, learns: bool) {
        let LearnedTorqueState { memory, filtered, decided, periods, now, .. } = state;
        let (delay, k) = (self.gains.delay as u64, *periods);
        decided[self.turn(k)] = now.decided;
        let mut parts = self.parts(memory.as_mut_slice());
        // What acts before the first torque arrives keeps the arm as it is.
        let acting = k.checked_sub(delay).map(|k| (self.turn(k), decided[self.turn(k)]));
        let v = acting.map_or(Vector::zeros(), |(_, it)| it.v);
        let pushed = if now.cut == Vector::<N>::zeros() {
            now.cut
        } else {
            Factor::of(&now.weight).solve(&now.cut)
        };
        let momentum = now.weight * now.velocity;
        if k == 0 {
            (filtered.slow, filtered.momentum) = (now.velocity, momentum);
        }
        let missing = v + pushed - now.alpha;
        let p = &self.gains.pull.bandwidth;
        filtered.zeta += Vector::from_fn(|n, _| (p[n] * dt).min(1.0) * missing[n]);
        filtered.velocity = now.velocity;
        filtered.slow += (now.velocity - filtered.slow) * filter(FRICTION_CUT_OFF, dt);
        (filtered.period, *periods) = (dt, k.saturating_add(1));
        let Some((turn, acting)) = acting else { return };
        let share = filter(self.gains.learning, dt);
        let velocity = acting.dq + filtered.slow;
        self.smooth(share, turn, &velocity, &mut parts);
        let last = filtered.momentum;
        filtered.torque += (acting.torque + now.cut - filtered.torque) * share;
        filtered.momentum += (momentum - last) * share;
        let rests = velocity.map(|v| if v.abs() < REST { 1.0 } else { 0.0 });
        filtered.rest += (rests - filtered.rest) * share;
        let astray = now.far || now.cut != Vector::<N>::zeros();
        filtered.astray += (if astray { 1.0 } else { 0.0 } - filtered.astray) * share;
        filtered.since += dt;
        if learns {
            let change = (filtered.momentum - last) / dt;
            let wanted = filtered.torque - change * self.gains.acceleration_share;
            self.learn(k, &wanted, filtered, &mut parts);
        }
    }

    /// The rows whose turn it is in period `k`, and after all of them P forgets.
    fn learn(&self, k: u64, wanted: &Vector<N>, filtered: &mut Filtered<N>, parts: &mut Parts<'_>) {
        let Parts { regression, inertial, own, .. } = parts;
        let cycle = libm::rint(CYCLE / self.gains.control_period).max(1.0) as u64;
        let tasks = (N + 1).div_ceil(cycle as usize);
        let first = (k % cycle) as usize * tasks;
        for n in (first..first + tasks).take_while(|n| *n <= N) {
            if n == N {
                let share = filtered.since / FORGETTING;
                regression.forget(share.min(1.0), self.features.prior());
                filtered.since = 0.0;
            } else if filtered.rest[n] <= RESTED && filtered.astray <= ASTRAY {
                let own = &own[n * self.features.own()..][..self.features.own()];
                let row = self.features.row(n, &inertial[self.features.acting(n)], own);
                regression.learn(&row, wanted[n], self.features.unit[n]);
            }
        }
    }

    /// The columns of the torque that acted, through the filter.
    fn smooth(&self, share: f64, turn: usize, velocity: &Vector<N>, parts: &mut Parts<'_>) {
        let Parts { inertial, own, columns, .. } = parts;
        let columns = &columns[turn * self.features.columns()..][..self.features.columns()];
        for n in 0..N {
            let acting = self.features.acting(n);
            approach(&mut inertial[acting.clone()], share, &columns[acting]);
            let own = &mut own[n * self.features.own()..][..self.features.own()];
            approach(own, share, &friction(velocity[n]));
            approach(&mut own[FRICTION..], share, &columns[N * K..]);
        }
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

/// The share that a filter with this cut-off \[Hz\] takes of a new value, after `period` \[s\].
pub(super) fn filter(cut_off: f64, period: f64) -> f64 {
    1.0 - decay(TAU * cut_off * period)
}

/// y ← y + share (x − y).
fn approach(y: &mut [f64], share: f64, x: &[f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y = unless_tiny(*y + share * (x - *y));
    }
}

//! Computed torque for the nominal arm, with a compensator:
//!
//! ```text
//! v = q̈_d − K_v ė − K_p e
//! τ = M₀(q)(v − ρ̂) + H₀(q, q̇) = (M₀ v + H₀) − M₀ ρ̂        (7), (11), (12)
//! ```

use super::{Compensator, Limits, NoCompensation, Sample, Stage};
use crate::arm::Arm;
use crate::error::{Error, Result, positive, within};
use crate::math::Vector;
use crate::reference::Setpoint;

/// Measurements and set-points beyond this are impossible for an arm, as in MuJoCo.
const IMPOSSIBLE: f64 = 1e10;

/// Periods of a sampled controller [s].
const SHORTEST_PERIOD: f64 = 1e-9;
const LONGEST_PERIOD: f64 = 1.0;

/// Feedback gains of each joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gains<const N: usize> {
    /// K_p [1/s²].
    pub kp: [f64; N],
    /// K_v [1/s].
    pub kv: [f64; N],
}

impl<const N: usize> Gains<N> {
    /// Diagonal gains; the error dynamics ë + K_v ė + K_p e = 0 (8) are stable exactly when all are > 0.
    ///
    /// # Errors
    /// `kp`, `kv`: not finite or not > 0.
    pub fn new(kp: [f64; N], kv: [f64; N]) -> Result<Self> {
        positive("kp", &kp)?;
        positive("kv", &kv)?;
        Ok(Self { kp, kv })
    }

    /// v = q̈_d − K_v ė − K_p e [rad/s²].
    #[inline]
    pub fn acceleration(&self, sample: &Sample<N>) -> Vector<N> {
        let Sample { desired, e, de, .. } = sample;
        Vector::from_fn(|n, _| desired.ddq[n] - self.kv[n] * de[n] - self.kp[n] * e[n])
    }
}

/// What one step of a controller returns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Command<const N: usize> {
    /// τ, the torque to apply: finite and inside the limits [N·m].
    pub tau: Vector<N>,
    /// M₀ v + H₀, what the nominal model asks for [N·m].
    pub model: Vector<N>,
    /// −M₀ ρ̂, what the compensator adds [N·m].
    pub compensation: Vector<N>,
    /// v, the acceleration that the feedback asks for [rad/s²].
    pub v: Vector<N>,
    /// ρ̂ [rad/s²].
    pub rho_hat: Vector<N>,
    /// Whether a limit cut the torque; nothing was learnt then.
    pub limited: bool,
}

/// What a controller remembers between samples.
#[derive(Clone, Debug, PartialEq)]
pub struct State<const N: usize, S = ()> {
    /// The compensator's state.
    pub compensator: S,
    /// The torque applied last [N·m], for the rate limit.
    pub last_tau: Option<Vector<N>>,
    /// Number of samples accepted.
    pub steps: u64,
}

impl<const N: usize, S> State<N, S> {
    /// A controller's state before its first sample.
    pub fn new(compensator: S) -> Self {
        Self { compensator, last_tau: None, steps: 0 }
    }
}

/// The controller: nominal arm, gains, compensator, limits. Immutable.
#[derive(Clone, Debug)]
pub struct ComputedTorque<const N: usize, A, C = NoCompensation> {
    /// What the controller believes of the arm.
    pub arm: A,
    /// Feedback gains.
    pub gains: Gains<N>,
    /// Produces ρ̂.
    pub compensator: C,
    /// Bounds on the torque.
    pub limits: Limits<N>,
}

impl<const N: usize, A: Arm<N>, C> ComputedTorque<N, A, C> {
    /// A controller without torque limits.
    pub fn new(arm: A, gains: Gains<N>, compensator: C) -> Self {
        Self { arm, gains, compensator, limits: Limits::default() }
    }

    /// The same controller with torque limits.
    ///
    /// # Errors
    /// `effort_limit`, `effort_rate_limit`: NaN or not > 0.
    pub fn with_limits(mut self, limits: Limits<N>) -> Result<Self> {
        limits.validate()?;
        self.limits = limits;
        Ok(self)
    }

    /// What it sees: a measurement and a set-point, with e around the circle where a joint of the nominal arm turns without
    /// an end.
    #[inline]
    pub fn sample(&self, q: &Vector<N>, dq: &Vector<N>, desired: &Setpoint<N>) -> Sample<N> {
        Sample::wrapped(*q, *dq, *desired, &self.arm.wraps())
    }

    /// Forgets everything: the state is then as a new one, to the bit.
    pub fn reset<S>(&self, state: &mut State<N, S>)
    where
        C: Compensator<N, S>,
    {
        let State { compensator, last_tau, steps } = state;
        self.compensator.reset(compensator);
        (*last_tau, *steps) = (None, 0);
    }

    /// One sample of the controller: the torque for this instant, and the adaptation over the period `dt` [s] that
    /// it will be held for. Allocates nothing and cannot panic.
    ///
    /// # Errors
    /// `q`, `dq`, `q_d`, `dq_d`, `ddq_d`: not finite, or beyond 1e10. `dt`: not between 1 ns and 1 s. `tau`,
    /// `weights`: the result would not be finite. On any error all that later steps depend on is bit for bit as before;
    /// only a refusal for `tau` or `weights`, which comes late, leaves other scratch memory behind.
    pub fn step<S>(
        &self,
        state: &mut State<N, S>,
        q: &Vector<N>,
        dq: &Vector<N>,
        desired: &Setpoint<N>,
        dt: f64,
    ) -> Result<Command<N>>
    where
        C: Compensator<N, S>,
    {
        check_sample(q, dq, desired)?;
        check_period("dt", dt)?;
        let sample = self.sample(q, dq, desired);
        let mut command = self.law(&mut state.compensator, &Stage::NOW, &sample);
        let wished = command.tau;
        if let Some(n) = wished.iter().position(|tau| !tau.is_finite()) {
            return Err(Error::not_finite("tau", wished[n]).at(n));
        }
        if let Some(last) = &state.last_tau {
            command.tau = self.limits.clamp_after(last, &command.tau, dt);
            command.limited |= command.tau != wished;
        }
        if command.limited {
            self.compensator.hold(&mut state.compensator, 0);
        }
        self.compensator.advance(&mut state.compensator, &Stage::after(dt))?;
        state.last_tau = Some(command.tau);
        state.steps += 1;
        Ok(command)
    }

    /// The law at one stage of a step, inside the effort limit; the compensator records its rate of change.
    #[inline(always)]
    pub fn law<S>(&self, state: &mut S, stage: &Stage<'_>, sample: &Sample<N>) -> Command<N>
    where
        C: Compensator<N, S>,
    {
        let (mass, bias) = self.arm.mass_matrix_and_bias(&sample.q, &sample.dq);
        let v = self.gains.acceleration(sample);
        let rho_hat = self.compensator.estimate(state, stage, sample);
        let model = mass * v + bias;
        let compensation = -(mass * rho_hat);
        let wished = model + compensation;
        let tau = self.limits.clamp(&wished);
        Command { tau, model, compensation, v, rho_hat, limited: tau != wished }
    }
}

/// Refuses periods that no sampled controller has.
pub(crate) fn check_period(parameter: &'static str, period: f64) -> Result<()> {
    let possible = |dt: f64| (SHORTEST_PERIOD..=LONGEST_PERIOD).contains(&dt);
    within(parameter, &[period], possible, "a period between 1e-9 and 1 s")
}

fn check_sample<const N: usize>(
    q: &Vector<N>,
    dq: &Vector<N>,
    desired: &Setpoint<N>,
) -> Result<()> {
    let possible = |x: f64| x.abs() <= IMPOSSIBLE;
    let wanted = "a value an arm can have (at most 1e10)";
    within("q", q.as_slice(), possible, wanted)?;
    within("dq", dq.as_slice(), possible, wanted)?;
    within("q_d", desired.q.as_slice(), possible, wanted)?;
    within("dq_d", desired.dq.as_slice(), possible, wanted)?;
    within("ddq_d", desired.ddq.as_slice(), possible, wanted)
}

//! A controller: a law with a compensator inside limits, stepped once a period or evaluated at
//! every stage of an integrator.
//!
//! ```text
//! seen = (q, q̇, q_d, e, ė)     ρ̂ = estimate(seen)     τ_asked = law(seen, ρ̂)
//! τ = limited(τ_asked)         acted(τ, τ_asked)
//! ```

use super::{Applied, Compensator, Demand, Law, Limits, NoCompensation, Sample, Stage};
use crate::error::{Error, Result, within};
use crate::math::Vector;
use crate::reference::Setpoint;

/// Measurements and set-points beyond this are impossible for an arm, as in MuJoCo.
const IMPOSSIBLE: f64 = 1e10;

/// Periods of a sampled controller \[s\].
const SHORTEST_PERIOD: f64 = 1e-9;
const LONGEST_PERIOD: f64 = 1.0;

/// What one step of a controller returns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Command<const N: usize> {
    /// τ, the torque to apply: finite and inside the limits [N·m].
    pub tau: Vector<N>,
    /// What feedback and nominal model ask for, M₀ v + H₀ in computed torque [N·m].
    pub model: Vector<N>,
    /// What the compensator adds, −M₀ ρ̂ in computed torque [N·m].
    pub compensation: Vector<N>,
    /// v, the acceleration that the law asks for [rad/s²].
    pub v: Vector<N>,
    /// ρ̂ [rad/s²].
    pub rho_hat: Vector<N>,
    /// Whether a limit cut the torque; nothing was learnt then.
    pub limited: bool,
}

impl<const N: usize> Command<N> {
    /// The torque `tau` that acted, beside the one that the law asked for.
    #[inline(always)]
    pub fn applied(&self, tau: &Vector<N>) -> Applied<N> {
        Applied { asked: self.model + self.compensation, tau: *tau }
    }
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

/// A controller: law, compensator, limits. Immutable; one can drive many states.
#[derive(Clone, Copy, Debug)]
pub struct Controller<const N: usize, L, C = NoCompensation> {
    /// Gives τ from a sample and ρ̂.
    pub law: L,
    /// Produces ρ̂.
    pub compensator: C,
    /// Bounds on the torque.
    pub limits: Limits<N>,
}

impl<const N: usize, L: Law<N>, C> Controller<N, L, C> {
    /// A controller without torque limits.
    pub fn new(law: L, compensator: C) -> Self {
        Self { law, compensator, limits: Limits::default() }
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

    /// What the law sees: a measurement and a set-point. e is taken around the circle where the law
    /// says that a joint turns without an end.
    #[inline]
    pub fn sample(&self, q: &Vector<N>, dq: &Vector<N>, desired: &Setpoint<N>) -> Sample<N> {
        Sample::wrapped(*q, *dq, *desired, &self.law.wraps())
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

    /// One sample of the controller: the torque for this instant, and the adaptation over the
    /// period `dt` \[s\] that it will be held for. Allocates nothing and cannot panic.
    ///
    /// # Errors
    /// `q`, `dq`, `q_d`, `dq_d`, `ddq_d`: not finite, or beyond 1e10. `dt`: not between 1 ns and 1
    /// s. `tau`, and what the compensator names, such as `weights`: the result would not be finite.
    /// After any error, all that later steps depend on is bit for bit as before. Scratch memory may
    /// differ after a result was refused.
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
        let mut command = self.decide(&mut state.compensator, &Stage::NOW, &sample);
        if let Some(n) = command.tau.iter().position(|tau| !tau.is_finite()) {
            return Err(Error::not_finite("tau", command.tau[n]).at(n));
        }
        if let Some(last) = &state.last_tau {
            command.tau = self.limits.clamp_after(last, &command.tau, dt);
        }
        let applied = command.applied(&command.tau);
        command.limited = applied.limited();
        self.compensator.acted(&mut state.compensator, 0, &sample, &applied);
        self.compensator.advance(&mut state.compensator, &Stage::after(dt))?;
        state.last_tau = Some(command.tau);
        state.steps += 1;
        Ok(command)
    }

    /// The torque at one stage of a step, inside the effort limit. The caller who applies it tells
    /// the compensator what [acted](Compensator::acted).
    #[inline(always)]
    pub fn decide<S>(&self, state: &mut S, stage: &Stage<'_>, sample: &Sample<N>) -> Command<N>
    where
        C: Compensator<N, S>,
    {
        let rho_hat = self.compensator.estimate(state, stage, sample);
        let Demand { model, compensation, v } = self.law.torque(sample, &rho_hat);
        let asked = model + compensation;
        let tau = self.limits.clamp(&asked);
        let limited = Applied { asked, tau }.limited();
        Command { tau, model, compensation, v, rho_hat, limited }
    }
}

/// Refuses periods that are too short or too long for a sampled controller.
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

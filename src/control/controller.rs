//! A controller: a law with a compensator inside limits, stepped once a period or evaluated at
//! every stage of an integrator.
//!
//! ```text
//! period k − 1 ends:      acted(τ_applied, τ_asked)     advance(dt)
//! period k is decided:    seen = (q, q̇, q_d, e, ė)      ρ̂ = estimate(seen)
//!                         τ_asked = law(seen, ρ̂)        τ = limited(τ_asked)
//! ```
//!
//! This is the one hold rule: a step first ends the period before with the torque that acted in it,
//! by default the one that was commanded, and then decides.

use super::checks::{check_applied, check_period, check_sample, desired_felt, felt};
use super::front::{FrontMemory, View};
use super::limits::possible;
use super::state::Pending;
use super::{
    Applied, Compensator, Demand, Front, Law, Limits, NoCompensation, Sample, Stage, State,
};
use crate::error::{Error, Result, finite};
#[cfg(feature = "std")]
use crate::math::Matrix;
use crate::math::Vector;
use crate::reference::Setpoint;

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
    /// Whether a limit cut the torque; nothing is learnt in its period then.
    pub limited: bool,
}

impl<const N: usize> Command<N> {
    /// The torque `tau` that acted, beside the one that the law asked for.
    #[inline(always)]
    pub fn applied(&self, tau: &Vector<N>) -> Applied<N> {
        Applied::new(self.model + self.compensation, *tau)
    }
}

/// A controller: front, law, compensator, limits. Immutable; one can drive many states.
#[derive(Clone, Copy, Debug)]
pub struct Controller<const N: usize, L, C = NoCompensation> {
    /// Gives τ from a sample and ρ̂.
    pub law: L,
    /// Produces ρ̂.
    pub compensator: C,
    /// Bounds on the torque.
    pub limits: Limits<N>,
    /// What stands before the law.
    pub front: Front,
}

impl<const N: usize, L: Law<N>, C> Controller<N, L, C> {
    /// A controller without torque limits, and with nothing before its law.
    pub fn new(law: L, compensator: C) -> Self {
        Self { law, compensator, limits: Limits::default(), front: Front::default() }
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

    /// The same controller with a front.
    ///
    /// # Errors
    /// As [`Front::validate`].
    pub fn with_front(mut self, front: Front) -> Result<Self> {
        front.validate()?;
        self.front = front;
        Ok(self)
    }

    /// What the law sees: a measurement and a set-point. e is taken around the circle where the law
    /// says that a joint turns without an end.
    #[inline]
    pub fn sample(&self, q: &Vector<N>, dq: &Vector<N>, desired: &Setpoint<N>) -> Sample<N> {
        Sample::wrapped(*q, *dq, *desired, &self.law.wraps())
    }

    /// The same as it is felt: without what is too small to mean anything.
    #[inline(always)]
    pub(crate) fn felt(&self, q: &Vector<N>, dq: &Vector<N>, desired: &Setpoint<N>) -> Sample<N> {
        self.sample(&felt(q), &felt(dq), &desired_felt(desired))
    }

    /// Whether its law sees what is measured, and no torque depends on the one before but by what
    /// is learnt: nothing stands before the law, and no rate is limited.
    #[cfg(feature = "std")]
    pub(crate) fn is_bare(&self) -> bool {
        !self.front.is_on() && !self.limits.limits_rate()
    }

    /// Forgets everything: the state is then as a new one, to the bit. If a torque is on the robot,
    /// say so by [`State::take_over`] afterwards.
    pub fn reset<S>(&self, state: &mut State<N, S>)
    where
        C: Compensator<N, S>,
    {
        let State { compensator, last_tau, steps, pending, front } = state;
        self.compensator.reset(compensator);
        (*last_tau, *steps, *pending) = (None, 0, None);
        *front = FrontMemory::new();
    }

    /// One sample of the controller: ends the period before with the torque that it commanded, then
    /// decides the torque to hold for `dt` \[s\]. Allocates nothing and cannot panic.
    ///
    /// Where the drive may have let through another torque, tell it by
    /// [`step_after`](Self::step_after).
    ///
    /// # Errors
    /// `q`, `q_d`: not finite, or beyond 1e5 rad. `dq`, `dq_d`, `ddq_d`: not finite, or beyond
    /// 1e10. `dt`: not between 1 ns and 1 s. What the compensator names, such as `weights`: they
    /// could not be finite at the end of the period. Nothing has changed then, bit for bit.
    /// `resting_torque`, `tau`: the law's result is not finite. For `tau` the period before has
    /// ended, as told; all else is as it was.
    #[inline]
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
        self.step_after(state, None, q, dq, desired, dt)
    }

    /// The same, told the torque `applied` [N·m] that acted since the last step: what the drive let
    /// through. `None`: what was commanded. Where it differs from what the law asked for, by
    /// whatever little, nothing is learnt in that period: a measured torque with its noise is not
    /// what is wanted here. Without a pending period it says nothing, as before the first step.
    ///
    /// The rate limit counts from the torque commanded last, whatever became of it.
    ///
    /// A period that would not end in finite numbers, with this torque, is left out: nothing is
    /// learnt from it. [`end_period`](Self::end_period) tells.
    ///
    /// # Errors
    /// As [`step`](Self::step). `applied`: not finite; nothing has changed then.
    #[inline]
    pub fn step_after<S>(
        &self,
        state: &mut State<N, S>,
        applied: Option<&Vector<N>>,
        q: &Vector<N>,
        dq: &Vector<N>,
        desired: &Setpoint<N>,
        dt: f64,
    ) -> Result<Command<N>>
    where
        C: Compensator<N, S>,
    {
        self.step_by(state, applied, (q, dq, desired), dt, |sample, rho_hat| {
            self.law.torque(sample, rho_hat)
        })
    }

    /// The same with what `demand` asks for in the place of the law.
    #[inline(always)]
    fn step_by<S>(
        &self,
        state: &mut State<N, S>,
        applied: Option<&Vector<N>>,
        (q, dq, desired): (&Vector<N>, &Vector<N>, &Setpoint<N>),
        dt: f64,
        demand: impl FnOnce(&Sample<N>, &Vector<N>) -> Demand<N>,
    ) -> Result<Command<N>>
    where
        C: Compensator<N, S>,
    {
        check_applied(applied)?;
        check_sample(q, dq, desired)?;
        check_period("dt", dt)?;
        let mut sample = self.felt(q, dq, desired);
        let view = self.front.is_on().then(|| self.look(state, &mut sample)).transpose()?;
        self.compensator.admit(&state.compensator, &sample, dt)?;
        let last = self.last_tau(state, q)?;
        // What cannot end is left out.
        _ = self.end(state, applied);
        let mut command = self.decide_by(&mut state.compensator, &Stage::NOW, &sample, demand);
        let view = view.map(|view| self.cushion(state, view, q, &mut command));
        if let Some(n) = command.tau.iter().position(|tau| !tau.is_finite()) {
            return Err(Error::not_finite("tau", command.tau[n]).at(n));
        }
        if let Some(last) = &last {
            command.tau = self.limits.clamp_after(last, &command.tau, dt);
        }
        let applied = command.applied(&command.tau);
        command.limited = applied.limited();
        if let Some(view) = view {
            state.front.view = view;
            if state.steps == 0 {
                let before = state.last_tau.unwrap_or_else(|| self.law.resting_torque(q));
                state.front.wait(&self.limits.clamp(&before));
            }
        }
        state.pending = Some(Pending { sample, applied, dt });
        state.last_tau = Some(possible(&command.tau));
        state.steps = state.steps.saturating_add(1);
        Ok(command)
    }

    /// As [`step`](Self::step) from M₀ and H₀ at this q and q̇, for a law that has a
    /// [`model`](Law::model) and sees q̇ as it is measured.
    #[cfg(feature = "std")]
    pub(crate) fn step_from<S>(
        &self,
        dynamics: &(Matrix<N>, Vector<N>),
        state: &mut State<N, S>,
        Sample { q, dq, desired, .. }: &Sample<N>,
        dt: f64,
    ) -> Result<Command<N>>
    where
        C: Compensator<N, S>,
    {
        self.step_by(state, None, (q, dq, desired), dt, |sample, rho_hat| {
            self.law.torque_by(dynamics, sample, rho_hat)
        })
    }

    /// Tells how long the last period really was, before the next step: where the loop jitters, or
    /// lost a sample.
    ///
    /// # Errors
    /// `elapsed`: not between 1 ns and 1 s.
    pub fn lasted<S>(&self, state: &mut State<N, S>, elapsed: f64) -> Result<()> {
        check_period("elapsed", elapsed)?;
        match &mut state.pending {
            Some(pending) => {
                if self.front.is_on() {
                    state.front.lost = (libm::rint(elapsed / pending.dt) - 1.0).max(0.0);
                }
                pending.dt = elapsed;
            }
            None if self.front.is_on() => state.front.period = elapsed,
            None => {}
        }
        Ok(())
    }

    /// Ends the period that the last step decided on, if that is pending, with the torque `applied`
    /// [N·m]; `None`: with what was commanded. The next step does so itself.
    ///
    /// # Errors
    /// `applied`: not finite; the period is then still pending. What the compensator names, such as
    /// `weights`: they would not be finite. The period has ended then, and nothing was learnt from
    /// it.
    #[inline]
    pub fn end_period<S>(&self, state: &mut State<N, S>, applied: Option<&Vector<N>>) -> Result<()>
    where
        C: Compensator<N, S>,
    {
        check_applied(applied)?;
        self.end(state, applied)
    }

    #[inline(always)]
    fn end<S>(&self, state: &mut State<N, S>, applied: Option<&Vector<N>>) -> Result<()>
    where
        C: Compensator<N, S>,
    {
        let Some(Pending { sample, applied: commanded, dt }) = state.pending.take() else {
            return Ok(());
        };
        let acting = self.front.acting(&state.front, &commanded);
        let tau = applied.copied().unwrap_or(acting.tau);
        let late = self.front.delay > 0;
        let acted = Applied { tau, commanded: if late { commanded.tau } else { tau }, ..acting };
        if self.front.is_on() {
            state.front.ended(&commanded, dt);
        }
        self.compensator.acted(&mut state.compensator, 0, &sample, &acted);
        self.compensator.advance(&mut state.compensator, &Stage::after(dt))
    }

    /// Ends the period that is pending, if any, with the torque that was commanded, and gives the
    /// compensator's state: to read or set its weights, to freeze it.
    ///
    /// What the next step tells of that period is then too late: where another torque acted, tell
    /// it by [`end_period`](Self::end_period) before.
    pub fn settle<'s, S>(&self, state: &'s mut State<N, S>) -> &'s mut S
    where
        C: Compensator<N, S>,
    {
        // What cannot end is left out.
        _ = self.end(state, None);
        &mut state.compensator
    }

    /// What the rate limit counts from: the torque commanded last, or the torque at take-over.
    #[inline]
    fn last_tau<S>(&self, state: &State<N, S>, q: &Vector<N>) -> Result<Option<Vector<N>>> {
        match state.last_tau {
            None if self.limits.limits_rate() => {
                let resting = self.law.resting_torque(q);
                finite("resting_torque", resting.as_slice())?;
                Ok(Some(resting))
            }
            last => Ok(last),
        }
    }

    /// What the law is to see, through the front, and what that remembers then.
    #[inline(never)]
    fn look<S>(&self, state: &State<N, S>, sample: &mut Sample<N>) -> Result<View<N>> {
        let (mut view, elapsed) = (state.front.view, state.front.period);
        let elapsed = state.pending.as_ref().map_or(elapsed, |pending| pending.dt);
        *sample = self.front.look(&mut view, sample, elapsed, &self.law.wraps());
        check_sample(&sample.q, &sample.dq, &sample.desired)?;
        Ok(view)
    }

    /// Takes the jump out of the first torques.
    #[inline(never)]
    fn cushion<S>(
        &self,
        state: &State<N, S>,
        mut view: View<N>,
        q: &Vector<N>,
        command: &mut Command<N>,
    ) -> View<N> {
        if self.front.bumpless.is_none() {
            return view;
        }
        let before = state.last_tau.unwrap_or_else(|| self.law.resting_torque(q));
        let asked = command.model + command.compensation;
        self.front.cushion(&mut view, &before, &asked, &mut command.model);
        command.tau = self.limits.clamp(&(command.model + command.compensation));
        view
    }

    /// The torque at one stage of a step, inside the effort limit. The caller who applies it tells
    /// the compensator what [acted](Compensator::acted).
    #[inline(always)]
    pub fn decide<S>(&self, state: &mut S, stage: &Stage<'_>, sample: &Sample<N>) -> Command<N>
    where
        C: Compensator<N, S>,
    {
        self.decide_by(state, stage, sample, |sample, rho_hat| self.law.torque(sample, rho_hat))
    }

    #[inline(always)]
    fn decide_by<S>(
        &self,
        state: &mut S,
        stage: &Stage<'_>,
        sample: &Sample<N>,
        demand: impl FnOnce(&Sample<N>, &Vector<N>) -> Demand<N>,
    ) -> Command<N>
    where
        C: Compensator<N, S>,
    {
        let rho_hat = self.compensator.estimate(state, stage, sample);
        let Demand { model, compensation, v } = demand(sample, &rho_hat);
        let asked = model + compensation;
        let tau = self.limits.clamp(&asked);
        let limited = Applied::new(asked, tau).limited();
        Command { tau, model, compensation, v, rho_hat, limited }
    }
}

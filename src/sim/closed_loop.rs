//! Plant, controller and reference as one system in continuous time, the paper's setting.

use super::certificate::Certificate;
use super::doubt::Coarse;
use super::evaluation::Evaluation;
use super::integrators::{Motion, RK4};
use super::stiff::{self, Moved};
use crate::arm::{Arm, JointFriction, Posed, Resistance};
use crate::control::{Command, Compensator, Controller, Law, MAX_STAGES, Sample, Stage};
use crate::error::Result;
use crate::math::{Vector, part};
use crate::plant::{Disturbance, Plant};
use crate::reference::{Reference, Setpoint};

/// The closed loop: the controller acts at every stage of the integrator.
pub struct ClosedLoop<'a, const N: usize, A, D, L, C, R> {
    plant: &'a Plant<N, A, D>,
    pub(super) controller: &'a Controller<N, L, C>,
    reference: &'a R,
    /// The latest time with its set-point, and with the disturbance if that depends on time alone.
    /// Two stages often fall on one time.
    latest: Option<(f64, Setpoint<N>, Option<Vector<N>>)>,
    /// The loop at the stage remembered last, and the certificate's share of every stage.
    evaluation: Option<Evaluation<N>>,
    pub(super) shares: [Certificate; MAX_STAGES],
    /// What opposes the motion of the plant's joints; `None` if nothing does.
    laws: Option<[Resistance; N]>,
    /// 2 s·F at the stages of a step in which friction was solved for, and F at its end.
    pub(super) pulls: [f64; 4],
    pub(super) last_braking: Option<Vector<N>>,
    /// What the step that has begun cannot follow.
    lost: Option<(usize, Coarse)>,
}

/// What drives the plant at a stage: command, what the actuators made of it, and τ − τ_d [N·m].
struct Driven<const N: usize> {
    sample: Sample<N>,
    command: Command<N>,
    applied: Vector<N>,
    net: Vector<N>,
}

/// The start of a step of the loop: q̈ there, and how the step is to be made.
#[derive(Clone, Copy, Debug)]
pub struct Start<const N: usize> {
    /// q̈ [rad/s²].
    pub ddq: Vector<N>,
    /// What to solve for, and M⁻¹r, if the step is beyond RK4.
    stiff: Option<([Resistance; N], Vector<N>)>,
}

impl<const N: usize> Start<N> {
    /// Whether friction is to be solved for.
    pub(super) fn is_stiff(&self) -> bool {
        self.stiff.is_some()
    }
}

impl<'a, const N: usize, A, D, L, C, R> ClosedLoop<'a, N, A, D, L, C, R>
where
    A: Arm<N>,
    D: Disturbance<N>,
    L: Law<N>,
    R: Reference<N>,
{
    /// A loop of these three.
    pub fn new(
        plant: &'a Plant<N, A, D>,
        controller: &'a Controller<N, L, C>,
        reference: &'a R,
    ) -> Self {
        Self {
            plant,
            controller,
            reference,
            latest: None,
            evaluation: None,
            shares: [Certificate::default(); MAX_STAGES],
            laws: plant.arm.resists().then(|| stiff::cancelled(&plant.arm, &controller.law)),
            pulls: [0.0; 4],
            last_braking: None,
            lost: None,
        }
    }

    /// The loop at the stage that [`acceleration`](Self::acceleration) was asked for last.
    pub fn evaluation(&self) -> Option<&Evaluation<N>> {
        self.evaluation.as_ref()
    }

    /// q̈ at a stage, time `t`; remembers the evaluation.
    #[inline]
    pub fn acceleration<S>(
        &mut self,
        state: &mut S,
        stage: &Stage<'_>,
        t: f64,
        motion: &Motion<N>,
    ) -> Vector<N>
    where
        C: Compensator<N, S>,
    {
        part::<N, _>(|| {
            let (evaluation, ddq) = self.evaluate(state, stage, t, motion);
            self.evaluation = Some(evaluation);
            ddq
        })
    }

    /// The start of a step of length `h` \[s\] at time `t`; remembers the evaluation.
    pub fn start<S>(&mut self, state: &mut S, h: f64, t: f64, motion: &Motion<N>) -> Start<N>
    where
        C: Compensator<N, S>,
    {
        part::<N, _>(|| {
            let (evaluation, start) = self.begin(state, h, t, motion);
            self.evaluation = Some(evaluation);
            start
        })
    }

    /// The loop at the start of such a step, and how the step is to be made.
    #[inline(always)]
    pub(super) fn begin<S>(
        &mut self,
        state: &mut S,
        h: f64,
        t: f64,
        motion: &Motion<N>,
    ) -> (Evaluation<N>, Start<N>)
    where
        C: Compensator<N, S>,
    {
        let stage = &RK4.stage(0, h);
        if let Some(laws) = self.laws {
            return self.begin_braked(state, stage, t, motion, laws);
        }
        let (evaluation, ddq) = self.evaluate(state, stage, t, motion);
        (evaluation, Start { ddq, stiff: None })
    }

    /// The same where something opposes the motion of the joints.
    #[inline(never)]
    fn begin_braked<S>(
        &mut self,
        state: &mut S,
        stage: &Stage<'_>,
        t: f64,
        motion: &Motion<N>,
        mut laws: [Resistance; N],
    ) -> (Evaluation<N>, Start<N>)
    where
        C: Compensator<N, S>,
    {
        let Motion { q, dq } = motion;
        let arm = &self.plant.arm;
        let (posed, mut push) = (Posed::of(arm, q, dq), Vector::zeros());
        let (evaluation, ddq) = self.evaluate_by(state, stage, t, motion, |net| {
            push = *net;
            posed.acceleration(arm, (q, dq), net)
        });
        if !stiff::beyond_rk4(&posed, &laws, stage.step) {
            return (evaluation, Start { ddq, stiff: None });
        }
        let Command { model, compensation, .. } = evaluation.command;
        for i in 0..N {
            if evaluation.applied[i] != model[i] + compensation[i] {
                laws[i].known = JointFriction::default();
            }
        }
        let inverse = posed.factor.inverse_diagonal();
        let falling = stiff::falling(&posed, &laws, stage.step).filter(|(rate, _)| *rate > 1.0);
        self.lost = falling.map(|(_, joint)| (joint, Coarse::Falling));
        let uncovered = (0..N).find(|&i| {
            let explicit = self.controller.law.joint_friction(i);
            let stiff = stage.step * explicit.steepest() * inverse[i] > stiff::MOST_BRAKING;
            stiff && explicit != laws[i].known
        });
        self.lost = self.lost.or(uncovered.map(|joint| (joint, Coarse::Uncovered)));
        let free = posed.free(&(push - stiff::known(&laws, dq)));
        self.pull(0, &evaluation, &(ddq - free));
        (evaluation, Start { ddq, stiff: Some((laws, free)) })
    }

    /// q̈ at a stage that no row is recorded of.
    #[inline]
    pub(super) fn rate<S>(
        &mut self,
        state: &mut S,
        stage: &Stage<'_>,
        t: f64,
        motion: &Motion<N>,
    ) -> Vector<N>
    where
        C: Compensator<N, S>,
    {
        part::<N, _>(|| self.evaluate(state, stage, t, motion).1)
    }

    /// The loop and q̈ at a stage.
    #[inline(always)]
    pub(super) fn evaluate<S>(
        &mut self,
        state: &mut S,
        stage: &Stage<'_>,
        t: f64,
        motion: &Motion<N>,
    ) -> (Evaluation<N>, Vector<N>)
    where
        C: Compensator<N, S>,
    {
        let (arm, Motion { q, dq }) = (&self.plant.arm, motion);
        self.evaluate_by(state, stage, t, motion, |net| arm.forward_dynamics(q, dq, net))
    }

    /// The same with q̈ as `accelerate` makes it of the torque that acts, τ − τ_d.
    #[inline(always)]
    fn evaluate_by<S>(
        &mut self,
        state: &mut S,
        stage: &Stage<'_>,
        t: f64,
        motion: &Motion<N>,
        accelerate: impl FnOnce(&Vector<N>) -> Vector<N>,
    ) -> (Evaluation<N>, Vector<N>)
    where
        C: Compensator<N, S>,
    {
        let Driven { sample, command, applied, net } = self.drive(state, stage, t, motion);
        let ddq = accelerate(&net);
        let audit = self.controller.compensator.audit(state, stage.index, &sample);
        let evaluation = Evaluation::new(t, sample, command, applied, &ddq, audit);
        self.shares[stage.index] = Certificate::rates(&evaluation);
        (evaluation, ddq)
    }

    /// What drives the plant at a stage.
    #[inline(always)]
    fn drive<S>(
        &mut self,
        state: &mut S,
        stage: &Stage<'_>,
        t: f64,
        Motion { q, dq }: &Motion<N>,
    ) -> Driven<N>
    where
        C: Compensator<N, S>,
    {
        part::<N, _>(|| {
            let (setpoint, disturbance) = self.at_time(t);
            let sample = self.controller.sample(q, dq, &setpoint);
            let command = self.controller.decide(state, stage, &sample);
            let applied = self.plant.applied(&command.tau);
            let acted = command.applied(&applied);
            self.controller.compensator.acted(state, stage.index, &sample, &acted);
            let tau_d = disturbance.unwrap_or_else(|| self.plant.disturbance.torque(q, dq, t));
            Driven { sample, command, applied, net: applied - tau_d }
        })
    }

    /// Finishes a step of length `h` from `t` to `end` \[s\], by RK4 or with friction solved for.
    ///
    /// # Errors
    /// When the weights would not be finite.
    #[inline(always)]
    pub fn finish<S>(
        &mut self,
        state: &mut S,
        (t, h, end): (f64, f64, f64),
        motion: &Motion<N>,
        start: &Start<N>,
    ) -> Result<Moved<N>>
    where
        C: Compensator<N, S>,
    {
        let moved = self.attempt(state, (t, h, end), motion, start);
        self.advance(state, &RK4.end(h, 4))?;
        Ok(moved)
    }

    /// The stages of such a step; the compensator stays at its start.
    #[inline(always)]
    pub(super) fn attempt<S>(
        &mut self,
        state: &mut S,
        (t, h, end): (f64, f64, f64),
        motion: &Motion<N>,
        start: &Start<N>,
    ) -> Moved<N>
    where
        C: Compensator<N, S>,
    {
        if let Some((laws, free)) = &start.stiff {
            return self.attempt_braked(state, (t, h, end), motion, (laws, free));
        }
        self.last_braking = None;
        Moved::by_rk4(h, motion, &start.ddq, |stage, at| {
            self.rate(state, stage, time_of(stage, (t, h, end)), at)
        })
    }

    /// The same with friction solved for.
    #[inline(never)]
    fn attempt_braked<S>(
        &mut self,
        state: &mut S,
        times: (f64, f64, f64),
        motion: &Motion<N>,
        (laws, free): (&[Resistance; N], &Vector<N>),
    ) -> Moved<N>
    where
        C: Compensator<N, S>,
    {
        let (arm, h) = (&self.plant.arm, times.1);
        let (moved, last) = stiff::step(arm, laws, h, motion, free, |stage, at, posed, braking| {
            let mut free = Vector::zeros();
            let time = time_of(stage, times);
            let (evaluation, _) = self.evaluate_by(state, stage, time, at, |net| {
                free = posed.free(&(net - stiff::known(laws, &at.dq)));
                free + braking
            });
            self.pull(stage.index, &evaluation, braking);
            free
        });
        self.last_braking = Some(last);
        Moved { lost: moved.lost.or(self.lost), ..moved }
    }

    /// Moves the compensator to the end of the step.
    pub(super) fn advance<S>(&self, state: &mut S, end: &Stage<'_>) -> Result<()>
    where
        C: Compensator<N, S>,
    {
        self.controller.compensator.advance(state, end)
    }

    /// Makes the last stage of the step that was just taken the start of the next one, where q̈ =
    /// `ddq`. `None` if the start must be evaluated again.
    pub(super) fn carry<S>(
        &mut self,
        state: &mut S,
        last: usize,
        ddq: Vector<N>,
    ) -> Option<Start<N>>
    where
        C: Compensator<N, S>,
    {
        if self.laws.is_some() {
            return None;
        }
        let evaluation = self.evaluation.as_mut()?;
        let compensator = &self.controller.compensator;
        if !compensator.carry(state, last) {
            return None;
        }
        evaluation.audit = compensator.audit(state, 0, &evaluation.sample);
        self.shares[0] = self.shares[last];
        Some(Start { ddq, stiff: None })
    }

    /// Whether the latest set-point is NaN or infinite.
    pub(super) fn lost_reference(&self) -> bool {
        self.latest.is_some_and(|(_, Setpoint { q, dq, ddq }, _)| {
            [q, dq, ddq].iter().any(|x| x.iter().any(|v| !v.is_finite()))
        })
    }

    /// The set-point at time `t`, and the disturbance if it depends on the time alone.
    #[inline(always)]
    fn at_time(&mut self, t: f64) -> (Setpoint<N>, Option<Vector<N>>) {
        match self.latest {
            Some((time, setpoint, disturbance)) if time == t => (setpoint, disturbance),
            _ => {
                let (setpoint, disturbance) =
                    (self.reference.at(t), self.plant.disturbance.at_time(t));
                self.latest = Some((t, setpoint, disturbance));
                (setpoint, disturbance)
            }
        }
    }
}

/// The time of a stage in a step of `h` \[s\] from `t` to `end`; `end` to the bit at c = 1.
#[inline(always)]
pub(super) fn time_of(stage: &Stage<'_>, (t, h, end): (f64, f64, f64)) -> f64 {
    if stage.node == 1.0 { end } else { t + stage.node * h }
}

//! Plant, controller and reference as one system in continuous time, the paper's setting.

use super::certificate::Certificate;
use super::integrators::{Motion, RK4, Rates, Tableau};
use crate::arm::Arm;
use crate::control::{Audit, Command, Compensator, ComputedTorque, MAX_STAGES, Sample, Stage};
use crate::error::Result;
use crate::math::Vector;
use crate::plant::{Disturbance, Plant};
use crate::reference::{Reference, Setpoint};

/// All that is known of the loop at one stage.
#[derive(Clone, Copy, Debug)]
pub struct Evaluation<const N: usize> {
    /// Time [s].
    pub t: f64,
    /// Measurement, set-point and error.
    pub sample: Sample<N>,
    /// What the controller asked for.
    pub command: Command<N>,
    /// What the actuators gave [N·m].
    pub applied: Vector<N>,
    /// ρ = q̈ − v + ρ̂ [rad/s²], from the applied torque.
    pub rho: Vector<N>,
    /// The terms of the dissipation identity.
    pub audit: Option<Audit<N>>,
}

impl<const N: usize> Evaluation<N> {
    /// Completes a command with what the plant made of it.
    #[inline]
    pub(super) fn new(
        t: f64,
        sample: Sample<N>,
        command: Command<N>,
        applied: Vector<N>,
        ddq: &Vector<N>,
        audit: Option<Audit<N>>,
    ) -> Self {
        let rho = ddq - command.v + command.rho_hat;
        Self { t, sample, command, applied, rho, audit }
    }
}

/// The closed loop: the controller acts at every stage of the integrator.
pub struct ClosedLoop<'a, const N: usize, A, D, B, C, R> {
    plant: &'a Plant<N, A, D>,
    controller: &'a ComputedTorque<N, B, C>,
    reference: &'a R,
    /// Two stages often fall on one time: the set-point there, and the disturbance if it depends on the time alone.
    latest: Option<(f64, Setpoint<N>, Option<Vector<N>>)>,
    /// The loop at the stage remembered last, and the certificate's share of every stage.
    evaluation: Option<Evaluation<N>>,
    shares: [Certificate; MAX_STAGES],
}

impl<'a, const N: usize, A, D, B, C, R> ClosedLoop<'a, N, A, D, B, C, R>
where
    A: Arm<N>,
    D: Disturbance<N>,
    B: Arm<N>,
    R: Reference<N>,
{
    /// A loop of these three.
    pub fn new(
        plant: &'a Plant<N, A, D>,
        controller: &'a ComputedTorque<N, B, C>,
        reference: &'a R,
    ) -> Self {
        Self {
            plant,
            controller,
            reference,
            latest: None,
            evaluation: None,
            shares: [Certificate::default(); MAX_STAGES],
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
        let (evaluation, ddq) = self.evaluate(state, stage, t, motion);
        self.evaluation = Some(evaluation);
        ddq
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
        self.evaluate(state, stage, t, motion).1
    }

    /// The loop and q̈ at a stage. Inlined, as all that it calls on the way, so that a stage computes only what its caller
    /// uses, and its numbers stay in registers: returned through memory one by one, they could not be read soon as one.
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
        let (setpoint, disturbance) = self.at_time(t);
        let sample = self.controller.sample(&motion.q, &motion.dq, &setpoint);
        let command = self.controller.law(state, stage, &sample);
        let applied = self.plant.applied(&command.tau);
        if command.limited || applied != command.tau {
            self.controller.compensator.hold(state, stage.index);
        }
        let ddq = match &disturbance {
            Some(tau_d) => self.plant.acceleration_under(&motion.q, &motion.dq, &applied, tau_d),
            None => self.plant.acceleration(&motion.q, &motion.dq, &applied, t),
        };
        let audit = self.controller.compensator.audit(state, stage.index, &sample);
        let evaluation = Evaluation::new(t, sample, command, applied, &ddq, audit);
        self.shares[stage.index] = Certificate::rates(&evaluation);
        (evaluation, ddq)
    }

    /// One step of RK4 of length `h` from `t` to `end` [s], whose stage 0 is already in `rates`.
    ///
    /// # Errors
    /// When the weights would not be finite.
    pub fn finish_rk4<S>(
        &mut self,
        state: &mut S,
        (t, h, end): (f64, f64, f64),
        motion: &Motion<N>,
        rates: &mut Rates<N, 4>,
    ) -> Result<Motion<N>>
    where
        C: Compensator<N, S>,
    {
        RK4.stages(h, motion, 1, rates, |stage, at| {
            let time = if stage.node == 1.0 { end } else { t + stage.node * h };
            self.rate(state, stage, time, at)
        });
        self.advance(state, &RK4.end(h, 4))?;
        Ok(motion.plus(h, &RK4.weights, rates))
    }

    /// Moves the compensator to the end of the step.
    pub(super) fn advance<S>(&self, state: &mut S, end: &Stage<'_>) -> Result<()>
    where
        C: Compensator<N, S>,
    {
        self.controller.compensator.advance(state, end)
    }

    /// Makes the last stage of the step that was just taken, remembered, the first of the next; false if it must be
    /// evaluated again.
    pub(super) fn carry<S>(&mut self, state: &mut S, last: usize) -> bool
    where
        C: Compensator<N, S>,
    {
        let Some(evaluation) = &mut self.evaluation else { return false };
        let compensator = &self.controller.compensator;
        if !compensator.carry(state, last) {
            return false;
        }
        evaluation.audit = compensator.audit(state, 0, &evaluation.sample);
        self.shares[0] = self.shares[last];
        true
    }

    /// Adds the step that was just taken to the certificate.
    #[inline]
    pub(super) fn certify<const S: usize>(
        &self,
        tableau: &Tableau<S>,
        h: f64,
        certificate: &mut Certificate,
    ) {
        for (weight, share) in tableau.weights.iter().zip(&self.shares) {
            certificate.add(weight * h, share);
        }
    }

    /// Whether the set-point asked for last is no number.
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

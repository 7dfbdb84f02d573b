//! Sampled control: the controller steps once a period and its torque is held while the plant moves
//! on.

use core::ops::ControlFlow;

use super::adaptive::{attempt, attempt_stiff};
use super::doubt::Coarse;
use super::evaluation::Evaluation;
use super::integrators::{Motion, Tolerance};
use super::options::Method;
use super::recorder::Recorder;
use super::run::Run;
use super::status::Cause;
use super::stiff::{self, Moved, beyond_rk4, falling};
use crate::arm::{Arm, Posed, Resistance};
use crate::control::{Audit, Command, Compensator, Controller, Law, Sample, State};
use crate::error::Result;
use crate::math::Vector;
use crate::plant::{Disturbance, Plant};
use crate::reference::Reference;

/// The plant under a held torque: one step of length `h` \[s\] from time `t`, by RK4, or with
/// friction and stops solved for where RK4 would be unstable. The step has up to 64 parts where
/// viscous friction brakes a joint by more than a tenth within it, or where Stribeck friction falls
/// fast.
pub fn hold_torque<const N: usize, A: Arm<N>, D: Disturbance<N>>(
    plant: &Plant<N, A, D>,
    motion: &Motion<N>,
    tau: &Vector<N>,
    t: f64,
    h: f64,
) -> Motion<N> {
    let held = Held::new(plant, tau);
    held.step((motion, &held.acceleration(motion, t)), t, h).motion
}

/// By how much friction may brake a joint within a step that RK4 follows in one part, h b/m.
const MOST_FOLLOWED: f64 = 0.7;
/// The largest rate at which friction may fall, times the length of a part; and the most parts.
const MOST_FALL: f64 = 0.3;
const MOST_PARTS: f64 = 64.0;

/// The plant under a held torque.
struct Held<'a, const N: usize, A, D> {
    plant: &'a Plant<N, A, D>,
    applied: Vector<N>,
    /// What opposes the motion of the joints; `None` if nothing does.
    laws: Option<[Resistance; N]>,
}

impl<'a, const N: usize, A: Arm<N>, D: Disturbance<N>> Held<'a, N, A, D> {
    fn new(plant: &'a Plant<N, A, D>, tau: &Vector<N>) -> Self {
        let laws = plant.arm.resists().then(|| Resistance::of(&plant.arm));
        Self { plant, applied: plant.applied(tau), laws }
    }

    /// How a step of `h` \[s\] starts.
    #[inline(always)]
    fn start(&self, at: &Motion<N>, t: f64, h: f64) -> Started<'_, N> {
        match &self.laws {
            None => Started::Smooth(self.acceleration(at, t)),
            Some(laws) => {
                let posed = self.posed(at);
                self.start_posed(laws, &posed, beyond_rk4(&posed, laws, h), at, t)
            }
        }
    }

    /// The same, of an arm with friction or stops that is posed already, and known to be `stiff`.
    #[inline(always)]
    fn start_posed<'b>(
        &self,
        laws: &'b [Resistance; N],
        posed: &Posed<N>,
        stiff: bool,
        at: &Motion<N>,
        t: f64,
    ) -> Started<'b, N> {
        let net = self.net(at, t);
        if stiff {
            Started::Stiff(laws, posed.free(&net))
        } else {
            Started::Smooth(posed.acceleration(&self.plant.arm, (&at.q, &at.dq), &net))
        }
    }

    /// One step of length `h` \[s\] from time `t`, where q̈ is known, in parts where friction
    /// changes the velocity too much for one.
    #[inline(always)]
    fn step(&self, (motion, ddq): (&Motion<N>, &Vector<N>), t: f64, h: f64) -> Moved<N> {
        match &self.laws {
            None => self.part(Started::Smooth(*ddq), motion, t, h),
            Some(laws) => self.step_braked(laws, motion, t, h),
        }
    }

    /// The same where something opposes the motion of the joints.
    fn step_braked(&self, laws: &[Resistance; N], motion: &Motion<N>, t: f64, h: f64) -> Moved<N> {
        let posed = self.posed(motion);
        let mut stiff = beyond_rk4(&posed, laws, h);
        let (parts, lost) = parts(&posed, laws, stiff, h);
        let h = h / parts;
        if parts > 1.0 {
            stiff = stiff && beyond_rk4(&posed, laws, h);
        }
        let start = self.start_posed(laws, &posed, stiff, motion, t);
        let mut moved = self.part(start, motion, t, h);
        for k in 1..parts as usize {
            let (at, t) = (moved.motion, t + k as f64 * h);
            let next = self.part(self.start(&at, t, h), &at, t, h);
            let (error, lost) = (moved.error + next.error, moved.lost.or(next.lost));
            moved = Moved { error, lost, ..next };
        }
        Moved { lost: moved.lost.or(lost), ..moved }
    }

    /// A step of length `h` \[s\] from time `t` that starts like this.
    #[inline(always)]
    fn part(&self, start: Started<'_, N>, motion: &Motion<N>, t: f64, h: f64) -> Moved<N> {
        match start {
            Started::Stiff(laws, free) => self.step_stiff(motion, (laws, &free), t, h),
            Started::Smooth(ddq) => Moved::by_rk4(h, motion, &ddq, |stage, at| {
                self.acceleration(at, t + stage.node * h)
            }),
        }
    }

    #[inline(always)]
    fn step_stiff(
        &self,
        motion: &Motion<N>,
        (laws, free): (&[Resistance; N], &Vector<N>),
        t: f64,
        h: f64,
    ) -> Moved<N> {
        stiff::step(&self.plant.arm, laws, h, motion, free, |stage, at, posed, _| {
            posed.free(&self.net(at, t + stage.node * h))
        })
        .0
    }

    /// The motion at `end` \[s\], by steps under error control, the first of `h` \[s\]; `None` if
    /// none met the tolerance.
    fn glide(
        &self,
        start: &Motion<N>,
        (mut t, mut h, end): (f64, f64, f64),
        tolerance: Tolerance,
    ) -> Option<Motion<N>> {
        let (mut motion, mut rates) = (*start, [Motion::zeros(); 7]);
        while t < end {
            let step = match self.start(&motion, t, h) {
                Started::Stiff(laws, free) => {
                    attempt_stiff((t, h, end), &motion, tolerance, |h, _| {
                        self.step_stiff(&motion, (laws, &free), t, h)
                    })
                }
                Started::Smooth(ddq) => {
                    rates[0] = Motion { q: motion.dq, dq: ddq };
                    attempt((t, h, end), &motion, &mut rates, tolerance, |_, time, at| {
                        self.acceleration(at, time)
                    })
                }
            }?;
            (motion, t, h) = (step.motion, step.end, step.next_h);
        }
        Some(motion)
    }

    #[inline(always)]
    fn posed(&self, at: &Motion<N>) -> Posed<N> {
        Posed::of(&self.plant.arm, &at.q, &at.dq)
    }

    fn acceleration(&self, at: &Motion<N>, t: f64) -> Vector<N> {
        self.plant.acceleration(&at.q, &at.dq, &self.applied, t)
    }

    /// τ − τ_d [N·m].
    fn net(&self, at: &Motion<N>, t: f64) -> Vector<N> {
        self.applied - self.plant.disturbance.torque(&at.q, &at.dq, t)
    }
}

/// The start of a step under a held torque.
enum Started<'a, const N: usize> {
    /// q̈.
    Smooth(Vector<N>),
    /// What to solve for, and M⁻¹r without it.
    Stiff(&'a [Resistance; N], Vector<N>),
}

/// The number of parts for a step of `h` \[s\], `stiff` or not, and what even these cannot follow.
///
/// Under a torque that is held for the whole step, 1 − R stands where 1 − e^(−x) is right, x = h
/// b/m. A loop that cancels viscous friction adds up the difference. The number of parts keeps it
/// below 0.4 %; nearly all joints need one.
fn parts<const N: usize>(
    posed: &Posed<N>,
    laws: &[Resistance; N],
    stiff: bool,
    h: f64,
) -> (f64, Option<(usize, Coarse)>) {
    if laws.iter().all(|law| law.friction.viscous == 0.0 && law.friction.stribeck == 0.0) {
        return (1.0, None);
    }
    let inverse = posed.factor.inverse_diagonal();
    let braking = |i: usize| {
        let x = h * laws[i].friction.viscous * inverse[i];
        if stiff { (10.0 * x).min(10.0).min(32.0 / x) } else { x / MOST_FOLLOWED }
    };
    let falling = falling(posed, laws, h);
    let fall = falling.map_or(0.0, |(rate, _)| rate / MOST_FALL);
    let parts = libm::ceil((0..N).map(braking).fold(fall, f64::max)).clamp(1.0, MOST_PARTS);
    let lost = falling.filter(|(rate, _)| *rate > parts).map(|(_, joint)| (joint, Coarse::Falling));
    (parts, lost)
}

/// Plant, sampled controller and reference.
pub(super) struct Sampled<'a, const N: usize, A, D, L, C, R> {
    pub plant: &'a Plant<N, A, D>,
    pub controller: &'a Controller<N, L, C>,
    pub reference: &'a R,
    /// Rows in a control period.
    pub hold: usize,
    pub method: Method,
}

impl<const N: usize, A, D, L, C, R> Sampled<'_, N, A, D, L, C, R>
where
    A: Arm<N>,
    D: Disturbance<N>,
    L: Law<N>,
    R: Reference<N>,
{
    /// The loop that a user would write: step the controller, hold its torque.
    pub fn run<S>(
        &self,
        state: &mut State<N, S>,
        mut motion: Motion<N>,
        mut record: Recorder<N>,
        mut monitor: impl FnMut(f64) -> ControlFlow<()>,
    ) -> Run<N>
    where
        C: Compensator<N, S>,
    {
        let period = self.hold as f64 * record.dt;
        let mut now: Option<(Command<N>, Held<'_, N, A, D>)> = None;
        for k in 0..=record.steps {
            let t = record.time(k);
            let sample = self.controller.sample(&motion.q, &motion.dq, &self.reference.at(t));
            if k.is_multiple_of(self.hold) && k < record.steps || now.is_none() {
                let before = now.as_ref().map(|(_, held)| &held.applied);
                match self.decide(state, before, &sample, period) {
                    Ok(command) => now = Some((command, Held::new(self.plant, &command.tau))),
                    Err(error) => {
                        record.diverged(t, Cause::Rejected(error));
                        break;
                    }
                }
            }
            let Some((command, held)) = &now else { break };
            let ddq = held.acceleration(&motion, t);
            let audit = if record.takes(k) { self.audit(state) } else { None };
            let at = Evaluation::new(t, sample, *command, held.applied, &ddq, audit);
            if !record.check(&at) {
                break;
            }
            record.take(k, &at, |row| self.signals(state, row));
            if k == record.steps {
                break;
            }
            if monitor(t).is_break() {
                record.interrupted(t);
                break;
            }
            match self.hold(held, &mut record, (&motion, &ddq), k) {
                Some(next) => motion = next,
                None => {
                    record.diverged(t, Cause::StepTooShort);
                    break;
                }
            }
        }
        // What the last period did to the state is part of the run.
        let last = now.map(|(_, held)| held.applied);
        if let Err(error) = self.controller.end_period(state, last.as_ref()) {
            record.diverged(record.time(record.steps), Cause::Rejected(error));
        }
        record.finish()
    }

    /// Ends the period before with the torque that the actuators gave, and decides on the next.
    #[inline(always)]
    fn decide<S>(
        &self,
        state: &mut State<N, S>,
        applied: Option<&Vector<N>>,
        sample: &Sample<N>,
        period: f64,
    ) -> Result<Command<N>>
    where
        C: Compensator<N, S>,
    {
        if applied.is_some() {
            self.controller.end_period(state, applied)?;
        }
        let Sample { q, dq, desired, .. } = sample;
        self.controller.step(state, q, dq, desired, period)
    }

    /// The terms of the identity at the sample that was decided on last.
    #[inline(always)]
    fn audit<S>(&self, state: &State<N, S>) -> Option<Audit<N>>
    where
        C: Compensator<N, S>,
    {
        self.controller.compensator.audit(state.compensator(), 0, state.seen()?)
    }

    /// The compensator's own signals there.
    fn signals<S>(&self, state: &State<N, S>, row: &mut [f64])
    where
        C: Compensator<N, S>,
    {
        if let Some(seen) = state.seen() {
            self.controller.compensator.signals(state.compensator(), seen, row);
        }
    }

    /// The motion at row k + 1, from that at row k and q̈ there; `None` if the error control gave
    /// up.
    #[inline(always)]
    fn hold(
        &self,
        held: &Held<'_, N, A, D>,
        record: &mut Recorder<N>,
        (start, ddq): (&Motion<N>, &Vector<N>),
        k: usize,
    ) -> Option<Motion<N>> {
        let t = record.time(k);
        if let Method::Dp54(tolerance) = self.method {
            return held.glide(start, (t, record.dt, record.time(k + 1)), tolerance);
        }
        let moved = held.step((start, ddq), t, record.dt);
        record.resolve(t, start, &moved);
        Some(moved.motion)
    }
}

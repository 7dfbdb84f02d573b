//! The plant while a torque is held.

use super::adaptive::{attempt, attempt_stiff};
use super::doubt::Coarse;
use super::integrators::{Motion, Tolerance};
use super::options::Method;
use super::recorder::Recorder;
use super::stiff::{self, Moved, beyond_rk4, falling};
use crate::arm::{Arm, Posed, Resistance};
use crate::effects::Actuators;
use crate::math::{Real, Vector};
use crate::plant::{Disturbance, Plant};

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
    Held::new(plant, t, &plant.applied(tau)).step_from(motion, t, h)
}

/// By how much friction may brake a joint within a step that RK4 follows in one part, h b/m.
const MOST_FOLLOWED: f64 = 0.7;
/// The largest rate at which friction may fall, times the length of a part; and the most parts.
const MOST_FALL: f64 = 0.3;
const MOST_PARTS: f64 = 64.0;

/// The plant under a held torque.
pub(super) struct Held<'a, const N: usize, A, D> {
    plant: &'a Plant<N, A, D>,
    /// The arm that is there now.
    arm: &'a A,
    /// What arrives at the joints [N·m].
    pub applied: Vector<N>,
    /// Actuators that cog.
    cogging: Option<&'a Actuators<N>>,
    /// What opposes the motion of the joints; `None` if nothing does.
    laws: Option<[Resistance; N]>,
}

impl<'a, const N: usize, A: Arm<N>, D: Disturbance<N>> Held<'a, N, A, D> {
    /// The plant at time `t` \[s\] under a torque that arrives at its joints.
    pub fn new(plant: &'a Plant<N, A, D>, t: f64, applied: &Vector<N>) -> Self {
        let arm = plant.arm_at(t);
        let laws = arm.resists().then(|| Resistance::of(arm));
        Self { plant, arm, applied: *applied, cogging: None, laws }
    }

    /// The same with actuators that cog.
    pub fn cogging(self, actuators: &'a Actuators<N>) -> Self {
        Self { cogging: Some(actuators), ..self }
    }

    /// The motion `h` \[s\] after time `t`.
    pub fn step_from(&self, motion: &Motion<N>, t: f64, h: f64) -> Motion<N> {
        self.step((motion, &self.acceleration(motion, t)), t, h).motion
    }

    /// The motion at `end` \[s\], a step of `h` \[s\] after `t`, from that at `t` and q̈ there;
    /// `None` if the error control gave up.
    #[inline(always)]
    pub fn move_on(
        &self,
        method: Method,
        record: &mut Recorder<N>,
        (start, ddq): (&Motion<N>, &Vector<N>),
        (t, h, end): (f64, f64, f64),
    ) -> Option<Motion<N>> {
        if let Method::Dp54(tolerance) = method {
            return self.glide(start, (t, h, end), tolerance);
        }
        let moved = self.step((start, ddq), t, h);
        record.resolve(t, start, &moved);
        Some(moved.motion)
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
            Started::Smooth(posed.acceleration(self.arm, (&at.q, &at.dq), &net))
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
        stiff::step(self.arm, laws, h, motion, free, |stage, at, posed, _| {
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
        Posed::of(self.arm, &at.q, &at.dq)
    }

    /// q̈ [rad/s²].
    pub fn acceleration(&self, at: &Motion<N>, t: f64) -> Vector<N> {
        self.arm.forward_dynamics(&at.q, &at.dq, &self.net(at, t))
    }

    /// τ − τ_d [N·m].
    fn net(&self, at: &Motion<N>, t: f64) -> Vector<N> {
        let net = self.applied - self.plant.disturbance.torque(&at.q, &at.dq, t);
        match self.cogging {
            None => net,
            Some(actuators) => net - actuators.cogging_torque(&at.q),
        }
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

/// Of arms side by side whose steps are not stiff, with friction that brakes and falls like this:
/// NaN where there is to be more than one part, and 0 elsewhere.
#[inline(always)]
pub(super) fn in_one_part<const N: usize, T: Real>(
    inverse: &Vector<N, T>,
    (viscous, falls): (&[T; N], &[T; N]),
    h: f64,
) -> T {
    let mut more = inverse[0].like(0.0);
    let (one, lost) = (more.like(1.0), more.like(f64::NAN));
    for i in 0..N {
        let x = more.like(h) * viscous[i] * inverse[i];
        more = one.if_less(x / x.like(MOST_FOLLOWED), lost, more);
        let rate = x.like(h) * inverse[i] * falls[i];
        more = one.if_less(rate / x.like(MOST_FALL), lost, more);
    }
    more
}

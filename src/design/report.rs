//! The design report: what the chosen gains, Q, γ, basis and period will do, and whether to go
//! ahead.

use super::choices::Choices;
use super::course::Course;
use super::joint_design::{JointDesign, JointReport};
use super::learning::{Learning, shaking_signal, strongest};
use super::sampled_loop::{Integrators, SampledLoop};
use super::spectrum::{Spectrum, signal};
use super::{Finding, Subject};
use crate::arm::{Arm, JointLimits};
use crate::control::{Adaptation, ComputedTorque, Gains, Limits, Signal};
use crate::error::{Error, Result, at_most, not_empty, positive};
use crate::math::Vector;

/// A control period above this share of the longest stable one is warned of …
const WARN: f64 = 1.0 / 3.0;
/// … and above this one refused.
const REFUSE: f64 = 0.75;

/// Errors of computed torque alone count up to this \[rad\].
const MOST_ERROR: f64 = 1.0;

/// Poses over which the weakest stiffness is looked for without a path.
const POSES: usize = 32;

/// What a design is judged for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conditions<'a> {
    /// Period of the control loop \[s\].
    pub control_period: f64,
    /// Samples from measurement to torque.
    pub delay_samples: usize,
    /// Harmonics of ρ along the reference: amplitude [rad/s²] and frequency [rad/s]. `None`: ρ_d of
    /// the course where the plant is known, 1 rad/s² at 1 rad/s otherwise.
    pub disturbance: Option<&'a [(f64, f64)]>,
    /// Nominal over true inertia: 1 for a right model, 0.5 if the arm is twice as heavy as
    /// believed. With a course its arms count instead.
    pub inertia_ratio: f64,
}

impl Default for Conditions<'_> {
    /// 1 kHz without delay, right inertia.
    fn default() -> Self {
        Self { control_period: 1e-3, delay_samples: 0, disturbance: None, inertia_ratio: 1.0 }
    }
}

/// The report of a design.
#[derive(Clone, Debug, PartialEq)]
pub struct Report<const N: usize> {
    /// Joint by joint.
    pub joints: [JointReport; N],
    /// What is learnt along the path; `None` without a path or a compensator.
    pub learning: Option<Learning<N>>,
    /// What to know before going ahead; empty if there is nothing.
    pub findings: Vec<Finding>,
    /// What acts in a run and is not in the figures.
    pub left_out: Vec<&'static str>,
}

impl<const N: usize> Report<N> {
    /// Judges a controller under these conditions, along a course if its path is known.
    ///
    /// # Errors
    /// `control_period`, `delay_samples`, `disturbance`, `inertia_ratio`: out of range.
    pub fn new<A: Arm<N>>(
        law: &ComputedTorque<N, A>,
        limits: &Limits<N>,
        compensator: Option<&dyn Subject<N>>,
        course: Option<&Course<N>>,
        conditions: &Conditions<'_>,
    ) -> Result<Self> {
        let arm = ArmFacts::of(&law.arm, course, limits);
        Design { gains: &law.gains, limits, compensator, course, conditions, arm: &arm }.report()
    }

    /// Whether nothing speaks against going ahead, and all that may is known.
    pub fn sound(&self) -> bool {
        self.known() && !self.findings.iter().any(Finding::refuses)
    }

    /// Whether the loop could be judged: without a path it can not where the rules see where the
    /// arm is.
    pub fn known(&self) -> bool {
        !self.findings.contains(&Finding::NeedsPath)
    }
}

/// What the choices are held against, of the nominal arm.
pub struct ArmFacts<const N: usize> {
    /// The smallest M₀ⱼⱼ [kg·m²].
    mass: [f64; N],
    effort_limit: [f64; N],
    dry: bool,
}

impl<const N: usize> ArmFacts<N> {
    /// Along the course, or over poses spread over the ranges of the joints.
    pub fn of<A: Arm<N>>(arm: &A, course: Option<&Course<N>>, limits: &Limits<N>) -> Self {
        let mut mass = [f64::INFINITY; N];
        let mut weaken = |masses: &crate::math::Matrix<N>| {
            for (joint, least) in mass.iter_mut().enumerate() {
                *least = least.min(masses[(joint, joint)]);
            }
        };
        match course {
            Some(course) => course.points.iter().for_each(|point| weaken(&point.nominal.mass)),
            None => (0..POSES).for_each(|k| weaken(&arm.mass_matrix(&pose(arm, k)))),
        }
        let effort_limit = std::array::from_fn(|joint| {
            let known = course.map_or(f64::INFINITY, |course| course.effort_limit[joint]);
            arm.joint_stop(joint).1.effort.min(limits.effort_limit[joint]).min(known)
        });
        let dry = (0..N).any(|joint| !arm.joint_friction(joint).is_none());
        Self { mass, effort_limit, dry }
    }

    /// The choices of a controller of this arm.
    pub fn choices<'a>(
        &self,
        gains: &'a Gains<N>,
        compensator: Option<&'a dyn Subject<N>>,
        course: Option<&'a Course<N>>,
    ) -> Choices<'a, N> {
        let stiffness = std::array::from_fn(|joint| gains.kp[joint] * self.mass[joint]);
        let effort_limit = self.effort_limit;
        Choices { gains, compensator, stiffness, effort_limit, course, start: None }
    }
}

/// Pose `k` of those that fill the ranges evenly: each joint turns by another irrational share.
fn pose<const N: usize, A: Arm<N>>(arm: &A, k: usize) -> Vector<N> {
    let half_turn = core::f64::consts::PI;
    Vector::from_fn(|joint, _| {
        let JointLimits { lower, upper, .. } = arm.joint_stop(joint).1;
        let (lower, upper) = (lower.max(-half_turn), upper.min(half_turn));
        let share = (0.5 + k as f64 * crate::math::sqrt(2.0 + 3.0 * joint as f64)).fract();
        lower + share * (upper - lower)
    })
}

/// A design with all that is known of it.
struct Design<'a, const N: usize> {
    gains: &'a Gains<N>,
    limits: &'a Limits<N>,
    compensator: Option<&'a dyn Subject<N>>,
    course: Option<&'a Course<N>>,
    conditions: &'a Conditions<'a>,
    arm: &'a ArmFacts<N>,
}

impl<const N: usize> Design<'_, N> {
    fn report(&self) -> Result<Report<N>> {
        let Conditions { control_period, delay_samples, disturbance, inertia_ratio } =
            *self.conditions;
        positive("inertia_ratio", &[inertia_ratio])?;
        positive("control_period", &[control_period])?;
        at_most("delay_samples", delay_samples, super::MAX_DELAY)?;
        not_empty("disturbance", disturbance.map_or(1, <[_]>::len))?;
        let mut findings = Vec::new();
        let learning = match (self.compensator, self.course) {
            (Some(subject), Some(course)) => Some(Learning::new(subject, course, self.gains)?),
            _ => None,
        };
        let xi_squared = self.xi_squared(learning.as_ref())?;
        let mut joints = Vec::with_capacity(N);
        for n in 0..N {
            let design = self.joint(n, xi_squared.map(|it| it[n]), learning.as_ref());
            joints.push(design.report(&mut findings)?);
        }
        let Ok(mut joints) = <[JointReport; N]>::try_from(joints) else {
            return Err(Error::no_convergence("design report"));
        };
        if xi_squared.is_none() {
            findings.push(Finding::NeedsPath);
        }
        let weakest = slowest(&joints);
        if let Some(course) = self.course {
            let judged = self.judge_loop(course, learning.as_ref(), &mut joints, weakest)?;
            findings.extend(judged);
        }
        if !findings.iter().any(Finding::refuses) {
            for (n, report) in joints.iter().enumerate() {
                let judged = self.course.is_none() || n == weakest;
                findings.extend(self.of_sampling(n, report).filter(|_| judged));
                let design = self.joint(n, xi_squared.map(|it| it[n]), learning.as_ref());
                findings.extend(design.inert(report)?);
            }
        }
        let choices = self.arm.choices(self.gains, self.compensator, self.course);
        findings.extend(choices.weak());
        findings.extend(choices.findings()?);
        Ok(Report { joints, learning, findings, left_out: self.left_out() })
    }

    /// |ξ|² of each joint: the largest along the path, or at zero if the rules see the error alone;
    /// `None` if it cannot be known.
    fn xi_squared(&self, learning: Option<&Learning<N>>) -> Result<Option<[f64; N]>> {
        let Some(subject) = self.compensator else { return Ok(Some([0.0; N])) };
        if let Some(learning) = learning {
            let largest = |n: usize| learning.xi_squared.iter().map(|it| it[n]).fold(0.0, f64::max);
            return Ok(Some(std::array::from_fn(largest)));
        }
        let error_alone = |(signal, _): &(Signal, f64)| matches!(signal, Signal::E | Signal::De);
        if !subject.parameters().inputs.signals().iter().all(error_alone) {
            return Ok(None);
        }
        let products = subject.products(&[super::course::at_rest()])?;
        Ok(Some(std::array::from_fn(|n| super::subject::of_joint(&products, n)[(0, 0)])))
    }

    fn joint(
        &self,
        n: usize,
        xi_squared: Option<f64>,
        learning: Option<&Learning<N>>,
    ) -> JointDesign<'_, N> {
        let own = self.course.filter(|course| course.measured).map(|it| Spectrum::of(it, n));
        let harmonics = match (self.conditions.disturbance, own) {
            (Some(given), _) => given.to_vec(),
            (None, Some(spectrum)) => spectrum.harmonics,
            (None, None) => vec![(1.0, 1.0)],
        };
        JointDesign {
            joint: n,
            gains: self.gains,
            compensator: self.compensator,
            harmonics,
            xi_squared,
            inertia_ratio: self.course.map_or(self.conditions.inertia_ratio, |it| it.ratio(n)),
            control_period: self.conditions.control_period,
            delay: self.conditions.delay_samples,
            mass: self.arm.mass[n],
            learns: learning.and_then(|it| it.learns(n)),
        }
    }

    /// The loop of all joints along the path, in place of each joint by itself.
    fn judge_loop(
        &self,
        course: &Course<N>,
        learning: Option<&Learning<N>>,
        joints: &mut [JointReport; N],
        weakest: usize,
    ) -> Result<Option<Finding>> {
        let Conditions { control_period, delay_samples, disturbance, .. } = *self.conditions;
        let whole = |it: Option<&_>| SampledLoop::new(course, self.gains, it, delay_samples);
        let alone = whole(None)?;
        let guess = joints[weakest].max_period.max(1e-6);
        let alone_longest = alone.max_period(guess)?;
        let errors = alone.rms(control_period.min(WARN * alone_longest), alone_longest);
        let [on_path, strongest, shaken] = match self.compensator.zip(learning) {
            Some((subject, learning)) => {
                self.integrators(course, subject, learning, &errors)?.map(Some)
            }
            None => [const { None }; 3],
        };
        // Some loops need their compensator to be stable: the smaller radius is the certain one.
        let with = whole(on_path.as_ref())?;
        let shaking = whole(shaken.as_ref())?.radius(control_period)?;
        let radius = with.radius(control_period)?.min(shaking);
        let max_period = whole(strongest.as_ref())?.max_period(guess)?;
        let rms = [alone.rms(control_period, alone_longest), with.rms(control_period, max_period)];
        let measured = course.measured && disturbance.is_none();
        let lost = max_period == 0.0 && joints[weakest].max_period > 0.0;
        for (n, joint) in joints.iter_mut().enumerate() {
            (joint.sampled_radius, joint.max_period) = (radius, max_period);
            if measured {
                joint.rms = [rms[0][n], rms[1][n]];
            }
        }
        Ok(lost.then_some(Finding::Overwhelmed { joint: weakest }))
    }

    /// The compensator on the path, where its rules fire most at the `errors` (RMS) that computed
    /// torque alone has, and where the loop shakes.
    fn integrators(
        &self,
        course: &Course<N>,
        subject: &dyn Subject<N>,
        learning: &Learning<N>,
        errors: &[f64],
    ) -> Result<[Integrators<N>; 3]> {
        let adaptation = &subject.parameters().adaptation;
        let of = |xi_squared: &[[f64; N]], factor: f64, pull: f64| {
            let k_i = xi_squared.iter().map(|it| adaptation.integral_gains(it));
            let k_i = k_i.map(|it| it.map(|k_i| factor * k_i)).collect();
            Integrators { p: *subject.p(), k_i, leak_rate: adaptation.leak_rate + pull }
        };
        let on_path = &learning.xi_squared;
        let known = if course.measured { crate::math::sqrt(2.0) } else { 0.0 };
        let size = std::array::from_fn(|n| known * errors[n].min(MOST_ERROR));
        let strongest = strongest(subject, &course.samples(), (&size, self.gains), on_path)?;
        let least = adaptation.gain.iter().copied().fold(f64::INFINITY, f64::min);
        let signal = shaking_signal(subject, self.gains, on_path);
        let pull = least * adaptation.error_modification * signal;
        let shaken = of(&learning.shaken, self.drive(course)?, pull);
        Ok([of(on_path, 1.0, 0.0), of(&strongest, 1.0, 0.0), shaken])
    }

    /// What a dead zone leaves of the drive at the largest signal that there is to learn from.
    fn drive(&self, course: &Course<N>) -> Result<f64> {
        let Some(subject) = self.compensator.filter(|_| course.measured) else { return Ok(1.0) };
        let dead_zone = subject.parameters().adaptation.dead_zone;
        if dead_zone == 0.0 {
            return Ok(1.0);
        }
        let signal = signal(subject, self.gains, course)?;
        Ok((1.0 - dead_zone / signal).max(0.0))
    }

    /// What the control period is to the longest stable one.
    fn of_sampling(&self, joint: usize, report: &JointReport) -> Option<Finding> {
        let JointReport { sampled_radius: radius, max_period, .. } = *report;
        let share = self.conditions.control_period / max_period;
        if radius >= 1.0 {
            Some(Finding::Unstable { joint, radius, max_period })
        } else if share > REFUSE {
            Some(Finding::NoMargin { joint, share, max_period })
        } else {
            (share > WARN).then_some(Finding::SlowSampling { joint, share, max_period })
        }
    }

    fn left_out(&self) -> Vec<&'static str> {
        let mut left_out = Vec::new();
        let mut add = |acts: bool, words| {
            if acts {
                left_out.push(words)
            }
        };
        if let Some(subject) = self.compensator {
            let Adaptation { error_modification, projection_radius, dead_zone, .. } =
                subject.parameters().adaptation;
            add(dead_zone > 0.0, "dead_zone (it learns less: the error is larger)");
            add(error_modification > 0.0, "error_modification (it forgets: the error is larger)");
            add(projection_radius.is_finite(), "projection_radius (|W| may not reach its need)");
            add(subject.dictionary(&[]).is_some(), "what the dictionary merges and drops");
        }
        let Limits { effort_limit, effort_rate_limit } = self.limits;
        add(effort_limit.iter().any(|limit| limit.is_finite()), "effort_limit");
        add(effort_rate_limit.iter().any(|limit| limit.is_finite()), "effort_rate_limit");
        add(self.arm.dry, "dry friction, but as a part of what the model leaves out");
        left_out
    }
}

/// The joint whose longest stable period is the shortest.
fn slowest<const N: usize>(joints: &[JointReport; N]) -> usize {
    let shorter = |best: usize, n: usize| {
        if joints[n].max_period < joints[best].max_period { n } else { best }
    };
    (0..N).reduce(shorter).unwrap_or(0)
}

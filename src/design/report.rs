//! The design report: what the chosen gains, Q, γ, basis and period will do, and whether to go
//! ahead.

use super::choices::Choices;
use super::conditions::Conditions;
use super::course::Course;
use super::joint_design::{JointDesign, JointReport, WARN};
use super::learning::Learning;
use super::loops::Loops;
use super::spectrum::Spectrum;
use super::{Finding, Subject};
use crate::arm::{Arm, JointLimits};
use crate::control::{Adaptation, ComputedTorque, Gains, Limits, Signal};
use crate::error::{Error, Result, at_most, not_empty, positive};
use crate::math::Vector;

/// A control period above this share of the longest stable one is refused.
const REFUSE: f64 = 0.75;
/// Along a path the longest period is known to 2 %: closer to it there is no margin, and no more is
/// known.
const CLOSE: core::ops::RangeInclusive<f64> = REFUSE..=1.02;

/// An error (RMS) above this, a swing of 1 rad, is beyond a linear model \[rad\].
const MOST_RMS: f64 = core::f64::consts::FRAC_1_SQRT_2;

/// Poses over which the weakest stiffness and the largest gravity are looked for without a path.
const POSES: usize = 32;

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
    /// `control_period`, `delay_samples`, `velocity_filter`, `disturbance`, `inertia_ratio`: out of
    /// range.
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
        self.known() && !refused(&self.findings)
    }

    /// Whether the loop could be judged: without a path it can not where the rules see where the
    /// arm is, and with errors as wide as the arm by no linear model.
    pub fn known(&self) -> bool {
        !self.findings.iter().any(Finding::leaves_open)
    }

    /// What to do, in words.
    pub fn verdict(&self) -> &'static str {
        if refused(&self.findings) {
            "do not run this"
        } else if self.findings.contains(&Finding::NeedsPath) {
            "cannot tell without a path"
        } else if self.known() {
            "go ahead"
        } else {
            "cannot tell from a linear model"
        }
    }
}

/// What the choices are held against, of the nominal arm.
pub struct ArmFacts<const N: usize> {
    /// The smallest M₀ⱼⱼ [kg·m²].
    mass: [f64; N],
    effort_limit: [f64; N],
    dry: bool,
    /// Without a path: the joints that gravity overcomes in some pose.
    dropped: Vec<Finding>,
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
        let dropped = if course.is_some() { Vec::new() } else { dropped(arm, limits) };
        let effort_limit = std::array::from_fn(|joint| {
            let known = course.map_or(f64::INFINITY, |course| course.effort_limit[joint]);
            arm.joint_stop(joint).1.effort.min(limits.effort_limit[joint]).min(known)
        });
        let dry = (0..N).any(|joint| !arm.joint_friction(joint).is_none());
        Self { mass, effort_limit, dry, dropped }
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

/// Joints whose limit of the controller is below what gravity takes in some pose.
fn dropped<const N: usize, A: Arm<N>>(arm: &A, limits: &Limits<N>) -> Vec<Finding> {
    let gravity: Vec<_> = (0..POSES).map(|k| arm.gravity(&pose(arm, k))).collect();
    let weak = |joint: usize| {
        let need = gravity.iter().fold(0.0, |most: f64, it| most.max(it[joint].abs()));
        let (limit, taken_by) = (limits.effort_limit[joint], "gravity in some poses");
        let weak = Finding::WeakEffort { joint, sags: false, limit, need, taken_by };
        (need > limit).then_some(weak)
    };
    (0..N).filter_map(weak).collect()
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
        let Conditions {
            control_period,
            delay_samples,
            velocity_filter,
            disturbance,
            inertia_ratio,
        } = *self.conditions;
        positive("inertia_ratio", &[inertia_ratio])?;
        positive("control_period", &[control_period])?;
        at_most("delay_samples", delay_samples, super::MAX_DELAY)?;
        positive("velocity_filter", &[velocity_filter.unwrap_or(1.0)])?;
        not_empty("disturbance", disturbance.map_or(1, <[_]>::len))?;
        let mut findings = Vec::new();
        let learning = match (self.compensator, self.course) {
            (Some(subject), Some(course)) => Some(Learning::new(subject, course)?),
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
        findings.extend(xi_squared.is_none().then_some(Finding::NeedsPath));
        let weakest = slowest(&joints);
        if let Some(course) = self.course {
            let judged = self.judge_loop(course, learning.as_ref(), &mut joints, weakest)?;
            findings.extend(judged);
        }
        self.judge(&joints, weakest, xi_squared.as_ref(), learning.as_ref(), &mut findings)?;
        Ok(Report { joints, learning, findings, left_out: self.left_out() })
    }

    /// What speaks against these figures, and against what was chosen.
    fn judge(
        &self,
        joints: &[JointReport; N],
        weakest: usize,
        xi_squared: Option<&[f64; N]>,
        learning: Option<&Learning<N>>,
        findings: &mut Vec<Finding>,
    ) -> Result<()> {
        let settles = |findings: &[Finding]| !findings.iter().any(Finding::grows);
        if settles(findings) {
            let judged = |n: usize| self.course.is_none() || n == weakest;
            let sampled = joints.iter().enumerate().filter(|(n, _)| judged(*n));
            findings.extend(sampled.filter_map(|(n, report)| self.of_sampling(n, report)));
        }
        if settles(findings) {
            findings.extend(self.course.and_then(|course| beyond(course, joints)));
            for (n, report) in joints.iter().enumerate() {
                let design = self.joint(n, xi_squared.map(|it| it[n]), learning);
                findings.extend(design.inert(report)?);
            }
        }
        let choices = self.arm.choices(self.gains, self.compensator, self.course);
        findings.extend(choices.weak());
        findings.extend(&self.arm.dropped);
        findings.extend(choices.findings()?);
        Ok(())
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
            conditions: self.conditions,
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
        let Conditions { control_period: h, disturbance, .. } = *self.conditions;
        let guess = joints[weakest].max_period.max(1e-6);
        let compensator = self.compensator.zip(learning);
        let loops = Loops::new(course, self.gains, compensator, (self.conditions, guess))?;
        let (radius, max_period) = (loops.radius(h)?, loops.max_period()?);
        let rms = [loops.alone.rms(h, loops.alone_longest), loops.on_path.rms(h, max_period)];
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

    /// What the control period is to the longest stable one.
    fn of_sampling(&self, joint: usize, report: &JointReport) -> Option<Finding> {
        let JointReport { sampled_radius: radius, max_period, .. } = *report;
        let share = self.conditions.control_period / max_period;
        let close = self.course.is_some() && CLOSE.contains(&share);
        if radius >= 1.0 && !close {
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

fn refused(findings: &[Finding]) -> bool {
    findings.iter().any(Finding::refuses)
}

/// The joint that errs most, if that is too much for a linear model.
fn beyond<const N: usize>(course: &Course<N>, joints: &[JointReport; N]) -> Option<Finding> {
    let rms = |joint: &usize| joints[*joint].rms[1];
    let joint = (0..N).max_by(|a, b| rms(a).total_cmp(&rms(b)))?;
    let beyond = course.measured && joints[joint].max_period > 0.0 && rms(&joint) > MOST_RMS;
    beyond.then_some(Finding::Beyond { joint, rms: rms(&joint) })
}

/// The joint whose longest stable period is the shortest.
fn slowest<const N: usize>(joints: &[JointReport; N]) -> usize {
    let shorter = |best: usize, n: usize| {
        if joints[n].max_period < joints[best].max_period { n } else { best }
    };
    (0..N).reduce(shorter).unwrap_or(0)
}

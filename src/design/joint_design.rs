//! One joint of a design, by itself: its figures, and what speaks against them.

use super::{Conditions, Finding, LinearModel, Subject};
use crate::control::{Adaptation, Gains};
use crate::eigen::{Complex, modulus};
use crate::error::{Error, Problem, Result};
use crate::math::sqrt;
use crate::riccati::{JointSolution, joint_gamma_opt, joint_max_scale};

/// A compensator that removes less of the error than this is called inert.
const INERT: f64 = 0.05;

/// What a compensator should remove; the gain for it is suggested to an inert one.
const USEFUL: f64 = 0.9;

/// The longest stable period under a suggested gain, in control periods.
const ROOM: f64 = 3.0;

/// |ξ|² below this is no rule that fires.
const SILENT: f64 = 1e-12;

/// A control period above this share of the longest stable one is warned of.
pub(super) const WARN: f64 = 1.0 / 3.0;

/// Q closer than this to the largest admissible one is warned of.
const Q_MARGIN: f64 = 1.1;

/// A damping ratio below this rings.
const RINGING: f64 = 0.1;

/// Doublings in the search for a useful gain.
const DOUBLINGS: usize = 60;

/// An error this small needs no compensator \[rad\].
const NOTHING: f64 = 1e-12;

/// The figures of one joint. What cannot be known without a path is NaN, and so is what only a
/// compensator has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointReport {
    /// P of (19).
    pub p: JointSolution,
    /// Smallest eigenvalue of P.
    pub min_eigenvalue: f64,
    /// Largest real part of A + γ⁻²BBᵀP [1/s].
    pub max_real: f64,
    /// γ must be larger than this for (19) to have a solution.
    pub gamma_opt: f64,
    /// Q may be multiplied by less than this.
    pub max_scale: f64,
    /// k_I = gain |ξ|² / (1 + ν |ξ|²), the integral action; along a path the largest.
    pub k_i: f64,
    /// Poles of the linear model [1/s]; without a velocity filter the last one is at −∞.
    pub poles: [Complex; 4],
    /// Nominal over true inertia: the mean of a path.
    pub inertia_ratio: f64,
    /// Predicted steady RMS error \[rad\], without and with the compensator.
    pub rms: [f64; 2],
    /// Spectral radius of the sampled loop; it is stable below 1. Along a path, the growth per
    /// sample of the loop of all joints, the smallest at any size of its motion: at 1 and above it
    /// is unstable on the path, shaking, and where the error is wide.
    pub sampled_radius: f64,
    /// Longest period at which the sampled loop is stable \[s\], 0 if it never is. Along a path,
    /// that of the loop of all joints: on the path, where the error is as wide as computed torque
    /// alone has it, and without the compensator, if it is stable then at any period.
    pub max_period: f64,
    /// k_p M₀ⱼⱼ, what holds the joint against a slow push [N·m/rad]: the smallest along the path,
    /// or over 32 poses without one.
    pub stiffness: f64,
    /// k_v M₀ⱼⱼ [N·m·s/rad], likewise.
    pub damping: f64,
}

/// One joint of a design.
pub(super) struct JointDesign<'a, const N: usize> {
    pub joint: usize,
    pub gains: &'a Gains<N>,
    pub compensator: Option<&'a dyn Subject<N>>,
    /// ρ_d: amplitudes [rad/s²] and frequencies [rad/s].
    pub harmonics: Vec<(f64, f64)>,
    /// |ξ|², the largest along the path; `None` if it cannot be known, 0 without a compensator.
    pub xi_squared: Option<f64>,
    pub inertia_ratio: f64,
    pub conditions: &'a Conditions<'a>,
    /// The smallest M₀ⱼⱼ [kg·m²].
    pub mass: f64,
    /// Directions of ξ along the path, if the rules can learn there what the model leaves out.
    pub learns: Option<usize>,
}

impl<const N: usize> JointDesign<'_, N> {
    fn model(&self, k_i: f64) -> LinearModel {
        let n = self.joint;
        let p = self.compensator.map_or(JointSolution::default(), |it| it.p()[n]);
        LinearModel {
            kp: self.gains.kp[n],
            kv: self.gains.kv[n],
            p12: p.p12,
            p22: p.p22,
            k_i,
            leak_rate: self.adaptation().leak_rate,
            inertia_ratio: self.inertia_ratio,
            velocity_filter: self.conditions.velocity_filter,
        }
    }

    fn adaptation(&self) -> Adaptation<N> {
        self.compensator.map_or_else(Adaptation::default, |it| it.parameters().adaptation)
    }

    /// k_I of the compensator with this gain.
    fn k_i(&self, gain: f64) -> Option<f64> {
        let (nu, xi_squared) = (self.adaptation().normalization, self.xi_squared?);
        Some(gain * xi_squared / (1.0 + nu * xi_squared))
    }

    /// The figures, as far as they are known, and what is found in them.
    pub fn report(&self, findings: &mut Vec<Finding>) -> Result<JointReport> {
        let k_i = self.k_i(self.adaptation().gain[self.joint]);
        let mut report = JointReport {
            stiffness: self.gains.kp[self.joint] * self.mass,
            damping: self.gains.kv[self.joint] * self.mass,
            inertia_ratio: self.inertia_ratio,
            ..UNKNOWN
        };
        report.rms[0] = self.rms(0.0)?;
        if let Some(subject) = self.compensator {
            self.riccati(subject, &mut report, findings)?;
        }
        if let Some(k_i) = k_i {
            self.closed(k_i, &mut report, findings)?;
        }
        Ok(report)
    }

    /// P and its margins.
    fn riccati(
        &self,
        subject: &dyn Subject<N>,
        report: &mut JointReport,
        findings: &mut Vec<Finding>,
    ) -> Result<()> {
        let (joint, parameters) = (self.joint, subject.parameters());
        let LinearModel { kp, kv, .. } = self.model(0.0);
        let (q1, q2) = (parameters.q_position[joint], parameters.q_velocity[joint]);
        let (gamma, p) = (parameters.gamma, subject.p()[joint]);
        report.p = p;
        report.min_eigenvalue = p.min_eigenvalue();
        report.max_real = p.max_real(kp, kv, 1.0 / (gamma * gamma));
        report.gamma_opt = joint_gamma_opt(kp, kv, q1, q2)?;
        report.max_scale = joint_max_scale(kp, kv, q1, q2, gamma)?;
        if report.max_scale < Q_MARGIN {
            findings.push(Finding::NarrowMargin { joint, max_scale: report.max_scale });
        }
        Ok(())
    }

    /// The closed loop with an integrator of this gain.
    fn closed(
        &self,
        k_i: f64,
        report: &mut JointReport,
        findings: &mut Vec<Finding>,
    ) -> Result<()> {
        let (joint, model) = (self.joint, self.model(k_i));
        let Conditions { control_period, delay_samples, velocity_filter, .. } = *self.conditions;
        let closed = Closed::new(&model, delay_samples)?;
        report.k_i = k_i;
        report.poles = closed.poles;
        report.rms[1] = self.rms(k_i)?;
        report.sampled_radius = model.sampled_radius(control_period, delay_samples)?;
        report.max_period = closed.max_period;
        if closed.diverges() {
            findings.push(Finding::Divergent { joint, max_real: closed.max_real });
        } else if closed.damping < RINGING {
            findings.push(Finding::Ringing { joint, damping: closed.damping });
        }
        if let Some(cut_off) = velocity_filter.filter(|_| closed.is_troubled(control_period)) {
            let without = LinearModel { velocity_filter: None, ..model };
            if !Closed::new(&without, delay_samples)?.is_troubled(control_period) {
                findings.push(Finding::SlowFilter { joint, cut_off });
            }
        }
        Ok(())
    }

    /// RMS over all harmonics.
    fn rms(&self, k_i: f64) -> Result<f64> {
        let model = self.model(k_i);
        let mut sum = 0.0;
        for &(amplitude, omega) in &self.harmonics {
            let rms = model.steady_rms(amplitude, omega)?;
            sum += rms * rms;
        }
        Ok(sqrt(sum))
    }

    /// What is found where the compensator removes less than 5 % of the error.
    pub fn inert(&self, report: &JointReport) -> Result<Option<Finding>> {
        let (joint, JointReport { k_i, rms: [without, with], .. }) = (self.joint, *report);
        let (Some(_), Some(xi_squared)) = (self.compensator, self.xi_squared) else {
            return Ok(None);
        };
        if xi_squared < SILENT {
            return Ok(Some(Finding::Silent { joint }));
        }
        let removes = 1.0 - with / without;
        if without < NOTHING || removes >= INERT || removes.is_nan() {
            return Ok(None);
        }
        let suggested_gain = self.useful_gain(self.rms(0.0)?)?;
        // ρ̂' = k_I p12 e with e = (ρ − ρ̂)/k_p, while ρ changes slowly; |ξ|² is shared among the
        // directions.
        let one = self.gains.kp[joint] / (k_i * report.p.p12);
        let learns_in = self.learns.map(|directions| directions as f64 * one);
        Ok(Some(Finding::Inert { joint, k_i, removes, suggested_gain, learns_in }))
    }

    /// The gain that removes 90 % of the error, by doubling and halving, if the control period
    /// allows it.
    fn useful_gain(&self, without: f64) -> Result<Option<f64>> {
        let enough = |gain: f64| {
            let k_i = self.k_i(gain).unwrap_or(0.0);
            Ok::<_, Error>(self.rms(k_i)? <= (1.0 - USEFUL) * without)
        };
        let mut high = 1.0;
        for _ in 0..DOUBLINGS {
            if enough(high)? {
                break;
            }
            high *= 2.0;
        }
        let mut low = 0.0;
        for _ in 0..DOUBLINGS {
            let middle = 0.5 * (low + high);
            if enough(middle)? { high = middle } else { low = middle }
        }
        let Conditions { control_period, delay_samples, .. } = *self.conditions;
        let longest = self.model(self.k_i(high).unwrap_or(0.0)).max_period(delay_samples);
        let roomy = longest.is_ok_and(|longest| longest >= ROOM * control_period);
        Ok((roomy && enough(high)?).then_some(high))
    }
}

/// What is known of a closed loop.
struct Closed {
    poles: [Complex; 4],
    /// The largest real part of them [1/s].
    max_real: f64,
    /// The smallest damping ratio of an oscillation, 1 if there is none.
    damping: f64,
    /// The longest stable period \[s\]; 0 if there is none.
    max_period: f64,
}

impl Closed {
    fn new(model: &LinearModel, delay_samples: usize) -> Result<Self> {
        let poles = model.poles()?;
        let max_period = match model.max_period(delay_samples) {
            Err(error) if matches!(error.problem(), Problem::NotHurwitz { .. }) => 0.0,
            other => other?,
        };
        let max_real = poles.iter().map(|z| z.re).fold(f64::NEG_INFINITY, f64::max);
        // Of the loop, not of the leak or an integrator at rest.
        let moving = poles.iter().filter(|z| z.im != 0.0);
        let damping = moving.map(|z| -z.re / modulus(*z)).fold(1.0, f64::min);
        Ok(Self { poles, max_real, damping, max_period })
    }

    /// Whether it is unstable in continuous time.
    fn diverges(&self) -> bool {
        self.max_real > 0.0 && self.max_period == 0.0
    }

    /// Whether there is something to say against it at this period.
    fn is_troubled(&self, control_period: f64) -> bool {
        self.damping < RINGING || control_period > WARN * self.max_period
    }
}

const NONE: Complex = Complex::new(f64::NAN, f64::NAN);

/// Nothing is known yet.
const UNKNOWN: JointReport = JointReport {
    p: JointSolution { p11: f64::NAN, p12: f64::NAN, p22: f64::NAN },
    min_eigenvalue: f64::NAN,
    max_real: f64::NAN,
    gamma_opt: f64::NAN,
    max_scale: f64::NAN,
    k_i: f64::NAN,
    poles: [NONE; 4],
    inertia_ratio: f64::NAN,
    rms: [f64::NAN; 2],
    sampled_radius: f64::NAN,
    max_period: f64::NAN,
    stiffness: f64::NAN,
    damping: f64::NAN,
};

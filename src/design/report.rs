//! The design report: what the chosen gains, Q, γ, basis and period will do, and whether to go
//! ahead.

use core::fmt;

use super::{LinearModel, Subject};
use crate::control::Gains;
use crate::eigen::{Complex, modulus};
use crate::error::{Error, Problem, Result, not_empty, positive};
use crate::math::{exp, sqrt};
use crate::riccati::{JointSolution, joint_gamma_opt, joint_max_scale};

/// A compensator that removes less of the error than this is called inert.
const INERT: f64 = 0.05;

/// What a compensator should remove; the gain for it is suggested to an inert one.
const USEFUL: f64 = 0.9;

/// Sampling that keeps less than this share of the continuous loop's damping is warned of.
const KEPT_DAMPING: f64 = 0.5;

/// Q closer than this to the largest admissible one is warned of.
const Q_MARGIN: f64 = 1.1;

/// A damping ratio below this rings.
const RINGING: f64 = 0.1;

/// Doublings in the search for a useful gain.
const DOUBLINGS: usize = 60;

/// What a design is judged for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conditions<'a> {
    /// Period of the control loop \[s\].
    pub period: f64,
    /// Samples from measurement to torque.
    pub delay_samples: usize,
    /// Harmonics of ρ along the reference: amplitude [rad/s²] and frequency [rad/s].
    pub disturbance: &'a [(f64, f64)],
    /// Nominal over true inertia: 1 for a right model, 0.5 if the arm is twice as heavy as
    /// believed.
    pub inertia_ratio: f64,
}

impl Default for Conditions<'_> {
    /// 1 kHz without delay, 1 rad/s² at 1 rad/s, right inertia.
    fn default() -> Self {
        Self { period: 1e-3, delay_samples: 0, disturbance: &[(1.0, 1.0)], inertia_ratio: 1.0 }
    }
}

/// The figures of one joint.
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
    /// k_I = gain |ξ(0)|², the integral action while the inputs stay near zero.
    pub k_i: f64,
    /// Poles of the linear model [1/s].
    pub poles: [Complex; 3],
    /// Predicted steady RMS error \[rad\], without and with the compensator.
    pub rms: [f64; 2],
    /// Spectral radius of the sampled loop; it is stable below 1.
    pub sampled_radius: f64,
    /// Longest period at which the sampled loop is stable \[s\].
    pub max_period: f64,
}

/// Something to know before going ahead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Finding {
    /// The compensator hardly changes the error.
    Inert {
        /// Joint, from 0.
        joint: usize,
        /// Its integral action.
        k_i: f64,
        /// Share of the error it removes.
        removes: f64,
        /// A gain that removes 90 %, if one was found.
        suggested_gain: Option<f64>,
    },
    /// The sampled loop is unstable.
    Unstable {
        /// Joint, from 0.
        joint: usize,
        /// Its spectral radius.
        radius: f64,
        /// Longest stable period \[s\].
        max_period: f64,
    },
    /// Sampling costs much of the damping.
    SlowSampling {
        /// Joint, from 0.
        joint: usize,
        /// Its spectral radius.
        radius: f64,
        /// Longest stable period \[s\].
        max_period: f64,
    },
    /// The loop rings.
    Ringing {
        /// Joint, from 0.
        joint: usize,
        /// Damping ratio of its slowest-dying oscillation.
        damping: f64,
    },
    /// The continuous loop is unstable for this inertia ratio.
    Divergent {
        /// Joint, from 0.
        joint: usize,
        /// Largest real part of its poles [1/s].
        max_real: f64,
    },
    /// Q is close to the largest one with a solution.
    NarrowMargin {
        /// Joint, from 0.
        joint: usize,
        /// What Q may be multiplied by.
        max_scale: f64,
    },
}

impl Finding {
    /// Whether one should not go ahead.
    pub fn refuses(&self) -> bool {
        matches!(self, Self::Unstable { .. } | Self::Divergent { .. })
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Inert { joint, k_i, removes, suggested_gain } => {
                let (number, percent) = (joint + 1, 100.0 * removes);
                write!(
                    f,
                    "joint {number}: the compensator is inert: with k_I = {k_i:.3} it removes \
                     {percent:.1} % of \
                     the error"
                )?;
                match suggested_gain {
                    Some(gain) => write!(f, "; a gain of about {gain:.3} removes 90 %"),
                    None => {
                        f.write_str("; no gain removes 90 % of an error this fast: raise kp and kv")
                    }
                }
            }
            Self::Unstable { joint, radius, max_period } => write!(
                f,
                "joint {}: the loop is too slow, it will be unstable (spectral radius \
                 {radius:.4}): sample faster \
                 than every {:.3} ms, or lower the gain",
                joint + 1,
                1e3 * max_period
            ),
            Self::SlowSampling { joint, radius, max_period } => write!(
                f,
                "joint {}: sampling takes most of the damping (spectral radius {radius:.4}); the \
                 limit is {:.3} ms, \
                 stay below a third of it",
                joint + 1,
                1e3 * max_period
            ),
            Self::Ringing { joint, damping } => write!(
                f,
                "joint {}: the loop will ring (damping ratio {damping:.3}): raise kv or lower the \
                 gain",
                joint + 1
            ),
            Self::Divergent { joint, max_real } => write!(
                f,
                "joint {}: unstable even in continuous time (a pole at +{max_real:.3} 1/s): lower \
                 the gain",
                joint + 1
            ),
            Self::NarrowMargin { joint, max_scale } => write!(
                f,
                "joint {}: Q is close to the largest that has a solution ({max_scale:.4} times \
                 this one): lower Q \
                 or raise gamma",
                joint + 1
            ),
        }
    }
}

/// The report of a design.
#[derive(Clone, Debug, PartialEq)]
pub struct Report<const N: usize> {
    /// Joint by joint.
    pub joints: [JointReport; N],
    /// What to know before going ahead; empty if there is nothing.
    pub findings: Vec<Finding>,
}

impl<const N: usize> Report<N> {
    /// Judges a compensator for these feedback gains under these conditions.
    ///
    /// # Errors
    /// `period`, `delay_samples`, `disturbance`, `inertia_ratio`: out of range.
    pub fn new(
        gains: &Gains<N>,
        compensator: &dyn Subject<N>,
        conditions: &Conditions<'_>,
    ) -> Result<Self> {
        positive("inertia_ratio", &[conditions.inertia_ratio])?;
        positive("period", &[conditions.period])?;
        not_empty("disturbance", conditions.disturbance.len())?;
        let xi_squared = compensator.xi_squared_at_zero()?;
        let mut findings = Vec::new();
        let mut joints = Vec::with_capacity(N);
        for n in 0..N {
            let gain = compensator.parameters().adaptation.gain[n];
            let design = Design { joint: n, gains, compensator, conditions };
            joints.push(design.report(gain, xi_squared[n], &mut findings)?);
        }
        match joints.try_into() {
            Ok(joints) => Ok(Self { joints, findings }),
            Err(_) => Err(Error::no_convergence("design report")),
        }
    }

    /// Whether nothing speaks against going ahead.
    pub fn sound(&self) -> bool {
        !self.findings.iter().any(Finding::refuses)
    }
}

/// One joint of a design.
struct Design<'a, const N: usize> {
    joint: usize,
    gains: &'a Gains<N>,
    compensator: &'a dyn Subject<N>,
    conditions: &'a Conditions<'a>,
}

impl<const N: usize> Design<'_, N> {
    fn model(&self, k_i: f64) -> LinearModel {
        let (kp, kv) = (self.gains.kp[self.joint], self.gains.kv[self.joint]);
        let JointSolution { p12, p22, .. } = self.compensator.p()[self.joint];
        LinearModel { kp, kv, p12, p22, k_i, inertia_ratio: self.conditions.inertia_ratio }
    }

    fn report(
        &self,
        gain: f64,
        xi_squared: f64,
        findings: &mut Vec<Finding>,
    ) -> Result<JointReport> {
        let LinearModel { kp, kv, .. } = self.model(0.0);
        let parameters = self.compensator.parameters();
        let (q1, q2) = (parameters.q_position[self.joint], parameters.q_velocity[self.joint]);
        let gamma = parameters.gamma;
        let p = self.compensator.p()[self.joint];
        let k_i = gain * xi_squared;
        let model = self.model(k_i);
        let Conditions { period, delay_samples, .. } = *self.conditions;
        let report = JointReport {
            p,
            min_eigenvalue: p.min_eigenvalue(),
            max_real: p.max_real(kp, kv, 1.0 / (gamma * gamma)),
            gamma_opt: joint_gamma_opt(kp, kv, q1, q2)?,
            max_scale: joint_max_scale(kp, kv, q1, q2, gamma)?,
            k_i,
            poles: model.poles()?,
            rms: [self.rms(0.0)?, self.rms(k_i)?],
            sampled_radius: model.sampled_radius(period, delay_samples)?,
            max_period: match model.max_period(delay_samples) {
                Err(error) if matches!(error.problem(), Problem::NotHurwitz { .. }) => 0.0,
                other => other?,
            },
        };
        self.judge(&report, xi_squared, findings)?;
        Ok(report)
    }

    /// RMS over all harmonics.
    fn rms(&self, k_i: f64) -> Result<f64> {
        let model = self.model(k_i);
        let mut sum = 0.0;
        for &(amplitude, omega) in self.conditions.disturbance {
            let rms = model.steady_rms(amplitude, omega)?;
            sum += rms * rms;
        }
        Ok(sqrt(sum))
    }

    fn judge(
        &self,
        report: &JointReport,
        xi_squared: f64,
        findings: &mut Vec<Finding>,
    ) -> Result<()> {
        let JointReport { k_i, poles, rms, sampled_radius: radius, max_period, max_scale, .. } =
            *report;
        let joint = self.joint;
        let max_real = poles.iter().map(|z| z.re).fold(f64::NEG_INFINITY, f64::max);
        if max_real > 0.0 {
            findings.push(Finding::Divergent { joint, max_real });
            return Ok(());
        }
        let removes = 1.0 - rms[1] / rms[0].max(f64::MIN_POSITIVE);
        if rms[0] > 0.0 && removes < INERT {
            let suggested_gain = self.useful_gain(rms[0], xi_squared)?;
            findings.push(Finding::Inert { joint, k_i, removes, suggested_gain });
        }
        // In a sample the slowest pole decays by e^(Re h); sampling should leave most of that. (A
        // fixed bound on the radius would warn of every fast loop: computed torque alone has 0.9979
        // at 1 kHz.)
        let expected = exp(KEPT_DAMPING * max_real * self.conditions.period);
        if radius >= 1.0 {
            findings.push(Finding::Unstable { joint, radius, max_period });
        } else if radius > expected {
            findings.push(Finding::SlowSampling { joint, radius, max_period });
        }
        let damping = poles.iter().map(|z| -z.re / modulus(*z)).fold(1.0, f64::min);
        if damping < RINGING {
            findings.push(Finding::Ringing { joint, damping });
        }
        if max_scale < Q_MARGIN {
            findings.push(Finding::NarrowMargin { joint, max_scale });
        }
        Ok(())
    }

    /// The gain that removes 90 % of the error, by doubling and halving.
    fn useful_gain(&self, without: f64, xi_squared: f64) -> Result<Option<f64>> {
        let enough = |k_i: f64| Ok::<_, Error>(self.rms(k_i)? <= (1.0 - USEFUL) * without);
        let mut high = 1.0;
        for _ in 0..DOUBLINGS {
            if enough(high)? {
                let mut low = 0.0;
                for _ in 0..DOUBLINGS {
                    let middle = 0.5 * (low + high);
                    if enough(middle)? { high = middle } else { low = middle }
                }
                return Ok(Some(high / xi_squared));
            }
            high *= 2.0;
        }
        Ok(None)
    }
}

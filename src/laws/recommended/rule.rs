//! All gains of the recommended controller from what is known of arm, loop and sensors.
//!
//! ```text
//! T_d = (½ + d) h + 1/(2πf) + 1/(2πf₂)        p(f₂) = min(.35/(3T_d), 40 rad/s)
//! ```
//!
//! Joint by joint, f₂ is the cut-off in 20 … 2000 Hz with the largest p for which the noise of the
//! encoder is at most .5 % of the joint's torque, and 20 Hz where it is more for all. Then p is
//! lowered until the sampled loop is stable enough for the lightest and the heaviest arm that is
//! declared, at 24 poses, and what is learnt converges there.

use core::f64::consts::TAU;

use super::gains::{LearningGains, QUICKEST};
use super::learning::filter;
use super::pull::Pull;
use super::{condition, frozen_loop};
use crate::arm::Parametric;
use crate::control::MAX_DELAY;
use crate::error::{Error, Result, accepted, finite, non_negative, positive, within};
use crate::laws::bandwidth::{poses_within, ranges};
use crate::math::{Matrix, Vector, exp, ln, sqrt};

/// Phase that the lags of the loop may take at 3p, where it crosses over \[rad\].
const LAG: f64 = 0.35;
/// No p is larger [rad/s].
const FASTEST: f64 = 40.0;
/// Cut-offs of the second velocity filter \[Hz\], and how many are tried.
const CUT_OFFS: [f64; 2] = [20.0, 2000.0];
const TRIED: usize = 61;
/// Share of a joint's largest torque that its noise may be.
const NOISE: f64 = 0.005;
/// Share of the torque that gravity leaves, with which a joint brakes; and what of its largest
/// torque it leaves at the least.
const BRAKING: f64 = 0.25;
const LEFT: f64 = 0.1;
/// No p may be slower where gravity pulls [rad/s]: arms swung at 4 and 7, and did not at 11.
const HOLDS: f64 = 8.0;
/// What a row's unit moves a joint by, at the most \[rad\].
const MOVED: f64 = 0.5;
/// The loop's slowest root is left of this share of the smallest p.
const MARGIN: f64 = 0.05;
/// p is lowered by this factor, so often at the most.
const SLOWER: f64 = 0.9;
const ROUNDS: usize = 40;
/// The filter of learning as a share of the smallest p, both in rad/s.
const LEARNING: f64 = 0.2;
/// What c is chosen from.
const SHARES: [f64; 4] = [1.0, 1.25, 1.5, 2.0];
/// The condition of learning: wanted, and the most that is accepted.
const SURE: f64 = 0.5;
const MOST: f64 = 1.0;

/// What the rule is told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Circumstances<const N: usize> {
    /// Period of the loop \[s\].
    pub control_period: f64,
    /// Samples between a torque and the period in which it acts, at most [`MAX_DELAY`].
    pub delay: usize,
    /// Standard deviation of a measured position \[rad\].
    pub noise: [f64; N],
    /// Cut-off of the velocity filter in front \[Hz\].
    pub velocity_filter: f64,
    /// Largest torque of each joint [N·m].
    pub effort_limit: [f64; N],
    /// The heaviest load at the tip \[kg\].
    pub payload: f64,
    /// Bounds of the arm's inertia as multiples of what is believed.
    pub inertia_range: [f64; 2],
    /// Whether joints may be so light for their torque that a rotor seems to be missing.
    pub light_joints: bool,
    /// Smallest and largest position of each joint that is looked at \[rad\]; `None`: all that the
    /// arm has.
    pub range: Option<[[f64; 2]; N]>,
}

/// What the rule gives.
///
/// ```
/// # #[cfg(feature = "urdf")]
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// use steadyarm::arm::Serial;
/// use steadyarm::control::{Controller, Front, State};
/// use steadyarm::laws::{Circumstances, FeedForward, LearnedTorque, Learns, Rule};
/// use steadyarm::{math::Vector, reference::Setpoint, robot::shipped};
///
/// let arm: Serial<7> = shipped("panda")?.arm()?;
/// let known = Circumstances {
///     control_period: 1e-3,
///     delay: 1,
///     noise: [2.8e-5; 7],
///     velocity_filter: 100.0,
///     effort_limit: arm.effort_limit(),
///     payload: 3.0,
///     inertia_range: [1.0; 2],
///     light_joints: false,
///     range: None,
/// };
/// let Rule { gains, weight, .. } = Rule::new(&arm, &known)?;
/// let law = FeedForward::new(arm, weight, gains.pull)?;
/// let learned = LearnedTorque::new(arm, weight, gains, known.effort_limit, Learns::default())?;
/// let front = Front { velocity_filter: Some(100.0), delay: 1, ..Front::default() };
/// let controller = Controller::new(law, learned).with_front(front)?;
///
/// let mut state = State::new(controller.compensator.state());
/// let q = Vector::<7>::zeros();
/// let command = controller.step(&mut state, &q, &q, &Setpoint::at_rest(q), 1e-3)?;
/// assert!(command.tau.iter().all(|tau| tau.is_finite()));
/// # Ok(())
/// # }
/// # #[cfg(not(feature = "urdf"))]
/// # fn main() {}
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rule<const N: usize, A> {
    /// All gains.
    pub gains: LearningGains<N>,
    /// The arm whose mass matrix is D.
    pub weight: A,
}

/// Gravity and mass matrices at a pose.
struct Posed<const N: usize> {
    gravity: Vector<N>,
    weight: Matrix<N>,
    light: Matrix<N>,
    heavy: Matrix<N>,
}

impl<const N: usize> Circumstances<N> {
    fn validate(&self) -> Result<()> {
        let Self { control_period, delay, noise, velocity_filter, .. } = *self;
        crate::control::check_period("control_period", control_period)?;
        if delay > MAX_DELAY {
            return Err(Error::too_many("delay", Some(delay), MAX_DELAY));
        }
        non_negative("noise", &noise)?;
        accepted("velocity_filter", &[velocity_filter], |f| f > 0.0, "a cut-off > 0")?;
        positive("effort_limit", &self.effort_limit)?;
        non_negative("payload", &[self.payload])?;
        for (n, [lower, upper]) in self.range.iter().flatten().enumerate() {
            let wanted = "a smallest and a largest position";
            let ordered = |x: f64| x.is_finite() && lower <= upper;
            accepted("range", &[*lower, *upper], ordered, wanted).map_err(|e| e.at(n))?;
        }
        let [low, high] = self.inertia_range;
        finite("inertia_range", &[low, high])?;
        let wanted = "bounds with 0 < low <= 1 <= high";
        within("inertia_range", &[low], |low| low > 0.0 && low <= 1.0, wanted)?;
        within("inertia_range", &[high], |high| high >= 1.0, wanted)
    }
}

impl<const N: usize, A: Clone> Rule<N, A> {
    /// The gains for an arm.
    ///
    /// # Errors
    /// Naming what is out of range. `armature`: a joint is so light for its torque that the inertia
    /// of its rotor must be missing. `loop_rate`: too slow for any gains, or for gravity.
    /// `inertia_range`: too wide for what is learnt to converge.
    pub fn new<const K: usize>(arm: &A, known: &Circumstances<N>) -> Result<Self>
    where
        A: Parametric<N, K>,
    {
        known.validate()?;
        let [low, high] = known.inertia_range;
        let weight = arm.burdened(1.0 + (high - 1.0) / 4.0, known.payload / 4.0)?;
        let light = arm.burdened(low, 0.0)?;
        let heavy = arm.burdened(high, known.payload)?;
        let posed: Vec<_> = poses_within(known.range.unwrap_or_else(|| ranges(arm)))
            .map(|q| Posed {
                gravity: arm.gravity(&q),
                weight: weight.mass_matrix(&q),
                light: light.mass_matrix(&q),
                heavy: heavy.mass_matrix(&q),
            })
            .collect();
        let quickness = core::array::from_fn(|n| known.effort_limit[n] / least_light(n, &posed));
        if !known.light_joints {
            has_rotors(&quickness)?;
        }
        let choice = core::array::from_fn(|n| quickest(n, &posed, known));
        let mut gains = LearningGains {
            pull: Pull {
                bandwidth: choice.map(|[p, _]| p),
                braking: braking(&posed, &known.effort_limit),
            },
            cut_off: choice.map(|[_, cut_off]| cut_off),
            learning: 0.0,
            acceleration_share: 1.0,
            unit: [0.0; N],
            control_period: known.control_period,
            delay: known.delay,
            quickness,
            condition: f64::NAN,
        };
        for (n, p) in gains.pull.bandwidth.iter_mut().enumerate() {
            *p *= (2.0 * least_share(n, &posed)).min(1.0);
        }
        slow_down(&mut gains, &posed, known.velocity_filter)?;
        holds_up(&gains.pull.bandwidth, &posed, known.control_period)?;
        gains.unit = units(&gains.pull.bandwidth, &posed, &known.effort_limit);
        gains.condition = learning(&mut gains, &posed)?;
        Ok(Self { gains, weight })
    }
}

/// What rows are measured in: a quarter of the largest torque, or for a joint that is light for its
/// torque what moves it by half a radian, so that 1 % of that is 5 mrad [N·m].
fn units<const N: usize>(bandwidth: &[f64; N], posed: &[Posed<N>], effort: &[f64; N]) -> [f64; N] {
    core::array::from_fn(|n| {
        let least = posed.iter().fold(f64::INFINITY, |least, it| least.min(it.weight[(n, n)]));
        (effort[n] / 4.0).min(MOVED * least * bandwidth[n] * bandwidth[n])
    })
}

/// With what each joint brakes: a quarter of the torque that gravity leaves at these poses, on D
/// [rad/s²].
fn braking<const N: usize>(posed: &[Posed<N>], effort: &[f64; N]) -> [f64; N] {
    let held = posed.iter().fold(Vector::<N>::zeros(), |most, it| most.sup(&it.gravity.abs()));
    core::array::from_fn(|n| {
        let inertia = posed.iter().fold(0.0, |most: f64, it| most.max(it.weight[(n, n)]));
        BRAKING * (effort[n] - held[n]).max(LEFT * effort[n]) / inertia
    })
}

/// Refuses a loop whose feedback is too slow for an arm that gravity pulls.
fn holds_up<const N: usize>(bandwidth: &[f64; N], posed: &[Posed<N>], period: f64) -> Result<()> {
    let slowest = bandwidth.iter().fold(f64::INFINITY, |least, p| least.min(*p));
    let pulled = posed.iter().any(|it| it.gravity.amax() > 0.0);
    let wanted = "a faster loop, a shorter delay, or less payload or inertia_range to reach over: \
                  feedback this slow lets an arm that gravity pulls swing";
    if pulled && slowest < HOLDS {
        return Err(Error::out_of_range("loop_rate", 1.0 / period, wanted));
    }
    Ok(())
}

/// Refuses a joint that is too quick at its largest torque.
fn has_rotors<const N: usize>(quickness: &[f64; N]) -> Result<()> {
    let wanted = "a joint that its effort_limit accelerates by at most 5000 rad/s² (the number \
                  here): its rotor's inertia is missing in this model, and with such a model the \
                  arm would shake; give its armature (gear ratio squared times the rotor's \
                  inertia), or say light_joints where there is no rotor";
    within("armature", quickness, |quick| quick <= QUICKEST, wanted)
}

/// The least inertia of joint `n`, of the lightest arm.
fn least_light<const N: usize>(n: usize, posed: &[Posed<N>]) -> f64 {
    posed.iter().fold(f64::INFINITY, |least, it| least.min(it.light[(n, n)]))
}

/// p of joint `n` and the cut-off of its filter \[Hz\]: the fastest that is quiet, or else the
/// quietest.
fn quickest<const N: usize>(n: usize, posed: &[Posed<N>], known: &Circumstances<N>) -> [f64; 2] {
    let inertia = posed.iter().fold(0.0, |most: f64, it| most.max(it.weight[(n, n)]));
    let [lowest, highest] = CUT_OFFS;
    let ratio = ln(highest / lowest) / (TRIED - 1) as f64;
    let choice = |k: usize| {
        let cut_off = lowest * exp(ratio * k as f64);
        let lag = (0.5 + known.delay as f64) * known.control_period
            + 1.0 / (TAU * known.velocity_filter)
            + 1.0 / (TAU * cut_off);
        [(LAG / (3.0 * lag)).min(FASTEST), cut_off]
    };
    // 3pD times the noise of the velocity
    let quiet = |&[p, cut_off]: &[f64; 2]| {
        let noise = 3.0 * p * inertia * known.noise[n] * velocity_noise(known, cut_off);
        noise <= NOISE * known.effort_limit[n]
    };
    // Of several that are as fast, the quietest.
    let all = (0..TRIED).rev().map(choice).filter(quiet);
    all.max_by(|one, other| one[0].total_cmp(&other[0])).unwrap_or(choice(0))
}

/// Standard deviation of the filtered velocity, of positions with white noise of 1 [1/s]: through a
/// difference and two filters with the shares a and b, `√(2a²b²/((1 − (1−a)(1−b))(2−a)(2−b)))/h`.
fn velocity_noise<const N: usize>(known: &Circumstances<N>, cut_off: f64) -> f64 {
    let h = known.control_period;
    let [a, b] = [filter(known.velocity_filter, h), filter(cut_off, h)];
    let apart = (1.0 - (1.0 - a) * (1.0 - b)) * (2.0 - a) * (2.0 - b);
    a * b * sqrt(2.0 / apart) / h
}

/// The least of M/D of joint `n`, of the lightest arm.
fn least_share<const N: usize>(n: usize, posed: &[Posed<N>]) -> f64 {
    posed.iter().fold(f64::INFINITY, |least, it| least.min(it.light[(n, n)] / it.weight[(n, n)]))
}

/// Lowers p until the loop is stable enough.
fn slow_down<const N: usize>(
    gains: &mut LearningGains<N>,
    posed: &[Posed<N>],
    velocity: f64,
) -> Result<()> {
    for _ in 0..ROUNDS {
        if stable(gains, posed, velocity)? {
            return Ok(());
        }
        gains.pull.bandwidth.iter_mut().for_each(|p| *p *= SLOWER);
    }
    let wanted = "a faster loop, a shorter delay or a narrower inertia_range: no gains keep the \
                  lightest and the heaviest arm stable";
    Err(Error::out_of_range("loop_rate", 1.0 / gains.control_period, wanted))
}

fn stable<const N: usize>(
    gains: &LearningGains<N>,
    posed: &[Posed<N>],
    velocity: f64,
) -> Result<bool> {
    let slowest = gains.pull.bandwidth.iter().fold(f64::INFINITY, |least, p| least.min(*p));
    let most = exp(-MARGIN * slowest * gains.control_period);
    for it in posed {
        for mass in [&it.light, &it.heavy] {
            if frozen_loop::slowest_root(gains, velocity, &it.weight, mass)? > most {
                return Ok(false);
            }
        }
    }
    Ok(true)
}

/// Chooses the filter of learning and c; gives the condition's value.
fn learning<const N: usize>(gains: &mut LearningGains<N>, posed: &[Posed<N>]) -> Result<f64> {
    let slowest = gains.pull.bandwidth.iter().fold(f64::INFINITY, |least, p| least.min(*p));
    gains.learning = LEARNING * slowest / TAU;
    for _ in 0..ROUNDS {
        let mut best = f64::INFINITY;
        for share in SHARES {
            let tried = LearningGains { acceleration_share: share, ..*gains };
            let value = worst(&tried, posed)?;
            if value < best {
                (best, gains.acceleration_share) = (value, share);
            }
            if best <= SURE {
                return Ok(best);
            }
        }
        if best <= MOST {
            return Ok(best);
        }
        gains.learning *= SLOWER;
    }
    let wanted = "a faster loop, a shorter delay, or less payload or inertia_range to reach over: \
                  what is learnt might not converge";
    Err(Error::out_of_range("loop_rate", 1.0 / gains.control_period, wanted))
}

fn worst<const N: usize>(gains: &LearningGains<N>, posed: &[Posed<N>]) -> Result<f64> {
    let mut worst: f64 = 0.0;
    for it in posed {
        for mass in [&it.light, &it.heavy] {
            worst = worst.max(condition::gain(gains, &it.weight, mass)?);
        }
    }
    Ok(worst)
}

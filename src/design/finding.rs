//! Something to know before going ahead, in words that name what to change.

use core::fmt;

use super::figure::Figure;

/// Something to know before going ahead. Joints count from 0, and from 1 in the words.
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
        /// A gain that removes 90 %, if there is one that the control period allows.
        suggested_gain: Option<f64>,
        /// Where the rules can learn the path, about how long that takes \[s\].
        learns_in: Option<f64>,
    },
    /// No rule fires where the joint works.
    Silent {
        /// Joint, from 0.
        joint: usize,
    },
    /// The sampled loop is unstable.
    Unstable {
        /// Joint, from 0; along a path, the one that sets the limit.
        joint: usize,
        /// Its spectral radius; along a path, the growth per sample.
        radius: f64,
        /// Longest stable period \[s\].
        max_period: f64,
    },
    /// The control period is above three quarters of the longest stable one.
    NoMargin {
        /// Joint, from 0; along a path, the one that sets the limit.
        joint: usize,
        /// The control period, as a share of the longest stable one.
        share: f64,
        /// Longest stable period \[s\].
        max_period: f64,
    },
    /// The control period is above a third of the longest stable one.
    SlowSampling {
        /// Joint, from 0; along a path, the one that sets the limit.
        joint: usize,
        /// The control period, as a share of the longest stable one.
        share: f64,
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
    /// The loop would have its margin with measured velocities; through the filter they are late.
    SlowFilter {
        /// Joint, from 0.
        joint: usize,
        /// Of the filter \[Hz\].
        cut_off: f64,
    },
    /// Q is close to the largest one with a solution.
    NarrowMargin {
        /// Joint, from 0.
        joint: usize,
        /// What Q may be multiplied by.
        max_scale: f64,
    },
    /// The rules see where the arm is, and no path was given.
    NeedsPath,
    /// Linearised on the path the loop grows at any control period.
    Overwhelmed {
        /// Joint, from 0; the one that sets the limit.
        joint: usize,
    },
    /// The predicted error is too wide for a linear model.
    Beyond {
        /// Joint, from 0; the one that errs most.
        joint: usize,
        /// Predicted steady RMS error \[rad\].
        rms: f64,
    },
    /// The joint is hardly held.
    Weak {
        /// Joint, from 0.
        joint: usize,
        /// k_p M₀ⱼⱼ [N·m/rad].
        stiffness: f64,
        /// Its effort limit, infinite for none [N·m].
        effort_limit: f64,
    },
    /// k_p and k_v look swapped.
    Swapped {
        /// Joint, from 0.
        joint: usize,
        /// k_p [1/s²].
        kp: f64,
        /// k_v [1/s].
        kv: f64,
    },
    /// The dead zone is wider than what there is to learn from.
    DeadZone {
        /// d₀.
        dead_zone: f64,
        /// The largest |BᵀPx| without the compensator.
        signal: f64,
    },
    /// The projection keeps the weights smaller than they must be.
    SmallBall {
        /// The projection's radius [rad/s²].
        radius: f64,
        /// |W| that ρ_d takes, at least [rad/s²].
        need: f64,
    },
    /// The dictionary is full before the path ends.
    SmallDictionary {
        /// States that it holds.
        capacity: usize,
    },
    /// An input of the rules runs where no centres are.
    OffCenters {
        /// Number of the signal among the inputs.
        signal: &'static str,
        /// Joint, from 0.
        joint: usize,
        /// Where the input runs, scaled.
        runs: (f64, f64),
        /// The smallest and the largest centre.
        centers: (f64, f64),
    },
    /// The run starts far from the path.
    FarStart {
        /// Joint, from 0.
        joint: usize,
        /// |e| at the start \[rad\].
        distance: f64,
    },
    /// The effort limit is below what the path takes.
    WeakEffort {
        /// Joint, from 0.
        joint: usize,
        /// Whether it cannot even be carried on its path.
        sags: bool,
        /// The smaller of controller's and plant's [N·m].
        limit: f64,
        /// What it takes [N·m].
        need: f64,
        /// What takes it.
        taken_by: &'static str,
    },
}

impl Finding {
    /// Whether one should not go ahead.
    pub fn refuses(&self) -> bool {
        matches!(
            self,
            Self::Unstable { .. }
                | Self::NoMargin { .. }
                | Self::Divergent { .. }
                | Self::WeakEffort { sags: true, .. }
        )
    }

    /// Whether the loop has no steady error to judge.
    pub(super) fn grows(&self) -> bool {
        match self {
            Self::WeakEffort { .. } => false,
            Self::Overwhelmed { .. } => true,
            _ => self.refuses(),
        }
    }

    /// Whether it leaves open what the loop does.
    pub fn leaves_open(&self) -> bool {
        matches!(self, Self::NeedsPath | Self::Overwhelmed { .. } | Self::Beyond { .. })
    }

    /// About the loop's sampling.
    fn of_sampling(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (joint, max_period) = match *self {
            Self::Unstable { joint, radius, max_period } => {
                write!(
                    f,
                    "joint {}: the loop is too slow, it will be unstable (spectral radius \
                     {radius:.4})",
                    joint + 1
                )?;
                (joint, max_period)
            }
            Self::NoMargin { joint, share, max_period } => {
                write!(
                    f,
                    "joint {}: the control period is {share:.2} of the longest stable one, too \
                     long to count on",
                    joint + 1
                )?;
                (joint, max_period)
            }
            Self::SlowSampling { joint, share, max_period } => {
                write!(
                    f,
                    "joint {}: the control period is {share:.2} of the longest stable one; it \
                     should be a third at most",
                    joint + 1
                )?;
                (joint, max_period)
            }
            _ => return Ok(()),
        };
        if max_period > 0.0 {
            write!(
                f,
                ": sample every {:.4} ms or faster (the limit is {:.4} ms), or lower gain and kv",
                1e3 * max_period / 3.0,
                1e3 * max_period
            )
        } else {
            write!(f, ": no control period is short enough; lower the gain of joint {}", joint + 1)
        }
    }

    /// About what is learnt.
    fn of_learning(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Inert { joint, k_i, removes, suggested_gain, learns_in } => {
                let (number, percent) = (joint + 1, Figure(100.0 * removes));
                if let Some(time) = learns_in {
                    return write!(
                        f,
                        "joint {number}: the compensator learns slowly: at first it removes \
                         {percent} % of the error, and to learn the path takes it some \
                         {time} s; a higher gain is faster",
                        time = Figure(time)
                    );
                }
                write!(
                    f,
                    "joint {number}: the compensator is inert: with k_I = {k_i} it removes \
                     {percent} % of the error",
                    k_i = Figure(k_i)
                )?;
                match suggested_gain {
                    Some(gain) => write!(f, "; a gain of about {} removes 90 %", Figure(gain)),
                    None => f.write_str(
                        "; no gain that this control period allows removes 90 %: raise kp and kv, \
                         or sample faster",
                    ),
                }
            }
            Self::Silent { joint } => write!(
                f,
                "joint {}: no rule fires where it works: move the centres there, or widen the sets",
                joint + 1
            ),
            Self::NarrowMargin { joint, max_scale } => write!(
                f,
                "joint {}: Q is close to the largest that has a solution ({max_scale:.4} times \
                 this one): lower Q or raise gamma",
                joint + 1
            ),
            Self::NeedsPath => f.write_str(
                "what the compensator does cannot be known without a path: its rules see where \
                 the arm is; give path=, and plant= for the error",
            ),
            _ => self.of_gains(f),
        }
    }

    /// About gains and margins.
    fn of_gains(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
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
            Self::SlowFilter { joint, cut_off } => write!(
                f,
                "velocity_filter: {cut_off} Hz is slow for joint {}, which would have its margin \
                 with velocities that are not late: raise velocity_filter",
                joint + 1
            ),
            Self::Overwhelmed { joint } => write!(
                f,
                "joint {}: linearised on the path the loop grows at any control period: kp and kv \
                 do not hold there what the nominal arm leaves out. How far it strays only a run \
                 tells; raise kp and kv, or mend the model",
                joint + 1
            ),
            Self::Beyond { joint, rms } => write!(
                f,
                "joint {}: its predicted error of {rms:.3} rad (RMS) is wider than a linear model \
                 holds for. How far it strays only a run tells; raise kp and kv, or mend the model",
                joint + 1
            ),
            Self::Swapped { joint, kp, kv } => write!(
                f,
                "joint {}: kp = {kp} and kv = {kv} look swapped: the joint would creep; kv near 2 \
                 √kp is usual",
                joint + 1
            ),
            Self::Weak { joint, stiffness, effort_limit } => {
                write!(
                    f,
                    "joint {}: it is hardly held, by {stiffness:.3} N·m/rad (kp times its \
                     inertia): ",
                    joint + 1
                )?;
                if effort_limit.is_finite() {
                    let bend = 0.01 * effort_limit / stiffness;
                    write!(f, "friction of 1 % of its effort limit bends it by {bend:.2} rad; ")?;
                } else {
                    f.write_str("a thousandth of what the stiffest joint has; ")?;
                }
                f.write_str("raise its kp and kv, or give the arm its rotors (with_armature)")
            }
            _ => self.of_choices(f),
        }
    }

    /// About choices that do nothing, or ruin it.
    fn of_choices(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::DeadZone { dead_zone, signal } => write!(
                f,
                "dead_zone: {dead_zone} is above the signal (|B'Px| stays below {signal} without \
                 the compensator), so nothing is learnt: lower dead_zone",
                signal = Figure(signal)
            ),
            Self::SmallBall { radius, need } => write!(
                f,
                "projection_radius: {radius} is below what is to be learnt (|W| of {need} at \
                 least): raise projection_radius",
                need = Figure(need)
            ),
            Self::SmallDictionary { capacity } => write!(
                f,
                "dictionary: {capacity} states are too few for sets this narrow: the path alone \
                 wants more, and what was learnt is dropped; raise dictionary, or width, or \
                 merge_tolerance"
            ),
            Self::OffCenters { signal, joint, runs, centers: (first, last) } => write!(
                f,
                "centers: the input {signal} of joint {} runs from {:.3} to {:.3}, mostly more \
                 than 2 widths from any centre ({first:.3} to {last:.3}): move, scale or widen \
                 the sets",
                joint + 1,
                runs.0,
                runs.1
            ),
            Self::FarStart { joint, distance } => write!(
                f,
                "q0: joint {} starts {distance:.3} from the path: the torque jumps, and a \
                 compensator learns from the way there: start on the path, or lead the reference \
                 from q0",
                joint + 1
            ),
            Self::WeakEffort { joint, limit, need, taken_by, .. } => write!(
                f,
                "effort_limit: joint {} has {limit:.4} N·m, and {taken_by} takes {need:.4}: raise \
                 it, or choose a slower path or another pose",
                joint + 1
            ),
            _ => Ok(()),
        }
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unstable { .. } | Self::NoMargin { .. } | Self::SlowSampling { .. } => {
                self.of_sampling(f)
            }
            _ => self.of_learning(f),
        }
    }
}

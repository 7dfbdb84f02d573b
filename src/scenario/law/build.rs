//! A law from its settings.

use core::f64::consts::TAU;

use super::adapts::Adapts;
use super::settings::*;
use crate::arm::Arm;
use crate::control::{
    BoxedCompensator, BoxedLaw, ComputedTorque, Dynamic, DynamicState, Feedback, Front, Gains,
    check_period,
};
use crate::error::{Error, Result};
use crate::laws::{
    DisturbanceObserver, HInfinity, Inertia, Integral, Mismatch, MomentumObserver, PdGravity, Rise,
    Robust, SlidingMode, SuperTwisting, TimeDelay, TimeDelayState,
};
use crate::scenario::PerJoint;

/// A law with what it remembers, behind pointers.
pub struct BuiltLaw<const N: usize> {
    /// The law.
    pub law: BoxedLaw<N>,
    /// What it remembers, if it does.
    pub compensator: Option<BoxedCompensator<N>>,
}

/// A rate of πf times half a period of this over 2πf is 0.35, what laws let a period take.
const FILTER_LAG: f64 = 1.4;

/// What is known of the loop around a law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Around<const N: usize> {
    /// Period \[s\], if it is known.
    pub period: Option<f64>,
    /// What stands before the law.
    pub front: Front,
    /// Largest torques [N·m]; infinite where there is no limit.
    pub effort_limit: [f64; N],
}

/// What a law is built for.
pub(super) struct Site<'a, const N: usize, A> {
    pub arm: &'a A,
    pub around: &'a Around<N>,
}

impl LawSettings {
    /// Its name, as in a file.
    pub fn name(&self) -> &'static str {
        match self {
            Self::ComputedTorque(_) => "computed_torque",
            Self::PdGravity(_) => "pd_gravity",
            Self::Pid(_) => "pid",
            Self::SlidingMode(_) => "sliding_mode",
            Self::Robust(_) => "robust",
            Self::HInfinity(_) => "h_infinity",
            Self::SuperTwisting(_) => "super_twisting",
            Self::Rise(_) => "rise",
            Self::SlotineLi(_) => "slotine_li",
            Self::NaturalSlotineLi(_) => "natural_slotine_li",
            Self::PassiveFuzzy(_) => "passive_fuzzy",
            Self::RbfNetwork(_) => "rbf_network",
            Self::AdaptiveComputedTorque(_) => "adaptive_computed_torque",
            Self::TimeDelay(_) => "time_delay",
            Self::DisturbanceObserver(_) => "disturbance_observer",
            Self::MomentumObserver(_) => "momentum_observer",
            Self::Recommended(_) => "recommended",
        }
    }

    /// Whether it learns something that stays right when learning stops.
    pub fn learns(&self) -> bool {
        match self {
            Self::ComputedTorque(it) => it.compensator.is_some(),
            Self::SlotineLi(_)
            | Self::NaturalSlotineLi(_)
            | Self::PassiveFuzzy(_)
            | Self::RbfNetwork(_)
            | Self::AdaptiveComputedTorque(_)
            | Self::Recommended(_) => true,
            _ => false,
        }
    }

    /// The law for a nominal arm. Where the period of the loop is known, its conditions on period
    /// and delay are asked too, and where an uncertainty is declared, those on it.
    ///
    /// # Errors
    /// Naming a parameter of the settings: it is missing, out of range, or a condition says no.
    pub fn build<const N: usize, A>(&self, arm: &A, around: &Around<N>) -> Result<BuiltLaw<N>>
    where
        A: Arm<N> + Adapts<N> + Clone + Send + Sync + 'static,
    {
        around.period.map_or(Ok(()), |period| check_period("control_period", period))?;
        let site = Site { arm, around };
        let built = match self {
            Self::ComputedTorque(it) => site.computed_torque(it),
            Self::PdGravity(it) => site.pd_gravity(it),
            Self::Pid(it) => site.pid(it),
            Self::SlidingMode(it) => site.sliding_mode(it),
            Self::Robust(it) => site.robust(it),
            Self::HInfinity(it) => site.h_infinity(it),
            Self::SuperTwisting(it) => site.super_twisting(it),
            Self::Rise(it) => site.rise(it),
            Self::SlotineLi(it) => site.slotine_li(it, false),
            Self::NaturalSlotineLi(it) => site.slotine_li(it, true),
            Self::PassiveFuzzy(it) => site.passive_fuzzy(it),
            Self::RbfNetwork(it) => site.rbf_network(it),
            Self::AdaptiveComputedTorque(it) => site.adaptive_computed_torque(it),
            Self::TimeDelay(it) => site.time_delay(it),
            Self::DisturbanceObserver(it) => site.disturbance_observer(it),
            Self::MomentumObserver(it) => site.momentum_observer(it),
            Self::Recommended(it) => site.recommended(it),
        };
        built.map_err(|error| match error.parameter() {
            "lambda" => error.named("slope"),
            _ => error,
        })
    }
}

/// A gain of `N` joints that has to be there.
pub(super) fn gain<const N: usize>(
    name: &'static str,
    value: &Option<PerJoint>,
) -> Result<[f64; N]> {
    value.as_ref().ok_or_else(|| Error::missing(name))?.each(name)
}

/// One number for all joints that has to be there.
pub(super) fn number(name: &'static str, value: &Option<PerJoint>) -> Result<f64> {
    gain::<1>(name, value).map(|[value]| value)
}

fn mismatch(settings: &Option<MismatchSettings>) -> Result<Mismatch> {
    settings.as_ref().map(Mismatch::from).ok_or_else(|| Error::missing("uncertainty"))
}

pub(super) fn gains<const N: usize>(
    kp: &Option<PerJoint>,
    kv: &Option<PerJoint>,
) -> Result<Gains<N>> {
    Gains::new(gain("kp", kp)?, gain("kv", kv)?)
}

impl<const N: usize, A> Site<'_, N, A>
where
    A: Arm<N> + Adapts<N> + Clone + Send + Sync + 'static,
{
    /// Asks a condition on period and delay, where they are known, and of a velocity filter that it
    /// is faster than the law: at the rate πf it takes 27° of the 75° that two poles in one place
    /// have. The law that suits a period of [`FILTER_LAG`]/2πf is slower than that.
    pub fn suits(&self, condition: impl Fn(f64, f64) -> Result<()>) -> Result<()> {
        let Around { period, front, .. } = self.around;
        if let Some(period) = *period {
            condition(period, front.delay as f64)?;
        }
        let Some(cut_off) = front.velocity_filter else { return Ok(()) };
        let wanted = "a cut-off [Hz] above the loop's fastest rate [1/s] over π: a higher one, or \
                      a lower bandwidth";
        condition(FILTER_LAG / (TAU * cut_off), 0.0)
            .map_err(|_| Error::out_of_range("velocity_filter", cut_off, wanted))
    }

    pub fn computed<F>(&self, feedback: F) -> BoxedLaw<N>
    where
        F: Feedback<N> + Send + Sync + 'static,
    {
        Box::new(ComputedTorque::new(self.arm.clone(), feedback))
    }

    fn alone<F>(&self, feedback: F) -> Result<BuiltLaw<N>>
    where
        F: Feedback<N> + Send + Sync + 'static,
    {
        Ok(BuiltLaw { law: self.computed(feedback), compensator: None })
    }

    fn with<F, D>(&self, feedback: F, dynamic: D) -> Result<BuiltLaw<N>>
    where
        F: Feedback<N> + Send + Sync + 'static,
        D: Dynamic<N, N> + Send + Sync + 'static,
    {
        let compensator = Some(BoxedCompensator::new(dynamic, |_: &D| DynamicState::<N>::new()));
        Ok(BuiltLaw { law: self.computed(feedback), compensator })
    }

    fn pd_gravity(&self, it: &PdGravitySettings) -> Result<BuiltLaw<N>> {
        let arm = self.arm.clone();
        let law = match it.by_bandwidth()? {
            Some(bandwidth) => PdGravity::with_bandwidth(arm, bandwidth)?,
            None => PdGravity::new(
                arm,
                gain("stiffness", &it.stiffness)?,
                gain("damping", &it.damping)?,
            )?,
        };
        self.suits(|h, d| law.suits(h, d))?;
        Ok(BuiltLaw { law: Box::new(law), compensator: None })
    }

    fn pid(&self, it: &PidSettings) -> Result<BuiltLaw<N>> {
        let (gains, integral) = match it.by_bandwidth()? {
            Some(bandwidth) => Integral::with_bandwidth(bandwidth)?,
            None => {
                let gains = gains(&it.kp, &it.kv)?;
                (gains, Integral::new(gain("ki", &it.ki)?, &gains)?)
            }
        };
        if let Some(uncertainty) = &it.uncertainty {
            integral.covers(&gains, &uncertainty.into())?;
        }
        self.suits(|h, d| gains.suits(h, d))?;
        self.with(gains, integral)
    }

    fn sliding_mode(&self, it: &SlidingModeSettings) -> Result<BuiltLaw<N>> {
        let feedback = match it.by_bandwidth()? {
            Some(bandwidth) => SlidingMode::with_bandwidth(bandwidth, &mismatch(&it.uncertainty)?)?,
            None => {
                let feedback = SlidingMode {
                    lambda: gain("slope", &it.slope)?,
                    gain: gain("gain", &it.gain)?,
                    layer: gain("layer", &it.layer)?,
                    linear: gain("linear", &it.linear)?,
                };
                feedback.validate()?;
                feedback
            }
        };
        if let Some(uncertainty) = &it.uncertainty {
            feedback.covers(&uncertainty.into(), 0.0)?;
        }
        self.suits(|h, d| feedback.suits(h, d))?;
        self.alone(feedback)
    }

    fn robust(&self, it: &RobustSettings) -> Result<BuiltLaw<N>> {
        let feedback = match it.by_bandwidth()? {
            Some(bandwidth) => Robust::with_bandwidth(bandwidth, &mismatch(&it.uncertainty)?)?,
            None => {
                let gains = gains(&it.kp, &it.kv)?;
                let [q, bound, layer] =
                    [number("q", &it.q)?, number("bound", &it.bound)?, number("layer", &it.layer)?];
                Robust::new(gains, q, it.gamma.unwrap_or(f64::INFINITY), bound, layer)?
            }
        };
        if let Some(uncertainty) = &it.uncertainty {
            feedback.covers(&uncertainty.into())?;
        }
        self.suits(|h, d| feedback.suits(h, d))?;
        self.alone(feedback)
    }

    fn h_infinity(&self, it: &HInfinitySettings) -> Result<BuiltLaw<N>> {
        let feedback = match it.by_bandwidth()? {
            Some(bandwidth) => HInfinity::with_bandwidth(bandwidth)?,
            None => {
                let gains = gains(&it.kp, &it.kv)?;
                let [q, gamma, r] =
                    [number("q", &it.q)?, number("gamma", &it.gamma)?, number("r", &it.r)?];
                HInfinity::new(gains, q, gamma, r)?
            }
        };
        self.suits(|h, d| feedback.suits(h, d))?;
        self.alone(feedback)
    }

    fn super_twisting(&self, it: &SuperTwistingSettings) -> Result<BuiltLaw<N>> {
        let feedback = match it.by_bandwidth()? {
            Some(bandwidth) => {
                SuperTwisting::with_bandwidth(bandwidth, &mismatch(&it.uncertainty)?)?
            }
            None => SuperTwisting::new(
                gain("slope", &it.slope)?,
                gain("k1", &it.k1)?,
                gain("k2", &it.k2)?,
            )?,
        };
        self.suits(|h, d| feedback.suits(h, d))?;
        self.with(feedback, feedback)
    }

    fn rise(&self, it: &RiseSettings) -> Result<BuiltLaw<N>> {
        let feedback = match it.by_bandwidth()? {
            Some(bandwidth) => Rise::with_bandwidth(bandwidth, &mismatch(&it.uncertainty)?)?,
            None => Rise::new(
                gain("alpha1", &it.alpha1)?,
                gain("alpha2", &it.alpha2)?,
                gain("ks", &it.ks)?,
                gain("beta", &it.beta)?,
            )?,
        };
        self.suits(|h, d| feedback.suits(h, d))?;
        self.with(feedback, feedback)
    }

    fn time_delay(&self, it: &TimeDelaySettings) -> Result<BuiltLaw<N>> {
        let arm = self.arm.clone();
        let (gains, inertia) = match &it.bandwidth {
            Some(_) => {
                let bandwidth: [f64; N] = it.by_bandwidth()?.unwrap_or([f64::NAN; N]);
                let slowest = bandwidth.iter().copied().fold(f64::INFINITY, f64::min);
                let period = self.around.period.ok_or_else(|| Error::missing("control_period"))?;
                let made = |h, d| Inertia::with_bandwidth(arm.clone(), slowest, h, d);
                self.suits(|h, d| made(h, d).map(|_: (Gains<N>, _)| ()))?;
                made(period, self.around.front.delay as f64)?
            }
            None => (gains(&it.kp, &it.kv)?, Inertia::new(arm, number("share", &it.share)?)?),
        };
        if let Some(uncertainty) = &it.uncertainty {
            inertia.covers(&uncertainty.into())?;
        }
        let delayed = TimeDelay { arm: inertia.clone() };
        let compensator = BoxedCompensator::new(delayed, |_: &_| TimeDelayState::<N>::new());
        let law = Box::new(ComputedTorque::new(inertia, gains));
        Ok(BuiltLaw { law, compensator: Some(compensator) })
    }

    fn disturbance_observer(&self, it: &DisturbanceObserverSettings) -> Result<BuiltLaw<N>> {
        let arm = self.arm.clone();
        let (gains, observer) = match it.by_bandwidth()? {
            Some(bandwidth) => (
                Gains::with_bandwidth(bandwidth)?,
                DisturbanceObserver::with_bandwidth(arm, bandwidth)?,
            ),
            None => {
                (gains(&it.kp, &it.kv)?, DisturbanceObserver::new(arm, gain("gain", &it.gain)?)?)
            }
        };
        self.suits(|h, d| gains.suits(h, d).and_then(|()| observer.suits(h, d)))?;
        self.with(gains, observer)
    }

    fn momentum_observer(&self, it: &MomentumObserverSettings) -> Result<BuiltLaw<N>> {
        let arm = self.arm.clone();
        let (gains, observer) = match it.by_bandwidth::<N>()? {
            Some(bandwidth) => {
                let slowest = bandwidth.iter().copied().fold(f64::INFINITY, f64::min);
                (Gains::with_bandwidth(bandwidth)?, MomentumObserver::with_bandwidth(arm, slowest)?)
            }
            None => {
                (gains(&it.kp, &it.kv)?, MomentumObserver::new(arm, number("pole", &it.pole)?)?)
            }
        };
        self.suits(|h, d| gains.suits(h, d).and_then(|()| observer.suits(h, d)))?;
        self.with(gains, observer)
    }
}

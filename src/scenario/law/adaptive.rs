//! The laws that learn.

use super::adapts::{Adapts, Natural, Uses};
use super::build::{BuiltLaw, Site, gain, gains, number};
use super::settings::*;
use crate::arm::{Arm, Parametric};
use crate::control::{BoxedCompensator, DynamicState, FuzzyCompensator, Gains, KernelCompensator};
use crate::error::{Error, Result};
use crate::laws::{
    AdaptiveComputedTorque, AdaptiveComputedTorqueState, AdaptiveParameters, Pace, Passive,
    PassiveFuzzy, RbfNetwork,
};
use crate::scenario::{CompensatorSettings, PerJoint};

/// How an arm moves where nobody says it: speed [rad/s] and acceleration [rad/s²].
const USUAL_MOTION: [f64; 2] = [1.0, 3.0];

fn pace<const N: usize>(
    speed: &Option<PerJoint>,
    acceleration: &Option<PerJoint>,
) -> Result<Pace<N>> {
    let [usual_speed, usual_acceleration] = USUAL_MOTION;
    let or = |value: &Option<PerJoint>, name, usual: f64| {
        value.as_ref().map_or(Ok([usual; N]), |value| value.each(name))
    };
    Ok(Pace {
        speed: or(speed, "speed", usual_speed)?,
        acceleration: or(acceleration, "acceleration", usual_acceleration)?,
    })
}

impl<const N: usize, A> Site<'_, N, A>
where
    A: Arm<N> + Adapts<N> + Clone + Send + Sync + 'static,
{
    pub fn computed_torque(&self, it: &ComputedTorqueSettings) -> Result<BuiltLaw<N>> {
        let gains = match it.by_bandwidth()? {
            Some(bandwidth) => Gains::with_bandwidth(bandwidth)?,
            None => gains(&it.kp, &it.kv)?,
        };
        self.suits(|h, d| gains.suits(h, d))?;
        let compensator = it.compensator.as_ref().map(|it| adaptive(it, &gains)).transpose()?;
        Ok(BuiltLaw { law: self.computed(gains), compensator })
    }

    /// Slotine and Li's law, with plain or natural adaptation.
    pub fn slotine_li(&self, it: &SlotineLiSettings, natural: bool) -> Result<BuiltLaw<N>> {
        let arm = self.arm.clone();
        let how = match it.by_bandwidth()? {
            Some(bandwidth) => Natural::Bandwidth(bandwidth, pace(&it.speed, &it.acceleration)?),
            None => Natural::Gains(gain("slope", &it.slope)?, number("gain", &it.gain)?),
        };
        let law = match &how {
            Natural::Bandwidth(bandwidth, _) => Passive::with_bandwidth(arm, *bandwidth)?,
            Natural::Gains(slope, _) => Passive::new(arm, *slope, gain("damping", &it.damping)?)?,
        };
        self.suits(|h, d| law.suits(h, d))?;
        let compensator = if natural {
            self.arm.natural(&how)?
        } else {
            self.arm.with_parameters(Parameters(&how))?
        };
        Ok(BuiltLaw { law: Box::new(law), compensator: Some(compensator) })
    }

    pub fn passive_fuzzy(&self, it: &PassiveFuzzySettings) -> Result<BuiltLaw<N>> {
        let settings = it.compensator.as_ref().ok_or_else(|| Error::missing("compensator"))?;
        let (arm, basis) = (self.arm.clone(), settings.basis.build(N)?);
        let parameters = settings.parameters::<N>()?;
        let (law, fuzzy) = match it.by_bandwidth()? {
            Some(bandwidth) => (
                Passive::with_bandwidth(arm.clone(), bandwidth)?,
                PassiveFuzzy::with_bandwidth(arm, basis, bandwidth, parameters.inputs)?,
            ),
            None => {
                let slope = gain("slope", &it.slope)?;
                let law = Passive::new(arm.clone(), slope, gain("damping", &it.damping)?)?;
                let (inputs, adaptation) = (parameters.inputs, parameters.adaptation);
                (law, PassiveFuzzy::new(arm, basis, slope, inputs, adaptation)?)
            }
        };
        self.suits(|h, d| law.suits(h, d))?;
        let new = |it: &PassiveFuzzy<A, FuzzyCompensator<N>>| it.approximator().state();
        Ok(BuiltLaw { law: Box::new(law), compensator: Some(BoxedCompensator::new(fuzzy, new)) })
    }

    pub fn rbf_network(&self, it: &RbfNetworkSettings) -> Result<BuiltLaw<N>> {
        let centers = it.centers.as_deref().ok_or_else(|| Error::missing("centers"))?;
        let network =
            RbfNetwork { centers, width: it.width.ok_or_else(|| Error::missing("width"))? };
        let (gains, fuzzy) = match it.by_bandwidth()? {
            Some(bandwidth) => network.with_bandwidth(bandwidth)?,
            None => {
                let gains = gains(&it.kp, &it.kv)?;
                let [q, gain] = [number("q", &it.q)?, number("gain", &it.gain)?];
                (gains, network.compensator(&gains, q, gain)?)
            }
        };
        self.suits(|h, d| gains.suits(h, d))?;
        let compensator = BoxedCompensator::new(fuzzy, FuzzyCompensator::state);
        Ok(BuiltLaw { law: self.computed(gains), compensator: Some(compensator) })
    }

    pub fn adaptive_computed_torque(
        &self,
        it: &AdaptiveComputedTorqueSettings,
    ) -> Result<BuiltLaw<N>> {
        let how = match it.by_bandwidth()? {
            Some(bandwidth) => Model::Bandwidth(bandwidth, pace(&it.speed, &it.acceleration)?),
            None => Model::Gains(
                gains(&it.kp, &it.kv)?,
                number("q", &it.q)?,
                number("gain", &it.gain)?,
                number("cutoff", &it.cutoff)?,
            ),
        };
        let (gains, compensator) = self.arm.with_parameters(how)?;
        self.suits(|h, d| gains.suits(h, d))?;
        Ok(BuiltLaw { law: self.computed(gains), compensator: Some(compensator) })
    }
}

/// A fuzzy compensator of computed torque, in either form.
fn adaptive<const N: usize>(
    settings: &CompensatorSettings,
    gains: &Gains<N>,
) -> Result<BoxedCompensator<N>> {
    let parameters = settings.parameters()?;
    Ok(match settings.kernel()? {
        Some(kernel) => {
            let basis = settings.basis.kernel(N)?;
            let fuzzy = KernelCompensator::new(basis, gains, parameters, kernel)?;
            BoxedCompensator::new(fuzzy, KernelCompensator::state)
        }
        None => {
            let fuzzy = FuzzyCompensator::new(settings.basis.build(N)?, gains, parameters)?;
            BoxedCompensator::new(fuzzy, FuzzyCompensator::state)
        }
    })
}

/// Plain adaptation of parameters.
struct Parameters<'a, const N: usize>(&'a Natural<N>);

impl<const N: usize> Uses<N> for Parameters<'_, N> {
    type Output = Result<BoxedCompensator<N>>;

    fn of<const K: usize, A>(self, arm: &A) -> Self::Output
    where
        A: Parametric<N, K> + Clone + Send + Sync + 'static,
    {
        let adaptation = match self.0 {
            Natural::Gains(slope, gain) => AdaptiveParameters::new(arm.clone(), *slope, [*gain; K]),
            Natural::Bandwidth(bandwidth, pace) => {
                AdaptiveParameters::with_bandwidth(arm.clone(), *bandwidth, pace)
            }
        }?;
        let new = |_: &AdaptiveParameters<N, K, A>| DynamicState::<K>::new();
        Ok(BoxedCompensator::new(adaptation, new))
    }
}

/// A model that adapts.
enum Model<const N: usize> {
    /// Gains, Q, g and cut-off.
    Gains(Gains<N>, f64, f64, f64),
    Bandwidth([f64; N], Pace<N>),
}

impl<const N: usize> Uses<N> for Model<N> {
    type Output = Result<(Gains<N>, BoxedCompensator<N>)>;

    fn of<const K: usize, A>(self, arm: &A) -> Self::Output
    where
        A: Parametric<N, K> + Clone + Send + Sync + 'static,
    {
        let (gains, adaptation) = match self {
            Self::Gains(gains, q, gain, cutoff) => {
                let adaptation =
                    AdaptiveComputedTorque::new(arm.clone(), gains, q, [gain; K], cutoff)?;
                (gains, adaptation)
            }
            Self::Bandwidth(bandwidth, pace) => {
                AdaptiveComputedTorque::with_bandwidth(arm.clone(), bandwidth, &pace)?
            }
        };
        let new = |_: &AdaptiveComputedTorque<N, K, A>| AdaptiveComputedTorqueState::new();
        Ok((gains, BoxedCompensator::new(adaptation, new)))
    }
}

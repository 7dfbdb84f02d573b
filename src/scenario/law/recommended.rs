//! The recommended controller: what nobody said is taken from the arm.

use core::f64::consts::TAU;

use super::adapts::{Adapts, Uses};
use super::build::{Around, BuiltLaw, Site};
use super::settings::RecommendedSettings;
use crate::arm::{Arm, Parametric};
use crate::control::BoxedCompensator;
use crate::error::{Error, Result, non_negative, within};
use crate::laws::{Circumstances, FeedForward, LearnedTorque, Learns, Rule};
use crate::math::sqrt;

/// Of an encoder of which nobody says it.
const USUAL_BITS: f64 = 16.0;
/// Share of its mass that an arm may carry where nobody says it.
const USUAL_LOAD: f64 = 1.0 / 6.0;

impl<const N: usize, A> Site<'_, N, A>
where
    A: Arm<N> + Adapts<N> + Clone + Send + Sync + 'static,
{
    pub fn recommended(&self, it: &RecommendedSettings) -> Result<BuiltLaw<N>> {
        self.arm.with_parameters(Recommended { settings: it, around: self.around })
    }
}

struct Recommended<'a, const N: usize> {
    settings: &'a RecommendedSettings,
    around: &'a Around<N>,
}

impl<const N: usize> Uses<N> for Recommended<'_, N> {
    type Output = Result<BuiltLaw<N>>;

    fn of<const K: usize, A>(self, arm: &A) -> Self::Output
    where
        A: Parametric<N, K> + Clone + Send + Sync + 'static,
    {
        if self.settings.payload_only && !A::BODIES {
            let wanted =
                "no choice: a two-link arm has lumped parameters, of which a load is a part";
            return Err(Error::out_of_range("payload_only", 1.0, wanted));
        }
        let known = self.circumstances(arm)?;
        let rule = Rule::new(arm, &known)?;
        let residual = self.settings.residual.as_ref();
        let residual = residual.map(|it| Ok::<_, Error>((it.build(N)?, it.inputs.build()?)));
        let learns =
            Learns { payload_only: self.settings.payload_only, residual: residual.transpose()? };
        let Rule { weight, gains, .. } = rule;
        let law = FeedForward::new(arm.clone(), weight.clone(), gains.pull)?;
        let compensator =
            LearnedTorque::new(arm.clone(), weight, gains, known.effort_limit, learns)?;
        let new = |it: &LearnedTorque<N, K, A>| it.state();
        let compensator = Some(BoxedCompensator::new(compensator, new));
        Ok(BuiltLaw { law: Box::new(law), compensator })
    }
}

impl<const N: usize> Recommended<'_, N> {
    fn circumstances<const K: usize, A: Parametric<N, K>>(
        &self,
        arm: &A,
    ) -> Result<Circumstances<N>> {
        let (it, around) = (self.settings, self.around);
        let control_period = around.period.ok_or_else(|| Error::missing("control_period"))?;
        let of = |value: &Option<_>, name, usual| match value {
            Some(value) => crate::scenario::PerJoint::each(value, name),
            None => Ok([usual; N]),
        };
        let bits = of(&it.encoder_bits, "encoder_bits", USUAL_BITS)?;
        let noise: [f64; N] = of(&it.noise, "noise", 0.0)?;
        non_negative("noise", &noise)?;
        within("encoder_bits", &bits, |bits| (1.0..=64.0).contains(&bits), "1 to 64 bits")?;
        let noise = core::array::from_fn(|n| {
            let count = TAU / libm::exp2(bits[n]);
            sqrt(count * count / 12.0 + noise[n] * noise[n])
        });
        Ok(Circumstances {
            control_period,
            delay: around.front.delay,
            noise,
            velocity_filter: around.front.velocity_filter.unwrap_or(f64::INFINITY),
            effort_limit: self.effort_limit(arm)?,
            payload: it.payload.unwrap_or_else(|| USUAL_LOAD * mass(arm)),
            inertia_range: it.inertia_range.unwrap_or([1.0; 2]),
            light_joints: it.light_joints,
            range: it.range.as_ref().map(|range| each(range)).transpose()?,
        })
    }

    /// The largest torque of each joint: as the controller limits it, as it is said, or as the arm
    /// has it.
    fn effort_limit<const K: usize, A: Parametric<N, K>>(&self, arm: &A) -> Result<[f64; N]> {
        let said = self.settings.effort.as_ref().map(|it| it.each("effort")).transpose()?;
        let mut all = self.around.effort_limit;
        for (n, limit) in all.iter_mut().enumerate() {
            let of_arm = arm.joint_stop(n).1.effort;
            let said: Option<[f64; N]> = said;
            *limit = said.map_or(*limit, |said| said[n].min(*limit)).min(of_arm);
            if !limit.is_finite() {
                let wanted =
                    "the largest torque of the joint [N·m]: neither controller nor arm says it";
                return Err(Error::out_of_range("effort_limit", *limit, wanted).at(n));
            }
        }
        Ok(all)
    }
}

fn each<const N: usize>(range: &[[f64; 2]]) -> Result<[[f64; 2]; N]> {
    range.try_into().map_err(|_| Error::wrong_length("range", range.len(), N))
}

/// Of all links \[kg\]; 0 of an arm of lumped parameters.
fn mass<const N: usize, const K: usize, A: Parametric<N, K>>(arm: &A) -> f64 {
    if A::BODIES { arm.inertial_parameters().iter().step_by(10).sum() } else { 0.0 }
}

//! The loop of a design along a path at every size of its motion: what is certain of its stability.
//!
//! A loop that is stable on its path may be lost where the error is wide, and one that is unstable
//! there may settle in a small cycle, where rules of the error fire less, a dead zone or an
//! e-modification weakens what is learnt, or the projection holds the weights:
//!
//! ```text
//! ρ̂ of a swing A:  k_I p22 A,  at most R |ξ| under a projection of radius R
//! ```
//!
//! It is certain to be unstable if it grows at every size, and stable if it grows at none.

use super::Subject;
use super::conditions::Conditions;
use super::course::Course;
use super::excursions::Excursions;
use super::learning::Learning;
use super::sampled_loop::{Integrators, SampledLoop};
use super::spectrum::Signals;
use crate::control::Gains;
use crate::error::Result;
use crate::math::sqrt;

/// Amplitudes at which a loop may shake and still track \[rad\].
const SHAKES: [f64; 8] = [0.0, 0.006, 0.009, 0.013, 0.018, 0.025, 0.035, 0.05];

/// A loop that the projection holds may swing as wide as computed torque alone errs, up to this
/// \[rad\].
const MOST_SWING: f64 = 1.0;

/// A first guess at a longest period \[s\].
const FIRST: f64 = 0.01;

/// Computed torque alone is looked at with a period up to this share of its longest one.
const ALONE: f64 = 1.0 / 3.0;

/// The loops of a design.
pub(super) struct Loops {
    /// Computed torque alone.
    pub alone: SampledLoop,
    /// Its longest period \[s\].
    pub alone_longest: f64,
    /// As the rules fire on the path.
    pub on_path: SampledLoop,
    /// Where they fire most, at errors as wide as computed torque alone has.
    wide: Option<SampledLoop>,
    /// What is left of them where the loop shakes.
    shaken: Vec<SampledLoop>,
}

impl Loops {
    /// Along a course, under these conditions; `guess`: about the longest period.
    pub fn new<const N: usize>(
        course: &Course<N>,
        gains: &Gains<N>,
        compensator: Option<(&dyn Subject<N>, &Learning<N>)>,
        (conditions, guess): (&Conditions<'_>, f64),
    ) -> Result<Self> {
        let whole = |it: Option<&_>| SampledLoop::new(course, gains, it, conditions);
        let alone = whole(None)?;
        let alone_longest = alone.max_period(guess)?;
        let Some((subject, learning)) = compensator else {
            let on_path = whole(None)?;
            return Ok(Self { alone, alone_longest, on_path, wide: None, shaken: Vec::new() });
        };
        let errors = alone.rms(conditions.control_period.min(ALONE * alone_longest), alone_longest);
        let known = if course.measured { sqrt(2.0) } else { 0.0 };
        // Joints shake one another.
        let widest = known * errors.iter().copied().fold(0.0, f64::max);
        let on_path = &learning.xi_squared;
        let rules = Excursions { subject, gains, samples: course.samples(), on_path };
        let firing = Firing::new(&rules, course)?;
        let settled = firing.integrators(on_path);
        let wide = firing.integrators(&rules.strongest(widest)?);
        let mut shaken: Vec<Integrators<N>> = Vec::new();
        for amplitude in firing.amplitudes(widest) {
            let left = firing.shaken(amplitude)?;
            if left != settled && !shaken.contains(&left) {
                shaken.push(left);
            }
        }
        Ok(Self {
            alone,
            alone_longest,
            on_path: whole(Some(&settled))?,
            wide: if wide == settled { None } else { Some(whole(Some(&wide))?) },
            shaken: shaken.iter().map(|it| whole(Some(it))).collect::<Result<_>>()?,
        })
    }

    /// The growth per sample that is certain: the smallest at any size of the motion.
    pub fn radius(&self, h: f64) -> Result<f64> {
        let mut least = self.on_path.radius(h)?;
        for it in self.shaken.iter().chain(&self.wide) {
            least = least.min(it.radius(h)?);
        }
        Ok(least)
    }

    /// The longest period \[s\] below which it is stable on the path, where the error is wide, and
    /// without its compensator if it can be; 0 if there is none.
    pub fn max_period(&self) -> Result<f64> {
        let guess = if self.alone_longest > 0.0 { self.alone_longest } else { FIRST };
        let mut longest = self.on_path.max_period(guess)?;
        if let Some(wide) = self.wide.as_ref().filter(|_| longest > 0.0) {
            longest = longest.min(wide.max_period(longest)?);
        }
        Ok(if self.alone_longest > 0.0 { longest.min(self.alone_longest) } else { longest })
    }
}

/// The rules with what the modifications leave of the law.
struct Firing<'a, const N: usize> {
    rules: &'a Excursions<'a, N>,
    /// |s| without shaking; `None` where it is not known.
    signal: Option<f64>,
}

impl<'a, const N: usize> Firing<'a, N> {
    fn new(rules: &'a Excursions<'a, N>, course: &Course<N>) -> Result<Self> {
        let adaptation = &rules.subject.parameters().adaptation;
        let count = rules.on_path.len() as f64;
        let mean = rules.on_path.iter().fold([0.0; N], |sum, xi_squared| {
            let k_i = adaptation.integral_gains(xi_squared);
            std::array::from_fn(|n| sum[n] + k_i[n] / count)
        });
        let signals = Signals::new(rules.subject, rules.gains, course);
        let signal = course.measured.then(|| signals.settled(&mean)).transpose()?;
        Ok(Self { rules, signal })
    }

    /// The law without dead zone, e-modification and projection.
    fn integrators(&self, xi_squared: &[[f64; N]]) -> Integrators<N> {
        let Excursions { subject, .. } = *self.rules;
        let adaptation = &subject.parameters().adaptation;
        let k_i = xi_squared.iter().map(|it| adaptation.integral_gains(it)).collect();
        Integrators { p: *subject.p(), k_i, leak_rate: adaptation.leak_rate }
    }

    fn amplitudes(&self, widest: f64) -> impl Iterator<Item = f64> {
        let projected = self.rules.subject.parameters().adaptation.projection_radius.is_finite();
        let held = projected && widest.is_finite();
        SHAKES.into_iter().chain(held.then_some(widest.min(MOST_SWING)))
    }

    /// What is left of the law where the loop shakes by this much \[rad\].
    fn shaken(&self, amplitude: f64) -> Result<Integrators<N>> {
        let subject = self.rules.subject;
        let adaptation = &subject.parameters().adaptation;
        let xi_squared = self.rules.shaken(amplitude)?;
        let rate = self.rules.frequency();
        let swings = (0..N).map(|n| subject.p()[n].p22 * rate[n] * amplitude);
        let swing = swings.fold(f64::INFINITY, f64::min);
        let signal = libm::hypot(self.signal.unwrap_or(0.0), swing);
        // Unknown signals may be above any dead zone.
        let drive = self.signal.map_or(1.0, |_| adaptation.drive_factor(signal, 0.0));
        let mut left = self.integrators(&xi_squared);
        left.leak_rate += adaptation.slowest_pull(signal);
        for (k_i, xi_squared) in left.k_i.iter_mut().zip(&xi_squared) {
            for n in 0..N {
                let rho = k_i[n] * subject.p()[n].p22 * amplitude;
                let most = adaptation.projection_radius * sqrt(xi_squared[n].max(0.0));
                k_i[n] *= drive * if rho > most { most / rho } else { 1.0 };
            }
        }
        Ok(left)
    }
}

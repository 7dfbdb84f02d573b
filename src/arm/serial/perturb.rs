//! A seeded neighbour of an arm: a true arm beside the nominal one.

use super::inertia::symmetric;
use super::unphysical::{moments_of, second_moments};
use super::{Inertia, Serial};
use crate::error::{Result, within};
use crate::math::Matrix;

/// How far an arm may be from another one. Shares are uniform in ±; zero, the default, changes
/// nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Perturbation {
    /// Share of every mass, 0 ≤ · < 1; the moments follow it.
    pub mass: f64,
    /// Shift of every centre of mass along each axis \[m\], ≥ 0.
    pub com: f64,
    /// Share of a link's extent in mass along each axis (½ of that in length), 0 ≤ · < 1: changes
    /// moments, not masses.
    pub inertia: f64,
    /// Share of every coefficient of friction, each on its own, 0 ≤ · ≤ 1.
    pub friction: f64,
}

impl Perturbation {
    /// Refuses what could make a mass or a coefficient negative.
    ///
    /// # Errors
    /// `NotFinite` or `OutOfRange`, naming `mass`, `com`, `inertia` or `friction`.
    pub fn validate(&self) -> Result<()> {
        let below_1 = |x: f64| (0.0..1.0).contains(&x);
        within("mass", &[self.mass], below_1, "a number >= 0 and < 1")?;
        within("com", &[self.com], |x| x >= 0.0, "a number >= 0")?;
        within("inertia", &[self.inertia], below_1, "a number >= 0 and < 1")?;
        let up_to_1 = |x: f64| (0.0..=1.0).contains(&x);
        within("friction", &[self.friction], up_to_1, "a number >= 0 and <= 1")
    }
}

/// SplitMix64 (Steele, Lea, Flood 2014): the same numbers everywhere.
struct Random(u64);

impl Random {
    /// Uniform in [−1, 1).
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// Uniform in [1 − share, 1 + share).
    fn factor(&mut self, share: f64) -> f64 {
        1.0 + share * self.next()
    }
}

impl<const N: usize> Serial<N> {
    /// An arm whose masses, centres, moments and friction are off at random. The same seed gives
    /// the same arm on any machine. A physically valid arm stays valid: moments come from
    /// `Σ' = D Σ D` with a positive diagonal D.
    ///
    /// # Errors
    /// As [`Perturbation::validate`], or as [`Serial::new`] if the numbers overflow.
    pub fn perturb(&self, seed: u64, perturbation: &Perturbation) -> Result<Self> {
        perturbation.validate()?;
        let mut random = Random(seed);
        let mut parameters = self.parameters;
        for link in &mut parameters.links {
            link.inertia = perturbed(&link.inertia, perturbation, &mut random);
            let friction = &mut link.friction;
            let [up, down] = &mut friction.coulomb;
            for coefficient in [&mut friction.viscous, up, down, &mut friction.stribeck] {
                *coefficient *= random.factor(perturbation.friction);
            }
        }
        self.rebuilt(parameters)
    }
}

fn perturbed(inertia: &Inertia, by: &Perturbation, random: &mut Random) -> Inertia {
    let heavier = random.factor(by.mass);
    let shift = nalgebra::Vector3::from_fn(|_, _| by.com * random.next());
    let wider = nalgebra::Vector3::from_fn(|_, _| random.factor(0.5 * by.inertia));
    let (mass, com) = (inertia.mass * heavier, inertia.com + shift);
    if by.inertia == 0.0 {
        return Inertia { mass, com, moments: inertia.moments * heavier };
    }
    // Σ = ½ tr(I) 1 − I about the centre of mass, and back by I = tr(Σ) 1 − Σ.
    let stretch = Matrix::<3>::from_diagonal(&wider);
    let sigma = stretch * second_moments(&inertia.moments) * stretch;
    let moments = symmetric(&(moments_of(&sigma) * heavier));
    let stretched = Inertia { mass, com, moments };
    if stretched.validate().is_ok() {
        return stretched;
    }
    // Moments that are valid only within rounding may not be so after stretching. The same change
    // on all axes keeps them valid.
    Inertia { mass, com, moments: inertia.moments * (heavier * wider[0] * wider[0]) }
}

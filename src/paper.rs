//! The paper's three simulations (section 4), from rest in the origin, 40 s.

use core::f64::consts::FRAC_1_SQRT_2;

use crate::arm::{TwoLink, TwoLinkParameters};
use crate::control::{
    Adaptation, ComputedTorque, Controller, FuzzyCompensator, FuzzyParameters, Gains,
};
use crate::error::{Result, at_most};
use crate::fuzzy::{Axis, Form, FuzzyBasis};
use crate::plant::Plant;
use crate::reference::{Harmonic, Sines};

/// Centres of the five sets.
pub const CENTERS: [f64; 5] = [-1.5, -0.5, 0.0, 0.5, 1.5];

/// σ of the sets: exp(−(x − c)²) has σ = 1/√2.
pub const WIDTH: f64 = FRAC_1_SQRT_2;

/// A sum of two harmonics of two joints.
pub type PaperSines = Sines<2, [Harmonic<2>; 2]>;

/// Computed torque for the nominal arm, with the compensator.
pub type PaperController = Controller<2, ComputedTorque<2, TwoLink>, FuzzyCompensator<2>>;

/// How the compensator of simulation 3 is read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// How sets combine to rules.
    pub form: Form,
    /// Fuzzy basis functions, or raw firing strengths.
    pub normalized: bool,
    /// gain = Γ⁻¹.
    pub gain: f64,
}

/// As printed: Γ = diag(7, 7) is a gain of 1/7, five rules, normalised. The compensator is inert.
pub const PRINTED: Reading = Reading { form: Form::Shared, normalized: true, gain: 1.0 / 7.0 };

/// A reading that does what the paper claims: Γ taken for the gain, 625 rules, raw firing
/// strengths.
pub const CLAIMED: Reading = Reading { form: Form::Grid, normalized: false, gain: 7.0 };

/// What the controller believes: 4 kg, 0.5 m, 0.2 kg m² each.
pub fn nominal() -> Result<TwoLink> {
    arm([4.0; 2], [0.2; 2])
}

/// What is there in simulations 2 and 3: twice the mass and inertia.
pub fn actual() -> Result<TwoLink> {
    arm([8.0; 2], [0.4; 2])
}

fn arm(mass: [f64; 2], inertia: [f64; 2]) -> Result<TwoLink> {
    TwoLink::new(TwoLinkParameters { mass, length: [0.5; 2], inertia, ..Default::default() })
}

/// q_d = [0.5 cos t + 0.2 sin 3t, −0.2 sin t − 0.5 cos t].
pub fn reference() -> Result<PaperSines> {
    let slow = Harmonic { frequency: 1.0, sin: [0.0, -0.2], cos: [0.5, -0.5] };
    let fast = Harmonic { frequency: 3.0, sin: [0.2, 0.0], cos: [0.0, 0.0] };
    Sines::new([0.0; 2], [slow, fast])
}

/// τ_d = [sin t, cos t], in simulations 2 and 3.
pub fn disturbance() -> Result<Sines<2, [Harmonic<2>; 1]>> {
    Sines::new([0.0; 2], [Harmonic { frequency: 1.0, sin: [1.0, 0.0], cos: [0.0, 1.0] }])
}

/// The plant of simulations 2 and 3.
pub fn plant() -> Result<Plant<2, TwoLink, Sines<2, [Harmonic<2>; 1]>>> {
    Ok(Plant::new(actual()?, disturbance()?))
}

/// K_p = diag(8, 8), K_v = diag(5.5, 5.5).
pub fn gains() -> Result<Gains<2>> {
    Gains::new([8.0; 2], [5.5; 2])
}

/// The basis of a reading over `inputs` inputs.
pub fn basis(reading: Reading, inputs: usize) -> Result<FuzzyBasis> {
    const MOST: usize = 8;
    at_most("inputs", inputs, MOST)?;
    let axis = Axis { centers: &CENTERS, widths: &[WIDTH] };
    FuzzyBasis::new(reading.form, reading.normalized, &[axis; MOST][..inputs])
}

/// The controller of simulation 3, Q = 10 I, γ = 1, inputs (e, ė).
pub fn controller(reading: Reading) -> Result<PaperController> {
    let adaptation = Adaptation { gain: [reading.gain; 2], ..Default::default() };
    let parameters = FuzzyParameters { adaptation, ..Default::default() };
    let gains = gains()?;
    let compensator = FuzzyCompensator::new(basis(reading, 4)?, &gains, parameters)?;
    Ok(Controller::new(ComputedTorque::new(nominal()?, gains), compensator))
}

//! The scenes that tests and benches share: the paper's simulations, a compensator in each form,
//! references; and two tools, a hash of bits and a small random generator.
#![allow(dead_code, missing_docs, clippy::unwrap_used)]

use std::ops::ControlFlow;

use steadyarm::arm::TwoLink;
use steadyarm::control::{
    Adaptation, Compensator, ComputedTorque, Controller, FuzzyCompensator, FuzzyParameters,
    FuzzyState, Inputs, Law, NoCompensation, State,
};
use steadyarm::fuzzy::Form;
use steadyarm::math::Vector;
use steadyarm::paper::{self, PaperSines, Reading};
use steadyarm::plant::Plant;
use steadyarm::reference::{Harmonic, Setpoint, Sines};
use steadyarm::sim::{Options, Run, Window, metrics, simulate};

pub type Arm = TwoLink;
pub type PaperPlant = Plant<2, TwoLink, Sines<2, [Harmonic<2>; 1]>>;
pub type Plain = Controller<2, ComputedTorque<2, TwoLink>, NoCompensation>;
pub type Adaptive = Controller<2, ComputedTorque<2, TwoLink>, FuzzyCompensator<2>>;
pub type AdaptiveState = State<2, FuzzyState<2, Vec<f64>>>;

pub const FORMS: [Form; 4] = [Form::Grid, Form::Shared, Form::Concat, Form::PerJoint { joints: 2 }];

/// The monitor that never interrupts.
pub fn on(_: f64) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// The plant, the reference and the nominal controller of simulations 1 and 2.
pub fn plant() -> PaperPlant {
    paper::plant().unwrap()
}

pub fn reference() -> PaperSines {
    paper::reference().unwrap()
}

/// The law of the paper's controllers.
pub fn nominal_law() -> ComputedTorque<2, TwoLink> {
    ComputedTorque::new(paper::nominal().unwrap(), paper::gains().unwrap())
}

pub fn plain() -> Plain {
    Controller::new(nominal_law(), NoCompensation)
}

/// Simulation 3 in a reading, with the paper's inputs and law.
pub fn adaptive(form: Form, normalized: bool, gain: f64) -> Adaptive {
    paper::controller(Reading { form, normalized, gain }).unwrap()
}

/// The law (18) with the same gain in both joints, and no modification.
pub fn law(gain: f64) -> Adaptation<2> {
    Adaptation { gain: [gain; 2], ..Adaptation::default() }
}

/// The paper's sets and gains with other inputs and another law.
pub fn modified(
    form: Form,
    normalized: bool,
    inputs: Inputs,
    adaptation: Adaptation<2>,
) -> Adaptive {
    let parameters = FuzzyParameters { inputs, adaptation, ..FuzzyParameters::default() };
    with_parameters(form, normalized, parameters)
}

/// The paper's sets and gains with other parameters.
pub fn with_parameters(form: Form, normalized: bool, parameters: FuzzyParameters<2>) -> Adaptive {
    let basis =
        paper::basis(Reading { form, normalized, gain: 1.0 }, parameters.inputs.len(2)).unwrap();
    let gains = paper::gains().unwrap();
    let compensator = FuzzyCompensator::new(basis, &gains, parameters).unwrap();
    Controller::new(nominal_law(), compensator)
}

/// Every robust modification at once, strong enough to act on the paper's runs.
pub fn everything(gain: f64) -> Adaptation<2> {
    Adaptation {
        gain: [gain, 0.5 * gain],
        leak_rate: 0.05,
        error_modification: 0.01,
        projection_radius: 2.0,
        dead_zone: 1e-3,
        normalization: 0.1,
    }
}

pub fn fresh(controller: &Adaptive) -> AdaptiveState {
    State::new(controller.compensator.state())
}

/// What the compensator remembers at the end of the period that is pending; `state` stays as it is.
pub fn ended<const N: usize, L, C, S>(controller: &Controller<N, L, C>, state: &State<N, S>) -> S
where
    L: Law<N>,
    C: Compensator<N, S>,
    S: Clone,
{
    controller.settle(&mut state.clone()).clone()
}

/// W at the end of the period that is pending, row-major.
pub fn learnt(controller: &Adaptive, state: &AdaptiveState) -> Vec<f64> {
    weights(controller, &ended(controller, state))
}

/// W, row-major.
pub fn weights(controller: &Adaptive, state: &FuzzyState<2, Vec<f64>>) -> Vec<f64> {
    let mut weights = vec![0.0; controller.compensator.weights_len()];
    controller.compensator.read_weights(state, &mut weights).unwrap();
    weights
}

/// Simulation 3 from weights zero.
pub fn run(controller: &Adaptive, options: &Options<2>) -> Run<2> {
    simulate(&plant(), controller, &mut fresh(controller), &reference(), options, on).unwrap()
}

/// The run whose speed is compared: 625 rules, normalised, gain 7000, 20 s of RK4 from an offset.
pub fn compared() -> (Adaptive, Options<2>) {
    let options = Options { duration: 20.0, q0: [0.5, -0.5], ..Options::default() };
    (adaptive(Form::Grid, true, 7000.0), options)
}

/// What a sampled controller sees: position, velocity and set-point at every 20th ms of that run.
pub fn samples() -> Vec<(Vector<2>, Vector<2>, Setpoint<2>)> {
    let (controller, options) = compared();
    let Run { q, dq, q_d, dq_d, ddq_d, .. } =
        run(&controller, &Options { record_every: 20, ..options });
    let at = |k: usize| {
        let desired = Setpoint { q: q_d[k].into(), dq: dq_d[k].into(), ddq: ddq_d[k].into() };
        (q[k].into(), dq[k].into(), desired)
    };
    (0..q.len() - 1).map(at).collect()
}

/// Steady RMS of e₁ and e₂ (second half, t > 20 s) and max |τ₁| of a run of 40 s.
pub fn figures(run: &Run<2>) -> [f64; 3] {
    let half = Window { from: 20.0 + 1e-9, to: 40.0, band: 1.0 };
    let all = Window { from: 0.0, ..half };
    let of = |n, window| metrics(n, &run.t, &run.e, &run.tau, window).unwrap();
    [of(0, half).rms_e, of(1, half).rms_e, of(0, all).max_abs_tau]
}

/// FNV-1a, 64 bits, over the bits of numbers.
pub fn hash(values: impl IntoIterator<Item = f64>) -> u64 {
    let bytes = values.into_iter().flat_map(|x| x.to_bits().to_le_bytes());
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}

/// The bits of numbers, to compare for identity rather than equality.
pub fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|x| x.to_bits()).collect()
}

/// SplitMix64 (Steele, Lea, Flood 2014): small, and the same numbers everywhere.
pub struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in [low, high).
    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn vector(&mut self, size: f64) -> Vector<2> {
        Vector::<2>::new(self.within(-size, size), self.within(-size, size))
    }
}

//! Weights over a basis: Feng's network of radial functions, and the passivity form of the fuzzy
//! law.

use std::ops::ControlFlow;

use steadyarm::arm::{Arm, TwoLink, TwoLinkParameters};
use steadyarm::control::{
    Adaptation, ComputedTorque, Controller, FuzzyCompensator, Gains, Inputs, KernelParameters,
    NoCompensation, Signal, State,
};
use steadyarm::fuzzy::{Axis, Form, FuzzyBasis, KernelBasis};
use steadyarm::laws::{Passive, PassiveFuzzy, RbfNetwork};
use steadyarm::math::Vector;
use steadyarm::paper;
use steadyarm::plant::{Plant, Undisturbed};
use steadyarm::reference::{Harmonic, Reference, Sines};
use steadyarm::sim::{Options, Run, simulate};

use super::{both, figures, nominal, printed, run};

const FENG: RbfNetwork<'static> = RbfNetwork { centers: &[-2.0, -1.0, 0.0, 1.0, 2.0], width: 3.0 };

fn feng_arm(share: f64) -> TwoLink {
    let parameters = TwoLinkParameters {
        mass: both(10.0 * share),
        length: [1.0, 1.75],
        inertia: [0.83 * share, 1.32375 * share],
        gravity: 9.8,
        ..TwoLinkParameters::default()
    };
    TwoLink::new(parameters).unwrap()
}

/// RMS over the whole 20 s.
fn whole(run: &Run<2>) -> [f64; 2] {
    let rms = |n: usize| {
        let sum: f64 = run.e.iter().map(|e| e[n] * e[n]).sum();
        (sum / run.e.len() as f64).sqrt()
    };
    [rms(0), rms(1)]
}

/// Feng 1995, section IV: an arm of 0.8 of the model, pushed along by 2 + 3|e| + 6|ė|.
#[test]
fn fengs_network_and_his_computed_torque_are_the_published_ones() {
    let swing =
        Harmonic { frequency: std::f64::consts::FRAC_PI_2, sin: [0.2, 0.0], cos: [0.0, -0.2] };
    let reference = Sines::new(both(1.0), [swing]).unwrap();
    let push = |q: &Vector<2>, dq: &Vector<2>, t: f64| {
        let desired = reference.at(t);
        let (e, de) = (q - desired.q, dq - desired.dq);
        Vector::<2>::repeat(-(2.0 + 3.0 * e.norm() + 6.0 * de.norm()))
    };
    let plant = Plant::new(feng_arm(0.8), push);
    let gains = Gains::new(both(9.0), both(6.0)).unwrap();
    let law = ComputedTorque::new(feng_arm(1.0), gains);
    let options = Options {
        duration: 20.0,
        q0: [0.6, 0.5],
        dq0: [0.3, 0.5],
        control_period: Some(1e-3),
        ..Options::default()
    };
    let go_on = |_| ControlFlow::Continue(());
    let plain = Controller::new(law, NoCompensation);
    let alone = simulate(&plant, &plain, &mut State::new(()), &reference, &options, go_on);
    let network = FENG.compensator(&gains, 50.0, 20.0).unwrap();
    let mut weights = network.state();
    network.load_weights(&mut weights, &[0.1; 10]).unwrap();
    let learning = Controller::new(law, network);
    let mut state = State::new(weights);
    let learnt = simulate(&plant, &learning, &mut state, &reference, &options, go_on);
    let wanted = [[0.1671, 0.2991], [0.0796, 0.0634]];
    for (run, wanted) in [alone, learnt].into_iter().zip(wanted) {
        let got = whole(&run.unwrap());
        for (got, wanted) in got.iter().zip(wanted) {
            assert!((got / wanted - 1.0).abs() < 0.01, "{got} {wanted}");
        }
    }
}

/// V̇ = −xᵀQx + 2 s·ρ with Lyapunov's P: without the term of γ.
#[test]
fn the_networks_dissipation_identity_holds_without_the_term_of_gamma() {
    let gains = Gains::new(both(9.0), both(6.0)).unwrap();
    let network = FENG.compensator(&gains, 50.0, 20.0).unwrap();
    let (plant, reference) = (paper::plant().unwrap(), paper::reference().unwrap());
    let mut state = State::new(network.state());
    let controller = Controller::new(ComputedTorque::new(nominal(), gains), network);
    let options = Options { duration: 5.0, ..Options::default() };
    let go_on = |_| ControlFlow::Continue(());
    let run = simulate(&plant, &controller, &mut state, &reference, &options, go_on).unwrap();
    let residual = run.certificate.unwrap().residual();
    assert!(residual < 1e-9, "{residual:e}");
}

/// Figures of a program written apart, in Python.
#[test]
fn networks_on_the_papers_plant_are_those_of_a_program_written_apart() {
    let (digits, gains) = ([1e-4, 1e-4, 1.0], Gains::new(both(9.0), both(6.0)).unwrap());
    let network = FENG.compensator(&gains, 50.0, 20.0).unwrap();
    let mut weights = network.state();
    network.load_weights(&mut weights, &[0.0; 10]).unwrap();
    let got = figures(&run(ComputedTorque::new(nominal(), gains), network, weights, 1e-3, 40.0));
    printed("RBF", got, [0.0088, 0.0173, 44.0], digits);
    let passive = Passive::new(nominal(), both(5.0), both(20.0)).unwrap();
    let fuzzy = passive_fuzzy();
    let weights = fuzzy.approximator().state();
    let got = figures(&run(passive, fuzzy, weights, 1e-3, 40.0));
    printed("passivity form", got, [0.0023, 0.0007, 111.0], digits);
}

/// Over (q_d, q̇_d, q̈_d/2): the paper's sets on every input, raw, and a constant.
fn passive_fuzzy() -> PassiveFuzzy<TwoLink, FuzzyCompensator<2>> {
    let w = paper::WIDTH;
    let axis = Axis { centers: &paper::CENTERS, widths: &[w] };
    let [one, two, three, four, five] = paper::CENTERS;
    let constant =
        Axis { centers: &[one, two, three, four, five, 0.0], widths: &[w, w, w, w, w, 1e6] };
    let axes = [constant, axis, axis, axis, axis, axis];
    let basis = FuzzyBasis::new(Form::Concat, false, &axes).unwrap();
    let signals = [(Signal::QDesired, 1.0), (Signal::DqDesired, 1.0), (Signal::DdqDesired, 0.5)];
    let inputs = Inputs::new(&signals).unwrap();
    let adaptation = Adaptation { gain: both(50.0), ..Adaptation::default() };
    PassiveFuzzy::new(nominal(), basis, both(5.0), inputs, adaptation).unwrap()
}

/// With W* = 0 in `V = ½sᵀMs + ½ Σ |Wₙ|²/gₙ`: V̇ = −sᵀK_D s + sᵀε, where ε is what the nominal
/// model lacks as a torque, `ε = τ_passive(M₀, C₀) − τ_passive(M, C) − τ_d`.
#[test]
fn what_the_passivity_form_stores_changes_by_what_the_damping_takes_and_the_model_lacks() {
    let (lambda, damping) = (5.0, 20.0);
    let (actual, reference) = (paper::actual().unwrap(), paper::reference().unwrap());
    let passive = Passive::new(nominal(), both(lambda), both(damping)).unwrap();
    let controller = Controller::new(passive, passive_fuzzy());
    let mut state = State::new(controller.compensator.approximator().state());
    let options = Options { duration: 3.0, dt: 5e-4, ..Options::default() };
    let go_on = |_| ControlFlow::Continue(());
    let plant = Plant::new(actual, Undisturbed);
    let run = simulate(&plant, &controller, &mut state, &reference, &options, go_on).unwrap();
    let s = |k: usize| Vector::<2>::from(run.de[k]) + Vector::<2>::from(run.e[k]) * lambda;
    let ideal = |arm: &TwoLink, k: usize| {
        let (q, dq) = (run.q[k].into(), Vector::<2>::from(run.dq[k]));
        let v_r = Vector::<2>::from(run.dq_d[k]) - Vector::<2>::from(run.e[k]) * lambda;
        let a_r = Vector::<2>::from(run.ddq_d[k]) - Vector::<2>::from(run.de[k]) * lambda;
        arm.mass_matrix(&q) * a_r + arm.coriolis(&q, &dq) * v_r
    };
    let power = |k: usize| {
        let lacking = ideal(&nominal(), k) - ideal(&actual, k);
        damping * s(k).norm_squared() - s(k).dot(&lacking)
    };
    let last = run.e.len() - 1;
    // Simpson's rule.
    let weight = |k: usize| if k % 2 == 1 { 4.0 } else { 2.0 };
    let inner: f64 = (1..last).map(|k| weight(k) * power(k)).sum();
    let lost = (power(0) + inner + power(last)) * options.dt / 3.0;
    let kinetic = |k: usize| 0.5 * s(k).dot(&(actual.mass_matrix(&run.q[k].into()) * s(k)));
    let stored = controller.settle(&mut state).weights_norm().powi(2) / (2.0 * 50.0);
    let fallen = kinetic(0) - kinetic(last) - stored;
    assert!(stored > 0.1 && (fallen - lost).abs() < 1e-6 * kinetic(0), "{fallen} {lost}");
}

/// Rules written out, and a dictionary of them that loses nothing: one torque.
#[test]
fn the_passivity_form_is_the_same_in_kernel_form() {
    let (lambda, inputs) = (both(5.0), Inputs::error());
    let adaptation = Adaptation { gain: both(20.0), ..Adaptation::default() };
    let axes = [Axis { centers: &paper::CENTERS, widths: &[paper::WIDTH] }; 4];
    let passive = Passive::new(nominal(), lambda, both(20.0)).unwrap();
    let basis = FuzzyBasis::new(Form::Grid, true, &axes).unwrap();
    let dense = PassiveFuzzy::new(nominal(), basis, lambda, inputs, adaptation).unwrap();
    let kernel = KernelParameters { capacity: 400, merge_tolerance: 0.0 };
    let basis = KernelBasis::new(true, &axes).unwrap();
    let sparse =
        PassiveFuzzy::kernel(nominal(), basis, lambda, inputs, adaptation, kernel).unwrap();
    let (weights, dictionary) = (dense.approximator().state(), sparse.approximator().state());
    let dense = run(passive, dense, weights, 2e-3, 0.6);
    let sparse = run(passive, sparse, dictionary, 2e-3, 0.6);
    for (own, other) in dense.tau.iter().flatten().zip(sparse.tau.iter().flatten()) {
        assert!((own - other).abs() <= 1e-8 * (1.0 + own.abs()), "{own} {other}");
    }
}

//! Adaptation of inertial parameters: with computed torque, and of bodies that stay possible.

use std::ops::ControlFlow;

use steadyarm::arm::{Arm, Inertia, Parametric, Serial};
use steadyarm::control::{Applied, Controller, Dynamic, DynamicState, Sample, State};
use steadyarm::laws::{
    AdaptiveComputedTorque, AdaptiveComputedTorqueState, AdaptiveParameters, NaturalParameters,
    Passive,
};
use steadyarm::math::{Matrix, Vector};
use steadyarm::plant::{Plant, Undisturbed};
use steadyarm::reference::{Harmonic, Setpoint, Sines};
use steadyarm::sim::{Options, Run, Status, simulate};

use super::{computed, figures, nominal, printed, refused, run};
use crate::chains;
use crate::random::Random;

/// Figures of a program written apart, in Python, for q̈ without a filter, where the projection
/// does not act. Others that keep θ̂ in a box, 0.1 of the nominal parameters at least, have
/// 0.0424 and 0.0941.
#[test]
fn adaptive_computed_torque_on_the_papers_plant_is_that_of_a_program_written_apart() {
    let gains = steadyarm::paper::gains().unwrap();
    let of = |cutoff: f64| {
        let adaptive = AdaptiveComputedTorque::new(nominal(), gains, 10.0, [1.0; 5], cutoff);
        let memory = AdaptiveComputedTorqueState::new();
        figures(&run(computed(gains), adaptive.unwrap(), memory, 1e-3, 40.0))
    };
    printed("MRAC", of(1e4), [0.0418, 0.0912, 15.0], [1e-4, 1e-4, 1.0]);
    // A filter of 10 Hz is slow beside the adaptation, and takes it to where M̂ is not positive.
    let slow = of(10.0);
    assert!(slow[0] < 0.045 && slow[1] < 0.1 && slow[2] < 20.0, "{slow:?}");
}

/// Three joints; the plant's bodies are up to half heavier and sit elsewhere.
fn scene() -> (Serial<3>, Serial<3>) {
    let arm = chains::chain::<3>(&mut Random(11));
    let mut parameters = *arm.parameters();
    for link in &mut parameters.links {
        link.friction = Default::default();
    }
    let arm = Serial::new(parameters).unwrap();
    for (n, link) in parameters.links.iter_mut().enumerate() {
        link.inertia.mass *= 1.2 + 0.15 * n as f64;
        link.inertia.moments *= 1.3;
        link.inertia.com.x += 0.03;
    }
    (arm, Serial::new(parameters).unwrap())
}

fn path() -> Sines<3, [Harmonic<3>; 2]> {
    let slow = Harmonic { frequency: 1.0, sin: [0.0, -0.2, 0.3], cos: [0.5, -0.5, 0.2] };
    let fast = Harmonic { frequency: 3.0, sin: [0.2, 0.0, 0.1], cos: [0.0, 0.1, 0.0] };
    Sines::new([0.1, -0.2, 0.3], [slow, fast]).unwrap()
}

/// P of a body, from its definition: Σ = ∫xxᵀ dm.
fn pseudo_inertia(body: &Inertia) -> Matrix<4> {
    let i = body.moments_about_origin();
    let second = Matrix::<3>::identity() * (0.5 * i.trace()) - i;
    let h = body.com * body.mass;
    Matrix::<4>::from_fn(|r, c| match (r, c) {
        (3, 3) => body.mass,
        (3, n) | (n, 3) => h[n],
        _ => second[(r, c)],
    })
}

const LAMBDA: [f64; 3] = [5.0, 4.0, 6.0];
const DAMPING: [f64; 3] = [20.0, 12.0, 8.0];

fn tracked<const K: usize, D: Dynamic<3, K> + Copy>(
    law: &D,
    options: &Options<3>,
) -> (Run<3>, Vector<K>) {
    let (nominal, actual) = scene();
    let controller = Controller::new(Passive::new(nominal, LAMBDA, DAMPING).unwrap(), *law);
    let mut state = State::new(DynamicState::<K>::new());
    let go_on = |_| ControlFlow::Continue(());
    let plant = Plant::new(actual, Undisturbed);
    let run = simulate(&plant, &controller, &mut state, &path(), options, go_on).unwrap();
    let z = *state.compensator().z().unwrap();
    (run, z)
}

fn sliding(run: &Run<3>, k: usize) -> Vector<3> {
    Vector::<3>::from_fn(|n, _| run.de[k][n] + LAMBDA[n] * run.e[k][n])
}

/// V = ½sᵀMs + (1/γ) Σ [ln det P − ln det P* + tr(P⁻¹P*) − 4] falls at the rate sᵀK_D s.
#[test]
fn what_natural_parameters_store_falls_at_the_rate_of_the_damping() {
    let gain = 0.05;
    let (nominal, actual) = scene();
    let natural = NaturalParameters::<3, 30>::new(nominal, LAMBDA, gain).unwrap();
    let options = Options { duration: 2.0, dt: 2.5e-4, ..Options::default() };
    let (run, z) = tracked(&natural, &options);
    assert_eq!(run.status, Status::Finished);
    let stored = |k: usize, bodies: &[Inertia; 3]| {
        let (s, q) = (sliding(&run, k), run.q[k].into());
        let of_bodies: f64 = (0..3)
            .map(|n| {
                let own = pseudo_inertia(&bodies[n]);
                let true_one = pseudo_inertia(&actual.links()[n].inertia);
                let apart = own.try_inverse().unwrap() * true_one;
                apart.trace() - 4.0 - apart.determinant().ln()
            })
            .sum();
        0.5 * s.dot(&(actual.mass_matrix(&q) * s)) + of_bodies / gain
    };
    let power = |k: usize| (0..3).map(|n| DAMPING[n] * sliding(&run, k)[n].powi(2)).sum::<f64>();
    let last = run.e.len() - 1;
    // Simpson's rule.
    let weight = |k: usize| if k % 2 == 1 { 4.0 } else { 2.0 };
    let inner: f64 = (1..last).map(|k| weight(k) * power(k)).sum();
    let lost = (power(0) + inner + power(last)) * options.dt / 3.0;
    let start = nominal.links().map(|link| link.inertia);
    let fallen = stored(0, &start) - stored(last, &natural.bodies(&z));
    assert!(lost > 1.0 && (fallen - lost).abs() < 1e-6 * lost, "{fallen} {lost}");
}

/// Steps of a congruence, one after the other, for errors as large as they come.
#[test]
fn bodies_stay_possible_after_a_million_steps() {
    let (nominal, _) = scene();
    let natural = NaturalParameters::<3, 30>::new(nominal, LAMBDA, 0.02).unwrap();
    let mut random = Random(7);
    let mut vector = |size: f64| chains::vector::<3>(&mut random, size);
    let applied = Applied::new(Vector::zeros(), Vector::zeros());
    let samples: Vec<_> = (0..1000)
        .map(|_| {
            let desired = Setpoint { q: vector(1.0), dq: vector(2.0), ddq: vector(5.0) };
            let (q, dq) = (desired.q + vector(0.05), desired.dq + vector(0.2));
            Sample::new(q, dq, desired)
        })
        .collect();
    let mut z = Dynamic::start(&natural, &samples[0]);
    for k in 0..1_000_000 {
        z += natural.rate(&z, &samples[k % samples.len()], &applied) * 1e-3;
    }
    let start = nominal.links();
    for (n, body) in natural.bodies(&z).iter().enumerate() {
        let p = pseudo_inertia(body);
        assert!(p.cholesky().is_some() && body.validate().is_ok(), "{p}");
        // They have moved, and far.
        let moved = body.mass / start[n].inertia.mass;
        assert!((moved - 1.0).abs() > 0.05, "{moved}");
    }
}

/// Beside the plain adaptation, on one scene: both follow, but its bodies could not exist.
#[test]
fn plain_adaptation_leaves_the_bodies_that_can_exist_and_the_natural_one_does_not() {
    let (nominal, _) = scene();
    let natural = NaturalParameters::<3, 30>::new(nominal, LAMBDA, 0.05).unwrap();
    let plain = AdaptiveParameters::<3, 30, _>::new(nominal, LAMBDA, [1.0; 30]).unwrap();
    let options = Options { duration: 20.0, control_period: Some(1e-3), ..Options::default() };
    let rms = |run: &Run<3>| {
        let half = &run.e[run.e.len() / 2..];
        (half.iter().flatten().map(|e| e * e).sum::<f64>() / (3 * half.len()) as f64).sqrt()
    };
    let (of_natural, z) = tracked(&natural, &options);
    let possible = |body: &Inertia| pseudo_inertia(body).cholesky().is_some();
    assert!(natural.bodies(&z).iter().all(possible));
    let (of_plain, z) = tracked(&plain, &options);
    let learnt = z + Parametric::inertial_parameters(&nominal);
    let bodies: [Inertia; 3] = core::array::from_fn(|n| {
        Inertia::from_parameters(learnt.as_slice()[10 * n..][..10].try_into().unwrap())
    });
    assert!(!bodies.iter().all(possible));
    assert!(rms(&of_natural) < 0.02 && rms(&of_plain) < 0.02);
}

/// q̈ is a difference of two samples.
#[test]
fn adaptive_computed_torque_is_refused_in_continuous_time() {
    let gains = steadyarm::paper::gains().unwrap();
    let adaptive = AdaptiveComputedTorque::new(nominal(), gains, 10.0, [1.0; 5], 50.0).unwrap();
    let controller = Controller::new(computed(gains), adaptive);
    let mut state = State::new(AdaptiveComputedTorqueState::new());
    let (plant, reference) =
        (steadyarm::paper::plant().unwrap(), steadyarm::paper::reference().unwrap());
    let go_on = |_| ControlFlow::Continue(());
    let run = simulate(&plant, &controller, &mut state, &reference, &Options::default(), go_on);
    assert!(refused(run).starts_with("control_period: got None, wants a period"));
}

#[test]
fn a_body_without_room_is_refused() {
    let (nominal, _) = scene();
    let mut parameters = *nominal.parameters();
    parameters.links[1].inertia.moments = Matrix::<3>::zeros();
    let flat = Serial::new(parameters).unwrap();
    let error = NaturalParameters::<3, 30>::new(flat, LAMBDA, 1.0).unwrap_err();
    assert!(error.to_string().starts_with("inertia[1]: got"), "{error}");
}

//! Speed of every part: a sampled step, whole runs, the basis, the Riccati equations, the dynamics.
#![allow(clippy::unwrap_used, missing_docs)]

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use nalgebra::SMatrix;
use steadyarm::arm::Arm;
use steadyarm::control::{Compensator, ComputedTorque, Controller, Inputs, State};
use steadyarm::fuzzy::Form;
use steadyarm::math::{Matrix, Vector};
use steadyarm::paper::{self, Reading};
use steadyarm::riccati::{bounded_real, gamma_opt, joint};
use steadyarm::sim::{Method, Options, Tolerance, simulate};

#[path = "../tests/common/mod.rs"]
mod common;

/// Period of the sampled controller [s].
const PERIOD: f64 = 1e-3;

/// The paper's gain with normalised functions.
const GAIN: f64 = 7.0;

fn name(form: Form) -> &'static str {
    match form {
        Form::Grid => "grid, 625 rules",
        Form::Shared => "shared, 5 rules",
        Form::Concat => "concat, 20 rules",
        Form::PerJoint { .. } => "per joint, 2 x 25 rules",
    }
}

/// One sampled step, along the samples of a run.
fn step(c: &mut Criterion) {
    step_of(c, "computed torque alone", &common::plain(), State::new(()));
    for form in common::FORMS {
        let controller = common::adaptive(form, true, GAIN);
        let state = common::fresh(&controller);
        step_of(c, name(form), &controller, state);
    }
    let law = common::everything(GAIN);
    let controller = common::modified(Form::Grid, true, Inputs::error(), law);
    let state = common::fresh(&controller);
    step_of(c, "grid, 625 rules, every modification", &controller, state);
}

fn step_of<A: Arm<2>, C: Compensator<2, S>, S>(
    c: &mut Criterion,
    name: &str,
    controller: &Controller<2, ComputedTorque<2, A>, C>,
    mut state: State<2, S>,
) {
    let samples = common::samples();
    let mut next = samples.iter().cycle();
    c.benchmark_group("step").bench_function(name, |b| {
        b.iter(|| {
            let (q, dq, desired) = next.next().unwrap();
            controller.step(&mut state, black_box(q), black_box(dq), desired, PERIOD).unwrap()
        });
    });
}

/// 20 s of the closed loop, record included.
fn closed_loop(c: &mut Criterion) {
    let mut group = c.benchmark_group("closed loop, 20 s");
    group.sample_size(20);
    let (compared, options) = common::compared();
    let dp54 = Method::Dp54(Tolerance { rtol: 1e-8, atol: 1e-10 });
    let sampled = Some(PERIOD);
    for (name, options) in [
        ("RK4 of 1 ms", options),
        ("DP5(4), rtol 1e-8", Options { method: dp54, ..options }),
        ("sampled every 1 ms", Options { control_period: sampled, ..options }),
    ] {
        group.bench_function(format!("grid, 625 rules, {name}"), |b| {
            b.iter(|| common::run(&compared, &options));
        });
    }
    let (plant, plain, reference) = (common::plant(), common::plain(), common::reference());
    group.bench_function("computed torque alone, RK4 of 1 ms", |b| {
        b.iter(|| {
            let mut state = State::new(());
            simulate(&plant, &plain, &mut state, &reference, &options, common::on).unwrap()
        });
    });
    group.finish();
}

/// ξ(x) written out in full, raw and normalised.
fn basis(c: &mut Criterion) {
    let mut group = c.benchmark_group("basis");
    let x = [0.3, -0.2, 0.8, -0.6];
    for form in common::FORMS {
        for normalized in [true, false] {
            let basis = paper::basis(Reading { form, normalized, gain: GAIN }, x.len()).unwrap();
            let (mut work, mut xi) = (vec![0.0; basis.work_len()], vec![0.0; basis.rules()]);
            let kind = if normalized { "normalised" } else { "raw" };
            group.bench_function(format!("{}, {kind}", name(form)), |b| {
                b.iter(|| basis.evaluate(black_box(&x), &mut work, black_box(&mut xi)).unwrap());
            });
        }
    }
    group.finish();
}

/// Equation (19): in closed form for a joint, and on the matrices of 2 and 7 joints.
fn riccati(c: &mut Criterion) {
    c.benchmark_group("riccati").bench_function("joint, closed form", |b| {
        b.iter(|| {
            let [kp, kv, q1, q2] = black_box([8.0, 5.5, 10.0, 10.0]);
            joint(kp, kv, q1, q2, 1.0).unwrap()
        });
    });
    riccati_of::<4, 2>(c);
    riccati_of::<14, 7>(c);
}

/// A = [0 I; −8 I −5.5 I], B = [0; I], Q = 10 I for N joints, S = 2 N.
fn riccati_of<const S: usize, const N: usize>(c: &mut Criterion) {
    let mut group = c.benchmark_group("riccati");
    let a = Matrix::<S>::from_fn(|i, j| match (i < N, i + N == j, i == j, i == j + N) {
        (true, true, ..) => 1.0,
        (false, _, true, _) => -5.5,
        (false, _, _, true) => -8.0,
        _ => 0.0,
    });
    let b = SMatrix::<f64, S, N>::from_fn(|i, j| if i == j + N { 1.0 } else { 0.0 });
    let q = 10.0 * Matrix::<S>::identity();
    group.bench_function(format!("bounded_real, {S} states"), |bench| {
        bench.iter(|| bounded_real(black_box(&a), black_box(&b), black_box(&q), 1.0).unwrap());
    });
    group.bench_function(format!("gamma_opt, {S} states"), |bench| {
        bench.iter(|| gamma_opt(black_box(&a), black_box(&b), black_box(&q)).unwrap());
    });
    group.finish();
}

/// The closed forms of the two-link arm.
fn dynamics(c: &mut Criterion) {
    let mut group = c.benchmark_group("dynamics, two links");
    let arm = paper::nominal().unwrap();
    let state = [Vector::<2>::new(0.3, -0.7), Vector::<2>::new(1.1, 0.4)];
    let input = Vector::<2>::new(-2.0, 0.5);
    group.bench_function("mass matrix and bias", |b| {
        b.iter(|| {
            let [q, dq] = black_box(&state);
            arm.mass_matrix_and_bias(q, dq)
        });
    });
    group.bench_function("inverse dynamics", |b| {
        b.iter(|| {
            let [q, dq] = black_box(&state);
            arm.inverse_dynamics(q, dq, black_box(&input))
        });
    });
    group.bench_function("forward dynamics", |b| {
        b.iter(|| {
            let [q, dq] = black_box(&state);
            arm.forward_dynamics(q, dq, black_box(&input))
        });
    });
    group.finish();
}

criterion_group!(groups, step, closed_loop, basis, riccati, dynamics);
criterion_main!(groups);

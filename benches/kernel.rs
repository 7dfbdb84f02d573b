//! Cost of a sampled step with the product grid in kernel form: against the number of joints, and
//! of atoms.
#![allow(clippy::unwrap_used, missing_docs)]

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use steadyarm::arm::{Arm, Serial, SerialParameters};
use steadyarm::control::{
    Adaptation, ComputedTorque, Controller, KernelParameters, NoCompensation, State,
};
use steadyarm::math::Vector;
use steadyarm::reference::Setpoint;
use steadyarm::robot;

#[path = "../tests/common/mod.rs"]
mod common;
#[path = "../tests/std/kernel/scene.rs"]
mod scene;

/// Period of the sampled controller [s].
const PERIOD: f64 = 1e-3;

/// States that a run goes through before it comes back to the first.
const SAMPLES: usize = 1000;

type SampleOf<const N: usize> = (Vector<N>, Vector<N>, Setpoint<N>);

/// A closed path, a little behind its set-point.
fn path<const N: usize>() -> Vec<SampleOf<N>> {
    let at = |k: usize| {
        let t = k as f64 / SAMPLES as f64 * core::f64::consts::TAU;
        let wave = |n: usize, shift: f64| ((n % 3 + 1) as f64 * t + n as f64 + shift).sin();
        let q = Vector::<N>::from_fn(|n, _| wave(n, 0.0));
        let dq = Vector::<N>::from_fn(|n, _| (n % 3 + 1) as f64 * wave(n, 1.57));
        let ddq = Vector::<N>::zeros();
        let desired = Setpoint { q: q.add_scalar(0.02), dq: dq.add_scalar(-0.01), ddq };
        (q, dq, desired)
    };
    (0..SAMPLES).map(at).collect()
}

/// What a step does with its term.
#[derive(Clone, Copy)]
enum Fate {
    Merged,
    Dropping,
}

/// A step of N joints, 2 N inputs of five sets, with a full dictionary.
fn step_of<const N: usize>(
    c: &mut Criterion,
    (group, number): (&str, usize),
    capacity: usize,
    fate: Fate,
) {
    step_with::<N, _>(c, (group, &number.to_string()), scene::Joints, capacity, fate);
}

/// The same with the arm that the controller believes in.
fn step_with<const N: usize, A: Arm<N> + Copy>(
    c: &mut Criterion,
    (group, name): (&str, &str),
    arm: A,
    capacity: usize,
    fate: Fate,
) {
    let law = Adaptation { gain: [100.0; N], leak_rate: 0.1, ..Adaptation::default() };
    let of = |merge_tolerance| {
        let kernel = KernelParameters { capacity, merge_tolerance };
        let Controller { law, compensator, .. } = scene::joints::<N>(true, law, kernel);
        Controller::new(ComputedTorque::new(arm, law.gains), compensator)
    };
    let (filling, merging) = (of(0.0), of(0.9999));
    let samples = path::<N>();
    let mut state = scene::fresh(&filling);
    for (q, dq, desired) in samples.iter().cycle().step_by(7).take(capacity) {
        filling.step(&mut state, q, dq, desired, PERIOD).unwrap();
    }
    assert_eq!(filling.settle(&mut state).atoms(), capacity);
    let controller = match fate {
        Fate::Merged => &merging,
        Fate::Dropping => &filling,
    };
    let mut next = samples.iter().cycle();
    c.benchmark_group(group).bench_function(name, |b| {
        b.iter(|| {
            let (q, dq, desired) = next.next().unwrap();
            controller.step(&mut state, black_box(q), black_box(dq), desired, PERIOD).unwrap()
        });
    });
}

fn joints(c: &mut Criterion) {
    let group = "kernel step by joints, 256 states, merging";
    step_of::<1>(c, (group, 1), 256, Fate::Merged);
    step_of::<2>(c, (group, 2), 256, Fate::Merged);
    step_of::<3>(c, (group, 3), 256, Fate::Merged);
    step_of::<4>(c, (group, 4), 256, Fate::Merged);
    step_of::<5>(c, (group, 5), 256, Fate::Merged);
    step_of::<6>(c, (group, 6), 256, Fate::Merged);
    step_of::<7>(c, (group, 7), 256, Fate::Merged);
    step_of::<8>(c, (group, 8), 256, Fate::Merged);
}

fn atoms(c: &mut Criterion) {
    for (fate, name) in [(Fate::Merged, "merging"), (Fate::Dropping, "dropping")] {
        let group = format!("kernel step by states, 7 joints, {name}");
        for capacity in [16, 64, 128, 256, 512, 1024] {
            step_of::<7>(c, (&group, capacity), capacity, fate);
        }
    }
}

fn plain(c: &mut Criterion) {
    let arm = scene::Joints;
    let gains = steadyarm::control::Gains::new([8.0; 7], [5.5; 7]).unwrap();
    let controller = Controller::new(ComputedTorque::new(arm, gains), NoCompensation);
    let (mut state, samples) = (State::new(()), path::<7>());
    let mut next = samples.iter().cycle();
    c.benchmark_group("kernel step").bench_function("7 joints, no compensation", |b| {
        b.iter(|| {
            let (q, dq, desired) = next.next().unwrap();
            controller.step(&mut state, black_box(q), black_box(dq), desired, PERIOD).unwrap()
        });
    });
}

/// 5¹⁴ = 6.1 billion rules on a real arm.
fn panda(c: &mut Criterion) {
    let robot = robot::shipped("panda").unwrap();
    let (links, tip, gravity) = (robot.links::<7>().unwrap(), robot.tip, robot.gravity);
    let arm = Serial::new(SerialParameters { links, tip, gravity }).unwrap();
    for (fate, name) in [(Fate::Merged, "merging"), (Fate::Dropping, "dropping")] {
        let name = format!("Panda, 256 states, {name}");
        step_with(c, ("kernel step", &name), arm, 256, fate);
    }
}

criterion_group!(groups, plain, panda, joints, atoms);
criterion_main!(groups);

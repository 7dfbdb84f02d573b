//! Cost of a sampled step with the product grid in kernel form: against the number of joints, and of atoms.
#![allow(clippy::unwrap_used, missing_docs)]

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use steadyarm::control::{Adaptation, ComputedTorque, KernelParameters, NoCompensation, State};
use steadyarm::math::Vector;
use steadyarm::reference::Setpoint;

#[path = "../tests/common/mod.rs"]
mod common;
#[path = "../tests/kernel/scene.rs"]
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

/// A step of N joints, 2 N inputs, with a dictionary that is full.
fn step_of<const N: usize>(c: &mut Criterion, group: &str, kernel: KernelParameters) {
    let law = Adaptation { gain: [100.0; N], leak_rate: 0.1, ..Adaptation::default() };
    let controller = scene::joints(true, law, kernel);
    let (mut state, samples) = (scene::fresh(&controller), path::<N>());
    for (q, dq, desired) in samples.iter().cycle().take(10 * SAMPLES) {
        controller.step(&mut state, q, dq, desired, PERIOD).unwrap();
    }
    let memory = &state.compensator;
    let name = format!(
        "{N} joints, {} inputs, {} atoms, merging {}",
        2 * N,
        memory.atoms(),
        kernel.merge_tolerance
    );
    println!("{name}: {} merged, {} dropped", memory.merged(), memory.dropped());
    let mut next = samples.iter().cycle();
    c.benchmark_group(group).bench_function(name, |b| {
        b.iter(|| {
            let (q, dq, desired) = next.next().unwrap();
            controller.step(&mut state, black_box(q), black_box(dq), desired, PERIOD).unwrap()
        });
    });
}

fn joints(c: &mut Criterion) {
    let kernel = KernelParameters { capacity: 256, merge_tolerance: 0.5 };
    step_of::<1>(c, "kernel step, joints", kernel);
    step_of::<2>(c, "kernel step, joints", kernel);
    step_of::<3>(c, "kernel step, joints", kernel);
    step_of::<4>(c, "kernel step, joints", kernel);
    step_of::<5>(c, "kernel step, joints", kernel);
    step_of::<6>(c, "kernel step, joints", kernel);
    step_of::<7>(c, "kernel step, joints", kernel);
    step_of::<8>(c, "kernel step, joints", kernel);
}

/// 7 joints; every step merges, and every step drops.
fn atoms(c: &mut Criterion) {
    for merge_tolerance in [0.99, 0.0] {
        for capacity in [16, 64, 128, 256, 512, 1024] {
            let kernel = KernelParameters { capacity, merge_tolerance };
            step_of::<7>(c, "kernel step, atoms", kernel);
        }
    }
}

fn plain(c: &mut Criterion) {
    let arm = scene::Joints;
    let gains = steadyarm::control::Gains::new([8.0; 7], [5.5; 7]).unwrap();
    let controller = ComputedTorque::new(arm, gains, NoCompensation);
    let (mut state, samples) = (State::new(()), path::<7>());
    let mut next = samples.iter().cycle();
    c.benchmark_group("kernel step, joints").bench_function("7 joints, no compensation", |b| {
        b.iter(|| {
            let (q, dq, desired) = next.next().unwrap();
            controller.step(&mut state, black_box(q), black_box(dq), desired, PERIOD).unwrap()
        });
    });
}

criterion_group!(groups, plain, joints, atoms);
criterion_main!(groups);

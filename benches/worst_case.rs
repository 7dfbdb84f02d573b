//! The worst step of a controller: samples and histories that breed subnormal numbers, beside usual
//! ones, as a line of JSON each.
//!
//! Steps are timed in batches. The minimum over repeats of a batch is what the arithmetic takes,
//! without interrupts. `benches/worst_case.py` keeps the figures.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use std::hint::black_box;
use std::time::Instant;

use steadyarm::arm::{Arm, Serial};
use steadyarm::control::{
    Adaptation, Compensator, ComputedTorque, Controller, FuzzyCompensator, FuzzyParameters, Gains,
    Inputs, KernelCompensator, KernelParameters, NoCompensation, State,
};
use steadyarm::fuzzy::{Axis, Form, FuzzyBasis, KernelBasis};
use steadyarm::math::Vector;
use steadyarm::paper::{CENTERS, WIDTH};
use steadyarm::reference::{Harmonic, Reference, Setpoint, Sines};
use steadyarm::robot::shipped;

#[path = "../tests/common/mod.rs"]
mod common;

/// Rounds over all cases, and repeats of a case in each: a disturbance lasts longer than a repeat.
const ROUNDS: usize = 8;
const REPEATS: usize = 20;
const BATCH: usize = 200;
const PERIOD: f64 = 1e-3;

type Seen<const N: usize> = (Vector<N>, Vector<N>, Setpoint<N>);

/// A sample whose entries all have this size.
fn sized<const N: usize>(size: f64, k: usize) -> Seen<N> {
    let v = |i: usize| {
        let x = size * (1.0 + 0.1 * ((k + i) % 7) as f64);
        Vector::<N>::from_fn(|n, _| if n % 2 == 0 { x } else { -1.3 * x })
    };
    (v(0), v(1), Setpoint { q: v(2), dq: v(3), ddq: v(4) })
}

/// Usual samples, those of sizes over the whole range of numbers, and those near the ends of the
/// sets.
fn samples<const N: usize>(usual: &[Seen<N>]) -> Vec<(String, Vec<Seen<N>>)> {
    let mut all = vec![("usual".into(), usual[..BATCH].to_vec())];
    let sizes = [
        5e-324, 1e-310, 1e-300, 1e-200, 1e-160, 1e-150, 1e-100, 1e-50, 1e-20, 1e-8, 1.0, 3.0, 6.0,
        8.0, 10.0, 12.0, 15.0, 18.0, 20.0, 21.0, 22.0, 25.0, 27.0, 30.0, 100.0, 1e4, 1e5,
    ];
    for size in sizes {
        all.push((format!("all {size:e}"), (0..BATCH).map(|k| sized(size, k)).collect()));
    }
    all
}

/// Nanoseconds a step: the minimum over repeats of a batch.
fn fastest<const N: usize, A: Arm<N>, C, S: Clone>(
    controller: &Controller<N, ComputedTorque<N, A>, C>,
    start: &State<N, S>,
    samples: &[Seen<N>],
) -> f64
where
    C: Compensator<N, S>,
{
    let mut least = f64::INFINITY;
    for _ in 0..REPEATS {
        let mut state = start.clone();
        let begin = Instant::now();
        for (q, dq, desired) in samples {
            let (q, dq, desired) = black_box((q, dq, desired));
            _ = black_box(controller.step(&mut state, q, dq, desired, PERIOD));
        }
        least = least.min(begin.elapsed().as_secs_f64() * 1e9 / samples.len() as f64);
    }
    least
}

/// Every kind of samples from every history, the usual ones first; `histories` are states to start
/// from.
fn report<const N: usize, A: Arm<N>, C, S: Clone>(
    name: &str,
    controller: &Controller<N, ComputedTorque<N, A>, C>,
    usual: &[Seen<N>],
    histories: &[(&str, State<N, S>)],
) where
    C: Compensator<N, S>,
{
    let samples = samples(usual);
    let cases: Vec<_> =
        histories.iter().flat_map(|of| samples.iter().map(move |seen| (of, seen))).collect();
    let mut least = vec![f64::INFINITY; cases.len()];
    for _ in 0..ROUNDS {
        for (((_, state), (_, seen)), least) in cases.iter().zip(&mut least) {
            *least = least.min(fastest(controller, state, seen));
        }
    }
    for (((history, _), (sample, _)), ns) in cases.iter().zip(&least) {
        println!("{{\"figure\": \"{name}: {history}, {sample}\", \"ns\": {ns:.1}}}");
    }
}

fn dense(name: &str, form: Form, normalized: bool, inputs: Inputs, adaptation: Adaptation<2>) {
    let controller = common::modified(form, normalized, inputs, adaptation);
    let (usual, fresh) = (common::samples(), common::fresh(&controller));
    let mut histories = vec![("taught", taught(&controller, &fresh, &usual)), ("new", fresh)];
    for (history, size) in [
        ("weights 1e-150", 1e-150),
        ("weights 1e-155", 1e-155),
        ("weights 1e-160", 1e-160),
        ("weights 1e-200", 1e-200),
        ("weights 1e-299", 1e-299),
        ("weights 1e-310", 1e-310),
    ] {
        let mut state = common::fresh(&controller);
        let weights: Vec<_> = (0..controller.compensator.weights_len())
            .map(|k| size * (1.0 + 0.1 * (k % 9) as f64))
            .collect();
        controller.compensator.load_weights(controller.settle(&mut state), &weights).unwrap();
        histories.push((history, state));
    }
    report(name, &controller, &usual, &histories);
}

/// The state after these samples.
fn taught<const N: usize, A: Arm<N>, C, S: Clone>(
    controller: &Controller<N, ComputedTorque<N, A>, C>,
    start: &State<N, S>,
    samples: &[Seen<N>],
) -> State<N, S>
where
    C: Compensator<N, S>,
{
    let mut state = start.clone();
    for (q, dq, desired) in samples {
        controller.step(&mut state, q, dq, desired, PERIOD).unwrap();
    }
    state
}

fn kernel(name: &str, normalized: bool, adaptation: Adaptation<2>) {
    dictionary(name, common::nominal_law(), normalized, adaptation, &common::samples());
}

fn dictionary<const N: usize, A: Arm<N>>(
    name: &str,
    law: ComputedTorque<N, A>,
    normalized: bool,
    adaptation: Adaptation<N>,
    usual: &[Seen<N>],
) {
    let axis = Axis { centers: &CENTERS, widths: &[WIDTH] };
    let basis = KernelBasis::new(normalized, &vec![axis; 2 * N]).unwrap();
    let parameters = FuzzyParameters { adaptation, ..FuzzyParameters::default() };
    let kernel = KernelParameters { capacity: 64, merge_tolerance: 0.05 };
    let compensator = KernelCompensator::new(basis, &law.gains, parameters, kernel).unwrap();
    let controller = Controller::new(law, compensator);
    let fresh = State::new(controller.compensator.state());
    report(name, &controller, usual, &[("taught", taught(&controller, &fresh, usual))]);
}

/// Seven joints, along sines about a pose in the middle of its range.
fn panda() {
    let arm: Serial<7> = shipped("panda").unwrap().arm().unwrap();
    let gains = Gains::new([100.0; 7], [20.0; 7]).unwrap();
    let rest = [0.0, -0.6, 0.0, -2.0, 0.0, 1.6, 0.8];
    let harmonic = Harmonic { frequency: 1.0, sin: [0.2; 7], cos: [0.0; 7] };
    let path = Sines::new(rest, vec![harmonic]).unwrap();
    let usual: Vec<Seen<7>> = (0..1000)
        .map(|k| {
            let (t, off) = (0.02 * k as f64, Vector::repeat(0.01));
            (path.at(t - 0.02).q + off, path.at(t - 0.02).dq - off, path.at(t))
        })
        .collect();
    let axis = Axis { centers: &CENTERS, widths: &[WIDTH] };
    let adaptation = |rate| Adaptation { gain: [7.0; 7], leak_rate: rate, ..Adaptation::default() };
    for (name, normalized, rate) in
        [("Panda, per joint, raw", false, 0.0), ("Panda, per joint, fast leak", true, 2e4)]
    {
        let basis = FuzzyBasis::new(Form::PerJoint { joints: 7 }, normalized, &[axis; 14]).unwrap();
        let adaptation = adaptation(rate);
        let parameters = FuzzyParameters { adaptation, ..FuzzyParameters::default() };
        let compensator = FuzzyCompensator::new(basis, &gains, parameters).unwrap();
        let controller = Controller::new(ComputedTorque::new(arm, gains), compensator);
        let fresh = State::new(controller.compensator.state());
        let histories = [("taught", taught(&controller, &fresh, &usual)), ("new", fresh)];
        report(name, &controller, &usual, &histories);
    }
    let law = ComputedTorque::new(arm, gains);
    dictionary("Panda, dictionary, raw", law, false, adaptation(0.0), &usual);
    let (law, state) = (ComputedTorque::new(arm, gains), State::new(()));
    report("Panda, plain", &Controller::new(law, NoCompensation), &usual, &[("new", state)]);
}

fn main() {
    let leak = |rate: f64| Adaptation { leak_rate: rate, ..common::law(70.0) };
    dense("625 rules", Form::Grid, true, Inputs::error(), common::law(7000.0));
    dense("625 rules, raw", Form::Grid, false, Inputs::error(), common::law(70.0));
    dense("5 rules, raw", Form::Shared, false, Inputs::error(), common::law(70.0));
    dense("625 rules, fast leak", Form::Grid, true, Inputs::error(), leak(2e4));
    dense("625 rules, slow leak", Form::Grid, true, Inputs::error(), leak(700.0));
    dense(
        "per joint, all",
        Form::PerJoint { joints: 2 },
        false,
        Inputs::state(),
        Adaptation { projection_radius: f64::INFINITY, ..common::everything(70.0) },
    );
    kernel("dictionary", true, leak(700.0));
    kernel("dictionary, raw", false, common::law(70.0));
    panda();
}

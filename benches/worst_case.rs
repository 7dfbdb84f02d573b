//! The worst step of a controller: samples and histories that breed subnormal numbers, beside usual
//! ones, as a line of JSON each.
//!
//! Steps are timed in batches. The minimum over repeats of a batch is what the arithmetic takes,
//! without interrupts. `benches/worst_case.py` keeps the figures.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use std::hint::black_box;
use std::time::Instant;

use steadyarm::control::{
    Adaptation, ComputedTorque, Controller, FuzzyParameters, Inputs, KernelCompensator,
    KernelParameters, Saves, State,
};
use steadyarm::fuzzy::{Axis, Form, KernelBasis};
use steadyarm::math::Vector;
use steadyarm::paper::{self, CENTERS, WIDTH};
use steadyarm::reference::Setpoint;

#[path = "../tests/common/mod.rs"]
mod common;

/// Rounds over all cases, and repeats of a case in each: a disturbance lasts longer than a repeat.
const ROUNDS: usize = 8;
const REPEATS: usize = 20;
const BATCH: usize = 200;
const PERIOD: f64 = 1e-3;

type Seen = (Vector<2>, Vector<2>, Setpoint<2>);

/// A sample whose entries all have this size.
fn sized(size: f64, k: usize) -> Seen {
    let v = |i: usize| {
        let x = size * (1.0 + 0.1 * ((k + i) % 7) as f64);
        Vector::<2>::new(x, -1.3 * x)
    };
    (v(0), v(1), Setpoint { q: v(2), dq: v(3), ddq: v(4) })
}

/// Samples of sizes over the whole range of numbers, and those near the ends of the sets.
fn samples() -> Vec<(String, Vec<Seen>)> {
    let mut all = vec![("usual".into(), common::samples()[..BATCH].to_vec())];
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
fn fastest<C, S: Clone>(
    controller: &Controller<2, ComputedTorque<2, common::Arm>, C>,
    start: &State<2, S>,
    samples: &[Seen],
) -> f64
where
    C: Saves<2, S>,
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
fn report<C, S: Clone>(
    name: &str,
    controller: &Controller<2, ComputedTorque<2, common::Arm>, C>,
    histories: &[(&str, State<2, S>)],
) where
    C: Saves<2, S>,
{
    let samples = samples();
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
    let taught = |state: &mut common::AdaptiveState| {
        for (q, dq, desired) in &common::samples() {
            controller.step(state, q, dq, desired, PERIOD).unwrap();
        }
    };
    let mut histories = vec![("new", common::fresh(&controller))];
    let mut state = common::fresh(&controller);
    taught(&mut state);
    histories.push(("taught", state));
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
    report(name, &controller, &histories);
}

fn kernel(name: &str, normalized: bool, adaptation: Adaptation<2>) {
    let axis = Axis { centers: &CENTERS, widths: &[WIDTH] };
    let basis = KernelBasis::new(normalized, &[axis; 4]).unwrap();
    let parameters = FuzzyParameters { adaptation, ..FuzzyParameters::default() };
    let gains = paper::gains().unwrap();
    let kernel = KernelParameters { capacity: 64, merge_tolerance: 0.05 };
    let compensator = KernelCompensator::new(basis, &gains, parameters, kernel).unwrap();
    let controller = Controller::new(common::nominal_law(), compensator);
    let mut state = State::new(controller.compensator.state());
    for (q, dq, desired) in &common::samples() {
        controller.step(&mut state, q, dq, desired, PERIOD).unwrap();
    }
    report(name, &controller, &[("taught", state)]);
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
}

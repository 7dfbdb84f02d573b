//! The step of the recommended controller on a Panda, each of 20 000 in a row, as a line of JSON.
//!
//! Every step is timed alone, in several passes over the same samples. The least over the passes is
//! what its arithmetic takes, without interrupts: of that the median, 99.99 % and the worst.
//! `benches/recommended.py` keeps the figures.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use std::hint::black_box;
use std::time::Instant;

use steadyarm::arm::Serial;
use steadyarm::control::{Controller, Front, State};
use steadyarm::laws::{Circumstances, FeedForward, LearnedTorque, Learns, Rule};
use steadyarm::math::Vector;
use steadyarm::reference::Setpoint;
use steadyarm::robot::shipped;

const STEPS: usize = 20_000;
const PASSES: usize = 9;
const PERIOD: f64 = 1e-3;

fn main() {
    let panda: Serial<7> = shipped("panda").unwrap().arm().unwrap();
    for (name, payload_only) in [("links", false), ("payload", true)] {
        let mut least = vec![f64::INFINITY; STEPS];
        for _ in 0..PASSES {
            pass(&panda, payload_only, &mut least);
        }
        least.sort_by(f64::total_cmp);
        let at = |share: f64| least[((STEPS - 1) as f64 * share) as usize];
        println!(
            "{{\"figure\": \"recommended, 7 joints, learns {name}\", \"median_ns\": {:.0}, \
             \"p9999_ns\": {:.0}, \"worst_ns\": {:.0}}}",
            at(0.5),
            at(0.9999),
            at(1.0)
        );
    }
}

/// Times every step of a run through sines in all joints.
fn pass(panda: &Serial<7>, payload_only: bool, least: &mut [f64]) {
    let known = Circumstances {
        control_period: PERIOD,
        delay: 1,
        noise: [2.8e-5; 7],
        velocity_filter: 100.0,
        effort_limit: panda.effort_limit(),
        payload: 2.0,
        inertia_range: [1.0; 2],
        light_joints: true,
    };
    let Rule { gains, weight, .. } = Rule::new(panda, &known).unwrap();
    let learns = Learns { payload_only, residual: None };
    let law = FeedForward::new(*panda, weight, gains.pull).unwrap();
    let learned = LearnedTorque::new(*panda, weight, gains, known.effort_limit, learns).unwrap();
    let front =
        Front { hand_over: Some(3.0), velocity_filter: Some(100.0), bumpless: None, delay: 1 };
    let it = Controller::new(law, learned).with_front(front).unwrap();
    let mut state = State::new(it.compensator.state());
    for (k, least) in least.iter_mut().enumerate() {
        let t = k as f64 * PERIOD;
        let wave = |n: usize, shift: f64| (t * (1.0 + 0.1 * n as f64) + n as f64 + shift).sin();
        let desired = Setpoint {
            q: Vector::from_fn(|n, _| 0.4 * wave(n, 0.0)),
            dq: Vector::from_fn(|n, _| 0.4 * wave(n, 1.57)),
            ddq: Vector::from_fn(|n, _| -0.4 * wave(n, 0.0)),
        };
        let q = desired.q + Vector::from_fn(|n, _| 1e-3 * wave(n, 2.0));
        let (q, desired) = black_box((q, desired));
        let begin = Instant::now();
        black_box(it.step(&mut state, &q, &desired.dq, &desired, PERIOD).unwrap());
        *least = least.min(begin.elapsed().as_secs_f64() * 1e9);
    }
}

//! Time of one sampled step with 625 rules, and of the Riccati equation of two joints in closed
//! form, as a line of JSON.
//!
//! A median over batches of 1000: a batch is short enough to be rarely interrupted.
//! `benches/compare.py` runs this.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use std::hint::black_box;
use std::time::Instant;

use steadyarm::riccati::joint;

#[path = "../tests/common/mod.rs"]
mod common;

const BATCHES: usize = 300;
const BATCH: usize = 1000;
/// Period of the sampled controller [s].
const PERIOD: f64 = 1e-3;

fn main() {
    let (controller, _) = common::compared();
    let (mut state, samples) = (common::fresh(&controller), common::samples());
    assert_eq!(samples.len(), BATCH);
    let step = median_ns(|k| {
        let (q, dq, desired) = black_box(&samples[k]);
        black_box(controller.step(&mut state, q, dq, desired, PERIOD).unwrap());
    });
    let riccati = median_ns(|_| {
        for _ in 0..2 {
            let [kp, kv, q1, q2] = black_box([8.0, 5.5, 10.0, 10.0]);
            black_box(joint(kp, kv, q1, q2, 1.0).unwrap());
        }
    });
    println!("{{\"step_ns\": {step:.1}, \"riccati_joints_ns\": {riccati:.2}}}");
}

/// Median over the batches of the time of one call [ns].
fn median_ns(mut call: impl FnMut(usize)) -> f64 {
    let mut batches: Vec<f64> = (0..BATCHES)
        .map(|_| {
            let start = Instant::now();
            (0..BATCH).for_each(&mut call);
            start.elapsed().as_secs_f64() * 1e9 / BATCH as f64
        })
        .collect();
    batches.sort_by(f64::total_cmp);
    batches[BATCHES / 2]
}

//! Time of the dynamics of an arm of 7 joints, ours and dynibo's, as lines of JSON [ns a call].
//!
//! Usage: dynamics-peers robot.urdf
//!
//! The smallest of 20 batches counts, as in the C++ peer. Both must agree on the torques first.

use std::error::Error;
use std::hint::black_box;
use std::time::Instant;

use nalgebra::SVector;
use steadyarm::arm::{Arm, Serial, SerialParameters};
use steadyarm::robot::Description;

const JOINTS: usize = 7;
const SAMPLES: usize = 64;
const BATCHES: usize = 20;
const CALLS: usize = 20_000;
const TORQUE_TOL: f64 = 1e-9;

/// That dynibo computes with [m/s²].
const GRAVITY: [f64; 3] = [0.0, 0.0, -9.80665];

type Vector = SVector<f64, JOINTS>;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("usage: dynamics-peers robot.urdf")?;
    let arm = ours(&path)?;
    let mut peer = dynibo::Robot::from_urdf(&path)?;
    let samples: Vec<[Vector; 3]> = (0..SAMPLES).map(sample).collect();
    let mut out = [0.0; JOINTS];
    for [q, dq, u] in &samples {
        peer.inverse_dynamics(q.as_slice(), dq.as_slice(), u.as_slice(), &[], &mut out)?;
        let difference = (arm.inverse_dynamics(q, dq, u) - Vector::from(out)).amax();
        if difference > TORQUE_TOL {
            return Err(format!("not the same work: torques {difference:e} N·m apart").into());
        }
    }
    report("steadyarm", "rnea", &samples, |[q, dq, u]| {
        black_box(arm.inverse_dynamics(q, dq, u));
    });
    report("steadyarm", "crba", &samples, |[q, ..]| {
        black_box(arm.mass_matrix(q));
    });
    report("steadyarm", "aba", &samples, |[q, dq, u]| {
        black_box(arm.forward_dynamics(q, dq, u));
    });
    report("steadyarm", "crba+nle", &samples, |[q, dq, _]| {
        black_box(arm.mass_matrix_and_bias(q, dq));
    });
    report("dynibo", "rnea", &samples, |[q, dq, u]| {
        let done =
            peer.inverse_dynamics(q.as_slice(), dq.as_slice(), u.as_slice(), &[], &mut out);
        black_box((done.is_ok(), &out));
    });
    Ok(())
}

fn ours(path: &str) -> Result<Serial<JOINTS>, Box<dyn Error>> {
    let description = Description::from_urdf_file(path, None, None, GRAVITY)?;
    let (links, tip, gravity) = (description.links()?, description.tip, description.gravity);
    Ok(Serial::new(SerialParameters { links, tip, gravity })?.without_friction())
}

/// Positions, velocities and accelerations between −1 and 1, scattered.
fn sample(k: usize) -> [Vector; 3] {
    let entry = |n: usize, seed: f64| (12.9 * k as f64 + 7.7 * n as f64 + seed).sin();
    [0.0, 1.0, 2.0].map(|seed| Vector::from_fn(|n, _| entry(n, seed)))
}

fn report(
    library: &str,
    operation: &str,
    samples: &[[Vector; 3]],
    mut call: impl FnMut(&[Vector; 3]),
) {
    let mut best = f64::INFINITY;
    for _ in 0..BATCHES {
        let start = Instant::now();
        for k in 0..CALLS {
            call(&samples[k % SAMPLES]);
        }
        best = best.min(start.elapsed().as_secs_f64() * 1e9 / CALLS as f64);
    }
    println!("{{\"library\": \"{library}\", \"op\": \"{operation}\", \"ns\": {best:.1}}}");
}

//! What a step of the plant costs beside a step of RK4 on the same arm, in turns and in processor
//! time: medians of ratios.
//!
//! Rows: without friction, with dry and with viscous friction that RK4 alone can follow, and with
//! 1, 3 and 10 % of each joint's largest torque as Coulomb friction (of 100 N·m where none is
//! stated), which is stiff. Linux alone. `cargo bench --bench friction`
#![allow(missing_docs, clippy::unwrap_used, clippy::print_stdout)]

use std::hint::black_box;
use std::ops::ControlFlow;

use steadyarm::arm::{JointFriction, Serial, SerialParameters};
use steadyarm::control::{ComputedTorque, Controller, Gains, NoCompensation, State};
use steadyarm::math::Vector;
use steadyarm::plant::{Plant, Undisturbed};
use steadyarm::reference::{Harmonic, Reference, Sines};
use steadyarm::robot::shipped;
use steadyarm::sim::{Motion, Options, RK4, hold_torque, simulate};

const DT: f64 = 1e-3;
const ROUNDS: usize = 7;
/// A thread's time is counted in ticks of some milliseconds: a turn takes about a hundred of them.
const PASSES: usize = 50;

type ArmPlant<const N: usize> = Plant<N, Serial<N>, Undisturbed>;

fn main() {
    println!("{:<10} {:<20} {:>9} {:>9} {:>6}", "arm", "friction", "RK4", "step", "ratio");
    rows::<7>("panda", [0.0, -0.6, 0.0, -2.0, 0.0, 1.6, 0.8]);
    rows::<6>("ur5e", [0.0, -1.2, 1.5, -0.3, 1.2, 0.0]);
    rows::<6>("puma560", [0.0, 0.8, -2.0, 0.0, 0.5, 0.0]);
}

fn rows<const N: usize>(name: &str, pose: [f64; N]) {
    let file = shipped(name).unwrap();
    let (links, tip) = (file.links().unwrap(), file.tip);
    let arm = Serial::<N>::new(SerialParameters { links, tip, gravity: file.gravity }).unwrap();
    let arm = arm.without_friction();
    let effort = arm.effort_limit();
    let with = |viscous: f64, share: f64, smoothing: f64| {
        let mut parameters = *arm.parameters();
        for (link, effort) in parameters.links.iter_mut().zip(effort) {
            let coulomb = [share * effort.min(100.0); 2];
            link.friction =
                JointFriction { viscous, coulomb, smoothing, ..JointFriction::default() };
        }
        Plant::new(Serial::new(parameters).unwrap(), Undisturbed)
    };
    row(name, "none", &Plant::new(arm, Undisturbed), pose);
    row(name, "0.01 %, not stiff", &with(0.0, 1e-4, 0.5), pose);
    row(name, "viscous", &with(0.05, 0.0, 0.5), pose);
    for share in [0.01, 0.03, 0.1] {
        row(name, &format!("{} %", 100.0 * share), &with(0.0, share, 0.01), pose);
    }
}

/// Motions and torques of a run: 3 s of sines of all joints, tracked at 1 kHz by a controller that
/// knows no friction.
fn motions<const N: usize>(plant: &ArmPlant<N>, pose: [f64; N]) -> Vec<(Motion<N>, Vector<N>)> {
    let harmonic = Harmonic {
        frequency: 2.0,
        sin: core::array::from_fn(|i| if i % 2 == 0 { 0.3 } else { -0.2 }),
        cos: core::array::from_fn(|i| if i % 2 == 0 { 0.1 } else { 0.2 }),
    };
    let path = Sines::new(pose, [harmonic]).unwrap();
    let gains = Gains::new([400.0; N], [40.0; N]).unwrap();
    let nominal = plant.arm.without_friction();
    let controller = Controller::new(ComputedTorque::new(nominal, gains), NoCompensation);
    let q0 = path.at(0.0).q.into();
    let options = Options { duration: 3.0, control_period: Some(DT), q0, ..Options::default() };
    let go_on = |_| ControlFlow::Continue(());
    let mut state = State::new(());
    let run = simulate(plant, &controller, &mut state, &path, &options, go_on).unwrap();
    let row =
        |k: usize| (Motion { q: run.q[k].into(), dq: run.dq[k].into() }, Vector::from(run.tau[k]));
    (0..run.t.len()).map(row).collect()
}

fn row<const N: usize>(name: &str, friction: &str, plant: &ArmPlant<N>, pose: [f64; N]) {
    let motions = motions(plant, pose);
    let time = |step: &dyn Fn(&Motion<N>, &Vector<N>) -> Motion<N>| {
        let start = processor_time();
        for _ in 0..PASSES {
            for (motion, tau) in &motions {
                black_box(step(black_box(motion), tau));
            }
        }
        (processor_time() - start) / (PASSES * motions.len()) as f64
    };
    let mut times = [[0.0; ROUNDS]; 3];
    for round in 0..ROUNDS {
        times[0][round] = time(&|motion, tau| rk4(plant, motion, tau));
        times[1][round] = time(&|motion, tau| hold_torque(plant, motion, tau, 0.0, DT));
        times[2][round] = times[1][round] / times[0][round];
    }
    let [rk4, step, ratio] = times.map(|mut row| {
        row.sort_by(f64::total_cmp);
        row[ROUNDS / 2]
    });
    println!("{name:<10} {friction:<20} {rk4:>6.0} ns {step:>6.0} ns {ratio:>6.3}");
}

/// What this thread has used [ns].
fn processor_time() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap();
    text.split_whitespace().next().unwrap().parse().unwrap()
}

/// A step of RK4 alone.
fn rk4<const N: usize>(plant: &ArmPlant<N>, motion: &Motion<N>, tau: &Vector<N>) -> Motion<N> {
    let applied = plant.applied(tau);
    let mut rates = [Motion::zeros(); 4];
    RK4.stages(DT, motion, 0, &mut rates, |stage, at| {
        plant.acceleration(&at.q, &at.dq, &applied, stage.node * DT)
    });
    motion.plus(DT, &RK4.weights, &rates)
}

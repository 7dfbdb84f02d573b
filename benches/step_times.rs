//! Steps timed one by one: of the two-link arm and of a Panda, over rules, over a dictionary, and
//! through a guard, beside a loop of arithmetic that takes as long. Lines of JSON.
//!
//! The samples are those of a run. Of each step the minimum over repeats is taken, from the same
//! state: that is what the arithmetic takes, without interrupts. p50 and p99.99 over the steps are
//! the claim; the maximum is what one unlucky step took. `benches/step_times.py` keeps them.
#![allow(clippy::unwrap_used, clippy::print_stdout, unsafe_code)]

use std::hint::black_box;

use steadyarm::arm::{Arm, Serial};
use steadyarm::control::{
    Adaptation, Brake, Compensator, ComputedTorque, Controller, FuzzyCompensator, FuzzyParameters,
    Gains, Guard, GuardParameters, GuardState, KernelCompensator, KernelParameters, State,
};
use steadyarm::fuzzy::{Axis, Form, FuzzyBasis, KernelBasis};
use steadyarm::math::Vector;
use steadyarm::paper::{self, CENTERS, WIDTH};
use steadyarm::plant::{Plant, Undisturbed};
use steadyarm::reference::{Harmonic, Reference, Setpoint, Sines};
use steadyarm::robot::shipped;
use steadyarm::sim::{Motion, hold_torque};

#[path = "../tests/common/mod.rs"]
mod common;

const STEPS: usize = 20_000;
const REPEATS: usize = 15;
const PERIOD: f64 = 1e-3;

type Seen<const N: usize> = (Vector<N>, Vector<N>, Setpoint<N>);

/// Ticks of a clock that costs a few nanoseconds to read: the counter of the processor.
#[cfg(target_arch = "x86_64")]
fn ticks() -> u64 {
    // SAFETY: every x86-64 processor has the instruction, and it touches no memory.
    unsafe { core::arch::x86_64::_rdtsc() }
}

#[cfg(not(target_arch = "x86_64"))]
fn ticks() -> u64 {
    use std::sync::OnceLock;
    static START: OnceLock<std::time::Instant> = OnceLock::new();
    START.get_or_init(std::time::Instant::now).elapsed().as_nanos() as u64
}

/// Length of a tick [ns].
fn tick() -> f64 {
    let (clock, start) = (std::time::Instant::now(), ticks());
    std::thread::sleep(std::time::Duration::from_millis(200));
    clock.elapsed().as_nanos() as f64 / (ticks() - start) as f64
}

/// Ticks of each call of `step`, the minimum over repeats from a fresh `start`.
fn least<T>(mut start: impl FnMut() -> T, mut step: impl FnMut(&mut T, usize)) -> Vec<u64> {
    let mut least = vec![u64::MAX; STEPS];
    for _ in 0..REPEATS {
        let mut state = start();
        for (k, least) in least.iter_mut().enumerate() {
            let begin = ticks();
            step(&mut state, k);
            *least = (*least).min(ticks() - begin);
        }
    }
    least.sort_unstable();
    least
}

fn say(figure: &str, sorted: &[u64], tick: f64) -> f64 {
    let at = |share: f64| sorted[((STEPS - 1) as f64 * share).ceil() as usize] as f64 * tick;
    let (p50, p9999, max) = (at(0.5), at(0.9999), at(1.0));
    println!(
        "{{\"figure\": \"{figure}\", \"p50\": {p50:.0}, \"p99.99\": {p9999:.0}, \"max\": {max:.0}}}"
    );
    p50
}

/// A loop of arithmetic about as long as `ns`.
fn dummy(figure: &str, ns: f64, tick: f64) {
    let spin = |turns: u64| (0..turns).fold(1.0_f64, |x, _| black_box(x * 1.000_000_1));
    let one = least(|| (), |(), _| _ = black_box(spin(100)));
    let turns = 100.0 * ns / (one[STEPS / 2] as f64 * tick);
    let times = least(|| (), |(), _| _ = black_box(spin(turns as u64)));
    say(&format!("{figure}, a dummy loop as long"), &times, tick);
}

/// What a controller sees in a run.
fn run<const N: usize, A, C, S>(
    controller: &Controller<N, ComputedTorque<N, A>, C>,
    start: &State<N, S>,
    plant: &Plant<N, A, Undisturbed>,
    path: &impl Reference<N>,
) -> Vec<Seen<N>>
where
    A: Arm<N>,
    C: Compensator<N, S>,
    S: Clone,
{
    let (mut state, mut seen) = (start.clone(), Vec::with_capacity(STEPS));
    let first = path.at(0.0);
    let mut motion = Motion { q: first.q, dq: first.dq };
    for k in 0..STEPS {
        let t = k as f64 * PERIOD;
        let desired = path.at(t);
        seen.push((motion.q, motion.dq, desired));
        let command = controller.step(&mut state, &motion.q, &motion.dq, &desired, PERIOD).unwrap();
        motion = hold_torque(plant, &motion, &command.tau, t, PERIOD);
    }
    seen
}

/// A controller alone and guarded, on the samples of its run.
fn report<const N: usize, A, C, S>(
    name: &str,
    controller: Controller<N, ComputedTorque<N, A>, C>,
    start: &State<N, S>,
    plant: &Plant<N, A, Undisturbed>,
    path: &impl Reference<N>,
    tick: f64,
) where
    A: Arm<N>,
    C: Compensator<N, S>,
    S: Clone,
{
    let seen = run(&controller, start, plant, path);
    let times = least(
        || start.clone(),
        |state, k| {
            let (q, dq, desired) = black_box(&seen[k]);
            black_box(controller.step(state, q, dq, desired, PERIOD).unwrap());
        },
    );
    let usual = say(name, &times, tick);
    dummy(name, usual, tick);
    let all = [1e3; N];
    let brake = Brake { bandwidth: [20.0; N], deceleration: all };
    let limits = GuardParameters {
        position_limits: [[-10.0, 10.0]; N],
        velocity_limit: all,
        effort_limit: all,
        effort_rate_limit: [1e7; N],
        power_limit: [1e6; N],
        envelope: [10.0; N],
        ..GuardParameters::new(PERIOD, brake)
    };
    let guard = Guard::new(controller, limits).unwrap();
    let times = least(
        || GuardState::new(start.clone()),
        |state, k| {
            let (q, dq, desired) = black_box(&seen[k]);
            black_box(guard.step(state, None, (q, dq), desired, PERIOD));
        },
    );
    say(&format!("{name}, guarded"), &times, tick);
}

fn kernel<const N: usize>(gains: &Gains<N>, capacity: usize, gain: f64) -> KernelCompensator<N> {
    let axis = Axis { centers: &CENTERS, widths: &[WIDTH] };
    let basis = KernelBasis::new(true, &vec![axis; 2 * N]).unwrap();
    let adaptation = Adaptation { gain: [gain; N], ..Adaptation::default() };
    let parameters = FuzzyParameters { adaptation, ..FuzzyParameters::default() };
    let kernel = KernelParameters { capacity, merge_tolerance: 0.05 };
    KernelCompensator::new(basis, gains, parameters, kernel).unwrap()
}

fn two_link(tick: f64) {
    let (plant, path) = (Plant::new(paper::actual().unwrap(), Undisturbed), common::reference());
    for (name, form) in
        [("two-link, 625 rules", Form::Grid), ("two-link, per joint", Form::PerJoint { joints: 2 })]
    {
        let controller = common::adaptive(form, false, 7.0);
        let start = common::fresh(&controller);
        report(name, controller, &start, &plant, &path, tick);
    }
    let compensator = kernel(&paper::gains().unwrap(), 64, 70.0);
    let start = State::new(compensator.state());
    let controller = Controller::new(common::nominal_law(), compensator);
    report("two-link, dictionary of 64", controller, &start, &plant, &path, tick);
}

fn panda(tick: f64) {
    let arm: Serial<7> = shipped("panda").unwrap().arm().unwrap();
    let rest = [0.0, -0.6, 0.0, -2.0, 0.0, 1.6, 0.8];
    let harmonic = Harmonic { frequency: 1.0, sin: [0.2; 7], cos: [0.0; 7] };
    let path = Sines::new(rest, vec![harmonic]).unwrap();
    let gains = Gains::new([100.0; 7], [20.0; 7]).unwrap();
    let plant = Plant::new(arm, Undisturbed);
    let axis = Axis { centers: &CENTERS, widths: &[WIDTH] };
    let basis = FuzzyBasis::new(Form::PerJoint { joints: 7 }, true, &[axis; 14]).unwrap();
    let adaptation = Adaptation { gain: [7.0; 7], ..Adaptation::default() };
    let parameters = FuzzyParameters { adaptation, ..FuzzyParameters::default() };
    let compensator = FuzzyCompensator::new(basis, &gains, parameters).unwrap();
    let start = State::new(compensator.state());
    let controller = Controller::new(ComputedTorque::new(arm, gains), compensator);
    report("Panda, per joint", controller, &start, &plant, &path, tick);
    let compensator = kernel(&gains, 256, 7.0);
    let start = State::new(compensator.state());
    let controller = Controller::new(ComputedTorque::new(arm, gains), compensator);
    report("Panda, dictionary of 256", controller, &start, &plant, &path, tick);
}

fn main() {
    let tick = tick();
    two_link(tick);
    panda(tick);
}

//! The rivals: each against its property, and all of them against a program written apart.

mod adaptive;
mod bandwidth;
mod conditions;
mod modern_robotics;
mod networks;
mod recommended;
mod windup;

use std::ops::ControlFlow;

use steadyarm::arm::{Arm, Parametric, TwoLink};
use steadyarm::control::{
    Compensator, ComputedTorque, Controller, Dynamic, DynamicState, Feedback, Law, NoCompensation,
    State,
};
use steadyarm::laws::{
    AdaptiveParameters, DisturbanceObserver, HInfinity, Inertia, Integral, Mismatch,
    MomentumObserver, Passive, PdGravity, Rise, Robust, SlidingMode, SuperTwisting, TimeDelay,
    TimeDelayState,
};
use steadyarm::math::Vector;
use steadyarm::paper;
use steadyarm::plant::{Plant, Undisturbed};
use steadyarm::reference::{Harmonic, Quintic, Reference, Sines};
use steadyarm::sim::{Options, Run, Status, simulate};

use crate::chains;
use crate::random::Random;

/// The paper's plant, sampled.
fn run<L, C, S>(law: L, compensator: C, memory: S, period: f64, duration: f64) -> Run<2>
where
    L: Law<2>,
    C: Compensator<2, S>,
{
    let (plant, reference) = (paper::plant().unwrap(), paper::reference().unwrap());
    let controller = Controller::new(law, compensator);
    let mut state = State::new(memory);
    let dt = period.min(1e-3);
    let options = Options { duration, dt, control_period: Some(period), ..Options::default() };
    let go_on = |_| ControlFlow::Continue(());
    simulate(&plant, &controller, &mut state, &reference, &options, go_on).unwrap()
}

/// RMS of e₁ and e₂ over the second half [rad], and max |τ₁| [N·m].
fn figures(run: &Run<2>) -> [f64; 3] {
    assert_eq!(run.status, Status::Finished);
    let half = &run.e[run.e.len() / 2..];
    let rms = |n: usize| {
        let sum: f64 = half.iter().map(|e| e[n] * e[n]).sum();
        (sum / half.len() as f64).sqrt()
    };
    let largest = run.tau.iter().fold(0.0, |max, tau| f64::max(max, tau[0].abs()));
    [rms(0), rms(1), largest]
}

fn plain<L: Law<2>>(law: L) -> [f64; 3] {
    figures(&run(law, NoCompensation, (), 1e-3, 40.0))
}

fn with<L: Law<2>, D: Dynamic<2, 2>>(law: L, dynamic: D) -> [f64; 3] {
    figures(&run(law, dynamic, DynamicState::new(), 1e-3, 40.0))
}

fn nominal() -> TwoLink {
    paper::nominal().unwrap()
}

fn computed<F: Feedback<2>>(feedback: F) -> ComputedTorque<2, TwoLink, F> {
    ComputedTorque::new(nominal(), feedback)
}

/// Within half a unit of the last printed digit.
fn printed(name: &str, got: [f64; 3], wanted: [f64; 3], digits: [f64; 3]) {
    for ((got, wanted), unit) in got.iter().zip(wanted).zip(digits) {
        assert!((got - wanted).abs() <= 0.5001 * unit, "{name}: {got} instead of {wanted}");
    }
}

/// Ends at rest at this pose, gets there within the duration.
fn rest(q: [f64; 2]) -> Quintic<2> {
    Quintic::new(q, q, 0.0, 1.0).unwrap()
}

fn both(x: f64) -> [f64; 2] {
    [x; 2]
}

/// Towards a pose at rest with a constant push, sampled.
fn pushed<L: Law<2>, C: Compensator<2, S>, S>(law: L, compensator: C, memory: S) -> Run<2> {
    let push = Sines::new([-1.5, 0.8], [Harmonic { frequency: 1.0, sin: [0.0; 2], cos: [0.0; 2] }]);
    let plant = Plant::new(paper::actual().unwrap(), push.unwrap());
    let controller = Controller::new(law, compensator);
    let mut state = State::new(memory);
    let options = Options { duration: 12.0, control_period: Some(1e-3), ..Options::default() };
    let go_on = |_| ControlFlow::Continue(());
    simulate(&plant, &controller, &mut state, &rest([0.4, -0.3]), &options, go_on).unwrap()
}

fn last_error(run: &Run<2>) -> f64 {
    assert_eq!(run.status, Status::Finished);
    run.e.last().unwrap().iter().fold(0.0, |max, e| f64::max(max, e.abs()))
}

/// A constant push leaves no error where something integrates, and one without.
#[test]
fn a_constant_push_leaves_an_error_only_without_an_integral() {
    let (gains, integral) = Integral::with_bandwidth([6.0; 2]).unwrap();
    let computed = computed(gains);
    assert!(last_error(&pushed(computed, NoCompensation, ())) > 1e-3);
    assert!(last_error(&pushed(computed, integral, DynamicState::new())) < 1e-9);
    let observer = DisturbanceObserver::new(nominal(), [20.0; 2]).unwrap();
    assert!(last_error(&pushed(computed, observer, DynamicState::new())) < 1e-9);
    let momentum = MomentumObserver::new(nominal(), 20.0).unwrap();
    assert!(last_error(&pushed(computed, momentum, DynamicState::new())) < 1e-9);
    let inertia = Inertia::new(nominal(), 1.0).unwrap();
    let law = ComputedTorque::new(inertia, gains);
    let delayed = pushed(law, TimeDelay { arm: inertia }, TimeDelayState::new());
    assert!(last_error(&delayed) < 1e-9);
}

/// ½q̇ᵀMq̇ + ½eᵀK_P e falls from sample to sample on the way to a pose, whatever the inertia.
#[test]
fn pd_with_gravity_takes_energy_out_on_the_way_to_a_pose() {
    let (stiffness, actual) = ([40.0, 25.0], paper::actual().unwrap());
    let law = PdGravity::new(actual, stiffness, [6.0, 4.0]).unwrap();
    let plant = Plant::new(actual, Undisturbed);
    let controller = Controller::new(law, NoCompensation);
    let options = Options { duration: 20.0, ..Options::default() };
    let mut state = State::new(());
    let run = simulate(&plant, &controller, &mut state, &rest([0.8, -1.1]), &options, |_| {
        ControlFlow::Continue(())
    });
    let run = run.unwrap();
    let energy = |k: usize| {
        let kinetic = actual.kinetic_energy(&run.q[k].into(), &run.dq[k].into());
        kinetic + (0..2).map(|n| 0.5 * stiffness[n] * run.e[k][n] * run.e[k][n]).sum::<f64>()
    };
    let rises = (1..run.q.len()).filter(|&k| energy(k) > energy(k - 1) * (1.0 + 1e-12)).count();
    assert_eq!(rises, 0);
    assert!(energy(run.q.len() - 1) < 1e-6 * energy(0));
}

/// With M = 2 M₀ the loop of time-delay control is stable below M̄ = 4 M₀: ‖I − M⁻¹M̄‖ < 1.
#[test]
fn time_delay_control_is_stable_just_below_its_limit_and_not_above() {
    let status = |share: f64| {
        let inertia = Inertia::new(nominal(), share).unwrap();
        let law = ComputedTorque::new(inertia, paper::gains().unwrap());
        let run = run(law, TimeDelay { arm: inertia }, TimeDelayState::new(), 1e-3, 20.0);
        run.status == Status::Finished && figures(&run)[0] < 0.1
    };
    assert!(status(3.9) && !status(4.1));
}

/// s is inside its layer after |s(0)|/η, and |e| then ends within φ/Λ.
#[test]
fn sliding_mode_reaches_its_layer_and_stays_within_it() {
    let (lambda, layer) = (3.0, 0.1);
    let feedback = SlidingMode {
        lambda: both(lambda),
        gain: both(40.0),
        layer: both(layer),
        linear: both(0.0),
    };
    let run = run(computed(feedback), NoCompensation, (), 1e-3, 20.0);
    let s = |k: usize, n: usize| run.de[k][n] + lambda * run.e[k][n];
    let outside = (0..run.e.len()).rev().find(|&k| s(k, 0).abs().max(s(k, 1).abs()) > layer);
    let reached = run.t[outside.unwrap() + 1];
    assert!(reached < 1.5, "{reached}");
    // The rest of the start has died away: exp(-3 · 6).
    let late = run.t.iter().position(|t| *t > reached + 6.0).unwrap();
    for e in run.e[late..].iter().flatten() {
        assert!(e.abs() <= layer / lambda, "{e}");
    }
}

/// How the error goes with the period: order 1 for RISE and time-delay control, 2 for
/// super-twisting; sliding mode's layer does not depend on it.
#[test]
fn errors_fall_with_the_period_in_the_order_of_the_law() {
    let order = |of: &dyn Fn(f64) -> Run<2>| {
        let [coarse, fine] = [2e-3, 1e-3].map(|period| figures(&of(period))[1]);
        (coarse / fine).log2()
    };
    let gains = paper::gains().unwrap();
    let rise = Rise::new(both(3.0), both(3.0), both(10.0), both(10.0)).unwrap();
    let of_rise = order(&|h| run(computed(rise), rise, DynamicState::new(), h, 30.0));
    assert!((0.7..1.4).contains(&of_rise), "{of_rise}");
    let inertia = Inertia::new(nominal(), 1.0).unwrap();
    let law = ComputedTorque::new(inertia, gains);
    let delayed = |h| run(law, TimeDelay { arm: inertia }, TimeDelayState::new(), h, 30.0);
    let of_delay = order(&delayed);
    assert!((0.8..1.3).contains(&of_delay), "{of_delay}");
    let twisting = SuperTwisting::new(both(3.0), both(8.0), both(25.0)).unwrap();
    let of_twisting = order(&|h| run(computed(twisting), twisting, DynamicState::new(), h, 30.0));
    assert!((1.6..2.4).contains(&of_twisting), "{of_twisting}");
    let sliding =
        SlidingMode { lambda: both(3.0), gain: both(20.0), layer: both(0.1), linear: both(2.0) };
    let of_sliding = order(&|h| run(computed(sliding), NoCompensation, (), h, 30.0));
    assert!(of_sliding.abs() < 0.1, "{of_sliding}");
}

/// RMS goes down with the layer, as √(ρε/2) bounds.
#[test]
fn the_robust_laws_error_goes_down_with_its_layer() {
    let gains = paper::gains().unwrap();
    let rms =
        |layer| plain(computed(Robust::new(gains, 10.0, f64::INFINITY, 20.0, layer).unwrap()));
    let [wide, thin] = [0.4, 0.1].map(rms);
    assert!(thin[0] < 0.5 * wide[0] && thin[1] < 0.5 * wide[1], "{wide:?} {thin:?}");
}

/// ∫|s|²-type bound: from rest on the path, ∫xᵀQx ≤ γ²∫|ρ|² with the mismatch ρ that acted.
#[test]
fn the_h_infinity_gain_is_at_most_gamma() {
    let (gains, q, gamma) = (paper::gains().unwrap(), 10.0, 0.8);
    let feedback = HInfinity::new(gains, q, gamma, 2.0 * gamma * gamma).unwrap();
    let (plant, reference) = (paper::plant().unwrap(), paper::reference().unwrap());
    let controller = Controller::new(computed(feedback), NoCompensation);
    let first = reference.at(0.0);
    let options =
        Options { q0: first.q.into(), dq0: first.dq.into(), duration: 20.0, ..Options::default() };
    let go_on = |_| ControlFlow::Continue(());
    let mut state = State::new(());
    let run = simulate(&plant, &controller, &mut state, &reference, &options, go_on).unwrap();
    let (mut cost, mut supplied) = (0.0, 0.0);
    for k in 0..run.e.len() {
        for n in 0..2 {
            cost += q * (run.e[k][n] * run.e[k][n] + run.de[k][n] * run.de[k][n]);
            supplied += gamma * gamma * run.rho[k][n] * run.rho[k][n];
        }
    }
    assert!(cost > 0.0 && cost <= supplied, "{cost} {supplied}");
}

/// V = ½sᵀMs + ½(θ̃ − θ̃*)ᵀΓ⁻¹(θ̃ − θ̃*) falls at the rate sᵀK_D s, so that V(0) − V(T) is its
/// integral; with M = 2 M₀, θ̃* = θ₀.
#[test]
fn what_adaptive_parameters_store_falls_at_the_rate_of_the_damping() {
    let (lambda, damping, gain) = (both(5.0), [20.0, 12.0], [10.0, 4.0, 6.0, 1.0, 1.0]);
    let (actual, reference) = (paper::actual().unwrap(), paper::reference().unwrap());
    let passive = Passive::new(nominal(), lambda, damping).unwrap();
    let adaptive = AdaptiveParameters::new(nominal(), lambda, gain).unwrap();
    let controller = Controller::new(passive, adaptive);
    let plant = Plant::new(actual, Undisturbed);
    let stored = |run: &Run<2>, k: usize, z: &Vector<5>| {
        let s = Vector::<2>::from_fn(|n, _| run.de[k][n] + lambda[n] * run.e[k][n]);
        let off = z - nominal().inertial_parameters();
        let of_parameters: f64 = (0..5).map(|k| off[k] * off[k] / gain[k]).sum();
        0.5 * (s.dot(&(actual.mass_matrix(&run.q[k].into()) * s)) + of_parameters)
    };
    let mut state = State::new(DynamicState::<5>::new());
    let options = Options { duration: 3.0, dt: 5e-4, ..Options::default() };
    let go_on = |_| ControlFlow::Continue(());
    let run = simulate(&plant, &controller, &mut state, &reference, &options, go_on).unwrap();
    let power = |k: usize| {
        (0..2).map(|n| damping[n] * (run.de[k][n] + lambda[n] * run.e[k][n]).powi(2)).sum::<f64>()
    };
    let last = run.e.len() - 1;
    // Simpson's rule.
    let weight = |k: usize| if k % 2 == 1 { 4.0 } else { 2.0 };
    let inner: f64 = (1..last).map(|k| weight(k) * power(k)).sum();
    let lost = (power(0) + inner + power(last)) * options.dt / 3.0;
    let z = *state.compensator().z().unwrap();
    let fallen = stored(&run, 0, &Vector::zeros()) - stored(&run, last, &z);
    assert!(lost > 1.0 && (fallen - lost).abs() < 1e-6 * lost, "{fallen} {lost}");
}

/// Y π = M q̈_r + C q̇_r + G for a chain of any kind of joints, whatever the motion.
#[test]
fn slotine_lis_regressor_times_the_parameters_is_the_law() {
    let mut random = Random(5);
    for _ in 0..40 {
        let arm = chains::chain::<4>(&mut random);
        let mut vector = || chains::vector::<4>(&mut random, 3.0);
        let [q, dq, dq_r, ddq_r] = [vector(), vector(), vector(), vector()];
        let y = arm.slotine_li_regressor(&q, &dq, &dq_r, &ddq_r);
        let rotors = Vector::<4>::from_fn(|n, _| arm.links()[n].armature * ddq_r[n]);
        let got = y * Parametric::inertial_parameters(&arm) + rotors;
        let wanted = arm.slotine_li(&q, &dq, &dq_r, &ddq_r);
        assert!((got - wanted).norm() <= 1e-10 * (1.0 + wanted.norm()), "{got} {wanted}");
    }
    let arm = paper::actual().unwrap().with_gravity(9.81).unwrap();
    for _ in 0..40 {
        let mut vector = || chains::vector::<2>(&mut random, 3.0);
        let [q, dq, dq_r, ddq_r] = [vector(), vector(), vector(), vector()];
        let got = arm.slotine_li_regressor(&q, &dq, &dq_r, &ddq_r) * arm.inertial_parameters();
        let wanted = arm.mass_matrix(&q) * ddq_r + arm.coriolis(&q, &dq) * dq_r + arm.gravity(&q);
        assert!((got - wanted).norm() <= 1e-12 * (1.0 + wanted.norm()));
    }
}

fn refused<T>(result: steadyarm::Result<T>) -> String {
    result.err().map_or_else(|| "accepted".into(), |error| error.to_string())
}

#[test]
fn what_cannot_work_is_refused_by_name() {
    let gains = paper::gains().unwrap();
    assert_eq!(
        refused(Integral::new([44.0, 10.0], &gains)),
        "ki[0]: got 44, wants less than kp·kv of the joint, else the loop is not stable"
    );
    let sliding =
        SlidingMode { lambda: both(3.0), gain: both(20.0), layer: both(0.01), linear: both(2.0) };
    let too_thin = refused(sliding.suits(1e-3, 0.0));
    assert!(too_thin.starts_with("layer[0]: got 0.01, wants a wider layer"), "{too_thin}");
    assert_eq!(refused(sliding.suits(1e-4, 0.0)), "accepted");
    let mismatch = Mismatch { inertia: 0.5, acceleration: 20.0, disturbance: 5.0 };
    let weak = refused(sliding.covers(&mismatch, 1.0));
    assert!(weak.starts_with("gain[0]: got 20, wants more than the mismatch"), "{weak}");
    let beyond = Mismatch { inertia: 1.0, ..mismatch };
    assert!(refused(sliding.covers(&beyond, 1.0)).starts_with("inertia: got 1, wants"));
    let momentum = MomentumObserver::new(nominal(), 600.0).unwrap();
    assert!(refused(momentum.suits(1e-3, 0.0)).starts_with("pole: got 600, wants a slower pole"));
    let observer = DisturbanceObserver::new(nominal(), [500.0; 2]).unwrap();
    let fast = refused(observer.suits(1e-3, 0.0));
    assert!(fast.starts_with("gain: got"), "{fast}");
    assert!(
        refused(Rise::new(both(0.5), both(3.0), both(1.0), both(1.0))).starts_with("alpha1[0]")
    );
    let twisting = SuperTwisting::new(both(3.0), both(8.0), both(25.0)).unwrap();
    assert_eq!(refused(twisting.covers(20.0)), "accepted");
    assert!(refused(twisting.covers(25.0)).starts_with("k2[0]: got 25, wants"));
    let inertia = Inertia::new(nominal(), 1.0).unwrap();
    let law = ComputedTorque::new(inertia, gains);
    let (plant, reference) = (paper::plant().unwrap(), paper::reference().unwrap());
    let delayed = Controller::new(law, TimeDelay { arm: inertia });
    let mut state = State::new(TimeDelayState::new());
    let go_on = |_| ControlFlow::Continue(());
    let run = simulate(&plant, &delayed, &mut state, &reference, &Options::default(), go_on);
    assert!(refused(run).starts_with("control_period: got None, wants a period"));
    // γ below half of √r, and Q too large for it.
    assert!(refused(HInfinity::new(gains, 1e3, 0.1, 1.0)).starts_with("gamma: got 0.1"));
    assert!(refused(HInfinity::new(gains, 1e3, 1.0, 2.0)) == "accepted");
}

/// Figures of a program written apart, in Python: RMS of both joints, largest torque.
#[test]
fn rivals_on_the_papers_plant_are_those_of_a_program_written_apart() {
    let gains = paper::gains().unwrap();
    let digits = [1e-4, 1e-4, 1.0];
    let pd = PdGravity::new(nominal(), [100.0; 2], [30.0; 2]).unwrap();
    printed("PD", plain(pd), [0.0743, 0.0237, 68.0], digits);
    let observer = DisturbanceObserver::new(nominal(), [50.0; 2]).unwrap();
    printed("observer", with(computed(gains), observer), [0.0147, 0.0047, 17.0], digits);
    let momentum = MomentumObserver::new(nominal(), 50.0).unwrap();
    printed("momentum", with(computed(gains), momentum), [0.0068, 0.0114, 22.0], digits);
    let sliding =
        SlidingMode { lambda: both(3.0), gain: both(20.0), layer: both(0.1), linear: both(2.0) };
    printed("sliding", plain(computed(sliding)), [0.0033, 0.0075, 60.0], digits);
    let robust = Robust::new(gains, 10.0, 1.0, 20.0, 0.1).unwrap();
    printed("robust", plain(computed(robust)), [0.0072, 0.0178, 66.0], digits);
    let rise = Rise::new(both(3.0), both(3.0), both(10.0), both(10.0)).unwrap();
    printed("RISE", with(computed(rise), rise), [0.0005, 0.0006, 25.0], digits);
    let inertia = Inertia::new(nominal(), 1.0).unwrap();
    let law = ComputedTorque::new(inertia, gains);
    let delayed = run(law, TimeDelay { arm: inertia }, TimeDelayState::new(), 1e-3, 40.0);
    printed("time delay", figures(&delayed), [0.0004, 0.0006, 30.0], digits);
    let (lambda, damping) = (both(5.0), both(20.0));
    let passive = Passive::new(nominal(), lambda, damping).unwrap();
    let adaptive = AdaptiveParameters::new(nominal(), lambda, [10.0; 5]).unwrap();
    let adapted = figures(&run(passive, adaptive, DynamicState::<5>::new(), 1e-3, 40.0));
    // 0.00565: what the order of the period's steps is worth, half a period is 3e-5.
    printed("Slotine-Li", adapted, [0.0057, 0.0081, 100.0], [1.1e-4, 1e-4, 1.0]);
    let twisting = SuperTwisting::new(both(3.0), both(8.0), both(25.0)).unwrap();
    let tight = [1e-7, 1e-6, 1.0];
    printed("super-twisting", with(computed(twisting), twisting), [8e-7, 1e-6, 27.0], tight);
}

//! Conditions: what `suits`, `covers` and the constructors from a bandwidth refuse, and that what
//! they accept is stable.

use std::ops::ControlFlow;

use steadyarm::control::{
    Compensator, ComputedTorque, Controller, DynamicState, Gains, Inputs, Law, NoCompensation,
    State,
};
use steadyarm::fuzzy::{Axis, Form, FuzzyBasis};
use steadyarm::laws::{
    AdaptiveComputedTorque, AdaptiveParameters, DisturbanceObserver, HInfinity, Inertia, Integral,
    Mismatch, MomentumObserver, Pace, Passive, PassiveFuzzy, PdGravity, RbfNetwork, Rise, Robust,
    SlidingMode, SuperTwisting, TimeDelay, TimeDelayState,
};
use steadyarm::paper;
use steadyarm::sim::{Options, simulate};

use super::{both, figures, refused};

const PERIOD: f64 = 1e-3;

/// A thousand times the bandwidth at 1 kHz, and what a mismatch does not allow.
#[test]
fn a_bandwidth_that_is_too_high_is_refused_by_each_laws_own_condition() {
    let (p, arm) = ([1000.0; 2], paper::nominal().unwrap());
    let mismatch = Mismatch { inertia: 0.5, acceleration: 5.0, disturbance: 5.0 };
    let too_fast = |result: steadyarm::Result<()>, parameter: &str| {
        let said = refused(result);
        assert!(said.starts_with(parameter), "{parameter}: {said}");
    };
    too_fast(Gains::with_bandwidth(p).unwrap().suits(PERIOD, 0.0), "kv[0]: got 2000");
    too_fast(PdGravity::with_bandwidth(arm, p).unwrap().suits(PERIOD, 0.0), "damping: got");
    let sliding = SlidingMode::with_bandwidth(p, &mismatch).unwrap();
    too_fast(sliding.suits(PERIOD, 0.0), "layer[0]");
    too_fast(Robust::with_bandwidth(p, &mismatch).unwrap().suits(PERIOD, 0.0), "layer[0]: got 3");
    too_fast(HInfinity::with_bandwidth(p).unwrap().suits(PERIOD, 0.0), "kv[0]: got 3000");
    let twisting = SuperTwisting::with_bandwidth(p, &mismatch).unwrap();
    too_fast(twisting.suits(PERIOD, 0.0), "k1[0]: got 15");
    too_fast(Rise::with_bandwidth(p, &mismatch).unwrap().suits(PERIOD, 0.0), "ks[0]: got 3000");
    too_fast(Passive::with_bandwidth(arm, p).unwrap().suits(PERIOD, 0.0), "damping[0]");
    let observer = DisturbanceObserver::with_bandwidth(arm, p).unwrap();
    too_fast(observer.suits(PERIOD, 0.0), "gain: got");
    let momentum = MomentumObserver::with_bandwidth(arm, 1000.0).unwrap();
    too_fast(momentum.suits(PERIOD, 0.0), "pole: got 1000");
    let delayed = Inertia::with_bandwidth::<2>(arm, 1000.0, PERIOD, 0.0);
    too_fast(delayed.map(drop), "bandwidth: got 3000");
    // A delay counts as the period does.
    let gains = Gains::with_bandwidth([200.0; 2]).unwrap();
    assert_eq!(refused(gains.suits(PERIOD, 0.0)), "accepted");
    too_fast(gains.suits(PERIOD, 1.0), "kv[0]: got 400");
    let (gains, integral) = Integral::with_bandwidth([10.0; 2]).unwrap();
    let far = Mismatch { inertia: 0.9, ..mismatch };
    too_fast(integral.covers(&gains, &far), "ki[0]: got 1000");
    let whole = Inertia::new(arm, 1.5).unwrap();
    too_fast(whole.covers(&mismatch), "share: got 1.5");
}

/// The highest bandwidth that a condition accepts, a thousandth below it.
fn edge(suits: impl Fn(f64) -> steadyarm::Result<()>) -> f64 {
    let (mut low, mut high) = (1.0, 1e4);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if suits(middle).is_ok() { low = middle } else { high = middle }
    }
    0.999 * low
}

/// The paper's plant in a loop of 200 Hz: the arm has twice the inertia of the model.
fn slow<L: Law<2>, C: Compensator<2, S>, S>(name: &str, p: f64, law: L, compensator: C, memory: S) {
    let (plant, reference) = (paper::plant().unwrap(), paper::reference().unwrap());
    let options = Options { duration: 20.0, control_period: Some(SLOW), ..Options::default() };
    let (controller, mut state) = (Controller::new(law, compensator), State::new(memory));
    let go_on = |_| ControlFlow::Continue(());
    let run = simulate(&plant, &controller, &mut state, &reference, &options, go_on).unwrap();
    let [first, second, _] = figures(&run);
    assert!(first.max(second) < 0.06, "{name} at {p}: {first} {second}");
}

const SLOW: f64 = 5e-3;

/// Each at the highest bandwidth that its own condition accepts for 5 ms.
#[test]
fn what_a_condition_accepts_is_stable() {
    let (arm, none) = (paper::nominal().unwrap(), NoCompensation);
    let mismatch = Mismatch { inertia: 0.5, acceleration: 5.0, disturbance: 5.0 };
    let computed = |gains: Gains<2>| ComputedTorque::new(arm, gains);
    let of_gains = |p: f64| Gains::with_bandwidth(both(p)).unwrap();
    let top = edge(|p| of_gains(p).suits(SLOW, 0.0));
    slow("computed torque", top, computed(of_gains(top)), none, ());
    let of_pid = |p: f64| Integral::with_bandwidth(both(p)).unwrap();
    let p = edge(|p| of_pid(p).0.suits(SLOW, 0.0));
    slow("PID", p, computed(of_pid(p).0), of_pid(p).1, DynamicState::new());
    let pd = |p: f64| PdGravity::with_bandwidth(arm, both(p)).unwrap();
    let p = edge(|p| pd(p).suits(SLOW, 0.0));
    slow("PD", p, pd(p), none, ());
    let passive = |p: f64| Passive::with_bandwidth(arm, both(p)).unwrap();
    let p = edge(|p| passive(p).suits(SLOW, 0.0));
    slow("passive", p, passive(p), none, ());
    let sliding = |p: f64| SlidingMode::with_bandwidth(both(p), &mismatch).unwrap();
    let p = edge(|p| sliding(p).suits(SLOW, 0.0));
    slow("sliding", p, ComputedTorque::new(arm, sliding(p)), none, ());
    let robust = |p: f64| Robust::with_bandwidth(both(p), &mismatch).unwrap();
    let p = edge(|p| robust(p).suits(SLOW, 0.0));
    slow("robust", p, ComputedTorque::new(arm, robust(p)), none, ());
    let h_infinity = |p: f64| HInfinity::with_bandwidth(both(p)).unwrap();
    let p = edge(|p| h_infinity(p).suits(SLOW, 0.0));
    slow("H infinity", p, ComputedTorque::new(arm, h_infinity(p)), none, ());
    let twisting = |p: f64| SuperTwisting::with_bandwidth(both(p), &mismatch).unwrap();
    let p = edge(|p| twisting(p).suits(SLOW, 0.0));
    slow("twisting", p, ComputedTorque::new(arm, twisting(p)), twisting(p), DynamicState::new());
    let rise = |p: f64| Rise::with_bandwidth(both(p), &mismatch).unwrap();
    let p = edge(|p| rise(p).suits(SLOW, 0.0));
    slow("RISE", p, ComputedTorque::new(arm, rise(p)), rise(p), DynamicState::new());
    let delayed = |p: f64| Inertia::with_bandwidth::<2>(arm, p, SLOW, 0.0);
    let p = edge(|p| delayed(p).map(drop));
    let (gains, inertia) = delayed(p).unwrap();
    let law = ComputedTorque::new(inertia, gains);
    slow("time delay", p, law, TimeDelay { arm: inertia }, TimeDelayState::new());
    let observer = |p: f64| DisturbanceObserver::with_bandwidth(arm, both(p)).unwrap();
    let p = edge(|p| observer(p).suits(SLOW, 0.0));
    slow("disturbance", p, computed(of_gains(top)), observer(p), DynamicState::new());
    let momentum = |p: f64| MomentumObserver::with_bandwidth(arm, p).unwrap();
    let p = edge(|p| momentum(p).suits(SLOW, 0.0));
    slow("momentum", p, computed(of_gains(top)), momentum(p), DynamicState::new());
}

/// One thing is wrong at a time.
#[test]
fn what_is_not_a_bandwidth_and_what_is_not_declared_is_refused_by_name() {
    let (arm, none, good) = (paper::nominal().unwrap(), [0.0, 5.0], both(5.0));
    let exact = Mismatch { inertia: 0.0, acceleration: 5.0, disturbance: 0.0 };
    let mismatch = Mismatch { inertia: 0.5, ..exact };
    let pace = Pace { speed: both(1.0), acceleration: both(2.0) };
    let network = RbfNetwork { centers: &[0.0], width: 1.0 };
    let axes = [Axis { centers: &[0.0, 1.0], widths: &[1.0] }; 4];
    let basis = FuzzyBasis::new(Form::Concat, true, &axes).unwrap();
    let said = [
        refused(Gains::<2>::with_bandwidth(none)),
        refused(PdGravity::with_bandwidth(arm, none)),
        refused(Integral::with_bandwidth(none)),
        refused(SlidingMode::with_bandwidth(none, &mismatch)),
        refused(Robust::with_bandwidth(none, &mismatch)),
        refused(HInfinity::with_bandwidth(none)),
        refused(SuperTwisting::with_bandwidth(none, &mismatch)),
        refused(Rise::with_bandwidth(none, &mismatch)),
        refused(Passive::with_bandwidth(arm, none)),
        refused(DisturbanceObserver::with_bandwidth(arm, none)),
        refused(AdaptiveParameters::with_bandwidth(arm, none, &pace)),
        refused(AdaptiveComputedTorque::with_bandwidth(arm, none, &pace)),
        refused(network.with_bandwidth(none)),
        refused(PassiveFuzzy::with_bandwidth(arm, basis, none, Inputs::error())),
    ];
    for said in said {
        assert!(said.starts_with("bandwidth[0]: got 0, wants a number"), "{said}");
    }
    let starts = |said: String, with: &str| assert!(said.starts_with(with), "{said}: {with}");
    starts(refused(MomentumObserver::with_bandwidth(arm, 0.0)), "bandwidth: got 0");
    starts(refused(Inertia::with_bandwidth::<2>(arm, 0.0, 1e-3, 0.0)), "bandwidth: got 0");
    starts(refused(Inertia::with_bandwidth::<2>(arm, 5.0, 0.0, 0.0)), "period: got 0");
    // Nothing to switch against.
    starts(refused(SlidingMode::with_bandwidth(good, &exact)), "gain[0]: got 0");
    starts(refused(Robust::with_bandwidth(good, &exact)), "bound: got 0");
    starts(refused(SuperTwisting::with_bandwidth(good, &exact)), "k1[0]: got 0");
    starts(refused(Rise::with_bandwidth(good, &exact)), "beta[0]: got 0");
    let beyond = Mismatch { inertia: 1.0, ..exact };
    starts(refused(Robust::with_bandwidth(good, &beyond)), "inertia: got 1");
    // Parameters act on nothing at rest: the arm lies flat.
    let rest = Pace { speed: both(0.0), acceleration: both(0.0) };
    starts(refused(AdaptiveParameters::with_bandwidth(arm, good, &rest)), "speed: got 0");
    starts(refused(AdaptiveComputedTorque::with_bandwidth(arm, good, &rest)), "speed: got 0");
    let backwards = Pace { acceleration: [1.0, -1.0], ..pace };
    let said = refused(AdaptiveParameters::with_bandwidth(arm, good, &backwards));
    starts(said, "acceleration[1]: got -1");
}

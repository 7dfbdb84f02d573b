//! A pulse that no torque can hold against: what remembers must not wind up meanwhile.

use std::ops::ControlFlow;

use nalgebra::Vector3;
use steadyarm::arm::{
    Inertia, JointFriction, JointKind, JointLimits, JointStop, Link, Pose, Serial, SerialParameters,
};
use steadyarm::control::{
    Adaptation, Applied, Compensator, ComputedTorque, Controller, Dynamic, DynamicState, Gains,
    Inputs, KernelParameters, Law, Limits, Sample, State,
};
use steadyarm::fuzzy::{Axis, Form, FuzzyBasis, KernelBasis};
use steadyarm::laws::{
    self, AdaptiveComputedTorque, AdaptiveComputedTorqueState, AdaptiveParameters,
    DisturbanceObserver, Integral, Mismatch, MomentumObserver, NaturalParameters, Pace, Passive,
    PassiveFuzzy, RbfNetwork, Rise, SuperTwisting, TimeDelay, TimeDelayState,
};
use steadyarm::math::{Matrix, Vector};
use steadyarm::paper;
use steadyarm::plant::Plant;
use steadyarm::reference::Reference;
use steadyarm::sim::{Options, Run, Status, simulate};

use super::{both, computed, nominal};

/// [s]
const PULSE: [f64; 2] = [10.0, 10.2];
const BANDWIDTH: f64 = 8.0;

/// The paper's plant with a torque limit, from on the path.
fn pushed<L: Law<2>, C: Compensator<2, S>, S>(law: L, compensator: C, memory: S) -> Run<2> {
    let sines = paper::disturbance().unwrap();
    let push = |_: &Vector<2>, _: &Vector<2>, t: f64| {
        let inside = (PULSE[0]..PULSE[1]).contains(&t);
        sines.value(t) + if inside { Vector::<2>::new(60.0, 0.0) } else { Vector::zeros() }
    };
    let plant = Plant::new(paper::actual().unwrap(), push);
    let reference = paper::reference().unwrap();
    let limits = Limits { effort_limit: [28.0, 12.0], ..Limits::default() };
    let controller = Controller::new(law, compensator).with_limits(limits).unwrap();
    let first = reference.at(0.0);
    let options = Options {
        duration: 20.0,
        q0: first.q.into(),
        dq0: first.dq.into(),
        control_period: Some(1e-3),
        ..Options::default()
    };
    let go_on = |_| ControlFlow::Continue(());
    let mut state = State::new(memory);
    simulate(&plant, &controller, &mut state, &reference, &options, go_on).unwrap()
}

/// Largest |e| from one time to another.
fn largest(run: &Run<2>, from: f64, to: f64) -> f64 {
    let inside = run.t.iter().zip(&run.e).filter(|(t, _)| (from..to).contains(*t));
    inside.flat_map(|(_, e)| e).fold(0.0, |most: f64, e| most.max(e.abs()))
}

/// Errors are those before the pulse so many seconds after it.
fn recovers<L: Law<2>, C: Compensator<2, S>, S>(
    (name, seconds): (&str, f64),
    law: L,
    compensator: C,
    memory: S,
) {
    let run = pushed(law, compensator, memory);
    assert_eq!(run.status, Status::Finished, "{name}");
    let cut = run.tau.iter().filter(|tau| tau[0].abs() == 28.0).count();
    let (before, during) = (largest(&run, 5.0, PULSE[0]), largest(&run, PULSE[0], 11.0));
    let after = largest(&run, PULSE[1] + seconds, 20.0);
    assert!(cut > 150 && during > 5.0 * before, "{name}: {cut} {during}");
    assert!(after < 1.5 * before + 2e-3, "{name}: {before} before the pulse, {after} after it");
}

/// The nominal arm as a chain of bodies.
fn chain() -> Serial<2> {
    let link = |along: f64| Link {
        kind: JointKind::Revolute,
        placement: Pose::at(Vector3::new(along, 0.0, 0.0)),
        axis: Vector3::z(),
        inertia: Inertia {
            mass: 4.0,
            com: Vector3::new(0.25, 0.0, 0.0),
            moments: Matrix::<3>::from_diagonal(&Vector3::new(0.05, 0.2, 0.2)),
        },
        friction: JointFriction::default(),
        armature: 0.0,
        limits: JointLimits::default(),
        stop: JointStop::default(),
    };
    let links = [link(0.0), link(0.5)];
    Serial::new(SerialParameters { links, tip: Pose::IDENTITY, gravity: [0.0; 3] }).unwrap()
}

#[test]
fn what_remembers_does_not_wind_up_while_the_torque_is_limited() {
    let p = both(BANDWIDTH);
    let mismatch = Mismatch { inertia: 0.5, acceleration: 5.0, disturbance: 5.0 };
    let pace = Pace { speed: both(1.0), acceleration: both(2.0) };
    let gains = Gains::with_bandwidth(p).unwrap();
    let (of_integral, integral) = Integral::with_bandwidth(p).unwrap();
    recovers(("integral", 3.0), computed(of_integral), integral, DynamicState::new());
    let twisting = SuperTwisting::with_bandwidth(p, &mismatch).unwrap();
    recovers(("super-twisting", 3.0), computed(twisting), twisting, DynamicState::new());
    let rise = Rise::with_bandwidth(p, &mismatch).unwrap();
    recovers(("RISE", 3.0), computed(rise), rise, DynamicState::new());
    let observer = DisturbanceObserver::with_bandwidth(nominal(), p).unwrap();
    recovers(("disturbance observer", 3.0), computed(gains), observer, DynamicState::new());
    let momentum = MomentumObserver::with_bandwidth(nominal(), BANDWIDTH).unwrap();
    recovers(("momentum observer", 3.0), computed(gains), momentum, DynamicState::new());
    let (delayed, inertia) =
        laws::Inertia::with_bandwidth(nominal(), BANDWIDTH, 1e-3, 0.0).unwrap();
    let law = ComputedTorque::new(inertia, delayed);
    recovers(("time delay", 3.0), law, TimeDelay { arm: inertia }, TimeDelayState::new());
    let passive = Passive::with_bandwidth(nominal(), p).unwrap();
    let plain = AdaptiveParameters::with_bandwidth(nominal(), p, &pace).unwrap();
    recovers(("parameters", 8.0), passive, plain, DynamicState::<5>::new());
    let natural = NaturalParameters::<2, 20>::with_bandwidth(chain(), p, &pace).unwrap();
    recovers(("natural parameters", 8.0), passive, natural, DynamicState::<20>::new());
    let (of_model, model) = AdaptiveComputedTorque::with_bandwidth(nominal(), p, &pace).unwrap();
    let memory = AdaptiveComputedTorqueState::<2, 5>::new();
    recovers(("adaptive computed torque", 8.0), computed(of_model), model, memory);
}

/// RISE that integrates on while the torque is limited.
#[derive(Clone, Copy)]
struct Winding(Rise<2>);

impl Dynamic<2, 2> for Winding {
    fn start(&self, seen: &Sample<2>) -> Vector<2> {
        self.0.start(seen)
    }

    fn estimate(&self, z: &Vector<2>, seen: &Sample<2>) -> Vector<2> {
        Dynamic::estimate(&self.0, z, seen)
    }

    fn rate(&self, z: &Vector<2>, seen: &Sample<2>, applied: &Applied<2>) -> Vector<2> {
        self.0.rate(z, seen, &Applied::new(applied.tau, applied.tau))
    }
}

/// What the tests here would see.
#[test]
fn an_integral_that_does_not_hold_winds_up() {
    let mismatch = Mismatch { inertia: 0.5, acceleration: 5.0, disturbance: 5.0 };
    let rise = Rise::with_bandwidth(both(BANDWIDTH), &mismatch).unwrap();
    let held = pushed(computed(rise), rise, DynamicState::new());
    let winding = pushed(computed(rise), Winding(rise), DynamicState::new());
    let [held, winding] = [held, winding].map(|run| largest(&run, PULSE[1] + 3.0, 20.0));
    assert!(winding > 20.0 * held, "{held} {winding}");
}

#[test]
fn weights_do_not_wind_up_while_the_torque_is_limited() {
    let p = both(BANDWIDTH);
    let network = RbfNetwork { centers: &[-2.0, -1.0, 0.0, 1.0, 2.0], width: 3.0 };
    let (of_network, network) = network.with_bandwidth(p).unwrap();
    let weights = network.state();
    recovers(("RBF network", 3.0), computed(of_network), network, weights);
    let passive = Passive::with_bandwidth(nominal(), p).unwrap();
    let axes = [Axis { centers: &paper::CENTERS, widths: &[paper::WIDTH] }; 4];
    let basis = FuzzyBasis::new(Form::Concat, true, &axes).unwrap();
    let inputs = Inputs::reference();
    let fuzzy = PassiveFuzzy::with_bandwidth(nominal(), basis, p, inputs).unwrap();
    let weights = fuzzy.approximator().state();
    recovers(("passivity form", 3.0), passive, fuzzy, weights);
    let basis = KernelBasis::new(true, &axes).unwrap();
    let adaptation = Adaptation { gain: both(200.0), ..Adaptation::default() };
    let kernel = KernelParameters::default();
    let kernel = PassiveFuzzy::kernel(nominal(), basis, p, inputs, adaptation, kernel).unwrap();
    let dictionary = kernel.approximator().state();
    recovers(("passivity form, kernel", 3.0), passive, kernel, dictionary);
}

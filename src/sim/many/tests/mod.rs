//! Which runs really go side by side, on every instruction set: all would have the right bits alone
//! too.

mod fronts;
mod learned;

use core::sync::atomic::AtomicBool;

use nalgebra::Vector3;
use pulp::Arch;

use super::*;
use crate::arm::{
    Friction, Inertia, JointFriction, JointKind, Link, Pose, Serial, SerialParameters, TwoLink,
    TwoLinkParameters,
};
use crate::control::{
    Adaptation, ComputedTorque, Controller, DynamicState, EstimatorsAbreast, Front,
    FuzzyCompensator, FuzzyParameters, Gains, Limits, NoCompensation, State,
};
use crate::effects::{Actuators, Effects, Sensors, Timing, Velocity};
use crate::fuzzy::{Axis, Form, FuzzyBasis};
use crate::laws::{DisturbanceObserver, Integral, MomentumObserver};
use crate::math::{Matrix, Vector, none_missing};
use crate::plant::Plant;
use crate::reference::{Harmonic, Setpoint, Sines};

/// Every instruction set that this processor has: registers of 1, 4 and 8 numbers.
fn instruction_sets() -> Vec<Arch> {
    let mut all = vec![Arch::Scalar];
    #[cfg(target_arch = "x86_64")]
    {
        all.extend(pulp::x86::V3::try_new().map(Arch::V3));
        all.extend(pulp::x86::V4::try_new().map(Arch::V4));
    }
    all
}

/// Those of these runs that go side by side, on every instruction set, with the bits that they have
/// alone.
fn together<const N: usize, A, D, L, C, S>(
    plants: &[Plant<N, A, D>; LANES],
    controller: &Controller<N, L, C>,
    state: &State<N, S>,
    way: (Option<f64>, Effects<N>),
) -> [bool; LANES]
where
    A: Arm<N>,
    D: Disturbance<N>,
    L: Law<N>,
    C: Compensator<N, S>,
    S: Clone,
{
    let reference = |t: f64| Setpoint::at_rest(Vector::<N>::repeat(0.1 * t));
    together_along(&reference, plants, controller, state, way)
}

fn together_along<const N: usize, A, D, L, C, S>(
    reference: &impl Reference<N>,
    plants: &[Plant<N, A, D>; LANES],
    controller: &Controller<N, L, C>,
    state: &State<N, S>,
    (control_period, effects): (Option<f64>, Effects<N>),
) -> [bool; LANES]
where
    A: Arm<N>,
    D: Disturbance<N>,
    L: Law<N>,
    C: Compensator<N, S>,
    S: Clone,
{
    let cases = plants.each_ref().map(|plant| {
        let (q0, dq0) = ([0.1; N], [0.05; N]);
        Case { plant, controller, state, reference, q0, dq0, effects }
    });
    let record = Record::Metrics(Window { from: 0.05, to: 0.15, band: 0.01 });
    let options = Options { duration: 0.25, record, control_period, ..Options::default() };
    let stop = AtomicBool::new(false);
    let alone = cases.each_ref().map(|case| alone(case, &options, &stop).unwrap());
    let mut went = None;
    for arch in instruction_sets() {
        let runs = abreast(&cases, &options, &stop, arch);
        for (i, run) in runs.iter().enumerate() {
            assert!(run.as_ref().is_none_or(|run| *run == alone[i]), "{i}");
        }
        let those = runs.each_ref().map(Option::is_some);
        assert_eq!(*went.get_or_insert(those), those);
    }
    went.unwrap()
}

/// The same with computed torque of this arm, in continuous time and sampled; and with what learns.
fn all_ways<const N: usize, A: Arm<N> + Clone>(
    plants: &[Plant<N, A, Push<N>>; LANES],
    arm: A,
) -> [bool; LANES] {
    let gains = Gains::new([60.0; N], [14.0; N]).unwrap();
    let law = ComputedTorque::new(arm, gains);
    let plain = &Controller::new(law.clone(), NoCompensation);
    let axis = Axis { centers: &[-1.0, -0.5, 0.0, 0.5, 1.0], widths: &[0.6] };
    let basis = FuzzyBasis::new(Form::PerJoint { joints: N }, true, &vec![axis; 2 * N]).unwrap();
    let learns = FuzzyCompensator::new(basis, &gains, FuzzyParameters::default()).unwrap();
    let learning = &Controller::new(law, learns);
    let state = State::new(learning.compensator.state());
    let rated = Limits { effort_limit: [60.0; N], effort_rate_limit: [5e3; N] };
    let limited = &learning.clone().with_limits(rated).unwrap();
    let ways = [None, Some(1e-3), Some(4e-3)].map(|period| {
        let went = together(plants, plain, &State::new(()), (period, Effects::default()));
        assert_eq!(together(plants, learning, &state, (period, Effects::default())), went);
        if period.is_some() {
            assert_eq!(together(plants, limited, &state, (period, Effects::default())), went);
            for drop in [0.0, 0.1] {
                assert_eq!(together(plants, limited, &state, (period, noisy(drop))), went);
                assert_eq!(together(plants, learning, &state, (period, noisy(drop))), went);
            }
            assert_eq!(together(plants, learning, &state, (period, coarse())), went);
        }
        went
    });
    assert_eq!(ways, [ways[0]; 3]);
    ways[0]
}

/// Sensors that are noisy, samples that are late and perhaps lost, drives that lag.
fn noisy<const N: usize>(drop: f64) -> Effects<N> {
    let sensors = Sensors { encoder: [1e-5; N], noise: [1e-5; N], ..Sensors::default() };
    let timing = Timing { delay: 1, drop, ..Timing::default() };
    let actuators = Actuators { lag: [2e-3; N], gain: [0.97; N], ..Actuators::default() };
    Effects { sensors, timing, actuators, seed: 5, ..Effects::default() }
}

/// Encoders whose velocity fades between two counts to what no controller feels.
fn coarse<const N: usize>() -> Effects<N> {
    let velocity = Velocity::Difference(300.0);
    let sensors = Sensors { encoder: [0.01; N], velocity, ..Sensors::default() };
    Effects { sensors, ..Effects::default() }
}

fn two_link(mass: f64, friction: Friction<2>) -> TwoLink {
    let numbers = TwoLinkParameters {
        mass: [mass; 2],
        length: [0.5; 2],
        inertia: [0.3; 2],
        gravity: 9.81,
        friction,
    };
    TwoLink::new(numbers).unwrap()
}

/// A chain with a joint that slides, of links that are not symmetric.
fn chain<const N: usize>(load: f64, friction: JointFriction) -> Serial<N> {
    let links = core::array::from_fn(|i| {
        let place = Pose::at(Vector3::new(0.3, 0.05 * i as f64, -0.1));
        let axis = [Vector3::z(), Vector3::y(), Vector3::x()][i % 3];
        let com = Vector3::new(0.1, -0.05, 0.02);
        let inertia =
            Inertia { moments: Matrix::<3>::identity() * 0.2, ..Inertia::point_mass(2.0, com) };
        let kind = if i == 1 { JointKind::Prismatic } else { JointKind::Revolute };
        Link { friction, ..Link::new(kind, place, axis, inertia) }
    });
    let gravity = [0.0, 0.0, -9.81];
    let arm = Serial::new(SerialParameters { links, tip: Pose::IDENTITY, gravity }).unwrap();
    arm.with_payload(&Inertia::point_mass(load, Vector3::zeros())).unwrap()
}

type Push<const N: usize> = Sines<N, [Harmonic<N>; 1]>;

fn pushed<const N: usize, A: Arm<N>>(arm: A) -> Plant<N, A, Push<N>> {
    let harmonic = Harmonic { frequency: 3.0, sin: [0.1; N], cos: [0.2; N] };
    Plant::new(arm, Sines::new([0.2; N], [harmonic]).unwrap())
}

#[test]
fn ordinary_runs_go_side_by_side() {
    let smooth = Friction { viscous: [0.4, 0.2], coulomb: [0.5, 0.0], smoothing: [0.2, 0.1] };
    for friction in [Friction::default(), smooth] {
        let plants = core::array::from_fn(|i| pushed(two_link(5.0 + i as f64, friction)));
        assert_eq!(all_ways(&plants, two_link(4.0, friction)), [true; LANES]);
        assert_eq!(all_ways(&plants, two_link(4.0, Friction::default())), [true; LANES]);
    }
    let coulomb = [0.3, 0.2];
    let smooth = JointFriction { viscous: 0.5, coulomb, smoothing: 0.2, ..Default::default() };
    let falling = JointFriction { stribeck: 0.1, stribeck_speed: 0.3, ..smooth };
    for friction in [JointFriction::default(), smooth, falling] {
        let plants = core::array::from_fn(|i| pushed(chain::<4>(0.2 * i as f64, friction)));
        assert_eq!(all_ways(&plants, chain(0.5, friction)), [true; LANES]);
        assert_eq!(all_ways(&plants, chain(0.5, JointFriction::default())), [true; LANES]);
    }
}

/// Sets on steps that are known when this is compiled, and on others; as many for each input, or
/// not; the same in both joints, or not.
#[test]
fn bases_on_any_sets_go_side_by_side() {
    let even: [&[f64]; 3] =
        [&[-1.0, 0.0, 1.0], &[-1.0, -0.5, 0.0, 0.5, 1.0], &[-1.5, -1.0, -0.5, 0.0, 0.5, 1.0, 1.5]];
    let (paper, other): (&[f64], &[f64]) = (&[-1.5, -0.5, 0.0, 0.5, 1.5], &[-1.0, -0.5, 0.0, 1.0]);
    let plants = core::array::from_fn(|i| pushed(two_link(5.0 + i as f64, Friction::default())));
    let gains = Gains::new([20.0; 2], [8.0; 2]).unwrap();
    for centers in [
        [even[0]; 4],
        [even[1]; 4],
        [even[2]; 4],
        [paper; 4],
        [other; 4],
        [other, other, paper, paper],
        [even[1], paper, even[1], paper],
    ] {
        for normalized in [true, false] {
            let axes = centers.map(|centers| Axis { centers, widths: &[0.6] });
            let basis = FuzzyBasis::new(Form::PerJoint { joints: 2 }, normalized, &axes).unwrap();
            let learns = FuzzyCompensator::new(basis, &gains, FuzzyParameters::default()).unwrap();
            let side = learns.state();
            let each = [learns.learns(&side).unwrap(); LANES];
            assert!(EstimatorsAbreast::of(each).is_some(), "{centers:?}");
            let law = ComputedTorque::new(two_link(4.0, Friction::default()), gains);
            let (controller, state) = (&Controller::new(law, learns), State::new(side));
            for period in [None, Some(1e-3)] {
                let way = (period, Effects::default());
                assert_eq!(together(&plants, controller, &state, way), [true; LANES]);
            }
        }
    }
}

/// A leak, also one that fades weights within a period, a dead zone and a normalisation go side by
/// side; what pulls weights by their size does not, but its arms do.
#[test]
fn laws_that_leak_or_weaken_the_drive_go_side_by_side() {
    let plants = core::array::from_fn(|i| pushed(two_link(5.0 + i as f64, Friction::default())));
    let gains = Gains::new([20.0; 2], [8.0; 2]).unwrap();
    let base = Adaptation { gain: [300.0; 2], ..Adaptation::default() };
    let leaks = [0.3, 200.0].map(|leak_rate| Adaptation { leak_rate, ..base });
    let weakened = Adaptation { dead_zone: 0.2, normalization: 3.0, ..base };
    let all = Adaptation { leak_rate: 0.1, ..weakened };
    let pulled = Adaptation { error_modification: 0.1, ..all };
    let laws = [(leaks[0], true), (leaks[1], true), (weakened, true), (all, true), (pulled, false)];
    for (adaptation, goes) in laws {
        let axis = Axis { centers: &[-1.0, -0.5, 0.0, 0.5, 1.0], widths: &[0.6] };
        let basis = FuzzyBasis::new(Form::PerJoint { joints: 2 }, true, &[axis; 4]).unwrap();
        let parameters = FuzzyParameters { adaptation, ..FuzzyParameters::default() };
        let learns = FuzzyCompensator::new(basis, &gains, parameters).unwrap();
        let side = learns.state();
        let each = [learns.learns(&side); LANES];
        let abreast = none_missing(each).and_then(EstimatorsAbreast::of);
        assert_eq!(abreast.is_some(), goes, "{adaptation:?}");
        let law = ComputedTorque::new(two_link(4.0, Friction::default()), gains);
        let (controller, state) = (&Controller::new(law, learns), State::new(side));
        for period in [None, Some(1e-3)] {
            let way = (period, Effects::default());
            assert_eq!(together(&plants, controller, &state, way), [true; LANES]);
        }
    }
}

/// The integral of the error, within the limits of the torque and beyond them, and an observer.
fn with_memories<const N: usize, A: Arm<N> + Clone>(
    plants: &[Plant<N, A, Push<N>>; LANES],
    arm: A,
) {
    fn beside<const N: usize, L: Law<N> + Clone, C: Compensator<N, DynamicState<N>> + Clone>(
        plants: &[Plant<N, impl Arm<N>, Push<N>>; LANES],
        controller: &Controller<N, L, C>,
    ) {
        let mut state = State::new(DynamicState::new());
        let each = [controller.compensator.learns(controller.settle(&mut state)); LANES];
        assert!(none_missing(each).and_then(EstimatorsAbreast::of).is_some());
        for limit in [f64::INFINITY, 40.0] {
            let limits = Limits { effort_limit: [limit; N], ..Limits::default() };
            let controller = &controller.clone().with_limits(limits).unwrap();
            for period in [None, Some(1e-3), Some(4e-3)] {
                let went = together(plants, controller, &state, (period, Effects::default()));
                assert_eq!(went, [true; LANES]);
                if period.is_some() {
                    let went = together(plants, controller, &state, (period, noisy(0.0)));
                    assert_eq!(went, [true; LANES]);
                }
            }
        }
    }
    let (gains, integral) = Integral::with_bandwidth([8.0; N]).unwrap();
    let law = ComputedTorque::new(arm.clone(), gains);
    beside(plants, &Controller::new(law.clone(), integral));
    let observer = DisturbanceObserver::with_bandwidth(arm, [20.0; N]).unwrap();
    beside(plants, &Controller::new(law.clone(), observer));
    let observer = MomentumObserver::new(law.arm.clone(), 20.0).unwrap();
    beside(plants, &Controller::new(law, observer));
}

#[test]
fn memories_of_a_number_a_joint_go_side_by_side() {
    let smooth = Friction { viscous: [0.4, 0.2], coulomb: [0.5, 0.0], smoothing: [0.2, 0.1] };
    let plants = core::array::from_fn(|i| pushed(two_link(5.0 + i as f64, smooth)));
    with_memories(&plants, two_link(4.0, smooth));
    let viscous = JointFriction { viscous: 0.5, ..Default::default() };
    let plants = core::array::from_fn(|i| pushed(chain::<4>(0.2 * i as f64, viscous)));
    with_memories(&plants, chain(0.5, viscous));
}

#[test]
fn a_run_that_is_not_ordinary_goes_alone() {
    let arm = two_link(4.0, Friction::default());
    let plants: [_; LANES] = core::array::from_fn(|i| {
        let factor = if i == 3 { 1e9 } else { 1.0 };
        let push = move |q: &Vector<2>, _: &Vector<2>, _: f64| q * factor;
        Plant::new(two_link(5.0 + i as f64, Friction::default()), push)
    });
    let gains = Gains::new([20.0; 2], [8.0; 2]).unwrap();
    let controller = &Controller::new(ComputedTorque::new(arm, gains), NoCompensation);
    let went = together(&plants, controller, &State::new(()), (None, Effects::default()));
    assert_eq!(went, core::array::from_fn(|i| i != 3));
}

/// A loop with effects is told what acted by its drives, and one without is not: they do not go
/// together.
#[test]
fn loops_with_effects_and_without_do_not_go_side_by_side() {
    let plants: [_; LANES] =
        core::array::from_fn(|i| pushed(two_link(5.0 + i as f64, Friction::default())));
    let (gains, integral) = Integral::with_bandwidth([8.0; 2]).unwrap();
    let law = ComputedTorque::new(two_link(4.0, Friction::default()), gains);
    let front = Front { delay: 1, ..Front::default() };
    let late = Controller::new(law, integral).with_front(front).unwrap();
    let (controller, state) = (&late, &State::new(DynamicState::new()));
    let reference = &|t: f64| Setpoint::at_rest(Vector::<2>::repeat(0.1 * t));
    let record = Record::Metrics(Window { from: 0.05, to: 0.15, band: 0.01 });
    let options =
        Options { duration: 0.25, record, control_period: Some(1e-3), ..Options::default() };
    for (others, goes) in [(noisy(0.0), true), (Effects::default(), false)] {
        let cases: [_; LANES] = core::array::from_fn(|i| {
            let effects = if i == 3 { noisy(0.0) } else { others };
            let (plant, q0, dq0) = (&plants[i], [0.1; 2], [0.05; 2]);
            Case { plant, controller, state, reference, q0, dq0, effects }
        });
        let stop = AtomicBool::new(false);
        for arch in instruction_sets() {
            let runs = abreast(&cases, &options, &stop, arch);
            assert_eq!(runs.each_ref().map(Option::is_some), [goes; LANES]);
            for (run, case) in runs.iter().zip(&cases) {
                let alone = alone(case, &options, &stop).unwrap();
                assert!(run.as_ref().is_none_or(|run| *run == alone));
            }
        }
    }
}

/// What a sampled controller refuses, or does not feel, is not ordinary; in continuous time it is.
#[test]
fn a_set_point_that_a_sampled_controller_refuses_goes_alone() {
    let plants = core::array::from_fn(|i| pushed(two_link(5.0 + i as f64, Friction::default())));
    let gains = Gains::new([20.0; 2], [8.0; 2]).unwrap();
    let law = ComputedTorque::new(two_link(4.0, Friction::default()), gains);
    let limits = Limits { effort_limit: [30.0; 2], ..Limits::default() };
    let controller = &Controller::new(law, NoCompensation).with_limits(limits).unwrap();
    let still = Setpoint::at_rest(Vector::<2>::new(0.2, -0.1));
    let far = Setpoint { q: Vector::<2>::new(0.2, 2e5), ..still };
    let fast = Setpoint { ddq: Vector::<2>::new(2e10, 0.0), ..still };
    let tiny = Setpoint { dq: Vector::<2>::new(0.0, 1e-31), ..still };
    for (setpoint, sampled) in [(still, true), (far, false), (fast, false), (tiny, false)] {
        for (period, goes) in [(None, true), (Some(1e-3), sampled)] {
            let (way, state) = ((period, Effects::default()), &State::new(()));
            let went = together_along(&|_| setpoint, &plants, controller, state, way);
            assert_eq!(went, [goes; LANES], "{setpoint:?} {period:?}");
        }
    }
}

/// Friction that sticks, long chains, samples between rows, motors that cog.
#[test]
fn what_has_no_lanes_goes_alone() {
    let plants = core::array::from_fn(|i| pushed(two_link(5.0 + i as f64, Friction::default())));
    let gains = Gains::new([20.0; 2], [8.0; 2]).unwrap();
    let law = ComputedTorque::new(two_link(4.0, Friction::default()), gains);
    let controller = &Controller::new(law, NoCompensation);
    let jitter = Timing { jitter: 0.2, ..Timing::default() };
    let cogs = Actuators { cogging: [0.1; 2], ..Actuators::default() };
    for effects in [
        Effects { timing: jitter, ..Effects::default() },
        Effects { actuators: cogs, ..Effects::default() },
    ] {
        let went = together(&plants, controller, &State::new(()), (Some(1e-3), effects));
        assert_eq!(went, [false; LANES]);
    }
    let dry = JointFriction { coulomb: [0.3; 2], smoothing: 0.0, ..Default::default() };
    let plants = core::array::from_fn(|i| pushed(chain::<3>(0.1 * i as f64, dry)));
    assert_eq!(all_ways(&plants, chain(0.0, dry)), [false; LANES]);
    let plants = core::array::from_fn(|i| pushed(chain::<9>(0.1 * i as f64, Default::default())));
    assert_eq!(all_ways(&plants, chain(0.0, Default::default())), [false; LANES]);
}

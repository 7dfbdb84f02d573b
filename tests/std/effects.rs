//! The loop through sensors, timing and actuators.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

use steadyarm::arm::{Arm, TwoLink};
use steadyarm::control::{
    Applied, Compensator, ComputedTorque, Controller, Dynamic, DynamicState, Front, Law,
    NoCompensation, Sample, State,
};
use steadyarm::effects::{Actuators, Effects, Sensors, Side, Timing, Transmission, Velocity};
use steadyarm::laws::{DisturbanceObserver, Integral};
use steadyarm::math::{Matrix, Vector};
use steadyarm::paper;
use steadyarm::plant::{Elastic, Plant, Undisturbed};
use steadyarm::reference::Setpoint;
use steadyarm::sim::{Options, Run, Status, simulate};

/// 16 bits, difference through 100 Hz, torque one sample late.
fn sensors() -> Effects<2> {
    let step = core::f64::consts::TAU / 65536.0;
    Effects {
        sensors: Sensors {
            encoder: [step; 2],
            velocity: Velocity::Difference(100.0),
            ..Sensors::default()
        },
        timing: Timing { delay: 1, ..Timing::default() },
        ..Effects::default()
    }
}

fn options(effects: Effects<2>) -> Options<2> {
    Options { control_period: Some(1e-3), effects, ..Options::default() }
}

/// The paper's plant.
fn run<L, C, S>(controller: &Controller<2, L, C>, memory: S, options: &Options<2>) -> Run<2>
where
    L: Law<2>,
    C: Compensator<2, S>,
{
    let (plant, reference) = (paper::plant().unwrap(), paper::reference().unwrap());
    let mut state = State::new(memory);
    let go_on = |_| ControlFlow::Continue(());
    simulate(&plant, controller, &mut state, &reference, options, go_on).unwrap()
}

fn computed() -> ComputedTorque<2, TwoLink> {
    ComputedTorque::new(paper::nominal().unwrap(), paper::gains().unwrap())
}

fn plain() -> Controller<2, ComputedTorque<2, TwoLink>> {
    Controller::new(computed(), NoCompensation)
}

/// RMS of |e| over both joints, and Σ|Δτ|/s, in the second half.
fn figures(run: &Run<2>) -> [f64; 2] {
    assert_eq!(run.status, Status::Finished);
    let half = run.t.len() / 2;
    let squares: f64 = run.e[half..].iter().flatten().map(|e| e * e).sum();
    let moved: f64 = run.tau[half..]
        .windows(2)
        .map(|pair| (0..2).map(|n| (pair[1][n] - pair[0][n]).abs()).sum::<f64>())
        .sum();
    let length = run.t.last().unwrap() - run.t[half];
    [(squares / (run.t.len() - half) as f64).sqrt(), moved / length]
}

/// The figures of a program written apart: .487 rad and 375 N·m/s.
#[test]
fn computed_torque_through_sensors_has_the_figures_of_another_program() {
    let [rms, variation] = figures(&run(&plain(), (), &options(sensors())));
    assert!((rms - 0.487).abs() < 5e-4 && (variation - 375.0).abs() < 1.0, "{rms} {variation}");
}

#[test]
fn a_seed_gives_the_same_bits_and_another_seed_others() {
    let noisy = |seed| {
        let mut effects = Effects { seed, ..sensors() };
        effects.sensors.noise = [1e-4; 2];
        (effects.timing.jitter, effects.timing.drop) = (0.2, 0.02);
        let options = Options { duration: 1.0, ..options(effects) };
        run(&plain(), (), &options)
    };
    let (one, again, other) = (noisy(1), noisy(1), noisy(2));
    assert!(one == again && one.q != other.q);
    assert!(one.values("sample_age").unwrap().iter().all(|age| *age < 4.2e-3));
}

/// 2 % of 10 000, within three standard deviations.
#[test]
fn as_many_samples_are_lost_as_is_said() {
    let mut effects = Effects::default();
    effects.timing.drop = 0.02;
    let run = run(&plain(), (), &Options { duration: 10.0, ..options(effects) });
    let lost = run.values("sample_age").unwrap().iter().filter(|age| **age > 5e-4).count();
    assert!((158..=242).contains(&lost), "{lost}");
}

#[test]
fn a_hand_over_starts_without_an_error_and_ends_on_the_reference() {
    let front = Front { hand_over: Some(2.0), ..Front::default() };
    let handed = plain().with_front(front).unwrap();
    let [hard, soft] = [&plain(), &handed].map(|it| run(it, (), &options(Effects::default())));
    let largest = |run: &Run<2>| run.tau.iter().flatten().fold(0.0, |m, t| f64::max(m, t.abs()));
    // What holds the reference's acceleration, instead of an error of half a radian at once.
    assert!(largest(&soft) < 0.75 * largest(&hard), "{} {}", largest(&soft), largest(&hard));
    let last = |run: &Run<2>| *run.e.last().unwrap();
    for n in 0..2 {
        assert!((last(&soft)[n] - last(&hard)[n]).abs() < 1e-6);
    }
}

/// A stop and go in the middle: saved and restored, a controller's next torques are the same.
#[test]
fn what_stands_before_the_law_is_saved_and_reset_to_the_bit() {
    let front =
        Front { hand_over: Some(3.0), velocity_filter: Some(60.0), bumpless: Some(5.0), delay: 2 };
    let controller = plain().with_front(front).unwrap();
    let reference = paper::reference().unwrap();
    let step = |state: &mut State<2>, k: u32| {
        let t = f64::from(k) * 1e-3;
        let q = Vector::from([0.3 * (3.0 * t).sin(), -0.1 + 0.2 * t]);
        controller.lasted(state, 1e-3 + 1e-5 * f64::from(k % 3)).unwrap();
        let desired = steadyarm::reference::Reference::at(&reference, t);
        controller.step(state, &q, &Vector::zeros(), &desired, 1e-3).unwrap().tau
    };
    let mut state = State::new(());
    let first: Vec<_> = (0..50).map(|k| step(&mut state, k)).collect();
    let mut restored = State::new(());
    controller.restore(&mut restored, &controller.save(&state)).unwrap();
    assert_eq!(state, restored);
    for k in 50..100 {
        assert_eq!(step(&mut state, k), step(&mut restored, k));
    }
    controller.reset(&mut state);
    assert_eq!(state, State::new(()));
    let again: Vec<_> = (0..50).map(|k| step(&mut state, k)).collect();
    assert_eq!(first, again);
    // Another front is another controller.
    let other = plain().with_front(Front { delay: 1, ..front }).unwrap();
    assert!(other.restore(&mut State::new(()), &controller.save(&state)).is_err());
}

#[test]
fn a_bumpless_start_goes_on_from_the_torque_at_take_over() {
    let front = Front { bumpless: Some(4.0), ..Front::default() };
    let controller = plain().with_front(front).unwrap();
    let mut state = State::new(());
    let before = Vector::from([3.0, -2.0]);
    state.take_over(&before).unwrap();
    let desired = Setpoint::at_rest(Vector::from([1.0, 0.5]));
    let step = |controller: &Controller<2, _>, state: &mut State<2>| {
        controller.step(state, &Vector::zeros(), &Vector::zeros(), &desired, 1e-3).unwrap().tau
    };
    assert_eq!(step(&controller, &mut state), before);
    for _ in 0..1000 {
        step(&controller, &mut state);
    }
    let law = step(&plain(), &mut State::new(()));
    let left = step(&controller, &mut state) - law;
    // e^(−4) of the jump is left after a second.
    assert!((left.norm() / (before - law).norm() - (-4.0_f64 * 1.001).exp()).abs() < 1e-6);
}

/// In a loop that is late by d samples an observer that knows it takes a push away; what the
/// controller is told of a period is what acted in it.
#[test]
fn an_observer_that_knows_the_delay_takes_a_push_away() {
    let observer = DisturbanceObserver::new(paper::nominal().unwrap(), [50.0; 2]).unwrap();
    let rms = |delay| {
        let front = Front { velocity_filter: Some(100.0), delay, ..Front::default() };
        let controller = Controller::new(computed(), observer).with_front(front).unwrap();
        figures(&run(&controller, DynamicState::new(), &options(sensors())))[0]
    };
    assert!(rms(1) < 0.02);
    assert!((rms(1) - rms(0)).abs() > 1e-6);
}

#[test]
fn an_integral_does_not_wind_up_against_the_limit_of_a_drive_that_is_late() {
    let (gains, integral) = Integral::with_bandwidth([12.0; 2]).unwrap();
    let law = ComputedTorque::new(paper::nominal().unwrap(), gains);
    let front = Front { velocity_filter: Some(100.0), delay: 1, ..Front::default() };
    let controller = Controller::new(law, integral).with_front(front).unwrap();
    let plant = paper::plant().unwrap().with_effort_limit([7.0; 2]).unwrap();
    let mut state = State::new(DynamicState::new());
    let (reference, options) = (paper::reference().unwrap(), options(sensors()));
    let go_on = |_| ControlFlow::Continue(());
    let run = simulate(&plant, &controller, &mut state, &reference, &options, go_on).unwrap();
    assert_eq!(run.status, Status::Finished);
    let limit = run.tau.iter().flatten().filter(|tau| tau.abs() == 7.0).count();
    assert!(limit > 100, "{limit}");
    let z = state.compensator().z().unwrap();
    assert!(z.iter().all(|z| z.abs() < 1.0), "{z}");
}

/// From t = 2 on the arm is the one that is twice as heavy.
#[test]
fn a_plant_that_changes_is_each_arm_in_its_time() {
    let (nominal, actual) = (paper::nominal().unwrap(), paper::actual().unwrap());
    let reference = paper::reference().unwrap();
    let run = |plant: &Plant<2, TwoLink>, q0: [f64; 2], dq0, duration| {
        let options = Options { q0, dq0, duration, ..options(Effects::default()) };
        let go_on = |_| ControlFlow::Continue(());
        simulate(plant, &plain(), &mut State::new(()), &reference, &options, go_on).unwrap()
    };
    let changing = Plant::new(nominal, Undisturbed).with_change(2.0, actual).unwrap();
    let whole = run(&changing, [0.0; 2], [0.0; 2], 4.0);
    let light = run(&Plant::new(nominal, Undisturbed), [0.0; 2], [0.0; 2], 4.0);
    assert!(whole.q[..=2000] == light.q[..=2000]);
    assert!((whole.e[3900][0] - light.e[3900][0]).abs() > 1e-3);
    let backwards = Plant::new(nominal, Undisturbed).with_change(2.0, actual).unwrap();
    let error = backwards.with_change(1.0, nominal).unwrap_err().to_string();
    assert!(error.starts_with("at: got 1, wants a time after"), "{error}");
}

#[test]
fn a_lag_and_a_gain_error_change_what_arrives_and_cogging_what_moves() {
    let of = |actuators| {
        let effects = Effects { actuators, ..Effects::default() };
        run(&plain(), (), &Options { duration: 5.0, ..options(effects) })
    };
    let none = of(Actuators::default());
    let weak = of(Actuators { gain: [0.9; 2], ..Actuators::default() });
    let sent = weak.values("tau_commanded").unwrap();
    for (k, tau) in weak.tau.iter().enumerate() {
        assert!((tau[0] - 0.9 * sent[2 * k]).abs() < 1e-12);
    }
    let lagging = of(Actuators { lag: [0.02; 2], ..Actuators::default() });
    let cogging = of(Actuators { cogging: [0.5; 2], ..Actuators::default() });
    for run in [&weak, &lagging, &cogging] {
        assert_eq!(run.status, Status::Finished);
        assert!((run.q[2000][0] - none.q[2000][0]).abs() > 1e-5);
    }
}

#[test]
fn what_needs_samples_is_refused_in_continuous_time() {
    let refused = |controller: &Controller<2, ComputedTorque<2, TwoLink>>, effects, plant| {
        let (reference, mut state) = (paper::reference().unwrap(), State::new(()));
        let options = Options { effects, ..Options::default() };
        let go_on = |_| ControlFlow::Continue(());
        let run = simulate(&plant, controller, &mut state, &reference, &options, go_on);
        run.unwrap_err().to_string()
    };
    let plant = || Plant::new(paper::nominal().unwrap(), Undisturbed);
    let front = Front { delay: 1, ..Front::default() };
    let fronted = plain().with_front(front).unwrap();
    let changing = plant().with_change(1.0, paper::actual().unwrap()).unwrap();
    for error in [
        refused(&plain(), sensors(), plant()),
        refused(&fronted, Effects::default(), plant()),
        refused(&plain(), Effects::default(), changing),
    ] {
        assert!(error.starts_with("control_period: got None, wants a period"), "{error}");
    }
    let effects = |timing| Effects::<2> { timing, ..Effects::default() };
    for (timing, wanted) in [
        (Timing { delay: 5, ..Timing::default() }, "delay"),
        (Timing { jitter: -0.1, ..Timing::default() }, "jitter"),
        (Timing { drop: f64::NAN, ..Timing::default() }, "drop"),
    ] {
        assert!(effects(timing).validate().unwrap_err().to_string().starts_with(wanted));
    }
    let front = Front { hand_over: Some(0.0), ..Front::default() };
    assert!(front.validate().unwrap_err().to_string().starts_with("hand_over"));
}

/// The two-link arm with rotors on its joints.
#[derive(Clone, Copy)]
struct Rotors {
    arm: TwoLink,
    rotor: f64,
}

impl Arm<2> for Rotors {
    fn mass_matrix(&self, q: &Vector<2>) -> Matrix<2> {
        self.arm.mass_matrix(q) + Matrix::identity() * self.rotor
    }

    fn rigid_bias(&self, q: &Vector<2>, dq: &Vector<2>) -> Vector<2> {
        self.arm.rigid_bias(q, dq)
    }
}

/// Gears that are stiff make a rigid arm with the rotors added; soft ones and play do not.
#[test]
fn stiff_gears_are_a_rigid_arm_and_soft_ones_are_not() {
    let (rotor, gears) = (0.05, |stiffness: f64| Elastic::new([stiffness; 2], [0.05; 2]).unwrap());
    let nominal = paper::nominal().unwrap();
    let with_rotor = Rotors { arm: nominal, rotor };
    let of = |transmission: Option<Transmission<2>>| {
        let effects = Effects { transmission, ..Effects::default() };
        let options = Options { duration: 4.0, ..options(effects) };
        let (reference, mut state) = (paper::reference().unwrap(), State::new(()));
        let go_on = |_| ControlFlow::Continue(());
        match transmission {
            None => {
                let plant = Plant::new(with_rotor, Undisturbed);
                simulate(&plant, &plain(), &mut state, &reference, &options, go_on).unwrap()
            }
            Some(_) => {
                let plant = Plant::new(nominal, Undisturbed);
                simulate(&plant, &plain(), &mut state, &reference, &options, go_on).unwrap()
            }
        }
    };
    let rigid = of(None);
    let at = |stiffness, backlash| {
        let gears: Elastic<2> = gears(stiffness);
        let gears = gears.with_damping([5.0; 2]).unwrap().with_backlash([backlash; 2]).unwrap();
        of(Some(Transmission { gears, encoders: Side::Link }))
    };
    let apart = |one: &Run<2>| {
        assert_eq!(one.status, Status::Finished);
        let pairs = one.q.iter().zip(&rigid.q);
        pairs.map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1])).fold(0.0, f64::max)
    };
    let (stiff, soft, loose) = (apart(&at(1e6, 0.0)), apart(&at(3e2, 0.0)), apart(&at(1e4, 0.02)));
    assert!(stiff < 2e-4 && soft > 10.0 * stiff && loose > 10.0 * stiff, "{stiff} {soft} {loose}");
}

/// Counts how often it is told of a torque that a limit cut.
#[derive(Default)]
struct Counting(AtomicUsize, AtomicUsize);

impl Dynamic<2, 2> for Counting {
    fn estimate(&self, _: &Vector<2>, _: &Sample<2>) -> Vector<2> {
        Vector::zeros()
    }

    fn rate(&self, _: &Vector<2>, _: &Sample<2>, applied: &Applied<2>) -> Vector<2> {
        let told = if applied.limited() { &self.0 } else { &self.1 };
        told.fetch_add(1, Ordering::Relaxed);
        Vector::zeros()
    }
}

/// Where no limit acts, what a controller is told is what it asked for, to the bit: in a late loop,
/// and where samples are lost in it. A lost one is no limit.
#[test]
fn a_lost_sample_in_a_late_loop_is_no_limit() {
    for (delay, drop, jitter) in [(0, 0.3, 0.2), (1, 0.3, 0.0), (2, 0.5, 0.2), (4, 0.6, 0.0)] {
        let front = Front { velocity_filter: Some(60.0), delay, ..Front::default() };
        let law = computed();
        let controller = Controller::new(law, Counting::default()).with_front(front).unwrap();
        let timing = Timing { delay, drop, jitter };
        let effects = Effects { timing, ..Effects::default() };
        let options = Options { duration: 3.0, ..options(effects) };
        let run = run(&controller, DynamicState::new(), &options);
        assert_eq!(run.status, Status::Finished);
        let Counting(limited, free) = &controller.compensator;
        assert_eq!(limited.load(Ordering::Relaxed), 0, "{delay} {drop}");
        assert!(free.load(Ordering::Relaxed) > 1000);
    }
}

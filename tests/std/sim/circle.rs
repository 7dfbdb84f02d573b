//! Joints that turn without an end: an error around the circle, in step, in every loop and in every
//! record.

use std::f64::consts::{PI, TAU};

use nalgebra::Vector3;

use crate::common::{bits, everything, on};
use steadyarm::arm::{Arm, Inertia, JointKind, Link, Pose, Serial, SerialParameters};
use steadyarm::control::{
    self, ComputedTorque, FuzzyCompensator, FuzzyParameters, FuzzyState, Gains, Sample, State,
};
use steadyarm::fuzzy::{Axis, Form, FuzzyBasis};
use steadyarm::math::{Matrix, Vector};
use steadyarm::paper::{CENTERS, WIDTH};
use steadyarm::plant::{Plant, Undisturbed};
use steadyarm::reference::{Reference, Setpoint};
use steadyarm::sim::{
    Method, Motion, Options, Record, Run, Status, Tolerance, hold_torque, simulate,
};

type Controller = control::Controller<2, ComputedTorque<2, Serial<2>>, FuzzyCompensator<2>>;
type Memory = State<2, FuzzyState<2, Vec<f64>>>;

/// A column that turns about the vertical, and an arm that turns about a horizontal axis on it.
fn arm(kinds: [JointKind; 2]) -> Serial<2> {
    let moments = Matrix::<3>::from_diagonal(&Vector3::new(0.3, 0.2, 0.25));
    let body = Inertia { mass: 2.0, com: Vector3::new(0.1, 0.0, 0.2), moments };
    let above = Pose::at(Vector3::new(0.0, 0.0, 0.4));
    let links = [
        Link::new(kinds[0], Pose::IDENTITY, Vector3::z(), body),
        Link::new(kinds[1], above, Vector3::y(), body),
    ];
    let gravity = [0.0, 0.0, -9.81];
    Serial::new(SerialParameters { links, tip: Pose::IDENTITY, gravity }).unwrap()
}

/// It learns from (e, ė), with every modification; the model lacks a third of the mass.
fn controller(kinds: [JointKind; 2]) -> Controller {
    let (gains, axis) =
        (Gains::new([8.0; 2], [5.5; 2]).unwrap(), Axis { centers: &CENTERS, widths: &[WIDTH] });
    let parameters = FuzzyParameters { adaptation: everything(70.0), ..FuzzyParameters::default() };
    let basis = FuzzyBasis::new(Form::Grid, true, &[axis; 4]).unwrap();
    let compensator = FuzzyCompensator::new(basis, &gains, parameters).unwrap();
    let mut parameters = *arm(kinds).parameters();
    parameters.links.iter_mut().for_each(|link| link.inertia.mass = 1.5);
    Controller::new(ComputedTorque::new(Serial::new(parameters).unwrap(), gains), compensator)
}

const ENDLESS: [JointKind; 2] = [JointKind::Continuous; 2];
const BOUNDED: [JointKind; 2] = [JointKind::Revolute; 2];

fn fresh(controller: &Controller) -> Memory {
    State::new(controller.compensator.state())
}

/// Torques of 200 steps and the state they end in, where the encoders are off by these turns from
/// step 50 on. Positions are multiples of 2⁻⁴⁰, so that a few turns of the f64 next to 2π can be
/// added to them without rounding.
fn driven(controller: &Controller, turns: [f64; 2]) -> (Vec<Vector<2>>, Vec<u8>) {
    let mut state = fresh(controller);
    let grid = |x: f64| (x * 2f64.powi(40)).round() / 2f64.powi(40);
    let tau = (0..200).map(|k| {
        let t = 0.01 * f64::from(k);
        let jump = if k < 50 { 0.0 } else { TAU };
        let q = Vector::<2>::new(grid((2.0 * t).sin()), grid(0.7 * t.cos()));
        let read = q + Vector::<2>::from(turns) * jump;
        let desired = Setpoint::at_rest(Vector::<2>::new(grid(0.3), grid(-0.2)));
        controller.step(&mut state, &read, &Vector::zeros(), &desired, 0.01).unwrap().tau
    });
    let tau = tau.collect();
    // What is pending has the position as it was read.
    controller.settle(&mut state);
    (tau, controller.save(&state))
}

/// The column's angle is in no entry of M and H, so its turns leave the bits of all torques.
#[test]
fn a_jump_of_an_encoder_by_turns_changes_no_bit_of_the_torque() {
    let controller = controller(ENDLESS);
    let (tau, saved) = driven(&controller, [0.0; 2]);
    for turns in [1.0, -1.0, 2.0, -4.0] {
        let (jumped, after) = driven(&controller, [turns, 0.0]);
        for (k, (one, other)) in tau.iter().zip(&jumped).enumerate() {
            assert_eq!(bits(one.as_slice()), bits(other.as_slice()), "{turns} turns, step {k}");
        }
        assert_eq!(saved, after, "{turns} turns");
    }
}

/// Where the model has the angle, it is as it was read: sin(q + 2π) is off by the rounding of 2π,
/// 2.4e-16 a turn.
#[test]
fn a_jump_of_any_joint_leaves_the_torque_but_for_the_rounding_of_a_turn() {
    let (tau, _) = driven(&controller(ENDLESS), [0.0; 2]);
    for turns in [[1.0, 1.0], [-2.0, 1.0], [0.0, -4.0]] {
        let (jumped, _) = driven(&controller(ENDLESS), turns);
        for (one, other) in tau.iter().zip(&jumped) {
            assert!((one - other).amax() < 1e-11, "{turns:?}: {one} {other}");
        }
    }
    // A joint with two ends is really a turn away.
    let (bounded, _) = driven(&controller(BOUNDED), [0.0; 2]);
    let (jumped, _) = driven(&controller(BOUNDED), [1.0, 0.0]);
    assert!((bounded[60] - jumped[60]).amax() > 10.0);
}

#[test]
fn errors_below_half_a_turn_keep_their_bits() {
    let (tau, saved) = driven(&controller(BOUNDED), [0.0; 2]);
    let (same, after) = driven(&controller(ENDLESS), [0.0; 2]);
    let all =
        |tau: &[Vector<2>]| tau.iter().flat_map(|tau| bits(tau.as_slice())).collect::<Vec<_>>();
    assert_eq!(all(&tau), all(&same));
    assert_eq!(saved, after);
}

#[test]
fn only_the_joints_that_wrap_have_their_error_taken_around_the_circle() {
    let (q, zero) = (Vector::<2>::new(4.0, 4.0), Vector::zeros());
    let rest = Setpoint::at_rest(zero);
    let seen = |kinds| controller(kinds).sample(&q, &zero, &rest).e;
    assert_eq!(seen(BOUNDED), q);
    assert_eq!(
        seen([JointKind::Continuous, JointKind::Revolute]),
        Vector::<2>::new(4.0 - TAU, 4.0)
    );
    let wraps = arm([JointKind::Revolute, JointKind::Continuous]).wraps();
    assert_eq!(wraps, [false, true]);
    let sample = Sample::wrapped(q, zero, rest, &wraps);
    assert_eq!((sample.e, sample.q), (Vector::<2>::new(4.0, 4.0 - TAU), q));
    // Half a turn is the lower end.
    let half = Sample::wrapped(Vector::<2>::new(PI, -PI), zero, rest, &[true; 2]);
    assert_eq!(half.e, Vector::<2>::new(-PI, -PI));
}

/// Both joints turn at 2 rad/s, eight turns in all; with `wrapped` the reference says so as an
/// angle in [−π, π).
#[derive(Clone, Copy)]
struct Turning {
    wrapped: bool,
}

impl Reference<2> for Turning {
    fn at(&self, t: f64) -> Setpoint<2> {
        let angle = 2.0 * t;
        let angle = if self.wrapped { angle - TAU * ((angle + PI) / TAU).floor() } else { angle };
        Setpoint { q: Vector::repeat(angle), dq: Vector::repeat(2.0), ddq: Vector::zeros() }
    }
}

fn options(method: Method, control_period: Option<f64>) -> Options<2> {
    let (duration, dt, q0, dq0) = (8.0, 1e-2, [0.4, -0.3], [2.0; 2]);
    Options { duration, dt, method, control_period, q0, dq0, ..Options::default() }
}

fn tracked(reference: Turning, options: &Options<2>) -> Run<2> {
    let (plant, controller) = (Plant::new(arm(ENDLESS), Undisturbed), controller(ENDLESS));
    simulate(&plant, &controller, &mut fresh(&controller), &reference, options, on).unwrap()
}

const DP54: Method = Method::Dp54(Tolerance { rtol: 1e-9, atol: 1e-12 });

/// The same motion by both references, in every loop: RK4 and Dormand-Prince in continuous time,
/// and sampled.
#[test]
fn a_reference_that_jumps_by_a_turn_is_the_one_that_goes_on() {
    for (method, period) in [(Method::Rk4, None), (DP54, None), (Method::Rk4, Some(1e-2))] {
        let options = options(method, period);
        let (on, back) = (
            tracked(Turning { wrapped: false }, &options),
            tracked(Turning { wrapped: true }, &options),
        );
        assert_eq!((on.status, back.status), (Status::Finished, Status::Finished));
        for k in 0..on.t.len() {
            for n in 0..2 {
                assert!(back.e[k][n].abs() < 0.6, "{} s: {:?}", back.t[k], back.e[k]);
                assert!((on.e[k][n] - back.e[k][n]).abs() < 1e-8, "{} s", on.t[k]);
                assert!((on.tau[k][n] - back.tau[k][n]).abs() < 1e-6, "{} s", on.t[k]);
            }
        }
        assert!(on.q.last().unwrap()[0] > 15.0);
    }
}

#[test]
fn the_loop_of_a_user_and_the_record_of_the_motion_have_the_same_bits() {
    let (reference, options) = (Turning { wrapped: true }, options(Method::Rk4, Some(1e-2)));
    let run = tracked(reference, &options);
    let (plant, controller) = (Plant::new(arm(ENDLESS), Undisturbed), controller(ENDLESS));
    let (mut state, h) = (fresh(&controller), options.dt);
    let mut at = Motion { q: options.q0.into(), dq: options.dq0.into() };
    for k in 0..run.t.len() - 1 {
        let desired = reference.at(run.t[k]);
        let command = controller.step(&mut state, &at.q, &at.dq, &desired, h).unwrap();
        assert_eq!(bits(command.tau.as_slice()), bits(&run.tau[k]), "row {k}");
        at = hold_torque(&plant, &at, &command.tau, run.t[k], h);
    }
    let mut motion = tracked(reference, &Options { record: Record::Motion, ..options });
    motion.add_reference(&reference, &controller.law.arm.wraps());
    assert_eq!(motion.e.concat(), run.e.concat());
}

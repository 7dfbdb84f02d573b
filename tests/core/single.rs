//! The controller in single precision says what the one in double precision says.

use steadyarm::arm::{
    Arm, Inertia, JointFriction, JointKind, Link, Pose, Serial, SerialParameters, TwoLink,
};
use steadyarm::control::{
    ComputedTorque, Controller, FuzzyCompensator, FuzzyParameters, Gains, Law, Limits,
    NoCompensation, Single, SingleState, State,
};
use steadyarm::fuzzy::{Axis, Form, FuzzyBasis};
use steadyarm::math::{Matrix, Vector};
use steadyarm::paper::{self, Reading};
use steadyarm::reference::{Reference, Setpoint};

const PERIOD: f64 = 1e-3;

fn single<const N: usize>(x: &Vector<N>) -> Vector<N, f32> {
    let mut y = Vector::<N, f32>::repeat(0.0);
    for n in 0..N {
        y[n] = x[n] as f32;
    }
    y
}

fn single_setpoint<const N: usize>(at: &Setpoint<N>) -> Setpoint<N, f32> {
    Setpoint { q: single(&at.q), dq: single(&at.dq), ddq: single(&at.ddq) }
}

/// The paper's controller with a grid a joint, in double precision and in single.
fn paper_controller() -> (paper::PaperController, Single<2, 25>, SingleState<2, 25>) {
    let form = Form::PerJoint { joints: 2 };
    let controller = paper::controller(Reading { form, normalized: true, gain: 700.0 }).unwrap();
    let mut state = State::new(controller.compensator.state_in([0.0; 2048]).unwrap());
    let (single, single_state) = Single::of(&controller, &mut state).unwrap();
    (controller, single, single_state)
}

/// The RMS error of a loop with the paper's arm, whose torque `decide` gives, for 4 s.
fn rms(mut decide: impl FnMut(&Vector<2>, &Vector<2>, &Setpoint<2>) -> Vector<2>) -> f64 {
    let (arm, reference) = (paper::actual().unwrap(), paper::reference().unwrap());
    let (mut q, mut dq) = (Vector::<2>::new(0.5, -0.5), Vector::<2>::zeros());
    let (mut sum, steps) = (0.0, 4000);
    for k in 0..steps {
        let desired = reference.at(f64::from(k) * PERIOD);
        let tau = decide(&q, &dq, &desired);
        dq += arm.forward_dynamics(&q, &dq, &tau) * PERIOD;
        q += dq * PERIOD;
        sum += (q - desired.q).norm_squared();
    }
    (sum / f64::from(steps)).sqrt()
}

#[test]
fn a_loop_in_single_precision_tracks_as_one_in_double() {
    let (controller, single_controller, mut single_state) = paper_controller();
    let mut state = State::new(controller.compensator.state_in([0.0; 2048]).unwrap());
    let double =
        rms(|q, dq, desired| controller.step(&mut state, q, dq, desired, PERIOD).unwrap().tau);
    let tracked = rms(|q, dq, desired| {
        let (q, dq, desired) = (single(q), single(dq), single_setpoint(desired));
        let tau = single_controller.step(&mut single_state, &q, &dq, &desired, 1e-3).unwrap();
        Vector::<2>::new(tau[0].into(), tau[1].into())
    });
    assert!((tracked / double - 1.0).abs() < 1e-4, "{tracked} {double}");
    // Without what it learns, the error is another one.
    let plain = Controller::new(
        ComputedTorque::new(paper::nominal().unwrap(), paper::gains().unwrap()),
        NoCompensation,
    );
    let mut state = State::new(());
    let unlearnt =
        rms(|q, dq, desired| plain.step(&mut state, q, dq, desired, PERIOD).unwrap().tau);
    assert!(unlearnt > 1.5 * double, "{unlearnt} {double}");
    assert!(single_state.weights().iter().flatten().any(|w| w.abs() > 0.1));
    single_controller.reset(&mut single_state);
    assert_eq!(single_state, paper_controller().2);
}

/// A chain with a joint that slides, with friction of all kinds but dry.
fn chain() -> Serial<4> {
    let links = core::array::from_fn(|i| {
        let place = Pose::at([0.3, 0.05 * i as f64, -0.1].into());
        let axis = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]][i % 3].into();
        let inertia = Inertia {
            moments: Matrix::<3>::identity() * 0.2,
            ..Inertia::point_mass(2.0, [0.1, -0.05, 0.02].into())
        };
        let kind = if i == 1 { JointKind::Prismatic } else { JointKind::Revolute };
        let friction = JointFriction {
            viscous: 0.5,
            coulomb: [0.3, 0.2],
            stribeck: 0.1,
            stribeck_speed: 0.3,
            smoothing: 0.2,
        };
        Link { friction, ..Link::new(kind, place, axis, inertia) }
    });
    let gravity = [0.0, 0.0, -9.81];
    Serial::new(SerialParameters { links, tip: Pose::IDENTITY, gravity }).unwrap()
}

/// Torques of both, sample by sample, along a motion that does not depend on them.
#[test]
fn torques_of_a_chain_are_those_of_double_precision() {
    let gains = Gains::new([60.0; 4], [14.0; 4]).unwrap();
    let axis = Axis { centers: &[-1.0, -0.5, 0.0, 0.5, 1.0], widths: &[0.6] };
    for normalized in [true, false] {
        let basis = FuzzyBasis::new(Form::PerJoint { joints: 4 }, normalized, &[axis; 8]).unwrap();
        let learns = FuzzyCompensator::new(basis, &gains, FuzzyParameters::default()).unwrap();
        let limits = Limits { effort_limit: [3.0, 4.0, 5.0, 3.0], ..Limits::default() };
        let law = ComputedTorque::new(chain(), gains);
        let controller = Controller::new(law, learns).with_limits(limits).unwrap();
        let mut state = State::new(controller.compensator.state_in([0.0; 4096]).unwrap());
        let (single_controller, mut single_state) =
            Single::<4, 25>::of(&controller, &mut state).unwrap();
        let mut limited = 0;
        for k in 0..3000 {
            let t = f64::from(k) * PERIOD;
            let sin = |rate: f64| libm::sin(rate * t);
            let q = Vector::<4>::new(0.8 * sin(1.0), 0.2 * sin(2.1), sin(1.7), -0.6 * sin(0.7));
            let dq = Vector::<4>::new(0.9 * sin(1.3), 0.4 * sin(2.6), sin(3.1), 2.0 * sin(1.9));
            let desired = Setpoint { q: q * 0.9, dq: dq * 0.8, ddq: dq * 1.1 };
            let command = controller.step(&mut state, &q, &dq, &desired, PERIOD).unwrap();
            let (q, dq, desired) = (single(&q), single(&dq), single_setpoint(&desired));
            let tau = single_controller.step(&mut single_state, &q, &dq, &desired, 1e-3).unwrap();
            for n in 0..4 {
                let off = (f64::from(tau[n]) - command.tau[n]).abs();
                assert!(off < 3e-4, "{k} {n}: {} {}", tau[n], command.tau[n]);
            }
            limited += usize::from(command.limited);
        }
        assert!((100..2900).contains(&limited), "{limited}");
    }
}

#[test]
fn what_is_refused_changes_nothing() {
    let (_, controller, mut state) = paper_controller();
    let at = Setpoint { q: [0.1, 0.2].into(), dq: [0.0; 2].into(), ddq: [0.0; 2].into() };
    let (q, dq) = (Vector::<2, f32>::new(0.3, 0.1), Vector::<2, f32>::new(0.0, 0.2));
    for _ in 0..3 {
        controller.step(&mut state, &q, &dq, &at, 1e-3).unwrap();
    }
    let before = state.clone();
    let wrong = Vector::<2, f32>::new(0.0, f32::NAN);
    let far = Vector::<2, f32>::new(2e5, 0.0);
    let mut step = |q, dq, dt| controller.step(&mut state, q, dq, &at, dt).unwrap_err();
    assert_eq!(
        (step(&wrong, &dq, 1e-3).parameter(), step(&wrong, &dq, 1e-3).index()),
        ("q", Some(1))
    );
    assert_eq!(step(&far, &dq, 1e-3).parameter(), "q");
    assert_eq!(step(&q, &wrong, 1e-3).parameter(), "dq");
    assert_eq!(step(&q, &dq, 0.0).parameter(), "dt");
    assert_eq!(state, before);
}

#[test]
fn a_controller_that_has_no_single_form_is_refused_by_name() {
    let (arm, gains) = (paper::nominal().unwrap(), paper::gains().unwrap());
    fn refused<L: Law<2>>(controller: &Controller<2, L, NoCompensation>) -> &'static str {
        Single::<2, 25>::of(controller, &mut State::new(())).unwrap_err().parameter()
    }
    let rated = Limits { effort_rate_limit: [1e3; 2], ..Limits::default() };
    let plain = Controller::new(ComputedTorque::new(arm, gains), NoCompensation);
    assert_eq!(refused(&plain.with_limits(rated).unwrap()), "effort_rate_limit");
    let dry =
        steadyarm::arm::Friction { coulomb: [1.0; 2], smoothing: [0.0; 2], ..Default::default() };
    let dry: TwoLink = arm.with_friction(dry).unwrap();
    assert_eq!(refused(&Controller::new(ComputedTorque::new(dry, gains), NoCompensation)), "law");
    let grid = Reading { form: Form::Grid, normalized: true, gain: 700.0 };
    let controller = paper::controller(grid).unwrap();
    let mut state = State::new(controller.compensator.state_in([0.0; 8192]).unwrap());
    let error = Single::<2, 25>::of(&controller, &mut state).unwrap_err();
    assert_eq!(error.parameter(), "compensator");
    let (controller, ..) = paper_controller();
    let mut state = State::new(controller.compensator.state_in([0.0; 2048]).unwrap());
    assert_eq!(Single::<2, 24>::of(&controller, &mut state).unwrap_err().parameter(), "rules");
}

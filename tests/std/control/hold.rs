//! The hold rule: a step first ends the period before with the torque that acted in it. Saturation
//! of the drive, take-over, and what is pending.

use crate::common::{
    self, Adaptive, AdaptiveState, FORMS, Random, adaptive, bits, ended, everything, fresh, law,
    learnt, modified,
};
use steadyarm::arm::{Arm, TwoLink, TwoLinkParameters};
use steadyarm::control::{
    Command, ComputedTorque, Controller, Inputs, Limits, NoCompensation, State,
};
use steadyarm::fuzzy::Form;
use steadyarm::math::Vector;
use steadyarm::paper;
use steadyarm::reference::{Reference, Setpoint};
use steadyarm::sim::{Motion, Options, hold_torque, simulate};

const H: f64 = 1e-3;

fn rest() -> Setpoint<2> {
    Setpoint::at_rest(Vector::zeros())
}

/// A step on a random sample, told what acted before.
fn step(
    controller: &Adaptive,
    state: &mut AdaptiveState,
    applied: Option<&Vector<2>>,
    random: &mut Random,
) -> Command<2> {
    let (q, dq) = (random.vector(0.7), random.vector(1.0));
    let desired = Setpoint::at_rest(random.vector(0.7));
    controller.step_after(state, applied, &q, &dq, &desired, H).unwrap()
}

/// To be told what was commanded is to be told nothing.
#[test]
fn the_commanded_torque_told_gives_the_bits_of_the_default() {
    for form in FORMS {
        let controller = modified(form, true, Inputs::error(), everything(70.0));
        let (mut told, mut silent) = (fresh(&controller), fresh(&controller));
        let (mut one, mut two) = (Random(1), Random(1));
        let mut last: Option<Vector<2>> = None;
        for _ in 0..300 {
            let a = step(&controller, &mut told, last.as_ref(), &mut one);
            assert_eq!(a, step(&controller, &mut silent, None, &mut two));
            assert_eq!(controller.save(&told), controller.save(&silent));
            last = Some(a.tau);
        }
    }
}

/// Whatever another torque it was: the estimate of the next sample has nothing of that period but
/// the leak.
#[test]
fn nothing_is_learnt_from_a_period_in_which_another_torque_acted() {
    for form in FORMS {
        let controller = modified(form, true, Inputs::error(), law(70.0));
        for share in [0.0, 0.5, -1.0, 1.0 + f64::EPSILON, 100.0] {
            let mut state = fresh(&controller);
            let mut random = Random(2);
            (0..20).for_each(|_| _ = step(&controller, &mut state, None, &mut random));
            let tau = state.last_tau.unwrap();
            let before = common::weights(&controller, state.compensator());
            assert_ne!(bits(&learnt(&controller, &state)), bits(&before));
            step(&controller, &mut state, Some(&(tau * share)), &mut random);
            let after = common::weights(&controller, state.compensator());
            assert_eq!(bits(&after), bits(&before), "{form:?} {share}");
        }
    }
}

/// The limit of the controller cut; that the drive did not go beyond it is no news.
#[test]
fn a_torque_that_the_controller_cut_teaches_nothing_even_if_it_acted() {
    let limits = Limits { effort_limit: [0.5; 2], ..Limits::default() };
    let controller = adaptive(Form::Grid, false, 70.0).with_limits(limits).unwrap();
    let mut state = fresh(&controller);
    let mut random = Random(3);
    for _ in 0..50 {
        let last = state.last_tau;
        assert!(step(&controller, &mut state, last.as_ref(), &mut random).limited);
    }
    assert_eq!(ended(&controller, &state).weights_norm(), 0.0);
}

#[test]
fn what_no_drive_can_apply_is_refused_by_name_and_changes_nothing() {
    let controller = adaptive(Form::Concat, true, 7.0);
    let mut state = fresh(&controller);
    let zeros = Vector::zeros();
    for pending in [false, true] {
        if pending {
            step(&controller, &mut state, None, &mut Random(4));
        }
        let before = format!("{state:?}");
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let applied = Vector::<2>::new(0.0, bad);
            let told = Some(&applied);
            let refused = [
                controller.step_after(&mut state, told, &zeros, &zeros, &rest(), H).map(drop),
                controller.end_period(&mut state, told),
            ];
            for refusal in refused {
                let error = refusal.unwrap_err().to_string();
                assert!(error.starts_with("applied[1]: got "), "{error}");
            }
            assert_eq!(format!("{state:?}"), before);
        }
    }
}

/// Before the first step, and after the period was ended otherwise.
#[test]
fn without_a_pending_period_what_acted_says_nothing() {
    let controller = adaptive(Form::Concat, true, 70.0);
    let (mut told, mut silent) = (fresh(&controller), fresh(&controller));
    let (mut one, mut two) = (Random(5), Random(5));
    for _ in 0..20 {
        let other = Vector::<2>::new(3.0, -4.0);
        let a = step(&controller, &mut told, Some(&other), &mut one);
        assert_eq!(a, step(&controller, &mut silent, None, &mut two));
        controller.settle(&mut told);
    }
    assert_eq!(learnt(&controller, &told), learnt(&controller, &silent));
}

/// 0.01 N·m: next to nothing can act, and whatever is asked for is cut.
#[test]
fn nothing_is_learnt_while_the_plants_actuators_saturate() {
    let plant = common::plant().with_effort_limit([0.01; 2]).unwrap();
    let controller = adaptive(Form::Grid, false, 70.0);
    for control_period in [None, Some(H), Some(5.0 * H)] {
        let mut state = fresh(&controller);
        let options =
            Options { duration: 2.0, control_period, q0: [0.5, -0.5], ..Options::default() };
        let reference = common::reference();
        let run =
            simulate(&plant, &controller, &mut state, &reference, &options, common::on).unwrap();
        assert!(run.weights_norm.iter().all(|norm| *norm == 0.0), "{control_period:?}");
        assert_eq!(ended(&controller, &state).weights_norm(), 0.0);
    }
}

/// The paper's third simulation as claimed, while the drive gives at most 6 N·m for 5 s: the errors
/// of every millisecond, and |W| at the release. The controller knows of no limit; it is `told`
/// what acted, or not.
fn saturated(drive: f64, told: bool) -> (Vec<f64>, f64) {
    let controller = paper::controller(paper::CLAIMED).unwrap();
    let (reference, free) = (common::reference(), common::plant());
    let weak = common::plant().with_effort_limit([drive; 2]).unwrap();
    let (mut state, mut motion) = (fresh(&controller), Motion::<2>::zeros());
    let (mut errors, mut norm, mut applied) = (Vec::new(), 0.0, None);
    for k in 0..15_000 {
        let (t, plant) = (f64::from(k) * H, if k < 5_000 { &weak } else { &free });
        let desired = reference.at(t);
        let told = applied.as_ref().filter(|_| told);
        let command =
            controller.step_after(&mut state, told, &motion.q, &motion.dq, &desired, H).unwrap();
        if k == 5_000 {
            norm = state.compensator().weights_norm();
        }
        applied = Some(plant.applied(&command.tau));
        motion = hold_torque(plant, &motion, &command.tau, t, H);
        errors.push((motion.q - desired.q).norm());
    }
    (errors, norm)
}

/// The time after the release at which the error is back in 1.5 times its usual range [s].
fn recovery(errors: &[f64]) -> f64 {
    let usual = saturated(f64::INFINITY, true).0[5_000..].iter().copied().fold(0.0, f64::max);
    (errors.iter().rposition(|e| *e > 1.5 * usual).unwrap() + 1) as f64 * H - 5.0
}

/// In continuous time, where the loop knows what acts, |W| is 5.56 at the release and the error is
/// back after 0.392 s: `simulate` with the same plant.
#[test]
fn a_controller_that_is_told_recovers_from_saturation_as_in_continuous_time() {
    let (errors, norm) = saturated(6.0, true);
    assert!((norm - 5.56).abs() < 0.1, "{norm}");
    assert!((recovery(&errors) - 0.39).abs() < 0.02, "{}", recovery(&errors));
    let (errors, norm) = saturated(6.0, false);
    assert!(norm > 40.0 && recovery(&errors) > 2.0, "{norm} {}", recovery(&errors));
}

/// The paper's arm upright: gravity pulls at both joints.
fn upright(limits: Limits<2>) -> Controller<2, ComputedTorque<2, TwoLink>> {
    let parameters = TwoLinkParameters { gravity: 9.81, ..TwoLinkParameters::default() };
    let law = ComputedTorque::new(TwoLink::new(parameters).unwrap(), paper::gains().unwrap());
    Controller::new(law, NoCompensation).with_limits(limits).unwrap()
}

/// One sample far from the set-point, where the law asks for more than any limit here.
fn first(
    controller: &Controller<2, ComputedTorque<2, TwoLink>>,
    state: &mut State<2>,
    q: [f64; 2],
) -> Command<2> {
    let far = Setpoint::at_rest(Vector::<2>::new(2.0, -2.0));
    controller.step(state, &q.into(), &Vector::zeros(), &far, H).unwrap()
}

/// The rate limit counts from the torque at take-over: the one stated, or by default the law's
/// resting torque. One rounding of last + change.
#[test]
fn the_rate_limit_holds_for_the_first_sample_and_after_a_reset() {
    let limits = Limits { effort_rate_limit: [1000.0, 500.0], ..Limits::default() };
    let controller = upright(limits);
    for q in [[0.1, 0.2], [-1.3, 2.0]] {
        let resting = controller.law.arm.gravity(&q.into());
        assert!(resting.norm() > 1.0);
        for stated in [None, Some([30.0, -7.0])] {
            let from = stated.map_or(resting, Vector::<2>::from);
            let mut state = State::new(());
            for life in 0..2 {
                if let Some(tau) = stated {
                    state.take_over(&tau.into()).unwrap();
                }
                let command = first(&controller, &mut state, q);
                assert!(command.limited);
                let change = command.tau - from;
                assert!((change[0].abs() - 1.0).abs() < 1e-12, "{life} {stated:?} {change}");
                assert!((change[1].abs() - 0.5).abs() < 1e-12, "{life} {stated:?} {change}");
                controller.reset(&mut state);
                assert_eq!(state, State::new(()));
            }
        }
    }
}

/// An effort limit below the resting torque comes before the rate limit.
#[test]
fn the_effort_limit_holds_at_take_over_whatever_is_on_the_robot() {
    let limits = Limits { effort_limit: [2.0; 2], effort_rate_limit: [100.0; 2] };
    let controller = upright(limits);
    let mut state = State::new(());
    state.take_over(&Vector::repeat(1e10)).unwrap();
    assert!(first(&controller, &mut state, [0.1; 2]).tau.amax() <= 2.0);
    controller.reset(&mut state);
    assert!(first(&controller, &mut state, [0.1; 2]).tau.amax() <= 2.0);
}

#[test]
fn without_a_rate_limit_the_first_torque_is_the_laws() {
    let controller = upright(Limits { effort_limit: [1e3; 2], ..Limits::default() });
    let command = first(&controller, &mut State::new(()), [0.1, 0.2]);
    assert!(!command.limited && command.tau == command.model);
}

#[test]
fn a_torque_at_take_over_that_no_arm_has_is_refused_and_changes_nothing() {
    let mut state = State::<2>::new(());
    for bad in [f64::NAN, f64::NEG_INFINITY, 1.1e10] {
        let error = state.take_over(&Vector::<2>::new(0.0, bad)).unwrap_err().to_string();
        assert!(error.starts_with("last_tau[1]: got "), "{error}");
        assert_eq!(state, State::new(()));
    }
}

/// The drive let through nothing; the next torque is within the limit of the one commanded.
#[test]
fn the_rate_limit_counts_from_the_torque_commanded_last() {
    let controller = upright(Limits { effort_rate_limit: [1000.0; 2], ..Limits::default() });
    let mut state = State::new(());
    let mut last = first(&controller, &mut state, [0.1, 0.2]).tau;
    for _ in 0..10 {
        let far = Setpoint::at_rest(Vector::<2>::new(2.0, -2.0));
        let (q, zeros) = (Vector::<2>::new(0.1, 0.2), Vector::zeros());
        let told = Some(&zeros);
        let tau = controller.step_after(&mut state, told, &q, &zeros, &far, H).unwrap().tau;
        assert!(((tau - last).amax() - 1.0).abs() < 1e-12, "{tau} after {last}");
        last = tau;
    }
}

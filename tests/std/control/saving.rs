//! Saved states: the same torques afterwards, and an error for every damage.

use crate::common::{
    Adaptive, AdaptiveState, Random, bits, ended, everything, fresh, law, learnt, modified,
};
use steadyarm::control::{Adaptation, Inputs, Limits, Origin};
use steadyarm::fuzzy::Form;
use steadyarm::reference::Setpoint;
use steadyarm::{Error, Problem};

fn controller(form: Form, everything_on: bool) -> Adaptive {
    let adaptation = if everything_on { everything(7.0) } else { law(7.0) };
    let limits = Limits { effort_limit: [30.0; 2], effort_rate_limit: [1e4; 2] };
    modified(form, false, Inputs::error(), adaptation).with_limits(limits).unwrap()
}

fn torque(controller: &Adaptive, state: &mut AdaptiveState, random: &mut Random) -> Vec<u64> {
    let (q, dq) = (random.vector(0.5), random.vector(1.0));
    let desired = Setpoint::at_rest(random.vector(0.5));
    bits(controller.step(state, &q, &dq, &desired, 1e-3).unwrap().tau.as_slice())
}

fn taught(controller: &Adaptive, warm: bool) -> AdaptiveState {
    let (mut state, mut random) = (fresh(controller), Random(9));
    if warm {
        let prior = vec![0.1; controller.compensator.weights_len()];
        controller.compensator.warm_start(controller.settle(&mut state), &prior).unwrap();
    }
    (0..500).for_each(|_| _ = torque(controller, &mut state, &mut random));
    state
}

#[test]
fn a_restored_state_gives_the_next_ten_thousand_torques_bit_for_bit() {
    for form in [Form::Grid, Form::PerJoint { joints: 2 }] {
        for (everything_on, warm) in [(false, false), (true, false), (true, true), (false, true)] {
            let controller = controller(form, everything_on);
            let mut state = taught(&controller, warm);
            let bytes = controller.save(&state);
            let mut restored = fresh(&controller);
            controller.restore(&mut restored, &bytes).unwrap();
            assert_eq!(controller.save(&restored), bytes);
            let (mut one, mut two) = (Random(10), Random(10));
            for k in 0..10_000 {
                let expected = torque(&controller, &mut state, &mut one);
                let found = torque(&controller, &mut restored, &mut two);
                assert_eq!(found, expected, "{form:?} {everything_on} {warm}: torque {k}");
            }
        }
    }
}

#[test]
fn a_frozen_state_is_restored_frozen() {
    let controller = controller(Form::Concat, true);
    let mut state = taught(&controller, false);
    controller.settle(&mut state).freeze();
    let bytes = controller.save(&state);
    let mut restored = fresh(&controller);
    controller.restore(&mut restored, &bytes).unwrap();
    assert!(ended(&controller, &restored).frozen());
}

#[test]
fn every_damaged_or_shortened_file_is_an_error_and_changes_nothing() {
    let controller = controller(Form::Shared, true);
    let bytes = controller.save(&taught(&controller, true));
    let mut state = taught(&controller, false);
    let before = format!("{state:?}");
    let mut refused = |bytes: &[u8]| {
        assert!(controller.restore(&mut state, bytes).is_err());
        assert_eq!(format!("{state:?}"), before);
    };
    for place in 0..bytes.len() {
        refused(&bytes[..place]);
        for bit in [0, 3, 7] {
            let mut damaged = bytes.clone();
            damaged[place] ^= 1 << bit;
            refused(&damaged);
        }
    }
    refused(&[&bytes[..], &[0]].concat());
}

#[test]
fn a_file_of_another_controller_is_refused() {
    let (shared, concat) = (controller(Form::Shared, true), controller(Form::Concat, true));
    let bytes = shared.save(&taught(&shared, true));
    let other = concat.restore(&mut fresh(&concat), &bytes).unwrap_err();
    assert_eq!(other, Error::wrong_length("rules", 5, 20));
    let plain = controller(Form::Shared, false);
    let mut state = fresh(&plain);
    let without = plain.restore(&mut state, &bytes).unwrap_err();
    assert!(matches!(without.problem(), Problem::OtherController { .. }), "{without}");
    // It has no use for the prior that is in there.
    let without = plain.restore_from_other(&mut state, &bytes).unwrap_err();
    assert!(matches!(without.problem(), Problem::Damaged { .. }), "{without}");
    assert!(learnt(&plain, &state).iter().all(|w| *w == 0.0));
}

/// Magic of 12 bytes, joints, rules; then the flags, of which 16 says that the norms of both joints
/// stand before the checksum.
fn without_norms(bytes: &[u8]) -> Vec<u8> {
    let mut old = bytes[..bytes.len() - 24].to_vec();
    assert_eq!(old[28] & 16, 16);
    old[28] -= 16;
    let fnv = |hash: u64, byte: &u8| (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3);
    let sum = old.iter().fold(0xcbf2_9ce4_8422_2325, fnv);
    old.extend(sum.to_le_bytes());
    old
}

#[test]
fn a_file_from_before_it_had_norms_is_read() {
    for warm in [false, true] {
        let controller = controller(Form::Concat, true);
        let state = taught(&controller, warm);
        let bytes = controller.save(&state);
        let mut restored = fresh(&controller);
        controller.restore(&mut restored, &without_norms(&bytes)).unwrap();
        let norm = ended(&controller, &state).weights_norm();
        assert!((ended(&controller, &restored).weights_norm() - norm).abs() <= 1e-14 * norm);
        assert_eq!(learnt(&controller, &restored), learnt(&controller, &state));
        assert_eq!(restored.last_tau, state.last_tau);
    }
}

#[test]
fn a_file_of_version_1_is_taken_and_says_that_it_does_not_say_whose_it_is() {
    let adaptation = Adaptation { leak_rate: 0.1, ..law(7.0) };
    let controller = modified(Form::Shared, true, Inputs::error(), adaptation);
    let old = include_bytes!("../../python/files/state_1_shared.bin");
    let mut state = fresh(&controller);
    assert_eq!(controller.restore(&mut state, old), Ok(Origin::Unknown));
    assert_eq!((state.steps, state.last_tau.is_some()), (50, true));
    assert!(learnt(&controller, &state).iter().any(|w| *w != 0.0));
    // What is saved now says it.
    let bytes = controller.save(&state);
    assert_eq!(controller.restore(&mut state, &bytes), Ok(Origin::Same));
}

#[test]
fn a_state_of_another_meaning_is_taken_only_by_those_who_say_so() {
    let controller = controller(Form::Shared, false);
    let bytes = controller.save(&taught(&controller, false));
    let mut other = controller.clone();
    other.law.gains.kp[1] += 1e-9;
    let mut state = fresh(&other);
    let differs = other.restore(&mut state, &bytes).unwrap_err().problem();
    assert!(
        matches!(
            differs,
            Problem::OtherController {
                arm: false,
                gains: true,
                compensator: false,
                basis: false,
                ..
            }
        ),
        "{differs:?}"
    );
    assert_eq!(state.steps, 0);
    assert_eq!(other.restore_from_other(&mut state, &bytes), Ok(Origin::Other));
    assert_eq!(state.steps, 500);
}

#[test]
fn pieces_of_a_state_are_its_bytes() {
    let controller = controller(Form::Concat, true);
    let state = taught(&controller, true);
    let mut pieces = Vec::new();
    controller.save_to(&state, &mut |piece| pieces.extend_from_slice(piece));
    assert_eq!(pieces, controller.save(&state));
}

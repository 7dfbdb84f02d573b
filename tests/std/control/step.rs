//! One sample of the controller: what is refused, what a refusal leaves alone, and what the torque
//! may be.

use crate::common::{
    self, Adaptive, AdaptiveState, Random, adaptive, bits, ended, everything, fresh, learnt,
    modified,
};
use steadyarm::arm::Arm;
use steadyarm::control::{
    Command, ComputedTorque, Controller, Gains, Inputs, Limits, NoCompensation, State,
};
use steadyarm::fuzzy::Form;
use steadyarm::math::{Matrix, Vector};
use steadyarm::paper;
use steadyarm::reference::{Reference, Setpoint};
use steadyarm::sim::{Motion, hold_torque};
use steadyarm::{Error, Problem};

const H: f64 = 1e-3;
/// The time after the release of a limit within which the error must be what it would have been
/// [s].
const RECOVERY: f64 = 1.0;

fn controller() -> Adaptive {
    modified(Form::Grid, false, Inputs::error(), everything(70.0))
}

/// q, dq, q_d, dq_d, ddq_d in a row.
type Entries = [f64; 10];
const NAMES: [&str; 5] = ["q", "dq", "q_d", "dq_d", "ddq_d"];
const VALID: Entries = [0.3, -0.2, 0.5, 0.1, 0.2, -0.3, 0.4, 0.2, -1.0, 1.0];

fn step(
    controller: &Adaptive,
    state: &mut AdaptiveState,
    x: &Entries,
    dt: f64,
) -> Result<Command<2>, Error> {
    let two = |i: usize| Vector::<2>::new(x[2 * i], x[2 * i + 1]);
    let desired = Setpoint { q: two(2), dq: two(3), ddq: two(4) };
    controller.step(state, &two(0), &two(1), &desired, dt)
}

/// A state in the middle of its work.
fn busy(controller: &Adaptive) -> AdaptiveState {
    let mut state = fresh(controller);
    for k in 0..20 {
        step(controller, &mut state, &VALID.map(|x| x * (0.1 * f64::from(k)).cos()), H).unwrap();
    }
    state
}

/// Everything there is in a state, scratch memory included, to the last bit (no entry is NaN).
fn picture(state: &AdaptiveState) -> String {
    format!("{state:?}")
}

#[test]
fn a_rejected_sample_is_named_and_leaves_the_state_bit_for_bit() {
    let controller = controller();
    let mut state = busy(&controller);
    let before = picture(&state);
    for place in 0..10 {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e11, -1e11, 1e308] {
            let mut x = VALID;
            x[place] = bad;
            let error = step(&controller, &mut state, &x, H).unwrap_err();
            let name = format!("{}[{}]: got ", NAMES[place / 2], place % 2);
            assert!(error.to_string().starts_with(&name), "{error}");
            assert_eq!(picture(&state), before);
        }
    }
    for dt in [0.0, -1.0, 1e-300, 1e3, f64::NAN, f64::INFINITY] {
        let error = step(&controller, &mut state, &VALID, dt).unwrap_err();
        assert!(error.to_string().starts_with("dt: got "), "{error}");
        assert_eq!(picture(&state), before);
    }
    assert!(step(&controller, &mut state, &VALID, H).is_ok());
}

/// The last place to refuse: the sample is fine, what follows from it is not.
#[test]
fn weights_that_would_overflow_are_refused_and_stay() {
    let controller = adaptive(Form::Concat, true, 1e149);
    let mut state = busy(&adaptive(Form::Concat, true, 7.0));
    let mut twin = state.clone();
    let before = (bits(&learnt(&controller, &state)), state.last_tau, state.steps);
    let far = VALID.map(|x| 1e5 * x);
    let error = step(&controller, &mut state, &far, 1.0).unwrap_err();
    assert!(matches!(error.problem(), Problem::OutOfRange { .. }), "{error}");
    assert_eq!(error.parameter(), "weights");
    let after = (bits(&learnt(&controller, &state)), state.last_tau, state.steps);
    assert_eq!(after, before);
    let usual = adaptive(Form::Concat, true, 7.0);
    for _ in 0..10 {
        let (a, b) = (step(&usual, &mut state, &VALID, H), step(&usual, &mut twin, &VALID, H));
        assert_eq!(a, b);
    }
}

/// An arm whose inertia has no number.
#[derive(Clone, Copy)]
struct Broken;

impl Arm<2> for Broken {
    fn mass_matrix(&self, q: &Vector<2>) -> Matrix<2> {
        Matrix::<2>::identity() / (q[0] - 1.0).max(0.0)
    }
    fn rigid_bias(&self, _: &Vector<2>, _: &Vector<2>) -> Vector<2> {
        Vector::zeros()
    }
}

#[test]
fn a_torque_that_is_no_number_is_refused_even_inside_an_effort_limit() {
    let gains = paper::gains().unwrap();
    let law = ComputedTorque::new(Broken, gains);
    let plain = Controller::new(law, NoCompensation);
    let limits = Limits { effort_limit: [5.0; 2], ..Limits::default() };
    let limited = Controller::new(law, NoCompensation).with_limits(limits).unwrap();
    let desired = Setpoint::at_rest(Vector::zeros());
    for controller in [plain, limited] {
        let mut state = State::new(());
        let error = controller
            .step(&mut state, &Vector::zeros(), &Vector::zeros(), &desired, H)
            .unwrap_err();
        assert!(matches!(error.problem(), Problem::NotFinite { .. }), "{error}");
        assert_eq!(error.parameter(), "tau");
        assert_eq!(state, State::new(()));
    }
}

/// Limits that were changed by hand to nonsense after construction must not panic either.
#[test]
fn nonsense_in_the_public_limits_is_no_panic() {
    for bad in [f64::NAN, -1.0, 0.0] {
        for rate in [false, true] {
            let mut controller = controller();
            let limit = if rate {
                &mut controller.limits.effort_rate_limit
            } else {
                &mut controller.limits.effort_limit
            };
            limit[1] = bad;
            let mut state = fresh(&controller);
            for _ in 0..3 {
                let command = step(&controller, &mut state, &VALID, H);
                assert!(command.is_ok_and(|c| c.tau.iter().all(|t| t.is_finite())));
            }
        }
    }
}

#[test]
fn every_bad_limit_and_gain_is_refused_by_name() {
    for bad in [f64::NAN, -1.0, 0.0] {
        let effort = Limits { effort_limit: [1.0, bad], ..Limits::default() };
        let error = controller().with_limits(effort).map(|_| ()).unwrap_err().to_string();
        let wanted = "wants a limit > 0 (infinite for none)";
        assert_eq!(error, format!("effort_limit[1]: got {bad}, {wanted}"));
        let rate = Limits { effort_rate_limit: [bad, 1.0], ..Limits::default() };
        let error = controller().with_limits(rate).map(|_| ()).unwrap_err().to_string();
        assert_eq!(error, format!("effort_rate_limit[0]: got {bad}, {wanted}"));
        assert!(Gains::new([1.0, bad], [1.0; 2]).unwrap_err().to_string().starts_with("kp[1]"));
        assert!(Gains::new([1.0; 2], [bad, 1.0]).unwrap_err().to_string().starts_with("kv[0]"));
    }
}

fn random_entries(random: &mut Random) -> Entries {
    let size = [1e-3, 1.0, 10.0, 1e5, 1e10][random.bits() as usize % 5];
    let mut x = VALID.map(|_| random.within(-size, size));
    // Positions are at most 1e5.
    for place in [0, 1, 4, 5] {
        x[place] *= (1e5 / size).min(1.0);
    }
    x
}

#[test]
fn torque_stays_inside_both_limits_whatever_the_sample() {
    let (effort, rate) = ([20.0, 5.0], [1000.0, 300.0]);
    let limits = Limits { effort_limit: effort, effort_rate_limit: rate };
    let controller = controller().with_limits(limits).unwrap();
    let mut random = Random(5);
    let mut state = fresh(&controller);
    // Gravity pulls at no joint: the first torque is limited from zero.
    let mut last: Option<Vector<2>> = None;
    for _ in 0..10_000 {
        let mut x = random_entries(&mut random);
        let dt = random.within(1e-5, 5e-3);
        if random.bits().is_multiple_of(7) {
            x[random.bits() as usize % 10] = f64::NAN;
        }
        let Ok(command) = step(&controller, &mut state, &x, dt) else {
            assert_eq!(state.last_tau, last);
            continue;
        };
        for n in 0..2 {
            assert!(command.tau[n].abs() <= effort[n]);
            // One rounding of last + change.
            let most = rate[n] * dt + 4.0 * f64::EPSILON * effort[n];
            assert!((command.tau[n] - last.unwrap_or_default()[n]).abs() <= most);
        }
        last = Some(command.tau);
    }
}

#[test]
fn unlimited_torque_is_the_exact_sum_of_its_parts() {
    let controller = controller();
    let mut random = Random(6);
    let mut state = fresh(&controller);
    for _ in 0..2000 {
        let x = VALID.map(|_| random.within(-1.0, 1.0));
        let command = step(&controller, &mut state, &x, H).unwrap();
        assert!(!command.limited);
        assert_eq!(command.tau, command.model + command.compensation);
        let q = Vector::<2>::new(x[0], x[1]);
        let expected = -(controller.law.arm.mass_matrix(&q) * command.rho_hat);
        assert!((command.compensation - expected).norm() <= 1e-14 * (1.0 + expected.norm()));
    }
}

#[test]
fn ten_thousand_random_steps_never_produce_a_torque_that_is_not_finite() {
    let mut random = Random(7);
    for form in common::FORMS {
        for adaptation in [common::law(7e3), everything(7e3)] {
            let controller = modified(form, false, Inputs::trajectory(), adaptation);
            let mut state = fresh(&controller);
            let mut accepted = 0;
            for _ in 0..10_000 {
                let x = random_entries(&mut random);
                let dt = 10f64.powf(random.within(-9.0, 0.0));
                if let Ok(command) = step(&controller, &mut state, &x, dt) {
                    assert!(command.tau.iter().all(|t| t.is_finite()));
                    accepted += 1;
                }
                let w = ended(&controller, &state).weights_norm();
                assert!(w.is_finite());
            }
            assert_eq!(state.steps, accepted);
            assert!(accepted > 9_000, "{form:?}: only {accepted} accepted");
        }
    }
}

/// What is remembered of a torque limit that lasts from 5 s to 10 s.
#[derive(Clone, Copy, PartialEq)]
enum Memory {
    /// What the controller chooses to: it learns nothing while it limits.
    Kept,
    /// Nothing: at the release the weights from before the limit are put back.
    Forgotten,
}

/// Tracks for 20 s under the limit [N·m]; the errors of every millisecond.
fn errors(limit: f64, memory: Memory) -> Vec<f64> {
    let (plant, reference) = (common::plant(), common::reference());
    let free = adaptive(Form::Grid, false, 70.0);
    let limits = Limits { effort_limit: [limit; 2], ..Limits::default() };
    let tight = free.clone().with_limits(limits).unwrap();
    let mut state = fresh(&free);
    let mut before = state.clone();
    let mut motion = Motion::<2>::zeros();
    let mut errors = Vec::new();
    for k in 0..20_000 {
        let t = f64::from(k) * H;
        if k == 5_000 {
            before = state.clone();
        }
        if k == 10_000 && memory == Memory::Forgotten {
            state = before.clone();
        }
        let controller = if (5_000..10_000).contains(&k) { &tight } else { &free };
        let desired = reference.at(t);
        let command = controller.step(&mut state, &motion.q, &motion.dq, &desired, H).unwrap();
        motion = hold_torque(&plant, &motion, &command.tau, t, H);
        errors.push((motion.q - desired.q).norm());
    }
    errors
}

/// The time after the release at which the error is back in 1.5 times its usual range [s].
fn recovery(limit: f64, memory: Memory) -> f64 {
    let usual = errors(f64::INFINITY, Memory::Kept)[5_000..].iter().copied().fold(0.0, f64::max);
    let limited = errors(limit, memory);
    let worst = limited[5_000..10_000].iter().copied().fold(0.0, f64::max);
    assert!(worst > 10.0 * usual, "{limit} N·m did not limit: {worst} {usual}");
    limited.iter().rposition(|e| *e > 1.5 * usual).unwrap() as f64 * H - 10.0
}

#[test]
fn recovery_after_a_torque_limit_takes_less_than_a_second() {
    assert!(recovery(10.0, Memory::Kept) < RECOVERY);
}

/// Whatever the arm was left to do under the limit, the weights do not remember it.
#[test]
fn nothing_winds_up_while_the_torque_is_limited() {
    for limit in [9.0, 8.0, 6.0, 5.0, 4.0] {
        let (kept, forgotten) = (recovery(limit, Memory::Kept), recovery(limit, Memory::Forgotten));
        assert!(kept < forgotten + 0.1, "{limit} N·m: {kept} s, without memory {forgotten} s");
    }
}

//! What the weights do between samples: bounds, decay, standstill, warm starts; and the refusals.

use crate::common::{
    self, Adaptive, AdaptiveState, Random, bits, ended, everything, fresh, law, learnt, modified,
    weights,
};
use steadyarm::control::{Adaptation, FuzzyCompensator, FuzzyParameters};
use steadyarm::control::{Gains, Inputs, Limits, Signal, State};
use steadyarm::fuzzy::{Axis, Form, FuzzyBasis};
use steadyarm::math::Vector;
use steadyarm::paper::{self, Reading};
use steadyarm::reference::Setpoint;
use steadyarm::{Error, Problem};

const H: f64 = 1e-3;
/// Two exponentials, and as many roundings as there are steps.
const DECAY_TOL: f64 = 1e-12;

fn error_inputs(adaptation: Adaptation<2>) -> Adaptive {
    modified(Form::Grid, false, Inputs::error(), adaptation)
}

/// One sample with error `e` and rate `de`, at a set-point in the origin.
fn sample(controller: &Adaptive, state: &mut AdaptiveState, e: f64, de: f64) -> [f64; 2] {
    let desired = Setpoint::at_rest(Vector::zeros());
    let (q, dq) = (Vector::repeat(e), Vector::repeat(de));
    controller.step(state, &q, &dq, &desired, H).unwrap().tau.into()
}

/// A state that has learnt something.
fn taught(controller: &Adaptive) -> AdaptiveState {
    let mut state = fresh(controller);
    (0..50).for_each(|k| _ = sample(controller, &mut state, 0.3 - 0.01 * f64::from(k), 0.5));
    assert!(ended(controller, &state).weights_norm() > 1e-3);
    state
}

#[test]
fn projection_keeps_the_weights_in_its_ball_also_when_sampled() {
    let mut random = Random(4);
    for radius in [1e-3, 0.5, 10.0] {
        let adaptation = Adaptation { projection_radius: radius, ..law(1e4) };
        let controller = error_inputs(adaptation);
        let mut state = fresh(&controller);
        let mut largest: f64 = 0.0;
        for _ in 0..5000 {
            let (e, de) = (random.within(-1.0, 1.0), random.within(-5.0, 5.0));
            sample(&controller, &mut state, e, de);
            let w = learnt(&controller, &state);
            largest = largest.max(w.iter().map(|w| w * w).sum::<f64>().sqrt());
        }
        assert!(largest <= radius * (1.0 + 1e-12), "{largest} {radius}");
        assert!(largest > 0.9 * radius, "the ball was never reached: {largest} {radius}");
    }
}

#[test]
fn leak_decays_exactly_where_nothing_is_learnt() {
    let controller = error_inputs(Adaptation { leak_rate: 0.7, ..law(7.0) });
    let mut state = taught(&controller);
    let before = learnt(&controller, &state);
    (0..2000).for_each(|_| _ = sample(&controller, &mut state, 0.0, 0.0));
    for (after, before) in learnt(&controller, &state).iter().zip(before) {
        assert!((after - before * (-0.7 * 2.0f64).exp()).abs() <= DECAY_TOL * before.abs());
    }
}

#[test]
fn reported_norm_is_the_norm_of_the_weights() {
    for adaptation in [law(70.0), everything(70.0)] {
        let controller = error_inputs(adaptation);
        let state = ended(&controller, &taught(&controller));
        let squares: f64 = weights(&controller, &state).iter().map(|w| w * w).sum();
        assert!((state.weights_norm() / squares.sqrt() - 1.0).abs() < 1e-14);
    }
}

#[test]
fn frozen_weights_never_change_and_stay_in_use() {
    let controller = error_inputs(everything(7.0));
    let mut state = taught(&controller);
    controller.settle(&mut state).freeze();
    let before = bits(&learnt(&controller, &state));
    let first = sample(&controller, &mut state, 0.2, 0.1);
    (0..1000).for_each(|_| _ = sample(&controller, &mut state, 0.2, -0.1));
    assert_eq!(bits(&learnt(&controller, &state)), before);
    assert_eq!(sample(&controller, &mut state, 0.2, 0.1), first);
    let without = sample(&controller, &mut fresh(&controller), 0.2, 0.1);
    assert_ne!(first, without);
    controller.settle(&mut state).unfreeze();
    sample(&controller, &mut state, 0.2, 0.1);
    assert_ne!(bits(&learnt(&controller, &state)), before);
}

#[test]
fn loaded_weights_are_read_back_bit_for_bit_and_act_like_learnt_ones() {
    let controller = error_inputs(law(7.0));
    let mut state = taught(&controller);
    let before = learnt(&controller, &state);
    let mut copy = fresh(&controller);
    controller.compensator.load_weights(controller.settle(&mut copy), &before).unwrap();
    assert_eq!(bits(&learnt(&controller, &copy)), bits(&before));
    for _ in 0..100 {
        assert_eq!(
            sample(&controller, &mut copy, 0.1, 0.3),
            sample(&controller, &mut state, 0.1, 0.3)
        );
    }
}

#[test]
fn a_warm_start_is_what_a_leak_returns_to() {
    let leaky = Adaptation { leak_rate: 2.0, ..law(7.0) };
    for adaptation in [leaky, everything(7.0)] {
        let controller = error_inputs(adaptation);
        let prior: Vec<_> = (0..1250).map(|k| 0.01 * f64::from(k % 17)).collect();
        let mut state = fresh(&controller);
        controller.compensator.warm_start(controller.settle(&mut state), &prior).unwrap();
        assert_eq!(bits(&learnt(&controller, &state)), bits(&prior));
        assert_eq!(ended(&controller, &state).weights_norm(), 0.0);
        (0..100).for_each(|_| _ = sample(&controller, &mut state, 0.1, 0.3));
        let off = ended(&controller, &state).weights_norm();
        (0..1000).for_each(|_| _ = sample(&controller, &mut state, 0.0, 0.0));
        let faded = off * (-adaptation.leak_rate * 1000.0 * H).exp();
        assert!((ended(&controller, &state).weights_norm() - faded).abs() < 1e-9 * off);
    }
}

#[test]
fn reset_forgets_learnt_and_loaded_weights() {
    use steadyarm::control::Compensator;
    let controller = error_inputs(everything(7.0));
    let mut state = taught(&controller);
    controller.compensator.reset(controller.settle(&mut state));
    assert!(learnt(&controller, &state).iter().all(|w| *w == 0.0));
    let mut fresh = fresh(&controller);
    (state.last_tau, state.steps) = (None, 0);
    for _ in 0..10 {
        assert_eq!(
            sample(&controller, &mut state, 0.1, 0.3),
            sample(&controller, &mut fresh, 0.1, 0.3)
        );
    }
}

#[test]
fn nothing_is_learnt_while_the_torque_is_limited() {
    let limits = [
        Limits { effort_limit: [0.5; 2], ..Limits::default() },
        Limits { effort_rate_limit: [1e-3; 2], ..Limits::default() },
    ];
    for limit in limits {
        let controller = error_inputs(law(7.0)).with_limits(limit).unwrap();
        let mut state = fresh(&controller);
        (0..100).for_each(|_| _ = sample(&controller, &mut state, 1.0, 0.0));
        assert_eq!(ended(&controller, &state).weights_norm(), 0.0);
    }
}

#[test]
fn nothing_is_learnt_inside_the_dead_zone() {
    let controller = error_inputs(Adaptation { dead_zone: 0.1, ..law(7.0) });
    let p = controller.compensator.p()[0];
    // |s| = √2 p12 e for the same e in both joints.
    let edge = 0.1 / (2.0f64.sqrt() * p.p12);
    let mut state = fresh(&controller);
    (0..100).for_each(|_| _ = sample(&controller, &mut state, 0.999 * edge, 0.0));
    assert_eq!(ended(&controller, &state).weights_norm(), 0.0);
    sample(&controller, &mut state, 1.001 * edge, 0.0);
    assert!(ended(&controller, &state).weights_norm() > 0.0);
}

/// Subnormal numbers would slow a step many times: weights become zero long before, by a strong
/// leak (at once) and by a weak one (within 256 steps), and so do their squares.
#[test]
fn weights_that_fade_are_never_subnormal_and_nor_are_their_squares() {
    for leak_rate in [100.0, 735.0, 2e4, 1e5] {
        let controller = error_inputs(Adaptation { leak_rate, ..law(7.0) });
        let mut state = fresh(&controller);
        let own = controller.settle(&mut state);
        controller.compensator.load_weights(own, &[0.3; 1250]).unwrap();
        let mut smallest = f64::INFINITY;
        for _ in 0..(500e3 / leak_rate) as usize {
            sample(&controller, &mut state, 0.0, 0.0);
            for w in learnt(&controller, &state).iter().filter(|w| **w != 0.0) {
                smallest = smallest.min(w * w);
            }
            let norm = ended(&controller, &state).weights_norm();
            assert!(norm == 0.0 || (norm * norm).is_normal());
        }
        assert!(smallest.is_normal() && (leak_rate > 1e3 || smallest < 1e-230), "{smallest:e}");
        assert!(learnt(&controller, &state).iter().all(|w| *w == 0.0), "{leak_rate}");
    }
}

/// Whatever the samples, all over the range of numbers.
#[test]
fn no_weight_and_no_torque_is_ever_subnormal() {
    let fine = |x: &f64| *x == 0.0 || (x * x).is_normal() || x.abs() > 1.0;
    let mut random = Random(11);
    for form in common::FORMS {
        for normalized in [true, false] {
            let inputs = Inputs::trajectory();
            for controller in [
                modified(form, normalized, Inputs::error(), law(70.0)),
                modified(form, normalized, inputs, everything(70.0)),
            ] {
                let mut state = fresh(&controller);
                for _ in 0..600 {
                    let size = 10f64.powf(random.within(-330.0, 5.0));
                    let mut vector = || random.vector(size);
                    let (q, dq) = (vector(), vector());
                    let desired = Setpoint { q: vector(), dq: vector(), ddq: vector() };
                    let command = controller.step(&mut state, &q, &dq, &desired, H).unwrap();
                    assert!(command.tau.iter().chain(&command.rho_hat).all(fine), "{command:?}");
                    assert!(learnt(&controller, &state).iter().all(fine), "{form:?} {size:e}");
                }
            }
        }
    }
}

/// Firing strengths many sigmas beyond the last set are normal numbers, or zero.
#[test]
fn no_firing_strength_is_subnormal() {
    for form in common::FORMS {
        for normalized in [true, false] {
            let reading = Reading { form, normalized, gain: 1.0 };
            let basis = paper::basis(reading, 4).unwrap();
            let (mut work, mut xi) = (vec![0.0; basis.work_len()], vec![0.0; basis.rules()]);
            let mut small = 0;
            for k in 0..4000 {
                let x = 0.01 * f64::from(k);
                for at in [[x; 4], [x, 0.0, -x, 0.1], [0.0, x, 1e-300, -x]] {
                    basis.evaluate(&at, &mut work, &mut xi).unwrap();
                    for y in &xi {
                        assert!(*y == 0.0 || y.is_normal(), "{form:?} {at:?}: {y:e}");
                        small += usize::from(*y > 0.0 && *y < 1e-20);
                    }
                }
            }
            assert!(small > 0 || normalized, "{form:?}: nothing was small");
        }
    }
}

fn refusal(change: impl Fn(&mut Adaptation<2>)) -> String {
    let mut adaptation = everything(7.0);
    change(&mut adaptation);
    let parameters = FuzzyParameters { adaptation, ..FuzzyParameters::default() };
    let basis = common::adaptive(Form::Grid, true, 1.0).compensator.basis().clone();
    FuzzyCompensator::new(basis, &paper::gains().unwrap(), parameters).unwrap_err().to_string()
}

#[test]
fn every_bad_parameter_of_the_law_is_refused_by_name() {
    assert_eq!(refusal(|a| a.gain[1] = 0.0), "gain[1]: got 0, wants a number > 0");
    assert_eq!(refusal(|a| a.gain[0] = f64::NAN), "gain[0]: got NaN, wants a finite number");
    assert_eq!(refusal(|a| a.leak_rate = -1.0), "leak_rate: got -1, wants a number >= 0");
    let modification = refusal(|a| a.error_modification = f64::INFINITY);
    assert_eq!(modification, "error_modification: got inf, wants a finite number");
    assert_eq!(refusal(|a| a.dead_zone = -1.0), "dead_zone: got -1, wants a number >= 0");
    assert_eq!(refusal(|a| a.normalization = -1.0), "normalization: got -1, wants a number >= 0");
    for bad in [0.0, -1.0, f64::NAN] {
        let wanted = "wants a radius > 0 (infinite for none)";
        let text = format!("projection_radius: got {bad}, {wanted}");
        assert_eq!(refusal(|a| a.projection_radius = bad), text);
    }
}

#[test]
fn a_basis_of_another_size_and_an_equation_without_solution_are_refused() {
    let gains = paper::gains().unwrap();
    let try_new = |basis: FuzzyBasis, parameters| {
        FuzzyCompensator::<2>::new(basis, &gains, parameters).map(|_| ()).unwrap_err()
    };
    let reading = Reading { form: Form::Grid, normalized: true, gain: 1.0 };
    let basis = |inputs| paper::basis(reading, inputs).unwrap();
    let wrong = Error::wrong_length;
    assert_eq!(try_new(basis(3), FuzzyParameters::default()), wrong("inputs", 3, 4));
    let axis = Axis { centers: &[0.0], widths: &[1.0] };
    let joints = FuzzyBasis::new(Form::PerJoint { joints: 4 }, true, &[axis; 4]).unwrap();
    assert_eq!(try_new(joints, FuzzyParameters::default()), wrong("joints", 4, 2));
    let hard = FuzzyParameters { gamma: 0.6, ..FuzzyParameters::default() };
    let refusal = try_new(basis(4), hard).problem();
    assert!(matches!(refusal, Problem::NoStabilizingSolution { gamma: 0.6, .. }));
    let heavy = FuzzyParameters { q_velocity: [10.0, -1.0], ..FuzzyParameters::default() };
    assert_eq!(try_new(basis(4), heavy).to_string(), "q2: got -1, wants a number >= 0");
    assert_eq!(
        Gains::new([8.0, 0.0], [5.5; 2]).unwrap_err().to_string(),
        "kp[1]: got 0, wants a number > 0"
    );
}

#[test]
fn bad_weights_are_refused_and_change_nothing() {
    let controller = error_inputs(everything(7.0));
    let mut state = ended(&controller, &taught(&controller));
    let before = bits(&weights(&controller, &state));
    let good = vec![0.1; 1250];
    let mut bad = good.clone();
    for (value, text) in [
        (f64::NAN, "weights[7]: got NaN, wants a finite number"),
        (2e150, "weights[7]: got 2e150, wants"),
    ] {
        bad[7] = value;
        let load = controller.compensator.load_weights(&mut state, &bad).unwrap_err();
        let warm = controller.compensator.warm_start(&mut state, &bad).unwrap_err();
        assert_eq!(load.to_string(), warm.to_string());
        assert!(load.to_string().starts_with(text), "{load}");
    }
    let short = controller.compensator.load_weights(&mut state, &good[1..]).unwrap_err();
    assert_eq!(short.to_string(), "weights: got 1249 entries, wants 1250");
    let mut out = vec![0.0; 1251];
    let long = controller.compensator.read_weights(&state, &mut out).unwrap_err();
    assert_eq!(long.to_string(), "weights: got 1251 entries, wants 1250");
    assert_eq!(bits(&weights(&controller, &state)), before);
}

#[test]
fn a_state_lives_in_any_buffer_that_is_long_enough() {
    let controller = error_inputs(law(7.0));
    let wanted = controller.compensator.buffer_len();
    let short = controller.compensator.state_in(vec![0.0; wanted - 1]).unwrap_err();
    assert_eq!(short, Error::wrong_length("buffer", wanted - 1, wanted));
    let mut memory = vec![f64::NAN; wanted];
    let mut borrowed = State::new(controller.compensator.state_in(&mut memory[..]).unwrap());
    let mut owned = fresh(&controller);
    let desired = Setpoint::at_rest(Vector::zeros());
    for _ in 0..10 {
        let q = Vector::<2>::new(0.1, -0.2);
        let a = controller.step(&mut borrowed, &q, &q, &desired, H).unwrap();
        assert_eq!(a, controller.step(&mut owned, &q, &q, &desired, H).unwrap());
    }
}

#[test]
fn every_bad_choice_of_inputs_is_refused() {
    let all = [Signal::E, Signal::De, Signal::Q, Signal::Dq, Signal::QDesired, Signal::DqDesired];
    let new = |signals: &[(Signal, f64)]| Inputs::new(signals).unwrap_err().to_string();
    assert_eq!(new(&[]), "inputs: got 0 entries, wants 1");
    assert_eq!(new(&[(Signal::E, 0.0)]), "scale: got 0, wants a number other than 0");
    assert_eq!(new(&[(Signal::E, f64::NAN)]), "scale: got NaN, wants a finite number");
    assert_eq!(
        new(&[(Signal::E, 1.0), (Signal::E, 2.0)]),
        "inputs[1]: got 1, wants each signal once"
    );
    assert_eq!(new(&[(Signal::E, 1.0); 8]), "inputs: got 8, wants at most 7");
    assert_eq!(Inputs::new(&all.map(|s| (s, 1.0))).unwrap().len(2), 12);
}

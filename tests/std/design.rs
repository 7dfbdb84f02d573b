//! The design report: its prediction against simulation, its findings one by one.

use std::f64::consts::TAU;

use steadyarm::arm::{Arm, TwoLink, TwoLinkParameters};
use steadyarm::control::{Adaptation, Inputs};
use steadyarm::design::{Conditions, Course, Finding, LinearModel, Report};
use steadyarm::fuzzy::Form;
use steadyarm::paper;
use steadyarm::reference::{Harmonic, Reference, Sines};
use steadyarm::sim::Options;

use crate::common::{self, Adaptive, adaptive, figures, law, modified, run};

/// Samples of a period of the reference: its harmonics end far below the Nyquist limit of this.
const SAMPLES: usize = 256;

/// Harmonics kept of ρ along the reference.
const HARMONICS: usize = 24;

fn report(controller: &Adaptive, conditions: &Conditions<'_>) -> Report<2> {
    let Adaptive { law, compensator, limits, .. } = controller;
    Report::new(law, limits, Some(compensator), None, conditions).unwrap()
}

/// Harmonics of `ρ_d = M₀⁻¹[ΔM q̈_d + ΔH − τ_d]` along the paper's reference, (amplitude,
/// frequency) of a joint.
fn uncertainty_along_the_reference(joint: usize) -> Vec<(f64, f64)> {
    let (nominal, actual) = (paper::nominal().unwrap(), paper::actual().unwrap());
    let (reference, disturbance) = (paper::reference().unwrap(), paper::disturbance().unwrap());
    let rho: Vec<f64> = (0..SAMPLES)
        .map(|k| {
            let t = TAU * k as f64 / SAMPLES as f64;
            let desired = reference.at(t);
            let believed = nominal.inverse_dynamics(&desired.q, &desired.dq, &desired.ddq);
            let needed = actual.inverse_dynamics(&desired.q, &desired.dq, &desired.ddq);
            let missing = believed - needed - disturbance.value(t);
            nominal
                .mass_matrix(&desired.q)
                .try_inverse()
                .unwrap()
                .row(joint)
                .dot(&missing.transpose())
        })
        .collect();
    let amplitude = |m: usize| {
        let angle = |k: usize| TAU * (k * m) as f64 / SAMPLES as f64;
        let (mut c, mut s) = (0.0, 0.0);
        for (k, value) in rho.iter().enumerate() {
            c += value * angle(k).cos();
            s += value * angle(k).sin();
        }
        2.0 * c.hypot(s) / SAMPLES as f64
    };
    (1..=HARMONICS).map(|m| (amplitude(m), m as f64)).collect()
}

#[test]
fn predicted_error_is_within_5_percent_of_the_simulated_one() {
    for (form, gain) in [(Form::Concat, 7.0), (Form::Concat, 70.0), (Form::Grid, 7.0)] {
        let controller = adaptive(form, false, gain);
        let simulated = figures(&run(&controller, &Options::default()));
        for joint in 0..2 {
            let disturbance = uncertainty_along_the_reference(joint);
            let conditions = Conditions {
                disturbance: Some(&disturbance),
                inertia_ratio: 0.5,
                ..Default::default()
            };
            let report = report(&controller, &conditions).joints[joint];
            assert!(report.k_i >= 60.0);
            let ratio = report.rms[1] / simulated[joint];
            assert!((ratio - 1.0).abs() < 0.05, "{form:?} {gain} joint {joint}: {ratio}");
        }
    }
}

#[test]
fn the_printed_compensator_is_called_inert_and_a_useful_gain_is_suggested() {
    let report_of = |gain| report(&adaptive(Form::Shared, true, gain), &Conditions::default());
    let printed = report_of(1.0 / 7.0);
    let Finding::Inert { joint: 0, removes, suggested_gain: Some(gain), .. } = printed.findings[0]
    else {
        panic!("{:?}", printed.findings);
    };
    assert!(removes < 0.01 && printed.sound());
    let better = report_of(gain);
    assert!(better.findings.is_empty(), "{:?}", better.findings);
    assert!((better.joints[0].rms[1] / better.joints[0].rms[0] - 0.1).abs() < 1e-6);
    let text = printed.findings[0].to_string();
    assert!(
        text.starts_with("joint 1: the compensator is inert: with k_I = 0.060 it removes "),
        "{text}"
    );
}

#[test]
fn a_loop_is_warned_of_above_a_third_of_its_limit_and_refused_above_three_quarters() {
    for (form, gain) in [(Form::Concat, 7.0), (Form::Concat, 70.0), (Form::Grid, 7.0)] {
        let controller = adaptive(form, false, gain);
        let limit = report(&controller, &Conditions::default()).joints[0].max_period;
        let at = |share: f64| {
            let control_period = share * limit;
            report(&controller, &Conditions { control_period, ..Default::default() })
        };
        let sampling = |f: &Finding| f.refuses() || matches!(f, Finding::SlowSampling { .. });
        assert!(at(0.33).sound() && !at(0.33).findings.iter().any(sampling));
        for share in [0.34, 0.74] {
            let warned = at(share);
            let slow = |f: &Finding| matches!(f, Finding::SlowSampling { .. });
            assert!(warned.sound() && warned.findings.iter().any(slow));
        }
        for share in [0.76, 0.99] {
            let refused = at(share);
            let close = |f: &Finding| matches!(f, Finding::NoMargin { .. });
            assert!(!refused.sound() && refused.findings.iter().any(close));
        }
        let refused = at(1.01);
        let unstable = |f: &Finding| matches!(f, Finding::Unstable { .. });
        assert!(!refused.sound() && refused.findings.iter().any(unstable));
    }
    // 67 ms for the five sets of each input at gain 7.
    let concat = report(&adaptive(Form::Concat, false, 7.0), &Conditions::default());
    assert!((concat.joints[0].max_period - 0.067).abs() < 5e-4);
}

#[test]
fn a_gain_too_high_for_a_heavy_arm_rings_and_a_tight_q_is_reported() {
    let controller = adaptive(Form::Grid, false, 700.0);
    let heavy = Conditions { inertia_ratio: 0.5, control_period: 1e-5, ..Default::default() };
    let found = report(&controller, &heavy).findings;
    assert!(found.iter().any(|f| matches!(f, Finding::Ringing { .. })), "{found:?}");
    let tight = common::with_parameters(
        Form::Concat,
        false,
        steadyarm::control::FuzzyParameters {
            q_position: [26.0; 2],
            q_velocity: [26.0; 2],
            adaptation: law(7.0),
            ..Default::default()
        },
    );
    let found = report(&tight, &Conditions::default()).findings;
    assert!(found.iter().any(|f| matches!(f, Finding::NarrowMargin { .. })), "{found:?}");
}

#[test]
fn margins_are_those_of_the_riccati_equation() {
    let joint = report(&adaptive(Form::Shared, true, 7.0), &Conditions::default()).joints[1];
    assert!((joint.gamma_opt - 0.6143205381).abs() < 1e-10);
    assert!((10.0 * joint.max_scale - 26.4978068488).abs() < 1e-9);
    assert!((joint.max_real + 2.1764040558).abs() < 1e-9);
    assert!((joint.k_i - 7.0 * 0.42163).abs() < 1e-4);
}

#[test]
fn where_the_rules_see_the_arm_nothing_is_known_without_a_path() {
    for inputs in [Inputs::state(), Inputs::reference()] {
        let controller = modified(Form::Grid, true, inputs, law(7.0));
        let report = report(&controller, &Conditions::default());
        assert!(!report.known() && !report.sound());
        assert!(report.findings.contains(&Finding::NeedsPath));
        let joint = report.joints[0];
        for unknown in [joint.k_i, joint.rms[1], joint.sampled_radius, joint.max_period] {
            assert!(unknown.is_nan());
        }
        // What does not depend on the rules is there.
        assert!((joint.gamma_opt - 0.6143205381).abs() < 1e-10 && joint.rms[0] > 0.0);
    }
}

/// The paper's arm at rest along a path: the sampled loop of all joints is then that of each joint,
/// as gravity is not held against it.
fn at_rest() -> Course<2> {
    let rest = Sines::new([0.3, -0.2], [Harmonic { frequency: 0.0, sin: [0.0; 2], cos: [0.0; 2] }]);
    let weightless = TwoLink::new(TwoLinkParameters { gravity: 0.0, ..nominal_parameters() });
    let arm = weightless.unwrap();
    Course::believed(&arm, 1.0, &rest.unwrap(), 2.0).unwrap()
}

fn nominal_parameters() -> TwoLinkParameters {
    TwoLinkParameters { mass: [4.0; 2], length: [0.5; 2], inertia: [0.2; 2], ..Default::default() }
}

#[test]
fn at_rest_the_loop_of_all_joints_is_that_of_each_joint() {
    for (delay_samples, velocity_filter) in [(0, None), (1, None), (3, Some(50.0)), (0, Some(90.0))]
    {
        for leak_rate in [0.0, 2.0] {
            let adaptation = Adaptation { leak_rate, normalization: 0.1, ..law(70.0) };
            let controller = modified(Form::Concat, false, Inputs::reference(), adaptation);
            let control_period = 2e-3;
            let conditions =
                Conditions { control_period, delay_samples, velocity_filter, ..Default::default() };
            let course = at_rest();
            let Adaptive { law, compensator, limits, .. } = &controller;
            let along = Report::new(law, limits, Some(compensator), Some(&course), &conditions);
            let along = along.unwrap().joints[0];
            let p = along.p;
            let alone = LinearModel {
                kp: 8.0,
                kv: 5.5,
                p12: p.p12,
                p22: p.p22,
                k_i: along.k_i,
                leak_rate,
                inertia_ratio: 1.0,
                velocity_filter,
            };
            let radius = alone.sampled_radius(control_period, delay_samples).unwrap();
            assert!((along.sampled_radius - radius).abs() < 1e-9);
            // The search along a path stops within 1e-3.
            let longest = alone.max_period(delay_samples).unwrap();
            assert!((along.max_period / longest - 1.0).abs() < 1e-3);
        }
    }
}

#[test]
fn each_condition_that_makes_no_sense_is_named() {
    let controller = adaptive(Form::Shared, true, 7.0);
    let refused = |conditions: Conditions<'_>| {
        let Adaptive { law, compensator, limits, .. } = &controller;
        let report = Report::new(law, limits, Some(compensator), None, &conditions);
        report.unwrap_err().parameter()
    };
    let good = Conditions::default();
    assert_eq!(refused(Conditions { control_period: 0.0, ..good }), "control_period");
    assert_eq!(refused(Conditions { control_period: f64::NAN, ..good }), "control_period");
    assert_eq!(refused(Conditions { delay_samples: 9, ..good }), "delay_samples");
    let filter = |cut_off| Conditions { velocity_filter: Some(cut_off), ..good };
    assert_eq!(refused(filter(0.0)), "velocity_filter");
    assert_eq!(refused(filter(f64::INFINITY)), "velocity_filter");
    assert_eq!(refused(Conditions { disturbance: Some(&[]), ..good }), "disturbance");
    assert_eq!(refused(Conditions { disturbance: Some(&[(1.0, -1.0)]), ..good }), "omega");
    assert_eq!(refused(Conditions { disturbance: Some(&[(f64::NAN, 1.0)]), ..good }), "amplitude");
    assert_eq!(refused(Conditions { inertia_ratio: 0.0, ..good }), "inertia_ratio");
}

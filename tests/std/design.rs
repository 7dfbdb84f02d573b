//! The design report: its prediction against simulation, its findings one by one.

use std::f64::consts::TAU;

use steadyarm::arm::Arm;
use steadyarm::control::Inputs;
use steadyarm::design::{Conditions, Finding, Report};
use steadyarm::fuzzy::Form;
use steadyarm::paper;
use steadyarm::reference::Reference;
use steadyarm::sim::Options;

use crate::common::{self, Adaptive, adaptive, figures, law, modified, run};

/// Samples of a period of the reference: its harmonics end far below the Nyquist limit of this.
const SAMPLES: usize = 256;

/// Harmonics kept of ρ along the reference.
const HARMONICS: usize = 24;

fn report(controller: &Adaptive, conditions: &Conditions<'_>) -> Report<2> {
    Report::new(&controller.law.gains, &controller.compensator, conditions).unwrap()
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
            let conditions =
                Conditions { disturbance: &disturbance, inertia_ratio: 0.5, ..Default::default() };
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
fn a_loop_beyond_its_sampling_limit_is_refused_and_one_near_it_warned_of() {
    let controller = adaptive(Form::Concat, false, 7.0);
    let limit = report(&controller, &Conditions::default()).joints[0].max_period;
    assert!((limit - 0.067).abs() < 5e-4, "{limit}");
    let findings = |period| report(&controller, &Conditions { period, ..Default::default() });
    let refused = findings(1.01 * limit);
    assert!(!refused.sound() && matches!(refused.findings[0], Finding::Unstable { joint: 0, .. }));
    let warned = findings(0.95 * limit);
    assert!(warned.sound() && matches!(warned.findings[0], Finding::SlowSampling { .. }));
    assert!(findings(1e-3).findings.is_empty());
}

#[test]
fn a_gain_too_high_for_a_heavy_arm_rings_and_a_tight_q_is_reported() {
    let controller = adaptive(Form::Grid, false, 700.0);
    let heavy = Conditions { inertia_ratio: 0.5, period: 1e-5, ..Default::default() };
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
fn inputs_other_than_the_error_are_judged_at_the_origin() {
    let controller = modified(Form::Grid, true, Inputs::state(), law(7.0));
    let k_i = report(&controller, &Conditions::default()).joints[0].k_i;
    assert!((k_i - 7.0 * 0.0072360).abs() < 1e-6);
}

#[test]
fn each_condition_that_makes_no_sense_is_named() {
    let controller = adaptive(Form::Shared, true, 7.0);
    let refused = |conditions: Conditions<'_>| {
        let report = Report::new(&controller.law.gains, &controller.compensator, &conditions);
        report.unwrap_err().parameter()
    };
    let good = Conditions::default();
    assert_eq!(refused(Conditions { period: 0.0, ..good }), "period");
    assert_eq!(refused(Conditions { period: f64::NAN, ..good }), "period");
    assert_eq!(refused(Conditions { delay_samples: 9, ..good }), "delay_samples");
    assert_eq!(refused(Conditions { disturbance: &[], ..good }), "disturbance");
    assert_eq!(refused(Conditions { disturbance: &[(1.0, -1.0)], ..good }), "omega");
    assert_eq!(refused(Conditions { disturbance: &[(f64::NAN, 1.0)], ..good }), "amplitude");
    assert_eq!(refused(Conditions { inertia_ratio: 0.0, ..good }), "inertia_ratio");
}

//! The golden values: the basis at rest, P, and the paper's three simulations, against numbers that
//! two independent programs agree on.

use crate::common::{self, adaptive, figures, on, plain, plant, reference, run};
use steadyarm::control::{Inputs, State};
use steadyarm::eigen::eigenvalues;
use steadyarm::fuzzy::Form;
use steadyarm::math::Matrix;
use steadyarm::paper::{self, Reading};
use steadyarm::plant::{Plant, Undisturbed};
use steadyarm::riccati::{joint, joint_gamma_opt, joint_max_scale};
use steadyarm::sim::{Options, Run, simulate};

/// RMS errors are known to six decimals [rad].
const RMS_TOL: f64 = 1e-5;
/// Torques are known to three decimals [N·m].
const TAU_TOL: f64 = 1e-3;
/// P is known to all digits of a double but the last one or two.
const P_TOL: f64 = 4e-15;

fn assert_figures(name: &str, run: &Run<2>, golden: [f64; 3]) {
    let found = figures(run);
    for (k, tolerance) in [RMS_TOL, RMS_TOL, TAU_TOL].into_iter().enumerate() {
        let difference = (found[k] - golden[k]).abs();
        assert!(difference < tolerance, "{name}: {found:?}, golden {golden:?}");
    }
}

/// |ξ(0)|² with the paper's sets; a basis per joint counts both joints.
#[test]
fn squared_norm_of_the_basis_at_rest_matches_to_its_printed_digits() {
    let table = [
        (Form::Shared, 0.42163, 5e-6, 1.27067, 5e-6),
        (Form::Concat, 1.16663, 5e-6, 8.94112, 5e-6),
        (Form::Grid, 0.0072360, 5e-8, 24.9647, 5e-5),
    ];
    let squared = |form, normalized| {
        let basis = paper::basis(Reading { form, normalized, gain: 1.0 }, 4).unwrap();
        let mut xi = vec![0.0; basis.rules()];
        basis.evaluate(&[0.0; 4], &mut vec![0.0; basis.work_len()], &mut xi).unwrap();
        xi.iter().map(|x| x * x).sum::<f64>()
    };
    for (form, normalized, digit, raw, raw_digit) in table {
        assert!((squared(form, true) - normalized).abs() <= digit, "{form:?}");
        assert!((squared(form, false) - raw).abs() <= raw_digit, "{form:?}");
    }
    assert!((squared(Form::PerJoint { joints: 2 }, true) - 0.17013).abs() <= 5e-6);
}

#[test]
fn p_matches_for_the_papers_gains() {
    let p = joint(8.0, 5.5, 10.0, 10.0, 1.0).unwrap();
    let golden = [12.01352353475379, 0.6515307716504657, 1.147191888366882];
    for (found, golden) in [p.p11, p.p12, p.p22].into_iter().zip(golden) {
        assert!((found / golden - 1.0).abs() < P_TOL, "{p:?}");
    }
    let closed = Matrix::<2>::new(0.0, 1.0, -8.0 + p.p12, -5.5 + p.p22);
    let [a, b] = eigenvalues(&closed).unwrap();
    for root in [a, b] {
        assert!((root.re + 2.1764040558).abs() < 1e-10, "{root:?}");
        assert!((root.im.abs() - 1.6160862026).abs() < 1e-10, "{root:?}");
    }
    assert!((joint_gamma_opt(8.0, 5.5, 10.0, 10.0).unwrap() - 0.6143205381).abs() < 5e-11);
    let largest_q = 10.0 * joint_max_scale(8.0, 5.5, 10.0, 10.0, 1.0).unwrap();
    assert!((largest_q - 26.4978068488).abs() < 5e-10);
}

/// |e| is the norm over both joints; either joint alone is settled earlier.
#[test]
fn simulation_1_converges_and_settles_when_the_paper_says() {
    let exact = Plant::new(paper::nominal().unwrap(), Undisturbed);
    let mut state = State::new(());
    let run =
        simulate(&exact, &plain(), &mut state, &reference(), &Options::default(), on).unwrap();
    let [rms_1, rms_2, tau] = figures(&run);
    assert!(rms_1 < 1e-9 && rms_2 < 1e-9, "{rms_1} {rms_2}");
    assert!((tau - 15.350).abs() < TAU_TOL);
    for (band, time) in [(0.01, 2.168), (0.001, 2.946)] {
        let outside = run.e.iter().rposition(|e| e[0].hypot(e[1]) >= band).unwrap();
        assert!((run.t[outside + 1] - time).abs() < 1e-9, "{band}: {}", run.t[outside + 1]);
    }
}

#[test]
fn simulation_2_keeps_its_error() {
    let mut state = State::new(());
    let run =
        simulate(&plant(), &plain(), &mut state, &reference(), &Options::default(), on).unwrap();
    assert_figures("simulation 2", &run, [0.193026, 0.447902, 15.350]);
}

/// The paper's claim does not follow from what it prints: gain 1/7 leaves simulation 2's error as
/// it is.
#[test]
fn simulation_3_as_printed_is_inert() {
    let printed =
        [(Form::Shared, [0.192160, 0.443569, 15.350]), (Form::Grid, [0.192933, 0.447706, 15.350])];
    for (form, golden) in printed {
        let run = run(&adaptive(form, true, 1.0 / 7.0), &Options::default());
        assert_figures(&format!("{form:?} as printed"), &run, golden);
    }
}

#[test]
fn simulation_3_matches_in_every_other_reading() {
    let table = [
        (Form::Shared, true, 7.0, [0.170362, 0.332090, 15.350]),
        (Form::Shared, false, 7.0, [0.169970, 0.295614, 15.350]),
        (Form::Shared, true, 70.0, [0.064579, 0.107421, 19.551]),
        (Form::Shared, false, 70.0, [0.021925, 0.040805, 23.860]),
        (Form::Concat, false, 7.0, [0.030918, 0.057160, 23.923]),
        (Form::Concat, false, 70.0, [0.003015, 0.006027, 64.278]),
        (Form::Grid, true, 7.0, [0.188632, 0.438626, 15.350]),
        (Form::Grid, true, 70.0, [0.159819, 0.376522, 15.350]),
        (Form::Grid, false, 7.0, [0.010938, 0.021588, 25.302]),
    ];
    for (form, normalized, gain, golden) in table {
        let run = run(&adaptive(form, normalized, gain), &Options::default());
        assert_figures(&format!("{form:?} {normalized} {gain}"), &run, golden);
    }
}

#[test]
fn simulation_3_matches_with_the_state_as_inputs() {
    let controller = common::modified(Form::Grid, true, Inputs::state(), common::law(7.0));
    assert_figures(
        "grid, inputs state",
        &run(&controller, &Options::default()),
        [0.184484, 0.427863, 15.350],
    );
}

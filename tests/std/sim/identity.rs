//! The dissipation identity and the bound of the theorem, and the wrong sign of the law that both
//! must catch.

use crate::common::{
    self, Adaptive, adaptive, everything, fresh, law, modified, on, reference, run, with_parameters,
};
use steadyarm::control::{
    Adaptation, Applied, Audit, Compensator, Controller, FuzzyCompensator, FuzzyParameters,
    FuzzyState, Inputs, Limits, Sample, Stage,
};
use steadyarm::fuzzy::Form;
use steadyarm::math::Vector;
use steadyarm::sim::{Cause, Certificate, Method, Options, Run, Status, Tolerance, simulate};

/// At 1 ms: rounding of 40 000 steps, and h⁴ times the fastest motion of the loop.
const IDENTITY_TOL: f64 = 1e-11;

fn certificate(controller: &Adaptive, options: &Options<2>) -> Certificate {
    let run = run(controller, options);
    assert_eq!(run.status, Status::Finished);
    run.certificate.unwrap()
}

#[test]
fn identity_holds_on_every_reading_of_simulation_3() {
    let readings = [
        (Form::Shared, true, 1.0 / 7.0),
        (Form::Grid, true, 1.0 / 7.0),
        (Form::Shared, true, 7.0),
        (Form::Shared, false, 7.0),
        (Form::Shared, true, 70.0),
        (Form::Shared, false, 70.0),
        (Form::Concat, false, 7.0),
        (Form::Concat, false, 70.0),
        (Form::Grid, true, 7.0),
        (Form::Grid, true, 70.0),
        (Form::Grid, false, 7.0),
        (Form::PerJoint { joints: 2 }, true, 70.0),
    ];
    for (form, normalized, gain) in readings {
        let residual =
            certificate(&adaptive(form, normalized, gain), &Options::default()).residual();
        assert!(residual < IDENTITY_TOL, "{form:?} {normalized} {gain}: {residual:e}");
    }
}

#[test]
fn identity_holds_with_every_modification_and_attenuation_level() {
    let options = Options { duration: 10.0, ..Options::default() };
    let plain = law(40.0);
    let laws = [
        ("leak", Adaptation { leak_rate: 0.5, ..plain }),
        ("e-modification", Adaptation { error_modification: 0.05, ..plain }),
        ("normalisation", Adaptation { normalization: 0.7, ..plain }),
        ("projection", Adaptation { projection_radius: 1.0, ..plain }),
        ("dead zone", Adaptation { dead_zone: 0.05, ..plain }),
        ("everything", everything(40.0)),
    ];
    for (name, adaptation) in laws {
        for gamma in [0.7, 1.0, 5.0, f64::INFINITY] {
            let (q_position, q_velocity) = ([10.0, 7.0], [3.0, 10.0]);
            let inputs = Inputs::state();
            let parameters = FuzzyParameters { inputs, q_position, q_velocity, gamma, adaptation };
            let controller = with_parameters(Form::Grid, true, parameters);
            let residual = certificate(&controller, &options).residual();
            assert!(residual < IDENTITY_TOL, "{name}, gamma {gamma}: {residual:e}");
        }
    }
}

/// The laws here are smooth; a dead zone has a corner, and the stiff readings need steps below 2
/// ms.
#[test]
fn identity_residual_falls_with_the_fourth_power_of_the_step() {
    let plain = law(7.0);
    let smooth =
        Adaptation { leak_rate: 0.5, error_modification: 0.05, normalization: 0.1, ..plain };
    for adaptation in [plain, smooth] {
        let controller = modified(Form::Grid, false, Inputs::error(), adaptation);
        let residuals = [16e-3, 8e-3, 4e-3, 2e-3, 1e-3].map(|dt| {
            let options = Options { duration: 3.2, dt, ..Options::default() };
            certificate(&controller, &options).residual()
        });
        for pair in residuals.windows(2) {
            let slope = (pair[0] / pair[1]).log2();
            assert!((slope - 4.0).abs() < 0.2, "slope {slope}: {residuals:?}");
        }
    }
}

#[test]
fn identity_residual_falls_with_the_tolerance_of_the_error_control() {
    for rtol in [1e-6, 1e-8, 1e-10] {
        let method = Method::Dp54(Tolerance { rtol, atol: rtol });
        let options = Options { duration: 10.0, method, ..Options::default() };
        let residual = certificate(&adaptive(Form::Grid, false, 7.0), &options).residual();
        assert!(residual < rtol, "{rtol:e}: {residual:e}");
    }
}

#[test]
fn identity_holds_where_the_torque_is_limited() {
    let limits = Limits { effort_limit: [9.0; 2], ..Limits::default() };
    let controller = adaptive(Form::Grid, false, 70.0).with_limits(limits).unwrap();
    let run = run(&controller, &Options { duration: 10.0, ..Options::default() });
    let cut = run.tau.iter().filter(|tau| tau[0].abs() == 9.0).count();
    let residual = run.certificate.unwrap().residual();
    assert!(cut > 1000, "only {cut} rows were limited");
    // Where a limit sets in or ends inside a step, the rates jump: no order of convergence there.
    assert!(residual < 1e-4, "{residual:e}");
}

/// int xᵀQx <= V(0) + gamma² int |rho - W0 xi|², what the theorem promises.
#[test]
fn tracking_error_is_bounded_by_the_uncertainty() {
    for gamma in [0.62, 0.8, 1.0, 2.0] {
        for adaptation in [law(0.1), law(7.0), law(700.0), everything(7.0)] {
            let parameters = FuzzyParameters { gamma, adaptation, ..FuzzyParameters::default() };
            let controller = with_parameters(Form::Concat, false, parameters);
            let options = Options { duration: 10.0, q0: [1.0, -1.0], ..Options::default() };
            let found = certificate(&controller, &options);
            let bound = found.v_start + gamma * gamma * found.uncertainty;
            assert!(found.state_cost <= bound, "{gamma}: {} {bound}", found.state_cost);
            assert!(found.state_cost > 0.0);
        }
    }
}

/// (18) with the printed minus applied to W: the negated error flips s, and mirrors the sets of
/// every input, which for symmetric centres only renames the rules.
struct Flipped(FuzzyCompensator<2>);

type Weights = FuzzyState<2, Vec<f64>>;

impl Flipped {
    fn mirror(sample: &Sample<2>) -> Sample<2> {
        Sample { e: -sample.e, de: -sample.de, ..*sample }
    }
}

impl Compensator<2, Weights> for Flipped {
    fn estimate(&self, state: &mut Weights, stage: &Stage<'_>, sample: &Sample<2>) -> Vector<2> {
        self.0.estimate(state, stage, &Self::mirror(sample))
    }
    fn acted(&self, state: &mut Weights, i: usize, sample: &Sample<2>, applied: &Applied<2>) {
        self.0.acted(state, i, &Self::mirror(sample), applied);
    }
    fn advance(&self, state: &mut Weights, end: &Stage<'_>) -> steadyarm::Result<()> {
        self.0.advance(state, end)
    }
    fn reset(&self, state: &mut Weights) {
        self.0.reset(state);
    }
    fn audit(&self, state: &Weights, index: usize, sample: &Sample<2>) -> Option<Audit<2>> {
        self.0.audit(state, index, sample)
    }
}

/// Also of the other tests: what a run that blows up looks like.
pub fn flipped(options: &Options<2>) -> Run<2> {
    let right = adaptive(Form::Concat, false, 7.0);
    let mut state = fresh(&right);
    let Controller { law, compensator, .. } = right;
    let wrong = Controller::new(law, Flipped(compensator));
    simulate(&common::plant(), &wrong, &mut state, &reference(), options, on).unwrap()
}

/// The motion passes every bound at 8.9 s, or 9.4 s with a tight tolerance (it is chaotic by then).
/// A fixed step of 1 ms follows it for 5 s only, and ends later.
#[test]
fn the_printed_sign_applied_to_the_weights_diverges() {
    let method = Method::Dp54(Tolerance { rtol: 1e-3, atol: 1e-3 });
    let run = flipped(&Options { method, record_every: 100, ..Options::default() });
    let Status::Diverged { t, cause, .. } = run.status else { panic!("{}", run.status) };
    assert_eq!(cause, Cause::Motion);
    assert!((8.8..9.5).contains(&t), "diverged at {t} s");
    assert!((run.e[40][0] + 74.4).abs() < 0.5, "{:?}", run.e[40]);
    let fixed = flipped(&Options::default());
    assert!(matches!(fixed.status, Status::Diverged { cause: Cause::Motion, .. }));
    assert!((fixed.e[4000][0] + 74.4).abs() < 0.1, "{:?}", fixed.e[4000]);
}

#[test]
fn identity_catches_the_wrong_sign_before_the_run_diverges() {
    for duration in [0.5, 2.0, 5.0] {
        let options = Options { duration, ..Options::default() };
        let residual = flipped(&options).certificate.unwrap().residual();
        assert!(residual > 0.5, "{duration}: {residual:e}");
    }
}

//! Dormand-Prince takes its last stage as the first of the next step: only rounding may tell.

use crate::common::{adaptive, everything, fresh, law, modified, on, plant, reference};
use steadyarm::control::{
    Adaptation, Applied, Audit, Compensator, Controller, FuzzyCompensator, FuzzyState, Inputs,
    Sample, Stage,
};
use steadyarm::fuzzy::Form;
use steadyarm::math::Vector;
use steadyarm::sim::{Method, Options, Run, Tolerance, simulate};

/// Rounding of some hundred steps.
const ROUNDING: f64 = 1e-12;

/// The projection has a kink: there rounding decides whether a step is tried again, and the weights
/// differ by what a step of this tolerance leaves.
const KINK: f64 = 1e-7;

type Weights = FuzzyState<2, Vec<f64>>;

/// The compensator, but every stage is evaluated.
struct Again(FuzzyCompensator<2>);

impl Compensator<2, Weights> for Again {
    fn estimate(&self, state: &mut Weights, stage: &Stage<'_>, sample: &Sample<2>) -> Vector<2> {
        self.0.estimate(state, stage, sample)
    }
    fn acted(&self, state: &mut Weights, i: usize, sample: &Sample<2>, applied: &Applied<2>) {
        self.0.acted(state, i, sample, applied);
    }
    fn advance(&self, state: &mut Weights, end: &Stage<'_>) -> steadyarm::Result<()> {
        self.0.advance(state, end)
    }
    fn reset(&self, state: &mut Weights) {
        Compensator::reset(&self.0, state);
    }
    fn audit(&self, state: &Weights, index: usize, sample: &Sample<2>) -> Option<Audit<2>> {
        self.0.audit(state, index, sample)
    }
}

fn options() -> Options<2> {
    let method = Method::Dp54(Tolerance { rtol: 1e-8, atol: 1e-10 });
    Options { duration: 3.0, method, q0: [0.5, -0.5], record_every: 50, ..Options::default() }
}

fn assert_same(name: &str, tol: f64, carried: &Run<2>, again: &Run<2>) {
    assert_eq!(carried.status, again.status, "{name}");
    for (column, [a, b]) in [
        ("q", [&carried.q, &again.q]),
        ("dq", [&carried.dq, &again.dq]),
        ("rho_hat", [&carried.rho_hat, &again.rho_hat]),
    ] {
        for (a, b) in a.iter().flatten().zip(b.iter().flatten()) {
            assert!((a - b).abs() < tol * (1.0 + b.abs()), "{name}: {column} {a} {b}");
        }
    }
    let norms = carried.weights_norm.iter().zip(&again.weights_norm);
    assert!(norms.into_iter().all(|(a, b)| (a - b).abs() < tol * (1.0 + b)), "{name}");
    let [a, b] = [carried, again].map(|run| run.certificate.unwrap());
    assert!((a.supplied - b.supplied).abs() < tol * (1.0 + b.turnover), "{name}");
    assert!((a.v_end - b.v_end).abs() < tol * (1.0 + b.v_end), "{name}");
}

#[test]
fn a_carried_stage_is_the_evaluated_one() {
    let plain = law(70.0);
    let laws = [
        ("plain", plain, ROUNDING),
        ("leak", Adaptation { leak_rate: 0.5, ..plain }, ROUNDING),
        ("e-modification", Adaptation { error_modification: 0.05, ..plain }, ROUNDING),
        ("normalisation", Adaptation { normalization: 0.7, ..plain }, ROUNDING),
        ("projection", Adaptation { projection_radius: 1.0, ..plain }, KINK),
        ("everything", everything(70.0), KINK),
    ];
    for form in [Form::Grid, Form::PerJoint { joints: 2 }, Form::Shared] {
        for (name, adaptation, tol) in laws {
            let controller = modified(form, true, Inputs::error(), adaptation);
            let mut state = fresh(&controller);
            let carried =
                simulate(&plant(), &controller, &mut state, &reference(), &options(), on).unwrap();
            let mut state = fresh(&controller);
            let Controller { law, compensator, .. } = controller;
            let again = Controller::new(law, Again(compensator));
            let again =
                simulate(&plant(), &again, &mut state, &reference(), &options(), on).unwrap();
            assert_same(&format!("{form:?} {name}"), tol, &carried, &again);
        }
    }
}

#[test]
fn a_frozen_compensator_carries_too() {
    let controller = adaptive(Form::Grid, true, 70.0);
    let mut state = fresh(&controller);
    let learning = simulate(&plant(), &controller, &mut state, &reference(), &options(), on);
    assert!(learning.is_ok());
    controller.settle(&mut state).freeze();
    let mut other = state.clone();
    let carried = simulate(&plant(), &controller, &mut state, &reference(), &options(), on);
    let Controller { law, compensator, .. } = controller;
    let again = Controller::new(law, Again(compensator));
    let again = simulate(&plant(), &again, &mut other, &reference(), &options(), on);
    assert_same("frozen", ROUNDING, &carried.unwrap(), &again.unwrap());
}

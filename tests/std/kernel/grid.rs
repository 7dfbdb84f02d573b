//! While nothing is merged and nothing goes, the kernel form is the grid that is written out, to
//! rounding.

use steadyarm::control::{Adaptation, State};
use steadyarm::fuzzy::{Axis, Form, FuzzyBasis, KernelBasis};
use steadyarm::sim::{Certificate, Method, Options, Run, Status, Tolerance, simulate};

use super::scene::{self, both, difference, drive, expanded, fresh, row_norms};
use crate::common::{self, Random, everything, law, on};

/// Sums over rules against sums over atoms: relative to the largest.
const GRID_TOL: f64 = 1e-11;

fn laws() -> [(&'static str, Adaptation<2>); 7] {
    let plain = law(40.0);
    [
        ("plain", plain),
        ("leak", Adaptation { leak_rate: 0.5, ..plain }),
        ("e-modification", Adaptation { error_modification: 0.05, ..plain }),
        ("projection", Adaptation { projection_radius: 1.0, ..plain }),
        ("dead zone", Adaptation { dead_zone: 0.05, ..plain }),
        ("normalisation", Adaptation { normalization: 0.7, ..plain }),
        ("everything", everything(40.0)),
    ]
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |largest: f64, x| largest.max(x.abs()))
}

#[test]
fn the_kernel_is_the_product_of_the_bases() {
    let narrow: &[f64] = &[0.3, 0.5, 0.4];
    let axes = [
        scene::PAPER_AXIS,
        Axis { centers: &[-1.0, 0.2, 0.9], widths: narrow },
        Axis { centers: &[0.0, 1.0, 2.0, 3.0], widths: &[0.6] },
    ];
    let mut random = Random(5);
    for normalized in [true, false] {
        let kernel = KernelBasis::new(normalized, &axes).unwrap();
        let grid = FuzzyBasis::new(Form::Grid, normalized, &axes).unwrap();
        assert_eq!((kernel.inputs(), kernel.sets(), kernel.rules()), (3, 12, 60.0));
        let (mut work, mut k_work) = (vec![0.0; grid.work_len()], vec![0.0; kernel.work_len()]);
        for _ in 0..1000 {
            let [x, y] = [(); 2].map(|()| [(); 3].map(|()| random.within(-3.0, 3.0)));
            let [xi, eta] = [x, y].map(|x| {
                let mut xi = vec![0.0; grid.rules()];
                grid.evaluate(&x, &mut work, &mut xi).unwrap();
                xi
            });
            let wanted: f64 = xi.iter().zip(&eta).map(|(a, b)| a * b).sum();
            let found = kernel.kernel(&x, &y, &mut k_work).unwrap();
            assert!((found - wanted).abs() <= 1e-14 * wanted, "{found} {wanted}");
        }
    }
}

#[test]
fn sampled_steps_agree_with_the_grid_with_every_modification() {
    const STEPS: usize = 500;
    for normalized in [true, false] {
        for (name, adaptation) in laws() {
            let pair = both(normalized, adaptation, STEPS, 0.0);
            let (mut tau, mut rho) = ([0.0_f64; 2], [0.0_f64; 2]);
            drive(&pair, STEPS, 0.01, |k, dense, kernel| {
                let [a, b] = [dense.last_tau, kernel.last_tau].map(Option::unwrap);
                tau = [tau[0].max(a.amax()), tau[1].max((a - b).amax())];
                let kernel = kernel.compensator();
                let [a, b] = [dense.compensator().weights_norm(), kernel.weights_norm()];
                rho = [rho[0].max(a), rho[1].max((a - b).abs())];
                if k + 1 == STEPS {
                    let wanted = common::learnt(&pair.0, dense);
                    let found = expanded(&pair.1, kernel);
                    let error = largest(&difference(&wanted, &found)) / largest(&wanted);
                    assert!(error < GRID_TOL, "{name} {normalized}: W {error:e}");
                    let counters = (kernel.merged(), kernel.dropped());
                    assert_eq!(counters, (0, 0));
                    assert!(kernel.error_bound().amax() < 1e-90);
                    assert!(kernel.atoms() > STEPS / 4);
                }
            });
            assert!(tau[1] < GRID_TOL * tau[0], "{name} {normalized}: tau {:e}", tau[1]);
            assert!(rho[1] < GRID_TOL * rho[0], "{name} {normalized}: |W| {:e}", rho[1]);
            assert!(rho[0] > 0.05, "{name} {normalized}: nothing was learnt, {}", rho[0]);
        }
    }
}

/// A run of both, and how far they are apart.
fn runs(name: &str, normalized: bool, adaptation: Adaptation<2>, options: &Options<2>) -> Run<2> {
    let (dense, kernel) = both(normalized, adaptation, 2400, 0.0);
    let (plant, reference) = (common::plant(), common::reference());
    let wanted = common::run(&dense, options);
    let mut state = fresh(&kernel);
    let found = simulate(&plant, &kernel, &mut state, &reference, options, on).unwrap();
    assert_eq!((wanted.status, found.status), (Status::Finished, Status::Finished));
    let own = state.compensator();
    assert_eq!((own.merged(), own.dropped()), (0, 0));
    assert!(own.atoms() > 100, "{}", own.atoms());
    let columns =
        |run: &Run<2>| [&run.q, &run.dq, &run.tau, &run.rho_hat].map(|x| x.as_flattened().to_vec());
    let scalars = |run: &Run<2>| [run.weights_norm.clone(), run.v.clone()];
    let pairs = columns(&wanted).into_iter().zip(columns(&found));
    for (k, (a, b)) in pairs.chain(scalars(&wanted).into_iter().zip(scalars(&found))).enumerate() {
        let error = largest(&difference(&a, &b)) / largest(&a);
        assert!(error < GRID_TOL, "{name} {normalized}, column {k}: {error:e}");
    }
    found
}

#[test]
fn runs_in_continuous_time_agree_with_the_grid() {
    let options = Options { duration: 0.5, q0: [0.5, -0.5], ..Options::default() };
    let tolerance = Tolerance { rtol: 1e-9, atol: 1e-11 };
    let dp54 = Options { method: Method::Dp54(tolerance), ..options };
    for normalized in [true, false] {
        for (name, adaptation) in laws() {
            runs(name, normalized, adaptation, &options);
        }
        // The projection has a corner, where an error estimate, and with it the step, scatters with
        // the last digit.
        let smooth = Adaptation { projection_radius: f64::INFINITY, ..everything(40.0) };
        let leak = Adaptation { leak_rate: 0.5, ..law(40.0) };
        runs("DP5(4)", normalized, law(40.0), &dp54);
        runs("DP5(4), leak", normalized, leak, &dp54);
        runs("DP5(4), all but the projection", normalized, smooth, &dp54);
    }
}

#[test]
fn the_dissipation_identity_holds_while_nothing_is_merged() {
    let options = Options { duration: 0.5, q0: [0.5, -0.5], ..Options::default() };
    for (name, adaptation) in laws() {
        let certificate: Certificate = runs(name, true, adaptation, &options).certificate.unwrap();
        let residual = certificate.residual();
        assert!(certificate.turnover > 1.0 && residual < 1e-11, "{name}: {residual:e}");
    }
}

#[test]
fn a_stage_that_is_held_teaches_nothing() {
    let (_, kernel) = both(true, law(40.0), 64, 0.0);
    let limits = steadyarm::control::Limits { effort_limit: [1e-3; 2], ..Default::default() };
    let kernel = kernel.with_limits(limits).unwrap();
    let mut state: scene::Memory<2> = State::new(kernel.compensator.state());
    for (q, dq, desired) in common::samples().iter().take(20) {
        let command = kernel.step(&mut state, q, dq, desired, 1e-3).unwrap();
        assert!(command.limited);
    }
    let own = kernel.settle(&mut state);
    assert_eq!((own.atoms(), own.weights_norm()), (0, 0.0));
}

#[test]
fn a_leak_of_many_lifetimes_goes_into_the_coefficients() {
    // exp(−300 · 0.5) a step: the scale passes 1e-100 every other step, and what was learnt first
    // is gone.
    let pair = both(true, Adaptation { leak_rate: 300.0, ..law(40.0) }, 64, 0.0);
    drive(&pair, 60, 0.5, |k, dense, kernel| {
        let wanted = common::learnt(&pair.0, dense);
        let found = expanded(&pair.1, kernel.compensator());
        let error = row_norms(&difference(&wanted, &found)).norm();
        assert!(error <= GRID_TOL * row_norms(&wanted).norm(), "{k}: {error:e}");
    });
}

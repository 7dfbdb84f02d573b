//! The fuzzy basis against a direct evaluation of (1)-(4), its limits and refusals, and the
//! approximator.

use crate::common::{FORMS, Random};
use steadyarm::fuzzy::{
    Axis, Form, FuzzyApproximator, FuzzyBasis, MAX_INPUTS, MAX_RULES, MAX_SETS,
};
use steadyarm::{Error, Problem};

/// A dozen roundings in a product of four memberships, and a power of one exponential instead of
/// each its own.
const BASIS_TOL: f64 = 1e-13;

#[derive(Clone)]
struct Sets {
    centers: Vec<f64>,
    widths: Vec<f64>,
}

fn basis(form: Form, normalized: bool, sets: &[Sets]) -> FuzzyBasis {
    try_basis(form, normalized, sets).unwrap()
}

fn try_basis(form: Form, normalized: bool, sets: &[Sets]) -> steadyarm::Result<FuzzyBasis> {
    let axes: Vec<_> =
        sets.iter().map(|s| Axis { centers: &s.centers, widths: &s.widths }).collect();
    FuzzyBasis::new(form, normalized, &axes)
}

fn xi(basis: &FuzzyBasis, x: &[f64]) -> Vec<f64> {
    let mut xi = vec![f64::NAN; basis.rules()];
    basis.evaluate(x, &mut vec![f64::NAN; basis.work_len()], &mut xi).unwrap();
    xi
}

/// (1): every set of one input.
fn mu(sets: &Sets, x: f64) -> Vec<f64> {
    let width = |j: usize| sets.widths[if sets.widths.len() == 1 { 0 } else { j }];
    let gauss = |(j, c): (usize, &f64)| (-0.5 * ((x - c) / width(j)).powi(2)).exp();
    sets.centers.iter().enumerate().map(gauss).collect()
}

fn products(mu: &[Vec<f64>]) -> Vec<f64> {
    mu.iter().fold(vec![1.0], |rules, axis| {
        rules.iter().flat_map(|r| axis.iter().map(move |m| r * m)).collect()
    })
}

/// (4), as printed.
fn divide_by_sum(strengths: Vec<f64>, normalized: bool) -> Vec<f64> {
    let sum = if normalized { strengths.iter().sum() } else { 1.0 };
    strengths.iter().map(|s| s / sum).collect()
}

fn naive(form: Form, normalized: bool, sets: &[Sets], x: &[f64]) -> Vec<f64> {
    let mu: Vec<_> = sets.iter().zip(x).map(|(s, x)| mu(s, *x)).collect();
    let whole = |strengths| divide_by_sum(strengths, normalized);
    match form {
        Form::Grid => whole(products(&mu)),
        Form::Shared => {
            whole((0..mu[0].len()).map(|j| mu.iter().map(|m| m[j]).product()).collect())
        }
        Form::Concat => mu.into_iter().flat_map(whole).collect(),
        Form::PerJoint { joints } => {
            let own = |n| mu.iter().skip(n).step_by(joints).cloned().collect::<Vec<_>>();
            (0..joints).flat_map(|n| whole(products(&own(n)))).collect()
        }
    }
}

/// Four inputs with five sets each: an even lattice, one with gaps, or anything in any order.
fn random_sets(random: &mut Random, kind: usize) -> Vec<Sets> {
    let axis = |_| {
        let (low, step) = (random.within(-2.0, 0.0), random.within(0.2, 1.0));
        let steps = [0.0, 1.0, 2.0 + (kind % 2) as f64, 4.0, 5.0];
        let even = steps.map(|k| low + k * step).to_vec();
        let uneven = (0..5).map(|_| random.within(-2.0, 2.0)).collect();
        let one = vec![random.within(0.3, 2.0)];
        let each = (0..5).map(|_| random.within(0.3, 2.0)).collect();
        match kind {
            0 | 1 => Sets { centers: even, widths: one },
            2 => Sets { centers: uneven, widths: one },
            _ => Sets { centers: uneven, widths: each },
        }
    };
    (0..4).map(axis).collect()
}

fn papers_sets(inputs: usize) -> Vec<Sets> {
    let centers = vec![-1.5, -0.5, 0.0, 0.5, 1.5];
    vec![Sets { centers, widths: vec![std::f64::consts::FRAC_1_SQRT_2] }; inputs]
}

#[test]
fn basis_equals_the_equations_evaluated_directly() {
    let mut random = Random(1);
    for case in 0..400 {
        let sets = random_sets(&mut random, case % 4);
        let x: Vec<_> = (0..4).map(|_| random.within(-3.0, 3.0)).collect();
        for form in FORMS {
            for normalized in [true, false] {
                let found = xi(&basis(form, normalized, &sets), &x);
                let direct = naive(form, normalized, &sets, &x);
                assert_eq!(found.len(), direct.len());
                for (a, b) in found.iter().zip(&direct) {
                    assert!((a - b).abs() < BASIS_TOL, "{form:?} {normalized} {case}: {a} {b}");
                }
            }
        }
    }
}

/// With the paper's four inputs (4) as printed is 0/0 from |x| = 15.15 on.
#[test]
fn far_outside_nothing_is_nan_and_the_normalised_sum_is_one() {
    let unequal = Sets { centers: vec![-1.5, 0.0, 2.0], widths: vec![0.5, 0.7, 0.6] };
    let tiny = Sets { centers: vec![-1e9, 0.0, 1e9], widths: vec![1e-9, 1e-9, 1e9] };
    let scenes = [papers_sets(4), vec![unequal; 4], vec![tiny; 4]];
    for sets in &scenes {
        for x in [0.0, 15.2, -40.0, 1e3, 1e15, 1e101, 1e308, -1e308, f64::MIN_POSITIVE] {
            for form in FORMS {
                let sums = match form {
                    Form::Concat => 4.0,
                    Form::PerJoint { .. } => 2.0,
                    _ => 1.0,
                };
                for x in [[x; 4], [x, -x, 0.0, 1.0]] {
                    let found = xi(&basis(form, true, sets), &x);
                    let sum: f64 = found.iter().sum();
                    assert!((sum - sums).abs() < BASIS_TOL, "{form:?} {x:?}: {sum}");
                    let raw = xi(&basis(form, false, sets), &x);
                    assert!(raw.iter().chain(&found).all(|p| (0.0..=1.0 + 1e-12).contains(p)));
                }
            }
        }
    }
}

#[test]
fn far_away_the_widest_set_wins() {
    let sets = [Sets { centers: vec![-3.0, 0.0, 1.0], widths: vec![0.5, 1.0, 0.6] }];
    for x in [100.0, -100.0, 1e15, 1e308, -1e308] {
        assert_eq!(xi(&basis(Form::Grid, true, &sets), &[x]), [0.0, 1.0, 0.0]);
    }
}

#[test]
fn first_input_is_the_slowest_in_a_grid() {
    let sets =
        [2, 3, 4].map(|n| Sets { centers: (0..n).map(f64::from).collect(), widths: vec![0.1] });
    let basis = basis(Form::Grid, true, &sets);
    for (i, j, k) in [(0, 0, 0), (1, 0, 0), (0, 2, 1), (1, 2, 3)] {
        let found = xi(&basis, &[i as f64, j as f64, k as f64]);
        assert!(found[(i * 3 + j) * 4 + k] > 0.999);
    }
}

/// Grids of up to MAX_RULES: the factors u and v of every split are put together in the right
/// order.
#[test]
fn large_grids_equal_the_equations_too() {
    let mut random = Random(2);
    for inputs in [1, 2, 5, 7] {
        let sets = papers_sets(inputs);
        let x: Vec<_> = (0..inputs).map(|_| random.within(-2.0, 2.0)).collect();
        let (found, direct) =
            (xi(&basis(Form::Grid, true, &sets), &x), naive(Form::Grid, true, &sets, &x));
        assert!(found.iter().zip(&direct).all(|(a, b)| (a - b).abs() < BASIS_TOL));
    }
}

#[test]
fn too_many_rules_are_refused_before_anything_is_allocated() {
    let ten = Sets { centers: (0..10).map(f64::from).collect(), widths: vec![1.0] };
    let refusal = |inputs| try_basis(Form::Grid, true, &vec![ten.clone(); inputs]).unwrap_err();
    let error = |got| Error::too_many("rules", got, MAX_RULES);
    assert_eq!(refusal(7), error(Some(10_000_000)));
    assert_eq!(refusal(19), error(Some(10_000_000_000_000_000_000)));
    assert_eq!(refusal(20), error(None));
    assert!(try_basis(Form::Grid, true, &vec![ten.clone(); 6]).is_ok());
}

#[test]
fn too_many_inputs_or_sets_are_refused() {
    let one = Sets { centers: vec![0.0], widths: vec![1.0] };
    let refusal = |sets: &[Sets]| try_basis(Form::Concat, true, sets).unwrap_err();
    let inputs = Error::too_many("inputs", Some(MAX_INPUTS + 1), MAX_INPUTS);
    assert_eq!(refusal(&vec![one; MAX_INPUTS + 1]), inputs);
    let many = Sets { centers: (0..200).map(f64::from).collect(), widths: vec![1.0] };
    let sets = Error::too_many("sets", Some(600), MAX_SETS);
    assert_eq!(refusal(&vec![many; 3]), sets);
}

#[test]
fn every_bad_set_is_refused_by_name() {
    let refusal = |form, change: &dyn Fn(&mut Vec<Sets>)| {
        let mut sets = papers_sets(4);
        change(&mut sets);
        format!("{}", try_basis(form, true, &sets).unwrap_err())
    };
    let grid = |change: &dyn Fn(&mut Vec<Sets>)| refusal(Form::Grid, change);
    assert_eq!(grid(&|s| s.clear()), "inputs: got 0 entries, wants 1");
    assert_eq!(grid(&|s| s[1].centers.clear()), "centers: got 0 entries, wants 1");
    assert_eq!(grid(&|s| s[1].centers[2] = f64::NAN), "centers[2]: got NaN, wants a finite number");
    assert!(grid(&|s| s[3].centers[0] = -2e9).starts_with("centers[0]: got -2000000000, wants"));
    assert_eq!(grid(&|s| s[0].widths = vec![1.0; 4]), "width: got 4 entries, wants 5");
    assert_eq!(grid(&|s| s[0].widths.clear()), "width: got 0 entries, wants 5");
    for bad in [0.0, -1.0, 1e-10, 1e10] {
        assert!(grid(&|s| s[0].widths[0] = bad).starts_with("width: got "));
    }
    assert_eq!(grid(&|s| s[0].widths[0] = f64::INFINITY), "width: got inf, wants a finite number");
    let fewer = |s: &mut Vec<Sets>| s[3].centers.truncate(4);
    assert_eq!(refusal(Form::Shared, &fewer), "centers: got 4 entries, wants 5");
    let per_joint = |joints| refusal(Form::PerJoint { joints }, &fewer);
    assert_eq!(per_joint(2), "centers: got 4 entries, wants 5");
    assert_eq!(per_joint(3), "inputs: got 4 entries, wants 6");
    assert_eq!(per_joint(0), "joints: got 0 entries, wants 1");
}

#[test]
fn every_bad_argument_of_an_evaluation_is_refused_by_name() {
    let basis = basis(Form::Grid, true, &papers_sets(2));
    let try_with = |x: &[f64], work: usize, rules: usize| {
        basis.evaluate(x, &mut vec![0.0; work], &mut vec![0.0; rules]).map_err(|e| e.to_string())
    };
    let work = basis.work_len();
    assert_eq!(try_with(&[0.0; 2], work, 25), Ok(()));
    assert_eq!(try_with(&[0.0; 3], work, 25).unwrap_err(), "x: got 3 entries, wants 2");
    let nan = try_with(&[0.0, f64::NAN], work, 25).unwrap_err();
    assert_eq!(nan, "x[1]: got NaN, wants a finite number");
    let short = try_with(&[0.0; 2], work - 1, 25).unwrap_err();
    assert_eq!(short, format!("work: got {} entries, wants {work}", work - 1));
    assert_eq!(try_with(&[0.0; 2], work, 24).unwrap_err(), "xi: got 24 entries, wants 25");
}

fn approximator(sets: usize, ridge: f64, samples: usize) -> steadyarm::Result<FuzzyApproximator> {
    let step = 2.0 / (sets - 1) as f64;
    let centers = (0..sets).map(|j| -1.0 + j as f64 * step).collect();
    let basis = basis(Form::Grid, true, &[Sets { centers, widths: vec![step] }]);
    let x: Vec<_> = (0..samples).map(|k| -1.0 + 2.0 * k as f64 / samples as f64).collect();
    let y: Vec<_> = x.iter().flat_map(|x| [(3.0 * x).sin(), x.abs()]).collect();
    FuzzyApproximator::fit(basis, &x, &y, 2, ridge)
}

/// The statement (5): more rules, less error, for a smooth function and for one with a corner.
#[test]
fn approximation_improves_with_the_number_of_rules() {
    let error = |sets| {
        let fitted = approximator(sets, 1e-12, 2000).unwrap();
        let x: Vec<_> = (0..=1000).map(|k| -0.99 + 1.98 * f64::from(k) / 1000.0).collect();
        let y = fitted.evaluate(&x).unwrap();
        let largest = |f: &dyn Fn(f64) -> f64, n: usize| {
            x.iter().zip(y.chunks(2)).map(|(x, y)| (y[n] - f(*x)).abs()).fold(0.0, f64::max)
        };
        [largest(&|x| (3.0 * x).sin(), 0), largest(&f64::abs, 1)]
    };
    let errors = [3, 6, 12, 24].map(error);
    for pair in errors.windows(2) {
        assert!((0..2).all(|n| pair[1][n] < 0.65 * pair[0][n]), "{errors:?}");
    }
    assert!(errors[3][0] < 0.005 * errors[0][0], "{errors:?}");
}

#[test]
fn samples_that_do_not_determine_the_weights_need_a_ridge() {
    let refusal = approximator(20, 0.0, 10).unwrap_err();
    assert!(matches!(refusal.problem(), Problem::NotPositive { .. }), "{refusal}");
    assert_eq!(refusal.parameter(), "ridge");
    assert!(approximator(20, 1e-9, 10).is_ok());
    assert!(approximator(5, 0.0, 100).is_ok());
}

#[test]
fn known_weights_give_back_the_fitted_function() {
    let fitted = approximator(6, 1e-9, 40).unwrap();
    let (basis, weights) = (fitted.basis().clone(), fitted.weights().to_vec());
    let copy = FuzzyApproximator::from_weights(basis.clone(), weights).unwrap();
    let x = [-0.7, 0.1, 0.9];
    assert_eq!(copy.evaluate(&x), fitted.evaluate(&x));
    let refusal = |weights| FuzzyApproximator::from_weights(basis.clone(), weights).unwrap_err();
    assert_eq!(refusal(vec![0.0; 5]).to_string(), "weights: got 5 entries, wants 6");
    assert_eq!(refusal(Vec::new()).to_string(), "weights: got 0 entries, wants 6");
}

#[test]
fn every_bad_argument_of_a_fit_is_refused_by_name() {
    let basis = basis(Form::Grid, true, &papers_sets(2));
    let refusal = |x: &[f64], y: &[f64], outputs, ridge| {
        FuzzyApproximator::fit(basis.clone(), x, y, outputs, ridge).unwrap_err().to_string()
    };
    let (x, y) = ([0.5; 6], [1.0; 3]);
    let fitted = FuzzyApproximator::fit(basis.clone(), &x, &y, 1, 1e-3).unwrap();
    assert_eq!(fitted.evaluate(&[0.0; 3]).unwrap_err().to_string(), "x: got 3 entries, wants 4");
    assert_eq!(refusal(&x[..5], &y, 1, 1e-3), "x: got 5 entries, wants 4");
    assert_eq!(refusal(&[], &y, 1, 1e-3), "x: got 0 entries, wants 2");
    assert_eq!(refusal(&x, &y[..2], 1, 1e-3), "y: got 2 entries, wants 3");
    assert_eq!(refusal(&x, &y, 2, 1e-3), "y: got 3 entries, wants 6");
    assert_eq!(refusal(&x, &y, 0, 1e-3), "outputs: got 0 entries, wants 1");
    assert_eq!(refusal(&x, &y, 1, -1.0), "ridge: got -1, wants a number >= 0");
    assert_eq!(refusal(&x, &y, 1, f64::NAN), "ridge: got NaN, wants a finite number");
    assert_eq!(refusal(&x, &[0.0, f64::NAN, 0.0], 1, 1e-3), "y[1]: got NaN, wants a finite number");
    assert_eq!(
        refusal(&[0.0, 0.0, 0.0, f64::INFINITY], &y[..2], 1, 1e-3),
        "x[3]: got inf, wants a finite number"
    );
}

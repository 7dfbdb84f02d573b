//! What the Riccati solvers refuse: one valid setup, one thing broken per test, the parameter
//! named.

use nalgebra::SMatrix;
use steadyarm::riccati::{
    bounded_real, care, gamma_opt, joint, joint_gamma_opt, joint_lqr, joint_max_scale,
};
use steadyarm::{Error, Problem};

/// Paper: K_p = 8, K_v = 5.5, one joint, Q = q I.
fn paper(q: f64) -> (SMatrix<f64, 2, 2>, SMatrix<f64, 2, 1>, SMatrix<f64, 2, 2>) {
    (
        SMatrix::<f64, 2, 2>::new(0.0, 1.0, -8.0, -5.5),
        SMatrix::<f64, 2, 1>::new(0.0, 1.0),
        SMatrix::identity() * q,
    )
}

fn not_finite(error: Error) -> bool {
    matches!(error.problem(), Problem::NotFinite { .. })
}

fn not_positive(error: Error) -> (&'static str, f64, &'static str) {
    match error.problem() {
        Problem::NotPositive { smallest, wanted, .. } => (error.parameter(), smallest, wanted),
        _ => panic!("{error}"),
    }
}

fn mode_on_axis(error: Error) -> (&'static str, f64) {
    match error.problem() {
        Problem::ModeOnAxis { frequency, .. } => (error.parameter(), frequency),
        _ => panic!("{error}"),
    }
}

#[test]
fn unstable_a_is_refused_by_bounded_real() {
    let (mut a, b, q) = paper(10.0);
    a[(1, 1)] = 0.5;
    let unstable =
        |e: Error| matches!(e.problem(), Problem::NotHurwitz { max_real, .. } if max_real > 0.0);
    let refused = |e: Error| e.parameter() == "a" && unstable(e);
    assert!(refused(bounded_real(&a, &b, &q, 1.0).unwrap_err()));
    assert!(refused(gamma_opt(&a, &b, &q).unwrap_err()));
}

#[test]
fn undamped_a_is_refused_by_bounded_real() {
    let (mut a, b, q) = paper(10.0);
    a[(1, 1)] = 0.0;
    let refusal = bounded_real(&a, &b, &q, 1.0).unwrap_err();
    assert!(matches!(refusal.problem(), Problem::NotHurwitz { .. }));
    assert_eq!(refusal.parameter(), "a");
}

#[test]
fn asymmetric_q_is_refused_with_its_worst_pair() {
    let (a, b, mut q) = paper(10.0);
    q[(0, 1)] = 0.5;
    let pair = |e: Error| match e.problem() {
        Problem::NotSymmetric { row, column, difference, .. } => {
            (e.parameter(), row, column, difference)
        }
        _ => panic!("{e}"),
    };
    let wanted = ("q", 0, 1, 0.5);
    assert_eq!(pair(bounded_real(&a, &b, &q, 1.0).unwrap_err()), wanted);
    assert_eq!(pair(gamma_opt(&a, &b, &q).unwrap_err()), wanted);
    assert_eq!(pair(care(&a, &b, &q, &SMatrix::identity()).unwrap_err()), wanted);
}

#[test]
fn indefinite_q_is_refused_with_its_smallest_eigenvalue() {
    let (a, b, mut q) = paper(10.0);
    q[(1, 1)] = -0.25;
    let wanted = ("q", -0.25, "positive semidefinite");
    assert_eq!(not_positive(bounded_real(&a, &b, &q, 1.0).unwrap_err()), wanted);
    assert_eq!(not_positive(gamma_opt(&a, &b, &q).unwrap_err()), wanted);
}

#[test]
fn asymmetric_r_is_refused() {
    let (a, _, q) = paper(10.0);
    let r = SMatrix::<f64, 2, 2>::new(1.0, 0.5, 0.0, 1.0);
    let refusal = care(&a, &SMatrix::<f64, 2, 2>::identity(), &q, &r).unwrap_err();
    assert!(matches!(refusal.problem(), Problem::NotSymmetric { .. }));
    assert_eq!(refusal.parameter(), "r");
}

#[test]
fn semidefinite_r_is_refused() {
    let (a, b, q) = paper(10.0);
    let refusal = care(&a, &b, &q, &SMatrix::zeros()).unwrap_err();
    assert_eq!(not_positive(refusal), ("r", 0.0, "positive definite"));
}

#[test]
fn gamma_that_is_not_positive_is_refused() {
    let (a, b, q) = paper(10.0);
    for gamma in [0.0, -1.0] {
        let out_of_range = |e: Error| matches!(e.problem(), Problem::OutOfRange { .. });
        let refused = |e: Error| e.parameter() == "gamma" && out_of_range(e);
        assert!(refused(bounded_real(&a, &b, &q, gamma).unwrap_err()));
        assert!(refused(joint(8.0, 5.5, 10.0, 10.0, gamma).unwrap_err()));
    }
    for gamma in [f64::NAN, f64::NEG_INFINITY] {
        let refused = |e: Error| e.parameter() == "gamma" && not_finite(e);
        assert!(refused(bounded_real(&a, &b, &q, gamma).unwrap_err()));
    }
}

#[test]
fn nan_and_infinity_are_refused_by_name() {
    for bad in [f64::NAN, f64::INFINITY] {
        let (a, b, q) = paper(10.0);
        let r = SMatrix::<f64, 1, 1>::new(1.0);
        let named = |e: Error, name| e.parameter() == name && not_finite(e);
        let broken = SMatrix::<f64, 2, 2>::new(0.0, 1.0, bad, -5.5);
        assert!(named(bounded_real(&broken, &b, &q, 1.0).unwrap_err(), "a"));
        assert!(named(care(&broken, &b, &q, &r).unwrap_err(), "a"));
        assert!(named(bounded_real(&a, &b, &broken, 1.0).unwrap_err(), "q"));
        assert!(named(care(&a, &b, &broken, &r).unwrap_err(), "q"));
        let broken = SMatrix::<f64, 2, 1>::new(bad, 1.0);
        assert!(named(bounded_real(&a, &broken, &q, 1.0).unwrap_err(), "b"));
        assert!(named(care(&a, &broken, &q, &r).unwrap_err(), "b"));
        assert!(named(care(&a, &b, &q, &SMatrix::<f64, 1, 1>::new(bad)).unwrap_err(), "r"));
    }
}

#[test]
fn input_that_misses_an_unstable_mode_is_refused() {
    let a = SMatrix::<f64, 2, 2>::new(1.0, 0.0, 0.0, -1.0);
    let b = SMatrix::<f64, 2, 1>::new(0.0, 1.0);
    let refusal = care(&a, &b, &SMatrix::identity(), &SMatrix::identity()).unwrap_err();
    assert_eq!((refusal.parameter(), refusal.problem()), ("b", Problem::NotStabilizable));
}

#[test]
fn no_input_stabilises_no_unstable_mode() {
    let b = SMatrix::<f64, 2, 1>::zeros();
    for a in [SMatrix::<f64, 2, 2>::new(0.0, 1.0, 0.0, 0.0), SMatrix::identity()] {
        let refusal = care(&a, &b, &SMatrix::identity(), &SMatrix::identity()).unwrap_err();
        assert_eq!((refusal.parameter(), refusal.problem()), ("b", Problem::NotStabilizable));
    }
}

#[test]
fn weight_that_misses_a_mode_on_the_axis_is_refused() {
    let oscillator = |omega: f64| SMatrix::<f64, 2, 2>::new(0.0, omega, -omega, 0.0);
    let integrators = SMatrix::<f64, 2, 2>::new(0.0, 1.0, 0.0, 0.0);
    let b = SMatrix::<f64, 2, 1>::new(0.0, 1.0);
    for (a, frequency) in [(integrators, 0.0), (oscillator(3.0), 3.0)] {
        let refusal = care(&a, &b, &SMatrix::zeros(), &SMatrix::identity()).unwrap_err();
        assert_eq!(mode_on_axis(refusal), ("q", frequency));
    }
}

#[test]
fn indefinite_weight_that_leaves_modes_on_the_axis_is_refused() {
    // p² + 2p + 2 = 0 has no real root: the Hamiltonian matrix [−1 −1; 2 1] has ±j.
    let one = SMatrix::<f64, 1, 1>::new(1.0);
    let refusal = care(&-one, &one, &(-2.0 * one), &one).unwrap_err();
    let (weight, frequency) = mode_on_axis(refusal);
    assert_eq!(weight, "q");
    assert!((frequency - 1.0).abs() < 1e-12);
}

#[test]
fn joint_names_the_gain_it_refuses() {
    let named = |e: Error, name| e.parameter() == name;
    assert!(named(joint(0.0, 5.5, 10.0, 10.0, 1.0).unwrap_err(), "kp"));
    assert!(named(joint(8.0, -1.0, 10.0, 10.0, 1.0).unwrap_err(), "kv"));
    assert!(named(joint(8.0, 5.5, -1.0, 10.0, 1.0).unwrap_err(), "q1"));
    assert!(named(joint(8.0, 5.5, 10.0, f64::NAN, 1.0).unwrap_err(), "q2"));
    assert!(named(joint_lqr(8.0, 5.5, 10.0, 10.0, 0.0).unwrap_err(), "r"));
    assert!(named(joint_gamma_opt(f64::INFINITY, 5.5, 10.0, 10.0).unwrap_err(), "kp"));
    assert!(named(joint_max_scale(8.0, 5.5, 10.0, 10.0, 0.0).unwrap_err(), "gamma"));
}

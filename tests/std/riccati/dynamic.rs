//! Riccati equations of a size known when running: solutions known by construction, any symmetric
//! Q.

use crate::random::Random;
use nalgebra::{DMatrix, SMatrix};
use steadyarm::riccati::dynamic::{MOST_STATES, bounded_real, care, gamma_opt};
use steadyarm::riccati::{self, RESIDUAL_LIMIT};
use steadyarm::{Error, Problem};

fn matrix(random: &mut Random, rows: usize, columns: usize) -> DMatrix<f64> {
    DMatrix::from_fn(rows, columns, |_, _| random.next())
}

fn symmetric(random: &mut Random, n: usize) -> DMatrix<f64> {
    let half = matrix(random, n, n);
    &half + half.transpose()
}

/// Hurwitz by Gershgorin's discs.
fn hurwitz(random: &mut Random, n: usize) -> DMatrix<f64> {
    let mut a = matrix(random, n, n);
    for i in 0..n {
        a[(i, i)] = -0.1 - a.row(i).abs().sum() * random.between(1.0, 1.5);
    }
    a
}

/// A, B, Q, R with the stabilising solution P: the closed loop C chosen first, then A = C + GP and
/// Q = PGP − AᵀP − PA.
fn constructed(random: &mut Random, n: usize) -> [DMatrix<f64>; 5] {
    let m = 1 + n / 2;
    let (b, p, c) = (matrix(random, n, m), symmetric(random, n), hurwitz(random, n));
    let y = matrix(random, m, m) + DMatrix::identity(m, m) * 2.0;
    let r = y.transpose() * y;
    let g = &b * r.clone().cholesky().unwrap().solve(&b.transpose());
    let a = c + &g * &p;
    let q = &p * g * &p - a.transpose() * &p - &p * &a;
    [a, b, (&q + q.transpose()) * 0.5, r, p]
}

#[test]
fn solution_known_by_construction_is_found_at_every_size() {
    let mut random = Random(41);
    for n in (1..=40).chain([100]) {
        let [a, b, q, r, p] = constructed(&mut random, n);
        let found = care(&a, &b, &q, &r).unwrap_or_else(|e| panic!("{n} states: {e}"));
        assert!((&found.p - &p).norm() < 1e-8 * p.norm(), "{n} states");
        assert!(found.residual <= RESIDUAL_LIMIT && found.max_real < 0.0, "{n} states");
        assert!(n == 1 || found.min_eigenvalue < 0.0, "{n} states");
    }
}

#[test]
fn same_bits_as_sizes_known_when_compiling() {
    let mut random = Random(42);
    let [a, b, q, r, _] = constructed(&mut random, 9);
    let at = |m: &DMatrix<f64>| SMatrix::<f64, 9, 9>::from_column_slice(m.as_slice());
    let b_static = SMatrix::<f64, 9, 5>::from_column_slice(b.as_slice());
    let r_static = SMatrix::<f64, 5, 5>::from_column_slice(r.as_slice());
    let expected = riccati::care(&at(&a), &b_static, &at(&q), &r_static).unwrap();
    assert_eq!(care(&a, &b, &q, &r).unwrap().p.as_slice(), expected.p.as_slice());
    let (a, q) = (hurwitz(&mut random, 9), DMatrix::identity(9, 9));
    let limit = gamma_opt(&a, &b, &q).unwrap();
    assert_eq!(riccati::gamma_opt(&at(&a), &b_static, &at(&q)).unwrap(), limit);
    let expected = riccati::bounded_real(&at(&a), &b_static, &at(&q), 2.0 * limit).unwrap();
    let found = bounded_real(&a, &b, &q, 2.0 * limit).unwrap();
    assert_eq!(found.p.as_slice(), expected.p.as_slice());
}

#[test]
fn limit_of_gamma_is_told_apart_beyond_sixteen_states() {
    let mut random = Random(43);
    for n in [17, 30, 60] {
        let (a, b) = (hurwitz(&mut random, n), matrix(&mut random, n, 3));
        let q = DMatrix::identity(n, n);
        let limit = gamma_opt(&a, &b, &q).unwrap();
        let found = bounded_real(&a, &b, &q, limit * (1.0 + 1e-8)).unwrap();
        assert!(found.residual <= RESIDUAL_LIMIT && found.max_real < 0.0);
        let refusal = bounded_real(&a, &b, &q, limit * (1.0 - 1e-8)).unwrap_err();
        assert!(matches!(refusal.problem(), Problem::NoStabilizingSolution { .. }), "{refusal}");
    }
}

#[test]
fn wrong_shapes_are_refused_by_name() {
    let square = |n: usize| DMatrix::<f64>::identity(n, n);
    let (a, b, q, r) = (-square(3), DMatrix::zeros(3, 2), square(3), square(2));
    let named = |e: Error, wanted: &str| {
        let of_size = matches!(e.problem(), Problem::WrongLength { .. } | Problem::TooMany { .. });
        of_size && e.parameter() == wanted
    };
    assert!(care(&a, &b, &q, &r).is_ok());
    assert!(named(care(&DMatrix::zeros(3, 2), &b, &q, &r).unwrap_err(), "a"));
    assert!(named(care(&DMatrix::zeros(0, 0), &b, &q, &r).unwrap_err(), "a"));
    assert!(named(care(&a, &square(2), &q, &r).unwrap_err(), "b"));
    assert!(named(care(&a, &DMatrix::zeros(3, 0), &q, &r).unwrap_err(), "b"));
    assert!(named(care(&a, &b, &square(2), &r).unwrap_err(), "q"));
    assert!(named(care(&a, &b, &q, &q).unwrap_err(), "r"));
    let large = -square(MOST_STATES + 1);
    let refusal = bounded_real(&large, &large, &square(MOST_STATES + 1), 1.0).unwrap_err();
    assert!(named(refusal, "a"));
}

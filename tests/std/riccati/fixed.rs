//! The Riccati equations: golden values, substitution over many systems, agreement with the closed
//! form.

use crate::random::Random;
use nalgebra::{DMatrix, DVector, SMatrix};
use steadyarm::Problem;
use steadyarm::eigen::max_real;
use steadyarm::riccati::{
    RESIDUAL_LIMIT, Solution, bounded_real, care, gamma_opt, joint, joint_gamma_opt, joint_lqr,
    joint_max_scale,
};

/// What every sane problem reaches relative to the terms themselves, which may be far below the
/// product of their norms.
const RESIDUAL: f64 = 1e-12;
/// The golden values are given to 13 digits.
const GOLDEN: f64 = 1e-12;

/// Systems to solve for.
trait Systems {
    fn stable<const S: usize>(&mut self) -> SMatrix<f64, S, S>;
    fn weight<const S: usize>(&mut self) -> SMatrix<f64, S, S>;
}

impl Systems for Random {
    /// Hurwitz, by a shift, with a margin of 0.03 to 3.
    fn stable<const S: usize>(&mut self) -> SMatrix<f64, S, S> {
        let a = self.matrix::<S, S>() * self.decades(-1.0, 1.0);
        let margin = self.decades(-1.5, 0.5);
        a - SMatrix::identity() * (max_real(&a).unwrap() + margin)
    }

    /// CᵀC with a C of full rank, or of rank 1.
    fn weight<const S: usize>(&mut self) -> SMatrix<f64, S, S> {
        let size = self.decades(-2.0, 2.0);
        if self.next() > 0.0 {
            let c = self.matrix::<S, S>();
            c.transpose() * c * size
        } else {
            let c = self.matrix::<1, S>();
            c.transpose() * c * size
        }
    }
}

/// Paper: K_p = 8, K_v = 5.5, one joint, Q = q I.
fn paper(q: f64) -> (SMatrix<f64, 2, 2>, SMatrix<f64, 2, 1>, SMatrix<f64, 2, 2>) {
    (
        SMatrix::<f64, 2, 2>::new(0.0, 1.0, -8.0, -5.5),
        SMatrix::<f64, 2, 1>::new(0.0, 1.0),
        SMatrix::identity() * q,
    )
}

fn close(got: f64, wanted: f64, tolerance: f64) {
    assert!((got - wanted).abs() <= tolerance * wanted.abs(), "got {got}, wanted {wanted}");
}

/// The equation again, written down independently of the crate: |left side| over the norms of its
/// terms.
fn substituted<const S: usize, const M: usize>(
    a: &SMatrix<f64, S, S>,
    f: &SMatrix<f64, S, M>,
    sign: f64,
    q: &SMatrix<f64, S, S>,
    p: &SMatrix<f64, S, S>,
) -> f64 {
    let pgp = (p * f) * (p * f).transpose() * sign;
    let left = a.transpose() * p + p * a + pgp + q;
    left.norm() / (2.0 * (p * a).norm() + pgp.norm() + q.norm())
}

fn check_solution<const S: usize, const M: usize>(
    solution: &Solution<S>,
    a: &SMatrix<f64, S, S>,
    (f, sign): (&SMatrix<f64, S, M>, f64),
    q: &SMatrix<f64, S, S>,
    what: &str,
) {
    let p = &solution.p;
    assert_eq!(*p, p.transpose(), "{what}");
    let residual = substituted(a, f, sign, q, p);
    assert!(residual < RESIDUAL, "{what}: residual {residual:e}");
    assert!(solution.residual < RESIDUAL, "{what}: residual {:e}", solution.residual);
    assert!(solution.min_eigenvalue > -1e-13 * p.norm(), "{what}");
    let abscissa = max_real(&(a + f * (p * f).transpose() * sign)).unwrap();
    assert!(abscissa < 0.0 && solution.max_real < 0.0, "{what}: {abscissa:e}");
}

#[test]
fn golden_values_of_the_paper_are_reproduced() {
    let (a, b, q) = paper(10.0);
    let general = bounded_real(&a, &b, &q, 1.0).unwrap();
    let closed = joint(8.0, 5.5, 10.0, 10.0, 1.0).unwrap();
    for (got, form) in [
        ([general.p[(0, 0)], general.p[(0, 1)], general.p[(1, 1)]], "general"),
        ([closed.p11, closed.p12, closed.p22], "closed"),
    ] {
        println!("{form}");
        close(got[0], 12.01352353475379, GOLDEN);
        close(got[1], 0.6515307716504657, GOLDEN);
        close(got[2], 1.147191888366882, GOLDEN);
    }
    close(general.max_real, -2.1764040558, 1e-10);
    close(closed.max_real(8.0, 5.5, 1.0), -2.1764040558, 1e-10);
    close(closed.min_eigenvalue(), general.min_eigenvalue, 1e-13);
    assert!(closed.residual(8.0, 5.5, 10.0, 10.0, 1.0) < 1e-15);
    close(gamma_opt(&a, &b, &q).unwrap(), 0.6143205381, 1e-10);
    close(joint_gamma_opt(8.0, 5.5, 10.0, 10.0).unwrap(), 0.6143205381, 1e-10);
    close(joint_max_scale(8.0, 5.5, 10.0, 10.0, 1.0).unwrap(), 2.64978068488, 1e-11);
}

#[test]
fn closed_loop_of_the_paper_has_the_golden_pair() {
    let (a, b, q) = paper(10.0);
    let p = bounded_real(&a, &b, &q, 1.0).unwrap().p;
    let pair = steadyarm::eigen::eigenvalues(&(a + b * b.transpose() * p)).unwrap();
    close(pair[0].re, -2.1764040558, 1e-10);
    close(pair[0].im.abs(), 1.6160862026, 1e-10);
}

#[test]
fn the_limit_of_q_is_told_apart_to_ten_digits() {
    let (a, b, q) = paper(26.49780684);
    bounded_real(&a, &b, &q, 1.0).unwrap();
    joint(8.0, 5.5, q[(0, 0)], q[(1, 1)], 1.0).unwrap();
    let (a, b, q) = paper(26.4978069);
    for refusal in [
        bounded_real(&a, &b, &q, 1.0).unwrap_err(),
        joint(8.0, 5.5, q[(0, 0)], q[(1, 1)], 1.0).unwrap_err(),
    ] {
        let Problem::NoStabilizingSolution { gamma, gamma_opt, max_scale, .. } = refusal.problem()
        else {
            panic!("{refusal}")
        };
        assert_eq!(gamma, 1.0);
        assert!(gamma_opt > 1.0 && max_scale < 1.0);
        close(max_scale * 26.4978069, 26.4978068488, 1e-10);
    }
}

fn substitute_bounded<const S: usize, const M: usize>(random: &mut Random, rounds: usize) {
    for round in 0..rounds {
        let (a, b, q) = (random.stable::<S>(), random.matrix::<S, M>(), random.weight::<S>());
        let limit = gamma_opt(&a, &b, &q).unwrap();
        let what =
            |ratio: f64| format!("{S} states, {M} inputs, round {round}, gamma/limit {ratio}");
        let far = random.decades(0.0, 4.0) + 0.001;
        for ratio in [1.0 + 1e-8, 1.0 + 1e-6, 1.01, 2.0, far, f64::INFINITY] {
            let gamma = limit * ratio;
            let solution =
                bounded_real(&a, &b, &q, gamma).unwrap_or_else(|e| panic!("{}: {e}", what(ratio)));
            check_solution(&solution, &a, (&(b / gamma), 1.0), &q, &what(ratio));
        }
        for ratio in [1.0 - 1e-8, 1.0 - 1e-5, 0.9, 0.1, 1e-4, 1e-12] {
            let refusal = bounded_real(&a, &b, &q, limit * ratio).expect_err(&what(ratio));
            let Problem::NoStabilizingSolution { gamma_opt, max_scale, .. } = refusal.problem()
            else {
                panic!("{}: {refusal}", what(ratio))
            };
            assert_eq!(gamma_opt, limit);
            close(max_scale, ratio * ratio, 1e-12);
        }
    }
}

#[test]
fn bounded_real_accepts_above_and_refuses_below_its_limit() {
    let mut random = Random(1);
    substitute_bounded::<2, 1>(&mut random, 150);
    substitute_bounded::<3, 1>(&mut random, 100);
    substitute_bounded::<4, 2>(&mut random, 100);
    substitute_bounded::<5, 2>(&mut random, 60);
    substitute_bounded::<6, 3>(&mut random, 60);
    substitute_bounded::<8, 4>(&mut random, 40);
    substitute_bounded::<10, 1>(&mut random, 30);
    substitute_bounded::<12, 6>(&mut random, 20);
    substitute_bounded::<14, 7>(&mut random, 20);
}

/// σ(ω) of a single input by another way: `[−A −ω; ω −A] [re; im] = [b; 0]`, then
/// `σ² = reᵀQ re + imᵀQ im`.
fn response<const S: usize>(
    a: &SMatrix<f64, S, S>,
    b: &SMatrix<f64, S, 1>,
    q: &SMatrix<f64, S, S>,
    omega: f64,
) -> f64 {
    let big = DMatrix::from_fn(2 * S, 2 * S, |i, j| match (i < S, j < S) {
        (true, true) => -a[(i, j)],
        (false, false) => -a[(i - S, j - S)],
        (true, false) => f64::from(i == j - S) * -omega,
        (false, true) => f64::from(i - S == j) * omega,
    });
    let right = DVector::from_fn(2 * S, |i, _| if i < S { b[i] } else { 0.0 });
    let x = big.lu().solve(&right).unwrap();
    let (re, im) = (x.rows(0, S).clone_owned(), x.rows(S, S).clone_owned());
    let q = DMatrix::from_fn(S, S, |i, j| q[(i, j)]);
    (re.dot(&(&q * &re)) + im.dot(&(&q * &im))).sqrt()
}

#[test]
fn no_frequency_exceeds_gamma_opt_and_one_reaches_it() {
    let mut random = Random(4);
    for _ in 0..100 {
        let (a, b, q) = (random.stable::<6>(), random.matrix::<6, 1>(), random.weight::<6>());
        let limit = gamma_opt(&a, &b, &q).unwrap();
        let mut most = response(&a, &b, &q, 0.0);
        let mut omega = 1e-3;
        while omega < 1e3 {
            most = most.max(response(&a, &b, &q, omega));
            omega *= 1.003;
        }
        assert!(most <= limit * (1.0 + 1e-10), "{most} {limit}");
        assert!(most >= limit * (1.0 - 5e-2), "{most} {limit}");
    }
}

#[test]
fn gamma_opt_finds_the_sharper_of_two_resonances() {
    // Two oscillators, damping ratios 1e-6 and 1e-4; peaks 1/(2 ζ ω²) = 500 000 and 5000 · 2.
    let mut a = SMatrix::<f64, 4, 4>::zeros();
    let mut b = SMatrix::<f64, 4, 1>::zeros();
    let mut q = SMatrix::<f64, 4, 4>::zeros();
    for (k, omega, damping) in [(0, 1.0, 1e-6), (2, 7.0, 1e-7)] {
        a[(k, k + 1)] = 1.0;
        a[(k + 1, k)] = -omega * omega;
        a[(k + 1, k + 1)] = -2.0 * damping * omega;
        b[k + 1] = 1.0;
        q[(k, k)] = omega * omega * omega * omega;
    }
    // Peak of ω₀²/(s² + 2ζω₀s + ω₀²): 1/(2ζ√(1 − ζ²)).
    let wanted = 1.0 / (2.0 * 1e-7 * (1.0_f64 - 1e-14).sqrt());
    close(gamma_opt(&a, &b, &q).unwrap(), wanted, 1e-8);
}

fn substitute_care<const S: usize, const M: usize>(random: &mut Random, rounds: usize) {
    for round in 0..rounds {
        let a = random.matrix::<S, S>() * random.decades(-1.0, 1.0);
        let b = random.matrix::<S, M>();
        let q = random.weight::<S>();
        let y = random.matrix::<M, M>() + SMatrix::identity() * 2.0;
        let r = y.transpose() * y * random.decades(-3.0, 3.0);
        let what = format!("{S} states, {M} inputs, round {round}");
        let solution = care(&a, &b, &q, &r).unwrap_or_else(|e| panic!("{what}: {e}"));
        let l = r.cholesky().unwrap().l();
        let f = l.solve_lower_triangular(&b.transpose()).unwrap().transpose();
        check_solution(&solution, &a, (&f, -1.0), &q, &what);
    }
}

#[test]
fn care_solves_its_equation_for_unstable_systems() {
    let mut random = Random(2);
    substitute_care::<2, 1>(&mut random, 300);
    substitute_care::<3, 2>(&mut random, 300);
    substitute_care::<4, 2>(&mut random, 300);
    substitute_care::<6, 3>(&mut random, 200);
    substitute_care::<8, 2>(&mut random, 100);
    substitute_care::<12, 6>(&mut random, 100);
    substitute_care::<14, 7>(&mut random, 100);
}

#[test]
fn care_of_the_double_integrator_is_the_textbook_one() {
    let a = SMatrix::<f64, 2, 2>::new(0.0, 1.0, 0.0, 0.0);
    let b = SMatrix::<f64, 2, 1>::new(0.0, 1.0);
    let p = care(&a, &b, &SMatrix::identity(), &SMatrix::identity()).unwrap().p;
    let root = 3.0_f64.sqrt();
    assert!((p - SMatrix::<f64, 2, 2>::new(root, 1.0, 1.0, root)).amax() < 1e-14);
}

#[test]
fn closed_form_equals_the_general_solver() {
    let mut random = Random(3);
    for round in 0..2000 {
        let (kp, kv) = (random.decades(-2.0, 4.0), random.decades(-2.0, 3.0));
        let (q1, q2) = (random.decades(-3.0, 3.0), random.decades(-3.0, 3.0));
        let limit = joint_gamma_opt(kp, kv, q1, q2).unwrap();
        let a = SMatrix::<f64, 2, 2>::new(0.0, 1.0, -kp, -kv);
        let b = SMatrix::<f64, 2, 1>::new(0.0, 1.0);
        let q = SMatrix::<f64, 2, 2>::new(q1, 0.0, 0.0, q2);
        close(gamma_opt(&a, &b, &q).unwrap(), limit, 1e-10);
        let near = if round % 3 == 0 { 1.0 + 1e-8 } else { 1.0 + random.decades(-4.0, 2.0) };
        let gamma = limit * near;
        let closed = joint(kp, kv, q1, q2, gamma).unwrap();
        let general = bounded_real(&a, &b, &q, gamma).unwrap();
        // At the limit two solutions meet: P is good to the root of the rounding, relative to its
        // distance from the limit.
        let tolerance = 1e-10 / (near - 1.0).min(1.0).sqrt();
        close(general.p[(0, 0)], closed.p11, tolerance);
        close(general.p[(1, 1)], closed.p22, tolerance);
        assert!(
            (general.p[(0, 1)] - closed.p12).abs() < tolerance * (closed.p11 * closed.p22).sqrt()
        );
        let g = 1.0 / (gamma * gamma);
        assert!(closed.residual(kp, kv, q1, q2, g) < RESIDUAL_LIMIT);
        assert!(closed.min_eigenvalue() > 0.0 && closed.max_real(kp, kv, g) < 0.0);
        assert!(joint(kp, kv, q1, q2, limit * (1.0 - 1e-8)).is_err());
        assert!(bounded_real(&a, &b, &q, limit * (1.0 - 1e-8)).is_err());
    }
}

#[test]
fn closed_form_of_the_lqr_sign_equals_the_general_solver() {
    let mut random = Random(8);
    for _ in 0..500 {
        let (kp, kv) = (random.decades(-2.0, 3.0), random.decades(-2.0, 2.0));
        let (q1, q2, r) =
            (random.decades(-2.0, 3.0), random.decades(-2.0, 3.0), random.decades(-3.0, 3.0));
        let a = SMatrix::<f64, 2, 2>::new(0.0, 1.0, -kp, -kv);
        let b = SMatrix::<f64, 2, 1>::new(0.0, 1.0);
        let q = SMatrix::<f64, 2, 2>::new(q1, 0.0, 0.0, q2);
        let general = care(&a, &b, &q, &SMatrix::<f64, 1, 1>::new(r)).unwrap();
        let closed = joint_lqr(kp, kv, q1, q2, r).unwrap();
        close(general.p[(0, 0)], closed.p11, 1e-9);
        close(general.p[(1, 1)], closed.p22, 1e-9);
        close(closed.max_real(kp, kv, -1.0 / r), general.max_real, 1e-6);
        assert!(closed.residual(kp, kv, q1, q2, -1.0 / r) < RESIDUAL);
    }
}

#[test]
fn infinite_gamma_gives_the_lyapunov_equation() {
    let (a, b, q) = paper(10.0);
    let p = bounded_real(&a, &b, &q, f64::INFINITY).unwrap().p;
    assert!((a.transpose() * p + p * a + q).amax() < 1e-13);
    let closed = joint(8.0, 5.5, 10.0, 10.0, f64::INFINITY).unwrap();
    close(p[(0, 0)], closed.p11, 1e-14);
}

#[test]
fn zero_q_has_the_zero_solution_and_a_zero_limit() {
    let (a, b, q) = paper(0.0);
    assert_eq!(gamma_opt(&a, &b, &q).unwrap(), 0.0);
    assert_eq!(joint_gamma_opt(8.0, 5.5, 0.0, 0.0).unwrap(), 0.0);
    let solution = bounded_real(&a, &b, &q, 1e-3).unwrap();
    assert_eq!(solution.p, SMatrix::<f64, 2, 2>::zeros());
    assert_eq!((solution.residual, solution.min_eigenvalue), (0.0, 0.0));
}

#[test]
fn zero_input_is_the_lyapunov_equation_at_every_gamma() {
    let (a, _, q) = paper(10.0);
    let b = SMatrix::<f64, 2, 1>::zeros();
    assert_eq!(gamma_opt(&a, &b, &q).unwrap(), 0.0);
    assert!(bounded_real(&a, &b, &q, 1e-6).unwrap().residual < RESIDUAL);
}

#[test]
fn invisible_modes_give_a_semidefinite_solution() {
    let (a, b, _) = paper(0.0);
    let blind =
        SMatrix::<f64, 4, 4>::from_fn(|i, j| if i / 2 == j / 2 { a[(i % 2, j % 2)] } else { 0.0 });
    let b = SMatrix::<f64, 4, 1>::from_fn(|i, _| b[i % 2]);
    let q = SMatrix::<f64, 4, 4>::from_fn(|i, j| if i == j && i < 2 { 10.0 } else { 0.0 });
    let solution = bounded_real(&blind, &b, &q, 1.0).unwrap();
    assert!(solution.min_eigenvalue.abs() < 1e-15 && solution.max_real < 0.0);
}

#[test]
fn units_do_not_matter() {
    // x → T x with T from 1e-6 to 1e6, time and Q in other units.
    let mut random = Random(12);
    for round in 0..200 {
        let (a, b, q) = (random.stable::<6>(), random.matrix::<6, 2>(), random.weight::<6>());
        let t = SMatrix::<f64, 6, 1>::from_fn(|_, _| random.decades(-6.0, 6.0));
        let (time, size) = (random.decades(-9.0, 9.0), random.decades(-20.0, 20.0));
        let limit = gamma_opt(&a, &b, &q).unwrap();
        let a = SMatrix::<f64, 6, 6>::from_fn(|i, j| a[(i, j)] * t[i] / t[j] * time);
        let b = SMatrix::<f64, 6, 2>::from_fn(|i, j| b[(i, j)] * t[i] * time);
        let q = SMatrix::<f64, 6, 6>::from_fn(|i, j| q[(i, j)] / t[i] / t[j] * size);
        let q = (q + q.transpose()) * 0.5;
        let limit = limit * size.sqrt();
        close(gamma_opt(&a, &b, &q).unwrap(), limit, 1e-9);
        for ratio in [1.0 + 1e-8, 1.1, 10.0] {
            let solution = bounded_real(&a, &b, &q, limit * ratio);
            let solution = solution.unwrap_or_else(|e| panic!("round {round}, {ratio}: {e}"));
            assert!(solution.residual < RESIDUAL_LIMIT);
        }
        assert!(bounded_real(&a, &b, &q, limit * (1.0 - 1e-8)).is_err());
    }
}

#[test]
fn same_input_same_bits() {
    let mut random = Random(20);
    let (a, b, q) = (random.stable::<14>(), random.matrix::<14, 7>(), random.weight::<14>());
    let first = bounded_real(&a, &b, &q, 1e3).unwrap();
    assert_eq!(first, bounded_real(&a, &b, &q, 1e3).unwrap());
}

#[test]
fn bits_are_the_same_on_every_machine() {
    let mut random = Random(14);
    let (a, b, q) =
        (random.matrix::<14, 14>(), random.matrix::<14, 7>(), SMatrix::<f64, 14, 14>::identity());
    let stable = a - SMatrix::identity() * 5.0;
    let limit = gamma_opt(&stable, &b, &q).unwrap();
    let bounded = bounded_real(&stable, &b, &q, 1.01 * limit).unwrap();
    let regulator = care(&a, &b, &q, &SMatrix::identity()).unwrap();
    // FNV-1a over the bits.
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    for x in bounded.p.iter().chain(regulator.p.iter()).chain([&bounded.max_real, &limit]) {
        hash = (hash ^ x.to_bits()).wrapping_mul(0x100_0000_01b3);
    }
    assert_eq!(hash, 0x5724_0b13_63ef_401e, "{hash:#x}");
}

//! Eigenvalues against spectra that are known by construction.

use crate::random::Random;
use nalgebra::SMatrix;
use steadyarm::eigen::{
    Complex, eigenvalues, max_real, spectral_radius, symmetric_eigenvalues, symmetric_min,
};
use steadyarm::{Error, Problem};

/// Largest distance of a found eigenvalue from the nearest wanted one, each wanted one used once.
fn mismatch(found: &[Complex], wanted: &[Complex]) -> f64 {
    let mut left = wanted.to_vec();
    let mut worst = 0.0_f64;
    for z in found {
        let distance = |w: &Complex| (z.re - w.re).hypot(z.im - w.im);
        let (i, _) =
            left.iter().enumerate().min_by(|a, b| distance(a.1).total_cmp(&distance(b.1))).unwrap();
        worst = worst.max(distance(&left.swap_remove(i)));
    }
    worst
}

fn real(values: &[f64]) -> Vec<Complex> {
    values.iter().map(|&x| Complex::new(x, 0.0)).collect()
}

#[test]
fn companion_matrix_has_the_roots_of_its_polynomial() {
    // (s−1)(s−2)(s−3)(s²+1) = s⁵ − 6s⁴ + 12s³ − 12s² + 11s − 6
    let c = [-6.0, 11.0, -12.0, 12.0, -6.0];
    let a =
        SMatrix::<f64, 5, 5>::from_fn(
            |i, j| {
                if i == 4 { -c[j] } else { f64::from(u8::from(j == i + 1)) }
            },
        );
    let mut wanted = real(&[1.0, 2.0, 3.0]);
    wanted.extend([Complex::new(0.0, 1.0), Complex::new(0.0, -1.0)]);
    assert!(mismatch(&eigenvalues(&a).unwrap(), &wanted) < 1e-12);
    assert!((max_real(&a).unwrap() - 3.0).abs() < 1e-12);
    assert!((spectral_radius(&a).unwrap() - 3.0).abs() < 1e-12);
}

#[test]
fn cyclic_permutation_has_the_roots_of_unity() {
    // The classic matrix on which QR without an exceptional shift never ends.
    let a = SMatrix::<f64, 12, 12>::from_fn(|i, j| f64::from(u8::from(i == (j + 1) % 12)));
    let wanted: Vec<Complex> = (0..12)
        .map(|k| {
            let angle = f64::from(k) * std::f64::consts::PI / 6.0;
            Complex::new(angle.cos(), angle.sin())
        })
        .collect();
    assert!(mismatch(&eigenvalues(&a).unwrap(), &wanted) < 1e-13);
}

#[test]
fn defective_matrix_is_good_to_the_root_of_the_rounding() {
    let a = SMatrix::<f64, 4, 4>::from_fn(|i, j| match (i, j) {
        (i, j) if i == j => -2.0,
        (i, j) if j == i + 1 => 1.0,
        _ => 0.0,
    });
    let mut random = Random(3);
    let t = random.matrix::<4, 4>() + SMatrix::identity() * 2.0;
    let a = t * a * t.try_inverse().unwrap();
    assert!(mismatch(&eigenvalues(&a).unwrap(), &real(&[-2.0; 4])) < 1e-3);
}

fn known_spectrum<const S: usize>(random: &mut Random) {
    let mut block = SMatrix::<f64, S, S>::zeros();
    let mut wanted = Vec::new();
    let mut i = 0;
    while i < S {
        let (re, im) = (random.next() * 5.0, random.next() * 5.0);
        block[(i, i)] = re;
        if i + 1 < S && random.next() > 0.0 {
            block[(i + 1, i + 1)] = re;
            block[(i, i + 1)] = im;
            block[(i + 1, i)] = -im;
            wanted.extend([Complex::new(re, im), Complex::new(re, -im)]);
            i += 1;
        } else {
            wanted.push(Complex::new(re, 0.0));
        }
        i += 1;
    }
    let t = random.matrix::<S, S>() + SMatrix::identity() * 3.0;
    let a = t * block * t.try_inverse().unwrap();
    let error = mismatch(&eigenvalues(&a).unwrap(), &wanted);
    assert!(error < 1e-9, "{S} states: {error:e}");
}

#[test]
fn similarity_transforms_keep_the_spectrum() {
    let mut random = Random(1);
    for _ in 0..100 {
        known_spectrum::<1>(&mut random);
        known_spectrum::<2>(&mut random);
        known_spectrum::<3>(&mut random);
        known_spectrum::<4>(&mut random);
        known_spectrum::<7>(&mut random);
        known_spectrum::<10>(&mut random);
        known_spectrum::<14>(&mut random);
        known_spectrum::<16>(&mut random);
    }
}

#[test]
fn badly_scaled_matrix_is_balanced_first() {
    let mut random = Random(5);
    let a = random.matrix::<6, 6>();
    let wanted = eigenvalues(&a).unwrap();
    let scaled =
        SMatrix::<f64, 6, 6>::from_fn(|i, j| a[(i, j)] * 2f64.powi(12 * (i as i32 - j as i32)));
    assert!(mismatch(&eigenvalues(&scaled).unwrap(), &wanted) < 1e-11);
}

#[test]
fn eigenvalues_scale_with_the_matrix_up_to_the_ends_of_the_range() {
    let mut random = Random(6);
    let a = random.matrix::<5, 5>();
    let wanted = eigenvalues(&a).unwrap();
    for exponent in [-1000, -500, 500, 1000] {
        let factor = 2f64.powi(exponent);
        let found = eigenvalues(&(a * factor)).unwrap().map(|z| z / factor);
        assert_eq!(found, wanted);
    }
}

#[test]
fn zero_matrix_has_zero_eigenvalues() {
    let zero = SMatrix::<f64, 6, 6>::zeros();
    assert_eq!(eigenvalues(&zero).unwrap(), [Complex::new(0.0, 0.0); 6]);
    assert_eq!(symmetric_eigenvalues(&zero).unwrap(), [0.0; 6]);
}

#[test]
fn random_matrices_always_converge_and_keep_their_trace() {
    let mut random = Random(9);
    for round in 0..3000 {
        let mut a = random.matrix::<9, 9>();
        if round % 3 == 0 {
            a.apply(|x| *x = x.powi(round % 13));
        }
        if round % 5 == 0 {
            a.apply(|x| *x = if x.abs() < 0.6 { 0.0 } else { *x });
        }
        let sum: f64 = eigenvalues(&a).unwrap().iter().map(|z| z.re).sum();
        assert!((sum - a.trace()).abs() < 1e-12 * (1.0 + a.norm()));
    }
}

#[test]
fn nan_and_infinity_are_refused() {
    for bad in [f64::NAN, f64::INFINITY] {
        let mut a = SMatrix::<f64, 3, 3>::identity();
        a[(2, 1)] = bad;
        let not_finite = |e: Error| matches!(e.problem(), Problem::NotFinite { .. });
        let refused = |e: Error| (e.parameter(), e.index()) == ("a", Some(5)) && not_finite(e);
        assert!(refused(eigenvalues(&a).unwrap_err()));
        assert!(refused(symmetric_eigenvalues(&a).unwrap_err()));
    }
}

fn symmetric_spectrum<const S: usize>(random: &mut Random) {
    let mut wanted: [f64; S] = std::array::from_fn(|_| random.next() * 10.0);
    let mut a = SMatrix::<f64, S, S>::from_fn(|i, j| if i == j { wanted[i] } else { 0.0 });
    for _ in 0..S {
        let v = random.matrix::<S, 1>().normalize();
        let reflector = SMatrix::<f64, S, S>::identity() - v * v.transpose() * 2.0;
        a = reflector * a * reflector;
    }
    let mut found = symmetric_eigenvalues(&a).unwrap();
    assert_eq!(symmetric_min(&a).unwrap(), found.iter().copied().fold(f64::INFINITY, f64::min));
    found.sort_by(f64::total_cmp);
    wanted.sort_by(f64::total_cmp);
    for (x, y) in found.iter().zip(wanted) {
        assert!((x - y).abs() < 1e-12, "{S}: {x} {y}");
    }
}

#[test]
fn symmetric_eigenvalues_survive_reflections() {
    let mut random = Random(2);
    for _ in 0..200 {
        symmetric_spectrum::<1>(&mut random);
        symmetric_spectrum::<2>(&mut random);
        symmetric_spectrum::<3>(&mut random);
        symmetric_spectrum::<6>(&mut random);
        symmetric_spectrum::<14>(&mut random);
    }
}

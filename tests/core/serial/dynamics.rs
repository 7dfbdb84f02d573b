//! The identities of rigid-body dynamics on 1000 random chains.

use steadyarm::arm::{Arm, Serial};
use steadyarm::math::{Matrix, Vector};

use crate::chains::{self, on_chains};
use crate::random::Random;

/// Rounding of some hundred operations, relative to the largest entry.
const ROUNDING: f64 = 1e-12;
/// The same, through a mass matrix whose condition number reaches 1e5.
const SOLVED: f64 = 1e-9;
/// Fourth-order differences with a step of 2e-3: truncation and rounding about 1e-11 of the largest
/// entry.
const DIFFERENCE: f64 = 1e-8;

fn close<const R: usize, const C: usize>(
    got: &nalgebra::SMatrix<f64, R, C>,
    wanted: &nalgebra::SMatrix<f64, R, C>,
    tolerance: f64,
) {
    let size = 1.0 + wanted.amax();
    let off = (got - wanted).amax() / size;
    assert!(off < tolerance, "{off:e}: got {got} wanted {wanted}");
}

on_chains!(mass_matrix_gravity_and_potential_energy_are_lagranges);
on_chains!(coriolis_is_christoffels);
on_chains!(coriolis_and_gravity_follow_from_the_bias);
on_chains!(mass_matrix_is_symmetric_positive_definite);
on_chains!(mass_matrix_has_the_columns_of_inverse_dynamics);
on_chains!(forward_dynamics_inverts_inverse_dynamics);
on_chains!(coriolis_and_its_transpose_add_to_the_rate_of_the_mass_matrix);
on_chains!(bias_is_coriolis_plus_gravity_plus_friction);
on_chains!(regressor_times_parameters_is_inverse_dynamics);
on_chains!(slotine_li_is_its_three_terms);
on_chains!(gravity_is_the_slope_of_potential_energy);
on_chains!(poses_are_those_of_rodrigues);
on_chains!(jacobian_is_the_slope_of_the_pose);
on_chains!(friction_never_drives);

/// Chains longer than those above.
fn on_long_chains<const N: usize>(holds: fn(&Serial<N>, &mut Random)) {
    for seed in 0..50 {
        let mut random = Random(seed);
        let arm = chains::chain::<N>(&mut random);
        holds(&arm, &mut random);
    }
}

/// Too long for one lane a joint: their wrenches walk in groups.
#[test]
fn mass_matrix_of_long_chains_has_the_columns_of_inverse_dynamics() {
    on_long_chains::<9>(of::mass_matrix_has_the_columns_of_inverse_dynamics);
    on_long_chains::<13>(of::mass_matrix_has_the_columns_of_inverse_dynamics);
    on_long_chains::<16>(of::mass_matrix_has_the_columns_of_inverse_dynamics);
    on_long_chains::<17>(of::mass_matrix_has_the_columns_of_inverse_dynamics);
    on_long_chains::<25>(of::mass_matrix_has_the_columns_of_inverse_dynamics);
}

/// The last ones are too long for factors of M: articulated bodies.
#[test]
fn forward_dynamics_of_long_chains_inverts_inverse_dynamics() {
    on_long_chains::<10>(of::forward_dynamics_inverts_inverse_dynamics);
    on_long_chains::<11>(of::forward_dynamics_inverts_inverse_dynamics);
    on_long_chains::<14>(of::forward_dynamics_inverts_inverse_dynamics);
}

mod of {
    use super::*;
    use crate::chains::vector;
    use crate::random::Random;

    pub fn mass_matrix_gravity_and_potential_energy_are_lagranges<const N: usize>(
        arm: &Serial<N>,
        random: &mut Random,
    ) {
        let q = vector(random, 3.0);
        let (mass, gravity, energy) = chains::lagrange(arm, &q);
        close(&arm.mass_matrix(&q), &mass, ROUNDING);
        close(&arm.gravity(&q), &gravity, ROUNDING);
        let off = (arm.potential_energy(&q) - energy).abs();
        assert!(off < ROUNDING * (100.0 + energy.abs()), "{off:e}");
    }

    pub fn coriolis_is_christoffels<const N: usize>(arm: &Serial<N>, random: &mut Random) {
        let (q, dq) = (vector(random, 3.0), vector(random, 2.0));
        close(&arm.coriolis(&q, &dq), &chains::christoffel(arm, &q, &dq).0, DIFFERENCE);
    }

    /// The same chain with nothing overridden.
    struct Bare<'a, const N: usize>(&'a Serial<N>);

    impl<const N: usize> Arm<N> for Bare<'_, N> {
        fn mass_matrix(&self, q: &Vector<N>) -> Matrix<N> {
            self.0.mass_matrix(q)
        }
        fn rigid_bias(&self, q: &Vector<N>, dq: &Vector<N>) -> Vector<N> {
            self.0.rigid_bias(q, dq)
        }
    }

    /// M and C q̇ + G say all the rest: C is the same matrix, not only the same product with q̇.
    pub fn coriolis_and_gravity_follow_from_the_bias<const N: usize>(
        arm: &Serial<N>,
        random: &mut Random,
    ) {
        let (q, dq) = (vector(random, 3.0), vector(random, 2.0));
        let bare = Bare(arm);
        close(&bare.coriolis(&q, &dq), &arm.coriolis(&q, &dq), 10.0 * ROUNDING);
        close(&bare.gravity(&q), &arm.gravity(&q), ROUNDING);
        let moving = arm.bias(&q, &dq) - arm.friction(&dq);
        close(&(bare.coriolis(&q, &dq) * dq + bare.gravity(&q)), &moving, 10.0 * ROUNDING);
    }

    pub fn mass_matrix_is_symmetric_positive_definite<const N: usize>(
        arm: &Serial<N>,
        random: &mut Random,
    ) {
        let q: Vector<N> = vector(random, 3.0);
        let dq: Vector<N> = vector(random, 2.0);
        let mass = arm.mass_matrix(&q);
        assert_eq!(mass, mass.transpose());
        assert!(mass.cholesky().is_some(), "{mass}");
        let energy = 0.5 * dq.dot(&(mass * dq));
        assert!((arm.kinetic_energy(&q, &dq) - energy).abs() <= ROUNDING * energy);
    }

    pub fn mass_matrix_has_the_columns_of_inverse_dynamics<const N: usize>(
        arm: &Serial<N>,
        random: &mut Random,
    ) {
        let q = vector(random, 3.0);
        let rest = Vector::<N>::zeros();
        let at_rest = arm.inverse_dynamics(&q, &rest, &rest);
        let columns = Matrix::<N>::identity();
        let columns = Matrix::<N>::from_fn(|i, j| {
            let unit: Vector<N> = columns.column(j).into();
            (arm.inverse_dynamics(&q, &rest, &unit) - at_rest)[i]
        });
        // The difference loses what gravity is larger than the inertia.
        close(&arm.mass_matrix(&q), &columns, 100.0 * ROUNDING);
    }

    pub fn forward_dynamics_inverts_inverse_dynamics<const N: usize>(
        arm: &Serial<N>,
        random: &mut Random,
    ) {
        let (q, dq, ddq) = (vector(random, 3.0), vector(random, 2.0), vector(random, 10.0));
        let tau = arm.inverse_dynamics(&q, &dq, &ddq);
        close(&arm.forward_dynamics(&q, &dq, &tau), &ddq, SOLVED);
        let pushed: Vector<N> = vector(random, 20.0);
        let ddq = arm.forward_dynamics(&q, &dq, &pushed);
        close(&arm.inverse_dynamics(&q, &dq, &ddq), &pushed, SOLVED);
    }

    pub fn coriolis_and_its_transpose_add_to_the_rate_of_the_mass_matrix<const N: usize>(
        arm: &Serial<N>,
        random: &mut Random,
    ) {
        let (q, dq) = (vector(random, 3.0), vector(random, 2.0));
        let h = 2e-3;
        let at = |steps: f64| arm.mass_matrix(&(q + dq * (steps * h)));
        let rate = ((at(1.0) - at(-1.0)) * 8.0 - (at(2.0) - at(-2.0))) / (12.0 * h);
        let c = arm.coriolis(&q, &dq);
        close(&(c + c.transpose()), &rate, DIFFERENCE);
    }

    pub fn bias_is_coriolis_plus_gravity_plus_friction<const N: usize>(
        arm: &Serial<N>,
        random: &mut Random,
    ) {
        let (q, dq, ddq) = (vector(random, 3.0), vector(random, 2.0), vector(random, 10.0));
        let rigid = arm.coriolis(&q, &dq) * dq + arm.gravity(&q);
        close(&arm.without_friction().bias(&q, &dq), &rigid, ROUNDING);
        close(&arm.bias(&q, &dq), &(rigid + arm.friction(&dq)), ROUNDING);
        let (mass, bias) = arm.mass_matrix_and_bias(&q, &dq);
        assert_eq!((mass, bias), (arm.mass_matrix(&q), arm.bias(&q, &dq)));
        close(&arm.inverse_dynamics(&q, &dq, &ddq), &(mass * ddq + bias), ROUNDING);
        let friction = arm.inverse_dynamics(&q, &dq, &ddq)
            - arm.without_friction().inverse_dynamics(&q, &dq, &ddq);
        // Of torques a hundred times as large.
        close(&friction, &arm.friction(&dq), 100.0 * ROUNDING);
    }

    pub fn regressor_times_parameters_is_inverse_dynamics<const N: usize>(
        arm: &Serial<N>,
        random: &mut Random,
    ) {
        let (q, dq, ddq) = (vector(random, 3.0), vector(random, 2.0), vector(random, 10.0));
        let (mut y, mut pi) = (vec![f64::NAN; 10 * N * N], vec![f64::NAN; 10 * N]);
        arm.regressor(&q, &dq, &ddq, &mut y).unwrap();
        arm.inertial_parameters(&mut pi).unwrap();
        let product = Vector::<N>::from_fn(|i, _| {
            y[10 * N * i..][..10 * N].iter().zip(&pi).map(|(a, b)| a * b).sum()
        });
        let armature = Vector::<N>::from_fn(|i, _| arm.links()[i].armature * ddq[i]);
        let rigid = arm.without_friction().inverse_dynamics(&q, &dq, &ddq) - armature;
        close(&product, &rigid, ROUNDING);
    }

    pub fn slotine_li_is_its_three_terms<const N: usize>(arm: &Serial<N>, random: &mut Random) {
        let (q, dq) = (vector(random, 3.0), vector(random, 2.0));
        let (dq_r, ddq_r) = (vector(random, 2.0), vector(random, 10.0));
        let terms = arm.mass_matrix(&q) * ddq_r + arm.coriolis(&q, &dq) * dq_r + arm.gravity(&q);
        close(&arm.slotine_li(&q, &dq, &dq_r, &ddq_r), &terms, ROUNDING);
        let same = arm.without_friction().inverse_dynamics(&q, &dq, &ddq_r);
        close(&arm.slotine_li(&q, &dq, &dq, &ddq_r), &same, ROUNDING);
    }

    pub fn gravity_is_the_slope_of_potential_energy<const N: usize>(
        arm: &Serial<N>,
        random: &mut Random,
    ) {
        let q: Vector<N> = vector(random, 3.0);
        let h = 2e-3;
        let slope = Vector::<N>::from_fn(|i, _| {
            let at = |steps: f64| {
                let mut moved = q;
                moved[i] += steps * h;
                arm.potential_energy(&moved)
            };
            ((at(1.0) - at(-1.0)) * 8.0 - (at(2.0) - at(-2.0))) / (12.0 * h)
        });
        close(&arm.gravity(&q), &slope, DIFFERENCE);
    }

    pub fn poses_are_those_of_rodrigues<const N: usize>(arm: &Serial<N>, random: &mut Random) {
        let q = vector(random, 3.0);
        let wanted = chains::poses(arm, &q);
        for (got, wanted) in arm.link_poses(&q).iter().zip(&wanted) {
            close(&got.rotation, &wanted.rotation, ROUNDING);
            close(&got.translation, &wanted.translation, ROUNDING);
        }
        let (tip, wanted) = (arm.pose(&q), wanted[N - 1].then(&arm.parameters().tip));
        close(&tip.rotation, &wanted.rotation, ROUNDING);
        close(&tip.translation, &wanted.translation, ROUNDING);
    }

    pub fn jacobian_is_the_slope_of_the_pose<const N: usize>(arm: &Serial<N>, random: &mut Random) {
        let q: Vector<N> = vector(random, 3.0);
        let h = 2e-3;
        let jacobian = arm.jacobian(&q);
        for j in 0..N {
            let at = |steps: f64| {
                let mut moved = q;
                moved[j] += steps * h;
                arm.pose(&moved)
            };
            let [a, b, c, d] = [1.0, -1.0, 2.0, -2.0].map(at);
            let linear = (a.translation - b.translation) * 8.0 - (c.translation - d.translation);
            let turning = (a.rotation - b.rotation) * 8.0 - (c.rotation - d.rotation);
            // Ṙ Rᵀ = [ω]ₓ
            let spin = turning * at(0.0).rotation.transpose() / (12.0 * h);
            let angular = nalgebra::Vector3::new(spin[(2, 1)], spin[(0, 2)], spin[(1, 0)]);
            let column = jacobian.column(j);
            close(&column.fixed_rows::<3>(0).into(), &(linear / (12.0 * h)), DIFFERENCE);
            close(&column.fixed_rows::<3>(3).into(), &angular, DIFFERENCE);
        }
    }

    pub fn friction_never_drives<const N: usize>(arm: &Serial<N>, random: &mut Random) {
        for size in [1e-6, 0.1, 1.0, 100.0] {
            let dq: Vector<N> = vector(random, size);
            let friction = arm.friction(&dq);
            assert!(friction.component_mul(&dq).min() >= 0.0, "{friction} {dq}");
        }
        assert_eq!(arm.friction(&Vector::zeros()), Vector::<N>::zeros());
        let one: Vector<N> = Vector::repeat(0.2);
        let friction = arm.friction(&one);
        for (f, link) in friction.iter().zip(arm.links()) {
            let of = &link.friction;
            let dry = of.coulomb[0] + of.stribeck * (-(0.2 / of.stribeck_speed).powi(2)).exp();
            let wanted = of.viscous * 0.2 + dry * (0.2 / of.smoothing).tanh();
            assert!((f - wanted).abs() < ROUNDING);
        }
        let back = arm.friction(&-one);
        for (f, link) in back.iter().zip(arm.links()) {
            let of = &link.friction;
            let dry = of.coulomb[1] + of.stribeck * (-(0.2 / of.stribeck_speed).powi(2)).exp();
            let wanted = of.viscous * 0.2 + dry * (0.2 / of.smoothing).tanh();
            assert!((f + wanted).abs() < ROUNDING);
        }
    }
}

//! Dynamics of an arm: the identities every rigid-body model obeys, the paper's numbers, and the
//! refusals.

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use steadyarm::arm::{Arm, Friction, TwoLink, TwoLinkParameters};
use steadyarm::math::{Matrix, Vector};
use steadyarm::{Error, Problem};

/// Rounding of a dozen operations on numbers of size 1 to 1000.
const ROUNDING: f64 = 1e-12;
/// Central differences with a step of 1e-5: truncation ~1e-10, rounding ~1e-11, relative to the
/// size of the derivative.
const DIFFERENCE: f64 = 1e-7;
const STEP: f64 = 1e-5;

fn config() -> ProptestConfig {
    ProptestConfig {
        cases: 400,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(20_170_104),
        ..ProptestConfig::default()
    }
}

fn vector(size: f64) -> impl Strategy<Value = Vector<2>> {
    prop::array::uniform2(-size..size).prop_map(Vector::<2>::from)
}

fn pair(low: f64, high: f64) -> impl Strategy<Value = [f64; 2]> {
    prop::array::uniform2(low..high)
}

fn arm() -> impl Strategy<Value = TwoLink> {
    let friction = (pair(0.0, 3.0), pair(0.0, 3.0), pair(0.01, 1.0))
        .prop_map(|(viscous, coulomb, smoothing)| Friction { viscous, coulomb, smoothing });
    (pair(0.1, 20.0), pair(0.1, 2.0), pair(0.01, 2.0), -10.0..10.0, friction).prop_map(
        |(mass, length, inertia, gravity, friction)| {
            TwoLink::new(TwoLinkParameters { mass, length, inertia, gravity, friction }).unwrap()
        },
    )
}

/// The same arm with nothing overridden.
struct Plain(TwoLink);

impl Arm<2> for Plain {
    fn mass_matrix(&self, q: &Vector<2>) -> Matrix<2> {
        self.0.mass_matrix(q)
    }
    fn rigid_bias(&self, q: &Vector<2>, dq: &Vector<2>) -> Vector<2> {
        self.0.rigid_bias(q, dq)
    }
    fn friction(&self, dq: &Vector<2>) -> Vector<2> {
        self.0.friction(dq)
    }
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn mass_matrix_is_symmetric_positive_definite(arm in arm(), q in vector(10.0)) {
        let mass = arm.mass_matrix(&q);
        prop_assert_eq!(mass, mass.transpose());
        prop_assert!(mass.cholesky().is_some());
    }

    #[test]
    fn mass_matrix_rate_minus_twice_coriolis_is_skew(
        arm in arm(), q in vector(10.0), dq in vector(5.0), z in vector(1.0),
    ) {
        let ahead = arm.mass_matrix(&(q + dq * STEP));
        let behind = arm.mass_matrix(&(q - dq * STEP));
        let n = (ahead - behind) / (2.0 * STEP) - arm.coriolis(&q, &dq) * 2.0;
        let size = 1.0 + n.amax();
        prop_assert!((n + n.transpose()).amax() < DIFFERENCE * size, "{n}");
        prop_assert!(z.dot(&(n * z)).abs() < DIFFERENCE * size);
    }

    #[test]
    fn bias_is_coriolis_plus_gravity_plus_friction(
        arm in arm(), q in vector(10.0), dq in vector(5.0),
    ) {
        let parts = [arm.coriolis(&q, &dq) * dq, arm.gravity(&q), arm.friction(&dq)];
        let size = 1.0 + parts.iter().map(|p| p.amax()).sum::<f64>();
        let sum: Vector<2> = parts.iter().sum();
        prop_assert!((arm.bias(&q, &dq) - sum).amax() < ROUNDING * size);
    }

    #[test]
    fn mass_matrix_and_bias_equals_the_two_calls_bit_for_bit(
        arm in arm(), q in vector(10.0), dq in vector(5.0),
    ) {
        let (mass, bias) = arm.mass_matrix_and_bias(&q, &dq);
        prop_assert_eq!(mass, arm.mass_matrix(&q));
        prop_assert_eq!(bias, arm.bias(&q, &dq));
    }

    #[test]
    fn forward_dynamics_inverts_inverse_dynamics(
        arm in arm(), q in vector(10.0), dq in vector(5.0), ddq in vector(20.0),
    ) {
        let tau = arm.inverse_dynamics(&q, &dq, &ddq);
        let back = arm.forward_dynamics(&q, &dq, &tau);
        let mass = arm.mass_matrix(&q);
        // A torque error of one rounding is amplified by the inverse of M.
        let torque = tau.amax() + arm.bias(&q, &dq).amax() + 1.0;
        let size = mass.try_inverse().unwrap().amax() * torque;
        prop_assert!((back - ddq).amax() < ROUNDING * size, "{back} {ddq}");
    }

    #[test]
    fn gravity_is_the_gradient_of_potential_energy(arm in arm(), q in vector(10.0)) {
        let gravity = arm.gravity(&q);
        for i in 0..2 {
            let mut shift = Vector::<2>::zeros();
            shift[i] = STEP;
            let rise = arm.potential_energy(&(q + shift)) - arm.potential_energy(&(q - shift));
            let size = 1.0 + gravity.amax() + arm.potential_energy(&q).abs();
            prop_assert!((rise / (2.0 * STEP) - gravity[i]).abs() < DIFFERENCE * size);
        }
    }

    #[test]
    fn friction_dissipates(arm in arm(), dq in vector(5.0)) {
        let friction = arm.friction(&dq);
        prop_assert!((0..2).all(|i| friction[i] * dq[i] >= 0.0));
        prop_assert_eq!(arm.friction(&-dq), -friction);
    }

    #[test]
    fn overrides_agree_with_the_default_methods(
        arm in arm(), q in vector(10.0), dq in vector(5.0), tau in vector(50.0),
    ) {
        let plain = Plain(arm);
        let size = 1.0 + arm.bias(&q, &dq).amax();
        prop_assert!((arm.bias(&q, &dq) - plain.bias(&q, &dq)).amax() < ROUNDING * size);
        let off = arm.coriolis(&q, &dq) - plain.coriolis(&q, &dq);
        prop_assert!(off.amax() < ROUNDING * size);
        prop_assert!((arm.gravity(&q) - plain.gravity(&q)).amax() < ROUNDING * size);
        let (mass, bias) = plain.mass_matrix_and_bias(&q, &dq);
        prop_assert_eq!(mass, arm.mass_matrix(&q));
        prop_assert!((arm.bias(&q, &dq) - bias).amax() < ROUNDING * size);
        let closed_form = arm.forward_dynamics(&q, &dq, &tau);
        let difference = closed_form - plain.forward_dynamics(&q, &dq, &tau);
        let size = mass.try_inverse().unwrap().amax() * (tau.amax() + bias.amax() + 1.0);
        // The Cholesky factors lose up to the condition of M against the closed form.
        let condition = mass.amax() * mass.try_inverse().unwrap().amax();
        prop_assert!(difference.amax() < ROUNDING * size * (1.0 + condition));
    }
}

/// Energy balance E(T) − E(0) + ∫q̇ᵀf dt of an undriven swing of 2 s, by classic RK4 in `steps`
/// steps [J].
fn energy_error(arm: &TwoLink, steps: usize) -> f64 {
    type State = (Vector<2>, Vector<2>, f64);
    let rate = |(q, dq, _): &State| {
        (*dq, arm.forward_dynamics(q, dq, &Vector::<2>::zeros()), dq.dot(&arm.friction(dq)))
    };
    let moved = |x: &State, k: &State, h: f64| (x.0 + k.0 * h, x.1 + k.1 * h, x.2 + k.2 * h);
    let energy = |x: &State| arm.kinetic_energy(&x.0, &x.1) + arm.potential_energy(&x.0);

    let start: State = (Vector::<2>::new(0.3, -0.4), Vector::<2>::new(1.0, 2.0), 0.0);
    let h = 2.0 / steps as f64;
    let mut x = start;
    for _ in 0..steps {
        let k1 = rate(&x);
        let k2 = rate(&moved(&x, &k1, h / 2.0));
        let k3 = rate(&moved(&x, &k2, h / 2.0));
        let k4 = rate(&moved(&x, &k3, h));
        for (k, weight) in [(k1, 1.0), (k2, 2.0), (k3, 2.0), (k4, 1.0)] {
            x = moved(&x, &k, h * weight / 6.0);
        }
    }
    energy(&x) - energy(&start) + x.2
}

fn swing(friction: Friction<2>) -> TwoLink {
    TwoLink::new(TwoLinkParameters { gravity: 9.81, friction, ..Default::default() }).unwrap()
}

fn assert_energy_order_4(arm: &TwoLink) {
    let errors = [500, 1000, 2000].map(|steps| energy_error(arm, steps).abs());
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!(order > 3.7, "order {order}, errors {errors:?}");
    }
    assert!(errors[2] < 1e-8, "{errors:?}");
}

#[test]
fn undriven_swing_without_friction_keeps_its_energy() {
    assert_energy_order_4(&swing(Friction::default()));
}

#[test]
fn undriven_swing_loses_exactly_what_friction_takes() {
    let friction = Friction { viscous: [0.5, 0.3], coulomb: [0.8, 0.4], smoothing: [0.5; 2] };
    assert_energy_order_4(&swing(friction));
}

#[test]
fn friction_has_the_stated_shape() {
    let none = Friction::<2>::default();
    assert!(none.is_none());
    assert_eq!(none.torque(&Vector::<2>::new(3.0, -2.0)), Vector::<2>::zeros());

    let both = Friction { viscous: [2.0, 0.0], coulomb: [0.0, 3.0], smoothing: [0.01, 0.5] };
    assert!(!both.is_none());
    let torque = both.torque(&Vector::<2>::new(1.5, -0.5));
    assert_eq!(torque[0], 3.0);
    // tanh 1 = 0.7615941559557649
    assert!((torque[1] + 3.0 * 0.761_594_155_955_764_9).abs() < ROUNDING);
    assert_eq!(both.torque(&Vector::<2>::new(0.0, 100.0))[1], 3.0);
}

#[test]
fn paper_parameters_give_the_paper_numbers() {
    let nominal = TwoLink::new(TwoLinkParameters::default()).unwrap();
    let doubled = TwoLinkParameters { mass: [8.0; 2], inertia: [0.4; 2], ..Default::default() };
    let actual = TwoLink::new(doubled).unwrap();
    assert_eq!(actual.parameters(), &doubled);
    for (got, wanted) in nominal.theta().iter().zip([1.45, 0.5, 0.45]) {
        assert!((got - wanted).abs() < 1e-15);
    }
    for (got, wanted) in actual.theta().iter().zip([2.9, 1.0, 0.9]) {
        assert!((got - wanted).abs() < 1e-15);
    }

    // Doubling masses and inertias doubles every entry, exactly.
    let (q, dq) = (Vector::<2>::new(0.4, -1.1), Vector::<2>::new(0.7, -0.2));
    assert_eq!(actual.mass_matrix(&q), nominal.mass_matrix(&q) * 2.0);
    assert_eq!(actual.bias(&q, &dq), nominal.bias(&q, &dq) * 2.0);
    assert_eq!(nominal.gravity(&q), Vector::<2>::zeros());

    // M = [θ₁ + θ₃ + 2θ₂, θ₃ + θ₂; θ₃ + θ₂, θ₃] stretched out.
    let stretched = nominal.mass_matrix(&Vector::<2>::zeros());
    assert!((stretched - Matrix::<2>::new(2.9, 0.95, 0.95, 0.45)).amax() < 1e-15);
    // At q₂ = π/2: H = [−θ₂ (2 q̇₁q̇₂ + q̇₂²), θ₂ q̇₁²] = [0.12, 0.245].
    let bent = Vector::<2>::new(0.0, core::f64::consts::FRAC_PI_2);
    assert!((nominal.bias(&bent, &dq) - Vector::<2>::new(0.12, 0.245)).amax() < 1e-15);
}

#[test]
fn hanging_arm_carries_its_weight_at_the_horizontal() {
    let arm = swing(Friction::default());
    // G(0) = g [m₁l₁/2 + m₂(l₁ + l₂/2), m₂l₂/2] = 9.81 [4, 1]
    let gravity = arm.gravity(&Vector::<2>::zeros());
    assert!((gravity - Vector::<2>::new(39.24, 9.81)).amax() < ROUNDING);
    let down = Vector::<2>::new(-core::f64::consts::FRAC_PI_2, 0.0);
    assert!(arm.gravity(&down).amax() < ROUNDING);
    assert!((arm.potential_energy(&down) + 9.81 * 4.0).abs() < ROUNDING);
}

#[test]
fn forward_dynamics_survives_a_tiny_inertia_beside_a_large_mass() {
    // θ₁θ₃ − θ₂² cos² q₂ as printed is 0 or negative here; the sum of positive terms is not.
    let parameters = TwoLinkParameters {
        mass: [1e-9, 1e9],
        length: [1.0; 2],
        inertia: [1e-9; 2],
        ..Default::default()
    };
    let arm = TwoLink::new(parameters).unwrap();
    let zero = Vector::<2>::zeros();
    let ddq = arm.forward_dynamics(&zero, &zero, &Vector::<2>::new(1.0, 0.0));
    // q̈₁ = θ₃ / det, det = (I₁ + m₁/4) θ₃ + m₂ I₂
    let wanted = 2.5e8 / (1.25e-9 * 2.5e8 + 1.0);
    assert!((ddq[0] / wanted - 1.0).abs() < ROUNDING, "{ddq}");
}

fn refusal(change: impl Fn(&mut TwoLinkParameters)) -> Error {
    let friction = Friction { viscous: [0.1; 2], coulomb: [0.2; 2], smoothing: [0.05; 2] };
    let mut parameters = TwoLinkParameters { gravity: 9.81, friction, ..Default::default() };
    assert!(TwoLink::new(parameters).is_ok());
    change(&mut parameters);
    TwoLink::new(parameters).unwrap_err()
}

fn too_small(
    parameter: &'static str,
    index: Option<usize>,
    got: f64,
    wanted: &'static str,
) -> Error {
    Error::out_of_range(parameter, got, wanted).at(index)
}

/// NaN is not equal to itself, so only infinities are compared as values.
fn not_finite(parameter: &'static str, index: Option<usize>) -> Error {
    Error::not_finite(parameter, f64::INFINITY).at(index)
}

#[test]
fn refuses_a_mass_of_zero() {
    let error = refusal(|p| p.mass[1] = 0.0);
    assert_eq!(error, too_small("mass", Some(1), 0.0, "a number > 0"));
}

#[test]
fn refuses_a_mass_that_is_nan() {
    let error = refusal(|p| p.mass[0] = f64::NAN);
    assert_eq!((error.parameter(), error.index()), ("mass", Some(0)));
    assert!(matches!(error.problem(), Problem::NotFinite { got, .. } if got.is_nan()));
}

#[test]
fn refuses_a_negative_length() {
    let error = refusal(|p| p.length[0] = -0.5);
    assert_eq!(error, too_small("length", Some(0), -0.5, "a number > 0"));
}

#[test]
fn refuses_an_infinite_length() {
    assert_eq!(refusal(|p| p.length[1] = f64::INFINITY), not_finite("length", Some(1)));
}

#[test]
fn refuses_an_inertia_of_zero() {
    let error = refusal(|p| p.inertia[1] = 0.0);
    assert_eq!(error, too_small("inertia", Some(1), 0.0, "a number > 0"));
}

#[test]
fn refuses_an_infinite_inertia() {
    assert_eq!(refusal(|p| p.inertia[0] = f64::INFINITY), not_finite("inertia", Some(0)));
}

#[test]
fn refuses_an_infinite_gravity() {
    assert_eq!(refusal(|p| p.gravity = f64::INFINITY), not_finite("gravity", None));
}

#[test]
fn refuses_a_negative_viscous_friction() {
    let error = refusal(|p| p.friction.viscous[0] = -1.0);
    assert_eq!(error, too_small("friction.viscous", Some(0), -1.0, "a number >= 0"));
}

#[test]
fn refuses_an_infinite_coulomb_friction() {
    let error = refusal(|p| p.friction.coulomb[1] = f64::INFINITY);
    assert_eq!(error, not_finite("friction.coulomb", Some(1)));
}

#[test]
fn refuses_a_negative_smoothing() {
    let error = refusal(|p| p.friction.smoothing[1] = -0.1);
    assert_eq!(error, too_small("friction.smoothing", Some(1), -0.1, "a number >= 0"));
}

#[test]
fn refuses_masses_that_overflow_together() {
    let error = refusal(|p| {
        p.mass = [1e300; 2];
        p.gravity = 0.0;
    });
    assert_eq!(error, not_finite("mass_matrix.det", None));
}

#[test]
fn refuses_masses_that_underflow_together() {
    let error = refusal(|p| {
        p.mass = [1e-200; 2];
        p.inertia = [1e-200; 2];
    });
    let wanted = "at least 2.3e-308 kg^2 m^4";
    assert_eq!(error, too_small("mass_matrix.det", None, 0.0, wanted));
}

#[test]
fn refuses_a_gravity_whose_torque_overflows() {
    assert_eq!(refusal(|p| p.gravity = 1e308), not_finite("gravity_torque", Some(0)));
}

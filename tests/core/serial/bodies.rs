//! Mass distributions that no body has: refused, taken as they stand, or the nearest one; and arms
//! that come of such arms.

use nalgebra::{Matrix3, Vector3};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use steadyarm::arm::{
    Arm, Inertia, JointFriction, JointKind, Link, Perturbation, Pose, Serial, SerialParameters,
    Unphysical,
};
use steadyarm::math::Vector;
use steadyarm::{Error, Problem};

use crate::chains::{self, vector};
use crate::random::Random;

/// Rounding of a few products of numbers of size 1.
const ROUNDING: f64 = 1e-14;
const POLICIES: [Unphysical; 3] = [Unphysical::Refuse, Unphysical::Note, Unphysical::Nearest];

fn config() -> ProptestConfig {
    ProptestConfig {
        cases: 300,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(10),
        ..ProptestConfig::default()
    }
}

/// Σ = ½ tr(I) 1 − I.
fn second_moments(moments: &Matrix3<f64>) -> Matrix3<f64> {
    Matrix3::identity() * (0.5 * moments.trace()) - moments
}

/// Moments in turned axes whose Σ has these principal values.
fn of_second_moments(values: [f64; 3], turn: &Matrix3<f64>) -> Matrix3<f64> {
    let sigma = Matrix3::from_diagonal(&values.into());
    let m = turn * (Matrix3::identity() * sigma.trace() - sigma) * turn.transpose();
    (m + m.transpose()) * 0.5
}

/// A body, or one whose Σ has a negative principal value.
fn any_inertia(random: &mut Random, flawed: bool) -> Inertia {
    let turn = chains::rotation(random);
    let lacking = if flawed { -random.between(0.01, 0.2) } else { random.between(0.0, 0.2) };
    let values = [random.between(0.1, 1.0), random.between(0.1, 1.0), lacking];
    let com = random.matrix::<3, 1>() * 0.3;
    Inertia { mass: random.between(0.5, 3.0), com, moments: of_second_moments(values, &turn) }
}

/// A chain, some of whose links may be no bodies.
fn parameters(random: &mut Random, flawed: bool) -> SerialParameters<4> {
    let mut parameters = *chains::chain::<4>(random).parameters();
    for link in &mut parameters.links {
        let this = flawed && random.next() > 0.0;
        link.inertia = any_inertia(random, this);
        // What is lacking is far less than rotors have.
        link.armature = 1.0;
    }
    parameters
}

fn out_of_range(error: &Error) -> bool {
    matches!(error.problem(), Problem::OutOfRange { .. })
}

/// The nearest Σ' ⪰ 0 is the one with Σ' − Σ ⪰ 0 and tr(Σ' (Σ' − Σ)) = 0: the conditions of a
/// projection on that cone (Moreau's decomposition).
#[test]
fn nearest_is_the_projection_on_the_bodies() {
    let mut random = Random(31);
    for _ in 0..500 {
        let stated = any_inertia(&mut random, true);
        let nearest = stated.nearest().unwrap();
        assert_eq!((nearest.mass, nearest.com), (stated.mass, stated.com));
        nearest.validate().unwrap();
        assert_eq!(nearest.nearest().unwrap(), nearest);
        assert_eq!(nearest.moments, nearest.moments.transpose());
        let sigma = second_moments(&nearest.moments);
        let added = sigma - second_moments(&stated.moments);
        assert!(sigma.symmetric_eigenvalues().min() > -ROUNDING);
        assert!(added.symmetric_eigenvalues().min() > -ROUNDING);
        assert!(added.amax() > 1e-3);
        assert!((sigma * added).trace().abs() < ROUNDING);
        // Frames don't matter.
        let pose = chains::pose(&mut random);
        let moved = stated.transformed(&pose).nearest().unwrap();
        let off = (moved.moments - nearest.transformed(&pose).moments).amax();
        assert!(off < ROUNDING, "{off}");
    }
}

#[test]
fn bodies_are_taken_bit_for_bit_by_every_policy() {
    let mut random = Random(32);
    for _ in 0..200 {
        let body = any_inertia(&mut random, false);
        assert_eq!(body.nearest().unwrap(), body);
        let parameters = parameters(&mut random, false);
        for unphysical in POLICIES {
            let arm = Serial::new_with(parameters, unphysical).unwrap();
            assert_eq!(arm.parameters(), &parameters);
            assert_eq!(arm.unphysical(), unphysical);
        }
    }
}

/// Extreme sizes: what is nearest is still a body.
#[test]
fn nearest_at_the_ends_of_the_scale() {
    let turn = chains::rotation(&mut Random(5));
    for size in [1e-30, 1e-9, 1e9, 1e100] {
        for values in [[1.0, -1.0, 1.0], [1.0, 1e-12, -1.0], [1.0, -1e-5, -1e-5], [-1.0; 3]] {
            let moments = of_second_moments(values.map(|value| value * size), &turn);
            let stated = Inertia { mass: 1e-30, com: Vector3::zeros(), moments };
            assert!(stated.validate().is_err());
            let nearest = stated.nearest().unwrap();
            nearest.validate().unwrap();
            let kept = of_second_moments(values.map(|value| value.max(0.0) * size), &turn);
            assert!((nearest.moments - kept).amax() <= ROUNDING * size);
        }
    }
}

#[test]
fn policies_do_as_they_say() {
    let mut random = Random(33);
    for _ in 0..50 {
        let mut stated = parameters(&mut random, false);
        stated.links[2].inertia = any_inertia(&mut random, true);
        let error = Serial::new(stated).unwrap_err();
        assert_eq!((error.parameter(), error.index()), ("inertia.moments", Some(2)));
        assert!(out_of_range(&error), "{error}");
        let noted = Serial::new_with(stated, Unphysical::Note).unwrap();
        assert_eq!(noted.parameters(), &stated);
        let nearest = Serial::new_with(stated, Unphysical::Nearest).unwrap();
        assert_eq!(nearest.links()[2].inertia, stated.links[2].inertia.nearest().unwrap());
        // The nearest only adds: M' − M ⪰ 0.
        let q = vector(&mut random, 3.0);
        let added = nearest.mass_matrix(&q) - noted.mass_matrix(&q);
        assert!(added.symmetric_eigenvalues().min() > -1e-13);
    }
}

/// Whatever is taken is taken into the dynamics: the torque is Y π, linear in the figures, bodies
/// or not.
#[test]
fn what_is_taken_as_stated_moves_as_stated() {
    let mut random = Random(34);
    for _ in 0..50 {
        let arm = Serial::new_with(parameters(&mut random, true), Unphysical::Note).unwrap();
        let arm = arm.without_friction().with_armature(&[1.0; 4]).unwrap();
        let [q, dq, ddq] = [(); 3].map(|()| vector::<4>(&mut random, 2.0));
        let (mut pi, mut y) = ([0.0; 40], [0.0; 160]);
        arm.inertial_parameters(&mut pi).unwrap();
        arm.regressor(&q, &dq, &ddq, &mut y).unwrap();
        let torque = |i: usize| y[40 * i..40 * (i + 1)].iter().zip(&pi).map(|(y, p)| y * p).sum();
        let tau = Vector::<4>::from_fn(|i, _| torque(i)) + ddq;
        assert!((arm.inverse_dynamics(&q, &dq, &ddq) - tau).amax() < 1e-11);
    }
}

#[test]
fn mass_matrix_must_be_positive_for_any_policy() {
    let negative = Inertia {
        mass: 1.0,
        com: Vector3::zeros(),
        moments: Matrix3::from_diagonal(&[0.1, 0.1, -0.1].into()),
    };
    let link = Link::new(JointKind::Revolute, Pose::IDENTITY, Vector3::z(), negative);
    let parameters =
        SerialParameters { links: [link], tip: Pose::IDENTITY, gravity: [0.0, 0.0, -9.81] };
    // The nearest has Σ = diag(0, 0, 0.15) of diag(−0.05, −0.05, 0.15), which is a rod along the
    // axis.
    for unphysical in [Unphysical::Note, Unphysical::Nearest] {
        let error = Serial::new_with(parameters, unphysical).unwrap_err();
        assert_eq!((error.parameter(), error.index()), ("inertia", Some(0)));
        assert!(out_of_range(&error), "{error}");
        let mut with_rotor = parameters;
        with_rotor.links[0].armature = 0.11;
        let arm = Serial::new_with(with_rotor, unphysical).unwrap();
        let wanted = if unphysical == Unphysical::Note { 0.01 } else { 0.11 };
        assert!((arm.mass_matrix(&[0.3].into())[0] - wanted).abs() < ROUNDING);
        // A rotor can be taken away again only if something is left to move.
        assert!(arm.with_armature(&[0.0]).is_err());
    }
}

#[test]
fn mass_that_is_negative_or_missing() {
    let body = any_inertia(&mut Random(35), false);
    let negative = Inertia { mass: -1e-3, ..body };
    let massless = Inertia { mass: 0.0, ..body };
    for stated in [negative, massless] {
        let error = stated.validate().unwrap_err();
        assert!(error.parameter() == "mass" && out_of_range(&error), "{error}");
    }
    // No body is near a negative mass. Moments without mass are the limit of bodies.
    assert!(negative.nearest().is_err());
    assert_eq!(massless.nearest().unwrap(), massless);
    let mut parameters = parameters(&mut Random(36), false);
    for (stated, policies) in
        [(negative, &[Unphysical::Note][..]), (massless, &[Unphysical::Note, Unphysical::Nearest])]
    {
        parameters.links[1].inertia = stated;
        for unphysical in POLICIES {
            let arm = Serial::new_with(parameters, unphysical);
            assert_eq!(arm.is_ok(), policies.contains(&unphysical));
            assert!(arm.is_err() || arm.unwrap().parameters() == &parameters);
        }
    }
}

/// Numbers that are none, and matrices that are not symmetric, are nobody's figures.
#[test]
fn what_is_no_mass_distribution_at_all_is_refused_by_every_policy() {
    let good = parameters(&mut Random(37), false);
    let broken: [fn(&mut Inertia); 4] = [
        |inertia| inertia.mass = f64::NAN,
        |inertia| inertia.com.x = f64::INFINITY,
        |inertia| inertia.moments[(0, 0)] = f64::NAN,
        |inertia| inertia.moments[(0, 1)] += 1e-6,
    ];
    for change in broken {
        let mut parameters = good;
        change(&mut parameters.links[3].inertia);
        for unphysical in POLICIES {
            assert!(Serial::new_with(parameters, unphysical).is_err());
        }
    }
}

#[test]
fn moving_a_matrix_does_not_make_it_symmetric() {
    let mut inertia = any_inertia(&mut Random(38), false);
    inertia.moments[(0, 1)] += 1e-3;
    let moved = inertia.transformed(&chains::pose(&mut Random(39)));
    let error = moved.validate().unwrap_err();
    assert!(error.parameter() == "moments" && out_of_range(&error), "{error}");
}

#[test]
fn masses_that_cancel_leave_no_centre_and_are_refused() {
    let one = Inertia::point_mass(1.0, Vector3::x());
    let other = Inertia::point_mass(-1.0, Vector3::zeros());
    let error = one.plus(&other).validate().unwrap_err();
    assert_eq!(error.parameter(), "com");
    assert!(matches!(error.problem(), Problem::NotFinite { .. }), "{error}");
}

const OFF: Perturbation = Perturbation { mass: 0.2, com: 0.01, inertia: 0.2, friction: 0.2 };

proptest! {
    #![proptest_config(config())]

    /// Payloads, perturbations, changes and the way through π keep the policy, of bodies and of
    /// what is none.
    #[test]
    fn arms_of_an_arm_keep_its_policy(seed in any::<u64>(), policy in 0_usize..3) {
        let mut random = Random(seed);
        let unphysical = POLICIES[policy];
        let stated = parameters(&mut random, unphysical != Unphysical::Refuse);
        let arm = Serial::new_with(stated, unphysical).unwrap();
        let mut pi = [0.0; 40];
        arm.inertial_parameters(&mut pi).unwrap();
        let arms = [
            arm.with_payload(&any_inertia(&mut random, false)).unwrap(),
            arm.perturb(seed, &OFF).unwrap(),
            arm.with_parameters(&pi).unwrap(),
            arm.with_gravity([1.0, 2.0, 3.0]).unwrap(),
            arm.with_armature(&[2.0; 4]).unwrap(),
            arm.with_friction(&[JointFriction::default(); 4]).unwrap(),
            arm.without_friction(),
            arm.with_stops(&[Default::default(); 4]).unwrap(),
        ];
        for other in &arms {
            prop_assert_eq!(other.unphysical(), unphysical);
            // The way back through what it is made of is the identity.
            let again = Serial::new_with(*other.parameters(), unphysical).unwrap();
            prop_assert_eq!(&again, other);
            if unphysical != Unphysical::Note {
                Serial::new(*other.parameters()).unwrap();
            }
        }
        // A payload weighs what it weighs, whatever the rest is: a load that is no body is refused.
        let load = any_inertia(&mut random, true);
        let error = arm.with_payload(&load).unwrap_err();
        prop_assert!(error.parameter() == "payload.moments" && out_of_range(&error), "{error}");
    }

    #[test]
    fn inertial_parameters_there_and_back(seed in any::<u64>(), flawed in any::<bool>()) {
        let mut random = Random(seed);
        let stated = parameters(&mut random, flawed);
        let arm = Serial::new_with(stated, Unphysical::Note).unwrap();
        let (mut pi, mut again) = ([0.0; 40], [0.0; 40]);
        arm.inertial_parameters(&mut pi).unwrap();
        let back = arm.with_parameters(&pi).unwrap();
        back.inertial_parameters(&mut again).unwrap();
        for (a, b) in pi.iter().zip(&again) {
            prop_assert!((a - b).abs() < ROUNDING, "{a} {b}");
        }
        for (a, b) in arm.links().iter().zip(back.links()) {
            prop_assert!((a.inertia.com - b.inertia.com).amax() < ROUNDING);
            prop_assert!((a.inertia.moments - b.inertia.moments).amax() < ROUNDING);
        }
        // Any π is taken: another arm's.
        let other = Serial::new_with(parameters(&mut random, flawed), Unphysical::Note).unwrap();
        other.inertial_parameters(&mut pi).unwrap();
        let moved = arm.with_parameters(&pi).unwrap();
        moved.inertial_parameters(&mut again).unwrap();
        prop_assert!(pi.iter().zip(&again).all(|(a, b)| (a - b).abs() < ROUNDING));
        prop_assert_eq!(moved.limits(), arm.limits());
    }
}

#[test]
fn sum_of_bodies_is_all_of_them_as_one() {
    let mut random = Random(40);
    let bodies = [(); 4].map(|()| any_inertia(&mut random, false));
    let sum: Inertia = bodies.into_iter().sum();
    let pairwise = bodies[0].plus(&bodies[1]).plus(&bodies[2]).plus(&bodies[3]);
    assert_eq!(sum, pairwise);
    assert_eq!(bodies[..1].iter().copied().sum::<Inertia>(), bodies[0]);
    assert_eq!(core::iter::empty::<Inertia>().sum::<Inertia>(), Inertia::NONE);
}

//! Arms from arms: payloads, merged bodies, seeded neighbours, and the closed form of two links.

use nalgebra::{Matrix3, Vector3};
use steadyarm::Error;
use steadyarm::arm::{
    Arm, Friction, Inertia, JointFriction, JointKind, JointLimits, Link, Perturbation, Pose,
    Serial, SerialParameters, TwoLink, TwoLinkParameters,
};
use steadyarm::math::Vector;

use crate::chains::{self, vector};
use crate::random::Random;

const ROUNDING: f64 = 1e-12;

/// Inertia of points of mass, by its definition.
fn of_points(points: &[(f64, Vector3<f64>)]) -> Inertia {
    let mass = points.iter().map(|p| p.0).sum::<f64>();
    let com = points.iter().map(|p| p.1 * p.0).sum::<Vector3<f64>>() / mass;
    let mut moments = Matrix3::zeros();
    for (m, x) in points {
        let d = x - com;
        moments += (Matrix3::identity() * d.dot(&d) - d * d.transpose()) * *m;
    }
    Inertia { mass, com, moments }
}

fn off(a: &Inertia, b: &Inertia) -> f64 {
    let (com, moments) = ((a.com - b.com).amax(), (a.moments - b.moments).amax());
    (a.mass - b.mass).abs().max(com).max(moments)
}

#[test]
fn inertias_add_and_move_as_their_points_do() {
    let mut random = Random(7);
    for _ in 0..200 {
        let mut points = [(); 4].map(|()| (random.between(0.1, 2.0), random.matrix::<3, 1>()));
        let (one, other) = (of_points(&points[..1]), of_points(&points[1..]));
        assert!(off(&one, &Inertia::point_mass(points[0].0, points[0].1)) < ROUNDING);
        let both = of_points(&points);
        assert!(off(&one.plus(&other), &both) < ROUNDING);
        assert!(off(&other.plus(&one), &both) < ROUNDING);
        assert!(off(&both.plus(&Inertia::NONE), &both) < ROUNDING);
        let about_origin: Matrix3<f64> = points
            .iter()
            .map(|(m, x)| (Matrix3::identity() * x.dot(x) - x * x.transpose()) * *m)
            .sum();
        assert!((both.moments_about_origin() - about_origin).amax() < ROUNDING);
        let pose = chains::pose(&mut random);
        points.iter_mut().for_each(|(_, x)| *x = pose.rotation * *x + pose.translation);
        assert!(off(&both.transformed(&pose), &of_points(&points)) < ROUNDING);
        assert!(off(&both.transformed(&pose).transformed(&pose.inverse()), &both) < ROUNDING);
    }
    assert_eq!(Inertia::NONE.plus(&Inertia::NONE), Inertia::NONE);
}

fn payload_adds_its_own<const N: usize>() {
    for seed in 0..50 {
        let mut random = Random(900 + seed);
        let arm = chains::chain::<N>(&mut random);
        let payload = chains::inertia(&mut random);
        let loaded = arm.with_payload(&payload).unwrap();
        let q = vector(&mut random, 3.0);
        let poses = chains::poses(&arm, &q);
        let tip = poses[N - 1].then(&arm.parameters().tip);
        let (linear, angular) = chains::jacobians(&arm, &poses, N - 1, &tip.point(&payload.com));
        let moments = tip.rotation * payload.moments * tip.rotation.transpose();
        let mass = arm.mass_matrix(&q)
            + linear.transpose() * linear * payload.mass
            + angular.transpose() * moments * angular;
        let g = Vector3::from(arm.parameters().gravity);
        let gravity = arm.gravity(&q) - linear.transpose() * g * payload.mass;
        assert!((loaded.mass_matrix(&q) - mass).amax() < ROUNDING * (1.0 + mass.amax()));
        assert!((loaded.gravity(&q) - gravity).amax() < ROUNDING * (1.0 + gravity.amax()));
        assert_eq!(loaded.pose(&q), arm.pose(&q));
    }
}

#[test]
fn payload_adds_its_mass_matrix_and_weight() {
    payload_adds_its_own::<1>();
    payload_adds_its_own::<3>();
    payload_adds_its_own::<7>();
}

#[test]
fn payload_that_cannot_be_is_refused_by_name() {
    let arm = chains::chain::<3>(&mut Random(1));
    let good = chains::inertia(&mut Random(2));
    let name = |payload| arm.with_payload(&payload).unwrap_err().parameter();
    assert_eq!(name(Inertia { mass: -1.0, ..good }), "payload.mass");
    assert_eq!(name(Inertia { com: Vector3::new(f64::NAN, 0.0, 0.0), ..good }), "payload.com");
    assert_eq!(name(Inertia { moments: -good.moments, ..good }), "payload.moments");
}

#[test]
fn a_chain_without_friction_is_the_same_chain() {
    let arm = chains::chain::<5>(&mut Random(11));
    let smooth = arm.without_friction();
    let mut parameters = *arm.parameters();
    parameters.links.iter_mut().for_each(|link| link.friction = JointFriction::default());
    assert_eq!(smooth, Serial::new(parameters).unwrap());
    let dq = Vector::<5>::repeat(1.0);
    assert!(arm.friction(&dq).amax() > 0.0);
    assert_eq!(smooth.friction(&dq), Vector::<5>::zeros());
}

#[test]
fn limits_are_those_of_the_links() {
    let mut parameters = *chains::chain::<3>(&mut Random(12)).parameters();
    parameters.links[1].limits =
        JointLimits { lower: -1.0, upper: 2.0, velocity: 3.0, effort: 4.0 };
    parameters.links[2].limits = JointLimits::NONE;
    let arm = Serial::new(parameters).unwrap();
    assert_eq!(arm.limits()[1], parameters.links[1].limits);
    assert_eq!(arm.position_limits()[1], [-1.0, 2.0]);
    assert_eq!((arm.velocity_limit()[1], arm.effort_limit()[1]), (3.0, 4.0));
    assert_eq!(arm.effort_limit()[2], f64::INFINITY);
    assert_eq!(arm.links(), &parameters.links);
}

const OFF: Perturbation = Perturbation { mass: 0.3, com: 0.02, inertia: 0.4, friction: 0.5 };

#[test]
fn perturbed_arms_are_valid_seeded_and_as_far_off_as_asked() {
    for seed in 0..1000 {
        let arm = chains::chain::<4>(&mut Random(seed));
        let other = arm.perturb(seed, &OFF).unwrap();
        assert_eq!(other, arm.perturb(seed, &OFF).unwrap());
        assert_ne!(other, arm.perturb(seed + 1, &OFF).unwrap());
        for (joint, (a, b)) in arm.links().iter().zip(other.links()).enumerate() {
            b.validate(joint).unwrap();
            let ratio = b.inertia.mass / a.inertia.mass;
            assert!((0.7..1.3).contains(&ratio) && ratio != 1.0, "{ratio}");
            let shift = (b.inertia.com - a.inertia.com).amax();
            assert!(shift <= 0.02 && shift > 0.0, "{shift}");
            assert_ne!(a.inertia.moments * ratio, b.inertia.moments);
            let apart = |x: f64, y: f64| (x - y).abs() <= 0.5 * x;
            assert!(apart(a.friction.viscous, b.friction.viscous));
            assert!(apart(a.friction.coulomb[0], b.friction.coulomb[0]));
            assert!(apart(a.friction.coulomb[1], b.friction.coulomb[1]));
            assert!(apart(a.friction.stribeck, b.friction.stribeck));
            assert_eq!((a.placement, a.axis, a.limits), (b.placement, b.axis, b.limits));
        }
    }
}

#[test]
fn perturbing_by_nothing_changes_nothing_and_mass_alone_scales() {
    let arm = chains::chain::<4>(&mut Random(5));
    assert_eq!(arm.perturb(1, &Perturbation::default()).unwrap(), arm);
    let heavier = arm.perturb(1, &Perturbation { mass: 0.5, ..Perturbation::default() }).unwrap();
    for (a, b) in arm.links().iter().zip(heavier.links()) {
        let ratio = b.inertia.mass / a.inertia.mass;
        assert_eq!((a.inertia.com, a.friction), (b.inertia.com, b.friction));
        assert!((a.inertia.moments * ratio - b.inertia.moments).amax() < ROUNDING);
    }
}

#[test]
fn a_flat_body_that_only_just_exists_stays_one_when_perturbed() {
    // A lamina's largest moment is the sum of the others; a rod has one that is zero.
    for diagonal in [[1.0, 2.0, 3.0 + 2e-6], [1.0, 1.0, -9e-7]] {
        let moments = Matrix3::from_diagonal(&diagonal.into());
        let mut parameters = *chains::chain::<1>(&mut Random(5)).parameters();
        parameters.links[0].inertia.moments = moments;
        let arm = Serial::new(parameters).unwrap();
        for seed in 0..1000 {
            arm.perturb(seed, &Perturbation { inertia: 0.99, ..OFF }).unwrap();
        }
    }
}

#[test]
fn perturbations_that_could_turn_a_sign_are_refused() {
    let arm = chains::chain::<2>(&mut Random(5));
    let name = |by| arm.perturb(0, &by).unwrap_err().parameter();
    for bad in [-0.1, 1.0, f64::NAN] {
        assert_eq!(name(Perturbation { mass: bad, ..OFF }), "mass");
        assert_eq!(name(Perturbation { inertia: bad, ..OFF }), "inertia");
    }
    assert_eq!(name(Perturbation { com: -1e-9, ..OFF }), "com");
    assert_eq!(name(Perturbation { com: f64::INFINITY, ..OFF }), "com");
    assert_eq!(name(Perturbation { friction: 1.1, ..OFF }), "friction");
}

/// The arm of two links as a chain in the x-y plane; gravity pulls along −y.
fn as_chain(p: &TwoLinkParameters) -> Serial<2> {
    let link = |i: usize, from: f64| {
        let inertia = Inertia {
            mass: p.mass[i],
            com: Vector3::new(p.length[i] / 2.0, 0.0, 0.0),
            moments: Matrix3::from_diagonal_element(p.inertia[i]),
        };
        let friction = JointFriction {
            viscous: p.friction.viscous[i],
            coulomb: [p.friction.coulomb[i]; 2],
            smoothing: p.friction.smoothing[i],
            ..JointFriction::default()
        };
        let placement = Pose::at(Vector3::new(from, 0.0, 0.0));
        Link { friction, ..Link::new(JointKind::Revolute, placement, Vector3::z(), inertia) }
    };
    let links = [link(0, 0.0), link(1, p.length[0])];
    let tip = Pose::at(Vector3::new(p.length[1], 0.0, 0.0));
    Serial::new(SerialParameters { links, tip, gravity: [0.0, -p.gravity, 0.0] }).unwrap()
}

#[test]
fn a_chain_of_two_agrees_with_the_closed_form() {
    // Relative to the largest entry.
    const AGREEMENT: f64 = 1e-13;
    // Of the sine of an angle of some turns, in metres.
    const ROUNDING: f64 = 1e-14;
    let friction = Friction { viscous: [0.4, 0.3], coulomb: [0.5, 0.2], smoothing: [0.05, 0.1] };
    let paper = TwoLinkParameters::default();
    let parameters = [
        paper,
        TwoLinkParameters { mass: [8.0; 2], inertia: [0.4; 2], ..paper },
        TwoLinkParameters { gravity: 9.81, friction, ..paper },
    ];
    let mut random = Random(3);
    for p in parameters {
        let (closed, chain) = (TwoLink::new(p).unwrap(), as_chain(&p));
        for _ in 0..1000 {
            let (q, dq) = (vector::<2>(&mut random, 4.0), vector::<2>(&mut random, 3.0));
            let u = vector::<2>(&mut random, 20.0);
            let pairs = [
                (closed.bias(&q, &dq), chain.bias(&q, &dq)),
                (closed.gravity(&q), chain.gravity(&q)),
                (closed.friction(&dq), chain.friction(&dq)),
                (closed.inverse_dynamics(&q, &dq, &u), chain.inverse_dynamics(&q, &dq, &u)),
                (closed.forward_dynamics(&q, &dq, &u), chain.forward_dynamics(&q, &dq, &u)),
            ];
            for (wanted, got) in pairs {
                let off = (wanted - got).amax() / (1.0 + wanted.amax());
                assert!(off < AGREEMENT, "{off:e}");
            }
            let off = (closed.mass_matrix(&q) - chain.mass_matrix(&q)).amax();
            assert!(off < AGREEMENT, "{off:e}");
            let off = (closed.coriolis(&q, &dq) - chain.coriolis(&q, &dq)).amax();
            assert!(off < AGREEMENT, "{off:e}");
            let off = closed.potential_energy(&q) - chain.potential_energy(&q);
            assert!(off.abs() < 1e-12, "{off:e}");
            let [first, second] = chain.link_poses(&q);
            let places = [first.translation, second.translation, chain.pose(&q).translation];
            let [shoulder, elbow] = closed.link_poses(&q);
            let tip = closed.pose(&q);
            for (frame, wanted) in [shoulder, elbow, tip].iter().zip(places) {
                assert!((frame.translation - wanted).amax() < ROUNDING, "{frame:?}");
            }
            let along = (tip.translation - elbow.translation) / p.length[1];
            assert!((tip.rotation.column(0) - along).amax() < ROUNDING);
        }
    }
}

#[test]
fn changed_arms_are_those_built_with_the_change() {
    let mut random = Random(51);
    let arm = chains::chain::<3>(&mut random);
    let friction = [(); 3].map(|()| chains::friction(&mut random));
    let armature = [0.1, 0.2, 0.3];
    let gravity = [0.1, -9.0, 0.2];
    let rebuilt = |change: &dyn Fn(&mut SerialParameters<3>)| {
        let mut parameters = *arm.parameters();
        change(&mut parameters);
        Serial::new(parameters).unwrap()
    };
    let each = |change: &dyn Fn(usize, &mut Link)| {
        rebuilt(&|p| p.links.iter_mut().enumerate().for_each(|(i, link)| change(i, link)))
    };
    assert_eq!(arm.with_friction(&friction).unwrap(), each(&|i, link| link.friction = friction[i]));
    assert_eq!(arm.with_armature(&armature).unwrap(), each(&|i, link| link.armature = armature[i]));
    assert_eq!(arm.with_gravity(gravity).unwrap(), rebuilt(&|p| p.gravity = gravity));
    // M carries the rotors on its diagonal, and nothing else changes.
    let q = vector(&mut random, 3.0);
    let rotors = arm.with_armature(&armature).unwrap().mass_matrix(&q)
        - arm.with_armature(&[0.0; 3]).unwrap().mass_matrix(&q);
    assert!((rotors - Matrix3::from_diagonal(&armature.into())).amax() < ROUNDING);
    // Weight is linear in gravity.
    let turned = arm.with_gravity(gravity.map(|g| -2.0 * g)).unwrap();
    let weight = arm.with_gravity(gravity).unwrap().gravity(&q);
    assert!((turned.gravity(&q) + weight * 2.0).amax() < ROUNDING * weight.amax());
}

#[test]
fn changes_that_cannot_be_are_refused_by_name() {
    let arm = chains::chain::<3>(&mut Random(52));
    let place = |refused: Result<Serial<3>, Error>| {
        let error = refused.unwrap_err();
        (error.parameter(), error.index())
    };
    assert_eq!(place(arm.with_armature(&[0.0, -1.0, 0.0])), ("armature", Some(1)));
    assert_eq!(place(arm.with_armature(&[0.0, 0.0, f64::NAN])), ("armature", Some(2)));
    let mut friction = [JointFriction::default(); 3];
    friction[2].coulomb[1] = -1.0;
    assert_eq!(place(arm.with_friction(&friction)), ("friction.coulomb", Some(2)));
    assert_eq!(place(arm.with_gravity([0.0, f64::INFINITY, 0.0])), ("gravity", Some(1)));
    let mut pi = [0.0; 30];
    arm.inertial_parameters(&mut pi).unwrap();
    let broken = |index: usize, value: f64| {
        let mut pi = pi;
        pi[index] = value;
        place(arm.with_parameters(&pi))
    };
    assert_eq!(broken(17, f64::NAN), ("parameters", Some(17)));
    assert_eq!(broken(10, -1.0), ("inertia.mass", Some(1)));
    assert_eq!(broken(24, -1.0), ("inertia.moments", Some(2)));
    // First moments without mass have no centre.
    assert_eq!(broken(0, 0.0), ("inertia.com", Some(0)));
    for length in [0, 29, 31] {
        let wanted = Error::wrong_length("parameters", length, 30);
        assert_eq!(arm.with_parameters(&vec![0.0; length]).unwrap_err(), wanted);
    }
}

//! A valid chain, and everything that breaks it, one thing at a time.

use nalgebra::{Matrix3, Vector3};
use steadyarm::arm::{Arm, Inertia, JointKind, JointLimits, Link, Pose, Serial, SerialParameters};
use steadyarm::{Error, Problem};

use crate::chains;
use crate::random::Random;

fn valid() -> SerialParameters<3> {
    let mut parameters = *chains::chain::<3>(&mut Random(17)).parameters();
    parameters.links.iter_mut().for_each(|link| link.armature = 0.0);
    Serial::new(parameters).unwrap();
    parameters
}

/// The place and kind of the error after one change of joint 1.
fn refusal(change: impl Fn(&mut Link)) -> (&'static str, Option<usize>, bool) {
    whole(|parameters| change(&mut parameters.links[1]))
}

fn whole(change: impl Fn(&mut SerialParameters<3>)) -> (&'static str, Option<usize>, bool) {
    let mut parameters = valid();
    change(&mut parameters);
    let error = Serial::new(parameters).unwrap_err();
    let out_of_range = match error.problem() {
        Problem::NotFinite { got, .. } => {
            assert!(!got.is_finite());
            false
        }
        Problem::OutOfRange { .. } => true,
        _ => panic!("{error}"),
    };
    (error.parameter(), error.index(), out_of_range)
}

fn infinite(parameter: &'static str) -> (&'static str, Option<usize>, bool) {
    (parameter, Some(1), false)
}

fn outside(parameter: &'static str) -> (&'static str, Option<usize>, bool) {
    (parameter, Some(1), true)
}

const NOT_FINITE: [f64; 3] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];

#[test]
fn what_is_not_finite() {
    for bad in NOT_FINITE {
        let rotation = "placement.rotation";
        assert_eq!(refusal(|l| l.placement.rotation[(1, 2)] = bad), infinite(rotation));
        let translation = "placement.translation";
        assert_eq!(refusal(|l| l.placement.translation[2] = bad), infinite(translation));
        assert_eq!(refusal(|l| l.axis[0] = bad), infinite("axis"));
        assert_eq!(refusal(|l| l.inertia.mass = bad), infinite("inertia.mass"));
        assert_eq!(refusal(|l| l.inertia.com[1] = bad), infinite("inertia.com"));
        assert_eq!(refusal(|l| l.inertia.moments[(2, 0)] = bad), infinite("inertia.moments"));
        assert_eq!(refusal(|l| l.friction.viscous = bad), infinite("friction.viscous"));
        assert_eq!(refusal(|l| l.friction.coulomb[0] = bad), infinite("friction.coulomb"));
        assert_eq!(refusal(|l| l.friction.coulomb[1] = bad), infinite("friction.coulomb"));
        assert_eq!(refusal(|l| l.friction.stribeck = bad), infinite("friction.stribeck"));
        let speed = "friction.stribeck_speed";
        assert_eq!(refusal(|l| l.friction.stribeck_speed = bad), infinite(speed));
        assert_eq!(refusal(|l| l.friction.smoothing = bad), infinite("friction.smoothing"));
        assert_eq!(refusal(|l| l.armature = bad), infinite("armature"));
        assert_eq!(whole(|p| p.gravity[2] = bad), ("gravity", Some(2), false));
        assert_eq!(whole(|p| p.tip.rotation[(0, 0)] = bad), ("tip.rotation", None, false));
        let tip = ("tip.translation", None, false);
        assert_eq!(whole(|p| p.tip.translation[0] = bad), tip);
    }
}

#[test]
fn axes_that_are_not_unit_vectors() {
    assert_eq!(refusal(|l| l.axis *= 1.0 + 2e-6), outside("axis"));
    assert_eq!(refusal(|l| l.axis *= 1.0 - 2e-6), outside("axis"));
    assert_eq!(refusal(|l| l.axis = Vector3::zeros()), outside("axis"));
}

#[test]
fn rotations_that_are_none() {
    let rotation = outside("placement.rotation");
    assert_eq!(refusal(|l| l.placement.rotation *= 1.0 + 2e-6), rotation);
    assert_eq!(refusal(|l| l.placement.rotation[(0, 0)] += 1e-4), rotation);
    // A mirror has orthonormal columns, but turns right hands into left ones.
    assert_eq!(refusal(|l| l.placement.rotation *= -1.0), rotation);
    assert_eq!(refusal(|l| l.placement.rotation = Matrix3::zeros()), rotation);
    assert_eq!(whole(|p| p.tip.rotation *= -1.0), ("tip.rotation", None, true));
}

#[test]
fn axes_and_rotations_off_by_print_are_taken_as_what_they_mean() {
    let mut rounded = valid();
    let exact = Serial::new(rounded).unwrap();
    for link in &mut rounded.links {
        link.axis *= 1.0 + 5e-7;
        link.placement.rotation *= 1.0 - 5e-7;
    }
    rounded.tip.rotation *= 1.0 + 5e-7;
    let arm = Serial::new(rounded).unwrap();
    let q = [0.3, -0.4, 0.5].into();
    // A scale is not a turn: what remains after normalising is rounding.
    assert!((arm.pose(&q).rotation - exact.pose(&q).rotation).amax() < 1e-11);
    assert!((arm.jacobian(&q) - exact.jacobian(&q)).amax() < 1e-11);
    // What the user gave is what the arm gives back.
    assert_eq!(arm.parameters(), &rounded);
}

#[test]
fn masses_that_cannot_be() {
    assert_eq!(refusal(|l| l.inertia.mass = -1e-9), outside("inertia.mass"));
    assert_eq!(refusal(|l| l.inertia.moments[(0, 1)] += 1e-6), outside("inertia.moments"));
    let moments = |diagonal: [f64; 3]| {
        refusal(move |l| l.inertia.moments = Matrix3::from_diagonal(&diagonal.into()))
    };
    assert_eq!(moments([0.1, 0.1, -1e-3]), outside("inertia.moments"));
    assert_eq!(moments([0.1, 0.2, 0.31]), outside("inertia.moments"));
    let mut speck = valid();
    speck.links[1].inertia.moments = Matrix3::from_diagonal(&[-1e-20, 0.0, 1e-20].into());
    Serial::new(speck).unwrap();
    assert_eq!(moments([0.0, 0.35, 0.0]), outside("inertia.moments"));
    // The same in turned axes.
    let turned = refusal(|l| {
        let r = chains::rodrigues(&Vector3::new(0.6, 0.0, 0.8), 0.7);
        let m = r * Matrix3::from_diagonal(&[0.1, 0.2, 0.31].into()) * r.transpose();
        l.inertia.moments = (m + m.transpose()) * 0.5;
    });
    assert_eq!(turned, outside("inertia.moments"));
    // A flat plate, a rod, and a plate with rounded figures are bodies.
    for diagonal in [[0.1, 0.2, 0.3], [0.0, 0.2, 0.2], [0.1, 0.2, 0.3 + 1e-7]] {
        let mut parameters = valid();
        parameters.links[1].inertia.moments = Matrix3::from_diagonal(&diagonal.into());
        Serial::new(parameters).unwrap();
    }
}

#[test]
fn friction_and_armature_that_drive() {
    assert_eq!(refusal(|l| l.friction.viscous = -1e-9), outside("friction.viscous"));
    assert_eq!(refusal(|l| l.friction.coulomb[0] = -1e-9), outside("friction.coulomb"));
    assert_eq!(refusal(|l| l.friction.coulomb[1] = -1e-9), outside("friction.coulomb"));
    assert_eq!(refusal(|l| l.friction.stribeck = -1e-9), outside("friction.stribeck"));
    let speed = "friction.stribeck_speed";
    assert_eq!(refusal(|l| l.friction.stribeck_speed = 0.0), outside(speed));
    assert_eq!(refusal(|l| l.friction.smoothing = -0.1), outside("friction.smoothing"));
    assert_eq!(refusal(|l| l.armature = -1e-9), outside("armature"));
}

#[test]
fn limits_that_nothing_meets() {
    let all = |change: fn(&mut JointLimits)| refusal(move |l| change(&mut l.limits));
    assert_eq!(all(|l| l.lower = f64::NAN), infinite("limits.lower"));
    assert_eq!(all(|l| l.upper = f64::NAN), infinite("limits.upper"));
    assert_eq!(all(|l| l.velocity = f64::NAN), infinite("limits.velocity"));
    assert_eq!(all(|l| l.effort = f64::NAN), infinite("limits.effort"));
    assert_eq!(all(|l| l.lower = f64::INFINITY), outside("limits.lower"));
    assert_eq!(all(|l| l.upper = l.lower - 1e-9), outside("limits.upper"));
    assert_eq!(
        all(|l| (l.lower, l.upper) = (f64::NEG_INFINITY, f64::NEG_INFINITY)),
        outside("limits.upper")
    );
    assert_eq!(all(|l| l.velocity = 0.0), outside("limits.velocity"));
    assert_eq!(all(|l| l.effort = -1.0), outside("limits.effort"));
    let mut parameters = valid();
    parameters.links[1].limits = JointLimits::NONE;
    Serial::new(parameters).unwrap();
    parameters.links[1].limits.lower = 0.5;
    parameters.links[1].limits.upper = 0.5;
    Serial::new(parameters).unwrap();
}

#[test]
fn joints_that_move_nothing() {
    let nothing = |joint| ("inertia", Some(joint), true);
    assert_eq!(whole(|p| p.links[2].inertia = Inertia::NONE), nothing(2));
    assert_eq!(
        whole(|p| {
            p.links[1].inertia = Inertia::NONE;
            p.links[2].inertia = Inertia::NONE;
        }),
        nothing(2)
    );
    // A mass on the axis does not turn.
    let on_axis = |p: &mut SerialParameters<3>| {
        p.links[2].kind = JointKind::Revolute;
        p.links[2].inertia = Inertia::point_mass(1.0, p.links[2].axis * 0.3);
    };
    assert_eq!(whole(on_axis), nothing(2));
    // Two joints about one axis with nothing between them.
    let coaxial = |p: &mut SerialParameters<3>| {
        p.links[1].inertia = Inertia::NONE;
        (p.links[1].kind, p.links[2].kind) = (JointKind::Revolute, JointKind::Revolute);
        p.links[2].placement = Pose::at(p.links[1].axis * 0.2);
        p.links[2].axis = p.links[1].axis;
    };
    assert_eq!(whole(coaxial), nothing(1));
    // Armature is something to move, and so is a link further out.
    let mut parameters = valid();
    parameters.links[2].inertia = Inertia::NONE;
    parameters.links[2].armature = 1e-3;
    Serial::new(parameters).unwrap();
    let mut parameters = valid();
    on_axis(&mut parameters);
    parameters.links[2].armature = 1e-3;
    Serial::new(parameters).unwrap();
}

#[test]
fn numbers_that_overflow_together() {
    assert!(!whole(|p| p.links[2].inertia.mass = 1e308).2);
    assert!(!whole(|p| p.links[1].placement.translation[0] = 1e200).2);
    assert_eq!(whole(|p| p.gravity = [1e308; 3]).0, "gravity");
}

#[test]
fn a_chain_of_nothing() {
    let parameters = SerialParameters::<0> { links: [], tip: Pose::IDENTITY, gravity: [0.0; 3] };
    let wanted = Error::wrong_length("links", 0, 1);
    assert_eq!(Serial::new(parameters).unwrap_err(), wanted);
}

#[test]
fn buffers_of_the_wrong_length() {
    let arm = Serial::new(valid()).unwrap();
    let q = [0.1, 0.2, 0.3].into();
    for length in [0, 89, 91] {
        let wanted = Error::wrong_length("out", length, 90);
        let mut out = vec![7.0; length];
        assert_eq!(arm.regressor(&q, &q, &q, &mut out).unwrap_err(), wanted);
        assert!(out.iter().all(|&x| x == 7.0));
    }
    let wanted = Error::wrong_length("out", 29, 30);
    assert_eq!(arm.inertial_parameters(&mut [0.0; 29]).unwrap_err(), wanted);
}

#[test]
fn inertias_alone_name_their_own_parameters() {
    let good = valid().links[0].inertia;
    good.validate().unwrap();
    let name = |inertia: Inertia| {
        let error = inertia.validate().unwrap_err();
        assert_eq!(error.index(), None);
        error.parameter()
    };
    assert_eq!(name(Inertia { mass: f64::NAN, ..good }), "mass");
    assert_eq!(name(Inertia { com: Vector3::repeat(f64::INFINITY), ..good }), "com");
    assert_eq!(name(Inertia { moments: -good.moments, ..good }), "moments");
}

#[test]
fn a_joint_that_turns_without_an_end_has_none() {
    let endless = |link: &mut Link| {
        link.kind = JointKind::Continuous;
        (link.limits.lower, link.limits.upper) = (f64::NEG_INFINITY, f64::INFINITY);
    };
    let mut parameters = valid();
    endless(&mut parameters.links[1]);
    let arm = Serial::new(parameters).unwrap();
    assert_eq!(arm.joint_kinds()[1], JointKind::Continuous);
    assert_eq!(arm.wraps(), [false, true, false]);
    assert_eq!(arm.without_friction().wraps(), arm.wraps());
    let body = Inertia::point_mass(0.5, Vector3::new(0.0, 0.1, 0.2));
    assert_eq!(arm.with_payload(&body).unwrap().wraps(), arm.wraps());
    let refused = |change: fn(&mut JointLimits)| {
        refusal(|link| {
            endless(link);
            change(&mut link.limits);
        })
    };
    assert_eq!(refused(|limits| limits.lower = -1.0), outside("limits.lower"));
    assert_eq!(refused(|limits| limits.upper = 7.0), outside("limits.upper"));
}

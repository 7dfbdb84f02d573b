//! A reference against an arm's limits: which joint, when, by how much.

use nalgebra::{Matrix3, Vector3};
use steadyarm::Error;
use steadyarm::arm::{
    Inertia, JointKind, JointLimits, JointStop, Link, Pose, Serial, SerialParameters,
};
use steadyarm::design::{Bound, check_limits};
use steadyarm::reference::{Quintic, Setpoint};

/// A wheel of 2 kg·m² about an upright axis, whose torque is 2 q̈, and a sled of 3 kg upright on
/// it, whose force is 3 (s̈ + 9.81).
fn arm(limits: [JointLimits; 2]) -> Serial<2> {
    let moments = Matrix3::from_diagonal(&[2.0, 2.0, 2.0].into());
    let wheel = Inertia { mass: 1.0, com: Vector3::zeros(), moments };
    let sled = Inertia::point_mass(3.0, Vector3::zeros());
    let link = |kind, inertia, limits| {
        let link = Link::new(kind, Pose::IDENTITY, Vector3::z(), inertia);
        Link { limits, ..link }
    };
    let links =
        [link(JointKind::Revolute, wheel, limits[0]), link(JointKind::Prismatic, sled, limits[1])];
    let (tip, gravity) = (Pose::IDENTITY, [0.0, 0.0, -9.81]);
    Serial::new(SerialParameters { links, tip, gravity }).unwrap()
}

fn limits(lower: f64, upper: f64, velocity: f64, effort: f64) -> JointLimits {
    JointLimits { lower, upper, velocity, effort }
}

fn close(got: f64, wanted: f64) {
    assert!((got - wanted).abs() < 1e-9 * wanted.abs().max(1.0), "got {got}, wanted {wanted}");
}

/// The quintic over D in T peaks at 15/8 D/T in the middle, and at 10/√3 D/T² where s = ½ − √3/6
/// (Flash and Hogan 1985).
#[test]
fn quintic_that_is_too_fast_is_told_joint_time_and_size() {
    let arm = arm([limits(-2.0, 2.0, 3.0, 40.0), JointLimits::NONE]);
    let path = Quintic::new([0.0; 2], [1.0, 0.0], 0.0, 0.1).unwrap();
    let check = check_limits(&arm, &path, 0.2, 1e-4).unwrap();
    assert!(!check.is_within());
    let found: Vec<_> = check.excesses().collect();
    assert_eq!(found.iter().map(|e| e.bound).collect::<Vec<_>>(), [Bound::Velocity, Bound::Effort]);
    assert!(found.iter().all(|e| e.joint == 0 && e.kind == JointKind::Revolute));
    let [velocity, effort] = [found[0], found[1]];
    close(velocity.value, 18.75);
    close(velocity.time, 0.05);
    close(velocity.by(), 15.75);
    // 30 s²(1 − s)² 10 > 3 from s = 0.11269 on: s (1 − s) = 0.1.
    let s = 0.5 - (0.25_f64 - 0.1).sqrt();
    assert!(velocity.first - 0.1 * s > 0.0 && velocity.first - 0.1 * s <= 1e-4);
    // Sampled at whole tenths of milliseconds, the peak is missed by less than 1e-5 of it.
    let peak = 2.0 * 10.0 / 3.0_f64.sqrt() * 100.0;
    assert!(effort.value.abs() <= peak && effort.value.abs() > peak * (1.0 - 1e-5));
    assert_eq!(effort.limit, 40.0);
    let said = velocity.to_string();
    for words in ["velocity 18.7500 rad/s at t = 0.0500 s", "15.7500 beyond", "6.250 times"] {
        assert!(said.contains(words), "{said}");
    }
}

#[test]
fn positions_count_at_both_ends() {
    let arm = arm([limits(-1.0, 2.0, f64::INFINITY, f64::INFINITY), JointLimits::NONE]);
    let at = |q: f64| check_limits(&arm, &|_: f64| Setpoint::at_rest([q, 0.0].into()), 0.0, 1.0);
    for inside in [-1.0, 2.0, 0.5, 2.0 + 1e-12] {
        assert!(at(inside).unwrap().is_within());
    }
    for (q, limit, by) in [(2.25, 2.0, 0.25), (-1.5, -1.0, 0.5)] {
        let check = at(q).unwrap();
        let found: Vec<_> = check.excesses().collect();
        assert_eq!((found.len(), found[0].bound), (1, Bound::Position));
        assert_eq!((found[0].limit, found[0].value, found[0].time), (limit, q, 0.0));
        close(found[0].by(), by);
    }
    // The worse of two.
    let sweep = |t: f64| Setpoint::at_rest([4.0 * t - 2.0, 0.0].into());
    let check = check_limits(&arm, &sweep, 1.0, 0.25).unwrap();
    let worst = *check.excesses().next().unwrap();
    assert_eq!((worst.value, worst.time, worst.first), (-2.0, 0.0, 0.0));
}

/// Holding 3 kg takes 29.43 N, at rest as well.
#[test]
fn weight_counts_as_effort() {
    let rest = |_: f64| Setpoint::at_rest([0.0; 2].into());
    for (effort, within) in [(29.44, true), (29.42, false)] {
        let arm = arm([JointLimits::NONE, limits(-1.0, 1.0, 1.0, effort)]);
        let check = check_limits(&arm, &rest, 1.0, 0.1).unwrap();
        assert_eq!(check.is_within(), within);
        let Some(excess) = check.excesses().next() else { continue };
        assert_eq!((excess.joint, excess.bound, excess.time), (1, Bound::Effort, 0.0));
        close(excess.value, 29.43);
        assert!(excess.to_string().contains(" N at"), "{excess}");
    }
}

/// A stop does not push where the position is reported.
#[test]
fn stops_are_no_effort() {
    let free = arm([limits(-1.0, 1.0, 1.0, 10.0), JointLimits::NONE]);
    let stop = JointStop { stiffness: 1e6, dissipation: 1.0 };
    let stopped = free.with_stops(&[stop; 2]).unwrap();
    let out = |_: f64| Setpoint::at_rest([1.5, 0.0].into());
    let check = |arm| check_limits(arm, &out, 0.0, 1.0).unwrap();
    assert_eq!(check(&free), check(&stopped));
    assert_eq!(check(&free).excesses().count(), 1);
}

#[test]
fn last_time_is_the_duration() {
    let arm = arm([limits(-1.0, 1.0, f64::INFINITY, f64::INFINITY), JointLimits::NONE]);
    let late = |t: f64| Setpoint::at_rest([if t >= 0.95 { 1.5 } else { 0.0 }, 0.0].into());
    let check = |duration| check_limits(&arm, &late, duration, 0.1).unwrap();
    assert_eq!(check(0.95).excesses().next().unwrap().time, 0.95);
    assert!(check(0.94).is_within());
}

#[test]
fn what_cannot_be_looked_at_is_refused_by_name() {
    let arm = arm([JointLimits::NONE; 2]);
    let rest = |_: f64| Setpoint::at_rest([0.0; 2].into());
    let name = |refused: Result<_, Error>| refused.unwrap_err().parameter();
    for bad in [f64::NAN, f64::INFINITY, -1.0] {
        assert_eq!(name(check_limits(&arm, &rest, bad, 0.1)), "duration");
        assert_eq!(name(check_limits(&arm, &rest, 1.0, bad)), "dt");
    }
    assert_eq!(name(check_limits(&arm, &rest, 1.0, 0.0)), "dt");
    assert_eq!(name(check_limits(&arm, &rest, 1.0, 1e-8)), "dt");
    let lost = |t: f64| Setpoint::at_rest([0.0, if t > 0.5 { f64::NAN } else { 0.0 }].into());
    assert_eq!(name(check_limits(&arm, &lost, 1.0, 0.1)), "reference");
    let fast = |_: f64| Setpoint { ddq: [1e308; 2].into(), ..rest(0.0) };
    assert_eq!(name(check_limits(&arm, &fast, 1.0, 0.1)), "reference");
}

//! The arms that ship: equal to the published tables bit for bit, and with the published figures.

use std::f64::consts::FRAC_PI_4;

use steadyarm::robot::{Convention, Description, GRAVITY, SHIPPED, shipped};

use super::dynamics::{frames, gravity, mass_matrix};
use super::tables;
use crate::random::Random;

#[test]
fn files_are_the_published_tables_bit_for_bit() {
    assert_eq!(shipped("panda").unwrap(), tables::panda());
    assert_eq!(shipped("puma560").unwrap(), tables::puma());
    assert_eq!(shipped("ur5e").unwrap(), tables::ur5e());
}

#[test]
fn files_name_their_source() {
    for name in SHIPPED {
        let path = format!("{}/python/steadyarm/arms/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(path).unwrap();
        assert!(text.starts_with('#') && text.contains("# Sources\n"), "{name}");
        assert_eq!(Description::from_toml(&text), shipped(name));
    }
}

#[test]
fn unknown_name_lists_the_known() {
    let message = shipped("pr2").unwrap_err().to_string();
    assert!(message.contains("\"pr2\"") && message.contains("\"puma560\""), "{message}");
}

/// Reach at q = 0: a₂ + a₃ back, d₄ + d₆ aside, d₁ − d₅ up (Universal Robots' table).
#[test]
fn ur5e_reaches_as_published() {
    let tip = frames(&shipped("ur5e").unwrap(), &[0.0; 6]).1.1;
    let wanted = [-0.425 - 0.3922, -0.1333 - 0.0996, 0.1625 - 0.0997];
    assert!((tip - nalgebra::Vector3::from(wanted)).amax() < 1e-15, "{tip}");
}

/// At q = 0 Franka's flange stands 0.088 m ahead and 0.333 + 0.316 + 0.384 − 0.107 m up, pointing
/// down.
#[test]
fn panda_reaches_as_published() {
    let tip = frames(&shipped("panda").unwrap(), &[0.0; 7]).1;
    assert!((tip.1 - nalgebra::Vector3::new(0.088, 0.0, 0.926)).amax() < 1e-15, "{}", tip.1);
    assert!((tip.0 * nalgebra::Vector3::z() + nalgebra::Vector3::z()).amax() < 1e-15);
}

/// At q = 0 the Puma's wrist stands a₂ + a₃ ahead, d₃ aside and d₄ up (Corke's qz).
#[test]
fn puma_reaches_as_published() {
    let tip = frames(&shipped("puma560").unwrap(), &[0.0; 6]).1.1;
    assert!(
        (tip - nalgebra::Vector3::new(0.4318 + 0.0203, -0.15005, 0.4318)).amax() < 1e-15,
        "{tip}"
    );
}

/// Corke's nominal pose.
const QN: [f64; 6] = [0.0, FRAC_PI_4, std::f64::consts::PI, 0.0, FRAC_PI_4, 0.0];
/// His figures have four decimals.
const FOUR_DECIMALS: f64 = 0.51e-4;

#[test]
fn puma_has_corkes_gravity_torques() {
    let mut arm = shipped("puma560").unwrap();
    let wanted = [0.0, 31.6399, 6.0351, 0.0, 0.0283, 0.0];
    let got = gravity(&arm, &QN);
    assert!((got - nalgebra::DVector::from_row_slice(&wanted)).amax() < FOUR_DECIMALS);
    arm.gravity = [0.0; 3];
    assert_eq!(gravity(&arm, &QN).amax(), 0.0);
}

/// His mass matrix in that pose, with the rotors.
#[test]
fn puma_has_corkes_mass_matrix() {
    #[rustfmt::skip]
    let wanted = [
        3.6594, -0.4044, 0.1006, -0.0025, 0.0, 0.0,
        -0.4044, 4.4137, 0.3509, 0.0, 0.0024, 0.0,
        0.1006, 0.3509, 0.9378, 0.0, 0.0015, 0.0,
        -0.0025, 0.0, 0.0, 0.1925, 0.0, 0.0,
        0.0, 0.0024, 0.0015, 0.0, 0.1713, 0.0,
        0.0, 0.0, 0.0, 0.0, 0.0, 0.1941,
    ];
    let got = mass_matrix(&shipped("puma560").unwrap(), &QN);
    assert!((got - nalgebra::DMatrix::from_row_slice(6, 6, &wanted)).amax() < FOUR_DECIMALS);
}

/// The published moments are none of rigid bodies; moving a part from link 3 to link 2 changes no
/// torque.
#[test]
fn puma_made_of_bodies_moves_as_the_published_one() {
    let arm = shipped("puma560").unwrap();
    let rows = tables::puma_rows();
    let refused = Description::from_dh("Puma", &rows, Convention::Standard, GRAVITY);
    assert!(refused.is_err());
    let mut published = arm.clone();
    for (joint, row) in published.joints.iter_mut().zip(&rows) {
        // T_x(a) R_x(α), as everywhere; only the moments differ.
        let r = nalgebra::Rotation3::from_axis_angle(&nalgebra::Vector3::x_axis(), row.alpha);
        joint.link.inertia.moments = r * row.inertia.moments * r.inverse();
        joint.link.inertia.mass = row.inertia.mass;
    }
    let mut random = Random(5);
    for _ in 0..100 {
        let q: [f64; 6] = std::array::from_fn(|_| random.between(-3.0, 3.0));
        let (a, b) = (mass_matrix(&arm, &q), mass_matrix(&published, &q));
        assert!((a - b).amax() < 1e-12);
        assert!((gravity(&arm, &q) - gravity(&published, &q)).amax() < 1e-12);
    }
}

/// Heights and width of the sigmoid that was identified, but for its shift: far from standstill
/// they agree.
#[test]
fn panda_has_the_identified_friction_at_speed() {
    let sigmoid = |x: f64| 1.0 / (1.0 + (-x).exp());
    let phi = [0.54615, 5.1181, 0.039533];
    let identified =
        |dq: f64| phi[0] * (sigmoid(phi[1] * (dq + phi[2])) - sigmoid(phi[1] * phi[2]));
    let friction = shipped("panda").unwrap().joints[0].link.friction;
    assert!((identified(10.0) - friction.coulomb[0]).abs() < 1e-9);
    assert!((identified(-10.0) + friction.coulomb[1]).abs() < 1e-9);
    // tanh 1 = 0.76: the rise from one height to the other.
    let rise = identified(friction.smoothing - phi[2]) - identified(-friction.smoothing - phi[2]);
    assert!((rise - phi[0] * 1.0_f64.tanh()).abs() < 1e-12);
}

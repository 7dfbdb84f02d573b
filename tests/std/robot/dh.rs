//! Denavit-Hartenberg tables: both conventions against the transforms of their definition, and
//! against each other.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use steadyarm::arm::JointKind;
use steadyarm::robot::{Convention, Description, DhRow, GRAVITY};

use super::dynamics::{frames, gravity, mass_matrix};
use super::tables::inertia;
use crate::random::Random;

/// Rounding of a chain of seven transforms of size 1.
const ROUNDING: f64 = 1e-13;

fn turn(axis: Vector3<f64>, angle: f64) -> Isometry3<f64> {
    Isometry3::from_parts(Translation3::identity(), UnitQuaternion::from_scaled_axis(axis * angle))
}

fn shift(axis: Vector3<f64>, by: f64) -> Isometry3<f64> {
    Isometry3::from_parts(Translation3::from(axis * by), UnitQuaternion::identity())
}

/// ⁱ⁻¹Tᵢ by its definition.
fn transform(row: &DhRow, convention: Convention, q: f64) -> Isometry3<f64> {
    let (x, z) = (Vector3::x(), Vector3::z());
    let (theta, d) = match row.kind {
        JointKind::Revolute | JointKind::Continuous => (row.theta_offset + q, row.d),
        JointKind::Prismatic => (row.theta_offset, row.d + q),
    };
    match convention {
        Convention::Standard => turn(z, theta) * shift(z, d) * shift(x, row.a) * turn(x, row.alpha),
        Convention::Modified => turn(x, row.alpha) * shift(x, row.a) * turn(z, theta) * shift(z, d),
    }
}

fn random_rows(random: &mut Random, n: usize) -> Vec<DhRow> {
    let row = |index: usize| {
        let kind = if index % 3 == 1 { JointKind::Prismatic } else { JointKind::Revolute };
        let mut any = || random.between(-1.0, 1.0);
        let com = [any(), any(), any()];
        let moments = [1.3 + 0.2 * any(), 1.2, 1.1, 0.1 * any(), 0.1 * any(), 0.1 * any()];
        let inertia = inertia(2.0 + any(), com, moments);
        let (a, alpha, d) = (any(), 3.0 * any(), any());
        DhRow { kind, a, alpha, d, theta_offset: 3.0 * any(), inertia, ..Default::default() }
    };
    (0..n).map(row).collect()
}

#[test]
fn frames_are_those_of_the_definition() {
    let mut random = Random(1);
    for round in 0..200 {
        let convention = [Convention::Standard, Convention::Modified][round % 2];
        let rows = random_rows(&mut random, 1 + round % 7);
        let arm = Description::from_dh("any", &rows, convention, GRAVITY).unwrap();
        let q: Vec<f64> = rows.iter().map(|_| random.between(-3.0, 3.0)).collect();
        let wanted = rows.iter().zip(&q).map(|(row, &q)| transform(row, convention, q));
        let wanted = wanted.fold(Isometry3::identity(), |frame, next| frame * next);
        let (_, tip) = frames(&arm, &q);
        assert!((tip.1 - wanted.translation.vector).amax() < ROUNDING);
        assert!((tip.0 - wanted.rotation.to_rotation_matrix().matrix()).amax() < ROUNDING);
    }
}

#[test]
fn masses_stand_where_the_tables_frames_are() {
    let mut random = Random(2);
    for round in 0..200 {
        let convention = [Convention::Standard, Convention::Modified][round % 2];
        let rows = random_rows(&mut random, 6);
        let arm = Description::from_dh("any", &rows, convention, GRAVITY).unwrap();
        let q: Vec<f64> = rows.iter().map(|_| random.between(-3.0, 3.0)).collect();
        let (links, _) = frames(&arm, &q);
        let mut frame = Isometry3::identity();
        for ((row, joint), (link, &q)) in rows.iter().zip(&arm.joints).zip(links.iter().zip(&q)) {
            frame *= transform(row, convention, q);
            let inertia = &joint.link.inertia;
            let r = *frame.rotation.to_rotation_matrix().matrix();
            let wanted = r * row.inertia.com + frame.translation.vector;
            assert!((link.0 * inertia.com + link.1 - wanted).amax() < ROUNDING);
            let (got, wanted) = (
                link.0 * inertia.moments * link.0.transpose(),
                r * row.inertia.moments * r.transpose(),
            );
            assert!((got - wanted).amax() < ROUNDING);
        }
    }
}

/// The same Puma in the two conventions: Craig's rows hold the a and α of the row before, and its
/// frames i are ours; a link's mass distribution is moved by T_x(a) R_x(α).
#[test]
fn standard_and_modified_tables_of_the_puma_are_the_same_arm() {
    let standard = super::tables::puma_bodies();
    let mut modified = standard;
    for i in 0..6 {
        let (a, alpha) =
            if i == 0 { (0.0, 0.0) } else { (standard[i - 1].a, standard[i - 1].alpha) };
        (modified[i].a, modified[i].alpha) = (a, alpha);
        let frame = shift(Vector3::x(), standard[i].a) * turn(Vector3::x(), standard[i].alpha);
        let r = *frame.rotation.to_rotation_matrix().matrix();
        let moments = r * standard[i].inertia.moments * r.transpose();
        modified[i].inertia.com = r * standard[i].inertia.com + frame.translation.vector;
        modified[i].inertia.moments = (moments + moments.transpose()) * 0.5;
    }
    let standard = Description::from_dh("s", &standard, Convention::Standard, GRAVITY).unwrap();
    let modified = Description::from_dh("m", &modified, Convention::Modified, GRAVITY).unwrap();
    let mut random = Random(3);
    for _ in 0..100 {
        let q: [f64; 6] = std::array::from_fn(|_| random.between(-3.0, 3.0));
        let (a, b) = (frames(&standard, &q).1, frames(&modified, &q).1);
        assert!((a.1 - b.1).amax() < ROUNDING && (a.0 - b.0).amax() < ROUNDING);
        assert!((mass_matrix(&standard, &q) - mass_matrix(&modified, &q)).amax() < 1e-12);
        assert!((gravity(&standard, &q) - gravity(&modified, &q)).amax() < 1e-12);
    }
}

#[test]
fn row_that_no_arm_has_is_refused_by_its_joint() {
    let row = DhRow {
        inertia: inertia(1.0, [0.0; 3], [1.0, 1.0, 1.0, 0.0, 0.0, 0.0]),
        ..Default::default()
    };
    let refused = |second: DhRow, words: [&str; 2]| {
        let error =
            Description::from_dh("x", &[row, second], Convention::Standard, GRAVITY).unwrap_err();
        let message = error.to_string();
        assert!(words.iter().all(|word| message.contains(word)), "{message}");
        assert!(message.contains("joint2"), "{message}");
    };
    refused(DhRow { d: f64::NAN, ..row }, ["d: got NaN", "finite"]);
    refused(DhRow { theta_offset: f64::INFINITY, ..row }, ["theta_offset: got inf", "finite"]);
    refused(DhRow { armature: -1.0, ..row }, ["armature", "-1"]);
    let broken = |moments| DhRow { inertia: inertia(1.0, [0.0; 3], moments), ..row };
    refused(broken([1.0, 1.0, 3.0, 0.0, 0.0, 0.0]), ["moments", "triangle inequality"]);
    refused(
        DhRow { inertia: inertia(-1.0, [0.0; 3], [1.0, 1.0, 1.0, 0.0, 0.0, 0.0]), ..row },
        ["mass", "-1"],
    );
    let none = Description::from_dh("x", &[], Convention::Standard, GRAVITY).unwrap_err();
    assert!(none.to_string().contains("joints: got none"));
}

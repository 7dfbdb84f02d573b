//! Merging: fixed links, side branches, and chains cut out of a robot.

use super::valid::{VALID, read};
use steadyarm::arm::Inertia;
use steadyarm::robot::{Description, GRAVITY};

/// Rounding of a dozen operations on numbers of size 1.
const ROUNDING: f64 = 1e-15;

fn with(addition: &str) -> String {
    VALID.replace("</robot>", &format!("{addition}</robot>"))
}

#[track_caller]
fn assert_close(got: &Inertia, wanted: &Inertia) {
    assert!((got.mass - wanted.mass).abs() < ROUNDING, "{got:?}\n{wanted:?}");
    assert!((got.com - wanted.com).amax() < ROUNDING, "{got:?}\n{wanted:?}");
    assert!((got.moments - wanted.moments).amax() < ROUNDING, "{got:?}\n{wanted:?}");
}

/// A block of 3 kg whose frame is shifted, and turned by a quarter about z.
const BLOCK: &str = r#"<link name="block"><inertial><origin xyz="0.1 0 0"/><mass value="3"/>
    <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.2" iyz="0" izz="0.25"/></inertial></link>
  <joint name="glue" type="TYPE"><origin xyz="0 0.2 0.4" rpy="0 0 1.5707963267948966"/>
    <parent link="tool"/><child link="block"/></joint>"#;

#[test]
fn fixed_links_are_merged_as_if_they_were_one() {
    let arm = read(&with(&BLOCK.replace("TYPE", "fixed"))).unwrap();
    // In the hand's frame: the hand 1 kg at 0; the block 3 kg at (0, 0.2, 0.05 + 0.4) + R (0.1, 0,
    // 0), R x = y.
    let com = nalgebra::Vector3::new(0.0, 0.3, 0.45);
    let merged = com * 0.75;
    let about = |m: f64, d: nalgebra::Vector3<f64>| {
        (nalgebra::Matrix3::identity() * d.dot(&d) - d * d.transpose()) * m
    };
    let block = nalgebra::Matrix3::from_diagonal(&nalgebra::Vector3::new(0.2, 0.1, 0.25));
    let hand = nalgebra::Matrix3::identity() * 0.01;
    let moments = hand + block + about(1.0, -merged) + about(3.0, com - merged);
    assert_close(&arm.joints[2].link.inertia, &Inertia { mass: 4.0, com: merged, moments });
    // The block is the new end, turned.
    assert!((arm.tip.translation - nalgebra::Vector3::new(0.0, 0.2, 0.45)).amax() < ROUNDING);
}

#[test]
fn masses_fixed_to_the_base_are_left_out() {
    let ballast = BLOCK.replace("TYPE", "fixed").replace("tool", "foot");
    let arm = Description::from_urdf(&with(&ballast), None, Some("tool"), GRAVITY).unwrap();
    assert_eq!(arm.joints, read(VALID).unwrap().joints);
}

/// A chain can be cut out of a robot whose other links are stated badly.
#[test]
fn masses_that_do_not_move_need_not_be_those_of_bodies() {
    let impossible = BLOCK.replace("TYPE", "fixed").replace("izz=\"0.25\"", "izz=\"9\"");
    let ballast = impossible.replace("tool", "foot");
    let arm = Description::from_urdf(&with(&ballast), None, Some("tool"), GRAVITY).unwrap();
    assert_eq!(arm.joints, read(VALID).unwrap().joints);
    let error = read(&with(&impossible)).unwrap_err().to_string();
    assert!(error.contains("link \"block\"") && error.contains("triangle"), "{error}");
}

#[test]
fn joints_beside_the_chain_are_held_at_zero_and_it_is_said() {
    let tip = |kind: &str| {
        let text = with(&BLOCK.replace("TYPE", kind));
        Description::from_urdf(&text, None, Some("tool"), GRAVITY).unwrap()
    };
    let (glued, held) = (tip("fixed"), tip("continuous"));
    assert_eq!(glued.joints, held.joints);
    assert_eq!(glued.tip, held.tip);
    let said: Vec<_> = held.notes.iter().filter(|note| note.contains("held at 0")).collect();
    assert_eq!(said.len(), 1);
    assert!(said[0].contains("\"glue\""), "{said:?}");
    assert!(!glued.notes.iter().any(|note| note.contains("held at 0")));
    // A gripper's second finger follows the first, which is no matter beside the chain.
    let mimic =
        BLOCK.replace("TYPE", "prismatic").replace("<parent", "<mimic joint=\"waist\"/><parent");
    let arm = Description::from_urdf(&with(&mimic), None, Some("tool"), GRAVITY).unwrap();
    assert_eq!(arm.joints, held.joints);
}

#[test]
fn joint_held_at_zero_without_mass_is_said() {
    let finger = "<link name=\"finger\"/><joint name=\"f\" type=\"prismatic\">\
                  <parent link=\"hand\"/><child link=\"finger\"/></joint>";
    let arm = Description::from_urdf(&with(finger), None, Some("tool"), GRAVITY).unwrap();
    let note = arm.notes.iter().find(|note| note.contains("massless")).unwrap();
    assert!(note.contains("\"finger\""), "{note}");
}

#[test]
fn chain_may_begin_and_end_anywhere() {
    let arm = Description::from_urdf(VALID, Some("trunk"), Some("hand"), GRAVITY).unwrap();
    let whole = read(VALID).unwrap();
    assert_eq!(arm.joints, whole.joints[1..]);
    assert_eq!(arm.tip.translation.as_slice(), [0.0; 3]);
    let stump = Description::from_urdf(VALID, None, Some("sled"), GRAVITY).unwrap();
    assert_eq!(stump.joints.len(), 2);
    assert_eq!(stump.joints[1].link.inertia.mass, 3.0);
    assert!(
        stump.notes.iter().any(|note| note.contains("held at 0") && note.contains("\"wrist\""))
    );
}

#[test]
fn ends_fixed_to_the_base_do_not_compete_for_the_tip() {
    let text = with(
        "<link name=\"mount\"/><joint name=\"m\" type=\"fixed\"><parent link=\"ground\"/>\
         <child link=\"mount\"/></joint>",
    );
    assert_eq!(read(&text).unwrap().joints, read(VALID).unwrap().joints);
}

#[test]
fn absent_limits_are_none_and_it_is_said() {
    let limit = "<limit lower=\"-1\" upper=\"2\" velocity=\"3\" effort=\"40\"/>";
    for (new, said) in
        [("", "states no <limit>"), ("<limit velocity=\"3\" effort=\"40\"/>", "lower and upper 0")]
    {
        let arm = read(&VALID.replace(limit, new)).unwrap();
        let limits = arm.joints[0].link.limits;
        assert_eq!([limits.lower, limits.upper], [f64::NEG_INFINITY, f64::INFINITY]);
        assert!(
            arm.notes[0].contains("\"waist\"") && arm.notes[0].contains(said),
            "{:?}",
            arm.notes
        );
    }
    let arm = read(&VALID.replace("upper=\"2\"", "upper=\"inf\"")).unwrap();
    assert_eq!(arm.joints[0].link.limits.upper, f64::INFINITY);
}

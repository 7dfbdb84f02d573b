//! Rotors: n² J_m of the tags that stand in a transmission, and what is said of the others.

use super::valid::{VALID, read};
use steadyarm::robot::Description;

/// The valid file with these elements in the wrist's actuator.
fn with(actuator: &str) -> Description {
    let from = VALID.find("      <mechanicalReduction>").unwrap();
    let to = VALID.find("    </actuator>").unwrap();
    read(&format!("{}{actuator}{}", &VALID[..from], &VALID[to..])).unwrap()
}

fn armature(arm: &Description) -> f64 {
    arm.joints[2].link.armature
}

/// The notes that are about the wrist's rotor.
fn said(arm: &Description) -> Vec<&String> {
    arm.notes.iter().filter(|note| note.contains("joint \"wrist\"")).collect()
}

const RATIO: &str = "<drake:gear_ratio value=\"160.0\"/>";
const ROTOR: &str = "<drake:rotor_inertia value=\"0.0001321\"/>";
const REDUCTION: &str = "<mechanicalReduction>1</mechanicalReduction>";
const MOTOR: &str = "<motorInertia>0.5</motorInertia>";

/// As in the 12 files of RobotLocomotion/models that state rotors; Drake's
/// `default_reflected_inertia`.
#[test]
fn drakes_tags_win_over_those_of_ros_in_any_order() {
    let wanted = 160.0 * 160.0 * 0.0001321;
    let orders = [
        [REDUCTION, RATIO, ROTOR],
        [ROTOR, REDUCTION, RATIO],
        [RATIO, ROTOR, REDUCTION],
        [ROTOR, RATIO, REDUCTION],
    ];
    for order in orders {
        for prefix in ["drake:", "", "d:"] {
            let arm = with(&order.concat().replace("drake:", prefix));
            assert_eq!(armature(&arm), wanted);
            let said = said(&arm);
            assert_eq!(said.len(), 1, "{said:?}");
            assert!(said[0].contains("<mechanicalReduction>") && said[0].contains("not used"));
        }
    }
}

#[test]
fn ratio_that_is_not_stated_is_one() {
    let arm = with(ROTOR);
    assert_eq!((armature(&arm), said(&arm).len()), (0.0001321, 0));
    let arm = with(MOTOR);
    assert_eq!((armature(&arm), said(&arm).len()), (0.5, 0));
    // Drake's rotor is not behind the gear of ROS.
    let arm = with(&format!("{ROTOR}<mechanicalReduction>50</mechanicalReduction>"));
    assert_eq!((armature(&arm), said(&arm).len()), (0.0001321, 1));
}

#[test]
fn a_ratio_of_drakes_without_its_rotor_leaves_that_of_ros_unused() {
    let arm = with(&format!("{RATIO}{MOTOR}"));
    assert_eq!(armature(&arm), 0.0);
    let said = said(&arm);
    assert!(said.len() == 1 && said[0].contains("<motorInertia>"), "{said:?}");
}

#[test]
fn what_agrees_is_not_noted() {
    let same =
        "<mechanicalReduction> 160 </mechanicalReduction><motorInertia>1.321e-4</motorInertia>";
    assert!(said(&with(&format!("{same}{RATIO}{ROTOR}"))).is_empty());
}

#[test]
fn what_is_left_over_is_noted() {
    let both = said(&with(&format!("{MOTOR}{RATIO}{ROTOR}{REDUCTION}"))).len();
    assert_eq!(both, 2);
    // Of two motors on a joint the first counts.
    let arm = with(&format!("{MOTOR}{MOTOR}"));
    assert_eq!((armature(&arm), said(&arm).len()), (0.5, 1));
    let unread = format!("{RATIO}{ROTOR}<mechanicalReduction>n/a</mechanicalReduction>");
    assert_eq!(said(&with(&unread)).len(), 1);
    let second = "<transmission><joint name=\"wrist\"/><motorInertia>1</motorInertia>\
                  </transmission></robot>";
    let arm = read(&VALID.replace("</robot>", second)).unwrap();
    assert_eq!((armature(&arm), said(&arm).len()), (2500.0 * 0.0002, 1));
    let two =
        VALID.replace("<joint name=\"wrist\"/>", "<joint name=\"wrist\"/><joint name=\"waist\"/>");
    let arm = read(&two).unwrap();
    assert_eq!((armature(&arm), said(&arm).len()), (0.0, 1));
}

#[test]
fn rotors_beside_the_chain_are_not_looked_at() {
    let other = VALID.replace("    <joint name=\"wrist\"/>", "    <joint name=\"elsewhere\"/>");
    let arm = read(&other.replace("<motorInertia>0.0002<", "<motorInertia>tiny<")).unwrap();
    assert_eq!(armature(&arm), 0.0);
}

#[test]
fn file_without_any_rotor_is_told() {
    let none = |arm: &Description| arm.notes.iter().any(|note| note.contains("no rotor inertia"));
    assert!(none(&with(REDUCTION)) && none(&with(RATIO)) && none(&with("")));
    assert!(!none(&with(MOTOR)));
}

//! What stands outside base and tip: it refuses nothing, and is told where it would have counted.

use super::valid::{VALID, read};
use steadyarm::robot::{Description, GRAVITY, ReadError};

fn cut(text: &str, base: Option<&str>, tip: Option<&str>) -> Result<Description, ReadError> {
    Description::from_urdf(text, base, tip, GRAVITY)
}

fn with(addition: &str) -> String {
    VALID.replace("</robot>", &format!("{addition}</robot>"))
}

/// A branch that hangs on `parent`, its joint's parts given, its link's as `inertial`.
fn branch(parent: &str, kind: &str, parts: &str, inertial: &str) -> String {
    with(&format!(
        "<link name=\"pan\"><inertial>{inertial}</inertial></link><joint name=\"pan_joint\" \
         type=\"{kind}\">\
         <parent link=\"{parent}\"/><child link=\"pan\"/>{parts}</joint>"
    ))
}

const GOOD: &str =
    "<mass value=\"3\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/>";

/// Parts of a joint that would be refused between base and tip.
const BAD_PARTS: [&str; 9] = [
    "<limit lower=\"1\" upper=\"1\"/>",
    "<limit lower=\"2.775\" upper=\"-2.775\"/>",
    "<limit lower=\"a\" upper=\"nan\" effort=\"-1\" velocity=\"-1\"/>",
    "<axis xyz=\"0 0 0\"/>",
    "<axis/>",
    "<axis xyz=\"1 0\"/>",
    "<dynamics damping=\"-1\" friction=\"x\"/>",
    "<mimic joint=\"waist\"/>",
    "<limit/><limit/>",
];

#[test]
fn bad_ranges_axes_and_friction_beside_the_chain_change_nothing() {
    let good = read(VALID).unwrap();
    for parts in BAD_PARTS {
        for kind in ["revolute", "prismatic", "floating", "planar"] {
            let text = branch("ground", kind, parts, GOOD);
            for base in [None, Some("ground"), Some("foot")] {
                let arm = cut(&text, base, Some("tool")).expect(parts);
                assert_eq!(arm.joints.len(), 3);
                assert_eq!(arm.joints[1..], good.joints[1..], "{parts}");
            }
            // On a link that moves the mass counts, and it is held at 0.
            let arm = cut(&branch("hand", kind, parts, GOOD), None, Some("tool")).expect(parts);
            assert_eq!(arm.joints[2].link.inertia.mass, 4.0, "{parts}");
        }
    }
}

#[test]
fn bad_masses_of_links_that_do_not_move_are_not_looked_at() {
    let good = read(VALID).unwrap();
    for inertial in ["", "<mass value=\"x\"/>", "<mass/>", "<mass value=\"-1\"/><inertia/>"] {
        let text = branch("foot", "revolute", "<origin xyz=\"a b c\"/>", inertial);
        let arm = cut(&text, None, Some("tool")).unwrap();
        assert_eq!((arm.joints, arm.notes), (good.joints.clone(), good.notes.clone()));
    }
}

#[test]
fn what_cannot_be_read_beyond_the_chain_is_left_out_and_told() {
    let good = read(VALID).unwrap();
    for (parts, inertial, word) in [
        ("", "", "without <mass>"),
        ("", "<mass value=\"x\"/><inertia/>", "<mass value>"),
        ("", "<mass value=\"1\"/>", "without <inertia>"),
        ("", "<mass value=\"1\"/><inertia ixx=\"nan\"/>", "<inertia ixx>"),
        ("<origin xyz=\"0 0\"/>", GOOD, "<origin xyz>"),
        ("<origin rpy=\"0 0 nan\"/>", GOOD, "<origin rpy>"),
        ("", "<mass value=\"${m}\"/><inertia/>", "xacro"),
    ] {
        for kind in ["fixed", "revolute"] {
            let text = branch("hand", kind, parts, inertial);
            let arm = cut(&text, None, Some("tool")).expect(word);
            assert_eq!(arm.joints, good.joints, "{word}");
            let told =
                arm.notes.iter().any(|note| note.contains("left out") && note.contains(word));
            assert!(told, "{word}: {:?}", arm.notes);
            // The same between base and tip.
            assert!(cut(&text, None, Some("pan")).unwrap_err().line.is_some(), "{word}");
        }
    }
}

#[test]
fn faulty_names_beside_a_named_chain_are_left_out_and_told() {
    let good = read(VALID).unwrap();
    let joint = |parts: &str| format!("<joint {parts}</joint><link name=\"pan\"/>");
    for (addition, word) in [
        ("<link/>".to_owned(), "without name"),
        ("<link name=\"foot\"/>".to_owned(), "given twice"),
        (
            joint("name=\"p\" type=\"screw\"><parent link=\"hand\"/><child link=\"pan\"/>"),
            "\"screw\"",
        ),
        (joint("name=\"p\"><parent link=\"hand\"/><child link=\"pan\"/>"), "without type"),
        (joint("type=\"fixed\"><parent link=\"hand\"/><child link=\"pan\"/>"), "without name"),
        (joint("name=\"p\" type=\"fixed\"><parent link=\"hand\"/>"), "no <child>"),
        (joint("name=\"p\" type=\"fixed\"><child link=\"pan\"/>"), "no <parent>"),
        (
            joint("name=\"p\" type=\"fixed\"><parent link=\"hand\"/><child link=\"lost\"/>"),
            "\"lost\"",
        ),
        (
            joint("name=\"lift\" type=\"fixed\"><parent link=\"hand\"/><child link=\"pan\"/>"),
            "given twice",
        ),
        (
            joint("name=\"p\" type=\"fixed\"><parent link=\"hand\"/><child link=\"foot\"/>"),
            "two parents",
        ),
    ] {
        let text = with(&addition);
        let arm = cut(&text, Some("foot"), Some("tool")).expect(word);
        assert_eq!(arm.joints[1..], good.joints[1..], "{word}");
        let told = arm.notes.iter().any(|note| note.contains("left out") && note.contains(word));
        assert!(told, "{word}: {:?}", arm.notes);
        // Without a tip the whole tree is asked for it.
        assert!(read(&text).unwrap_err().to_string().contains(word), "{word}");
    }
}

#[test]
fn loops_and_other_roots_beside_a_named_tip_change_nothing() {
    let good = read(VALID).unwrap();
    let selfish = "<link name=\"a\"/><joint name=\"s\" type=\"fixed\"><parent link=\"a\"/>\
                   <child link=\"a\"/></joint>";
    for addition in ["<link name=\"alone\"/>", selfish] {
        let arm = cut(&with(addition), None, Some("tool")).unwrap();
        assert_eq!(arm.joints, good.joints);
        let told = arm.notes.iter().any(|note| note.contains("root") && note.contains("\"alone\""));
        assert_eq!(told, addition != selfish);
    }
    // The base hangs on the tip's neighbour: what lies between is a chain all the same.
    let text = VALID.replacen("<parent link=\"ground\"/>", "<parent link=\"hand\"/>", 1);
    let error = cut(&text, Some("foot"), Some("tool")).unwrap_err().to_string();
    assert!(error.contains("loop"), "{error}");
}

/// A shoulder that names no parent must not cut the arm short.
#[test]
fn fault_between_root_and_tip_is_refused() {
    let text = VALID.replacen("<parent link=\"trunk\"/>", "<parent link=\"trunc\"/>", 1);
    for base in [None, Some("ground"), Some("foot")] {
        let error = cut(&text, base, Some("tool")).unwrap_err().to_string();
        assert!(error.contains("\"lift\"") && error.contains("\"trunc\""), "{error}");
    }
    assert_eq!(cut(&text, Some("sled"), Some("tool")).unwrap().joints.len(), 1);
}

#[test]
fn gravity_is_given_in_the_axes_of_the_root() {
    // The ground is turned by a quarter about x: the root's z is the foot's y.
    let turned = VALID.replacen(
        "<origin xyz=\"0 0 0.1\"/>",
        "<origin xyz=\"0 0 0.1\" rpy=\"1.5707963267948966 0 0\"/>",
        1,
    );
    let from = |base| cut(&turned, base, Some("tool")).unwrap();
    let (whole, cut) = (from(None), from(Some("foot")));
    assert_eq!((whole.gravity, cut.gravity), (GRAVITY, [0.0, -9.81, 0.0]));
    let told = |arm: &Description| arm.notes.iter().any(|note| note.contains("gravity"));
    assert!(told(&cut) && !told(&whole));
    // Both weigh the same: the sled's force along its axis is m g times its direction in the world.
    let torque = |arm: &Description| {
        use steadyarm::arm::{Arm, Serial, SerialParameters};
        let (links, tip, gravity) = (arm.links::<3>().unwrap(), arm.tip, arm.gravity);
        let arm = Serial::new(SerialParameters { links, tip, gravity }).unwrap();
        arm.gravity(&[0.3, 0.2, -0.4].into())
    };
    assert!((torque(&whole) - torque(&cut)).amax() < 1e-14 * 9.81 * 8.0);
    // A joint that moves before the base stands at 0 and turns it too.
    let arm = Description::from_urdf(VALID, Some("trunk"), None, [1.0, 0.0, -9.81]).unwrap();
    assert_eq!(arm.gravity, [0.0, -1.0, -9.81]);
    let note = arm.notes.iter().find(|note| note.contains("before the base stand at 0"));
    assert!(note.is_some_and(|note| note.contains("\"waist\"")), "{:?}", arm.notes);
}

#[test]
fn gripper_taken_as_the_last_joint_is_told() {
    let finger = |name: &str, upper: &str| {
        with(&format!(
            "<link name=\"pad\"><inertial>{GOOD}</inertial></link><joint name=\"{name}\" \
             type=\"prismatic\">\
             <parent link=\"tool\"/><child link=\"pad\"/><limit lower=\"0\" \
             upper=\"{upper}\"/></joint>"
        ))
    };
    let told = |arm: &Description| arm.notes.iter().any(|note| note.contains("gripper"));
    let arm = read(&finger("slide", "0.04")).unwrap();
    let note = arm.notes.iter().find(|note| note.contains("gripper")).unwrap();
    assert!(note.contains("\"slide\"") && note.contains("\"tool\""), "{note}");
    assert!(told(&read(&finger("Left_Finger", "0.5")).unwrap()));
    assert!(!told(&read(&finger("slide", "0.5")).unwrap()) && !told(&read(VALID).unwrap()));
    assert!(!told(&cut(&finger("slide", "0.04"), None, Some("pad")).unwrap()));
}

#[test]
fn absurd_sizes_are_told() {
    let hand = "<mass value=\"1\"/>\n      \
                <inertia ixx=\"0.01\" ixy=\"0\" ixz=\"0\" iyy=\"0.01\" iyz=\"0\" izz=\"0.01\"/>";
    assert!(VALID.contains(hand));
    let notes = |mass: f64, moment: f64| {
        let new = format!(
            "<mass value=\"{mass}\"/><inertia ixx=\"{moment}\" iyy=\"{moment}\" izz=\"{moment}\" \
             ixy=\"0\" ixz=\"0\" iyz=\"0\"/>"
        );
        let notes = read(&VALID.replacen(hand, &new, 1)).unwrap().notes;
        let size: Vec<_> =
            notes.into_iter().filter(|note| note.contains("taken as stated")).collect();
        assert!(size.iter().all(|note| note.contains("link \"hand\"")) && size.len() < 2);
        size.first().cloned().unwrap_or_default()
    };
    assert!(notes(97.7, 0.0).contains("densest"));
    // A ball of osmium, 22 590 kg/m³, of 1 kg: r = 0.021945 m, 2/5 m r² = 1.926e-4 kg m².
    assert!(notes(1.0, 1.90e-4).contains("densest") && notes(1.0, 1.95e-4).is_empty());
    let wide = notes(0.07, 0.07 * 6.5 * 6.5);
    assert!(wide.contains("radius of gyration") && !wide.contains("mm^2"), "{wide}");
    // A link of 2 kg and 0.1 m, 7e-3 kg m², written in kg mm².
    assert!(notes(2.0, 7e3).contains("kg mm^2"));
    assert!(notes(2.0, 7e-3).is_empty());
}

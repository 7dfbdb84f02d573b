//! The valid URDF with exactly one thing broken: the message names it, and the line.

use super::valid::{VALID, read};
use steadyarm::arm::{Arm, Serial, SerialParameters};
use steadyarm::robot::{Description, GRAVITY, ReadError};

/// The line, counted from 1, in which a piece first stands.
fn line_of(text: &str, piece: &str) -> usize {
    1 + text[..text.find(piece).unwrap()].matches('\n').count()
}

#[track_caller]
fn assert_says(error: &ReadError, line: Option<usize>, words: &[&str]) {
    let message = error.to_string();
    assert_eq!(error.line, line, "{message}");
    for word in words {
        assert!(message.contains(word), "{word:?} is not in: {message}");
    }
}

/// Replaces the first `old` and reads; the line is that in which `new` begins, or `at` in the
/// broken text.
#[track_caller]
fn refused_at(old: &str, new: &str, at: &str, words: &[&str]) {
    assert!(VALID.contains(old), "{old}");
    let text = VALID.replacen(old, new, 1);
    assert_says(&read(&text).unwrap_err(), Some(line_of(&text, at)), words);
}

#[track_caller]
fn refused(old: &str, new: &str, words: &[&str]) {
    refused_at(old, new, new, words);
}

#[test]
fn three_numbers_must_be_three_and_finite() {
    let wants = "three finite numbers";
    for xyz in
        ["0 0", "0 0 0 0", "", "0 0 x", "0 nan 0", "0 inf 0", "0 0 1e999", "0,1 0 0", "0 0 0.1 0.2"]
    {
        let new = format!("<origin xyz=\"{xyz}\"/>");
        let words = ["joint \"flange\"", "<origin xyz>", wants];
        refused("<origin xyz=\"0 0 0.05\"/>", &new, &words);
    }
    refused(
        "rpy=\"0.1 0.2 0.3\"",
        "rpy=\"0.1 0.2\"",
        &["\"wrist\"", "<origin rpy>", "\"0.1 0.2\"", wants],
    );
    refused("<axis xyz=\"0 1 0\"/>", "<axis xyz=\"0 1\"/>", &["\"wrist\"", "<axis xyz>", wants]);
    refused("<axis xyz=\"0 1 0\"/>", "<axis/>", &["\"wrist\"", "without xyz"]);
}

#[test]
fn axis_must_have_a_direction() {
    refused(
        "<axis xyz=\"0 1 0\"/>",
        "<axis xyz=\"0 0 0\"/>",
        &["\"wrist\"", "axis", "no direction"],
    );
}

#[test]
fn mass_must_be_a_number_and_positive() {
    for (mass, word) in [("-5", "-5"), ("nan", "\"nan\""), ("inf", "\"inf\""), ("5kg", "\"5kg\"")] {
        let new = format!("<mass value=\"{mass}\"/>");
        refused("<mass value=\"5\"/>", &new, &["link \"trunk\"", "<mass value>", word, "wants"]);
    }
    refused("<mass value=\"5\"/>", "<mass/>", &["\"trunk\"", "<mass> without value"]);
    refused_at("      <mass value=\"5\"/>\n", "", "<inertial>", &["\"trunk\"", "without <mass>"]);
}

#[test]
fn mass_of_zero_is_refused_on_a_link_that_moves() {
    let body = |mass: &str, moment: &str| {
        format!(
            "<mass value=\"{mass}\"/>\n      <inertia ixx=\"{moment}\" ixy=\"0\" ixz=\"0\" \
             iyy=\"{moment}\" iyz=\"0\" izz=\"{moment}\"/>"
        )
    };
    let (old, zero) = (&body("1", "0.01"), &body("0", "0"));
    refused_at(old, zero, "<link name=\"hand\">", &["link \"hand\"", "got 0", "> 0", "moves"]);
}

#[test]
fn moments_must_be_those_of_a_body() {
    let words = ["link \"trunk\"", "<inertia>", "triangle inequality", "kg m^2"];
    refused_at("izz=\"0.5\"", "izz=\"0.9\"", "izz=\"0.9\"", &words);
    refused("izz=\"0.5\"", "izz=\"-0.5\"", &["link \"trunk\"", "<inertia>", "wants none negative"]);
    refused(
        "izz=\"0.5\"",
        "izz=\"NaN\"",
        &["link \"trunk\"", "<inertia izz>", "\"NaN\"", "finite"],
    );
    refused_at(" izz=\"0.5\"", "", "<inertia ixx=\"0.3\"", &["\"trunk\"", "<inertia> without izz"]);
}

/// Files have −1e-20 kg m² where they mean none.
#[test]
fn moments_below_what_a_micrometre_changes_are_rounding() {
    let hand = "<inertia ixx=\"0.01\" ixy=\"0\" ixz=\"0\" iyy=\"0.01\" iyz=\"0\" izz=\"0.01\"/>";
    assert!(VALID.contains(hand));
    let with = |ixx: &str| {
        let new = format!(
            "<inertia ixx=\"{ixx}\" ixy=\"0\" ixz=\"0\" iyy=\"0\" iyz=\"0\" izz=\"1e-20\"/>"
        );
        read(&VALID.replacen(hand, &new, 1))
    };
    with("-1e-20").unwrap();
    let error = with("-1e-11").unwrap_err().to_string();
    assert!(error.contains("wants none negative"), "{error}");
}

/// The text without the inertial of the link.
fn without_inertial(link: &str) -> String {
    let link = VALID.find(&format!("<link name=\"{link}\">")).unwrap();
    let from = link + VALID[link..].find("    <inertial>").unwrap();
    let to = from + VALID[from..].find("</inertial>\n").unwrap() + "</inertial>\n".len();
    format!("{}{}", &VALID[..from], &VALID[to..])
}

#[test]
fn last_link_must_have_an_inertial() {
    let text = without_inertial("hand");
    let words = ["link \"hand\"", "no <inertial>", "moves", "inertials"];
    assert_says(&read(&text).unwrap_err(), Some(line_of(&text, "<link name=\"hand\">")), &words);
}

#[test]
fn link_between_joints_may_be_massless_and_it_is_said() {
    let arm = read(&without_inertial("trunk")).unwrap();
    let trunk = arm.joints[0].link.inertia;
    assert_eq!((trunk.mass.to_bits(), trunk.moments.amax()), (0, 0.0));
    let note = arm.notes.iter().find(|note| note.contains("massless")).unwrap();
    assert!(note.contains("\"trunk\"") && !note.contains("\"hand\""), "{note}");
    // The waist turns the sled and the hand, 0.1 m and more from its axis: M is positive definite.
    let (links, tip, gravity) = (arm.links::<3>().unwrap(), arm.tip, arm.gravity);
    let arm = Serial::new(SerialParameters { links, tip, gravity }).unwrap();
    assert!(arm.mass_matrix(&[0.0; 3].into())[(0, 0)] > 2.0 * 0.1 * 0.1);
}

#[test]
fn names_must_be_unique_and_stated() {
    refused("<link name=\"tool\"/>", "<link name=\"hand\"/>", &["link \"hand\"", "given twice"]);
    refused(
        "<joint name=\"flange\" type",
        "<joint name=\"wrist\"  type",
        &["joint \"wrist\"", "given twice"],
    );
    refused("<link name=\"tool\"/>", "<link/>", &["link", "without name"]);
    refused("<link name=\"tool\"/>", "<link name=\" \"/>", &["link", "empty name"]);
    let second = "<origin xyz=\"0 0 0.05\"/><origin/>";
    refused("<origin xyz=\"0 0 0.05\"/>", second, &["\"flange\"", "second <origin>"]);
}

#[test]
fn joint_must_join_links_that_exist() {
    let near = ["joint \"flange\"", "<parent>", "\"hnad\"", "near are \"hand\""];
    refused_at(
        "<parent link=\"hand\"/>",
        "<parent link=\"hnad\"/>",
        "<joint name=\"flange\"",
        &near,
    );
    let none = ["joint \"flange\"", "no <parent>"];
    refused_at("<parent link=\"hand\"/>", "", "<joint name=\"flange\"", &none);
    let no_link = ["joint \"flange\"", "<child> without link"];
    refused("<child link=\"tool\"/>", "<child/>", &no_link);
}

#[test]
fn type_of_a_joint_must_be_known() {
    refused_at(
        "type=\"continuous\"",
        "type=\"spherical\"",
        "type=\"spherical\"",
        &["\"wrist\"", "\"spherical\"", "revolute"],
    );
    refused(
        "<joint name=\"flange\" type=\"fixed\"",
        "<joint name=\"flange\"",
        &["\"flange\"", "without type"],
    );
}

#[test]
fn two_parents_are_refused() {
    let words = ["link \"trunk\"", "two parents", "\"waist\"", "\"flange\""];
    refused_at(
        "<child link=\"tool\"/>",
        "<child link=\"trunk\"/>",
        "<joint name=\"flange\"",
        &words,
    );
}

#[test]
fn loops_are_refused() {
    // The foot hangs on the tool: every link has a parent.
    let text = VALID.replacen("<parent link=\"ground\"/>", "<parent link=\"tool\"/>", 1);
    let text = text.replacen("<link name=\"ground\"/>\n", "", 1);
    assert_says(&read(&text).unwrap_err(), Some(line_of(&text, "<link name=\"foot\">")), &["loop"]);
    // Beside a tree, a link that hangs on itself.
    let selfish = "<link name=\"a\"/><joint name=\"s\" type=\"fixed\"><parent link=\"a\"/>\
                   <child link=\"a\"/></joint></robot>";
    refused("</robot>", selfish, &["joint \"s\"", "loop"]);
}

#[test]
fn two_roots_are_refused() {
    refused(
        "<link name=\"ground\"/>",
        "<link name=\"ground\"/><link name=\"alone\"/>",
        &["2 without a parent", "\"ground\"", "\"alone\""],
    );
}

#[test]
fn base_and_tip_must_be_links() {
    let read = |base, tip| Description::from_urdf(VALID, base, tip, GRAVITY).unwrap_err();
    assert_says(&read(Some("Trunc"), None), None, &["base", "\"Trunc\"", "near are \"trunk\""]);
    assert_says(&read(None, Some("tool0")), None, &["tip", "\"tool0\"", "near are \"tool\""]);
    assert_says(&read(None, Some("qqqqqq")), None, &["tip", "\"qqqqqq\"", "there are \"ground\""]);
    assert_says(
        &read(Some("hand"), Some("trunk")),
        None,
        &["tip", "\"trunk\"", "does not hang", "\"hand\""],
    );
    assert_says(&read(Some("hand"), None), None, &["none that moves", "\"hand\""]);
    assert_says(
        &read(None, Some("foot")),
        None,
        &["none that moves between", "\"ground\"", "\"foot\""],
    );
}

#[test]
fn several_ends_are_listed() {
    let gripper = "<link name=\"camera\"/><joint name=\"c\" type=\"fixed\"><parent link=\"sled\"/>\
                   <child link=\"camera\"/></joint></robot>";
    let text = VALID.replace("</robot>", gripper);
    let words = ["tip", "2 ends", "\"camera\" (2 joints)", "\"tool\" (3 joints)"];
    assert_says(&read(&text).unwrap_err(), None, &words);
}

#[test]
fn joints_without_a_motor_of_their_own_are_refused_on_the_chain() {
    let mimic = "<axis xyz=\"0 1 0\"/><mimic joint=\"waist\"/>";
    refused("<axis xyz=\"0 1 0\"/>", mimic, &["joint \"wrist\"", "<mimic>", "follows"]);
    for kind in ["floating", "planar"] {
        let new = format!("type=\"{kind}\"");
        refused("type=\"continuous\"", &new, &["joint \"wrist\"", kind, "base and tip"]);
    }
}

#[test]
fn limits_must_leave_a_range() {
    let wants = ["joint \"waist\"", "<limit>", "lower 3", "upper 2", "lower <= upper"];
    refused("lower=\"-1\"", "lower=\"3\"", &wants);
    refused("velocity=\"3\"", "velocity=\"-3\"", &["\"waist\"", "<limit velocity>", "-3", ">= 0"]);
    refused("effort=\"40\"", "effort=\"nan\"", &["\"waist\"", "<limit effort>", "\"nan\""]);
    refused(
        "damping=\"0.5\"",
        "damping=\"-0.5\"",
        &["\"waist\"", "<dynamics damping>", "-0.5", ">= 0"],
    );
    refused(
        "friction=\"0.25\"",
        "friction=\"inf\"",
        &["\"waist\"", "<dynamics friction>", "\"inf\""],
    );
}

#[test]
fn rotor_must_be_a_number() {
    refused(
        "<motorInertia>0.0002<",
        "<motorInertia>tiny<",
        &["transmission", "<motorInertia>", "\"tiny\""],
    );
    refused("<motorInertia>0.0002<", "<motorInertia>-1<", &["transmission", "rotor of -1", ">= 0"]);
    refused_at(
        "    <joint name=\"wrist\"/>\n",
        "",
        "<transmission",
        &["transmission", "exactly one <joint>"],
    );
}

#[test]
fn what_is_not_a_urdf_is_refused() {
    assert_says(
        &read("robots/ur5.urdf").unwrap_err(),
        None,
        &["robots/ur5.urdf", "function for files"],
    );
    assert_says(&read("<mujoco/>").unwrap_err(), Some(1), &["\"mujoco\"", "wants <robot>"]);
    assert_says(&read("<robot/>").unwrap_err(), Some(1), &["no <link>"]);
    let xacro = "<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\">\n<xacro:arg/></robot>";
    assert_says(&read(xacro).unwrap_err(), Some(2), &["xacro"]);
    let unclosed = VALID.replace("</robot>\n", "");
    let last = Some(1 + unclosed.matches('\n').count());
    assert_says(&read(&unclosed).unwrap_err(), last, &["not well-formed XML"]);
    refused_at(
        "<link name=\"tool\"/>",
        "<link name=\"tool\">",
        "</robot>",
        &["not well-formed XML"],
    );
    refused("<link name=\"tool\"/>", "<link name=tool/>", &["not well-formed XML"]);
}

#[test]
fn numbers_that_overflow_together_are_refused() {
    let huge = "xyz=\"0 0 1e308\"";
    let text = VALID.replace("xyz=\"0 0 0.2\"", huge).replace("xyz=\"0 0 0.1\"", huge);
    let words = ["joint \"waist\"", "placement", "inf", "finite"];
    assert_says(&read(&text).unwrap_err(), Some(line_of(&text, "<joint name=\"waist\"")), &words);
}

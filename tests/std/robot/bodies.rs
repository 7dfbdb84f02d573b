//! Mass distributions: one rule for every way in, asked of what moves together, and three answers
//! to what no body is.

use std::fmt::Write;

use nalgebra::Matrix3;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use steadyarm::arm::{
    Arm, Inertia, JointFriction, Perturbation, Serial, SerialParameters, Unphysical,
};
use steadyarm::math::Vector;
use steadyarm::robot::{Convention, Description, DhRow, GRAVITY, ReadError, UrdfOptions};

use super::tables::inertia;
use super::valid::{VALID, read};

const POLICIES: [Unphysical; 3] = [Unphysical::Refuse, Unphysical::Note, Unphysical::Nearest];
/// Where the trunk's inertia is stated, which no body has with an izz of 0.9: 0.9 > 0.3 + 0.4.
const IMPOSSIBLE: [&str; 2] = ["izz=\"0.5\"", "izz=\"0.9\""];

fn taking(text: &str, unphysical: Unphysical) -> Result<Description, ReadError> {
    Description::from_urdf_with(text, &UrdfOptions { unphysical, ..UrdfOptions::default() })
}

/// VALID with a link of this inertia fixed to its hand.
fn with_part(mass: &str, moments: &str) -> String {
    let part = format!(
        "<link name=\"part\"><inertial><mass value=\"{mass}\"/><inertia {moments}/></inertial>\
         </link><joint name=\"glue\" type=\"fixed\"><parent link=\"hand\"/><child link=\"part\"/>\
         </joint></robot>"
    );
    VALID.replace("</robot>", &part)
}

fn read_with_part(mass: &str, moments: &str) -> Result<Description, ReadError> {
    Description::from_urdf(&with_part(mass, moments), None, Some("tool"), GRAVITY)
}

fn notes_of<'a>(arm: &'a Description, link: &str) -> Vec<&'a String> {
    arm.notes.iter().filter(|note| note.contains(&format!("link \"{link}\""))).collect()
}

/// A dummy tool frame as the vendor's Sawyer has it, six times 1e-8, is no body; the hand with it
/// is one to 15 digits.
#[test]
fn part_that_is_no_body_is_read_as_part_of_one_and_noted() {
    let six = "ixx=\"1e-8\" ixy=\"1e-8\" ixz=\"1e-8\" iyy=\"1e-8\" iyz=\"1e-8\" izz=\"1e-8\"";
    let flat = "ixx=\"0\" ixy=\"0\" ixz=\"0\" iyy=\"0\" iyz=\"0\" izz=\"1e-4\"";
    let upside = "ixx=\"-1e-4\" ixy=\"0\" ixz=\"0\" iyy=\"-1e-4\" iyz=\"0\" izz=\"-1e-4\"";
    let hand = read(VALID).unwrap().joints[2].link.inertia;
    for (mass, moments, size) in
        [("1e-8", six, 1e-7), ("0", flat, 2e-4), ("1e-3", upside, 1e-3), ("-1e-3", flat, 1e-3)]
    {
        let arm = read_with_part(mass, moments).unwrap();
        let body = arm.joints[2].link.inertia;
        assert!((body.moments - hand.moments).amax() < size);
        let notes = notes_of(&arm, "part");
        assert_eq!(notes.len(), 1, "{:?}", arm.notes);
        assert!(notes[0].contains("no body has") && notes[0].contains("\"hand\""), "{notes:?}");
        body.validate().unwrap();
    }
    // A part that is a body says nothing.
    let ball = "ixx=\"1e-8\" ixy=\"0\" ixz=\"0\" iyy=\"1e-8\" iyz=\"0\" izz=\"1e-8\"";
    assert!(notes_of(&read_with_part("1e-8", ball).unwrap(), "part").is_empty());
}

/// Two parts, one of which lacks what the other has.
#[test]
fn merged_bodies_are_judged_by_their_sum() {
    let disc = "ixx=\"0.1\" ixy=\"0\" ixz=\"0\" iyy=\"0.1\" iyz=\"0\" izz=\"0.205\"";
    let arm = read_with_part("1", disc).unwrap();
    // (0.01 + 0.1, 0.01 + 0.1, 0.01 + 0.205): 0.215 <= 0.22.
    let wanted = Matrix3::from_diagonal(&[0.11, 0.11, 0.215].into());
    assert!((arm.joints[2].link.inertia.moments - wanted).amax() < 1e-15);
    let more = disc.replace("0.205", "0.3");
    let error = read_with_part("1", &more).unwrap_err();
    assert!(error.message.contains("link \"part\", <inertia>"), "{error}");
    assert!(error.message.contains("triangle"), "{error}");
}

#[test]
fn refusal_says_the_way_on() {
    let error = read(&VALID.replace(IMPOSSIBLE[0], IMPOSSIBLE[1])).unwrap_err();
    let line = 1 + VALID[..VALID.find(IMPOSSIBLE[0]).unwrap()].matches('\n').count();
    assert_eq!(error.line, Some(line));
    for word in ["link \"trunk\"", "unphysical = \"note\"", "\"nearest\""] {
        assert!(error.message.contains(word), "{error}");
    }
}

/// The trunk's moments become its nearest body's, or stay; the note has its size:
/// 0.9 − (0.3 + 0.4) = 0.2, but for the products of inertia.
#[test]
fn policies_take_what_they_say_and_note_it() {
    let text = VALID.replace(IMPOSSIBLE[0], IMPOSSIBLE[1]);
    let [valid, noted] = [VALID, &text].map(|text| taking(text, Unphysical::Note).unwrap());
    let nearest = taking(&text, Unphysical::Nearest).unwrap();
    let trunk = |arm: &Description| arm.joints[0].link.inertia;
    assert_eq!(trunk(&noted).moments[(2, 2)], 0.9);
    assert_eq!(trunk(&nearest), trunk(&noted).nearest().unwrap());
    assert!(notes_of(&valid, "trunk").is_empty());
    for (arm, words) in [
        (&noted, ["taken as stated", "no body has", "e-1 kg m^2 more than"]),
        (&nearest, ["taken as the nearest", "no body has", "e-1 kg m^2 more than"]),
    ] {
        let notes = notes_of(arm, "trunk");
        assert_eq!(notes.len(), 1);
        assert!(words.iter().all(|word| notes[0].contains(word)), "{notes:?}");
        let built: Serial<3> = arm.arm().unwrap();
        assert_eq!(built.unphysical(), arm.unphysical);
        assert!(Serial::<3>::new(*built.parameters()).is_ok() == (arm == &nearest));
    }
    // The same of a table and of our own format.
    let row = DhRow { inertia: trunk(&noted), ..DhRow::default() };
    let dh =
        |policy| Description::from_dh_taking("x", &[row], Convention::Standard, GRAVITY, policy);
    assert!(dh(Unphysical::Refuse).unwrap_err().message.contains("unphysical = \"note\""));
    assert_eq!(dh(Unphysical::Note).unwrap().joints[0].link.inertia, trunk(&noted));
    assert_eq!(dh(Unphysical::Nearest).unwrap().joints[0].link.inertia, trunk(&nearest));
    let file = noted.to_toml();
    assert!(file.contains("\nunphysical = \"note\"\n"));
    assert_eq!(Description::from_toml(&file).unwrap(), noted);
    let strict = file.replace("unphysical = \"note\"\n", "");
    let error = Description::from_toml(&strict).unwrap_err();
    assert!(error.message.contains("joint \"waist\", moments: got principal"), "{error}");
    assert!(error.line.is_some());
    assert!(Description::from_toml_taking(&file, Unphysical::Refuse).is_err());
    let taken = Description::from_toml_taking(&strict, Unphysical::Nearest).unwrap();
    assert_eq!(trunk(&taken), trunk(&nearest));
    let error = Description::from_toml(&file.replace("\"note\"\n", "\"ignore\"\n")).unwrap_err();
    assert!(error.message.contains("ignore") && error.message.contains("note"), "{error}");
}

/// An arm whose M is not positive definite cannot be simulated, whatever is taken; the joint is
/// named.
#[test]
fn mass_matrix_is_asked_for_by_any_policy() {
    let text = VALID.replace("izz=\"0.5\"", "izz=\"-50\"");
    for unphysical in [Unphysical::Note, Unphysical::Nearest] {
        let arm = taking(&text, unphysical).unwrap().arm::<3>();
        assert_eq!(arm.is_ok(), unphysical == Unphysical::Nearest);
        if let Err(error) = arm {
            assert!(error.message.contains("joint \"waist\", link \"trunk\""), "{error}");
            assert!(error.message.contains("inertia: got -"), "{error}");
        }
    }
}

/// A link of one joint in our own format, with this turn and this range.
fn one_joint(c: &str, range: &str) -> String {
    let mut text =
        String::from("format = 1\nname = \"one\"\n[[joint]]\nname = \"a\"\nlink = \"b\"\n");
    let _ = writeln!(text, "kind = \"revolute\"\naxis = [0.0, 0.0, 1.0]");
    let _ = writeln!(text, "rotation = [[{c}, -{c}, 0.0], [{c}, {c}, 0.0], [0.0, 0.0, 1.0]]");
    let _ = writeln!(text, "mass = 1.0\ncom = [0.1, 0.0, 0.0]\nlimits = {{ {range} }}");
    text + "moments = [[0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]]\n"
}

/// What our own format takes and what the arm takes is the same, on both sides of every bound.
#[test]
fn every_way_in_has_the_same_rule() {
    let usual = "lower = -1.0, upper = 1.0";
    for (c, range, taken) in [
        ("0.7071067811865476", usual, true),
        ("0.70710678", usual, true),
        ("0.7071068", usual, true),
        ("0.707107", usual, true),
        // Rows of length 1 + 1e-5.
        ("0.707114", usual, false),
        ("0.70711", usual, false),
        ("0.707107", "lower = 0.5, upper = 0.5", true),
        ("0.707107", "lower = 0.0, upper = -0.0", true),
        ("0.707107", "lower = 0.5, upper = 0.4999999999", false),
        ("0.707107", "lower = inf, upper = inf", false),
        ("0.707107", "lower = -inf, upper = -inf", false),
        ("0.707107", "velocity = inf, effort = inf", true),
        ("0.707107", "velocity = nan", false),
    ] {
        let read = Description::from_toml(&one_joint(c, range));
        assert_eq!(read.is_ok(), taken, "{c} {range} {read:?}");
        let Ok(arm) = read else { continue };
        let links = arm.links::<1>().unwrap();
        Serial::new(SerialParameters { links, tip: arm.tip, gravity: arm.gravity }).unwrap();
        assert_eq!(Description::from_toml(&arm.to_toml()).unwrap(), arm);
    }
    let limit = |lower: &str, upper: &str| {
        let new = format!("lower=\"{lower}\" upper=\"{upper}\"");
        read(&VALID.replace("lower=\"-1\" upper=\"2\"", &new))
    };
    let limits = limit("0.5", "0.5").unwrap().joints[0].link.limits;
    assert_eq!([limits.lower, limits.upper], [0.5; 2]);
    assert!(limit("0.5", "0.4").is_err());
}

/// A matrix that is not symmetric is a mistake, which averaging would hide.
#[test]
fn table_with_an_asymmetric_tensor_is_refused() {
    let mut row = DhRow {
        inertia: inertia(1.0, [0.0; 3], [0.3, 0.3, 0.3, 0.0, 0.0, 0.0]),
        a: 0.3,
        alpha: 1.0,
        ..DhRow::default()
    };
    row.inertia.moments[(0, 1)] = 0.02;
    for convention in [Convention::Standard, Convention::Modified] {
        for unphysical in POLICIES {
            let arm = Description::from_dh_taking("x", &[row], convention, GRAVITY, unphysical);
            let error = arm.unwrap_err();
            for word in ["joint \"joint1\"", "moments", "not symmetric"] {
                assert!(error.message.contains(word), "{error}");
            }
        }
    }
}

#[test]
fn notes_follow_the_links() {
    let text = VALID.replace(IMPOSSIBLE[0], IMPOSSIBLE[1]);
    let noted = taking(&text, Unphysical::Note).unwrap();
    let mut links = noted.links::<3>().unwrap();
    // Twice the moments lack twice as much: one note, of the new size.
    links[0].inertia.moments *= 2.0;
    let other = noted.with_links(links).unwrap();
    assert_eq!(other.notes.len(), noted.notes.len());
    assert_ne!(notes_of(&other, "trunk"), notes_of(&noted, "trunk"));
    // A body again: none.
    links[0].inertia.moments = Matrix3::identity();
    let body = noted.with_links(links).unwrap();
    assert!(notes_of(&body, "trunk").is_empty());
    assert_eq!(body.notes.len() + 1, noted.notes.len());
    links[0].armature = -1.0;
    let error = noted.with_links(links).unwrap_err();
    assert!(error.message.contains("joint \"waist\", armature: got -1"), "{error}");
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 200,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(2018),
        ..ProptestConfig::default()
    })]

    /// Any arm of any policy, loaded and perturbed, is the same after writing and reading, and
    /// moves the same.
    #[test]
    fn files_keep_the_policy_and_every_bit(
        moments in prop::array::uniform3(0.05..1.0_f64),
        products in prop::array::uniform3(-0.02..0.02_f64),
        mass in 0.1..3.0_f64,
        seed in any::<u64>(),
        policy in 0_usize..3,
    ) {
        let unphysical = POLICIES[policy];
        let [xx, yy, zz] = moments;
        let [xy, xz, yz] = products;
        let link = |scale: f64| DhRow {
            a: 0.3,
            alpha: 0.7,
            armature: 2.0,
            friction: JointFriction { viscous: 0.1, coulomb: [0.2, 0.3], ..Default::default() },
            inertia: inertia(mass, [0.1, 0.0, 0.2], [xx, yy, zz, xy, xz, yz].map(|i| i * scale)),
            ..DhRow::default()
        };
        let rows = [link(1.0), link(0.3), link(0.1)];
        let read =
            Description::from_dh_taking("any", &rows, Convention::Standard, GRAVITY, unphysical);
        let bodies = rows.iter().all(|row| row.inertia.validate().is_ok());
        prop_assert_eq!(read.is_ok(), bodies || unphysical != Unphysical::Refuse);
        let Ok(arm) = read else { return Ok(()) };
        let said = arm.notes.iter().filter(|note| note.contains("no body has")).count();
        prop_assert_eq!(said > 0, !bodies);
        let payload = Inertia::point_mass(0.5, [0.0, 0.1, 0.0].into());
        let by = Perturbation { mass: 0.1, com: 0.01, inertia: 0.1, friction: 0.1 };
        let built: Serial<3> = arm.arm().unwrap();
        let changed = built.with_payload(&payload).unwrap().perturb(seed, &by).unwrap();
        for (description, serial) in
            [(&arm, built), (&arm.with_links(*changed.links()).unwrap(), changed)]
        {
            let text = description.to_toml();
            let again = Description::from_toml(&text).unwrap();
            prop_assert_eq!(&again, description);
            prop_assert_eq!(again.to_toml(), text);
            let rebuilt: Serial<3> = again.arm().unwrap();
            prop_assert_eq!(&rebuilt, &serial);
            let q = Vector::<3>::new(0.1, -0.2, 0.3);
            prop_assert_eq!(rebuilt.mass_matrix(&q), serial.mass_matrix(&q));
        }
    }
}

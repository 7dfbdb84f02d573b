//! Masses and mass distributions that the caller gives for links of a URDF.

use crate::valid::VALID;
use nalgebra::{Matrix3, Vector3};
use steadyarm::arm::Inertia;
use steadyarm::robot::{Description, ReadError, UrdfOptions};

fn read(
    text: &str,
    masses: &[(&str, f64)],
    inertials: &[(&str, Inertia)],
) -> Result<Description, ReadError> {
    let masses = masses.iter().map(|&(name, mass)| (name.to_owned(), mass)).collect();
    let inertials = inertials.iter().map(|&(name, inertia)| (name.to_owned(), inertia)).collect();
    Description::from_urdf_with(text, &UrdfOptions { masses, inertials, ..UrdfOptions::default() })
}

/// The valid file without any mass, as a hundred files of public repositories are.
fn bare() -> String {
    let mut text = VALID.to_owned();
    while let Some(from) = text.find("<inertial>") {
        let to = text.find("</inertial>").unwrap() + "</inertial>".len();
        text.replace_range(from..to, "");
    }
    text
}

fn block(mass: f64) -> Inertia {
    let moments = Matrix3::from_diagonal(&Vector3::new(0.1, 0.2, 0.25));
    Inertia { mass, com: Vector3::new(0.1, 0.0, 0.2), moments }
}

#[test]
fn mass_scales_the_moments_and_leaves_the_centre() {
    let stated = read(VALID, &[], &[]).unwrap();
    let arm = read(VALID, &[("trunk", 10.0)], &[]).unwrap();
    let (old, new) = (stated.joints[0].link.inertia, arm.joints[0].link.inertia);
    assert_eq!((new.mass, new.com, new.moments), (10.0, old.com, old.moments * 2.0));
    assert_eq!(arm.joints[1..], stated.joints[1..]);
    let note = arm.notes.iter().find(|note| note.contains("mass given")).unwrap();
    assert!(note.contains("\"trunk\"") && note.contains("10 kg instead of 5"), "{note}");
}

#[test]
fn inertials_make_an_arm_of_a_file_that_states_none() {
    let all = [("trunk", block(1.0)), ("sled", block(2.0)), ("hand", block(3.0))];
    let arm = read(&bare(), &[], &all).unwrap();
    for (joint, (name, inertia)) in arm.joints.iter().zip(all) {
        assert_eq!((joint.link_name.as_str(), joint.link.inertia), (name, inertia));
        let told =
            arm.notes.iter().any(|note| note.contains(name) && note.contains("file states none"));
        assert!(told, "{:?}", arm.notes);
    }
    let error = read(&bare(), &[], &all[..2]).unwrap_err().to_string();
    assert!(error.contains("\"hand\"") && error.contains("inertials"), "{error}");
}

/// In the link's frame: a link that is fixed to another is carried to it.
#[test]
fn inertials_are_given_in_the_frame_of_the_link() {
    let arm = read(VALID, &[], &[("tool", block(1.0)), ("hand", Inertia::NONE)]).unwrap();
    // The tool stands 0.05 m above the hand.
    let com = Vector3::new(0.1, 0.0, 0.2 + 0.05);
    assert!((arm.joints[2].link.inertia.com - com).amax() < 1e-15);
    assert_eq!(arm.joints[2].link.inertia.moments, block(1.0).moments);
    let told = arm
        .notes
        .iter()
        .any(|note| note.contains("\"hand\"") && note.contains("1 kg of the file are not used"));
    assert!(told, "{:?}", arm.notes);
}

/// What is given need not be readable in the file.
#[test]
fn inertials_mend_what_the_file_states_badly() {
    let text = VALID.replace("<mass value=\"5\"/>", "<mass value=\"five\"/>");
    let arm = read(&text, &[], &[("trunk", block(5.0))]).unwrap();
    assert_eq!(arm.joints[0].link.inertia, block(5.0));
    assert!(read(&text, &[("trunk", 5.0)], &[]).unwrap_err().to_string().contains("\"five\""));
}

#[test]
fn mass_without_a_distribution_says_what_to_give() {
    let error = read(&bare(), &[("trunk", 1.0)], &[]).unwrap_err();
    let message = error.to_string();
    assert!(message.contains("\"trunk\"") && message.contains("inertials") && error.line.is_some());
}

#[test]
fn names_and_numbers_are_checked() {
    let says = |masses: &[(&str, f64)], inertials: &[(&str, Inertia)], words: &[&str]| {
        let message = read(VALID, masses, inertials).unwrap_err().to_string();
        assert!(words.iter().all(|word| message.contains(word)), "{words:?} not in {message}");
    };
    says(&[("trunc", 1.0)], &[], &["masses", "\"trunc\"", "near are \"trunk\""]);
    says(&[], &[("waist", block(1.0))], &["inertials", "\"waist\"", "name of a link"]);
    says(&[("trunk", 1.0)], &[("trunk", block(1.0))], &["\"trunk\"", "both"]);
    for mass in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        says(&[("trunk", mass)], &[], &["masses", "\"trunk\"", "> 0"]);
    }
    for mass in [-1.0, f64::NAN, f64::INFINITY] {
        says(&[], &[("trunk", block(mass))], &["inertials", "\"trunk\"", "mass", ">= 0"]);
    }
    let broken = |change: &dyn Fn(&mut Inertia)| {
        let mut inertia = block(1.0);
        change(&mut inertia);
        inertia
    };
    let com = broken(&|inertia| inertia.com.x = f64::NAN);
    says(&[], &[("trunk", com)], &["inertials", "\"trunk\"", "com", "finite"]);
    let moments = broken(&|inertia| inertia.moments[(0, 1)] = 0.01);
    says(&[], &[("trunk", moments)], &["inertials", "\"trunk\"", "moments", "symmetric"]);
    let triangle = broken(&|inertia| inertia.moments[(2, 2)] = 9.0);
    says(&[], &[("trunk", triangle)], &["\"trunk\"", "triangle"]);
}

#[test]
fn masses_of_links_that_do_not_move_are_told() {
    let arm = read(VALID, &[], &[("ground", block(1.0))]).unwrap();
    assert_eq!(arm.joints, read(VALID, &[], &[]).unwrap().joints);
    let told =
        arm.notes.iter().any(|note| note.contains("do not move") && note.contains("\"ground\""));
    assert!(told, "{:?}", arm.notes);
}

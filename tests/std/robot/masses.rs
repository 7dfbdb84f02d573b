//! Masses and mass distributions that the caller gives for links of a URDF.

use super::valid::VALID;
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

/// A link's shape where the file states no mass: uniform, by the textbook's formulas.
#[test]
fn mass_without_a_distribution_is_uniform_in_the_shape() {
    let shaped = |shapes: &str| {
        let text =
            bare().replace("<link name=\"trunk\">", &format!("<link name=\"trunk\">{shapes}"));
        let rest = [("sled", block(1.0)), ("hand", block(1.0))];
        let arm = read(&text, &[("trunk", 12.0)], &rest).unwrap();
        let note = arm.notes.iter().find(|note| note.contains("uniform")).unwrap().clone();
        (arm.joints[0].link.inertia, note)
    };
    let close = |got: Inertia, com: [f64; 3], moments: [f64; 3]| {
        let moments = Matrix3::from_diagonal(&moments.into());
        assert_eq!(got.mass, 12.0);
        assert!((got.com - Vector3::from(com)).amax() < 1e-15, "{got:?}");
        assert!((got.moments - moments).amax() < 1e-14, "{got:?}");
    };
    let shape = |which: &str, origin: &str, solid: &str| {
        format!("<{which}>{origin}<geometry>{solid}</geometry></{which}>")
    };
    let cuboid = shape("visual", "<origin xyz=\"0 0 0.2\"/>", "<box size=\"0.1 0.2 0.3\"/>");
    let (got, note) = shaped(&cuboid);
    close(got, [0.0, 0.0, 0.2], [0.13, 0.10, 0.05]);
    assert!(note.contains("\"trunk\"") && note.contains("<visual>"), "{note}");
    // Along y after a quarter turn about x; the shape of <collision> comes first.
    let turned = "<origin rpy=\"1.5707963267948966 0 0\"/>";
    let rod = shape("collision", turned, "<cylinder radius=\"0.1\" length=\"0.4\"/>");
    let (got, note) = shaped(&format!("{cuboid}{rod}"));
    close(got, [0.0; 3], [0.03 + 0.16, 0.06, 0.03 + 0.16]);
    assert!(note.contains("<collision>"), "{note}");
    let ball = |x: &str, r: &str| {
        shape(
            "collision",
            &format!("<origin xyz=\"{x} 0 0\"/>"),
            &format!("<sphere radius=\"{r}\"/>"),
        )
    };
    close(shaped(&ball("0.3", "0.5")).0, [0.3, 0.0, 0.0], [1.2; 3]);
    // Two balls, of 8 : 1 in volume: 32/3 kg and 4/3 kg, 0.9 m apart.
    let (large, small) = (32.0 / 3.0, 4.0 / 3.0);
    let own = 0.4 * (large * 0.04 + small * 0.01);
    let apart = large * small / 12.0 * 0.81;
    let two = shaped(&format!("{}{}", ball("0", "0.2"), ball("0.9", "0.1"))).0;
    close(two, [0.1, 0.0, 0.0], [own, own + apart, own + apart]);
    // A mesh beside the box is not looked at: the shape is not known.
    let mesh = shape("collision", "", "<mesh filename=\"a.stl\"/>");
    close(shaped(&format!("{mesh}{cuboid}")).0, [0.0, 0.0, 0.2], [0.13, 0.10, 0.05]);
}

#[test]
fn mass_without_a_distribution_or_a_shape_says_what_to_give() {
    let mesh = "<visual><geometry><mesh filename=\"a.stl\"/></geometry></visual>";
    let flat = "<visual><geometry><box size=\"1 1 0\"/></geometry></visual>";
    for shape in ["<visual/>", mesh, flat, &format!("{mesh}{flat}")] {
        let text = bare().replace("<visual/>", shape);
        let error = read(&text, &[("trunk", 1.0)], &[]).unwrap_err();
        let message = error.to_string();
        assert!(message.contains("\"trunk\"") && message.contains("inertials"), "{message}");
        assert!(error.line.is_some());
    }
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

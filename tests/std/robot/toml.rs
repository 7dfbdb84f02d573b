//! Our own format: what is written is read back bit for bit, and everything else is refused with
//! its line.

use steadyarm::arm::{JointFriction, JointKind, JointLimits, JointStop};
use steadyarm::robot::{Description, SHIPPED, shipped};

use super::valid::{VALID, read};
use crate::random::Random;

/// Every number of a description, as bits.
fn bits(arm: &Description) -> Vec<u64> {
    let mut numbers: Vec<f64> = arm.gravity.to_vec();
    numbers.extend(arm.tip.rotation.iter().chain(&arm.tip.translation));
    for joint in &arm.joints {
        let link = &joint.link;
        numbers.extend(link.placement.rotation.iter().chain(&link.placement.translation));
        numbers.extend(link.axis.iter().chain(&link.inertia.com).chain(&link.inertia.moments));
        let JointFriction { viscous, coulomb: [plus, minus], stribeck, stribeck_speed, smoothing } =
            link.friction;
        let JointLimits { lower, upper, velocity, effort } = link.limits;
        numbers.extend([viscous, plus, minus, stribeck, stribeck_speed, smoothing]);
        numbers.extend([lower, upper, velocity, effort, link.armature, link.inertia.mass]);
        let JointStop { stiffness, dissipation } = link.stop;
        numbers.extend([stiffness, dissipation]);
    }
    numbers.iter().map(|number| number.to_bits()).collect()
}

#[track_caller]
fn assert_same_after_reading(arm: &Description) {
    let text = arm.to_toml();
    let again = Description::from_toml(&text).unwrap();
    assert_eq!(&again, arm);
    assert_eq!(bits(&again), bits(arm));
    assert_eq!(again.to_toml(), text);
}

#[test]
fn saving_and_reading_is_the_identity() {
    assert_same_after_reading(&read(VALID).unwrap());
    for name in SHIPPED {
        assert_same_after_reading(&shipped(name).unwrap());
    }
    let mut random = Random(6);
    for _ in 0..500 {
        let mut arm = read(VALID).unwrap();
        scramble(&mut arm, &mut random);
        assert_same_after_reading(&arm);
    }
}

/// Numbers over many decades, zeros of both signs, limits that are there or not.
fn scramble(arm: &mut Description, random: &mut Random) {
    for joint in &mut arm.joints {
        let link = &mut joint.link;
        let size = random.decades(-300.0, 300.0);
        link.placement.translation *= size;
        link.placement.translation.x = -0.0;
        let turn =
            nalgebra::Rotation3::from_euler_angles(random.next(), random.next(), random.next());
        link.placement.rotation = *turn.matrix();
        link.axis = (turn * link.axis).normalize();
        link.inertia.mass = random.decades(-3.0, 3.0);
        link.inertia.com *= random.next();
        let spread = turn.matrix()
            * nalgebra::Matrix3::from_diagonal(&[1.0, 1.1, 1.2].into())
            * turn.matrix().transpose();
        link.inertia.moments = (spread + spread.transpose()) * random.decades(-9.0, 9.0);
        let kinds = [JointKind::Revolute, JointKind::Continuous, JointKind::Prismatic];
        link.kind = kinds[random.between(0.0, 3.0) as usize];
        link.friction.viscous = random.decades(-300.0, 300.0);
        link.friction.stribeck = 5e-324;
        link.friction.coulomb = [random.decades(-9.0, 9.0), -0.0];
        link.limits.upper = if random.next() > 0.0 { f64::INFINITY } else { f64::MAX };
        link.limits.lower = if random.next() > 0.0 { f64::NEG_INFINITY } else { random.next() };
        if link.kind == JointKind::Continuous {
            (link.limits.lower, link.limits.upper) = (f64::NEG_INFINITY, f64::INFINITY);
        }
        link.armature = random.decades(-20.0, 3.0);
        let stiffness = if random.next() > 0.0 { 0.0 } else { random.decades(-9.0, 9.0) };
        link.stop = JointStop { stiffness, dissipation: random.next().max(0.0) };
    }
    arm.tip.translation.z = random.next();
    arm.gravity = [random.next(), -0.0, -9.81];
}

#[test]
fn any_text_survives_as_a_name() {
    let mut arm = read(VALID).unwrap();
    for text in [
        "",
        "\"\\\"",
        "a\nb\tc\r\u{0}\u{7f}\u{85}",
        "# [joint]",
        "Gelenk ärgerlich 関節 🦾",
        "'''\"\"\"",
        "\\u0041",
    ] {
        arm.name = text.to_owned();
        arm.joints[0].link_name = text.to_owned();
        arm.notes = vec![text.to_owned(), "plain".to_owned()];
        assert_same_after_reading(&arm);
    }
}

#[test]
fn file_can_be_read_and_names_itself_in_errors() {
    let path = std::env::temp_dir().join(format!("steadyarm-{}.toml", std::process::id()));
    let arm = read(VALID).unwrap();
    std::fs::write(&path, arm.to_toml()).unwrap();
    let again = Description::from_toml_file(&path);
    std::fs::write(&path, "format = 1\nname = 3\n").unwrap();
    let error = Description::from_toml_file(&path).unwrap_err();
    std::fs::remove_file(&path).unwrap();
    assert_eq!(again.unwrap(), arm);
    assert!(error.to_string().starts_with(&format!("{}, line 2: ", path.display())), "{error}");
}

#[test]
fn what_may_be_absent_is_as_said() {
    let text = "format = 1\nname = \"one\"\n[[joint]]\nname = \"a\"\nlink = \"b\"\n\
                kind = \"revolute\"\naxis = [0, 0, 1]\nmass = 2\ncom = [0, 0, 0]\n\
                moments = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\n";
    let arm = Description::from_toml(text).unwrap();
    let link = arm.joints[0].link;
    assert_eq!(arm.gravity, steadyarm::robot::GRAVITY);
    assert_eq!(link.friction, JointFriction::default());
    assert_eq!([link.limits.lower, link.limits.upper], [f64::NEG_INFINITY, f64::INFINITY]);
    assert_eq!(link.placement.rotation, nalgebra::Matrix3::identity());
    assert_eq!([link.inertia.mass, link.armature], [2.0, 0.0]);
    assert_eq!(link.stop, JointStop::default());
}

/// Replaces the first `old` of the written file; the error must be in the line of `at` in the
/// broken one.
#[track_caller]
fn refused(old: &str, new: &str, at: Option<&str>, words: &[&str]) {
    let good = read(VALID).unwrap().to_toml();
    assert!(good.contains(old), "{old}");
    let text = good.replacen(old, new, 1);
    let error = Description::from_toml(&text).unwrap_err();
    let line = at.map(|at| 1 + text[..text.find(at).unwrap()].matches('\n').count());
    assert_eq!(error.line, line, "{error}");
    for word in words {
        assert!(error.message.contains(word), "{word:?} is not in: {error}");
    }
}

#[test]
fn one_thing_broken_is_refused_with_its_line() {
    let first = Some("[[joint]]");
    refused("mass = 5.0", "mass = -5.0", first, &["joint \"waist\"", "mass", "-5", ">= 0"]);
    refused("mass = 5.0", "mass = nan", first, &["\"waist\"", "mass", "NaN", "finite"]);
    refused("mass = 5.0", "mass = inf", first, &["\"waist\"", "mass", "inf"]);
    refused("com = [0.01", "com = [nan", first, &["\"waist\"", "com", "NaN"]);
    refused("moments = [[0.3", "moments = [[3.0", first, &["\"waist\"", "moments", "triangle"]);
    refused(
        "moments = [[0.3, 0.01",
        "moments = [[0.3, 0.02",
        first,
        &["\"waist\"", "not symmetric"],
    );
    refused(
        "axis = [0.0, 0.0, 1.0]",
        "axis = [0.0, 0.1, 1.0]",
        first,
        &["\"waist\"", "axis", "length 1"],
    );
    refused(
        "rotation = [[0.0, -1.0",
        "rotation = [[0.0, 1.0",
        first,
        &["placement.rotation", "rotation matrix"],
    );
    refused(
        "lower = -1.0",
        "lower = 2.5",
        first,
        &["\"waist\"", "limits.upper: got 2", "at least limits.lower"],
    );
    refused("effort = 40.0", "effort = 0.0", first, &["limits.effort", "got 0", "> 0"]);
    refused("upper = 2.0", "upper = nan", first, &["limits", "NaN"]);
    refused("smoothing = 0.01", "smoothing = -0.1", first, &["friction.smoothing", ">= 0"]);
    refused("viscous = 0.5", "viscous = -0.5", first, &["friction.viscous", "-0.5"]);
    refused("armature = 0.0", "armature = -1.0", first, &["armature", "-1"]);
    let stop = |entry| format!("armature = 0.0\nstop = {{ {entry} }}");
    for (entry, name) in [
        ("stiffness = -1.0", "stop.stiffness"),
        ("stiffness = 1.0, dissipation = -1.0", "stop.dissipation"),
    ] {
        refused("armature = 0.0", &stop(entry), first, &["\"waist\"", name, ">= 0"]);
    }
    refused("-9.81", "-inf", None, &["gravity", "-inf"]);
    let second = "[[joint]]\nname = \"waist\"\nlink = \"sled\"";
    refused(
        "[[joint]]\nname = \"lift\"\nlink = \"sled\"",
        second,
        Some(second),
        &["\"waist\"", "given twice"],
    );
}

#[test]
fn what_is_not_of_the_format_is_refused() {
    refused("format = 1", "format = 2", None, &["format", "got 2", "wants 1"]);
    refused("format = 1", "", Some("#"), &["missing field `format`"]);
    refused("mass = 5.0", "weight = 5.0", Some("weight"), &["unknown field `weight`"]);
    for (stop, words) in [
        ("3", "expected stiffness and"),
        ("{}", "missing field `stiffness`"),
        ("{ dissipation = 1.0 }", "missing field `stiffness`"),
    ] {
        let with = format!("armature = 0.0\nstop = {stop}");
        refused("armature = 0.0", &with, Some("stop = "), &[words]);
    }
    refused("mass = 5.0", "mass = \"heavy\"", Some("\"heavy\""), &["invalid type"]);
    refused("mass = 5.0", "mass = 5.0\nmass = 5.0", Some("mass = 5.0\ncom"), &["duplicate"]);
    refused(
        "kind = \"revolute\"",
        "kind = \"floating\"",
        Some("\"floating\""),
        &["unknown variant"],
    );
    refused("com = [0.01, 0.02, 0.03]", "com = [0.01, 0.02]", Some("[0.01, 0.02]"), &["length"]);
    refused("mass = 5.0", "mass = ", Some("mass = \n"), &["not the TOML"]);
    let none = Description::from_toml("format = 1\nname = \"x\"\n").unwrap_err();
    assert!(none.message.contains("joints: got none"), "{none}");
}

#[test]
fn hostile_texts_are_refused_at_once() {
    let start = std::time::Instant::now();
    for text in [
        "[".repeat(200_000),
        format!("a = {}", "[".repeat(200_000)),
        "a.".repeat(200_000),
        format!("a = {}", "{b=".repeat(200_000)),
    ] {
        assert!(Description::from_toml(&text).is_err());
    }
    let large = Description::from_toml(&" ".repeat(64 << 20)).unwrap_err();
    assert!(large.message.contains("at most 16777216"), "{large}");
    assert!(start.elapsed().as_secs() < 20);
}

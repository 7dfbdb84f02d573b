//! A description written down. Numbers have the fewest digits that give the same bits back.

use std::fmt::Write;

use crate::arm::{JointFriction, JointLimits, JointStop, Pose, Unphysical};
use crate::math::Matrix;
use crate::robot::{Description, JointDescription};

/// The version of the format that is written and read.
pub(super) const FORMAT: u32 = 1;

/// What every file begins with.
const HEADER: &str = "\
# A serial arm, joint by joint from the base outwards.
#
# Units: m, rad, kg, kg m^2, N m, m/s^2; for a prismatic joint m instead of rad, N instead of N m.
# translation, rotation   the joint's frame in the frame of the link before (the base for the \
    first), at q = 0;
#                         rotation row by row, absent for none. [tip]: the tip in the frame of \
    the last link.
# kind                    revolute, continuous (a turn leads back to where it began) or prismatic
# unphysical              what is done about links that no body is: refuse (if absent), note or \
    nearest
# axis                    of the joint, in its own frame, of length 1
# mass, com, moments      of the link, in the joint's frame; moments about the centre of mass
# armature                inertia of the rotor, seen through the gear
# friction                coulomb = [in positive motion, in negative motion]; smoothing, \
    stribeck_speed in rad/s or m/s
# limits                  absent for none
# stop                    at the ends of the range, absent for none: stiffness in N m/rad, \
    dissipation in s/rad
";

/// The whole file. Writing into a string cannot fail.
pub(super) fn text(description: &Description) -> String {
    let Description { name, joints, tip, gravity, notes, unphysical } = description;
    let mut out = String::from(HEADER);
    let _ = writeln!(out, "\nformat = {FORMAT}\nname = {}", string(name));
    let _ = writeln!(out, "gravity = {}", list(gravity));
    if *unphysical != Unphysical::Refuse {
        let _ = writeln!(out, "unphysical = {}", string(unphysical.name()));
    }
    if !notes.is_empty() {
        let notes: String = notes.iter().map(|note| format!("    {},\n", string(note))).collect();
        let _ = writeln!(out, "notes = [\n{notes}]");
    }
    out.push_str("\n[tip]\n");
    write_pose(&mut out, tip);
    for joint in joints {
        write_joint(&mut out, joint);
    }
    out
}

fn write_joint(out: &mut String, joint: &JointDescription) {
    let link = &joint.link;
    let kind = link.kind.name();
    let _ = writeln!(out, "\n[[joint]]\nname = {}", string(&joint.name));
    let _ = writeln!(out, "link = {}\nkind = \"{kind}\"", string(&joint.link_name));
    write_pose(out, &link.placement);
    let _ = writeln!(out, "axis = {}", list(link.axis.as_slice()));
    let _ = writeln!(out, "mass = {:?}", link.inertia.mass);
    let _ = writeln!(out, "com = {}", list(link.inertia.com.as_slice()));
    let _ = writeln!(out, "moments = {}", rows(&link.inertia.moments));
    let _ = writeln!(out, "armature = {:?}", link.armature);
    let JointFriction { viscous, coulomb, stribeck, stribeck_speed, smoothing } = link.friction;
    let _ = writeln!(
        out,
        "friction = {{ viscous = {viscous:?}, coulomb = {}, stribeck = {stribeck:?}, \
         stribeck_speed = {stribeck_speed:?}, \
         smoothing = {smoothing:?} }}",
        list(&coulomb)
    );
    write_limits(out, &link.limits);
    if link.stop != JointStop::default() {
        let JointStop { stiffness, dissipation } = link.stop;
        let _ =
            writeln!(out, "stop = {{ stiffness = {stiffness:?}, dissipation = {dissipation:?} }}");
    }
}

fn write_pose(out: &mut String, pose: &Pose) {
    let _ = writeln!(out, "translation = {}", list(pose.translation.as_slice()));
    let none = Matrix::<3>::identity();
    let same = pose.rotation.iter().zip(&none).all(|(a, b)| a.to_bits() == b.to_bits());
    if !same {
        let _ = writeln!(out, "rotation = {}", rows(&pose.rotation));
    }
}

fn write_limits(out: &mut String, limits: &JointLimits) {
    let JointLimits { lower, upper, velocity, effort } = *limits;
    let stated = [
        ("lower", lower, f64::NEG_INFINITY),
        ("upper", upper, f64::INFINITY),
        ("velocity", velocity, f64::INFINITY),
        ("effort", effort, f64::INFINITY),
    ];
    let stated = stated.iter().filter(|(_, value, none)| value != none);
    let stated: Vec<_> = stated.map(|(what, value, _)| format!("{what} = {value:?}")).collect();
    if !stated.is_empty() {
        let _ = writeln!(out, "limits = {{ {} }}", stated.join(", "));
    }
}

/// `[1.0, 0.5]`.
fn list(values: &[f64]) -> String {
    let values: Vec<_> = values.iter().map(|value| format!("{value:?}")).collect();
    format!("[{}]", values.join(", "))
}

fn rows(matrix: &Matrix<3>) -> String {
    let rows: Vec<_> = matrix.row_iter().map(|row| list(&[row[0], row[1], row[2]])).collect();
    format!("[{}]", rows.join(", "))
}

/// A TOML string: quotes, backslashes and control characters escaped.
fn string(text: &str) -> String {
    let mut out = String::from('"');
    for character in text.chars() {
        match character {
            '"' | '\\' => out.extend(['\\', character]),
            c if c.is_control() => {
                let _ = write!(out, "\\u{:04X}", u32::from(c));
            }
            c => out.push(c),
        }
    }
    out.push('"');
    out
}

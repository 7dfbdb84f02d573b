//! `<transmission>`: the rotor's inertia through the gear, J = n² J_m, where the file states J_m.
//!
//! Read are `mechanicalReduction` and `motorInertia` as texts, and Drake's `gear_ratio` and `rotor_inertia` as values.

use std::collections::BTreeMap;

use roxmltree::Node;

use super::elements::Source;
use crate::robot::ReadError;
use crate::robot::error::quoted;

/// Armature by the joint's name [kg·m² or kg].
pub(super) fn armatures(source: &Source, robot: Node) -> Result<BTreeMap<String, f64>, ReadError> {
    let mut armatures = BTreeMap::new();
    for node in robot.children().filter(|node| node.has_tag_name("transmission")) {
        let Some(rotor) = rotor(source, node)? else { continue };
        let at = node.range().start;
        let mut joints = node.descendants().filter(|part| part.has_tag_name("joint"));
        let (Some(joint), None) = (joints.next(), joints.next()) else {
            let message =
                "transmission: got a rotor's inertia without exactly one <joint>, wants one";
            return Err(source.error(at, message));
        };
        let name = source.text(joint, "name", "transmission")?;
        if armatures.insert(name.to_owned(), rotor).is_some() {
            let message = format!("transmission: got a second rotor for joint {}", quoted(name));
            return Err(source.error(at, format!("{message}, wants one")));
        }
    }
    Ok(armatures)
}

/// True if the transmission says something that is used.
pub(super) fn states_rotor(node: Node) -> bool {
    stated(node, "motorInertia", "rotor_inertia").is_some()
}

fn stated<'a, 'input>(node: Node<'a, 'input>, text: &str, value: &str) -> Option<Node<'a, 'input>> {
    node.descendants().find(|part| {
        let name = part.tag_name().name();
        part.is_element() && (name == text || name == value)
    })
}

/// n² J_m, if J_m is stated.
fn rotor(source: &Source, node: Node) -> Result<Option<f64>, ReadError> {
    let Some(inertia) = stated(node, "motorInertia", "rotor_inertia") else { return Ok(None) };
    let motor = number(source, inertia)?;
    let gear = match stated(node, "mechanicalReduction", "gear_ratio") {
        Some(gear) => number(source, gear)?,
        None => 1.0,
    };
    let armature = gear * gear * motor;
    if armature >= 0.0 && armature.is_finite() {
        return Ok(Some(armature));
    }
    let message = format!(
        "transmission: got a rotor of {motor} kg m^2 behind a gear of {gear}, wants a finite number >= 0"
    );
    Err(source.error(inertia.range().start, message))
}

/// The number in an element's `value`, or else in its text.
fn number(source: &Source, node: Node) -> Result<f64, ReadError> {
    if let Some(value) = source.number(node, "value", "transmission", false)? {
        return Ok(value);
    }
    let text = node.text().unwrap_or_default().trim();
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(source.error(
            node.range().start,
            format!(
                "transmission, <{}>: got {}, wants a finite number",
                node.tag_name().name(),
                quoted(text)
            ),
        )),
    }
}

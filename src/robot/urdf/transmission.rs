//! `<transmission>`: the rotor's inertia through the gear, J = n² J_m.
//!
//! Where one of Drake's tags stands, n is `gear_ratio` and J_m `rotor_inertia`, as in its
//! `default_reflected_inertia`; else they are `mechanicalReduction` and `motorInertia`, as in ROS.
//! An n that is not stated is 1. Numbers stand in `value` or as text, names with any prefix.
//! Source: drake.mit.edu, "Parsing Models in Drake"; wiki.ros.org/urdf/XML/Transmission.

use std::collections::BTreeMap;

use roxmltree::Node;

use super::elements::Document;
use crate::robot::ReadError;
use crate::robot::error::quoted;

const DRAKE: [&str; 2] = ["gear_ratio", "rotor_inertia"];
const ROS: [&str; 2] = ["mechanicalReduction", "motorInertia"];

/// What the transmissions say of a chain.
#[derive(Default)]
pub(super) struct Rotors {
    /// Armature by the joint's name [kg·m² or kg].
    pub armatures: BTreeMap<String, f64>,
    /// What contradicts or is left over.
    pub notes: Vec<String>,
}

impl Rotors {
    /// Of the joints in `chain`; the others' transmissions are not looked at.
    pub fn read(
        source: &Document,
        robot: Node,
        chain: impl Fn(&str) -> bool,
    ) -> Result<Self, ReadError> {
        let mut rotors = Self::default();
        for node in robot.children().filter(|node| node.has_tag_name("transmission")) {
            if states_rotor(source, node) {
                rotors.add(source, node, &chain)?;
            }
        }
        Ok(rotors)
    }

    fn add(
        &mut self,
        source: &Document,
        node: Node,
        chain: impl Fn(&str) -> bool,
    ) -> Result<(), ReadError> {
        let joints: Vec<_> = named(source, node, "joint").collect();
        let name = match *joints.as_slice() {
            [joint] => source.text(joint, "name", "transmission")?,
            [] => {
                let message =
                    "transmission: got a rotor's inertia without exactly one <joint>, wants one";
                return Err(source.error(node.range().start, message));
            }
            _ => {
                let names = joints.iter().filter_map(|joint| joint.attribute("name"));
                if let Some(name) = names.map(str::trim).find(|&name| chain(name)) {
                    let line = source.line(node.range().start);
                    self.notes.push(format!(
                        "joint {}: its rotor is not used, as <transmission> in line {line} has \
                         several joints",
                        quoted(name)
                    ));
                }
                return Ok(());
            }
        };
        if !chain(name) {
            return Ok(());
        }
        if self.armatures.contains_key(name) {
            let line = source.line(node.range().start);
            self.notes
                .push(format!("joint {}: a second rotor in line {line} is not used", quoted(name)));
            return Ok(());
        }
        if let Some(armature) = self.armature(source, node, name)? {
            self.armatures.insert(name.to_owned(), armature);
        }
        Ok(())
    }

    /// n² J_m, if J_m is stated; what says otherwise is noted.
    fn armature(
        &mut self,
        source: &Document,
        node: Node,
        joint: &str,
    ) -> Result<Option<f64>, ReadError> {
        let first = |name| named(source, node, name).next();
        let drake = DRAKE.map(first);
        let used = if drake.iter().any(Option::is_some) { drake } else { ROS.map(first) };
        let values = [1.0, 0.0].into_iter().zip(used).map(|(absent, node)| match node {
            Some(node) => number(source, node),
            None => Ok(absent),
        });
        let values: Vec<f64> = values.collect::<Result<_, _>>()?;
        let (gear, motor) = (values[0], values[1]);
        for [gear_name, inertia_name] in [DRAKE, ROS] {
            for (name, value) in [(gear_name, gear), (inertia_name, motor)] {
                // Two motors of the same inertia are not one: a second is noted though it agrees.
                let second = used[1].is_some_and(|used| source.local_name(used) == name);
                let others =
                    named(source, node, name).filter(|&other| !used.contains(&Some(other)));
                for other in others {
                    if second || number(source, other).ok() != Some(value) {
                        self.notes.push(left_over(source, other, joint, used));
                    }
                }
            }
        }
        let Some(inertia) = used[1] else { return Ok(None) };
        let armature = gear * gear * motor;
        if armature >= 0.0 && armature.is_finite() {
            return Ok(Some(armature));
        }
        let message = format!(
            "transmission: got a rotor of {motor} kg m^2 behind a gear of {gear}, wants a finite \
             number >= 0"
        );
        Err(source.error(inertia.range().start, message))
    }
}

/// True if the transmission says something of a rotor.
pub(super) fn states_rotor(source: &Document, node: Node) -> bool {
    [DRAKE[1], ROS[1]].iter().any(|name| named(source, node, name).next().is_some())
}

/// The elements of that name, with any prefix, in a transmission.
fn named<'s, 'n: 's, 'i: 's>(
    source: &'s Document,
    node: Node<'n, 'i>,
    name: &'s str,
) -> impl Iterator<Item = Node<'n, 'i>> + 's {
    node.descendants().filter(move |part| part.is_element() && source.local_name(*part) == name)
}

/// The number in an element's `value`, or else in its text.
fn number(source: &Document, node: Node) -> Result<f64, ReadError> {
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
                source.name(node),
                quoted(text)
            ),
        )),
    }
}

/// A note on a number that is not that which was used.
fn left_over(source: &Document, node: Node, joint: &str, used: [Option<Node>; 2]) -> String {
    let stated: Vec<_> = used.into_iter().flatten().map(|node| source.name(node)).collect();
    let line = source.line(node.range().start);
    format!(
        "joint {}: <{}> in line {line} is not used beside <{}>",
        quoted(joint),
        source.name(node),
        stated.join("> and <")
    )
}

//! What the file says that is not used, each element once.

use std::collections::BTreeMap;

use roxmltree::Node;

use super::elements::Document;
use super::transmission::states_rotor;

const IN_LINK: [&str; 1] = ["inertial"];
const IN_JOINT: [&str; 7] = ["origin", "parent", "child", "axis", "limit", "dynamics", "mimic"];

/// Most elements that are told apart.
const MOST_NOTES: usize = 20;

/// A note for each name of an unused element, in the order of their first appearance.
pub(super) fn notes(source: &Document, robot: Node) -> Vec<String> {
    let mut found: BTreeMap<&str, (usize, usize)> = BTreeMap::new();
    let mut add = |node: Node| {
        found.entry(source.name(node)).or_insert((node.range().start, 0)).1 += 1;
    };
    for part in robot.children().filter(Node::is_element) {
        let used: &[&str] = match part.tag_name().name() {
            "link" => &IN_LINK,
            "joint" => &IN_JOINT,
            "transmission" if states_rotor(source, part) => continue,
            _ => {
                add(part);
                continue;
            }
        };
        for child in part.children().filter(Node::is_element) {
            if !used.contains(&child.tag_name().name()) {
                add(child);
            }
        }
    }
    let mut found: Vec<_> =
        found.into_iter().map(|(name, (at, count))| (at, name, count)).collect();
    found.sort_unstable();
    let more = found.len().saturating_sub(MOST_NOTES);
    let shown = found.iter().take(MOST_NOTES);
    let mut notes: Vec<_> = shown.map(|&(at, name, count)| note(source, at, name, count)).collect();
    if more > 0 {
        notes.push(format!("{more} further elements: not used"));
    }
    notes
}

fn note(source: &Document, at: usize, name: &str, count: usize) -> String {
    let line = source.line(at);
    match count {
        1 => format!("<{name}> in line {line}: not used"),
        _ => format!("<{name}>, {count} times, first in line {line}: not used"),
    }
}

//! Links and joints as a tree: names are unique, every link but the root has one parent, nothing goes in circles.

use std::collections::BTreeMap;

use roxmltree::Node;

use super::elements::Source;
use super::joint::JointPart;
use super::link::LinkPart;
use super::transmission;
use crate::robot::ReadError;
use crate::robot::error::{listed, quoted};
use crate::robot::urdf::joint::Motion;

/// The robot as its file states it.
pub(super) struct Tree {
    pub links: Vec<LinkPart>,
    pub joints: Vec<JointPart>,
    /// Parent and child link of every joint.
    pub ends: Vec<(usize, usize)>,
    /// The joint that carries a link; none for the root.
    pub carrier: Vec<Option<usize>>,
    /// The joints that a link carries, in the order of the file.
    pub carried: Vec<Vec<usize>>,
    /// Rotor inertia by the joint's name.
    pub armatures: BTreeMap<String, f64>,
    root: usize,
}

/// From base to tip.
pub(super) struct Path {
    pub base: usize,
    pub tip: usize,
    /// The joints between, fixed ones included.
    pub joints: Vec<usize>,
}

impl Tree {
    pub fn read(source: &Source, robot: Node) -> Result<Self, ReadError> {
        let elements = |name| robot.children().filter(move |node: &Node| node.has_tag_name(name));
        let mut by_name = BTreeMap::new();
        let mut links = Vec::new();
        for node in elements("link") {
            let link = LinkPart::read(source, node)?;
            unique(source, &mut by_name, "link", &link.name, link.at, links.len())?;
            links.push(link);
        }
        let mut joint_names = BTreeMap::new();
        let mut joints = Vec::new();
        for node in elements("joint") {
            let joint = JointPart::read(source, node)?;
            unique(source, &mut joint_names, "joint", &joint.name, joint.at, joints.len())?;
            joints.push(joint);
        }
        let mut tree = Self {
            carrier: vec![None; links.len()],
            carried: vec![Vec::new(); links.len()],
            ends: Vec::with_capacity(joints.len()),
            armatures: transmission::armatures(source, robot)?,
            root: 0,
            links,
            joints,
        };
        tree.connect(source, &by_name)?;
        tree.root = tree.only_root(source, robot)?;
        tree.refuse_circles(source)?;
        Ok(tree)
    }

    fn connect(
        &mut self,
        source: &Source,
        by_name: &BTreeMap<String, usize>,
    ) -> Result<(), ReadError> {
        for (index, joint) in self.joints.iter().enumerate() {
            let link = |which: &str, name: &str| {
                by_name.get(name).copied().ok_or_else(|| {
                    let owner = quoted(&joint.name);
                    let near = near(name, by_name.keys().map(String::as_str));
                    let message = format!(
                        "joint {owner}, <{which}>: got the link {}, which the file does not have{near}",
                        quoted(name)
                    );
                    source.error(joint.at, message)
                })
            };
            let (parent, child) = (link("parent", &joint.parent)?, link("child", &joint.child)?);
            if let Some(other) = self.carrier[child].replace(index) {
                let message = format!(
                    "link {}: got two parents, joints {} and {}, wants one",
                    quoted(&joint.child),
                    quoted(&self.joints[other].name),
                    quoted(&joint.name)
                );
                return Err(source.error(joint.at, message));
            }
            self.carried[parent].push(index);
            self.ends.push((parent, child));
        }
        Ok(())
    }

    /// The one link without a parent.
    fn only_root(&self, source: &Source, robot: Node) -> Result<usize, ReadError> {
        let roots: Vec<_> = (0..self.links.len()).filter(|&l| self.carrier[l].is_none()).collect();
        let names = || roots.iter().map(|&root| self.links[root].name.as_str());
        match (roots.as_slice(), self.links.first()) {
            (&[root], _) => Ok(root),
            (_, None) => {
                Err(source.error(robot.range().start, "<robot>: got no <link>, wants links and joints"))
            }
            ([], Some(link)) => {
                Err(source.error(link.at, "links: got a loop, every link has a parent; wants a tree"))
            }
            (&[_, second, ..], _) => Err(source.error(
                self.links[second].at,
                format!(
                    "links: got {} without a parent ({}), wants one root; join them by fixed joints",
                    roots.len(),
                    listed(names().collect::<Vec<_>>().into_iter())
                ),
            )),
        }
    }

    /// Every link must be reached from the root; as each has one parent, those that are not go in circles.
    fn refuse_circles(&self, source: &Source) -> Result<(), ReadError> {
        let mut reached = vec![false; self.links.len()];
        let mut waiting = vec![self.root];
        while let Some(link) = waiting.pop() {
            reached[link] = true;
            waiting.extend(self.carried[link].iter().map(|&joint| self.ends[joint].1));
        }
        match self.ends.iter().position(|&(_, child)| !reached[child]) {
            None => Ok(()),
            Some(joint) => {
                let joint = &self.joints[joint];
                let message = format!(
                    "joint {}: got a loop, its links hang on themselves and not on {}; wants a tree",
                    quoted(&joint.name),
                    quoted(&self.links[self.root].name)
                );
                Err(source.error(joint.at, message))
            }
        }
    }

    /// The way from base to tip.
    pub fn path(
        &self,
        source: &Source,
        base: Option<&str>,
        tip: Option<&str>,
    ) -> Result<Path, ReadError> {
        let base = base.map_or(Ok(self.root), |name| self.named("base", name))?;
        let tip = match tip {
            Some(name) => self.named("tip", name)?,
            None => self.only_end(base)?,
        };
        let mut joints = Vec::new();
        let mut link = tip;
        while link != base {
            let Some(joint) = self.carrier[link] else {
                let (tip, base) = (quoted(&self.links[tip].name), quoted(&self.links[base].name));
                return Err(ReadError::new(format!(
                    "tip: got {tip}, which does not hang on the base {base}; wants a link beyond the base"
                )));
            };
            joints.push(joint);
            link = self.ends[joint].0;
        }
        joints.reverse();
        for &joint in &joints {
            self.refuse_dependent(source, joint)?;
        }
        Ok(Path { base, tip, joints })
    }

    fn named(&self, which: &str, name: &str) -> Result<usize, ReadError> {
        self.links.iter().position(|link| link.name == name).ok_or_else(|| {
            let near = near(name, self.links.iter().map(|link| link.name.as_str()));
            ReadError::new(format!("{which}: got {}, wants the name of a link{near}", quoted(name)))
        })
    }

    /// The only end of the robot that moves relative to the base.
    fn only_end(&self, base: usize) -> Result<usize, ReadError> {
        let mut ends = Vec::new();
        let mut waiting = vec![(base, 0_usize)];
        while let Some((link, moving)) = waiting.pop() {
            if self.carried[link].is_empty() && moving > 0 {
                ends.push((link, moving));
            }
            waiting.extend(self.carried[link].iter().rev().map(|&joint| {
                (self.ends[joint].1, moving + usize::from(self.joints[joint].moves()))
            }));
        }
        match ends.as_slice() {
            &[(end, _)] => Ok(end),
            [] => Err(ReadError::new(format!(
                "joints: got none that moves beyond {}, wants at least one",
                quoted(&self.links[base].name)
            ))),
            _ => {
                let shown = ends.iter().take(12).map(|&(end, moving)| {
                    format!("{} ({moving} joints)", quoted(&self.links[end].name))
                });
                let shown: Vec<_> = shown.collect();
                let more = if ends.len() > shown.len() { ", …" } else { "" };
                Err(ReadError::new(format!(
                    "tip: got none, but the robot has {} ends; choose one of {}{more}, or a link before",
                    ends.len(),
                    shown.join(", ")
                )))
            }
        }
    }

    /// Refuses a joint between base and tip that is not moved by one motor of its own.
    fn refuse_dependent(&self, source: &Source, joint: usize) -> Result<(), ReadError> {
        let joint = &self.joints[joint];
        let name = quoted(&joint.name);
        let what = match joint.motion {
            Motion::Floating => "a floating joint",
            Motion::Planar => "a planar joint",
            _ => match joint.mimic {
                None => return Ok(()),
                Some(at) => {
                    let message = format!(
                        "joint {name}, <mimic>: got a joint that follows another, wants independent ones between base and \
                         tip; choose a tip before it, or make it fixed"
                    );
                    return Err(source.error(at, message));
                }
            },
        };
        let message = format!(
            "joint {name}: got {what}, wants revolute, continuous, prismatic or fixed ones between base and tip; choose a \
             base beyond it"
        );
        Err(source.error(joint.at, message))
    }
}

/// Remembers a name, which must be new.
fn unique(
    source: &Source,
    names: &mut BTreeMap<String, usize>,
    what: &str,
    name: &str,
    at: usize,
    index: usize,
) -> Result<(), ReadError> {
    match names.insert(name.to_owned(), index) {
        None => Ok(()),
        Some(_) => {
            let message = format!("{what} {}: got a name given twice, wants another", quoted(name));
            Err(source.error(at, message))
        }
    }
}

/// `; near are "a", "b"`: known names that resemble `name`, or else the first few.
fn near<'a>(name: &str, known: impl Iterator<Item = &'a str> + Clone) -> String {
    let lower = name.to_lowercase();
    let resembles = |other: &&str| {
        let other = other.to_lowercase();
        !lower.is_empty() && (other.contains(&lower) || lower.contains(&other))
            || distance(&lower, &other) <= 1 + lower.chars().count().min(24) / 4
    };
    let alike: Vec<_> = known.clone().filter(resembles).take(8).collect();
    match alike.is_empty() {
        false => format!("; near are {}", listed(alike.into_iter())),
        true => format!("; there are {}", listed(known.collect::<Vec<_>>().into_iter())),
    }
}

/// Levenshtein's distance of the first 32 characters.
fn distance(a: &str, b: &str) -> usize {
    const COMPARED: usize = 32;
    let b: Vec<char> = b.chars().take(COMPARED).collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().take(COMPARED).enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(x != *y);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row.last().copied().unwrap_or(0)
}

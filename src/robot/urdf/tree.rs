//! Links and joints as a tree: names are unique, every link but the root has one parent, nothing
//! goes in circles.
//!
//! What breaks the tree is kept as a fault: it refuses the file only where it concerns what is
//! asked for.

use std::collections::{BTreeMap, BTreeSet};

use roxmltree::Node;

use super::elements::Document;
use super::joint::JointPart;
use super::link::LinkPart;
use super::names::near;
use crate::robot::ReadError;
use crate::robot::error::{listed, quoted};

/// As many faults are told with the names that are near; each costs a look at all names.
const MOST_NEAR: usize = 20;

/// The robot as its file states it.
#[derive(Default)]
pub(super) struct Tree<'n, 'i> {
    pub links: Vec<LinkPart<'n, 'i>>,
    pub joints: Vec<JointPart<'n, 'i>>,
    /// Parent and child link of every joint.
    pub ends: Vec<(usize, usize)>,
    /// The joint that carries a link; none for the root.
    pub carrier: Vec<Option<usize>>,
    /// The joints that a link carries, in the order of the file.
    pub carried: Vec<Vec<usize>>,
    /// Links and joints that were left out.
    pub faults: Vec<ReadError>,
    /// The fault that concerns a link.
    fault_of: BTreeMap<usize, usize>,
    by_name: BTreeMap<&'n str, usize>,
}

impl<'n, 'i> Tree<'n, 'i> {
    pub fn read(source: &Document, robot: Node<'n, 'i>) -> Result<Self, ReadError> {
        let elements = |name| robot.children().filter(move |node: &Node| node.has_tag_name(name));
        let mut tree = Self::default();
        for node in elements("link") {
            tree.add_link(source, node);
        }
        let mut joint_names = BTreeSet::new();
        for node in elements("joint") {
            let added = JointPart::read(source, node)
                .and_then(|joint| tree.add_joint(source, joint, &mut joint_names));
            if let Err(error) = added {
                let child = node.children().find(|part| part.has_tag_name("child"));
                let name = child.and_then(|child| child.attribute("link"));
                let link = name.and_then(|name| tree.by_name.get(name.trim()).copied());
                tree.leave_out(error, link);
            }
        }
        if !tree.links.is_empty() {
            return Ok(tree);
        }
        Err(match (source.macro_in(robot, |_| true), tree.faults.into_iter().next()) {
            (Some(node), _) => source.unexpanded(node),
            (None, Some(fault)) => fault,
            (None, None) => {
                source.error(robot.range().start, "<robot>: got no <link>, wants links and joints")
            }
        })
    }

    fn add_link(&mut self, source: &Document, node: Node<'n, 'i>) {
        let link = match LinkPart::read(source, node) {
            Ok(link) => link,
            Err(error) => return self.leave_out(error, None),
        };
        if let Some(&first) = self.by_name.get(link.name) {
            return self.leave_out(twice(source, "link", link.name, link.at), Some(first));
        }
        self.by_name.insert(link.name, self.links.len());
        self.links.push(link);
        self.carrier.push(None);
        self.carried.push(Vec::new());
    }

    fn add_joint(
        &mut self,
        source: &Document,
        joint: JointPart<'n, 'i>,
        names: &mut BTreeSet<&'n str>,
    ) -> Result<(), ReadError> {
        if !names.insert(joint.name) {
            return Err(twice(source, "joint", joint.name, joint.at));
        }
        let parent = self.end(source, &joint, "parent", joint.parent)?;
        let child = self.end(source, &joint, "child", joint.child)?;
        if let Some(other) = self.carrier[child] {
            let message = format!(
                "link {}: got two parents, joints {} and {}, wants one",
                quoted(joint.child),
                quoted(self.joints[other].name),
                quoted(joint.name)
            );
            return Err(source.error(joint.at, message));
        }
        let index = self.joints.len();
        self.carrier[child] = Some(index);
        self.carried[parent].push(index);
        self.ends.push((parent, child));
        self.joints.push(joint);
        Ok(())
    }

    /// The link that a joint names.
    fn end(
        &self,
        source: &Document,
        joint: &JointPart,
        which: &str,
        name: &str,
    ) -> Result<usize, ReadError> {
        self.by_name.get(name).copied().ok_or_else(|| {
            let near = match self.faults.len() < MOST_NEAR {
                true => near(name, self.by_name.keys().copied()),
                false => String::new(),
            };
            let message = format!(
                "joint {}, <{which}>: got the link {}, which the file does not have{near}",
                quoted(joint.name),
                quoted(name)
            );
            source.error(joint.at, message)
        })
    }

    fn leave_out(&mut self, error: ReadError, link: Option<usize>) {
        if let Some(link) = link {
            self.fault_of.entry(link).or_insert(self.faults.len());
        }
        self.faults.push(error);
    }

    /// What is wrong with what this link is or hangs on.
    pub fn fault(&self, link: usize) -> Option<&ReadError> {
        self.faults.get(*self.fault_of.get(&link)?)
    }

    /// The link of that name, for the argument `which`.
    pub fn named(&self, which: &str, name: &str) -> Result<usize, ReadError> {
        self.by_name.get(name).copied().ok_or_else(|| {
            let near = near(name, self.links.iter().map(|link| link.name));
            ReadError::new(format!("{which}: got {}, wants the name of a link{near}", quoted(name)))
        })
    }

    /// The root of a file in which all is right.
    pub fn only_root(&self, source: &Document) -> Result<usize, ReadError> {
        if let Some(fault) = self.faults.first() {
            return Err(fault.clone());
        }
        let roots: Vec<_> = (0..self.links.len()).filter(|&l| self.carrier[l].is_none()).collect();
        let root = match *roots.as_slice() {
            [root] => root,
            [] => {
                let message = "links: got a loop, every link has a parent; wants a tree";
                return Err(source.error(self.links[0].at, message));
            }
            [_, second, ..] => {
                let names: Vec<_> = roots.iter().map(|&root| self.links[root].name).collect();
                let message = format!(
                    "links: got {} without a parent ({}), wants one root; join them by fixed \
                     joints, or name a tip",
                    roots.len(),
                    listed(names.into_iter())
                );
                return Err(source.error(self.links[second].at, message));
            }
        };
        self.refuse_circles(source, root)?;
        Ok(root)
    }

    /// Every link must be reached from the root; as each has one parent, those that are not go in
    /// circles.
    fn refuse_circles(&self, source: &Document, root: usize) -> Result<(), ReadError> {
        let mut reached = vec![false; self.links.len()];
        let mut waiting = vec![root];
        while let Some(link) = waiting.pop() {
            reached[link] = true;
            waiting.extend(self.carried[link].iter().map(|&joint| self.ends[joint].1));
        }
        match self.ends.iter().position(|&(_, child)| !reached[child]) {
            None => Ok(()),
            Some(joint) => Err(self.circle(source, joint)),
        }
    }

    pub fn circle(&self, source: &Document, joint: usize) -> ReadError {
        let joint = &self.joints[joint];
        let message = format!(
            "joint {}: got a loop, its links hang on themselves; wants a tree",
            quoted(joint.name)
        );
        source.error(joint.at, message)
    }
}

fn twice(source: &Document, what: &str, name: &str, at: usize) -> ReadError {
    source.error(at, format!("{what} {}: got a name given twice, wants another", quoted(name)))
}

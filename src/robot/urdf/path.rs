//! The way from base to tip.
//!
//! A tip that is named is followed back to the base, and what does not lie between them may be as
//! it likes. Without one it is found from the whole tree, which then must be right.

use super::elements::Document;
use super::joint::JointType;
use super::tree::Tree;
use crate::robot::ReadError;
use crate::robot::error::quoted;

/// From the root over the base to the tip.
pub(super) struct Path {
    pub root: usize,
    pub base: usize,
    pub tip: usize,
    /// The joints between root and base.
    pub before: Vec<usize>,
    /// The joints between base and tip, fixed ones included.
    pub joints: Vec<usize>,
    /// True if the tip was found and not named.
    pub found: bool,
}

impl Path {
    pub fn of(
        source: &Document,
        tree: &Tree,
        base: Option<&str>,
        tip: Option<&str>,
    ) -> Result<Self, ReadError> {
        let named =
            |which, name: Option<&str>| name.map(|name| tree.named(which, name)).transpose();
        let root = if tip.is_none() { Some(tree.only_root(source)?) } else { None };
        let base = named("base", base)?.or(root);
        let end = match named("tip", tip)? {
            Some(tip) => tip,
            None => only_end(tree, base.unwrap_or_default())?,
        };
        let (base, joints) = back(source, tree, base, end)?;
        for &joint in &joints {
            refuse_dependent(source, tree, joint)?;
        }
        let (mut root, mut before) = (base, Vec::new());
        while let Some(joint) = tree.carrier[root] {
            if before.len() == tree.joints.len() {
                return Err(tree.circle(source, joint));
            }
            before.push(joint);
            root = tree.ends[joint].0;
        }
        before.reverse();
        Ok(Self { root, base, tip: end, before, joints, found: tip.is_none() })
    }
}

/// The joints from the base, or else from the root, to the tip.
fn back(
    source: &Document,
    tree: &Tree,
    base: Option<usize>,
    tip: usize,
) -> Result<(usize, Vec<usize>), ReadError> {
    let (mut link, mut joints) = (tip, Vec::new());
    while Some(link) != base {
        if let Some(fault) = tree.fault(link) {
            return Err(fault.clone());
        }
        let Some(joint) = tree.carrier[link] else {
            let Some(base) = base else { break };
            let (tip, base) = (quoted(tree.links[tip].name), quoted(tree.links[base].name));
            return Err(ReadError::new(format!(
                "tip: got {tip}, which does not hang on the base {base}; wants a link beyond the \
                 base"
            )));
        };
        if joints.len() == tree.joints.len() {
            return Err(tree.circle(source, joint));
        }
        joints.push(joint);
        link = tree.ends[joint].0;
    }
    joints.reverse();
    Ok((link, joints))
}

/// The only end of the robot that moves relative to the base.
fn only_end(tree: &Tree, base: usize) -> Result<usize, ReadError> {
    let mut ends = Vec::new();
    let mut waiting = vec![(base, 0_usize)];
    while let Some((link, moving)) = waiting.pop() {
        if tree.carried[link].is_empty() && moving > 0 {
            ends.push((link, moving));
        }
        waiting.extend(
            tree.carried[link].iter().rev().map(|&joint| {
                (tree.ends[joint].1, moving + usize::from(tree.joints[joint].moves()))
            }),
        );
    }
    match *ends.as_slice() {
        [(end, _)] => Ok(end),
        [] => Err(ReadError::new(format!(
            "joints: got none that moves beyond {}, wants at least one",
            quoted(tree.links[base].name)
        ))),
        _ => {
            let shown = ends.iter().take(12).map(|&(end, moving)| {
                format!("{} ({moving} joints)", quoted(tree.links[end].name))
            });
            let shown: Vec<_> = shown.collect();
            let more = if ends.len() > shown.len() { ", …" } else { "" };
            Err(ReadError::new(format!(
                "tip: got none, but the robot has {} ends; choose one of {}{more}, or a link \
                 before",
                ends.len(),
                shown.join(", ")
            )))
        }
    }
}

/// Refuses a joint between base and tip that is not moved by one motor of its own.
fn refuse_dependent(source: &Document, tree: &Tree, joint: usize) -> Result<(), ReadError> {
    let joint = &tree.joints[joint];
    let name = quoted(joint.name);
    let what = match (joint.joint_type, joint.mimic) {
        (JointType::Floating, _) => "a floating joint",
        (JointType::Planar, _) => "a planar joint",
        (_, None) => return Ok(()),
        (_, Some(at)) => {
            let message = format!(
                "joint {name}, <mimic>: got a joint that follows another, wants independent ones \
                 between base and \
                 tip; choose a tip before it, or make it fixed"
            );
            return Err(source.error(at, message));
        }
    };
    let message = format!(
        "joint {name}: got {what}, wants revolute, continuous, prismatic or fixed ones between \
         base and tip; choose a \
         base beyond it"
    );
    Err(source.error(joint.at, message))
}

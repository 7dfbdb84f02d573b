//! `<link>`: its name and its `<inertial>`.

use nalgebra::Vector3;
use roxmltree::Node;

use super::elements::Source;
use crate::arm::{Inertia, Pose};
use crate::math::Matrix;
use crate::robot::error::quoted;
use crate::robot::{ReadError, checks, frames};

/// A link, its mass distribution in its own frame.
pub(super) struct LinkPart {
    pub name: String,
    pub at: usize,
    pub inertia: Option<Inertia>,
}

impl LinkPart {
    pub fn read(source: &Source, node: Node) -> Result<Self, ReadError> {
        let name = source.text(node, "name", "link")?;
        let owner = format!("link {}", quoted(name));
        let inertia = match source.child(node, "inertial", &owner)? {
            Some(inertial) => Some(inertia(source, inertial, &owner)?),
            None => None,
        };
        Ok(Self { name: name.to_owned(), at: node.range().start, inertia })
    }
}

/// `<origin>`, or no displacement.
pub(super) fn origin(source: &Source, parent: Node, owner: &str) -> Result<Pose, ReadError> {
    let Some(node) = source.child(parent, "origin", owner)? else { return Ok(frames::identity()) };
    let xyz = source.three(node, "xyz", owner)?.unwrap_or_default();
    let rpy = source.three(node, "rpy", owner)?.unwrap_or_default();
    Ok(Pose { rotation: frames::roll_pitch_yaw(rpy), translation: xyz.into() })
}

fn inertia(source: &Source, node: Node, owner: &str) -> Result<Inertia, ReadError> {
    let at = node.range().start;
    let needed = |name: &str| {
        source.child(node, name, owner)?.ok_or_else(|| {
            source.error(at, format!("{owner}: got <inertial> without <{name}>, wants one"))
        })
    };
    let frame = origin(source, node, owner)?;
    let mass_node = needed("mass")?;
    let mass = source.required(mass_node, "value", owner)?;
    let inertia_node = needed("inertia")?;
    let entry = |name: &str| source.required(inertia_node, name, owner);
    let (xx, yy, zz) = (entry("ixx")?, entry("iyy")?, entry("izz")?);
    let (xy, xz, yz) = (entry("ixy")?, entry("ixz")?, entry("iyz")?);
    let moments = Matrix::<3>::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    if mass < 0.0 {
        let message = format!("{owner}, <mass value>: got {mass}, wants a number >= 0");
        return Err(source.error(mass_node.range().start, message));
    }
    let inertia = Inertia { mass, com: Vector3::zeros(), moments };
    checks::inertia(&inertia).map_err(|problem| {
        source.error(inertia_node.range().start, format!("{owner}, <inertia>, {problem}"))
    })?;
    Ok(frames::carried(&inertia, &frame))
}

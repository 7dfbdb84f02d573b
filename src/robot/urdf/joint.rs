//! `<joint>`: what it connects, how it moves, and what it can do.

use nalgebra::Vector3;
use roxmltree::Node;

use super::elements::{Document, attribute_at};
use crate::arm::{JointLimits, Pose};
use crate::robot::ReadError;
use crate::robot::error::quoted;

/// How a joint of a URDF moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum JointType {
    Fixed,
    Revolute,
    Continuous,
    Prismatic,
    Floating,
    Planar,
}

/// A joint: what it connects, and how it moves. The rest is read where it counts.
pub(super) struct JointPart<'n, 'i> {
    pub name: &'n str,
    pub at: usize,
    pub joint_type: JointType,
    pub parent: &'n str,
    pub child: &'n str,
    /// Where it says that it follows another joint.
    pub mimic: Option<usize>,
    node: Node<'n, 'i>,
}

/// What a joint that moves can do.
pub(super) struct Drive {
    pub axis: Vector3<f64>,
    pub limits: JointLimits,
    pub damping: f64,
    pub friction: f64,
    /// What was not taken as it stands.
    pub notes: Vec<String>,
}

const NO_LIMITS: JointLimits = JointLimits {
    lower: f64::NEG_INFINITY,
    upper: f64::INFINITY,
    velocity: f64::INFINITY,
    effort: f64::INFINITY,
};

impl<'n, 'i> JointPart<'n, 'i> {
    pub fn read(source: &Document, node: Node<'n, 'i>) -> Result<Self, ReadError> {
        let name = source.text(node, "name", "joint")?;
        let owner = format!("joint {}", quoted(name));
        Ok(Self {
            name,
            at: node.range().start,
            joint_type: joint_type(source, node, &owner)?,
            parent: end(source, node, "parent", &owner)?,
            child: end(source, node, "child", &owner)?,
            mimic: source.child(node, "mimic", &owner)?.map(|mimic| mimic.range().start),
            node,
        })
    }

    fn owner(&self) -> String {
        format!("joint {}", quoted(self.name))
    }

    /// Its frame in that of the parent.
    pub fn origin(&self, source: &Document) -> Result<Pose, ReadError> {
        source.refuse_macros(self.node)?;
        source.origin(self.node, &self.owner())
    }

    /// Axis, limits and friction.
    pub fn drive(&self, source: &Document) -> Result<Drive, ReadError> {
        let (node, owner) = (self.node, self.owner());
        let mut notes = Vec::new();
        let (damping, friction) = match source.child(node, "dynamics", &owner)? {
            None => (0.0, 0.0),
            Some(dynamics) => (
                source.at_least_zero(dynamics, "damping", &owner)?,
                source.at_least_zero(dynamics, "friction", &owner)?,
            ),
        };
        Ok(Drive {
            axis: axis(source, node, &owner, self.joint_type)?,
            limits: limits(source, node, &owner, self.joint_type, &mut notes)?,
            damping,
            friction,
            notes,
        })
    }

    pub fn moves(&self) -> bool {
        self.joint_type != JointType::Fixed
    }
}

fn joint_type(source: &Document, node: Node, owner: &str) -> Result<JointType, ReadError> {
    Ok(match source.text(node, "type", owner)? {
        "fixed" => JointType::Fixed,
        "revolute" => JointType::Revolute,
        "continuous" => JointType::Continuous,
        "prismatic" => JointType::Prismatic,
        "floating" => JointType::Floating,
        "planar" => JointType::Planar,
        other => {
            let message = format!(
                "{owner}, type: got {}, wants revolute, continuous, prismatic, fixed, floating or \
                 planar",
                quoted(other)
            );
            return Err(source.error(attribute_at(node, "type"), message));
        }
    })
}

/// The link that `<parent>` or `<child>` names.
fn end<'n>(
    source: &Document,
    node: Node<'n, '_>,
    which: &str,
    owner: &str,
) -> Result<&'n str, ReadError> {
    match source.child(node, which, owner)? {
        Some(end) => source.text(end, "link", owner),
        None => {
            let message = format!("{owner}: got no <{which}>, wants <{which} link=\"…\"/>");
            Err(source.error(node.range().start, message))
        }
    }
}

/// The axis, of length 1; x where the file does not say.
fn axis(
    source: &Document,
    node: Node,
    owner: &str,
    joint_type: JointType,
) -> Result<Vector3<f64>, ReadError> {
    if matches!(joint_type, JointType::Fixed | JointType::Floating) {
        return Ok(Vector3::x());
    }
    let Some(element) = source.child(node, "axis", owner)? else { return Ok(Vector3::x()) };
    let Some(xyz) = source.three(element, "xyz", owner)? else {
        let message = format!("{owner}: got <axis> without xyz, wants <axis xyz=\"…\"/>");
        return Err(source.error(element.range().start, message));
    };
    // Scaled first, so that the squares neither overflow nor vanish.
    let axis = Vector3::from(xyz);
    let largest = axis.amax();
    if largest == 0.0 {
        let message =
            format!("{owner}, <axis xyz>: got no direction, wants a vector that is not 0");
        return Err(source.error(attribute_at(element, "xyz"), message));
    }
    let scaled = axis / largest;
    Ok(if is_unit(&axis) { axis } else { scaled / scaled.norm() })
}

/// True for the six directions along the frame's axes, which keep their bits.
fn is_unit(axis: &Vector3<f64>) -> bool {
    axis.iter().filter(|x| x.abs() == 1.0).count() == 1
        && axis.iter().filter(|x| **x == 0.0).count() == 2
}

fn limits(
    source: &Document,
    node: Node,
    owner: &str,
    joint_type: JointType,
    notes: &mut Vec<String>,
) -> Result<JointLimits, ReadError> {
    if !matches!(joint_type, JointType::Revolute | JointType::Continuous | JointType::Prismatic) {
        return Ok(NO_LIMITS);
    }
    let Some(limit) = source.child(node, "limit", owner)? else {
        if joint_type != JointType::Continuous {
            notes.push(format!("{owner}: states no <limit>, taken as unlimited"));
        }
        return Ok(NO_LIMITS);
    };
    let (lower, upper) = match joint_type {
        JointType::Continuous => (f64::NEG_INFINITY, f64::INFINITY),
        _ => range(source, limit, owner, notes)?,
    };
    let mut most = |name: &str| match source.number(limit, name, owner, true)? {
        Some(value) if value < 0.0 => Err(source.error(
            attribute_at(limit, name),
            format!("{owner}, <limit {name}>: got {value}, wants a number >= 0"),
        )),
        Some(0.0) => {
            notes.push(format!("{owner}: <limit {name}=\"0\"> taken as no limit"));
            Ok(f64::INFINITY)
        }
        value => Ok(value.unwrap_or(f64::INFINITY)),
    };
    Ok(JointLimits { lower, upper, velocity: most("velocity")?, effort: most("effort")? })
}

/// Lower and upper; both 0, or both absent, are none.
fn range(
    source: &Document,
    limit: Node,
    owner: &str,
    notes: &mut Vec<String>,
) -> Result<(f64, f64), ReadError> {
    let lower = source.number(limit, "lower", owner, true)?.unwrap_or(0.0);
    let upper = source.number(limit, "upper", owner, true)?.unwrap_or(0.0);
    if lower == 0.0 && upper == 0.0 {
        notes.push(format!("{owner}: <limit> with lower and upper 0 taken as no limit"));
        return Ok((f64::NEG_INFINITY, f64::INFINITY));
    }
    if lower <= upper && lower < f64::INFINITY && upper > f64::NEG_INFINITY {
        return Ok((lower, upper));
    }
    let message =
        format!("{owner}, <limit>: got lower {lower} and upper {upper}, wants lower <= upper");
    Err(source.error(attribute_at(limit, "lower"), message))
}

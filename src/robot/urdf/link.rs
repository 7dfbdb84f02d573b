//! `<link>`: its name and its `<inertial>`.

use nalgebra::Vector3;
use roxmltree::Node;

use super::elements::Document;
use super::solid;
use crate::arm::Inertia;
use crate::math::Matrix;
use crate::robot::error::quoted;
use crate::robot::{ReadError, checks};

/// A link; its `<inertial>` is read where its mass counts.
pub(super) struct LinkPart<'n, 'i> {
    pub name: &'n str,
    pub at: usize,
    node: Node<'n, 'i>,
}

/// `<inertial>`, in the link's frame.
pub(super) struct Inertial {
    pub inertia: Inertia,
    mass_at: usize,
    moments_at: usize,
}

impl Inertial {
    /// One that does not stand in the file, for the link at the byte `at`.
    pub fn given(inertia: Inertia, at: usize) -> Self {
        Self { inertia, mass_at: at, moments_at: at }
    }
}

impl<'n, 'i> LinkPart<'n, 'i> {
    pub fn read(source: &Document, node: Node<'n, 'i>) -> Result<Self, ReadError> {
        Ok(Self { name: source.text(node, "name", "link")?, at: node.range().start, node })
    }

    /// `<inertial>`, if there is one.
    pub fn inertial(&self, source: &Document) -> Result<Option<Inertial>, ReadError> {
        source.refuse_macros(self.node)?;
        let owner = format!("link {}", quoted(self.name));
        let element = source.child(self.node, "inertial", &owner)?;
        element.map(|element| inertial(source, element, &owner)).transpose()
    }

    /// The uniform body of this mass in the link's shape, and the element that gives the shape.
    pub fn uniform(
        &self,
        source: &Document,
        mass: f64,
    ) -> Result<Option<(Inertia, &'static str)>, ReadError> {
        solid::uniform(source, self.node, &format!("link {}", quoted(self.name)), mass)
    }

    /// The complaint about a mass distribution that no rigid body can have, if it is one.
    pub fn problem(&self, source: &Document, inertial: &Inertial, more: &str) -> Option<ReadError> {
        let Inertial { inertia, mass_at, moments_at } = inertial;
        let problem = checks::body_problem(inertia)?;
        let owner = format!("link {}", quoted(self.name));
        Some(match problem.strip_prefix("mass: ").filter(|_| inertia.mass < 0.0) {
            Some(problem) => {
                source.error(*mass_at, format!("{owner}, <mass value>: {problem}{more}"))
            }
            None => source.error(*moments_at, format!("{owner}, <inertia>, {problem}{more}")),
        })
    }
}

fn inertial(source: &Document, node: Node, owner: &str) -> Result<Inertial, ReadError> {
    source.refuse_macros(node)?;
    let at = node.range().start;
    let needed = |name: &str| {
        source.child(node, name, owner)?.ok_or_else(|| {
            source.error(at, format!("{owner}: got <inertial> without <{name}>, wants one"))
        })
    };
    let frame = source.origin(node, owner)?;
    let mass_node = needed("mass")?;
    let mass = source.required(mass_node, "value", owner)?;
    let moments_node = needed("inertia")?;
    let entry = |name: &str| source.required(moments_node, name, owner);
    let (xx, yy, zz) = (entry("ixx")?, entry("iyy")?, entry("izz")?);
    let (xy, xz, yz) = (entry("ixy")?, entry("ixz")?, entry("iyz")?);
    let moments = Matrix::<3>::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    Ok(Inertial {
        inertia: Inertia { mass, com: Vector3::zeros(), moments }.transformed(&frame),
        mass_at: mass_node.range().start,
        moments_at: moments_node.range().start,
    })
}

//! The uniform body in the shape of a link, where the file gives that by boxes, cylinders and
//! balls.
//!
//! Volumes: x y z; π r² l; 4/3 π r³. Moments of a mass m: m/12 (y² + z²) about x, and so on;
//! m r²/2 about the cylinder's axis and m/12 (3 r² + l²) across; 2/5 m r². Shapes that overlap
//! count twice where they do.

use core::f64::consts::PI;

use nalgebra::Vector3;
use roxmltree::Node;

use super::elements::Document;
use crate::arm::Inertia;
use crate::math::Matrix;
use crate::robot::ReadError;

/// The body of this mass in the shape of `<collision>`, or else of `<visual>`, and which of them.
/// None if there is no shape, or one that is a mesh: meshes are never opened.
pub(super) fn uniform(
    source: &Document,
    link: Node,
    owner: &str,
    mass: f64,
) -> Result<Option<(Inertia, &'static str)>, ReadError> {
    for which in ["collision", "visual"] {
        let mut parts = Vec::new();
        for shape in link.children().filter(|node| node.has_tag_name(which)) {
            if let Some(geometry) = source.child(shape, "geometry", owner)? {
                parts.push(part(source, shape, geometry, owner)?);
            }
        }
        let parts: Option<Vec<_>> = parts.into_iter().collect();
        let body: Inertia = parts.unwrap_or_default().into_iter().sum();
        if body.mass > 0.0 {
            let moments = body.moments * (mass / body.mass);
            return Ok(Some((Inertia { mass, moments, com: body.com }, which)));
        }
    }
    Ok(None)
}

/// A shape of density 1 in the link's frame; none for a mesh.
fn part(
    source: &Document,
    shape: Node,
    geometry: Node,
    owner: &str,
) -> Result<Option<Inertia>, ReadError> {
    let Some(solid) = geometry.children().find(Node::is_element) else { return Ok(None) };
    let length = |name| source.required(solid, name, owner).map(f64::abs);
    let (mass, moments) = match source.name(solid) {
        "box" => {
            let Some(size) = source.three(solid, "size", owner)? else { return Ok(None) };
            let [x, y, z] = size.map(f64::abs);
            let squares = [y * y + z * z, z * z + x * x, x * x + y * y];
            (x * y * z, squares.map(|square| square / 12.0))
        }
        "cylinder" => {
            let (r, l) = (length("radius")?, length("length")?);
            let across = (3.0 * r * r + l * l) / 12.0;
            (PI * r * r * l, [across, across, 0.5 * r * r])
        }
        "sphere" => {
            let r = length("radius")?;
            (4.0 / 3.0 * PI * r * r * r, [0.4 * r * r; 3])
        }
        _ => return Ok(None),
    };
    let moments = Matrix::<3>::from_diagonal(&(Vector3::from(moments) * mass));
    let inertia = Inertia { mass, com: Vector3::zeros(), moments };
    Ok(Some(inertia.transformed(&source.origin(shape, owner)?)))
}

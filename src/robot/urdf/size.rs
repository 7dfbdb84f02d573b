//! Mass distributions that a body can have, but hardly a robot's.

use crate::math::sqrt;
use crate::robot::JointDescription;
use crate::robot::error::quoted;

/// The densest matter is osmium [kg/m³].
const DENSEST: f64 = 22_590.0;
/// Radii of gyration beyond this are noted [m]: that of a uniform rod of 3.5 m about its middle.
const WIDE: f64 = 1.0;
/// Beyond this, moments in kg·mm² are the likeliest reason [m]: they make √(I/m) a thousand times
/// too large.
const MILLIMETRES: f64 = 10.0;

/// A note on the body that a joint moves, if its moments are too small for any matter or too large
/// for a robot.
pub(super) fn note(joint: &JointDescription) -> Option<String> {
    let inertia = &joint.link.inertia;
    let mass = Some(inertia.mass).filter(|&mass| mass > 0.0)?;
    let link = quoted(&joint.link_name);
    // Of all bodies of a mass and at most a density, a ball has the least I_xx + I_yy + I_zz = 6/5
    // m r².
    let ball = libm::cbrt(3.0 * mass / (4.0 * core::f64::consts::PI * DENSEST));
    let trace = inertia.moments.trace();
    if trace < 1.2 * mass * ball * ball {
        return Some(format!(
            "link {link}: {mass} kg with moments of {trace:.2e} kg m^2 in all, less than a ball \
             of the densest metal has: taken \
             as stated"
        ));
    }
    // Of a thin rod I_xx + I_yy + I_zz is twice the moment about its middle.
    let radius = sqrt(0.5 * trace / mass);
    (radius > WIDE).then(|| {
        let unit = match radius > MILLIMETRES {
            true => "; do they stand in kg mm^2?",
            false => "",
        };
        format!(
            "link {link}: {mass} kg with moments as of a radius of gyration of {radius:.3} m, \
             which is much for a robot: taken \
             as stated{unit}"
        )
    })
}

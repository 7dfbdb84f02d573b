//! The file as it is written down.

use nalgebra::Vector3;
use serde::Deserialize;
use toml::Spanned;

use crate::arm::{
    Inertia, JointFriction, JointKind, JointLimits, JointStop, Link, Pose, Unphysical,
};
use crate::math::Matrix;
use crate::robot::{Description, GRAVITY, JointDescription};

type Rows = [[f64; 3]; 3];

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct File {
    pub format: u32,
    name: String,
    #[serde(default = "usual_gravity")]
    gravity: [f64; 3],
    #[serde(default)]
    notes: Vec<String>,
    #[serde(default, with = "Policy")]
    unphysical: Unphysical,
    #[serde(default)]
    tip: Place,
    #[serde(default)]
    pub joint: Vec<Spanned<Joint>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Place {
    #[serde(default)]
    translation: [f64; 3],
    #[serde(default = "no_rotation")]
    rotation: Rows,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Joint {
    name: String,
    link: String,
    kind: Kind,
    axis: [f64; 3],
    #[serde(default)]
    translation: [f64; 3],
    #[serde(default = "no_rotation")]
    rotation: Rows,
    mass: f64,
    com: [f64; 3],
    moments: Rows,
    #[serde(default)]
    armature: f64,
    #[serde(default)]
    friction: Friction,
    #[serde(default)]
    limits: Limits,
    stop: Option<Stop>,
}

#[derive(Deserialize)]
#[serde(rename_all = "lowercase")]
enum Kind {
    Revolute,
    Continuous,
    Prismatic,
}

#[derive(Deserialize)]
#[serde(remote = "Unphysical", rename_all = "lowercase")]
enum Policy {
    Refuse,
    Note,
    Nearest,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, default)]
struct Friction {
    viscous: f64,
    coulomb: [f64; 2],
    stribeck: f64,
    stribeck_speed: f64,
    smoothing: f64,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct Limits {
    lower: Option<f64>,
    upper: Option<f64>,
    velocity: Option<f64>,
    effort: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "stiffness and dissipation")]
struct Stop {
    stiffness: f64,
    #[serde(default)]
    dissipation: f64,
}

fn usual_gravity() -> [f64; 3] {
    GRAVITY
}

fn no_rotation() -> Rows {
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
}

fn matrix(rows: Rows) -> Matrix<3> {
    Matrix::<3>::from_fn(|i, j| rows[i][j])
}

impl Default for Place {
    fn default() -> Self {
        Self { translation: [0.0; 3], rotation: no_rotation() }
    }
}

impl Default for Friction {
    fn default() -> Self {
        let JointFriction { viscous, coulomb, stribeck, stribeck_speed, smoothing } =
            JointFriction::default();
        Self { viscous, coulomb, stribeck, stribeck_speed, smoothing }
    }
}

impl File {
    pub fn description(self) -> Description {
        Description {
            name: self.name,
            joints: self.joint.into_iter().map(|joint| joint.into_inner().description()).collect(),
            tip: pose(self.tip.translation, self.tip.rotation),
            gravity: self.gravity,
            notes: self.notes,
            unphysical: self.unphysical,
        }
    }
}

fn pose(translation: [f64; 3], rotation: Rows) -> Pose {
    Pose { rotation: matrix(rotation), translation: translation.into() }
}

impl Joint {
    fn description(self) -> JointDescription {
        let Friction { viscous, coulomb, stribeck, stribeck_speed, smoothing } = self.friction;
        let link = Link {
            kind: match self.kind {
                Kind::Revolute => JointKind::Revolute,
                Kind::Continuous => JointKind::Continuous,
                Kind::Prismatic => JointKind::Prismatic,
            },
            placement: pose(self.translation, self.rotation),
            axis: Vector3::from(self.axis),
            inertia: Inertia {
                mass: self.mass,
                com: Vector3::from(self.com),
                moments: matrix(self.moments),
            },
            friction: JointFriction { viscous, coulomb, stribeck, stribeck_speed, smoothing },
            armature: self.armature,
            limits: JointLimits {
                lower: self.limits.lower.unwrap_or(JointLimits::NONE.lower),
                upper: self.limits.upper.unwrap_or(JointLimits::NONE.upper),
                velocity: self.limits.velocity.unwrap_or(JointLimits::NONE.velocity),
                effort: self.limits.effort.unwrap_or(JointLimits::NONE.effort),
            },
            stop: self.stop.map_or_else(JointStop::default, |Stop { stiffness, dissipation }| {
                JointStop { stiffness, dissipation }
            }),
        };
        JointDescription { name: self.name, link_name: self.link, link }
    }
}

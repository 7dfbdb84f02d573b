//! Kinematics and energies of a chain, written out from the definitions: the oracle for what is
//! read.

use nalgebra::{DMatrix, DVector, Isometry3, Matrix3, Translation3, UnitQuaternion, Vector3};
use steadyarm::arm::{JointKind, Pose};
use steadyarm::robot::Description;

/// x_outer = R x_inner + p.
#[derive(Clone, Copy)]
pub struct Frame(pub Matrix3<f64>, pub Vector3<f64>);

impl Frame {
    fn of(pose: &Pose) -> Self {
        Self(pose.rotation, pose.translation)
    }

    fn then(self, inner: Self) -> Self {
        Self(self.0 * inner.0, self.0 * inner.1 + self.1)
    }
}

/// The frames of the links, and that of the tip, in the base's.
pub fn frames(arm: &Description, q: &[f64]) -> (Vec<Frame>, Frame) {
    let mut at = Frame(Matrix3::identity(), Vector3::zeros());
    let mut frames = Vec::new();
    for (joint, &q) in arm.joints.iter().zip(q) {
        let link = &joint.link;
        let axis = nalgebra::Unit::new_normalize(link.axis);
        let moved: Isometry3<f64> = match link.kind {
            JointKind::Revolute | JointKind::Continuous => Isometry3::from_parts(
                Translation3::identity(),
                UnitQuaternion::from_axis_angle(&axis, q),
            ),
            JointKind::Prismatic => {
                Isometry3::from_parts(Translation3::from(link.axis * q), UnitQuaternion::identity())
            }
        };
        let moved = Frame(*moved.rotation.to_rotation_matrix().matrix(), moved.translation.vector);
        at = at.then(Frame::of(&link.placement)).then(moved);
        frames.push(at);
    }
    (frames, at.then(Frame::of(&arm.tip)))
}

/// M(q) = Σ mₖ JᵥᵀJᵥ + J_ωᵀ R I Rᵀ J_ω, with the rotors.
pub fn mass_matrix(arm: &Description, q: &[f64]) -> DMatrix<f64> {
    let n = arm.joints.len();
    let (frames, _) = frames(arm, q);
    let mut mass = DMatrix::zeros(n, n);
    for (k, joint) in arm.joints.iter().enumerate() {
        let (linear, angular) = jacobian(arm, &frames, k);
        let Frame(r, _) = frames[k];
        let inertia = &joint.link.inertia;
        let moments = r * inertia.moments * r.transpose();
        mass += linear.transpose() * &linear * inertia.mass;
        mass += angular.transpose() * moments * &angular;
        mass[(k, k)] += joint.link.armature;
    }
    mass
}

/// G(q) = −Σ mₖ Jᵥᵀ g.
pub fn gravity(arm: &Description, q: &[f64]) -> DVector<f64> {
    let (frames, _) = frames(arm, q);
    let weight = |k: usize| {
        let force = Vector3::from(arm.gravity) * arm.joints[k].link.inertia.mass;
        -(jacobian(arm, &frames, k).0.transpose() * force)
    };
    (0..arm.joints.len()).map(weight).sum()
}

type Rows = nalgebra::OMatrix<f64, nalgebra::U3, nalgebra::Dyn>;

/// Velocity of the centre of mass of link `k`, and its angular velocity, per joint velocity.
fn jacobian(arm: &Description, frames: &[Frame], k: usize) -> (Rows, Rows) {
    let n = arm.joints.len();
    let com = frames[k].0 * arm.joints[k].link.inertia.com + frames[k].1;
    let (mut linear, mut angular) = (Rows::zeros(n), Rows::zeros(n));
    for j in 0..=k {
        let axis = frames[j].0 * arm.joints[j].link.axis;
        match arm.joints[j].link.kind {
            JointKind::Revolute | JointKind::Continuous => {
                linear.set_column(j, &axis.cross(&(com - frames[j].1)));
                angular.set_column(j, &axis);
            }
            JointKind::Prismatic => linear.set_column(j, &axis),
        }
    }
    (linear, angular)
}

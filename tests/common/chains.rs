//! Random chains, and a second model of them straight from Lagrange: link poses by Rodrigues'
//! formula, M from the links' Jacobians. It shares no code with the crate's.

use nalgebra::{Matrix3, SMatrix, Vector3};
use steadyarm::arm::{
    Inertia, JointFriction, JointKind, JointLimits, JointStop, Link, Pose, Serial, SerialParameters,
};
use steadyarm::math::{Matrix, Vector};

use crate::random::Random;

pub const CHAINS_PER_LENGTH: usize = 125;

/// Runs a property on 1000 random chains of 1 to 8 joints.
macro_rules! on_chains {
    ($property:ident) => {
        #[test]
        fn $property() {
            on_chains!(@lengths $property, crate::chains::CHAINS_PER_LENGTH);
        }
    };
    (@lengths $property:ident, $count:expr) => {
        on_chains!(@each $property, $count, 1 2 3 4 5 6 7 8)
    };
    (@each $property:ident, $count:expr, $($n:literal)*) => {
        $(for seed in 0..$count as u64 {
            let mut random = crate::random::Random(1000 * $n + seed);
            let arm = crate::chains::chain::<$n>(&mut random);
            of::$property::<$n>(&arm, &mut random);
        })*
    };
}
pub(crate) use on_chains;

pub fn vector<const N: usize>(random: &mut Random, size: f64) -> Vector<N> {
    random.matrix::<N, 1>() * size
}

fn vector3(random: &mut Random, size: f64) -> Vector3<f64> {
    random.matrix::<3, 1>() * size
}

/// Rodrigues: the turn by `angle` about the unit vector `axis`.
pub fn rodrigues(axis: &Vector3<f64>, angle: f64) -> Matrix3<f64> {
    let k = axis.cross_matrix();
    Matrix3::identity() + k * angle.sin() + k * k * (1.0 - angle.cos())
}

/// Any axis, or one of the frame's.
pub fn axis(random: &mut Random) -> Vector3<f64> {
    let mut axis = vector3(random, 1.0);
    if random.next() < 0.0 {
        let (k, sign) = (axis.imax(), axis[axis.imax()].signum());
        axis = Vector3::zeros();
        axis[k] = sign;
    }
    axis.normalize()
}

/// Any rotation, a quarter or half turn, or none.
pub fn rotation(random: &mut Random) -> Matrix3<f64> {
    let about = axis(random);
    let quarter = core::f64::consts::FRAC_PI_2;
    let angle = match random.between(0.0, 4.0) {
        ..1.0 => 0.0,
        1.0..2.0 => (random.between(-3.0, 3.0)).round() * quarter,
        _ => random.between(-3.0, 3.0),
    };
    rodrigues(&about, angle)
}

pub fn pose(random: &mut Random) -> Pose {
    let parallel = random.next() < -0.7;
    Pose::new(rotation(random), if parallel { Vector3::zeros() } else { vector3(random, 0.5) })
}

/// Six points of mass: any such inertia can exist.
pub fn inertia(random: &mut Random) -> Inertia {
    let points = [(); 6].map(|()| (random.between(0.05, 1.0), vector3(random, 0.3)));
    let mass = points.iter().map(|p| p.0).sum::<f64>();
    let com = points.iter().map(|p| p.1 * p.0).sum::<Vector3<f64>>() / mass;
    let mut moments = Matrix3::zeros();
    for (m, x) in points {
        let k = (x - com).cross_matrix();
        moments -= k * k * m;
    }
    Inertia { mass, com, moments: (moments + moments.transpose()) * 0.5 }
}

pub fn friction(random: &mut Random) -> JointFriction {
    let mut some = |high| if random.next() < 0.0 { 0.0 } else { random.between(0.0, high) };
    let (viscous, stribeck) = (some(2.0), some(1.0));
    let coulomb = [some(2.0), some(2.0)];
    let (smoothing, stribeck_speed) = (random.between(0.01, 1.0), random.between(0.05, 1.0));
    JointFriction { viscous, coulomb, stribeck, stribeck_speed, smoothing }
}

pub fn link(random: &mut Random) -> Link {
    let kind = if random.next() < -0.4 { JointKind::Prismatic } else { JointKind::Revolute };
    let armature = if random.next() < 0.0 { 0.0 } else { random.between(0.0, 0.5) };
    Link {
        kind,
        placement: pose(random),
        axis: axis(random),
        inertia: inertia(random),
        friction: friction(random),
        armature,
        limits: JointLimits { lower: -3.0, upper: 3.0, velocity: 2.0, effort: 100.0 },
        stop: JointStop::default(),
    }
}

pub fn chain<const N: usize>(random: &mut Random) -> Serial<N> {
    let links = [(); N].map(|()| link(random));
    let gravity = vector3(random, 10.0).into();
    Serial::new(SerialParameters { links, tip: pose(random), gravity }).unwrap()
}

/// Poses of the joints' frames in the base, each from the one before.
pub fn poses<const N: usize>(arm: &Serial<N>, q: &Vector<N>) -> [Pose; N] {
    let mut at = Pose::IDENTITY;
    core::array::from_fn(|i| {
        let link = &arm.links()[i];
        let moved = match link.kind {
            JointKind::Revolute | JointKind::Continuous => {
                Pose::new(rodrigues(&link.axis, q[i]), Vector3::zeros())
            }
            JointKind::Prismatic => Pose::at(link.axis * q[i]),
        };
        at = at.then(&link.placement).then(&moved);
        at
    })
}

/// Jacobians of a point that rides on link `i`: its velocity and the link's angular velocity.
pub fn jacobians<const N: usize>(
    arm: &Serial<N>,
    poses: &[Pose; N],
    i: usize,
    point: &Vector3<f64>,
) -> (SMatrix<f64, 3, N>, SMatrix<f64, 3, N>) {
    let (mut linear, mut angular) = (SMatrix::<f64, 3, N>::zeros(), SMatrix::<f64, 3, N>::zeros());
    for j in 0..=i {
        let link = &arm.links()[j];
        let z = poses[j].rotation * link.axis;
        match link.kind {
            JointKind::Revolute | JointKind::Continuous => {
                linear.set_column(j, &z.cross(&(point - poses[j].translation)));
                angular.set_column(j, &z);
            }
            JointKind::Prismatic => linear.set_column(j, &z),
        }
    }
    (linear, angular)
}

/// M = Σ m JᵥᵀJᵥ + Jᵥᵥᵀ I Jᵥᵥ + armature, G = −Σ m Jᵥᵀ g, U = −Σ m gᵀ c.
pub fn lagrange<const N: usize>(arm: &Serial<N>, q: &Vector<N>) -> (Matrix<N>, Vector<N>, f64) {
    let poses = poses(arm, q);
    let g = Vector3::from(arm.parameters().gravity);
    let (mut mass, mut gravity, mut energy) = (Matrix::<N>::zeros(), Vector::<N>::zeros(), 0.0);
    for (i, link) in arm.links().iter().enumerate() {
        let (m, com) = (link.inertia.mass, poses[i].point(&link.inertia.com));
        let (linear, angular) = jacobians(arm, &poses, i, &com);
        let r = poses[i].rotation;
        mass += linear.transpose() * linear * m;
        mass += angular.transpose() * (r * link.inertia.moments * r.transpose()) * angular;
        mass[(i, i)] += link.armature;
        gravity -= linear.transpose() * g * m;
        energy -= m * g.dot(&com);
    }
    (mass, gravity, energy)
}

/// ∂M/∂q_k from differences of fourth order.
pub fn mass_slope<const N: usize>(arm: &Serial<N>, q: &Vector<N>, k: usize) -> Matrix<N> {
    const H: f64 = 2e-3;
    let at = |steps: f64| {
        let mut moved = *q;
        moved[k] += steps * H;
        lagrange(arm, &moved).0
    };
    ((at(1.0) - at(-1.0)) * 8.0 - (at(2.0) - at(-2.0))) / (12.0 * H)
}

/// Christoffel's C, `C_ij = ½ Σ (∂M_ij/∂q_k + ∂M_ik/∂q_j − ∂M_jk/∂q_i) q̇_k`, and Ṁ.
pub fn christoffel<const N: usize>(
    arm: &Serial<N>,
    q: &Vector<N>,
    dq: &Vector<N>,
) -> (Matrix<N>, Matrix<N>) {
    let slopes: Vec<_> = (0..N).map(|k| mass_slope(arm, q, k)).collect();
    let c = Matrix::<N>::from_fn(|i, j| {
        let term = |k: usize| slopes[k][(i, j)] + slopes[j][(i, k)] - slopes[i][(j, k)];
        0.5 * (0..N).map(|k| term(k) * dq[k]).sum::<f64>()
    });
    let rate = slopes.iter().zip(dq.iter()).map(|(slope, v)| slope * *v).sum();
    (c, rate)
}

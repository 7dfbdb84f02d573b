//! A chain prepared for the recursions. Every joint's axis is the z of its own frame, and two
//! frames differ by `R_x(α) R_z(θ)` and a shift p. The part of a link's mass that its own joint
//! does not feel is counted with the link before.
//!
//! The mass distribution is `m = ∫dm`, `h = ∫r dm`, `Σ = ∫r rᵀ dm` about the frame's origin. A line
//! of mass on the axis of a revolute joint (m, h_z, Σ_zz) does not load that joint and does not
//! move with it, so it may belong to the link before. The same is true of the Σ of a sliding link.
//! Source: Khalil and Dombre, Modeling, Identification and Control of Robots, 9.4.2.

use super::space::{Sym3, Turn, V3};
use super::unphysical::second_moments;
use super::{Link, Pose, SerialParameters};
use crate::arm::JointFriction;
use crate::math::{Matrix, Real, Vector, sqrt};

/// m, h and Σ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Mass<T = f64> {
    pub m: T,
    pub h: V3<T>,
    pub sigma: Sym3<T>,
}

impl Mass {
    pub const ZERO: Self = Self { m: 0.0, h: V3::ZERO, sigma: Sym3::ZERO };
}

impl<T: Real> Mass<T> {
    /// The same distribution about the origin of the frame before:
    /// `Σ' = R Σ Rᵀ + R h pᵀ + p (R h)ᵀ + m p pᵀ`.
    #[inline(always)]
    pub fn inward(&self, turn: &Turn<T>) -> Self {
        let (h, p) = (turn.inward(self.h), turn.p);
        let k = h + p * self.m;
        let s = self.sigma.inward(turn);
        let sigma = Sym3 {
            xx: s.xx + (h.x * p.x + p.x * k.x),
            yy: s.yy + (h.y * p.y + p.y * k.y),
            zz: s.zz + (h.z * p.z + p.z * k.z),
            xy: s.xy + (h.x * p.y + p.x * k.y),
            xz: s.xz + (h.x * p.z + p.x * k.z),
            yz: s.yz + (h.y * p.z + p.y * k.z),
        };
        Self { m: self.m, h: k, sigma }
    }

    #[inline(always)]
    pub fn plus(&self, other: &Self) -> Self {
        Self { m: self.m + other.m, h: self.h + other.h, sigma: self.sigma + other.sigma }
    }
}

/// A joint and the link that it moves, prepared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Joint<T = f64> {
    pub revolute: bool,
    /// The frame in the one before at q = 0.
    pub rest: Turn<T>,
    /// What remains with this link.
    pub mass: Mass<T>,
    pub armature: T,
    pub friction: JointFriction,
    /// The joint's frame as its user gave it: x_user = A x.
    pub user: Matrix<3>,
}

impl<T: Real> Joint<T> {
    /// The frame in the one before at q.
    #[inline(always)]
    pub fn turn(&self, q: T) -> Turn<T> {
        let rest = &self.rest;
        if self.revolute {
            let (s, c) = q.sin_cos();
            Turn { c: rest.c * c - rest.s * s, s: rest.s * c + rest.c * s, ..*rest }
        } else {
            let p = V3::new(rest.p.x, rest.p.y - q * rest.sa, rest.p.z + q * rest.ca);
            Turn { p, ..*rest }
        }
    }
}

/// The prepared chain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Chain<const N: usize, T = f64> {
    pub joints: [Joint<T>; N],
    /// The prepared base's axes in the user's: x_base = B x.
    pub base: Matrix<3>,
    /// The tip in the last frame.
    pub tip: Pose,
    /// Gravity in the prepared base's axes [m/s²].
    pub gravity: V3<T>,
    /// Potential energy of the mass that came to belong to the ground \[J\].
    pub ground_energy: f64,
}

impl<const N: usize> Chain<N> {
    /// Prepares parameters that have been validated.
    pub fn new(parameters: &SerialParameters<N>) -> Self {
        let (mut base, mut before) = (Matrix::<3>::identity(), Matrix::<3>::identity());
        let mut joints = parameters.links.map(|link| plain(&link));
        for i in 0..N {
            let link = &parameters.links[i];
            let placement = orthonormal(&link.placement.rotation);
            let turned = ZxZ::of(&(before.transpose() * placement * joints[i].user));
            // The frame before turns about its own axis until its x is normal to both axes.
            let about = about_z(turned.before);
            if i == 0 {
                base *= about;
                before = base;
            } else {
                let rest = &mut joints[i - 1].rest;
                (rest.c, rest.s) = compose((rest.c, rest.s), turned.before);
                joints[i - 1].user *= about;
                before = joints[i - 1].user;
            }
            let p = (before.transpose() * link.placement.translation).into();
            let ((ca, sa), (c, s)) = (turned.tilt, turned.after);
            joints[i].rest = Turn { ca, sa, c, s, p };
            before = joints[i].user;
        }
        for (joint, link) in joints.iter_mut().zip(&parameters.links) {
            joint.mass = mass_in(&joint.user, link);
        }
        let gravity: V3 = (base.transpose() * nalgebra::Vector3::from(parameters.gravity)).into();
        let ground_energy = -gravity.dot(hand_down(&mut joints).h);
        let tip = Pose {
            rotation: before.transpose() * orthonormal(&parameters.tip.rotation),
            translation: before.transpose() * parameters.tip.translation,
        };
        Self { joints, base, tip, gravity, ground_energy }
    }
}

impl<const N: usize, T: Real> Chain<N, T> {
    /// The frames at q.
    #[inline(always)]
    pub fn turns(&self, q: &Vector<N, T>) -> [Turn<T>; N] {
        let mut turns = [self.joints[0].rest; N];
        for i in 0..N {
            turns[i] = self.joints[i].turn(q[i]);
        }
        turns
    }
}

/// A joint whose frame has its axis for z, with nothing known of the others yet.
#[inline(never)]
fn plain(link: &Link) -> Joint {
    Joint {
        revolute: link.kind.turns(),
        rest: Turn { ca: 1.0, sa: 0.0, c: 1.0, s: 0.0, p: V3::ZERO },
        mass: Mass::ZERO,
        armature: link.armature,
        friction: link.friction,
        user: with_z_along(&link.axis.normalize()),
    }
}

/// The mass distribution of a link in the axes of its prepared frame, about its origin.
#[inline(never)]
pub(super) fn mass_in(user: &Matrix<3>, link: &Link) -> Mass {
    let inertia = &link.inertia;
    let com = user.transpose() * inertia.com;
    let moments = user.transpose() * inertia.moments * user;
    let sigma = second_moments(&moments) + com * com.transpose() * inertia.mass;
    Mass { m: inertia.mass, h: (com * inertia.mass).into(), sigma: Sym3::of(&sigma) }
}

/// Gives the mass of every link that its own joint does not feel to the link before. Returns what
/// reaches the ground.
fn hand_down(joints: &mut [Joint]) -> Mass {
    let mut reached = Mass::ZERO;
    for i in (0..joints.len()).rev() {
        let joint = &mut joints[i];
        joint.mass = joint.mass.plus(&reached);
        let own = joint.mass;
        let line = if joint.revolute {
            Mass {
                m: own.m,
                h: V3::new(0.0, 0.0, own.h.z),
                sigma: Sym3 { zz: own.sigma.zz, ..Sym3::ZERO },
            }
        } else {
            Mass { sigma: own.sigma, ..Mass::ZERO }
        };
        joint.mass = if joint.revolute {
            Mass { m: 0.0, h: V3::new(own.h.x, own.h.y, 0.0), sigma: Sym3 { zz: 0.0, ..own.sigma } }
        } else {
            Mass { sigma: Sym3::ZERO, ..own }
        };
        reached = line.inward(&joint.rest);
    }
    reached
}

/// The rotation nearest to one that is orthonormal within 1e-6, to rounding: two Newton steps R ← R
/// (3 − RᵀR)/2.
#[inline(never)]
pub(super) fn orthonormal(rotation: &Matrix<3>) -> Matrix<3> {
    let step = |r: Matrix<3>| r * (Matrix::<3>::identity() * 3.0 - r.transpose() * r) * 0.5;
    step(step(*rotation))
}

/// A rotation whose third column is the unit vector `axis`; the identity for z, exact for x and y.
#[inline(never)]
fn with_z_along(axis: &nalgebra::Vector3<f64>) -> Matrix<3> {
    let least = axis.map(f64::abs).imin();
    let mut x = nalgebra::Vector3::zeros();
    x[least] = 1.0;
    let x = (x - axis * axis[least]).normalize();
    Matrix::<3>::from_columns(&[x, axis.cross(&x), *axis])
}

/// R = R_z(before) R_x(tilt) R_z(after), each angle as (cos, sin).
struct ZxZ {
    before: (f64, f64),
    tilt: (f64, f64),
    after: (f64, f64),
}

impl ZxZ {
    #[inline(never)]
    fn of(r: &Matrix<3>) -> Self {
        // R z = (sin β sin α, −cos β sin α, cos α)
        let across = sqrt(r[(0, 2)] * r[(0, 2)] + r[(1, 2)] * r[(1, 2)]);
        let before =
            if across > 0.0 { (-r[(1, 2)] / across, r[(0, 2)] / across) } else { (1.0, 0.0) };
        let tilt = unit(r[(2, 2)], across);
        let rest = about_x(tilt).transpose() * about_z(before).transpose() * r;
        Self { before, tilt, after: unit(rest[(0, 0)], rest[(1, 0)]) }
    }
}

fn unit(c: f64, s: f64) -> (f64, f64) {
    let size = sqrt(c * c + s * s);
    (c / size, s / size)
}

fn compose((c, s): (f64, f64), (co, so): (f64, f64)) -> (f64, f64) {
    unit(c * co - s * so, s * co + c * so)
}

fn about_z((c, s): (f64, f64)) -> Matrix<3> {
    Matrix::<3>::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0)
}

fn about_x((c, s): (f64, f64)) -> Matrix<3> {
    Matrix::<3>::new(1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c)
}

//! Any fixed-base chain of revolute and prismatic joints:
//! `M(q) q̈ + C(q, q̇) q̇ + G(q) + f(q̇) + s(q, q̇) = τ`.
//!
//! M carries the armature on its diagonal. Construction turns every frame so that its joint's axis
//! is z and the next frame differs by two plane rotations. The recursions then cost one sine and
//! cosine per joint and few products.

#[cfg(feature = "std")]
mod abreast;
mod articulated;
mod body;
mod changes;
mod composite;
mod inertia;
mod inverse;
mod joint;
mod kinematics;
mod limits;
mod link;
mod links;
mod parameters;
mod perturb;
mod place;
mod regressor;
mod space;
mod stop;
mod unphysical;
mod validate;

pub use body::{Inertia, Pose};
pub use limits::JointLimits;
pub use link::{JointKind, Link};
pub use parameters::SerialParameters;
pub use perturb::Perturbation;
pub use stop::JointStop;
pub use unphysical::Unphysical;
#[cfg(feature = "std")]
pub(crate) use unphysical::{Flaw, SYMMETRIC};

use crate::arm::{Arm, Factor, JointFriction, Posed, Side};
use crate::error::{Result, finite, not_empty};
use crate::math::{Matrix, Vector};
#[cfg(feature = "std")]
pub(crate) use abreast::Part;
pub(super) use joint::Chain;
use joint::Mass;
#[cfg(feature = "std")]
pub(crate) use links::Frames;
pub(crate) use links::{Frame, Links};
use place::{Of, PoseNames};
use space::V3;
use validate::validate_pose;

const TIP: PoseNames = PoseNames { rotation: "tip.rotation", translation: "tip.translation" };

/// M must be positive definite at q = 0 and at this many more positions for an arm to be accepted.
const PROBES: usize = 4;
/// An inertia below this share of what lies beyond a joint (m r², or m for one that slides) is
/// rounding.
const NEGLIGIBLE: f64 = 1e-13;

/// Up to this many joints arms go side by side. Kernels are compiled for every number of joints:
/// two more took the wheel's compiler 7 % longer.
#[cfg(feature = "std")]
pub(crate) const MAX_ABREAST: usize = 8;
#[cfg(feature = "std")]
const _: () = assert!(MAX_ABREAST <= SHORT, "side by side M is factored");

/// Up to this many joints M is factored. Beyond, articulated bodies are used, whose cost grows with
/// N and not with N³. Factoring is faster at 7 joints; where that ends has not been measured.
const SHORT: usize = 10;

/// A serial arm with `N` joints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Serial<const N: usize> {
    parameters: SerialParameters<N>,
    unphysical: Unphysical,
    chain: Chain<N>,
    has_friction: bool,
    has_stops: bool,
    /// Whether the friction of any joint is dry.
    sticks: bool,
    wraps: [bool; N],
}

impl<const N: usize> Serial<N> {
    /// Checks and prepares the parameters.
    ///
    /// M must be positive definite at q = 0 and at some positions spread over a turn \[rad\] or a
    /// metre. It is then so almost everywhere.
    ///
    /// # Errors
    /// As [`Link::validate`], with the joint as index; `NotFinite` or `OutOfRange` naming `tip.…`
    /// or `gravity`; or `inertia`, with the joint that moves neither inertia nor armature;
    /// `WrongLength` for no links at all.
    pub fn new(parameters: SerialParameters<N>) -> Result<Self> {
        Self::new_with(parameters, Unphysical::Refuse)
    }

    /// As [`new`](Self::new), with a choice of what is done about a link that no rigid body can be.
    /// The arm keeps the choice: payloads, perturbations and all other arms made from this one are
    /// built with the same `unphysical`.
    ///
    /// What [`Unphysical::Nearest`] changed stands in [`links`](Self::links); with
    /// [`Unphysical::Note`], [`Inertia::validate`] tells which links no rigid body can be. If there
    /// are such links, M was positive definite where it was tried, but need not be so everywhere.
    ///
    /// # Errors
    /// As [`new`](Self::new), except for links that are taken.
    pub fn new_with(mut parameters: SerialParameters<N>, unphysical: Unphysical) -> Result<Self> {
        not_empty("links", N)?;
        for (joint, link) in parameters.links.iter_mut().enumerate() {
            *link = link.taken(joint, unphysical)?;
        }
        validate_pose(&parameters.tip, TIP, None)?;
        finite("gravity", &parameters.gravity)?;
        let chain = Chain::new(&parameters);
        let has_friction = parameters.links.iter().any(|link| !link.friction.is_none());
        let has_stops = parameters.links.iter().any(|link| !link.stop.is_none());
        let sticks = parameters.links.iter().any(|link| link.friction.hold().is_some());
        let wraps = parameters.links.map(|link| link.kind == JointKind::Continuous);
        let arm = Self { parameters, unphysical, chain, has_friction, has_stops, sticks, wraps };
        for probe in 0..=PROBES {
            // Multiples of the golden angle: all joints at other angles in every probe.
            let at = |i: usize, _| 2.399_963_229_728_653 * (probe * (i + 1)) as f64;
            let q = Vector::<N>::from_fn(|i, j| {
                if parameters.links[i].kind.turns() { at(i, j) } else { 0.1 * at(i, j) }
            });
            arm.check_mass_matrix(&q)?;
        }
        Ok(arm)
    }

    #[inline(never)]
    fn check_mass_matrix(&self, q: &Vector<N>) -> Result<()> {
        let turns = self.chain.turns(q);
        let (mass, free) = (self.mass_matrix(q), self.chain.free_inertias(&turns));
        let mut beyond = Mass::ZERO;
        for joint in (0..N).rev() {
            let (of, got) = (Of { parameter: "inertia", joint: Some(joint) }, free[joint]);
            let link = &self.parameters.links[joint];
            let body = beyond.plus(&joint::mass_in(&self.chain.joints[joint].user, link));
            let all = if link.kind.turns() {
                body.sigma.xx + body.sigma.yy + body.sigma.zz
            } else {
                body.m
            };
            of.finite(mass.column(joint).as_slice())?;
            of.finite(&[all])?;
            let wanted = "inertia or armature that joint moves when all beyond it are free";
            of.within(got, got > NEGLIGIBLE * all.abs(), wanted)?;
            beyond = body.inward(&turns[joint]);
        }
        finite("gravity", self.gravity(q).as_slice())?;
        finite("gravity", &[self.potential_energy(q)])
    }

    /// The parameters it was built from.
    pub fn parameters(&self) -> &SerialParameters<N> {
        &self.parameters
    }

    /// What was done about links that no rigid body can be.
    pub fn unphysical(&self) -> Unphysical {
        self.unphysical
    }

    /// Joints and links from the base on.
    pub fn links(&self) -> &[Link; N] {
        &self.parameters.links
    }

    /// How the joints move.
    pub fn joint_kinds(&self) -> [JointKind; N] {
        self.parameters.links.map(|link| link.kind)
    }

    /// Limits of the joints, infinite for none.
    pub fn limits(&self) -> [JointLimits; N] {
        self.parameters.links.map(|link| link.limits)
    }

    /// Largest torques [N·m] or forces \[N\], infinite for none.
    pub fn effort_limit(&self) -> [f64; N] {
        self.limits().map(|limits| limits.effort)
    }

    /// Largest speeds [rad/s or m/s], infinite for none.
    pub fn velocity_limit(&self) -> [f64; N] {
        self.limits().map(|limits| limits.velocity)
    }

    /// Smallest and largest positions [rad or m], infinite for none.
    pub fn position_limits(&self) -> [[f64; 2]; N] {
        self.limits().map(|limits| [limits.lower, limits.upper])
    }

    /// M q̈_r + C(q, q̇) q̇_r + G, without friction and stops: Slotine and Li's law, with
    /// Christoffel's C [N·m].
    pub fn slotine_li(
        &self,
        q: &Vector<N>,
        dq: &Vector<N>,
        dq_r: &Vector<N>,
        ddq_r: &Vector<N>,
    ) -> Vector<N> {
        let turns = self.chain.turns(q);
        let tau = self.chain.polar(&turns, dq, (dq_r, ddq_r), self.upward());
        self.add_armature(tau, ddq_r)
    }

    /// −g, the acceleration of the base that weighs as gravity does.
    #[inline(always)]
    fn upward(&self) -> V3 {
        V3::ZERO - self.chain.gravity
    }

    #[inline(always)]
    fn add_armature(&self, mut tau: Vector<N>, ddq: &Vector<N>) -> Vector<N> {
        for i in 0..N {
            tau[i] += self.chain.joints[i].armature * ddq[i];
        }
        tau
    }

    #[inline(always)]
    fn add_friction(&self, mut tau: Vector<N>, dq: &Vector<N>) -> Vector<N> {
        if self.has_friction {
            for i in 0..N {
                tau[i] += self.chain.joints[i].friction.torque(dq[i]);
            }
        }
        tau
    }

    #[inline(always)]
    fn add_stop_torques(&self, mut tau: Vector<N>, q: &Vector<N>, dq: &Vector<N>) -> Vector<N> {
        if self.has_stops {
            for (i, link) in self.parameters.links.iter().enumerate() {
                tau[i] += link.stop.torque(&link.limits, q[i], dq[i]);
            }
        }
        tau
    }

    /// Potential energy U(q) \[J\]; G = ∂U/∂q.
    pub fn potential_energy(&self, q: &Vector<N>) -> f64 {
        self.chain.potential_energy(&self.chain.turns(q))
    }

    #[inline(always)]
    fn bias_at(&self, turns: &[space::Turn; N], dq: &Vector<N>) -> Vector<N> {
        self.add_friction(self.chain.inverse(turns, dq, None, self.upward()), dq)
    }
}

impl<const N: usize> Arm<N> for Serial<N> {
    #[inline]
    fn wraps(&self) -> [bool; N] {
        self.wraps
    }

    fn mass_matrix(&self, q: &Vector<N>) -> Matrix<N> {
        self.chain.mass_matrix(&self.chain.turns(q))
    }

    fn coriolis(&self, q: &Vector<N>, dq: &Vector<N>) -> Matrix<N> {
        self.chain.coriolis(&self.chain.turns(q), dq)
    }

    fn rigid_bias(&self, q: &Vector<N>, dq: &Vector<N>) -> Vector<N> {
        self.chain.inverse(&self.chain.turns(q), dq, None, self.upward())
    }

    fn joint_friction(&self, joint: usize) -> JointFriction {
        self.chain.joints[joint].friction
    }

    fn joint_stop(&self, joint: usize) -> (JointStop, JointLimits) {
        (self.parameters.links[joint].stop, self.parameters.links[joint].limits)
    }

    fn resists(&self) -> bool {
        self.has_friction || self.has_stops
    }

    fn friction(&self, dq: &Vector<N>) -> Vector<N> {
        self.add_friction(Vector::zeros(), dq)
    }

    fn stops(&self, q: &Vector<N>, dq: &Vector<N>) -> Vector<N> {
        self.add_stop_torques(Vector::zeros(), q, dq)
    }

    fn side(&self) -> Option<Side<'_, N>> {
        let friction = self.chain.joints.each_ref().map(|joint| joint.friction);
        let plain = !self.sticks && !self.has_stops && N <= SHORT;
        plain.then(|| Side::chain(&self.chain, self.has_friction.then_some(friction)))
    }

    fn rigid_dynamics(
        &self,
        q: &Vector<N>,
        choose: &mut dyn FnMut(&Matrix<N>) -> Vector<N>,
    ) -> (Matrix<N>, Vector<N>, Vector<N>) {
        let turns = self.chain.turns(q);
        let mass = self.chain.mass_matrix(&turns);
        let dq = choose(&mass);
        (mass, dq, self.chain.inverse(&turns, &dq, None, self.upward()))
    }

    fn bias(&self, q: &Vector<N>, dq: &Vector<N>) -> Vector<N> {
        self.bias_at(&self.chain.turns(q), dq)
    }

    fn mass_matrix_and_bias(&self, q: &Vector<N>, dq: &Vector<N>) -> (Matrix<N>, Vector<N>) {
        let turns = self.chain.turns(q);
        (self.chain.mass_matrix(&turns), self.bias_at(&turns, dq))
    }

    fn inverse_dynamics(&self, q: &Vector<N>, dq: &Vector<N>, ddq: &Vector<N>) -> Vector<N> {
        let turns = self.chain.turns(q);
        let tau = self.chain.inverse(&turns, dq, Some(ddq), self.upward());
        let tau = self.add_friction(self.add_armature(tau, ddq), dq);
        self.add_stop_torques(tau, q, dq)
    }

    fn forward_dynamics(&self, q: &Vector<N>, dq: &Vector<N>, tau: &Vector<N>) -> Vector<N> {
        if self.sticks {
            return Posed::of(self, q, dq).acceleration(self, (q, dq), tau);
        }
        let turns = self.chain.turns(q);
        let net = tau - self.add_stop_torques(self.bias_at(&turns, dq), q, dq);
        if N <= SHORT {
            return Factor::of(&self.chain.mass_matrix(&turns)).solve(&net);
        }
        self.chain.accelerations(&turns, &net)
    }
}

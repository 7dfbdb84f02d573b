//! What a control law is: the torque for a sample and an estimate, in its parts,
//! `τ = τ_model + τ_compensation`.

#[cfg(feature = "std")]
use super::Beliefs;
use super::{Gains, Sample};
use crate::arm::{JointFriction, Side};
use crate::math::{Matrix, Vector};

/// A control law for `N` joints. All that it knows is in `&self`, and it remembers nothing. What
/// has a memory is a [`Compensator`](super::Compensator), or a [`Dynamic`](super::Dynamic) if the
/// memory is a few numbers.
///
/// A law asks; [`Controller`](super::Controller) limits, tells the compensator what acted, and
/// checks that samples are finite and at most 1e10 before the law sees them.
pub trait Law<const N: usize> {
    /// The torque for a sample. `rho_hat` is the estimate ρ̂ [rad/s²] of what the law's model
    /// leaves out: the arm accelerates by ρ̂ more than the model says.
    fn torque(&self, seen: &Sample<N>, rho_hat: &Vector<N>) -> Demand<N>;

    /// The torque that keeps the arm at rest at `q`, as far as the law knows [N·m]: for a stop, and
    /// before a controller takes over.
    fn resting_torque(&self, q: &Vector<N>) -> Vector<N>;

    /// M₀(q) a: what accelerates the arm at rest by `acceleration` [rad/s²], beside the resting
    /// torque [N·m]. A guard brakes with it. The default is for a law without a model: 1 kg·m² at
    /// each joint.
    fn inertia_torque(&self, _q: &Vector<N>, acceleration: &Vector<N>) -> Vector<N> {
        *acceleration
    }

    /// Friction of a joint that the torque cancels at the measured velocity; none by default.
    /// Simulation solves for friction within its steps, and leaves out what the law cancels.
    fn joint_friction(&self, _joint: usize) -> JointFriction {
        JointFriction::default()
    }

    /// Which joints turn without an end: e is taken around the circle there. None by default.
    #[inline]
    fn wraps(&self) -> [bool; N] {
        [false; N]
    }

    /// The arm that it believes in, where all that it needs of it for a torque is M₀ and H₀ at the
    /// measured motion: of many runs these are found side by side.
    fn model(&self) -> Option<Side<'_, N>> {
        None
    }

    /// The torque, from M₀ and H₀ at the measured motion; a law with a [`model`](Self::model) has
    /// it.
    fn torque_by(
        &self,
        _dynamics: &(Matrix<N>, Vector<N>),
        seen: &Sample<N>,
        rho_hat: &Vector<N>,
    ) -> Demand<N> {
        self.torque(seen, rho_hat)
    }

    /// Its gains, where it is computed torque with constant ones.
    fn constant_gains(&self) -> Option<&Gains<N>> {
        None
    }

    /// What it believes, where it is the law of the recommended controller: with this, many runs go
    /// side by side. `None` by default, and for laws of your own.
    #[cfg(feature = "std")]
    fn beliefs(&self) -> Option<Beliefs<'_, N>> {
        None
    }

    /// A number for what gives ρ̂ its meaning, as a rule the nominal arm. Weights that were learnt
    /// under one law are right under another law of the same fingerprint. The default is 0, for a
    /// law without a model.
    fn fingerprint(&self) -> u64 {
        0
    }

    /// A number for the law's parameters beside its model, as a rule the feedback gains. With
    /// others, the error says something else to what learns from it. The default is 0.
    fn tuning(&self) -> u64 {
        0
    }
}

/// What a law asks for: the torque in its parts, before any limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Demand<const N: usize, T = f64> {
    /// What feedback and nominal model ask for [N·m].
    pub model: Vector<N, T>,
    /// What is added for ρ̂, zero for ρ̂ = 0 [N·m].
    pub compensation: Vector<N, T>,
    /// v [rad/s²]: the acceleration under `model` if the arm is as the law's model says. For a law
    /// without a model, v is the acceleration that it aims at. What the model leaves out is ρ = q̈
    /// − v + ρ̂.
    pub v: Vector<N, T>,
}

/// The torque that acted at a stage, and the one that the law asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Applied<const N: usize> {
    /// model + compensation of the law [N·m].
    pub asked: Vector<N>,
    /// What acted [N·m]: inside the controller's limits, and inside the actuators' limits if they
    /// are known.
    pub tau: Vector<N>,
    /// What was commanded last, of which `tau` may be an older one in a loop with a
    /// [delay](super::Front::delay) [N·m].
    pub commanded: Vector<N>,
}

impl<const N: usize> Applied<N> {
    /// A torque that was asked for, and what acts of it at once.
    #[inline(always)]
    pub fn new(asked: Vector<N>, tau: Vector<N>) -> Self {
        Self { asked, tau, commanded: tau }
    }

    /// Whether a limit cut the torque of any joint. The error then says nothing about the estimate,
    /// so what learns from it or integrates it holds.
    #[inline]
    pub fn limited(&self) -> bool {
        self.tau != self.asked
    }
}

//! An arm at one position and velocity: M factored, and C q̇ + G.

use super::{Arm, Factor, Implicit, Resistance};
use crate::math::{Matrix, Vector};

/// What the acceleration of an arm needs, for any torque.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Posed<const N: usize> {
    pub mass: Matrix<N>,
    pub factor: Factor<N>,
    /// C q̇ + G [N·m].
    pub rigid: Vector<N>,
}

impl<const N: usize> Posed<N> {
    /// `arm` at the position `q` with the velocity `dq`.
    pub fn of<A: Arm<N> + ?Sized>(arm: &A, q: &Vector<N>, dq: &Vector<N>) -> Self {
        let (mass, _, rigid) = arm.rigid_dynamics(q, &mut |_| *dq);
        Self { mass, factor: Factor::of(&mass), rigid }
    }

    /// M⁻¹(τ − C q̇ − G) [rad/s²]: without friction and stops.
    #[inline]
    #[cfg(feature = "std")]
    pub fn free(&self, tau: &Vector<N>) -> Vector<N> {
        self.factor.solve(&(tau - self.rigid))
    }

    /// q̈ = M⁻¹(τ − H − s) [rad/s²] of the same `arm`; joints at rest stay there if their dry
    /// friction can hold them.
    pub fn acceleration<A: Arm<N> + ?Sized>(
        &self,
        arm: &A,
        (q, dq): (&Vector<N>, &Vector<N>),
        tau: &Vector<N>,
    ) -> Vector<N> {
        let moving = tau - (self.rigid + arm.friction(dq) + arm.stops(q, dq));
        let free = self.factor.solve(&moving);
        let hold: [_; N] = core::array::from_fn(|joint| {
            let friction = arm.joint_friction(joint);
            friction.hold().filter(|_| dq[joint] == 0.0).map(|_| Resistance::holding(&friction))
        });
        if hold.iter().all(Option::is_none) {
            return free;
        }
        let laws = hold.map(Option::unwrap_or_default);
        let (factor, place) = (&self.factor, &Vector::zeros());
        let still = Implicit { mass: &self.mass, factor, laws: &laws, h: 1.0, place };
        still.solve(&free, &Vector::zeros()).0
    }
}

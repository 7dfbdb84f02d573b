//! What pushes at the tip: a force F and a moment m in the axes of the base, at the tip's origin.
//! `τ_d = −J(q)ᵀ (F, m)` opposes the applied torque, so the push itself helps it:
//! `M q̈ + H = τ + Jᵀ (F, m)`.

use super::Disturbance;
use crate::arm::Tip;
use crate::math::Vector;

/// A wrench at the tip of an arm.
///
/// ```
/// use steadyarm::arm::{TwoLink, TwoLinkParameters};
/// use steadyarm::math::Vector;
/// use steadyarm::plant::{Disturbance, Pulse, Pulses, Shape, Wrench};
///
/// let arm = TwoLink::new(TwoLinkParameters::default())?;
/// // 20 N downwards for half a second.
/// let push = Pulse { time: 1.0, duration: 0.5, torque: [0.0, -20.0, 0.0, 0.0, 0.0, 0.0] };
/// let wrench = Wrench::new(arm, Pulses::new([push], Shape::Rectangle)?);
/// let (q, still) = (Vector::<2>::new(0.0, 0.0), Vector::<2>::zeros());
/// assert_eq!(wrench.torque(&q, &still, 1.2), Vector::<2>::new(20.0, 10.0));
/// # Ok::<(), steadyarm::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wrench<A, W> {
    arm: A,
    wrench: W,
}

impl<A, W> Wrench<A, W> {
    /// At the tip of this arm. The six values of `wrench` over time are the force (x, y, z) \[N\]
    /// and the moment [N·m] that act on the tip.
    pub fn new(arm: A, wrench: W) -> Self {
        Self { arm, wrench }
    }
}

impl<const N: usize, A: Tip<N>, W: Disturbance<6>> Disturbance<N> for Wrench<A, W> {
    fn torque(&self, q: &Vector<N>, _: &Vector<N>, t: f64) -> Vector<N> {
        let none = Vector::zeros();
        let wrench = self.wrench.torque(&none, &none, t);
        -(self.arm.jacobian(q).tr_mul(&wrench))
    }
}

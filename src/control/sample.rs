//! What a controller sees at one instant: the measurement, the set-point, and `e = q − q_d`, around
//! the circle where a joint turns without an end.

#[cfg(feature = "std")]
use pulp::Simd;

#[cfg(feature = "std")]
use crate::math::{Abreast, Register, lane, put, store};
use crate::math::{Real, Vector};
use crate::reference::Setpoint;

/// What a controller sees at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample<const N: usize, T = f64> {
    /// Measured position q \[rad\].
    pub q: Vector<N, T>,
    /// Measured velocity q̇ [rad/s].
    pub dq: Vector<N, T>,
    /// Where the arm should be.
    pub desired: Setpoint<N, T>,
    /// Tracking error e = q − q_d \[rad\], in [−π, π) for a joint that turns without an end.
    pub e: Vector<N, T>,
    /// ė = q̇ − q̇_d [rad/s].
    pub de: Vector<N, T>,
}

impl<const N: usize> Sample<N> {
    /// Measurement, set-point and their difference, for an arm without continuous joints.
    #[inline]
    pub fn new(q: Vector<N>, dq: Vector<N>, desired: Setpoint<N>) -> Self {
        Self { q, dq, desired, e: q - desired.q, de: dq - desired.dq }
    }
}

impl<const N: usize, T: Real> Sample<N, T> {
    /// As [`new`](Sample::new), but with the error around the circle, −π ≤ e < π, for the joints
    /// that [`Arm::wraps`](crate::arm::Arm::wraps) names. q and q_d stay as they are.
    #[inline(always)]
    pub fn wrapped(
        q: Vector<N, T>,
        dq: Vector<N, T>,
        desired: Setpoint<N, T>,
        wraps: &[bool; N],
    ) -> Self {
        let (mut e, mut de) = (q, dq);
        for n in 0..N {
            e[n] -= desired.q[n];
            de[n] -= desired.dq[n];
        }
        // One test for all joints: most arms have no continuous joint.
        if wraps.iter().fold(false, |any, wraps| any | wraps) {
            e = around_where(wraps, &e);
        }
        Self { q, dq, desired, e, de }
    }
}

#[cfg(feature = "std")]
impl<const N: usize, S: Simd> Sample<N, Register<S>> {
    /// Puts them in their place.
    #[inline(always)]
    pub(crate) fn store(&self, to: &mut Sample<N, Abreast>, part: usize) {
        store(&self.q, &mut to.q, part);
        store(&self.dq, &mut to.dq, part);
        store(&self.e, &mut to.e, part);
        store(&self.de, &mut to.de, part);
        store(&self.desired.q, &mut to.desired.q, part);
        store(&self.desired.dq, &mut to.desired.dq, part);
        store(&self.desired.ddq, &mut to.desired.ddq, part);
    }
}

#[cfg(feature = "std")]
impl<const N: usize> Sample<N, Abreast> {
    /// Shows the controller in a lane what it sees.
    pub(crate) fn show(&mut self, i: usize, Sample { q, dq, desired, e, de }: &Sample<N>) {
        put(q, &mut self.q, i);
        put(dq, &mut self.dq, i);
        put(e, &mut self.e, i);
        put(de, &mut self.de, i);
        put(&desired.q, &mut self.desired.q, i);
        put(&desired.dq, &mut self.desired.dq, i);
        put(&desired.ddq, &mut self.desired.ddq, i);
    }

    /// What the controller in a lane sees.
    pub(crate) fn lane(&self, i: usize) -> Sample<N> {
        let Self { q, dq, desired, e, de } = self;
        let Setpoint { q: q_d, dq: dq_d, ddq: ddq_d } = desired;
        let desired = Setpoint { q: lane(q_d, i), dq: lane(dq_d, i), ddq: lane(ddq_d, i) };
        Sample { q: lane(q, i), dq: lane(dq, i), desired, e: lane(e, i), de: lane(de, i) }
    }
}

/// The error of the joints that wrap around the circle. A cold path: most arms have no such joints.
#[inline(never)]
fn around_where<const N: usize, T: Real>(wraps: &[bool; N], e: &Vector<N, T>) -> Vector<N, T> {
    let mut around = *e;
    for n in 0..N {
        if wraps[n] {
            around[n] = e[n].around();
        }
    }
    around
}

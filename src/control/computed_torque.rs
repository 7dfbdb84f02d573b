//! Computed torque for the nominal arm:
//!
//! ```text
//! v = q̈_d − K_v ė − K_p e
//! τ = M₀(q)(v − ρ̂) + H₀(q, q̇) = (M₀ v + H₀) − M₀ ρ̂        (7), (11), (12)
//! ```
//!
//! v is the paper's feedback. With another [`Feedback`] the law is another one of the same family.

#[cfg(feature = "std")]
use super::LawsAbreast;
use super::{Demand, Law, Sample};
use crate::arm::{Arm, JointFriction};
use crate::error::{Result, positive, within};
#[cfg(feature = "std")]
use crate::math::LANES;
use crate::math::{FNV_START, Matrix, Real, Vector, fnv_of, product};

/// What computed torque asks the arm to do: the acceleration v for a sample. It remembers nothing;
/// an integrator is a [`Dynamic`](super::Dynamic) that adds its share to ρ̂.
pub trait Feedback<const N: usize> {
    /// v [rad/s²].
    fn acceleration(&self, seen: &Sample<N>) -> Vector<N>;

    /// It, where it is the paper's feedback with constant gains.
    fn constant(&self) -> Option<&Gains<N>> {
        None
    }

    /// A number for its parameters: see [`Law::tuning`].
    fn tuning(&self) -> u64;
}

/// Feedback gains of each joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gains<const N: usize> {
    /// K_p [1/s²].
    pub kp: [f64; N],
    /// K_v [1/s].
    pub kv: [f64; N],
}

impl<const N: usize> Gains<N> {
    /// Diagonal gains; the error dynamics ë + K_v ė + K_p e = 0 (8) are stable exactly when all are
    /// > 0.
    ///
    /// # Errors
    /// `kp`, `kv`: not finite or not > 0.
    pub fn new(kp: [f64; N], kv: [f64; N]) -> Result<Self> {
        positive("kp", &kp)?;
        positive("kv", &kv)?;
        Ok(Self { kp, kv })
    }

    /// Gains with both poles at −`bandwidth` p [rad/s]: K_p = p², K_v = 2p.
    ///
    /// # Errors
    /// `bandwidth`: not finite or not > 0.
    pub fn with_bandwidth(bandwidth: [f64; N]) -> Result<Self> {
        positive("bandwidth", &bandwidth)?;
        Self::new(bandwidth.map(|p| p * p), bandwidth.map(|p| 2.0 * p))
    }

    /// Refuses gains that are too fast for a period \[s\] and a delay in samples: what a period
    /// holds and a delay adds is late by (½ + d) h, and K_v (½ + d) h ≤ 0.35 leaves the loop its
    /// damping.
    ///
    /// # Errors
    /// `kv`.
    pub fn suits(&self, period: f64, delay: f64) -> Result<()> {
        keeps_up("kv", &self.kv, period, delay)
    }
}

/// Refuses a feedback of the velocity \[1/s\] that is too fast for a period \[s\] and a delay in
/// samples. At the crossover, near k_v, the lag k_v (½ + d) h takes so many radians of phase: 0.35
/// of the 1.3 that two poles in one place have.
pub(crate) fn keeps_up(
    parameter: &'static str,
    rates: &[f64],
    period: f64,
    delay: f64,
) -> Result<()> {
    let wanted = "a loop whose fastest rate [1/s], the number here, is at most 0.35 / ((1/2 + \
                  delay) · period): a lower bandwidth or a shorter period";
    within(parameter, rates, |rate| rate * (0.5 + delay) * period <= 0.35, wanted)
}

/// v = q̈_d − K_v ė − K_p e.
#[inline(always)]
pub(super) fn feedback<const N: usize, T: Real>(
    kp: &[T; N],
    kv: &[T; N],
    Sample { desired, e, de, .. }: &Sample<N, T>,
) -> Vector<N, T> {
    let mut v = desired.ddq;
    for n in 0..N {
        v[n] = desired.ddq[n] - kv[n] * de[n] - kp[n] * e[n];
    }
    v
}

impl<const N: usize> Feedback<N> for Gains<N> {
    /// v = q̈_d − K_v ė − K_p e [rad/s²].
    #[inline]
    fn acceleration(&self, seen: &Sample<N>) -> Vector<N> {
        feedback(&self.kp, &self.kv, seen)
    }

    fn constant(&self) -> Option<&Gains<N>> {
        Some(self)
    }

    /// FNV-1a of the gains.
    fn tuning(&self) -> u64 {
        fnv_of(fnv_of(FNV_START, self.kp), self.kv)
    }
}

/// The law: nominal arm and feedback. Immutable.
#[derive(Clone, Copy, Debug)]
pub struct ComputedTorque<const N: usize, A, F = Gains<N>> {
    /// What the law believes of the arm.
    pub arm: A,
    /// Feedback, by default with constant gains.
    pub gains: F,
}

impl<const N: usize, A: Arm<N>, F: Feedback<N>> ComputedTorque<N, A, F> {
    /// Computed torque for this arm; [`Controller::new`](super::Controller::new) makes a controller
    /// of it.
    pub fn new(arm: A, gains: F) -> Self {
        Self { arm, gains }
    }
}

/// (M₀ v + H₀) − M₀ ρ̂.
#[inline(always)]
pub(super) fn computed<const N: usize, T: Real>(
    (mass, bias): (Matrix<N, T>, Vector<N, T>),
    v: Vector<N, T>,
    rho_hat: &Vector<N, T>,
) -> Demand<N, T> {
    let (mut model, mut compensation) = (product(&mass, &v), product(&mass, rho_hat));
    for n in 0..N {
        model[n] += bias[n];
        compensation[n] = -compensation[n];
    }
    Demand { model, compensation, v }
}

impl<const N: usize, A: Arm<N>, F: Feedback<N>> Law<N> for ComputedTorque<N, A, F> {
    #[inline(always)]
    fn torque(&self, seen: &Sample<N>, rho_hat: &Vector<N>) -> Demand<N> {
        let (mass, bias) = self.arm.mass_matrix_and_bias(&seen.q, &seen.dq);
        computed((mass, bias), self.gains.acceleration(seen), rho_hat)
    }

    /// G₀(q).
    #[cfg(feature = "std")]
    fn abreast(each: [&Self; LANES]) -> Option<LawsAbreast<N>> {
        LawsAbreast::of(each)
    }

    fn resting_torque(&self, q: &Vector<N>) -> Vector<N> {
        self.arm.gravity(q)
    }

    /// M₀(q) a.
    fn inertia_torque(&self, q: &Vector<N>, acceleration: &Vector<N>) -> Vector<N> {
        self.arm.mass_matrix(q) * acceleration
    }

    fn joint_friction(&self, joint: usize) -> JointFriction {
        self.arm.joint_friction(joint)
    }

    #[inline]
    fn wraps(&self) -> [bool; N] {
        self.arm.wraps()
    }

    /// That of the nominal arm. Gains may differ: ρ does not depend on them.
    fn fingerprint(&self) -> u64 {
        self.arm.fingerprint()
    }

    fn tuning(&self) -> u64 {
        self.gains.tuning()
    }
}

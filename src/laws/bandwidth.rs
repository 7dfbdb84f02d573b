//! What gains from a bandwidth p [rad/s] have in common: s = ė + pe as BᵀPx, the poses at which an
//! arm is looked at, and its inertia and fastest pole there.
//!
//! With K_p = p², K_v = 2p and Q = diag(2p³, 2p), Lyapunov's P has p12 = p and p22 = 1.

use core::f64::consts::PI;

use crate::arm::{Arm, Factor, Parametric, Regressor};
use crate::eigen::symmetric_eigenvalues;
use crate::error::{Result, non_negative, positive, within};
use crate::math::{Matrix, Vector, sqrt};

/// So many poses tell what an arm is like.
const POSES: usize = 24;

/// The multiples of their roots spread over a turn.
const PRIMES: [u8; 12] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37];

/// The diagonals of Q for e and for ė with which BᵀPx is ė + pe, for the gains p² and 2p.
pub(super) fn sliding_weights<const N: usize>(bandwidth: &[f64; N]) -> [[f64; N]; 2] {
    [bandwidth.map(|p| 2.0 * p * p * p), bandwidth.map(|p| 2.0 * p)]
}

/// 24 poses spread over the joints' ranges.
pub(super) fn poses<const N: usize>(arm: &impl Arm<N>) -> impl Iterator<Item = Vector<N>> {
    poses_within(ranges(arm))
}

/// Smallest and largest position of each joint; −π … π rad or m where a joint has none.
pub(super) fn ranges<const N: usize>(arm: &impl Arm<N>) -> [[f64; 2]; N] {
    core::array::from_fn(|n| {
        let (_, limits) = arm.joint_stop(n);
        let given = limits.lower.is_finite() && limits.upper.is_finite();
        if given { [limits.lower, limits.upper] } else { [-PI, PI] }
    })
}

/// 24 poses spread over these ranges.
pub(super) fn poses_within<const N: usize>(
    ranges: [[f64; 2]; N],
) -> impl Iterator<Item = Vector<N>> {
    (1..=POSES).map(move |k| {
        Vector::from_fn(|n, _| {
            let turns = k as f64 * sqrt(f64::from(PRIMES[n % PRIMES.len()]));
            let [lower, upper] = ranges[n];
            lower + (turns - libm::floor(turns)) * (upper - lower)
        })
    })
}

/// D, the mean of M₀'s diagonal over these poses [kg·m²].
///
/// # Errors
/// `mass_matrix`: an entry is not finite or not > 0.
pub(super) fn inertia_weights<const N: usize>(arm: &impl Arm<N>) -> Result<[f64; N]> {
    let sum: Vector<N> = poses(arm).map(|q| arm.mass_matrix(&q).diagonal()).sum();
    let mean = core::array::from_fn(|n| sum[n] / POSES as f64);
    positive("mass_matrix", &mean)?;
    Ok(mean)
}

/// How an arm will move, joint by joint: what adaptation of parameters takes its gain from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace<const N: usize> {
    /// Speed [rad/s].
    pub speed: [f64; N],
    /// Acceleration [rad/s²].
    pub acceleration: [f64; N],
}

impl<const N: usize> Pace<N> {
    /// Y and pose at these speeds and accelerations, in changing directions, at each of the poses.
    ///
    /// # Errors
    /// `speed`, `acceleration`: not finite or negative.
    pub(super) fn regressors<const K: usize, A: Parametric<N, K>>(
        &self,
        arm: &A,
    ) -> Result<impl Iterator<Item = (Vector<N>, Regressor<N, K>)>> {
        non_negative("speed", &self.speed)?;
        non_negative("acceleration", &self.acceleration)?;
        let sign = |k: usize, n: usize| if (k >> (n % 5)) & 1 == 0 { 1.0 } else { -1.0 };
        Ok(poses(arm).enumerate().map(move |(k, q)| {
            let dq = Vector::from_fn(|n, _| sign(k, n) * self.speed[n]);
            let ddq = Vector::from_fn(|n, _| sign(k + 1, n) * self.acceleration[n]);
            (q, arm.slotine_li_regressor(&q, &dq, &dq, &ddq))
        }))
    }
}

/// The gain with which the poles of s, beside `ṡ + ps`, are both at −p/2 where the parameters act
/// most: 1/4 of the inverse of the largest of `strengths`, Σ |share of joint n|²/pₙ².
///
/// # Errors
/// `speed`: nothing acts at this pace.
pub(super) fn adaptation_gain(strengths: impl Iterator<Item = f64>) -> Result<f64> {
    let largest = strengths.fold(0.0, f64::max);
    let wanted = "a pace at which the parameters act";
    within("speed", &[largest], |strength| strength > 0.0, wanted)?;
    Ok(0.25 / largest)
}

/// 1/p²D of each joint.
///
/// # Errors
/// As [`inertia_weights`].
pub(super) fn joint_scales<const N: usize>(
    arm: &impl Arm<N>,
    bandwidth: &[f64; N],
) -> Result<[f64; N]> {
    let weights = inertia_weights(arm)?;
    Ok(core::array::from_fn(|n| 1.0 / (bandwidth[n] * bandwidth[n] * weights[n])))
}

/// The largest eigenvalue of M₀⁻¹K over these poses [1/s], for the damping K = diag(`damping`)
/// [N·m·s/rad].
///
/// # Errors
/// `mass_matrix`: not positive definite.
pub(super) fn fastest_pole<const N: usize>(arm: &impl Arm<N>, damping: &[f64; N]) -> Result<f64> {
    let roots = damping.map(sqrt);
    let mut fastest: f64 = 0.0;
    for q in poses(arm) {
        let factor = Factor::of(&arm.mass_matrix(&q));
        // √K M⁻¹ √K has the eigenvalues of M⁻¹K.
        let mut symmetric = Matrix::<N>::zeros();
        for (n, mut column) in symmetric.column_iter_mut().enumerate() {
            let root = Vector::from_fn(|i, _| if i == n { roots[n] } else { 0.0 });
            column.copy_from(&factor.solve(&root).component_mul(&roots.into()));
        }
        let poles = symmetric_eigenvalues(&symmetric).map_err(|e| e.named("mass_matrix"))?;
        fastest = poles.iter().fold(fastest, |most, x| most.max(*x));
    }
    Ok(fastest)
}

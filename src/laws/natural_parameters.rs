//! Natural adaptation of a chain's bodies: as [`AdaptiveParameters`](super::AdaptiveParameters),
//! but with steps that depend on no units, and with bodies that stay possible for ever.
//!
//! ```text
//! P_b = [Σ h; hᵀ m] ≻ 0, Σ = ½ tr(I) 1 − I      pseudo-inertia of body b about its frame's origin
//! Ṗ_b = −γ P_b L_b P_b,  tr(L_b P_b) = (Y_bᵀs)ᵀπ_b
//! P_b = F Fᵀ,  F lower triangular:  Ḟ = F Ψ,  Ψ + Ψᵀ = −γ Fᵀ L_b F
//! ```
//!
//! A step of F is a congruence of P_b, so mass stays positive and moments those of a body, without
//! any projection. `V = ½sᵀMs + (1/γ) Σ_b [ln det P_b − ln det P_b* + tr(P_b⁻¹P_b*) − 4]` has
//! `V̇ = −sᵀK_D s` on the law [`Passive`](super::Passive) with the same Λ. F holds while the torque
//! is limited. Source: Lee, Kwon, Park 2018.

use super::adaptive_parameters::passive_regressor;
use super::bandwidth::{Pace, adaptation_gain, joint_scales};
use crate::arm::{Arm, Factor, Inertia, Parametric, Serial};
use crate::control::{Applied, Dynamic, Sample};
use crate::error::{Error, Result, positive};
use crate::math::{FNV_START, Matrix, Vector, fnv_of, sqrt};

/// Numbers of a body: π, or the lower triangle of F row by row.
const PER_BODY: usize = 10;

/// The adaptation of the bodies of a nominal chain; `K` = 10 `N`.
#[derive(Clone, Copy, Debug)]
pub struct NaturalParameters<const N: usize, const K: usize> {
    arm: Serial<N>,
    lambda: [f64; N],
    gain: f64,
    /// F of the nominal bodies.
    start: Vector<K>,
}

impl<const N: usize, const K: usize> NaturalParameters<N, K>
where
    Serial<N>: Parametric<N, K>,
{
    /// The adaptation with Λ = `lambda` [1/s] of the law and γ = `gain` [1/J].
    ///
    /// # Errors
    /// `lambda`, `gain`: not finite or not > 0. `inertia`, with the joint: P_b of a nominal body is
    /// not positive definite, as of a body that is thin or a point.
    pub fn new(arm: Serial<N>, lambda: [f64; N], gain: f64) -> Result<Self> {
        positive("lambda", &lambda)?;
        positive("gain", &[gain])?;
        let mut start = Vector::<K>::zeros();
        for (joint, link) in arm.links().iter().enumerate() {
            let triangle = cholesky(&pseudo_inertia(&link.inertia)).ok_or_else(|| {
                let wanted = "a body with room in all directions: its pseudo-inertia > 0";
                Error::out_of_range("inertia", link.inertia.mass, wanted).at(joint)
            })?;
            write(&triangle, &mut start.as_mut_slice()[PER_BODY * joint..]);
        }
        Ok(Self { arm, lambda, gain, start })
    }

    /// γ for the bandwidth p [rad/s] of [`Passive::with_bandwidth`] and a pace, in the metric of
    /// the nominal bodies: 4 γ Σₙ Σ_b tr(LPLP)/pₙ²Dₙ = 1 at the one of 24 poses where it acts most,
    /// L of row n of Y. Where M = D, both poles of s are then at −p/2 at the fastest.
    ///
    /// # Errors
    /// As [`new`](Self::new) and [`AdaptiveParameters::with_bandwidth`].
    ///
    /// [`Passive::with_bandwidth`]: super::Passive::with_bandwidth
    /// [`AdaptiveParameters::with_bandwidth`]: super::AdaptiveParameters::with_bandwidth
    pub fn with_bandwidth(arm: Serial<N>, bandwidth: [f64; N], pace: &Pace<N>) -> Result<Self> {
        positive("bandwidth", &bandwidth)?;
        let scales = joint_scales(&arm, &bandwidth)?;
        let own = Self::new(arm, bandwidth, 1.0)?;
        let strengths = pace
            .regressors(&own.arm)?
            .map(|(_, y)| (0..N).map(|n| scales[n] * own.strength(&y.row(n).transpose())).sum());
        let gain = adaptation_gain(strengths)?;
        Ok(Self { gain, ..own })
    }

    /// Σ_b tr(LPLP) for the nominal bodies.
    fn strength(&self, row: &Vector<K>) -> f64 {
        (0..N)
            .map(|joint| {
                let f = triangle(&self.start.as_slice()[PER_BODY * joint..]);
                let y = &row.as_slice()[PER_BODY * joint..];
                f.tr_mul(&(adjoint(y) * f)).norm_squared()
            })
            .sum()
    }

    /// The bodies that a memory stands for.
    pub fn bodies(&self, z: &Vector<K>) -> [Inertia; N] {
        core::array::from_fn(|joint| {
            Inertia::from_parameters(&parameters(&triangle(&z.as_slice()[PER_BODY * joint..])))
        })
    }
}

impl<const N: usize, const K: usize> Dynamic<N, K> for NaturalParameters<N, K>
where
    Serial<N>: Parametric<N, K>,
{
    /// The nominal bodies.
    fn start(&self, _: &Sample<N>) -> Vector<K> {
        self.start
    }

    /// ρ̂ = −M₀⁻¹ Y (π̂ − π₀).
    fn estimate(&self, z: &Vector<K>, seen: &Sample<N>) -> Vector<N> {
        let mut off = -Parametric::inertial_parameters(&self.arm);
        for (own, body) in
            off.as_mut_slice().chunks_exact_mut(PER_BODY).zip(z.as_slice().chunks_exact(PER_BODY))
        {
            own.iter_mut().zip(parameters(&triangle(body))).for_each(|(own, x)| *own += x);
        }
        let torque = passive_regressor(&self.arm, &self.lambda, seen).0 * off;
        -Factor::of(&self.arm.mass_matrix(&seen.q)).solve(&torque)
    }

    /// Ḟ = FΨ of each body.
    fn rate(&self, z: &Vector<K>, seen: &Sample<N>, applied: &Applied<N>) -> Vector<K> {
        let mut rate = Vector::<K>::zeros();
        if applied.limited() {
            return rate;
        }
        let (regressor, s) = passive_regressor(&self.arm, &self.lambda, seen);
        let shares = regressor.tr_mul(&s);
        for joint in 0..N {
            let from = PER_BODY * joint;
            let f = triangle(&z.as_slice()[from..]);
            let drive = f.tr_mul(&(adjoint(&shares.as_slice()[from..]) * f)) * -self.gain;
            let half = |i: usize, j: usize| if i == j { 0.5 } else { 1.0 };
            let psi =
                Matrix::<4>::from_fn(|i, j| if i < j { 0.0 } else { half(i, j) * drive[(i, j)] });
            write(&(f * psi), &mut rate.as_mut_slice()[from..]);
        }
        rate
    }

    fn tuning(&self) -> u64 {
        fnv_of(fnv_of(FNV_START, self.lambda), [self.gain])
    }
}

/// P of a body.
fn pseudo_inertia(body: &Inertia) -> Matrix<4> {
    let [m, hx, hy, hz, xx, xy, yy, xz, yz, zz] = body.parameters();
    let [sx, sy, sz] = [0.5 * (yy + zz - xx), 0.5 * (xx + zz - yy), 0.5 * (xx + yy - zz)];
    Matrix::<4>::from([[sx, -xy, -xz, hx], [-xy, sy, -yz, hy], [-xz, -yz, sz, hz], [hx, hy, hz, m]])
}

/// π of FFᵀ.
fn parameters(f: &Matrix<4>) -> [f64; PER_BODY] {
    let p = f * f.transpose();
    let [sx, sy, sz] = [p[(0, 0)], p[(1, 1)], p[(2, 2)]];
    let (xy, xz, yz) = (-p[(1, 0)], -p[(2, 0)], -p[(2, 1)]);
    [p[(3, 3)], p[(3, 0)], p[(3, 1)], p[(3, 2)], sy + sz, xy, sx + sz, xz, yz, sx + sy]
}

/// L with tr(LP) = y·π.
fn adjoint(y: &[f64]) -> Matrix<4> {
    let [m, hx, hy, hz] = [y[0], 0.5 * y[1], 0.5 * y[2], 0.5 * y[3]];
    let [xx, xy, yy] = [y[4], -0.5 * y[5], y[6]];
    let [xz, yz, zz] = [-0.5 * y[7], -0.5 * y[8], y[9]];
    Matrix::<4>::from([
        [yy + zz, xy, xz, hx],
        [xy, xx + zz, yz, hy],
        [xz, yz, xx + yy, hz],
        [hx, hy, hz, m],
    ])
}

/// F with FFᵀ = P; `None` where P is not positive definite.
fn cholesky(p: &Matrix<4>) -> Option<Matrix<4>> {
    let mut f = Matrix::<4>::zeros();
    for j in 0..4 {
        let pivot = p[(j, j)] - (0..j).map(|k| f[(j, k)] * f[(j, k)]).sum::<f64>();
        // Less is rounding.
        f[(j, j)] = if pivot > 1e-12 * p[(j, j)] { sqrt(pivot) } else { return None };
        for i in j + 1..4 {
            let rest = p[(i, j)] - (0..j).map(|k| f[(i, k)] * f[(j, k)]).sum::<f64>();
            f[(i, j)] = rest / f[(j, j)];
        }
    }
    Some(f)
}

/// F from its lower triangle.
fn triangle(z: &[f64]) -> Matrix<4> {
    Matrix::<4>::from_fn(|i, j| if i < j { 0.0 } else { z[i * (i + 1) / 2 + j] })
}

/// The lower triangle of F.
fn write(f: &Matrix<4>, z: &mut [f64]) {
    for i in 0..4 {
        for j in 0..=i {
            z[i * (i + 1) / 2 + j] = f[(i, j)];
        }
    }
}

//! What a basis can learn along a path: how far ξ turns, and how much of ρ_d one W explains.
//!
//! ```text
//! ρ̂ = W ξ(x_d(t)),  W by ridge regression on every second point, judged at the points between
//! ```
//!
//! What W explains is there when learning stops; the rest was only integrated. With inputs (e, ė)
//! ξ stands still while the arm tracks, and W explains no more than the mean of ρ_d.

use nalgebra::{DMatrix, DVector};

use super::Subject;
use super::course::Course;
use super::subject::of_joint;
use crate::control::{Gains, Sample};
use crate::error::Result;
use crate::math::{Vector, sqrt};
use crate::reference::Setpoint;

/// Ridge, as a share of the mean of |ξ|².
const RIDGE: f64 = 1e-6;

/// Shaking by so much ends where the rules lose what they learn in it \[rad\]; in velocity, times
/// √k_p.
const AWAY: f64 = 0.05;

/// Rules that explain more than this share of ρ_d can learn it.
const LEARNT: f64 = 0.5;

/// A direction counts if ξ has this share of the largest |ξ|² in it.
const DIRECTION: f64 = 1e-3;

/// What is learnt along a path.
#[derive(Clone, Debug, PartialEq)]
pub struct Learning<const N: usize> {
    /// |ξ|² of each joint at every point.
    pub(super) xi_squared: Vec<[f64; N]>,
    /// What is left of it where the loop shakes.
    pub(super) shaken: Vec<[f64; N]>,
    /// Independent directions that ξ takes along the path, of each joint.
    pub directions: [usize; N],
    /// Rules that fire somewhere along the path with 5 % of the strongest, of each joint; `None` in
    /// kernel form.
    pub rules_excited: Option<[usize; N]>,
    /// Rules of each joint.
    pub rules: f64,
    /// The share of ρ_d (RMS) that is still compensated when learning stops, at best; `None` where
    /// ρ_d is not known, or zero.
    pub survives: Option<[f64; N]>,
}

impl<const N: usize> Learning<N> {
    /// Of a compensator along a path, for a loop with these gains.
    pub(super) fn new(
        subject: &dyn Subject<N>,
        course: &Course<N>,
        gains: &Gains<N>,
    ) -> Result<Self> {
        let samples = course.samples();
        let products = subject.products(&samples)?;
        let excited = subject.rules_excited(&samples)?;
        let mut directions = [0; N];
        let mut survives = [0.0; N];
        for n in 0..N {
            let block = of_joint(&products, n);
            directions[n] = count_directions(block);
            let rho = DVector::from_iterator(samples.len(), course.points.iter().map(|p| p.rho[n]));
            survives[n] = explained(block, &rho);
        }
        let known = course.measured && course.points.iter().any(|point| point.rho.amax() > 0.0);
        let xi_squared = diagonals(&products);
        Ok(Self {
            shaken: shaken(subject, &samples, gains, &xi_squared)?,
            xi_squared,
            directions,
            rules_excited: excited.map(|it| std::array::from_fn(|n| *of_joint(&it, n))),
            rules: subject.rules(),
            survives: known.then_some(survives),
        })
    }
}

impl<const N: usize> Learning<N> {
    /// Directions of ξ, if the rules of joint `n` can learn what the model leaves out.
    pub(super) fn learns(&self, n: usize) -> Option<usize> {
        let learnt = self.survives.is_some_and(|share| share[n] > LEARNT);
        learnt.then_some(self.directions[n])
    }
}

/// |ξ|² of each joint at every sample.
pub(super) fn diagonals<const N: usize>(products: &[DMatrix<f64>]) -> Vec<[f64; N]> {
    let of = |k: usize| std::array::from_fn(|n| of_joint(products, n)[(k, k)]);
    (0..products[0].nrows()).map(of).collect()
}

/// Both ends of a shake about every sample: those of one end, then those of the other. Neighbours
/// go to opposite sides, or all to one.
fn ends<const N: usize>(
    samples: &[Sample<N>],
    size: &[f64; N],
    rate: Option<&[f64; N]>,
    together: bool,
) -> Vec<Sample<N>> {
    let away = |sample: &Sample<N>, end: f64| {
        let side = |n: usize| if together || n.is_multiple_of(2) { end } else { -end };
        let by = Vector::from_fn(|n, _| side(n) * size[n] * rate.map_or(1.0, |rate| rate[n]));
        let still = Vector::zeros();
        let (e, de) = if rate.is_some() { (still, by) } else { (by, still) };
        let Setpoint { q, dq, .. } = sample.desired;
        Sample { q: q + e, dq: dq + de, e, de, ..*sample }
    };
    let of = |end: f64| samples.iter().map(move |it| away(it, end));
    of(1.0).chain(of(-1.0)).collect()
}

/// The frequency of the loop at a point, √(k_p + k_I p22) of each joint [rad/s].
fn frequency<const N: usize>(
    subject: &dyn Subject<N>,
    gains: &Gains<N>,
    xi_squared: &[f64; N],
) -> [f64; N] {
    let k_i = subject.parameters().adaptation.integral_gains(xi_squared);
    std::array::from_fn(|n| sqrt(gains.kp[n] + k_i[n] * subject.p()[n].p22))
}

/// What is left of |ξ|² of each joint where the loop shakes about every sample by [`AWAY`]: the
/// smallest ξ·ξ' of both ends, in position and in velocity. What is learnt at one end is used at
/// the other.
fn shaken<const N: usize>(
    subject: &dyn Subject<N>,
    samples: &[Sample<N>],
    gains: &Gains<N>,
    on_path: &[[f64; N]],
) -> Result<Vec<[f64; N]>> {
    let mut least = on_path.to_vec();
    let rate = frequency(subject, gains, &largest(on_path));
    for rate in [None, Some(&rate)] {
        let products = subject.products(&ends(samples, &[AWAY; N], rate, false))?;
        for (k, least) in least.iter_mut().enumerate() {
            for (n, least) in least.iter_mut().enumerate() {
                *least = least.min(of_joint(&products, n)[(k, samples.len() + k)]);
            }
        }
    }
    Ok(least)
}

/// The largest |ξ|² of each joint at every sample, and at errors of this size there: rules of the
/// error may fire more than on the path.
pub(super) fn strongest<const N: usize>(
    subject: &dyn Subject<N>,
    samples: &[Sample<N>],
    (size, gains): (&[f64; N], &Gains<N>),
    on_path: &[[f64; N]],
) -> Result<Vec<[f64; N]>> {
    let mut most = on_path.to_vec();
    let rate = gains.kp.map(sqrt);
    for rate in [None, Some(&rate)] {
        for together in [true, false] {
            let near = diagonals::<N>(&subject.products(&ends(samples, size, rate, together))?);
            for (k, near) in near.iter().enumerate() {
                for (most, near) in most[k % samples.len()].iter_mut().zip(near) {
                    *most = most.max(*near);
                }
            }
        }
    }
    Ok(most)
}

/// The largest of each joint.
fn largest<const N: usize>(xi_squared: &[[f64; N]]) -> [f64; N] {
    std::array::from_fn(|n| xi_squared.iter().map(|it| it[n]).fold(0.0, f64::max))
}

/// The frequency of the fastest joint's shaking, times [`AWAY`], as a signal |BᵀPx|, at least.
pub(super) fn shaking_signal<const N: usize>(
    subject: &dyn Subject<N>,
    gains: &Gains<N>,
    on_path: &[[f64; N]],
) -> f64 {
    let rate = frequency(subject, gains, &largest(on_path));
    (0..N).map(|n| subject.p()[n].p22 * rate[n] * AWAY).fold(f64::INFINITY, f64::min)
}

/// Steps of a pivoted Cholesky factorisation: each takes the ξ that sticks out most of the span of
/// those before.
fn count_directions(products: &DMatrix<f64>) -> usize {
    let mut rest = products.clone();
    let most = rest.diagonal().max();
    for count in 0..rest.nrows() {
        let pivot = rest.diagonal().imax();
        let size = rest[(pivot, pivot)];
        if size <= 0.0 || size < DIRECTION * most {
            return count;
        }
        let column = rest.column(pivot).into_owned();
        rest.ger(-1.0 / size, &column, &column, 1.0);
    }
    rest.nrows()
}

/// 1 − RMS of what W leaves over RMS of ρ, at the points between those that W is fitted to.
fn explained(products: &DMatrix<f64>, rho: &DVector<f64>) -> f64 {
    let even = |k: &usize| k.is_multiple_of(2);
    let (fitted, judged): (Vec<usize>, Vec<usize>) = (0..rho.len()).partition(even);
    let mut normal = products.select_rows(&fitted).select_columns(&fitted);
    let ridge = RIDGE * normal.trace().max(f64::MIN_POSITIVE);
    for k in 0..fitted.len() {
        normal[(k, k)] += ridge;
    }
    let size = |values: &DVector<f64>| values.norm();
    let wanted = rho.select_rows(&judged);
    let Some(factor) = normal.cholesky() else { return 0.0 };
    if size(&wanted) == 0.0 {
        return 1.0;
    }
    let coefficients = factor.solve(&rho.select_rows(&fitted));
    let given = products.select_rows(&judged).select_columns(&fitted) * coefficients;
    (1.0 - size(&(&wanted - given)) / size(&wanted)).clamp(0.0, 1.0)
}

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
use crate::error::Result;

/// Ridge, as a share of the mean of |ξ|².
const RIDGE: f64 = 1e-6;

/// Rules that explain more than this share of ρ_d can learn it.
const LEARNT: f64 = 0.5;

/// A direction counts if ξ has this share of the largest |ξ|² in it.
const DIRECTION: f64 = 1e-3;

/// What is learnt along a path.
#[derive(Clone, Debug, PartialEq)]
pub struct Learning<const N: usize> {
    /// |ξ|² of each joint at every point.
    pub(super) xi_squared: Vec<[f64; N]>,
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
    /// Of a compensator along a path.
    pub(super) fn new(subject: &dyn Subject<N>, course: &Course<N>) -> Result<Self> {
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
        Ok(Self {
            xi_squared: diagonals(&products),
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

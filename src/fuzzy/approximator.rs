//! A fuzzy system as a plain function approximator, y(x) = W ξ(x), fitted to samples by ridge
//! regression.
//!
//! `min_W Σ |W ξ(x_k) − y_k|² + ridge T |W|²` over T samples: the universal approximation statement
//! (5), to look at.

use super::FuzzyBasis;
use crate::error::{Error, Result, at_most, finite, length, non_negative, not_empty};

/// The normal equations are a dense matrix of this order at the most (128 MiB).
const MAX_FITTED_RULES: usize = 4096;

/// y(x) = W ξ(x) with weights that were fitted to samples.
#[derive(Clone, Debug)]
pub struct FuzzyApproximator {
    basis: FuzzyBasis,
    outputs: usize,
    weights: Vec<f64>,
    work: usize,
}

impl FuzzyApproximator {
    /// Fits W to samples: `x` row-major (samples × inputs), `y` row-major (samples × outputs).
    ///
    /// # Errors
    /// `x`, `y`: lengths that do not fit, no sample, or not finite. `outputs`: 0. `ridge`:
    /// negative. `rules`: more than 4096. `ridge` again, as
    /// [`NotPositive`](crate::Problem::NotPositive), when the samples do not determine W: give more
    /// ridge.
    pub fn fit(
        basis: FuzzyBasis,
        x: &[f64],
        y: &[f64],
        outputs: usize,
        ridge: f64,
    ) -> Result<Self> {
        let (inputs, rules) = (basis.inputs(), basis.rules());
        let samples = x.len() / inputs;
        if samples == 0 || x.len() != samples * inputs {
            let wanted = inputs * samples.max(1);
            return Err(Error::wrong_length("x", x.len(), wanted));
        }
        not_empty("outputs", outputs)?;
        length("y", y.len(), samples.saturating_mul(outputs))?;
        at_most("rules", rules, MAX_FITTED_RULES)?;
        finite("x", x)?;
        finite("y", y)?;
        non_negative("ridge", &[ridge])?;
        let mut normal = NormalEquations::new(rules, outputs);
        let mut work = vec![0.0; basis.work_len()];
        let mut xi = vec![0.0; rules];
        for (x, y) in x.chunks_exact(inputs).zip(y.chunks_exact(outputs)) {
            basis.evaluate(x, &mut work, &mut xi)?;
            normal.add(&xi, y);
        }
        let weights = normal.solve(ridge * samples as f64)?;
        Ok(Self { work: basis.work_len(), basis, outputs, weights })
    }

    /// y(x) = W ξ(x) with known weights, row-major (outputs × rules).
    ///
    /// # Errors
    /// `weights`: not a whole number of rows, none, or not finite.
    pub fn from_weights(basis: FuzzyBasis, weights: Vec<f64>) -> Result<Self> {
        let (got, rules) = (weights.len(), basis.rules());
        if got == 0 || !got.is_multiple_of(rules) {
            let wanted = got.next_multiple_of(rules).max(rules);
            return Err(Error::wrong_length("weights", got, wanted));
        }
        finite("weights", &weights)?;
        Ok(Self { work: basis.work_len(), basis, outputs: got / rules, weights })
    }

    /// W, row-major (outputs × rules).
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// The basis ξ.
    pub fn basis(&self) -> &FuzzyBasis {
        &self.basis
    }

    /// Number of outputs.
    pub fn outputs(&self) -> usize {
        self.outputs
    }

    /// y at every row of `x`, row-major (samples × outputs).
    ///
    /// # Errors
    /// `x`: no whole number of rows, or not finite.
    pub fn evaluate(&self, x: &[f64]) -> Result<Vec<f64>> {
        let (inputs, rules) = (self.basis.inputs(), self.basis.rules());
        if !x.len().is_multiple_of(inputs) {
            let wanted = x.len().next_multiple_of(inputs);
            return Err(Error::wrong_length("x", x.len(), wanted));
        }
        let mut work = vec![0.0; self.work];
        let mut xi = vec![0.0; rules];
        let mut y = Vec::with_capacity(x.len() / inputs * self.outputs);
        for x in x.chunks_exact(inputs) {
            self.basis.evaluate(x, &mut work, &mut xi)?;
            for row in self.weights.chunks_exact(rules) {
                y.push(row.iter().zip(&xi).map(|(w, p)| w * p).sum());
            }
        }
        Ok(y)
    }
}

/// Ξᵀ Ξ and Ξᵀ Y, lower triangle and rows of Y.
struct NormalEquations {
    rules: usize,
    gram: Vec<f64>,
    right: Vec<f64>,
}

impl NormalEquations {
    fn new(rules: usize, outputs: usize) -> Self {
        Self { rules, gram: vec![0.0; rules * rules], right: vec![0.0; outputs * rules] }
    }

    fn add(&mut self, xi: &[f64], y: &[f64]) {
        for (i, a) in xi.iter().enumerate().filter(|(_, a)| **a != 0.0) {
            let row = &mut self.gram[i * self.rules..i * self.rules + i + 1];
            row.iter_mut().zip(xi).for_each(|(g, b)| *g += a * b);
        }
        for (row, y) in self.right.chunks_exact_mut(self.rules).zip(y) {
            row.iter_mut().zip(xi).for_each(|(r, a)| *r += y * a);
        }
    }

    fn solve(mut self, shift: f64) -> Result<Vec<f64>> {
        for i in 0..self.rules {
            self.gram[i * self.rules + i] += shift;
        }
        let gram = nalgebra::DMatrix::from_row_slice(self.rules, self.rules, &self.gram);
        let Some(factor) = gram.cholesky() else {
            let wanted = "positive definite (add ridge or samples)";
            return Err(Error::not_positive("ridge", 0.0, wanted));
        };
        let rows = self.right.chunks_exact(self.rules);
        Ok(rows
            .flat_map(|row| {
                let column = nalgebra::DVector::from_column_slice(row);
                factor.solve(&column).as_slice().to_vec()
            })
            .collect())
    }
}

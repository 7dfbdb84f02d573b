//! What a closed loop adds to its certificate.

use super::certificate::Certificate;
use super::closed_loop::ClosedLoop;
use super::evaluation::Evaluation;
use super::integrators::{RK4, Tableau};
use super::stiff::FRICTION_WEIGHTS;
use crate::math::Vector;

impl<const N: usize, A, D, L, C, R> ClosedLoop<'_, N, A, D, L, C, R> {
    /// Remembers 2 s·F of a stage.
    pub(super) fn pull(&mut self, stage: usize, evaluation: &Evaluation<N>, braking: &Vector<N>) {
        self.pulls[stage] = evaluation.audit.map_or(0.0, |audit| 2.0 * audit.s.dot(braking));
    }

    /// Adds the step that was just taken to the certificate.
    #[inline]
    pub(super) fn certify<const S: usize>(
        &self,
        tableau: &Tableau<S>,
        h: f64,
        certificate: &mut Certificate,
    ) {
        for (weight, share) in tableau.weights.iter().zip(&self.shares) {
            certificate.add(weight * h, share);
        }
    }

    /// The same for a step that [`finish`](Self::finish) made. The work of friction entered V with
    /// weights of its own. The part at the end of the step waits for [`settle`](Self::settle).
    pub(super) fn certify_step(&self, h: f64, certificate: &mut Certificate) {
        self.certify(&RK4, h, certificate);
        if self.last_braking.is_some() {
            let [b2, b3, b4, _] = FRICTION_WEIGHTS;
            for (i, b) in [0.0, b2, b3, b4].into_iter().enumerate() {
                certificate.supplied += h * (b - RK4.weights[i]) * self.pulls[i];
            }
        }
    }

    /// Adds to the certificate what friction did at the end of the last step, of length `h` \[s\],
    /// from the loop `at` that end.
    #[inline]
    pub(super) fn settle(&mut self, at: &Evaluation<N>, h: f64, certificate: &mut Certificate) {
        if let (Some(audit), Some(braking)) = (&at.audit, self.last_braking.take()) {
            let weight = h * FRICTION_WEIGHTS[3];
            certificate.supplied += weight * 2.0 * audit.s.dot(&braking);
        }
    }
}

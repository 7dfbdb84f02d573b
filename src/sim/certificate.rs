//! The Lyapunov certificate of a run: the dissipation identity, integrated beside the motion.
//!
//! ```text
//! V(T) − V(0) = ∫ (2 s·ρ − loss) dt            exact for the law as implemented
//! ∫ xᵀQx dt ≤ V(0) + γ² ∫ |ρ − W₀ξ|² dt        what the theorem really promises
//! ```
//!
//! Any sign slip in the law, in P or in B breaks the identity by as much as it moves V.

use super::closed_loop::Evaluation;

/// Both sides of the identity over a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Certificate {
    /// V at the start.
    pub v_start: f64,
    /// V at the end.
    pub v_end: f64,
    /// ∫ (2 s·ρ − loss) dt.
    pub supplied: f64,
    /// ∫ (|2 s·ρ| + loss) dt: what the residual is relative to, with V.
    pub turnover: f64,
    /// ∫ xᵀQx dt.
    pub state_cost: f64,
    /// ∫ |ρ − W₀ξ|² dt.
    pub uncertainty: f64,
}

impl Certificate {
    /// |V(T) − V(0) − ∫ (2 s·ρ − loss)| over the larger of V and the turnover; 0 for a run of no length.
    pub fn residual(&self) -> f64 {
        let scale = self.turnover.max(self.v_start).max(self.v_end);
        let difference = (self.v_end - self.v_start - self.supplied).abs();
        if scale > 0.0 { difference / scale } else { difference }
    }

    /// The integrands at one stage; zero for a compensator without a proof.
    #[inline]
    pub(super) fn rates<const N: usize>(evaluation: &Evaluation<N>) -> Self {
        let Some(audit) = &evaluation.audit else { return Self::default() };
        let supply = 2.0 * audit.s.dot(&evaluation.rho);
        Self {
            supplied: supply - audit.loss,
            turnover: supply.abs() + audit.loss.abs(),
            state_cost: audit.state_cost,
            uncertainty: (evaluation.rho - audit.prior).norm_squared(),
            ..Self::default()
        }
    }

    /// Adds the integrands of one stage with their quadrature weight [s].
    #[inline]
    pub(super) fn add(&mut self, weight: f64, rates: &Self) {
        self.supplied += weight * rates.supplied;
        self.turnover += weight * rates.turnover;
        self.state_cost += weight * rates.state_cost;
        self.uncertainty += weight * rates.uncertainty;
    }
}

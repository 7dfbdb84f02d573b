//! The Lyapunov certificate of a run: the dissipation identity, integrated beside the motion.
//!
//! ```text
//! V(T) − V(0) = ∫ (2 s·ρ − loss) dt = ∫ (−xᵀQx − |s/γ − γε|² + γ²|ε|² − …) dt     ε = ρ − W₀ξ
//! ∫ xᵀQx dt ≤ V(0) + γ² ∫ |ε|² dt
//! ```
//!
//! The first line is exact for the law as implemented; the second is what the theorem really
//! promises.
//!
//! Any sign slip in the law, in P or in B breaks the identity by as much as it moves V.

use super::evaluation::Evaluation;

/// Both sides of the identity over a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Certificate {
    /// V at the start.
    pub v_start: f64,
    /// V at the end.
    pub v_end: f64,
    /// ∫ (2 s·ρ − loss) dt.
    pub supplied: f64,
    /// ∫ (xᵀQx + |s/c − cε|² + c²|ε|²) dt with c = min(γ, 1), finite for every γ: what the residual
    /// is relative to.
    pub turnover: f64,
    /// ∫ xᵀQx dt.
    pub state_cost: f64,
    /// ∫ |ε|² dt.
    pub uncertainty: f64,
}

impl Certificate {
    /// |V(T) − V(0) − ∫ (2 s·ρ − loss) dt| over the larger of V and the turnover.
    pub fn residual(&self) -> f64 {
        let scale = self.turnover.max(self.v_start).max(self.v_end);
        let difference = (self.v_end - self.v_start - self.supplied).abs();
        if scale > 0.0 { difference / scale } else { difference }
    }

    /// The integrands at one stage; zero for a compensator without a proof.
    #[inline]
    pub(super) fn rates<const N: usize>(evaluation: &Evaluation<N>) -> Self {
        let Some(audit) = &evaluation.audit else { return Self::default() };
        let epsilon = evaluation.rho - audit.prior;
        let (uncertainty, c) = (epsilon.norm_squared(), audit.gamma.min(1.0));
        let mismatch = (audit.s / c - epsilon * c).norm_squared();
        Self {
            supplied: 2.0 * audit.s.dot(&evaluation.rho) - audit.loss,
            turnover: audit.state_cost + mismatch + c * c * uncertainty,
            state_cost: audit.state_cost,
            uncertainty,
            ..Self::default()
        }
    }

    /// Adds the integrands of one stage with their quadrature weight \[s\].
    #[inline]
    pub(super) fn add(&mut self, weight: f64, rates: &Self) {
        self.supplied += weight * rates.supplied;
        self.turnover += weight * rates.turnover;
        self.state_cost += weight * rates.state_cost;
        self.uncertainty += weight * rates.uncertainty;
    }
}

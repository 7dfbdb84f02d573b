//! The record of a run, time first.

use core::fmt;
use std::collections::TryReserveError;

use super::certificate::Certificate;
use super::closed_loop::Evaluation;
use crate::error::Error;
use crate::math::Vector;

/// Why a run ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Status {
    /// It reached its duration.
    Finished,
    /// It was stopped from outside at this time [s].
    Interrupted {
        /// Time of the last step [s].
        t: f64,
    },
    /// It could not go on.
    Diverged {
        /// Time at which that was noticed [s].
        t: f64,
        /// What happened.
        cause: Cause,
    },
}

/// Why a run could not go on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cause {
    /// The reference is not finite.
    Reference,
    /// The disturbance, or the acceleration it leads to, is not finite.
    Acceleration,
    /// A position or velocity passed 1e6.
    Motion,
    /// The error control asked for steps too short to advance the time.
    StepTooShort,
    /// The controller refused the sample.
    Rejected(Error),
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Reference => f.write_str("the reference is not finite"),
            Self::Acceleration => {
                f.write_str("the torque, disturbance or acceleration is not finite")
            }
            Self::Motion => f.write_str("a position or velocity passed 1e6 rad or rad/s"),
            Self::StepTooShort => {
                f.write_str("the error control asked for steps too short to advance the time")
            }
            Self::Rejected(error) => write!(f, "the controller refused the sample: {error}"),
        }
    }
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Finished => f.write_str("finished"),
            Self::Interrupted { t } => write!(f, "interrupted at t = {t:.6} s"),
            Self::Diverged { t, cause } => write!(f, "diverged at t = {t:.6} s because {cause}"),
        }
    }
}

/// Everything that was recorded, a row a time. Every entry is finite.
#[derive(Clone, Debug, PartialEq)]
pub struct Run<const N: usize> {
    /// Time [s].
    pub t: Vec<f64>,
    /// Position [rad].
    pub q: Vec<[f64; N]>,
    /// Velocity [rad/s].
    pub dq: Vec<[f64; N]>,
    /// Desired position [rad].
    pub q_d: Vec<[f64; N]>,
    /// Desired velocity [rad/s].
    pub dq_d: Vec<[f64; N]>,
    /// Desired acceleration [rad/s²].
    pub ddq_d: Vec<[f64; N]>,
    /// Tracking error q − q_d [rad].
    pub e: Vec<[f64; N]>,
    /// Its rate [rad/s].
    pub de: Vec<[f64; N]>,
    /// Applied torque [N·m].
    pub tau: Vec<[f64; N]>,
    /// Part of the nominal model [N·m].
    pub tau_model: Vec<[f64; N]>,
    /// Part of the compensator [N·m].
    pub tau_compensation: Vec<[f64; N]>,
    /// ρ, what the nominal model leaves out [rad/s²].
    pub rho: Vec<[f64; N]>,
    /// ρ̂, its estimate [rad/s²].
    pub rho_hat: Vec<[f64; N]>,
    /// |W − W₀|; empty without a compensator that has a proof.
    pub weights_norm: Vec<f64>,
    /// Lyapunov function; empty without a compensator that has a proof.
    pub v: Vec<f64>,
    /// Why the run ended.
    pub status: Status,
    /// The dissipation identity; `None` in sampled control or without a compensator that has a proof.
    pub certificate: Option<Certificate>,
}

impl<const N: usize> Run<N> {
    /// An empty record with room for `rows` rows.
    pub(super) fn with_capacity(rows: usize) -> Result<Self, TryReserveError> {
        fn room<T>(rows: usize) -> Result<Vec<T>, TryReserveError> {
            let mut column = Vec::new();
            column.try_reserve_exact(rows)?;
            Ok(column)
        }
        Ok(Self {
            t: room(rows)?,
            q: room(rows)?,
            dq: room(rows)?,
            q_d: room(rows)?,
            dq_d: room(rows)?,
            ddq_d: room(rows)?,
            e: room(rows)?,
            de: room(rows)?,
            tau: room(rows)?,
            tau_model: room(rows)?,
            tau_compensation: room(rows)?,
            rho: room(rows)?,
            rho_hat: room(rows)?,
            weights_norm: room(rows)?,
            v: room(rows)?,
            status: Status::Finished,
            certificate: None,
        })
    }

    /// Adds a row.
    #[inline]
    pub(super) fn push(&mut self, at: &Evaluation<N>) {
        let row = |x: &Vector<N>| -> [f64; N] { (*x).into() };
        self.t.push(at.t);
        self.q.push(row(&at.sample.q));
        self.dq.push(row(&at.sample.dq));
        self.q_d.push(row(&at.sample.desired.q));
        self.dq_d.push(row(&at.sample.desired.dq));
        self.ddq_d.push(row(&at.sample.desired.ddq));
        self.e.push(row(&at.sample.e));
        self.de.push(row(&at.sample.de));
        self.tau.push(row(&at.applied));
        self.tau_model.push(row(&at.command.model));
        self.tau_compensation.push(row(&at.command.compensation));
        self.rho.push(row(&at.rho));
        self.rho_hat.push(row(&at.command.rho_hat));
        if let Some(audit) = &at.audit {
            self.weights_norm.push(audit.weights_norm);
            self.v.push(audit.value);
        }
    }
}

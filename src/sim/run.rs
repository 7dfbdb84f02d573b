//! The record of a run, time first.

use core::fmt;
use core::hint::black_box;
use std::collections::TryReserveError;

use super::certificate::Certificate;
use super::doubt::Doubt;
use super::evaluation::Evaluation;
use super::options::Record;
use crate::control::Sample;
use crate::error::Error;
use crate::math::Vector;
use crate::reference::Reference;

/// Why a run ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Status {
    /// It reached its duration.
    Finished,
    /// It reached its duration, in steps too long to be believed.
    Unresolved(Doubt),
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
        /// Steps that were too long before that, which may be why.
        doubt: Option<Doubt>,
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
            Self::Unresolved(doubt) => write!(f, "finished, but not resolved: {doubt}"),
            Self::Interrupted { t } => write!(f, "interrupted at t = {t:.6} s"),
            Self::Diverged { t, cause, doubt } => {
                write!(f, "diverged at t = {t:.6} s because {cause}")?;
                doubt.map_or(Ok(()), |doubt| write!(f, "; before that, {doubt}"))
            }
        }
    }
}

/// Everything that was recorded, a row a time. Every entry is finite. What was not to be recorded is empty.
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
    pub(super) fn with_capacity(rows: usize, record: Record) -> Result<Self, TryReserveError> {
        let all = if record == Record::All { rows } else { 0 };
        fn room<T>(rows: usize) -> Result<Vec<T>, TryReserveError> {
            let mut column = Vec::new();
            column.try_reserve_exact(rows)?;
            Ok(column)
        }
        // Asked for and given back at once: allocators that return a large block to the system when it is freed, to be
        // zeroed page by page for the next run, keep blocks as large as one that was freed before.
        let whole = room::<f64>((3 * rows).saturating_add(12 * all).saturating_mul(N))?;
        drop(black_box(whole));
        Ok(Self {
            t: room(rows)?,
            q: room(rows)?,
            dq: room(rows)?,
            q_d: room(all)?,
            dq_d: room(all)?,
            ddq_d: room(all)?,
            e: room(all)?,
            de: room(all)?,
            tau: room(all)?,
            tau_model: room(all)?,
            tau_compensation: room(all)?,
            rho: room(all)?,
            rho_hat: room(all)?,
            weights_norm: room(all)?,
            v: room(all)?,
            status: Status::Finished,
            certificate: None,
        })
    }

    /// Adds the desired motion and the error to a record of the motion alone, from the run's `reference` at the times of its
    /// rows: the same as in a record of all signals. `wraps` are the controller's, `controller.law.wraps()`.
    pub fn add_reference<R: Reference<N>>(&mut self, reference: &R, wraps: &[bool; N]) {
        for k in self.q_d.len()..self.t.len() {
            let (q, dq) = (self.q[k].into(), self.dq[k].into());
            self.push_desired(&Sample::wrapped(q, dq, reference.at(self.t[k]), wraps));
        }
    }

    /// Adds a row of the motion.
    #[inline]
    pub(super) fn push_motion(&mut self, t: f64, q: &Vector<N>, dq: &Vector<N>) {
        self.t.push(t);
        self.q.push((*q).into());
        self.dq.push((*dq).into());
    }

    /// Adds the desired motion of a row, and the error.
    #[inline]
    fn push_desired(&mut self, sample: &Sample<N>) {
        self.q_d.push(sample.desired.q.into());
        self.dq_d.push(sample.desired.dq.into());
        self.ddq_d.push(sample.desired.ddq.into());
        self.e.push(sample.e.into());
        self.de.push(sample.de.into());
    }

    /// Adds the rest of a row.
    #[inline]
    pub(super) fn push_rest(&mut self, at: &Evaluation<N>) {
        self.push_desired(&at.sample);
        self.tau.push(at.applied.into());
        self.tau_model.push(at.command.model.into());
        self.tau_compensation.push(at.command.compensation.into());
        self.rho.push(at.rho.into());
        self.rho_hat.push(at.command.rho_hat.into());
        if let Some(audit) = &at.audit {
            self.weights_norm.push(audit.weights_norm);
            self.v.push(audit.value);
        }
    }
}

//! The record of a run, time first: every signal is declared here, in one line.

use core::hint::black_box;
use std::collections::TryReserveError;

use super::certificate::Certificate;
use super::channels::{Cell, Column, record, room};
use super::evaluation::Evaluation;
use super::metrics::Metrics;
use super::options::Record;
use super::status::Status;
use crate::control::{Audit, Channel, Sample};
use crate::math::Vector;
use crate::reference::Reference;

record! {
    /// Everything that was recorded, one row per time. Every entry is finite. Signals that were not
    /// recorded are empty.
    #[derive(Clone, Debug, PartialEq)]
    pub struct Run<const N: usize>;

    /// Adds a row of the motion.
    in Record::Motion, fn push_motion(t: f64, q: &Vector<N>, dq: &Vector<N>) {
        t: f64, "s", "Time" = t;
        q: [f64; N], "rad", "Position" = (*q).into();
        dq: [f64; N], "rad/s", "Velocity" = (*dq).into();
    }

    /// Adds the desired motion of a row, and the error.
    in Record::All, fn push_desired(at: &Sample<N>) {
        q_d: [f64; N], "rad", "Desired position" = at.desired.q.into();
        dq_d: [f64; N], "rad/s", "Desired velocity" = at.desired.dq.into();
        ddq_d: [f64; N], "rad/s²", "Desired acceleration" = at.desired.ddq.into();
        e: [f64; N], "rad", "Tracking error q − q_d, in [−π, π) for a continuous joint"
            = at.e.into();
        de: [f64; N], "rad/s", "Rate of the tracking error" = at.de.into();
    }

    /// Adds what controller and plant made of a row.
    in Record::All, fn push_loop(at: &Evaluation<N>) {
        tau: [f64; N], "N·m", "Applied torque" = at.applied.into();
        tau_model: [f64; N], "N·m", "Torque of the nominal model, M₀v + H₀"
            = at.command.model.into();
        tau_compensation: [f64; N], "N·m", "Torque of the compensator, −M₀ρ̂"
            = at.command.compensation.into();
        rho: [f64; N], "rad/s²", "ρ, what the nominal model leaves out" = at.rho.into();
        rho_hat: [f64; N], "rad/s²", "ρ̂, the compensator's estimate of ρ"
            = at.command.rho_hat.into();
    }

    /// Adds a row of a compensator that has a proof; without one these are empty.
    in Record::All, fn push_proof(at: &Audit<N>) {
        weights_norm: f64, "rad/s²", "|W − W₀|, the size of the weights" = at.weights_norm;
        v as "V": f64, "1", "Lyapunov function" = at.value;
    }

    also {
        /// Why the run ended.
        status: Status = Status::Finished;
        /// The dissipation identity; `None` in sampled control or without a compensator that has a
        /// proof.
        certificate: Option<Certificate> = None;
        /// The figures of every joint, of a run of [`Record::Metrics`] that has rows in its window;
        /// otherwise `None`.
        metrics: Option<[Metrics; N]> = None;
    }
}

impl<const N: usize> Run<N> {
    /// A run that finished, of [`Record::Metrics`].
    pub(super) fn of_metrics(metrics: [Metrics; N]) -> Option<Self> {
        let empty = Self::with_room(0, Record::Motion, &[]).ok()?;
        Some(Self { metrics: Some(metrics), ..empty })
    }

    /// The signals that every record has; those of the compensator are in `own`.
    pub fn channels() -> impl Iterator<Item = &'static Channel> {
        Self::TABLE.iter().map(|(_, channel)| channel)
    }

    /// What a row takes at most, with these signals of others beside it \[bytes\].
    pub(super) fn row_bytes(record: Record, own: &[Channel]) -> usize {
        let common = Self::TABLE.iter().map(|&(kind, ref channel)| (kind, channel));
        let all = common.chain(own.iter().map(|channel| (Record::All, channel)));
        let taken = all.filter(|(kind, _)| record.takes(*kind));
        taken.map(|(_, channel)| channel.width.of(N) * size_of::<f64>()).sum()
    }

    /// An empty record with room for `rows` rows of the common signals and these `own` ones.
    pub(super) fn with_capacity(
        rows: usize,
        record: Record,
        own: &[Channel],
    ) -> Result<Self, TryReserveError> {
        // The block is asked for and freed at once. Some allocators return a large freed block to
        // the system, which then zeroes it page by page for the next run. They keep blocks as large
        // as one that was freed before.
        let whole = room::<u8>(rows.saturating_mul(Self::row_bytes(record, own)))?;
        drop(black_box(whole));
        Self::with_room(rows, record, own)
    }

    /// Adds the desired motion and the error to a record of the motion alone, from the run's
    /// `reference` at the times of its rows: the same as in a record of all signals. `wraps` are
    /// the controller's, `controller.law.wraps()`.
    pub fn add_reference<R: Reference<N>>(&mut self, reference: &R, wraps: &[bool; N]) {
        for k in self.q_d.len()..self.t.len() {
            let (q, dq) = (self.q[k].into(), self.dq[k].into());
            self.push_desired(&Sample::wrapped(q, dq, reference.at(self.t[k]), wraps));
        }
    }

    /// Adds the rest of a row; `own` holds that of the `own` signals, one after the other.
    #[inline]
    pub(super) fn push_rest(&mut self, at: &Evaluation<N>, own: &[f64]) {
        self.push_desired(&at.sample);
        self.push_loop(at);
        if let Some(audit) = &at.audit {
            self.push_proof(audit);
        }
        let mut rest = own;
        for Column { channel, values } in &mut self.own {
            let (row, next) = rest.split_at(channel.width.of(N));
            values.extend_from_slice(row);
            rest = next;
        }
    }
}

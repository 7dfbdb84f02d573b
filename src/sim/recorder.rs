//! Which rows enter the record, and when a run cannot go on.

use super::certificate::Certificate;
use super::evaluation::Evaluation;
use super::integrators::Motion;
use super::metrics::Figures;
use super::options::{MAX_RECORD_BYTES, Options, Record};
use super::resolution::Resolution;
use super::run::Run;
use super::status::{Cause, Status};
use super::stiff::Moved;
use crate::control::{Channel, Sample};
use crate::error::{Error, Result};
use crate::math::Vector;

/// A position or velocity beyond this counts as diverged [rad, rad/s].
pub(super) const DIVERGED: f64 = 1e6;

/// The record with what decides which rows enter it.
pub(super) struct Recorder<const N: usize> {
    run: Run<N>,
    /// A row of the compensator's own signals.
    own: Vec<f64>,
    /// The figures so far, where they are all that is wanted.
    figures: Option<Figures<N>>,
    certificate: Option<Certificate>,
    resolution: Resolution<N>,
    /// Number of the last row.
    pub steps: usize,
    every: usize,
    record: Record,
    /// Spacing of the rows \[s\].
    pub dt: f64,
}

impl<const N: usize> Recorder<N> {
    /// An empty record of rows 0 … `steps`, of the common signals and these `own` ones.
    ///
    /// # Errors
    /// `channels`: one of `own` has the name of another signal.
    /// `record_every`: the record is larger than [`MAX_RECORD_BYTES`], or than memory.
    pub fn new(steps: usize, options: &Options<N>, own: &[Channel]) -> Result<Self> {
        let own = if let Record::Metrics(_) = options.record { &[] } else { own };
        check_names::<N>(own)?;
        let every = options.record_every;
        let rows = steps.div_ceil(every) + 1;
        let row_bytes = Run::<N>::row_bytes(options.record, own);
        let limit = MAX_RECORD_BYTES;
        let too_large = Error::record_too_large(every, (rows, row_bytes), limit);
        if rows as u64 > limit / (row_bytes as u64).max(1) {
            return Err(too_large);
        }
        let run = Run::with_capacity(rows, options.record, own).map_err(|_| too_large)?;
        let (record, dt) = (options.record, options.dt);
        let figures = match record {
            Record::Metrics(window) => Some(Figures::over(window, 0.0)),
            Record::All | Record::Motion => None,
        };
        let resolution = Resolution::new(dt);
        let own = vec![0.0; own.iter().map(|channel| channel.width.of(N)).sum()];
        Ok(Self { run, own, figures, certificate: None, resolution, steps, every, record, dt })
    }

    /// Time of row k \[s\].
    #[inline]
    pub fn time(&self, k: usize) -> f64 {
        k as f64 * self.dt
    }

    /// Whether row k enters the record.
    #[inline]
    pub fn due(&self, k: usize) -> bool {
        self.every == 1 || k.is_multiple_of(self.every) || k == self.steps
    }

    /// False, with the status set, if the run cannot go on from here.
    #[inline]
    pub fn check(&mut self, at: &Evaluation<N>) -> bool {
        match trouble(at) {
            None => true,
            Some(cause) => {
                self.diverged(at.t, cause);
                false
            }
        }
    }

    /// Whether a row needs more than the motion.
    pub fn wants_all(&self) -> bool {
        self.record != Record::Motion
    }

    /// Whether all of row k enters the record.
    #[inline]
    pub fn takes(&self, k: usize) -> bool {
        self.record == Record::All && self.due(k)
    }

    /// Records row k, in which nothing was wrong, if it is due. `own` writes the row of the
    /// compensator's own signals.
    #[inline]
    pub fn take(&mut self, k: usize, at: &Evaluation<N>, own: impl FnOnce(&mut [f64])) {
        if self.due(k) {
            self.push(at, own);
        }
    }

    /// Records a row between two steps, unless something is wrong with it.
    pub fn take_between(&mut self, at: &Evaluation<N>, own: impl FnOnce(&mut [f64])) {
        if trouble(at).is_none() {
            self.push(at, own);
        }
    }

    /// Adds the signals of a row that are to be recorded.
    #[inline]
    fn push(&mut self, at: &Evaluation<N>, own: impl FnOnce(&mut [f64])) {
        if let Some(figures) = &mut self.figures {
            return figures.add(at.t, &at.sample.e, &at.applied);
        }
        self.run.push_motion(at.t, &at.sample.q, &at.sample.dq);
        if self.wants_all() {
            if !self.own.is_empty() {
                own(&mut self.own);
            }
            self.run.push_rest(at, &self.own);
        }
    }

    /// The same for a row of the motion.
    #[inline]
    pub fn take_motion(&mut self, t: f64, Motion { q, dq }: &Motion<N>) {
        if small(q) && small(dq) {
            self.run.push_motion(t, q, dq);
        }
    }

    /// Confirms the certificate up to an evaluation in which nothing was wrong.
    #[inline]
    pub fn confirm(&mut self, certificate: &mut Certificate, at: &Evaluation<N>) {
        if let Some(audit) = &at.audit {
            if self.certificate.is_none() {
                certificate.v_start = audit.value;
            }
            certificate.v_end = audit.value;
            self.certificate = Some(*certificate);
        }
    }

    /// Notes how well the step from time `t` \[s\] on followed the motion.
    #[inline]
    pub fn resolve(&mut self, t: f64, start: &Motion<N>, moved: &Moved<N>) {
        self.resolution.add(t, start, moved);
    }

    /// Notes that the run was stopped from outside.
    pub fn interrupted(&mut self, t: f64) {
        self.run.status = Status::Interrupted { t };
    }

    /// Notes why the run cannot go on.
    pub fn diverged(&mut self, t: f64, cause: Cause) {
        self.run.status = Status::Diverged { t, cause, doubt: self.resolution.suspicion() };
    }

    /// The record.
    pub fn finish(mut self) -> Run<N> {
        if let (Status::Finished, Some(doubt)) = (self.run.status, self.resolution.doubt()) {
            self.run.status = Status::Unresolved(doubt);
        }
        match self.figures {
            None => self.run.certificate = self.certificate,
            Some(figures) => self.run.metrics = figures.finish(|x| x),
        }
        self.run
    }
}

/// Refuses names that two signals have.
fn check_names<const N: usize>(own: &[Channel]) -> Result<()> {
    let mut names: Vec<&str> = Run::<N>::channels().map(|channel| channel.name).collect();
    for (i, channel) in own.iter().enumerate() {
        if names.contains(&channel.name) {
            let wanted = "channels of names that no other signal of the record has";
            return Err(Error::out_of_range("channels", i as f64, wanted).at(i));
        }
        names.push(channel.name);
    }
    Ok(())
}

/// Why a run cannot go on from here, if it cannot.
#[inline]
fn trouble<const N: usize>(at: &Evaluation<N>) -> Option<Cause> {
    if moderate(&at.sample) && finite(&at.rho) { None } else { Some(cause(&at.sample)) }
}

/// Whether nothing is wrong with a motion and its set-point.
#[inline]
fn moderate<const N: usize>(sample: &Sample<N>) -> bool {
    let Sample { q, dq, desired, .. } = sample;
    small(q) && small(dq) && finite(&desired.q) && finite(&desired.dq) && finite(&desired.ddq)
}

/// What is wrong with a sample that is not moderate.
#[cold]
fn cause<const N: usize>(sample: &Sample<N>) -> Cause {
    let Sample { q, dq, desired, .. } = sample;
    if !(finite(&desired.q) && finite(&desired.dq) && finite(&desired.ddq)) {
        return Cause::Reference;
    }
    // A NaN position comes from a NaN acceleration.
    let far = q.iter().chain(dq.iter()).any(|v| v.abs() > DIVERGED);
    if far { Cause::Motion } else { Cause::Acceleration }
}

/// Whether positions or velocities have not diverged.
#[inline]
fn small<const N: usize>(x: &Vector<N>) -> bool {
    x.iter().all(|v| v.abs() <= DIVERGED)
}

#[inline]
fn finite<const N: usize>(x: &Vector<N>) -> bool {
    x.iter().all(|v| v.is_finite())
}

//! Many runs, on as many threads as there are cores to spare, eight side by side where they can be.
//!
//! Each run has the bits of [`simulate`](super::simulate), whatever runs beside it. The way
//! through: a `case` is a run; `abreast` (continuous time) and `sampled` are loops of eight, a run
//! a lane; `surroundings` are what these are asked to do and what pushes them, `bodies` their arms,
//! `forces` what moves these, `estimators` what compensates in continuous time. In sampled loops
//! `deciders` decide: `together`, or one after the other from `models`; `affected` stands between
//! these and what sensors measure, and `measured` are those that decide together there. What is
//! left over, and what was lost, goes alone.

mod abreast;
mod affected;
mod bodies;
mod case;
mod course;
mod deciders;
mod estimators;
mod forces;
mod measured;
mod models;
mod registers;
mod sampled;
mod surroundings;
#[cfg(test)]
mod tests;
mod together;

use core::convert::Infallible;
use core::ops::ControlFlow;
use core::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::panic::resume_unwind;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread::scope;
use std::time::Duration;

use pulp::Arch;

use self::abreast::Loops;
use self::affected::goes_along;
use self::bodies::Bodies;
pub use self::case::Case;
use self::course::Course;
use self::sampled::SampledLoops;
use super::metrics::Window;
use super::options::{Method, Options, Record};
use super::run::Run;
use super::simulate::simulate;
use crate::arm::{Arm, MAX_ABREAST};
use crate::control::{Compensator, Law};
use crate::error::Result;
use crate::math::{LANES, has_lanes};
use crate::plant::Disturbance;
use crate::reference::Reference;

/// `watch` is called this often.
const WATCH_EVERY: Duration = Duration::from_millis(20);

/// Simulates every case with these options, but for its own start and effects; on so many threads.
///
/// `watch` is told every 20 ms, in the calling thread, how many runs have ended, and may break all
/// off: those that are under way end as interrupted, and those that were not begun are `None`.
/// A run that diverges, or is refused, ends alone.
pub fn simulate_many<const N: usize, A, D, L, C, R, S>(
    cases: &[Case<'_, N, A, D, L, C, R, S>],
    options: &Options<N>,
    threads: usize,
    mut watch: impl FnMut(usize) -> ControlFlow<()>,
) -> Vec<Option<Result<Run<N>>>>
where
    A: Arm<N> + Sync,
    D: Disturbance<N> + Sync,
    L: Law<N> + Sync,
    C: Compensator<N, S> + Sync,
    R: Reference<N> + Sync,
    S: Clone + Sync,
{
    let mut ended: Vec<_> = cases.iter().map(|_| None).collect();
    let (next, count, stop) = (AtomicUsize::new(0), AtomicUsize::new(0), AtomicBool::new(false));
    // Nothing is sent on it: it ends with the last of the threads that hold it.
    let (working, all_of_them) = channel::<Infallible>();
    scope(|threads_of| {
        let number = threads.clamp(1, cases.len().div_ceil(LANES).max(1));
        let workers: Vec<_> = (0..number)
            .map(|_| {
                let (working, next, count, stop) = (working.clone(), &next, &count, &stop);
                threads_of.spawn(move || {
                    let _working = working;
                    work(cases, options, (next, count), stop)
                })
            })
            .collect();
        drop(working);
        // This thread sleeps but for the watch: the others have all of the cores.
        while all_of_them.recv_timeout(WATCH_EVERY) == Err(RecvTimeoutError::Timeout) {
            if watch(count.load(Ordering::Relaxed)).is_break() {
                stop.store(true, Ordering::Relaxed);
            }
        }
        for worker in workers {
            for (index, run) in worker.join().unwrap_or_else(|panic| resume_unwind(panic)) {
                ended[index] = Some(run);
            }
        }
    });
    ended
}

/// A run, by the place of its case.
type Ended<const N: usize> = (usize, Result<Run<N>>);

/// What a thread does: batch after batch, until there are none.
fn work<const N: usize, A, D, L, C, R, S>(
    cases: &[Case<'_, N, A, D, L, C, R, S>],
    options: &Options<N>,
    (next, count): (&AtomicUsize, &AtomicUsize),
    stop: &AtomicBool,
) -> Vec<Ended<N>>
where
    A: Arm<N>,
    D: Disturbance<N>,
    L: Law<N>,
    C: Compensator<N, S>,
    R: Reference<N>,
    S: Clone,
{
    let mut ended = vec![];
    while !stop.load(Ordering::Relaxed) {
        let first = next.fetch_add(LANES, Ordering::Relaxed);
        let Some(rest) = cases.get(first..).filter(|rest| !rest.is_empty()) else { break };
        let batch = &rest[..rest.len().min(LANES)];
        let together = abreast(batch, options, stop, Arch::new());
        for ((index, case), run) in (first..).zip(batch).zip(together) {
            if stop.load(Ordering::Relaxed) {
                break;
            }
            ended.push((index, run.map_or_else(|| alone(case, options, stop), Ok)));
            count.fetch_add(1, Ordering::Relaxed);
        }
    }
    ended
}

/// The runs of a batch that were made side by side.
fn abreast<const N: usize, A, D, L, C, R, S>(
    batch: &[Case<'_, N, A, D, L, C, R, S>],
    options: &Options<N>,
    stop: &AtomicBool,
    arch: Arch,
) -> [Option<Run<N>>; LANES]
where
    A: Arm<N>,
    D: Disturbance<N>,
    L: Law<N>,
    C: Compensator<N, S>,
    R: Reference<N>,
    S: Clone,
{
    let nothing = [const { None }; LANES];
    if const { N > MAX_ABREAST } || !has_lanes(arch) {
        return nothing;
    }
    let (Some(cases), Some((course, window))) = (batch.first_chunk(), course(options, stop)) else {
        return nothing;
    };
    let sampled = options.control_period.is_some();
    let plain = |case: &Case<'_, N, A, D, L, C, R, S>| {
        let controller = case.controller;
        let as_in_continuous_time = controller.is_bare() && !controller.compensator.sampled_only();
        let alone = case.plant.changes() || !goes_along(&case.effects);
        !alone && (sampled || as_in_continuous_time && !case.effects.is_on())
    };
    // With effects a loop is another one: what a controller is told comes from its drives.
    let affected = |case: &Case<'_, N, A, D, L, C, R, S>| case.effects.is_on();
    if !cases.iter().all(plain) || cases.iter().any(|it| affected(it) != affected(&cases[0])) {
        return nothing;
    }
    let cases = cases.each_ref();
    let Some(bodies) = Bodies::new(cases, window, arch) else { return nothing };
    let metrics = if sampled {
        SampledLoops::new(cases, bodies, course).run(course)
    } else {
        let Some(loops) = Loops::new(cases, bodies) else { return nothing };
        loops.run(course)
    };
    metrics.map(|metrics| metrics.and_then(Run::of_metrics))
}

/// The course of runs that can go side by side, where options are valid.
fn course<'a, const N: usize>(
    options: &Options<N>,
    stop: &'a AtomicBool,
) -> Option<(Course<'a>, Window)> {
    let Options { dt: h, record_every: every, .. } = *options;
    let (steps, hold) = options.steps().ok()?;
    match (options.method, options.record) {
        (Method::Rk4, Record::Metrics(window)) => {
            Some((Course { steps, h, hold, every, stop }, window))
        }
        _ => None,
    }
}

/// One of the runs.
fn alone<const N: usize, A, D, L, C, R, S>(
    case: &Case<'_, N, A, D, L, C, R, S>,
    options: &Options<N>,
    stop: &AtomicBool,
) -> Result<Run<N>>
where
    A: Arm<N>,
    D: Disturbance<N>,
    L: Law<N>,
    C: Compensator<N, S>,
    R: Reference<N>,
    S: Clone,
{
    let Case { plant, controller, state, reference, q0, dq0, effects } = *case;
    let options = Options { q0, dq0, effects, ..*options };
    simulate(plant, controller, &mut state.clone(), reference, &options, |_| {
        if stop.load(Ordering::Relaxed) {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    })
}

//! Many runs in one call: their metrics, without the GIL.

use core::ops::{ControlFlow, Range};

use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

use super::any_arm::AnyArm;
use super::any_law::AnyLaw;
use super::compensator::{AnyCompensator, Memory};
use super::controller::PyController;
use super::convert::{self, Any, Array, Given, joints, object};
use super::curves::PyCurve;
use super::dispatch::{each, of_joints, same_joints};
use super::effects::PyEffects;
use super::plant::{Plant, Plants, PyPlant};
use super::simulate::{Numerics, as_the_tracker, ended, status, window_of};
use super::sources::Source;
use super::tracked::{Tracker, Trackers};
use crate::effects::Effects;
use crate::sim::{self, Metrics, Options, Record, Run, Status, Window};

/// Runs that are made ready at a time: what that takes of memory does not grow with their number.
const READY: usize = 4096;

/// A run of the core.
type Case<'a, const N: usize> = sim::Case<
    'a,
    N,
    AnyArm<N>,
    Option<Source<N>>,
    AnyLaw<N>,
    AnyCompensator<N>,
    Source<N>,
    Memory<N>,
>;

/// What is other from run to run: lists of one entry for all, or of one a run.
#[derive(Clone, Copy)]
struct Lists<'a, 'py> {
    plants: &'a Bound<'py, PyList>,
    trackers: &'a Bound<'py, PyList>,
    references: &'a Bound<'py, PyList>,
    effects: &'a Bound<'py, PyList>,
    q0: &'a Bound<'py, PyList>,
    dq0: &'a Bound<'py, PyList>,
}

/// Run `steadyarm.simulate_many` where only figures are wanted, and nothing calls Python.
///
/// Lists have one entry for all runs, or one a run. Returns the figures, (M, n) each, and the
/// status of each run: its kind, when it ended, and the reason; None for a run that was not begun.
/// Returns None where a run would call Python, or has a guard. ``progress`` is called with the
/// number of runs that ended.
#[pyfunction]
#[pyo3(signature = (count, plants, trackers, references, effects, q0, dq0, duration, dt, method,
    control_period, rtol, atol, record_every, window, band, threads, progress))]
#[expect(clippy::too_many_arguments, reason = "called by keyword from one Python function")]
pub(super) fn simulate_many<'py>(
    py: Python<'py>,
    count: usize,
    plants: &Bound<'py, PyList>,
    trackers: &Bound<'py, PyList>,
    references: &Bound<'py, PyList>,
    effects: &Bound<'py, PyList>,
    q0: &Bound<'py, PyList>,
    dq0: &Bound<'py, PyList>,
    duration: Any<'_, 'py>,
    dt: Any<'_, 'py>,
    method: Any<'_, 'py>,
    control_period: Given<'_, 'py>,
    rtol: Any<'_, 'py>,
    atol: Any<'_, 'py>,
    record_every: Any<'_, 'py>,
    window: Any<'_, 'py>,
    band: Any<'_, 'py>,
    threads: usize,
    progress: Py<PyAny>,
) -> PyResult<Option<Found<'py>>> {
    let lists = Lists { plants, trackers, references, effects, q0, dq0 };
    if lists.call_python()? {
        return Ok(None);
    }
    let numerics = Numerics::of(duration, dt, method, control_period, [rtol, atol])?;
    let every = convert::count(record_every, "record_every", 1)?;
    let asked = (every, window_of(window, band)?);
    let first = trackers.get_item(0)?;
    let first = free(&first)?;
    let mut done = Done::new(count, first.trackers.joints(), progress);
    each!(&first.trackers, Trackers, it => {
        several(py, it, lists, numerics, asked, threads, &mut done)
    })?;
    Ok(Some((done.figures(py)?, done.ended)))
}

/// Figures by name, and how each run ended.
type Found<'py> = (Bound<'py, PyDict>, Vec<Option<Ended>>);

impl Lists<'_, '_> {
    /// Whether any run would call Python, or has a guard.
    fn call_python(&self) -> PyResult<bool> {
        let plants = self.plants.iter().map(|plant| {
            let plant = object::<PyPlant>(&plant, "plant", "a Plant")?.get();
            let pushes = each!(&plant.plants, Plants, plant => {
                plant.disturbance.as_ref().is_some_and(Source::calls)
            });
            Ok(pushes)
        });
        let trackers = self.trackers.iter().map(|tracker| {
            let Ok(tracker) = tracker.cast::<PyController>() else { return Ok(true) };
            let tracker = tracker.try_borrow()?;
            let own = each!(&tracker.trackers, Trackers, it => {
                matches!(it.controller.law, AnyLaw::Own(..))
            });
            Ok(own)
        });
        let references = self.references.iter().map(|it| Ok(it.cast::<PyCurve>().is_err()));
        let mut all = plants.chain(trackers).chain(references);
        all.try_fold(false, |any, calls: PyResult<bool>| Ok(any | calls?))
    }

    /// Refuses what is not of `N` joints.
    fn check<const N: usize>(&self) -> PyResult<()> {
        for plant in self.plants.iter() {
            let plant = object::<PyPlant>(&plant, "plant", "a Plant")?.get();
            as_the_tracker::<N>(plant.plants.joints())?;
        }
        each_of(self.trackers, &(0..self.trackers.len()), |tracker| {
            same_joints("tracker", free(&tracker)?.trackers.joints(), N)
        })?;
        for (list, name) in [(self.q0, "q0"), (self.dq0, "dq0")] {
            each_of(list, &(0..list.len()), |start| joints::<N>(&start, name).map(drop))?;
        }
        Ok(())
    }
}

/// A tracker, unless it is in the middle of a step.
fn free<'py>(tracker: &Bound<'py, PyAny>) -> PyResult<PyRef<'py, PyController>> {
    Ok(object::<PyController>(tracker, "tracker", "a Controller")?.try_borrow()?)
}

/// The part of [`simulate_many`] that knows the joint count, told by the first tracker.
fn several<const N: usize>(
    py: Python<'_>,
    _: &Tracker<N>,
    lists: Lists<'_, '_>,
    numerics: Numerics,
    (record_every, window): (usize, Window),
    threads: usize,
    done: &mut Done,
) -> PyResult<()> {
    let rest = ([0.0; N], [0.0; N], Effects::default());
    let record = Record::Metrics(window);
    let options = Options { record_every, record, ..numerics.options(rest) };
    lists.check::<N>()?;
    let (runs, end) = (done.ended.len(), options.end());
    for first in (0..runs).step_by(READY) {
        let range = first..runs.min(first + READY);
        let ready = Ready::<N>::of(lists, &range)?;
        let mut raised = None;
        let ended = py.detach(|| {
            let all: Option<Vec<_>> = range.map(|run| ready.case(run - first)).collect();
            sim::simulate_many(&all.unwrap_or_default(), &options, threads, |count| {
                raised = done.look(first + count).err();
                if raised.is_some() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            })
        });
        for (run, ended) in (first..).zip(ended) {
            let Some(ended) = ended else { continue };
            let ended = ended.map_err(|error| {
                let of_one = runs > 1 && ["q0", "dq0"].contains(&error.parameter());
                let error = error.into();
                if of_one { of_run(py, &error, run) } else { error }
            })?;
            done.add(run, &ended, end);
        }
        // Once more after the last one, so that a bar gets to its end.
        let looked = raised.map_or_else(|| done.look(runs.min(first + READY)), Err);
        match looked {
            Err(error) if error.is_instance_of::<PyKeyboardInterrupt>(py) => return Ok(()),
            looked => looked?,
        }
    }
    Ok(())
}

/// Some of the runs, made ready. What is the same for all of them is here once.
struct Ready<const N: usize> {
    plants: Vec<Py<PyPlant>>,
    trackers: Vec<Tracker<N>>,
    references: Vec<Source<N>>,
    effects: Vec<Effects<N>>,
    q0: Vec<[f64; N]>,
    dq0: Vec<[f64; N]>,
}

impl<const N: usize> Ready<N> {
    fn of(lists: Lists<'_, '_>, range: &Range<usize>) -> PyResult<Self> {
        let plants = each_of(lists.plants, range, |plant| {
            Ok(object::<PyPlant>(&plant, "plant", "a Plant")?.clone().unbind())
        })?;
        let trackers = each_of(lists.trackers, range, |tracker| {
            let tracker = free(&tracker)?;
            let own = each!(&tracker.trackers, Trackers, it => of_joints::<Tracker<N>>(&**it));
            Ok(own.cloned())
        })?;
        let source = |it: Bound<'_, PyAny>| Source::reference(&it, "reference");
        let references = each_of(lists.references, range, source)?;
        let effects = each_of(lists.effects, range, |it| {
            PyEffects::of(Some(&it).filter(|it| !it.is_none()))
        })?;
        let q0 = each_of(lists.q0, range, |it| joints(&it, "q0"))?;
        let dq0 = each_of(lists.dq0, range, |it| joints(&it, "dq0"))?;
        let trackers = trackers.into_iter().flatten().collect();
        Ok(Self { plants, trackers, references, effects, q0, dq0 })
    }

    /// The run at a place among those that are ready.
    fn case(&self, place: usize) -> Option<Case<'_, N>> {
        let plants = &pick(&self.plants, place).get().plants;
        let tracker = pick(&self.trackers, place);
        Some(Case {
            plant: each!(plants, Plants, plant => of_joints::<Plant<N>>(&**plant))?,
            controller: &tracker.controller,
            state: &tracker.state,
            reference: pick(&self.references, place),
            q0: *pick(&self.q0, place),
            dq0: *pick(&self.dq0, place),
            effects: *pick(&self.effects, place),
        })
    }
}

/// What is made of the one entry of a list, or of those of these runs; an error says of which run.
fn each_of<'py, T>(
    list: &Bound<'py, PyList>,
    range: &Range<usize>,
    make: impl Fn(Bound<'py, PyAny>) -> PyResult<T>,
) -> PyResult<Vec<T>> {
    if list.len() == 1 {
        return Ok(vec![make(list.get_item(0)?)?]);
    }
    let made = |run| make(list.get_item(run)?).map_err(|error| of_run(list.py(), &error, run));
    range.clone().map(made).collect()
}

/// The same error, of this run.
fn of_run(py: Python<'_>, error: &PyErr, run: usize) -> PyErr {
    PyErr::from_type(error.get_type(py), format!("{} (run {run})", error.value(py)))
}

/// The one entry, or that at a place.
fn pick<T>(all: &[T], place: usize) -> &T {
    if let [one] = all { one } else { &all[place] }
}

/// The kind of a status, when it came \[s\], and the reason.
type Ended = (&'static str, f64, String);

/// What there is of the runs.
struct Done {
    joints: usize,
    metrics: Vec<Metrics>,
    ended: Vec<Option<Ended>>,
    progress: Py<PyAny>,
}

impl Done {
    fn new(runs: usize, joints: usize, progress: Py<PyAny>) -> Self {
        Self { joints, metrics: vec![NONE; runs * joints], ended: vec![None; runs], progress }
    }

    /// Shows progress, and looks for Ctrl-C.
    fn look(&self, ended: usize) -> PyResult<()> {
        Python::attach(|py| {
            self.progress.call1(py, (ended,))?;
            py.check_signals()
        })
    }

    fn add<const N: usize>(&mut self, index: usize, run: &Run<N>, duration: f64) {
        self.ended[index] = Some(status(run.status, ended(run.status, duration)));
        if let (Some(metrics), false) = (run.metrics, interrupted(run.status)) {
            self.metrics[index * N..(index + 1) * N].copy_from_slice(&metrics);
        }
    }

    /// The figures by name, (M, n) each.
    fn figures<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for (name, of) in FIGURES {
            let values = self.metrics.iter().map(of).collect();
            dict.set_item(name, Array::rows(values, self.joints))?;
        }
        Ok(dict)
    }
}

fn interrupted(status: Status) -> bool {
    matches!(status, Status::Interrupted { .. })
}

/// Those of a run that has none.
const NONE: Metrics = Metrics {
    rms_e: f64::NAN,
    max_abs_e: f64::NAN,
    itae: f64::NAN,
    settling_time: f64::NAN,
    rms_tau: f64::NAN,
    max_abs_tau: f64::NAN,
    torque_variation: f64::NAN,
};

type Figure = (&'static str, fn(&Metrics) -> f64);

const FIGURES: [Figure; 7] = [
    ("rms_e", |m| m.rms_e),
    ("max_abs_e", |m| m.max_abs_e),
    ("itae", |m| m.itae),
    ("settling_time", |m| m.settling_time),
    ("rms_tau", |m| m.rms_tau),
    ("max_abs_tau", |m| m.max_abs_tau),
    ("torque_variation", |m| m.torque_variation),
];

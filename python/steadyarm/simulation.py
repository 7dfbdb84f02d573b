"""Closed-loop simulation."""

from __future__ import annotations

import functools
import warnings
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from . import _core, _scene, _stopping
from ._progress import Progress
from .run import Run

Reference = _core.Curve | Callable[[float], tuple[ArrayLike, ArrayLike, ArrayLike]]

NOTED_ROWS = 257
"""Rows of a run at the most that stand for a reference that is a callable."""


class DesignWarning(UserWarning):
    """A choice does nothing, or ruins a run: `simulate` says so once, and ``run.notes`` has it."""


def simulate(
    plant: _core.Plant,
    tracker: _core.Controller | _core.Guard,
    reference: Reference,
    duration: float = 40.0,
    dt: float = 1e-3,
    method: Literal["rk4", "dp54"] = "rk4",
    *,
    control_period: float | None = None,
    q0: ArrayLike | None = None,
    dq0: ArrayLike | None = None,
    rtol: float = 1e-8,
    atol: float = 1e-10,
    record_every: int = 1,
    record: Literal["all", "motion"] = "all",
    effects: _core.Effects | None = None,
    progress: bool = False,
) -> Run:
    """Simulate the closed loop of plant, tracker and reference, and record it.

    The run starts from the tracker's present weights and leaves the tracker as it was; to go on
    with what was learnt, take ``run.tracker``. Rust works with the GIL released.
    Ctrl-C ends the run within 0.1 s and returns what there is, with ``run.status`` "interrupted"; a
    run that blows up ends the same way, "diverged". Choices that do nothing or ruin the run (a dead
    zone above the signal, centres off the path, an effort limit below gravity, …) are said once, in
    a `DesignWarning` and in ``run.notes``; `design` says them before.

    Parameters
    ----------
    plant: what is really there.
    tracker: the controller: a `ComputedTorque`, one of `laws`, or an object of your own with a
        method ``step(q, dq, q_d, dq_d, ddq_d, dt) -> tau``, which is copied deeply; or a `Guard`
        around one; the guard stays as it was too. A guard's run
        needs its ``control_period``, tells what it did in ``run.guard``, and
        cannot be replayed.
    reference: `Sines`, `Quintic`, `Table`, `Waypoints`, or a callable ``t -> (q_d, dq_d, ddq_d)``.
    duration: length [s], a whole number of ``dt``.
    dt: step of the integrator and spacing of the record [s].
    method: "rk4" (fixed step) or "dp54" (error control to ``rtol`` and ``atol``; ``dt`` then only
        spaces the record).
    control_period: None for a controller in continuous time, the paper's setting; otherwise the
        controller steps once every so many seconds (a whole number of ``dt``, at most 1 s) and its
        torque is held. A tracker with an ``effort_rate_limit`` needs one.
    q0, dq0: initial position [rad] and velocity [rad/s], zero by default.
    rtol, atol: tolerances of "dp54".
    record_every: record every so many steps only. A row takes 8 (12 n + 3) bytes and what the
        compensator adds, 8 (2 n + 1) of the motion alone; a record of more than 2 GiB is refused
        before the run, with its size.
    record: "all" signals, or only the "motion": t, q, dq. The set-points (q_d, dq_d, ddq_d) and
        errors (e, de) are then computed when one of them is first asked for: the reference is
        called again at the times of the rows. The arrays of the other signals are empty. It saves
        memory, and most of the time of a "dp54" run with many rows: they come from its dense
        output alone.
    effects: sensors, timing and actuators between controller and arm; see `Effects`. Needs a
        ``control_period``.
    progress: show a progress bar.

    Returns
    -------
    Run

    Raises
    ------
    ValueError, TypeError
        For an argument that makes no sense; the message names it.
    Exception
        Whatever a callable raises, with a note of when; its attribute ``run`` holds the run so far.
    """
    tracker = in_controller(plant, tracker, control_period)
    arguments = (plant, tracker, reference, duration, dt, method)
    numerics = (control_period, q0, dq0, rtol, atol, record_every)
    run_of = functools.partial(_core.simulate, *arguments, *numerics, record, effects)
    if progress:
        with Progress(float(duration), "s") as bar:
            columns, raised = run_of(bar.to)
            bar.to(columns["status"][1])
    else:
        columns, raised = run_of(_stopping.poll())
    options = (duration, dt, method, *numerics, record, effects)
    given = dict(zip(_scene.OPTIONS, options, strict=True))
    run = recorded(columns, plant, tracker, reference, given)
    if raised is not None:
        step = round(run.status.t / dt)
        raised.add_note(f"steadyarm: raised by a callable at t = {run.status.t:.6g} s, step {step}")
        raised.run = run  # type: ignore[attr-defined]
        raise raised
    if run.notes:
        warnings.warn("\n".join(run.notes), DesignWarning, stacklevel=2)
    return run


def replay(
    path: str | Path,
    *,
    reference: Reference | None = None,
    disturbance: Any = None,
    law: Any = None,
) -> Run:
    """Simulate the run in the file at ``path`` again: ``Run.load(path).replay(...)``."""
    return Run.load(path).replay(reference=reference, disturbance=disturbance, law=law)


def in_controller(plant: Any, tracker: Any, control_period: float | None) -> Any:
    """A tracker, or else an object with a method ``step``, in a controller for the plant's arm."""
    if isinstance(tracker, _core.Controller | _core.Guard) or not hasattr(tracker, "step"):
        return tracker
    arm: Any = getattr(plant, "arm", None)
    return _core.Controller(arm, tracker, control_period=control_period)


def recorded(
    record: dict[str, Any],
    plant: _core.Plant,
    tracker: _core.Controller | _core.Guard,
    reference: Reference,
    options: Mapping[str, Any],
) -> Run:
    """The run of a record, with its notes; ``options``: those of `_scene.OPTIONS`."""
    run = Run._from_record(record, plant, reference, options, _scene.own_law(tracker))
    notes = _notes(run, plant, tracker, reference, options["duration"], options["q0"])
    period, effects = options["control_period"], options["effects"]
    vars(run)["notes"] = (*notes, *_loop_notes(tracker, period, effects))
    return run


def _notes(
    run: Run,
    plant: _core.Plant,
    tracker: _core.Controller | _core.Guard,
    reference: Reference,
    duration: float,
    q0: ArrayLike | None,
) -> tuple[str, ...]:
    """What did nothing in a run, or ruined it.

    A callable is not called again: its rows are taken.
    """
    path: Any = reference
    if not isinstance(reference, _core.Curve):
        path = None
        if len(run.t) > 1 and len(run.tau) == len(run.t):
            rows = np.unique(np.linspace(0, len(run.t) - 1, NOTED_ROWS).astype(int))
            path = _core.Table(run.t[rows], run.q_d[rows], run.dq_d[rows], run.ddq_d[rows])
            duration = float(run.t[-1])
    try:
        notes = _core.choices(tracker, plant, path, duration, q0)
    except ValueError as error:  # of what no design was made for; the run is there all the same
        notes = [f"the design could not be judged: {error}"]
    if run.guard is not None and run.guard.stopped is not None:
        notes.append(f"guard: it stopped ({run.guard.stopped}), and braked the arm from there on")
    return tuple(notes)


def _loop_notes(
    tracker: _core.Controller | _core.Guard,
    control_period: float | None,
    effects: _core.Effects | None,
) -> list[str]:
    """What of a controller does not suit the loop that it was in."""
    if isinstance(tracker, _core.Guard):
        tracker = tracker.tracker
    notes, given = [], _scene.arguments(tracker)
    late = 0 if effects is None else effects.delay
    if control_period is not None and late != tracker.delay:
        notes.append(
            f"delay: the loop is late by {late} samples, and the controller believes "
            f"{tracker.delay}; tell it: delay={late}"
            + f", or simulate with effects=sa.Effects(delay={tracker.delay})"
            * (effects is None)
        )
    if effects is not None:
        made_of = _scene.arguments(effects)
        if made_of["velocity"] == "difference" and given["velocity_filter"] is None:
            cutoff = made_of["velocity_cutoff"]
            notes.append(
                f"velocity_filter: dq comes through a filter of {cutoff:g} Hz, and is compared "
                "with a dq_d that does not, so its lag reads as an error; "
                f"velocity_filter={cutoff:g} sends both through the same, and costs nothing"
            )
    # A law was made for the period that its tracker names, and is made anew for another.
    other = control_period not in (None, given.get("control_period"))
    if other and isinstance(given.get("law"), dict):
        try:
            tracker.__replace__(control_period=control_period)
        except ValueError as error:
            notes.append(f"control_period: this law would be refused for it ({error})")
    return notes

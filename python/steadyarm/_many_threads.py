"""`simulate_many` by threads over `_core.simulate`: where runs call Python, or are recorded."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import numpy as np

from . import _core
from ._stopping import poll, stopped_by
from .compare_runner import AMID, BEFORE, GRACE, WAIT, _words
from .metrics import NAMES
from .record import MOTION


def simulate_many(
    count: int,
    plants: list[Any],
    trackers: list[Any],
    references: list[Any],
    q0: list[Any],
    dq0: list[Any],
    effects: list[Any],
    duration: float,
    dt: float,
    method: str,
    control_period: float | None,
    rtol: float,
    atol: float,
    window: tuple[float, float],
    band: float,
    record: str | None,
    record_every: int,
    threads: int,
    progress: Callable[[int], object],
) -> dict[str, Any]:
    """Simulate all runs; lists have one entry for all, or one a run."""
    stop = threading.Event()
    lists = (plants, trackers, references, q0, dq0, effects)

    def run_of(index: int) -> tuple[Any, ...]:
        plant, tracker, reference, q, dq, effect = (
            it[0] if len(it) == 1 else it[index] for it in lists
        )
        options = (duration, dt, method, control_period, q, dq, rtol, atol, record_every, "all")
        return _run(plant, tracker, reference, options, effect, (window, band, record), stop)

    done: list[Any] = [None] * count
    begun = [False] * count
    _in_threads(run_of, done, begun, min(threads, count), progress, stop)
    wrong = next((it for it in done if isinstance(it, BaseException)), None)
    if wrong is not None:
        raise wrong
    joints = plants[0].arm.joints
    nothing = np.full(joints, np.nan)
    lost = [("interrupted", 0.0, AMID if it else BEFORE) for it in begun]
    runs: list[Any] = [it or (said, {}, None, None) for it, said in zip(done, lost, strict=True)]
    figures = {name: np.array([run[1].get(name, nothing) for run in runs]) for name in NAMES}
    return {
        "status": [run[0] for run in runs],
        "figures": figures,
        "records": [run[2] for run in runs],
        "raised": [run[3] for run in runs],
    }


def _in_threads(
    run_of: Callable[[int], Any],
    done: list[Any],
    begun: list[bool],
    threads: int,
    progress: Callable[[int], object],
    stop: threading.Event,
) -> None:
    """Fill ``done``, from Ctrl-C on no further."""
    indices, lock = iter(range(len(done))), threading.Lock()
    ended: queue.SimpleQueue[int] = queue.SimpleQueue()

    def work() -> None:
        while not stop.is_set():
            with lock:
                index = next(indices, None)
            if index is None:
                return
            begun[index] = True
            try:
                done[index] = run_of(index)
            except BaseException as error:
                done[index] = error
                stop.set()
            ended.put(index)

    workers = [threading.Thread(target=work) for _ in range(threads)]
    try:
        for worker in workers:
            worker.start()
        left = len(done)
        while left and not stop.is_set():
            with suppress(queue.Empty):
                ended.get(timeout=WAIT)
                left -= 1
            progress(len(done) - left)
    except KeyboardInterrupt:
        stop.set()
        for worker in workers:
            with suppress(RuntimeError):  # one that was not started yet
                worker.join(GRACE)
    finally:
        stop.set()


def _run(
    plant: Any,
    tracker: Any,
    reference: Any,
    options: tuple[Any, ...],
    effects: Any,
    asked: tuple[Any, ...],
    stop: threading.Event,
) -> tuple[Any, ...]:
    """Status, figures, record and what was raised of one run."""
    with stopped_by(stop):
        arguments: tuple[Any, ...] = (plant, tracker, reference, *options, effects, poll())
        found, raised = _core.simulate(*arguments)
    window, band, record = asked
    columns, status = found["columns"], found["status"]
    figures: Any = {}
    if raised is not None:
        status = ("raised", status[1], _words(raised))
    elif status[0] != "interrupted":
        e, t = columns["e"], columns["t"]
        with suppress(ValueError):
            figures = _core.metrics(t, e, columns["tau"], window, band)
    if record == "motion":
        found["own"] = []
        found["columns"] = {n: it if n in MOTION else None for n, it in columns.items()}
    return status, figures, None if record is None else found, raised

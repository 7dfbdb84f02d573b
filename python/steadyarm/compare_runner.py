"""Many runs at a time: jobs in threads, for the core computes without the GIL."""

from __future__ import annotations

import os
import queue
import sys
import threading
import time
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass

from ._documented import documented
from ._progress import Progress
from ._stopping import stopped_by
from .comparison import Row

BEFORE = "it was stopped from the keyboard before it began"
AMID = "it was stopped from the keyboard"

WAIT = 0.2
"""A wait is that long at the most, for some systems tell of Ctrl-C only between waits [s]."""

GRACE = 1.0
"""So long jobs that run have to end after Ctrl-C [s]; a simulation takes 0.1 s."""


@documented
@dataclass(frozen=True)
class Job:
    """A row that is still to be computed.

    It can be pickled if ``compute`` can, a function of a module or a ``functools.partial`` of one.
    """

    controller: str
    """What the controller is called."""
    scenario: str
    """What the scenario is called."""
    seed: int
    """Seed of all that is random in it."""
    compute: Callable[[], Row]
    """What returns the row."""

    def __post_init__(self) -> None:
        # A name that no row can have would be found out in a thread, and be waited for.
        self.failed("interrupted", BEFORE)

    def failed(self, status: str, reason: str) -> Row:
        """The row of a job that has none."""
        return Row(self.controller, self.scenario, self.seed, status, reason)


def run_all(
    jobs: Iterable[Job], workers: int | None = None, progress: bool | None = None
) -> list[Row]:
    """Compute the rows of all jobs, in the order of the jobs.

    A job that raises loses its own row: its status is "raised", with the exception as its reason.
    Ctrl-C keeps the rows that there are; the others are "interrupted". Simulations that run end
    within 0.1 s then, another job is no longer waited for after a second, and goes on until it ends
    by itself.

    Parameters
    ----------
    jobs: what is to be computed.
    workers: number of threads; as many as there are cores by default.
    progress: whether to show a bar; by default on a terminal.

    Raises
    ------
    ValueError
        If ``workers`` is less than 1.
    """
    jobs = list(jobs)
    workers = threads_of("workers", workers)
    if progress is None:
        progress = sys.stderr.isatty()
    pool = _Pool(jobs)
    try:
        with Progress(len(jobs), "runs", shown=progress) as bar:
            pool.start(min(workers, len(jobs)))
            while pool.left:
                pool.take()
                bar.to(len(jobs) - pool.left)
    except KeyboardInterrupt:
        pool.stop.set()
        pool.settle()
    finally:
        pool.stop.set()
    return [
        row or job.failed("interrupted", AMID if begun else BEFORE)
        for row, job, begun in zip(pool.rows, jobs, pool.begun, strict=True)
    ]


class _Pool:
    """Threads that compute jobs until there are none, or until ``stop`` is set."""

    def __init__(self, jobs: list[Job]) -> None:
        self.stop = threading.Event()
        self.rows: list[Row | None] = [None] * len(jobs)
        self.begun = [False] * len(jobs)
        self.left = len(jobs)
        self._jobs = jobs
        self._next = iter(range(len(jobs)))
        self._lock = threading.Lock()
        self._done: queue.SimpleQueue[None] = queue.SimpleQueue()
        self._threads: list[threading.Thread] = []

    def start(self, workers: int) -> None:
        """Start so many threads."""
        for _ in range(workers):
            self._threads.append(threading.Thread(target=self._work))
            self._threads[-1].start()

    def _work(self) -> None:
        while not self.stop.is_set():
            with self._lock:
                index = next(self._next, None)
            if index is None:
                return
            self.begun[index] = True
            self.rows[index] = _computed(self._jobs[index], self.stop)
            self._done.put(None)

    def take(self) -> None:
        """Wait for a row, but not for long."""
        with suppress(queue.Empty):
            self._done.get(timeout=WAIT)
            self.left -= 1

    def settle(self) -> None:
        """Wait for jobs that end soon. A second Ctrl-C ends the waiting."""
        end = time.monotonic() + GRACE
        with suppress(KeyboardInterrupt):
            for thread in self._threads:
                with suppress(RuntimeError):  # one that was not started yet
                    thread.join(max(0.0, end - time.monotonic()))


def _computed(job: Job, stop: threading.Event) -> Row:
    """The row of a job, whatever happens in it."""
    try:
        with stopped_by(stop):
            row = job.compute()
    except KeyboardInterrupt:
        return job.failed("interrupted", AMID)
    except BaseException as error:  # a thread that ended with one would leave the others waiting
        return job.failed("raised", _words(error))
    if not isinstance(row, Row):
        return job.failed("raised", f"the job returned {type(row).__name__}, wants a Row")
    return row


def _words(error: BaseException) -> str:
    """An exception in words that every file can hold."""
    try:
        said = str(error)
    except Exception as worse:  # the exception is the user's, and so is its text
        said = f"its message raised {type(worse).__name__}"
    notes = [note for note in getattr(error, "__notes__", ()) if isinstance(note, str)]
    words = ": ".join(part for part in (type(error).__name__, said) if part)
    return "; ".join([words, *notes]).encode(errors="backslashreplace").decode()


def threads_of(argument: str, asked: int | None) -> int:
    """How many threads are asked for; None: one for each core that this process may use."""
    if asked is None:
        if hasattr(os, "sched_getaffinity"):
            return len(os.sched_getaffinity(0))
        return os.cpu_count() or 1
    if isinstance(asked, bool) or not isinstance(asked, int) or asked < 1:
        raise ValueError(f"{argument}: got {asked!r}, wants a whole number >= 1")
    return asked

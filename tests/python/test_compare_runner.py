"""Many runs at a time: the order of rows, what a job loses, Ctrl-C."""

from __future__ import annotations

import functools
import os
import pickle
import signal
import subprocess
import sys
import threading
import time

import pytest
import steadyarm as sa
from steadyarm.compare_runner import Job, run_all
from steadyarm.comparison import Comparison, Row

PATIENCE = 60
"""Far more than a child needs to notice a signal [s]."""


def made(k: int) -> Row:
    return Row(f"c{k}", "s", k, rms_e=float(k))


def job(k: int, compute: object = None) -> Job:
    return Job(f"c{k}", "s", k, compute or functools.partial(made, k))  # type: ignore[arg-type]


def raising(error: BaseException) -> Row:
    raise error


@pytest.mark.parametrize("workers", [1, 2, 5, 64, None])
def test_rows_have_the_order_of_the_jobs_whatever_ends_first(workers: int | None) -> None:
    def slow(k: int) -> Row:
        time.sleep(0.01 * ((7 * k) % 12))
        return made(k)

    jobs = [job(k, functools.partial(slow, k)) for k in range(12)]
    assert run_all(jobs, workers=workers) == [made(k) for k in range(12)]


def test_jobs_run_at_the_same_time() -> None:
    meeting = threading.Barrier(3, timeout=PATIENCE)

    def meet(k: int) -> Row:
        meeting.wait()
        return made(k)

    rows = run_all([job(k, functools.partial(meet, k)) for k in range(3)], workers=3)
    assert [row.status for row in rows] == ["finished"] * 3


class Silent(Exception):
    def __str__(self) -> str:
        raise RuntimeError


def noted() -> BaseException:
    error = ValueError("k₂: got -1, wants > 0")
    error.add_note("at t = 3 s")
    return error


@pytest.mark.parametrize(
    ("error", "reason"),
    [
        (ValueError("gain: got nan"), "ValueError: gain: got nan"),
        (ZeroDivisionError(), "ZeroDivisionError"),
        (noted(), "ValueError: k₂: got -1, wants > 0; at t = 3 s"),
        (SystemExit(3), "SystemExit: 3"),
        (Silent(), "Silent: its message raised RuntimeError"),
        (OSError("\udcff"), "OSError: \\udcff"),
        (MemoryError("x" * 10_000), f"MemoryError: {'x' * 10_000}"),
    ],
    ids=lambda value: type(value).__name__,
)
def test_a_job_that_raises_in_row_7_of_12_loses_its_row_only(
    error: BaseException, reason: str
) -> None:
    jobs = [job(k) for k in range(12)]
    jobs[6] = job(6, functools.partial(raising, error))
    rows = run_all(jobs, workers=2)
    assert rows[6] == Row("c6", "s", 6, "raised", reason)
    assert [row for k, row in enumerate(rows) if k != 6] == [made(k) for k in range(12) if k != 6]
    assert "1/1" in str(Comparison(rows))


def test_a_controller_that_raises_in_a_simulation_is_told_with_its_time() -> None:
    scene = sa.paper.simulation(1)

    def reference(t: float) -> object:
        if t > 0.5:
            raise RuntimeError("no more")
        return scene.reference(t)

    def compute() -> Row:
        run = sa.simulate(scene.plant, scene.tracker, reference, 1.0)  # type: ignore[arg-type]
        return Row.of(run, controller="own")

    (row,) = run_all([job(0, compute)])
    assert row.status == "raised" and row.reason.startswith("RuntimeError: no more; steadyarm: ")
    assert "at t = 0.5" in row.reason


def test_a_job_that_returns_no_row_says_what_it_returned() -> None:
    rows = run_all([job(0, lambda: 3), job(1)])
    assert (rows[0].status, rows[0].reason) == ("raised", "the job returned int, wants a Row")
    assert rows[1] == made(1)


def test_rows_are_the_same_bits_with_any_number_of_workers() -> None:
    def compute(k: int) -> Row:
        scene = sa.paper.simulation(3, gain=5.0 + k)
        return Row.of(scene.run(duration=1.0), controller=f"c{k}", seed=k)

    jobs = [job(k, functools.partial(compute, k)) for k in range(6)]
    first, second = run_all(jobs, workers=1), run_all(jobs, workers=3)
    assert first == second
    for one, other in zip(first, second, strict=True):
        assert one.curves is not None and other.curves is not None
        assert one.curves.plain() == other.curves.plain()


def test_jobs_can_be_pickled() -> None:
    assert run_all([pickle.loads(pickle.dumps(job(3)))]) == [made(3)]


@pytest.mark.parametrize("workers", [0, -1, 1.5, True, "2"])
def test_workers_that_make_no_sense_are_refused(workers: object) -> None:
    with pytest.raises(ValueError, match=r"workers: got .*, wants a whole number >= 1"):
        run_all([job(0)], workers=workers)  # type: ignore[arg-type]


def test_no_jobs_are_no_rows() -> None:
    assert run_all([]) == []


def test_the_bar_counts_the_rows(capsys: pytest.CaptureFixture[str]) -> None:
    run_all([job(k) for k in range(4)], progress=True)
    assert "4 of 4 runs" in capsys.readouterr().err
    run_all([job(k) for k in range(4)])
    assert capsys.readouterr().err == ""


def test_keyboard_interrupt_of_a_callback_interrupts_its_job() -> None:
    rows = run_all([job(0, functools.partial(raising, KeyboardInterrupt())), job(1)])
    assert rows[0].status == "interrupted" and rows[1] == made(1)


START = """
import functools, sys, threading, time
import steadyarm as sa
from steadyarm.compare_runner import Job, run_all
from steadyarm.comparison import Row
scene = sa.paper.simulation(2)
started = threading.Barrier(2)
def short(k):
    return Row.of(scene.run(duration=0.1), controller=f"c{k}", scenario="s", seed=k)
def long(k):
    if started.wait() == 0:
        print("ready", flush=True)
    run = scene.run(duration=90000.0, record_every=1000)
    return Row.of(run, controller=f"c{k}", scenario="s", seed=k)
def stuck(k):
    if started.wait() == 0:
        print("ready", flush=True)
    time.sleep(2.5)
    return short(k)
kinds = [short, short, short, KIND, KIND, short, short]
jobs = [Job(f"c{k}", "s", k, functools.partial(kind, k)) for k, kind in enumerate(kinds)]
rows = run_all(jobs, workers=2, progress=PROGRESS)
end = time.monotonic()
for row in rows:
    print(row.controller, row.status, row.curves is not None, row.reason)
print("end", flush=True)
print(scene.run(duration=0.1).status)
"""


@pytest.mark.skipif(os.name != "posix", reason="signals are sent as on Unix")
@pytest.mark.parametrize("progress", [False, True])
@pytest.mark.parametrize("kind", ["long", "stuck"])
def test_interrupt_keeps_the_rows_that_there_are(kind: str, progress: bool) -> None:
    code = START.replace("KIND", kind).replace("PROGRESS", str(progress))
    with subprocess.Popen(
        [sys.executable, "-u", "-W", "error", "-c", code],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as child:
        assert child.stdout is not None and child.stderr is not None
        try:
            assert child.stdout.readline() == "ready\n"
            time.sleep(0.1)
            sent = time.monotonic()
            child.send_signal(signal.SIGINT)
            lines = []
            while not lines or lines[-1] != "end":
                lines.append(child.stdout.readline().rstrip("\n"))
                assert lines[-1], lines
            # Simulations look for a stop every 20 ms; the others have a second.
            assert time.monotonic() - sent < (1.0 if kind == "long" else 2.0)
            rest, errors = child.stdout.read(), child.stderr.read()
            child.wait(timeout=PATIENCE)
        finally:
            child.kill()
    assert child.returncode == 0 and rest == "finished\n", errors
    assert lines[:3] == [f"c{k} finished True " for k in range(3)]
    for k in (3, 4):
        assert lines[k].startswith(f"c{k} interrupted {kind == 'long'} ")
        assert lines[k].endswith("it was stopped from the keyboard")
    before = "interrupted False it was stopped from the keyboard before it began"
    assert lines[5:7] == [f"c{k} {before}" for k in (5, 6)]

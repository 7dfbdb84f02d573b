"""How many runs end, each alone, and how they are told in tables."""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import steadyarm as sa
from law_scenes import TWO, H, made
from many_scenes import alone, assert_same, bits, called, fuzzy, many, wild
from steadyarm._stopping import stopped_by
from steadyarm.metrics import NAMES
from test_own_controllers import Breaks, Springs

PATIENCE = 60
"""Far more than a child needs to notice a signal [s]."""


def test_a_run_that_diverges_ends_alone() -> None:
    trackers = [fuzzy(), wild(), fuzzy()]
    runs = many(tracker=trackers, duration=0.5, record="all")
    single = alone(tracker=wild(), duration=0.5)
    assert single.status.kind == "diverged" and 0 < single.status.t < 0.5
    assert_same(runs, [alone(duration=0.5), single, alone(duration=0.5)])
    assert runs.finished.tolist() == [True, False, True]
    assert runs[1].tau.tobytes() == single.tau.tobytes()
    late = many(tracker=trackers, duration=0.5, window=(0.4, 0.5))
    assert np.isnan(late.rms_e[1]).all() and np.isnan(late.max_abs_tau[1]).all()
    assert bits(late.metrics(2)) == bits(alone(duration=0.5).metrics((0.4, 0.5)))


def test_a_run_that_is_not_resolved_has_figures_and_is_not_finished() -> None:
    scene = sa.paper.simulation(2)
    runs = sa.simulate_many(scene.plant, scene.tracker, scene.reference, 40.0, 1.0)
    assert_same(runs, [scene.run(duration=40.0, dt=1.0)])
    assert runs.status[0].kind == "unresolved" and not runs.finished[0]


def test_a_callable_that_raises_loses_its_run_alone() -> None:
    def reference_of(limit: float) -> Callable[[float], Any]:
        def reference(t: float) -> Any:
            if t > limit:
                raise ZeroDivisionError("no more")
            return called(t)

        return reference

    references = [reference_of(1.0), reference_of(0.03), reference_of(1.0)]
    runs = many(reference=references, record="all")
    assert [it.kind for it in runs.status] == ["finished", "raised", "finished"]
    assert runs.status[1].reason == "ZeroDivisionError: no more"
    assert 0.02 < runs.status[1].t < 0.04
    assert all(np.isnan(getattr(runs, name)[1]).all() for name in NAMES)
    assert bits(runs.metrics(2)) == bits(alone(reference=called).metrics())
    assert runs[1].status == runs.status[1] and 20 < len(runs[1].t) < 40
    assert "raised at t = " in str(runs.status[1])


@pytest.mark.parametrize("error", [SystemExit(3), MemoryError()], ids=repr)
def test_whatever_a_controller_raises_is_its_reason(error: BaseException) -> None:
    runs = many(tracker=[Springs(), Breaks(5, error)])
    said = f"{type(error).__name__}: {error}".removesuffix(": ")
    assert [(it.kind, it.reason) for it in runs.status] == [("finished", ""), ("raised", said)]
    assert_same(many(tracker=[Springs()]), [alone(tracker=Springs())])


def test_keyboard_interrupt_of_a_callback_interrupts_its_run() -> None:
    runs = many(tracker=[Springs(), Breaks(5, KeyboardInterrupt())], record="all", threads=1)
    assert [it.kind for it in runs.status] == ["finished", "interrupted"]
    assert np.isnan(runs.rms_e[1]).all() and runs.status[1].t == pytest.approx(5 * H)
    assert runs[1].tau.tobytes() == alone(tracker=Breaks(5, KeyboardInterrupt())).tau.tobytes()


def test_a_job_that_is_stopped_interrupts_its_runs() -> None:
    stop = threading.Event()
    stop.set()
    with stopped_by(stop):
        runs = many(duration=9000.0, changes=[{}] * 20, threads=2, record="motion")
    assert {it.kind for it in runs.status} == {"interrupted"}
    before = "it was stopped from the keyboard before it began"
    assert (runs.status[-1].t, runs.status[-1].reason) == (0.0, before)
    with pytest.raises(ValueError, match=f"run 19: got no record of it, for {before}"):
        runs[19]


def some() -> sa.Runs:
    trackers = [fuzzy(), Breaks(5, RuntimeError("<no> more")), wild(), made("pid", TWO)]
    return many(tracker=trackers, duration=0.5, record="motion")


def test_the_table_has_a_row_a_run_in_columns() -> None:
    runs = some()
    table = runs.table()
    assert list(table)[:5] == ["status", "t_end", "reason", "rms_e_1", "rms_e_2"]
    assert len(table) == 3 + 2 * len(NAMES) and {it.shape for it in table.values()} == {(4,)}
    assert table["status"].tolist() == ["finished", "raised", "diverged", "finished"]
    assert table["reason"][1] == "RuntimeError: <no> more"
    assert table["t_end"].tolist() == [it.t for it in runs.status]
    for name in NAMES:
        for joint in (0, 1):
            assert table[f"{name}_{joint + 1}"].tobytes() == getattr(runs, name)[:, joint].tobytes()
    table["rms_e_1"][0] = 7.0
    assert runs.rms_e[0, 0] != 7.0


def test_pandas_has_the_same_table() -> None:
    pytest.importorskip("pandas")
    runs = some()
    frame, table = runs.to_pandas(), runs.table()
    assert list(frame.columns) == list(table) and frame.index.name == "run"
    assert (frame["itae_2"].to_numpy()[[0, 3]] == table["itae_2"][[0, 3]]).all()
    assert frame.attrs["units"]["itae_2"] == "rad·s²"


def test_printed_it_counts_the_ends_and_has_median_and_worst_of_what_finished() -> None:
    runs = some()
    lines = str(runs).splitlines()
    assert lines[0] == "4 runs of 2 joints: 2 finished, 1 raised, 1 diverged"
    assert repr(runs) == f"Runs({lines[0]})"
    finished = runs.rms_e[[0, 3]]
    said = [line.split()[-2:] for line in lines if line.split()[0] == "rms_e"]
    wanted = [[f"{x:.6g}" for x in row] for row in (finished.mean(axis=0), finished.max(axis=0))]
    assert said == wanted
    page = runs._repr_html_()
    assert "1 × raised: RuntimeError: &lt;no&gt; more" in page and "RMS error, worst" in page


def test_without_a_run_that_finished_it_prints_the_ends() -> None:
    runs = many(tracker=Breaks(0, RuntimeError("no")))
    assert str(runs) == "1 runs of 2 joints: 1 raised"
    assert "RuntimeError: no" in runs._repr_html_()


def test_runs_pickle_with_their_records() -> None:
    runs = some()
    twin = pickle.loads(pickle.dumps(runs))
    assert twin.status == runs.status and bits(twin.metrics(0)) == bits(runs.metrics(0))
    assert twin[0].q.tobytes() == runs[0].q.tobytes()


def test_the_bar_counts_the_runs(capsys: pytest.CaptureFixture[str]) -> None:
    many(changes=[{}] * 3, progress=True)
    assert "3 of 3 runs" in capsys.readouterr().err
    many(changes=[{}] * 3)
    assert capsys.readouterr().err == ""


START = """
import threading, time
import steadyarm as sa
scene = sa.paper.simulation(2)
def slow(t):
    if t > 0 and not told.is_set():
        told.set()
        print("ready", flush=True)
    time.sleep(PAUSE)
    return scene.reference(t)
told = threading.Event()
runs = sa.simulate_many(
    scene.plant, scene.tracker, REFERENCES, DURATION, threads=THREADS, record="motion",
    record_every=100, progress=True,
)
for n, status in enumerate(runs.status):
    print(status.kind, runs.rms_e[n, 0] > 0, runs.rms_e[n, 0] != runs.rms_e[n, 0], status.reason)
print(sum(run is not None for run in runs._records))
print(scene.run(duration=0.1).status)
"""


def stopped(**values: Any) -> list[str]:
    """What a child prints that is stopped from the keyboard while a slow run is on its way."""
    code = START
    for name, value in values.items():
        code = code.replace(name, str(value))
    with subprocess.Popen(
        [sys.executable, "-u", "-W", "error", "-c", code],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as child:
        assert child.stdout is not None
        try:
            assert child.stdout.readline() == "ready\n"
            child.send_signal(signal.SIGINT)
            out, errors = child.communicate(timeout=PATIENCE)
        finally:
            child.kill()
    assert child.returncode == 0, errors
    assert out.endswith("\nfinished\n")
    return out.splitlines()[:-1]


BEFORE = "interrupted False True it was stopped from the keyboard before it began"
AMID = BEFORE.removesuffix(" before it began")


@pytest.mark.skipif(os.name != "posix", reason="signals are sent as on Unix")
def test_interrupt_keeps_the_runs_that_are_finished() -> None:
    references = "[scene.reference, scene.reference, slow, scene.reference]"
    lines = stopped(REFERENCES=references, DURATION=0.2, PAUSE=0.2, THREADS=1)
    assert lines == ["finished True False "] * 2 + [AMID, BEFORE, "3"]


@pytest.mark.skipif(os.name != "posix", reason="signals are sent as on Unix")
def test_interrupt_ends_all_runs_that_are_on_their_way() -> None:
    references = "[slow, scene.reference, scene.reference, scene.reference]"
    lines = stopped(REFERENCES=references, DURATION=90000.0, PAUSE=0.0, THREADS=2)
    amid = lines.count(AMID)
    assert 1 <= amid <= 2, "the second thread may not have begun"
    assert lines == [AMID] * amid + [BEFORE] * (4 - amid) + [str(amid)]

"""Ctrl-C ends a run, and what there is comes back."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

PATIENCE = 300
"""Far more than a run needs to notice a signal [s]."""

START = """
import sys, threading
import numpy as np
import steadyarm as sa
scene = sa.paper.simulation(3, preset="claimed")
zero = np.zeros(2)
def ready():
    print("ready", flush=True)
def callback(t):
    return scene.reference(t)
def disturbance(q, dq, t):
    return zero
disturbed = sa.Plant(sa.paper.actual(), disturbance)
"""

REPORT = """
print(run.status.kind, 0 < run.status.t < 90000, len(run.t) > 1, str(run.status))
arrays = [getattr(run, name) for name in ("t", "q", "dq", "tau", "weights", "V")]
print(all(np.isfinite(array).all() for array in arrays if array is not None))
again = sa.simulate(scene.plant, scene.tracker, scene.reference, 0.01)
print(again.status.kind)
"""

RUNS = {
    "continuous": "scene.plant, scene.tracker, scene.reference, 90000.0",
    "error control": "scene.plant, scene.tracker, scene.reference, 90000.0, method='dp54'",
    "sampled": "scene.plant, scene.tracker, scene.reference, 90000.0, control_period=1e-3",
    "reference callback": "scene.plant, scene.tracker, callback, 90000.0",
    "disturbance callback": "disturbed, scene.tracker, scene.reference, 90000.0",
}


@pytest.mark.skipif(os.name != "posix", reason="signals are sent as on Unix")
@pytest.mark.parametrize("name", RUNS)
def test_interrupted_run_returns_what_there_is(name: str) -> None:
    # The progress bar shows that the run is on its way: it is drawn from inside the loop.
    call = f"sa.simulate({RUNS[name]}, record_every=1000, progress=True)"
    code = f"{START}\nready()\nrun = {call}\n{REPORT}"
    child = subprocess.Popen(
        [sys.executable, "-u", "-c", code],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=os.environ | {"PYTHONWARNINGS": "error"},
    )
    try:
        assert child.stdout is not None
        assert child.stderr is not None
        assert child.stdout.readline() == b"ready\n"
        seen = b""
        while not any(digit in seen.split(b" of 90000")[0][-12:] for digit in b"123456789"):
            chunk = os.read(child.stderr.fileno(), 4096)
            assert chunk, seen
            seen = seen[-100:] + chunk if b" of 90000" not in chunk else chunk
        child.send_signal(signal.SIGINT)
        out, err = child.communicate(timeout=PATIENCE)
    finally:
        child.kill()
        child.wait()
    lines = out.decode().splitlines()
    assert child.returncode == 0, err.decode()[-2000:]
    assert lines[0].startswith("interrupted True True interrupted at t = ")
    assert lines[0].endswith("because it was stopped from the keyboard")
    assert lines[1:] == ["True", "finished"]


def test_keyboard_interrupt_from_a_callback_ends_the_run_the_same_way(tmp_path: Path) -> None:
    import numpy as np
    import steadyarm as sa

    scene = sa.paper.simulation(3)

    def reference(t: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        if t > 0.05:
            raise KeyboardInterrupt
        return scene.reference(t)

    for options in ({}, {"method": "dp54"}, {"control_period": 1e-3}):
        run = sa.simulate(scene.plant, scene.tracker, reference, 1.0, **options)
        assert run.status.kind == "interrupted"
        assert run.status.t <= 0.06
        assert len(run.t) > 1
        run.save(tmp_path / "run.npz")
        assert sa.Run.load(tmp_path / "run.npz").status == run.status

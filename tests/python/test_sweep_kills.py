"""Workers and clients of a sweep are killed at random moments, and no row is lost, none twice.

``STEADYARM_KILLS=20`` kills so often, and adds Ray: ``make sweep-kills``.
"""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack, contextmanager, suppress
from multiprocessing import get_context
from pathlib import Path

import pyarrow.parquet
import pytest
import steadyarm as sa
import sweep_jobs
from steadyarm import _sweep_loop

psutil = pytest.importorskip("psutil")
pytestmark = pytest.mark.skipif(os.name != "posix", reason="processes are killed as on Unix")

HERE = Path(__file__).parent
KILLS = int(os.environ.get("STEADYARM_KILLS", "2"))
ROWS = 60 * (KILLS + 1)
"""Of a fiftieth of a second each."""

LATEST = 0.3
"""A kill comes so long after the last row at the most [s]."""

PATIENCE = 90.0
"""So long anything may take before a test gives up [s]."""

EXECUTORS = ["processes", "dask", *["ray"] * ("STEADYARM_KILLS" in os.environ)]

WORKERS = {
    "processes": "from multiprocessing.spawn import spawn_main",
    "dask": "from multiprocessing.spawn import spawn_main",
    "ray": "ray::computed",
}
"""What a part of the command line of a worker begins with."""


def waited(until: Callable[[], object]) -> None:
    """Wait for something."""
    end = time.monotonic() + PATIENCE
    while not until():
        assert time.monotonic() < end, "it took too long"
        time.sleep(0.02)


@contextmanager
def started(*command: object, **options: object) -> Iterator[subprocess.Popen[str]]:
    """A process of Python, ended with all that it started."""
    paths = os.pathsep.join([str(HERE), *filter(None, [os.environ.get("PYTHONPATH")])])
    child = subprocess.Popen(
        [sys.executable, *map(str, command)],
        env={**os.environ, "PYTHONPATH": paths},
        text=True,
        **options,  # type: ignore[call-overload]
    )
    try:
        yield child
    finally:
        with suppress(psutil.NoSuchProcess):
            for each in psutil.Process(child.pid).children(recursive=True):
                with suppress(psutil.NoSuchProcess):
                    each.kill()
        child.kill()
        child.wait()


@pytest.fixture(scope="module")
def dask(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[str, int]]:
    """A scheduler and two workers, each a process of its own: the address, and who has workers."""
    pytest.importorskip("distributed")
    folder = tmp_path_factory.mktemp("dask")
    file = folder / "scheduler.json"
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "cwd": folder}
    with ExitStack() as stack:

        def start(*command: object) -> int:
            module = ("-m", "dask", *command, "--scheduler-file", file)
            return stack.enter_context(started(*module, **quiet)).pid

        start("scheduler", "--port", "0", "--no-dashboard", "--host", "127.0.0.1")
        waited(lambda: file.exists() and file.stat().st_size)
        address = json.loads(file.read_text(encoding="utf-8"))["address"]
        # A nanny starts a worker again that was killed.
        nanny = start("worker", "--nworkers", "2", "--nthreads", "1", "--no-dashboard")
        yield f"dask://{address.removeprefix('tcp://')}", nanny


def workers(name: str, above: int) -> list[psutil.Process]:
    """The processes that compute, below one that started them."""
    found = []
    with suppress(psutil.NoSuchProcess):
        for each in psutil.Process(above).children(recursive=True):
            with suppress(psutil.NoSuchProcess):
                if any(part.startswith(WORKERS[name]) for part in each.cmdline()):
                    found.append(each)
    return found


def files(folder: Path) -> set[str]:
    return {file.name for file in folder.glob("rows-*.parquet")}


def check(folder: Path) -> None:
    """Every row is there, once, and right."""
    tables = [pyarrow.parquet.read_table(file) for file in folder.glob("rows-*.parquet")]
    assert sorted(row for table in tables for row in table["index"].to_pylist()) == [*range(ROWS)]
    columns = sa.Sweep.read(folder).table()
    assert (columns["square"] == columns["number"] ** 2.0).all()
    assert set(columns["status"]) == {"finished"}


def kill_after_rows(child: subprocess.Popen[str], folder: Path, kill: Callable[[], None]) -> bool:
    """Kill at a random moment after further rows came; whether the client was still at work."""
    before = files(folder)
    waited(lambda: files(folder) - before or child.poll() is not None)
    time.sleep(random.uniform(0.0, LATEST))
    if child.poll() is not None:
        return False
    kill()
    return True


@pytest.mark.parametrize("name", EXECUTORS)
def test_killed_workers_lose_no_row(
    name: str, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    executor, above = request.getfixturevalue("dask") if name == "dask" else (name, None)
    with started(HERE / "sweep_client.py", executor, tmp_path, ROWS) as child:

        def kill() -> None:
            some = workers(name, above or child.pid)
            with suppress(psutil.NoSuchProcess, IndexError):
                random.choice(some).kill()
                killed.append(some)

        killed: list[object] = []
        while len(killed) < KILLS and kill_after_rows(child, tmp_path, kill):
            pass
        assert child.wait(PATIENCE) == 0
    assert len(killed) == KILLS, "it was done too soon"
    check(tmp_path)


@pytest.mark.parametrize("name", EXECUTORS)
def test_killed_clients_lose_no_row_that_was_written(
    name: str, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    executor, _ = request.getfixturevalue("dask") if name == "dask" else (name, None)
    command = (HERE / "sweep_client.py", executor, tmp_path, ROWS)
    for _ in range(KILLS):
        with started(*command) as child:

            def kill(child: subprocess.Popen[str] = child) -> None:
                own = workers(name, child.pid)
                child.send_signal(signal.SIGKILL)
                child.wait()
                if name == "processes":  # nobody is left behind
                    psutil.wait_procs(own, timeout=PATIENCE)
                    assert not [it for it in own if it.is_running()]

            there = files(tmp_path)
            assert kill_after_rows(child, tmp_path, kill), "it was done too soon"
            assert there < files(tmp_path)
    with started(*command) as child:
        assert child.wait(PATIENCE) == 0
    check(tmp_path)


def test_a_row_that_kills_its_workers_costs_itself_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(_sweep_loop, "LOSSES", 3)
    given = {"executor": "processes", "chunk_seconds": 1e-9, "out": tmp_path}
    with pytest.raises(RuntimeError, match=r"1 rows are missing \(row 25 is the first\)"):
        sa.sweep(sweep_jobs.fatal, {"number": range(30)}, **given)
    assert sa.Sweep.read(tmp_path).table()["number"].tolist() == [*range(25), *range(26, 30)]


def test_a_broken_pool_keeps_what_is_written(tmp_path: Path) -> None:
    with ProcessPoolExecutor(2, get_context("spawn")) as pool:
        given = {"executor": pool, "chunk_seconds": 1e-9, "out": tmp_path}
        with pytest.raises(RuntimeError, match=r"executor: it broke .* call again"):
            sa.sweep(sweep_jobs.fatal, {"number": range(40)}, **given)
    assert 0 < len(sa.Sweep.read(tmp_path)) < 40


def test_the_table_is_the_same_from_clusters(
    dask: tuple[str, int], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    over = {"scale": [1.0, 1.5, 2.0], "kp": [8.0, 16.0]}
    wanted = sa.sweep(sweep_jobs.arguments, over, seeds=3, out=tmp_path / "here").table()
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(filter(None, sys.path)))  # for Ray's workers
    for executor in (dask[0], *["ray"] * ("ray" in EXECUTORS)):
        out = tmp_path / executor.partition(":")[0]
        chunks = {"executor": executor, "chunk_seconds": 0.01}
        found = sa.sweep(sweep_jobs.arguments, over, seeds=3, out=out, **chunks).table()
        assert found.keys() == wanted.keys()
        assert all(found[name].tobytes() == wanted[name].tobytes() for name in wanted), executor

"""The command line among pipes, closed streams, full disks and Ctrl-C: exit codes and messages."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import steadyarm as sa

pytestmark = pytest.mark.skipif(os.name != "posix", reason="needs a shell, pipes and signals")

COMMAND = f"{sys.executable} -m steadyarm"
SHORT = "simulate --duration 0.1"

FINISHED, FAILED, USAGE, STOPPED = 0, 1, 2, 130


def shell(line: str, folder: Path) -> tuple[int, str, str]:
    """Exit code of the command, what came out of the line, and its errors."""
    script = f"{line.replace('steadyarm', COMMAND)}"
    done = subprocess.run(
        ["bash", "-c", script], capture_output=True, encoding="utf-8", cwd=folder, check=False
    )
    assert "Traceback" not in done.stderr
    assert "Exception ignored" not in done.stderr
    return done.returncode, done.stdout, done.stderr


@pytest.mark.parametrize("closed", [">&-", "2>&-", "<&- >&- 2>&-"])
@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        (f"{SHORT} --save run.npz --plot run.png", FINISHED),
        ("simulate --form concat --raw --gain 70 --control-period 0.04", FAILED),
        ("simulate --gain x", USAGE),
        ("--help", FINISHED),
        ("", USAGE),
    ],
)
def test_closed_stream_changes_no_exit_code(
    closed: str, arguments: str, code: int, tmp_path: Path
) -> None:
    got, out, err = shell(f"steadyarm {arguments} {closed}", tmp_path)
    assert got == code, err
    if ">&-" not in closed.split():
        assert out or code == USAGE
    if "--save" in arguments:
        assert sa.Run.load(tmp_path / "run.npz").status.finished
        assert sorted(os.listdir(tmp_path)) == ["run.npz", "run.png"]


@pytest.mark.parametrize("reader", ["head -n 1", "true"])
@pytest.mark.parametrize(
    "arguments", [f"{SHORT} --save out.npz", "approximate --out out.png", "design", "--help"]
)
def test_reader_that_has_enough_is_no_failure(reader: str, arguments: str, tmp_path: Path) -> None:
    line = f"steadyarm {arguments} | {reader}; exit ${{PIPESTATUS[0]}}"
    code, _, err = shell(line, tmp_path)
    assert (code, err) == (FINISHED, "")
    files = [part for part in arguments.split() if part.startswith("out.")]
    assert os.listdir(tmp_path) == files  # they are written all the same


@pytest.mark.skipif(sys.platform != "linux", reason="needs /dev/full")
@pytest.mark.parametrize("arguments", [SHORT, "--help", "approximate", "--version"])
def test_output_that_cannot_be_written_is_one_line(arguments: str, tmp_path: Path) -> None:
    code, _, err = shell(f"steadyarm {arguments} > /dev/full", tmp_path)
    assert (code, err) == (FAILED, "steadyarm: cannot write the output: No space left on device\n")


@pytest.mark.parametrize(
    ("arguments", "last"),
    [
        ("simulate --gain x", "steadyarm: argument --gain: got 'x', wants a number"),
        ("simulate --bogus", "steadyarm: unrecognized arguments: --bogus"),
        ("simulate --gain", "steadyarm: argument --gain: expected one argument"),
        ("simulate --gain -1", "steadyarm: gain[0]: got -1, wants a number > 0"),
        ("simulat", "steadyarm: argument <command>: invalid choice: 'simulat' (choose from"),
        (
            "simulate --save run.csv",
            "steadyarm: argument --save: got 'run.csv', wants a name that ends in .npz",
        ),
        (
            "simulate --raw --normalized",
            "steadyarm: argument --normalized: not allowed with argument --raw",
        ),
    ],
)
def test_what_is_wrong_with_the_arguments_is_the_last_of_two_lines(
    arguments: str, last: str, tmp_path: Path
) -> None:
    code, out, err = shell(f"steadyarm {arguments}", tmp_path)
    assert (code, out) == (USAGE, "")
    lines = err.splitlines()
    assert lines[-1].startswith(last)
    assert len(lines) <= 2
    assert all("--help explains" in line for line in lines[:-1])


@pytest.mark.parametrize("option", ["--save", "--plot"])
@pytest.mark.parametrize("place", ["missing", "file", "folder", "circle", "/proc", "long"])
def test_file_that_cannot_be_written_is_found_before_the_run(
    option: str, place: str, tmp_path: Path
) -> None:
    ending = {"--save": ".npz", "--plot": ".png"}[option]
    (tmp_path / "file").touch()
    (tmp_path / f"folder{ending}").mkdir()
    (tmp_path / f"circle{ending}").symlink_to(f"circle{ending}")
    path = {
        "missing": f"missing/run{ending}",
        "file": f"file/run{ending}",
        "folder": f"folder{ending}",
        "circle": f"circle{ending}",
        "/proc": f"/proc/run{ending}",
        "long": "x" * 300 + ending,
    }[place]
    # Such a run takes days.
    code, out, err = shell(f"steadyarm simulate --duration 1e4 --dt 1e-4 {option} {path}", tmp_path)
    assert (code, out) == (FAILED, "")
    assert err.startswith("steadyarm: cannot write ")
    assert err.count("\n") == 1
    assert sorted(os.listdir(tmp_path)) == [f"circle{ending}", "file", f"folder{ending}"]


def test_check_before_the_run_leaves_the_file_as_it_is(tmp_path: Path) -> None:
    (tmp_path / "run.npz").write_bytes(b"old")
    code, _, _ = shell("steadyarm simulate --gain -1 --save run.npz", tmp_path)
    assert code == USAGE
    assert (tmp_path / "run.npz").read_bytes() == b"old"
    assert os.listdir(tmp_path) == ["run.npz"]


def test_run_that_ends_at_once_says_so(tmp_path: Path) -> None:
    line = "steadyarm simulate --kp 1e308 --save run.npz --plot run.png"
    code, out, err = shell(line, tmp_path)
    assert code == FAILED
    assert "diverged at t = 0 s" in out
    assert err == "steadyarm: nothing was recorded, and nothing is written\n"
    assert os.listdir(tmp_path) == []


def test_rows_are_thinned_as_in_python(tmp_path: Path) -> None:
    code, _, err = shell(f"steadyarm {SHORT} --record-every 7 --save run.npz", tmp_path)
    assert (code, err) == (FINISHED, "")
    expected = sa.paper.simulation(3, duration=0.1).run(record_every=7)
    assert np.array_equal(sa.Run.load(tmp_path / "run.npz").q, expected.q)


def interrupted(arguments: str, folder: Path, busy: Callable[[], bool]) -> tuple[int, str]:
    """Exit code and errors of a command that gets Ctrl-C once it is ``busy``."""
    child = subprocess.Popen(
        [sys.executable, "-m", "steadyarm", *arguments.split()],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        cwd=folder,
        text=True,
    )
    try:
        while not busy():
            assert child.poll() is None, child.communicate()
            time.sleep(0.001)
        time.sleep(0.2)
        child.send_signal(signal.SIGINT)
        _, err = child.communicate(timeout=120)
    finally:
        child.kill()
        child.wait()
    return child.returncode, err


@pytest.mark.parametrize("old", [None, b"old"])
def test_ctrl_c_while_a_run_is_saved_keeps_the_old_file(old: bytes | None, tmp_path: Path) -> None:
    record, picture = tmp_path / "run.npz", tmp_path / "run.png"
    if old is not None:
        record.write_bytes(old)
    # The record is written after the picture, and takes seconds.
    arguments = "simulate --duration 200 --plot run.png --save run.npz"
    code, err = interrupted(
        arguments, tmp_path, lambda: picture.exists() and any(tmp_path.glob(".*.npz"))
    )
    assert (code, err) == (STOPPED, "steadyarm: stopped; run.npz was not written; kept: run.png\n")
    kept = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    assert kept.pop("run.png").startswith(b"\x89PNG")
    assert kept == ({} if old is None else {"run.npz": old})


def test_ctrl_c_while_nobody_reads_a_pipe_is_answered(tmp_path: Path) -> None:
    pipe, record = tmp_path / "pipe.png", tmp_path / "run.npz"
    os.mkfifo(pipe)
    arguments = f"{SHORT} --plot pipe.png --save run.npz"
    started = time.monotonic()
    code, err = interrupted(arguments, tmp_path, lambda: time.monotonic() > started + 4.0)
    assert (code, err) == (STOPPED, "steadyarm: stopped; pipe.png was not written\n")
    assert not record.exists()
    assert os.listdir(tmp_path) == ["pipe.png"]

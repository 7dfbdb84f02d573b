"""The example that tunes two ends at once, where Optuna is installed."""

import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLE = Path(__file__).parents[2] / "examples/tune_optuna.py"


def test_it_prints_the_front_and_draws_it(tmp_path: Path) -> None:
    pytest.importorskip("optuna")
    picture = tmp_path / "front.svg"
    command = [sys.executable, EXAMPLE, "--trials", "6", "--out", picture]
    done = subprocess.run(command, capture_output=True, check=True, text=True, encoding="utf-8")
    lines = done.stdout.splitlines()
    assert any(line.startswith("recommended ") for line in lines)
    assert any(line.startswith("kp ") for line in lines)
    assert lines[-1].endswith(f"of 6 trials finished; {picture} shows them")
    assert "torque variation [N·m/s]" in picture.read_text(encoding="utf-8")

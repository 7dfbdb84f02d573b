"""What the README shows, runs; links are in test_docs."""

import re
from pathlib import Path

import numpy as np
import steadyarm as sa

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "README.md").read_text(encoding="utf-8")
CODE = re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL)


def error(run: sa.Run) -> float:
    """RMS of |e| over the last 2 s [mrad]."""
    return 1e3 * float(np.linalg.norm(run.metrics(window=(8, 10)).rms_e))


def test_example_of_8_lines_tracks_as_the_text_says() -> None:
    (code,) = CODE
    assert len([line for line in code.splitlines() if line.strip()]) <= 8
    names: dict[str, object] = {}
    exec(compile(code, "README.md", "exec"), names)
    run, arm, path = names["run"], names["arm"], names["path"]
    assert isinstance(run, sa.Run) and isinstance(arm, sa.Serial) and isinstance(path, sa.Quintic)
    plain = sa.ComputedTorque(arm.without_friction(), kp=400, kv=40)
    plant = sa.Plant(arm.with_payload(2.0))
    without = sa.simulate(plant, plain, path, 10.0, q0=path(0.0)[0])
    found = re.search(r"(\d+) mrad without `compensator=`, ([\d.]+) mrad with it", TEXT)
    assert found
    assert f"{error(without):.0f}" == found[1]
    assert f"{error(run):.1f}" == found[2]


def test_it_is_short_and_names_the_command_that_tests() -> None:
    assert len(TEXT.splitlines()) <= 110
    assert "make test" in (ROOT / ".ci/run").read_text(encoding="utf-8")
    assert re.search(r"^make test\b", TEXT, re.MULTILINE)

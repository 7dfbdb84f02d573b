"""What the README shows, runs; links are in test_docs."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import steadyarm as sa
from steadyarm._comparison_words import rounded

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "README.md").read_text(encoding="utf-8")
CODE = re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL)


def error(run: sa.Run) -> float:
    """RMS of |e| over the last 2 s [mrad]."""
    return 1e3 * float(np.linalg.norm(run.metrics(window=(8, 10)).rms_e))


def test_example_of_9_lines_tracks_as_the_text_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (code,) = CODE
    assert len([line for line in code.splitlines() if line.strip()]) <= 9
    names: dict[str, object] = {}
    exec(compile(code, "README.md", "exec"), names)
    assert "<html" in (tmp_path / "run.html").read_text(encoding="utf-8")
    run, arm, path = names["run"], names["arm"], names["path"]
    assert isinstance(run, sa.Run) and isinstance(arm, sa.Serial) and isinstance(path, sa.Quintic)
    plain = sa.laws.computed_torque(
        arm.without_friction(), bandwidth=20.0, velocity_filter=100.0, delay=1
    )
    loop: dict[str, Any] = names["loop"]  # type: ignore[assignment]
    without = sa.simulate(sa.Plant(arm.with_payload(2.0)), plain, path, 10.0, **loop)
    found = re.search(r"(\d+) mrad with computed torque, ([\d.]+) mrad with it", TEXT)
    assert found
    assert f"{error(without):.0f}" == found[1]
    assert f"{error(run):.3f}" == found[2]
    load = sa.learned(run.tracker).payload
    assert f"a load of {load:.2f} kg" in TEXT


RIVALS = {
    "**recommended**": "recommended",
    "computed torque": "computed_torque",
    "**the paper's compensator, as printed**": "fuzzy_printed",
    "the same, as claimed (another gain, raw strengths)": "fuzzy_claimed",
    "PD, which needs no model here": "pd",
    "disturbance observer": "disturbance_observer",
    "momentum observer": "momentum_observer",
    "sliding mode (the paper's ref. 2)": "sliding_mode",
    "Slotine and Li": "slotine_li",
    "PID": "pid",
    "super-twisting": "super_twisting",
}
"""Rows of the table, and the controllers of the scenarios that they are."""


def test_the_table_of_rivals_is_what_the_scenario_gives() -> None:
    lines = sa.compare("paper_sensors", only=list(RIVALS.values())).table()
    shown = {}
    for line in lines:
        figures = [1e3 * line.median["steady_rms_e"], line.median["max_abs_tau"]]
        cells = [f"{rounded(figures[0])} mrad", f"{rounded(figures[1])} N·m"]
        cells += [f"{rounded(line.median['torque_variation'])} N·m/s"]
        frozen = line.median["frozen_rms_e"]
        shown[line.controller] = [*cells, "" if frozen is None else f"{rounded(1e3 * frozen)} mrad"]
    rows = re.findall(
        r"^\| (.+) \| (.+ mrad) \| (.+ N·m) \| (.+ N·m/s) \|(.*)\|$", TEXT, re.MULTILINE
    )
    assert [row[0] for row in rows] == list(RIVALS)
    for name, *cells in rows:
        assert [cell.strip() for cell in cells] == shown[RIVALS[name]], name


def test_what_the_text_says_of_rivals_is_what_ideal_sensors_give() -> None:
    lines = sa.compare("paper_rivals", only=["pd", "fuzzy_printed", "pid"], freeze=False).table()
    row = {line.controller: line.median for line in lines}
    text = " ".join(TEXT.split())
    error = {name: rounded(1e3 * median["steady_rms_e"]) for name, median in row.items()}
    peak = {name: rounded(median["max_abs_tau"]) for name, median in row.items()}
    assert f"{error['pd']} mrad against {error['fuzzy_printed']}" in text
    assert f"at {peak['pd']} N·m against {peak['fuzzy_printed']}" in text
    assert f"(the PID {peak['pid']} N·m)" in text


def test_it_is_short_and_names_the_command_that_tests() -> None:
    assert len([line for line in TEXT.splitlines() if "]: https://" not in line]) <= 110
    assert "make test" in (ROOT / ".ci/run").read_text(encoding="utf-8")
    assert re.search(r"^make test\b", TEXT, re.MULTILINE)

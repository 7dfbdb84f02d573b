"""Scenarios on the command line: exit codes, and what is printed and written."""

from __future__ import annotations

import json
import os
import re
import runpy
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import steadyarm as sa
from scenario_files import text
from steadyarm import comparison
from steadyarm.bench import scenario_names
from steadyarm.cli import main

EXAMPLES = Path(__file__).parents[2] / "examples"
SCENE = {
    "title": "Short",
    "two_link": {"mass": 4.0, "length": 0.5, "inertia": 0.2},
    "actual": {"inertia_scale": 2.0},
    "reference": {"sines": {"frequency": 2.0, "sin": [0.3, 0.2]}},
    "effects": {"noise": 1e-5},
    "run": {"duration": 0.2, "control_period": 0.001},
    "controllers": {
        "plain": {"law": "computed_torque", "bandwidth": 10.0},
        "pid": {"law": "pid", "bandwidth": 10.0},
        "too_fast": {"law": "pid", "bandwidth": 4000.0},
    },
}


@pytest.fixture
def file(tmp_path: Path) -> str:
    (tmp_path / "short.toml").write_text(text(SCENE), encoding="utf-8")
    return str(tmp_path / "short.toml")


Out = pytest.CaptureFixture[str]


def test_run_runs_one_controller(file: str, tmp_path: Path, capsys: Out) -> None:
    plot, save = tmp_path / "run.png", tmp_path / "run.npz"
    options = ["--controller", "pid", "--seed", "3", "--plot", str(plot), "--save", str(save)]
    assert main(["run", file, *options]) == 0
    out = capsys.readouterr().out
    assert "Short" in out and "controller  pid" in out and "status      finished" in out
    assert plot.stat().st_size > 10_000 and str(plot) in out and str(save) in out
    run = sa.Run.load(save)
    assert (run.q == sa.Scenario.read(file).simulate("pid", seed=3).q).all()
    assert main(["run", file]) == 0
    assert "controller  pid" in capsys.readouterr().out, "the first by name"


def test_run_says_why_the_error_is_what_it_is(file: str, tmp_path: Path, capsys: Out) -> None:
    picture = tmp_path / "why.png"
    assert main(["run", file, "--controller", "plain", "--why", "--why-plot", str(picture)]) == 0
    out = capsys.readouterr().out
    run = sa.Scenario.read(file).simulate("plain")
    # The steady figures are of the second half.
    assert str(sa.attribution(run, window=(0.1, 0.2))) in out
    assert picture.stat().st_size > 10_000 and str(picture) in out


def test_run_refuses_in_one_line(file: str, capsys: Out) -> None:
    for arguments, words in (
        (["run", file, "--controller", "nobody"], "--controller: got 'nobody', wants one of"),
        (["run", file, "--controller", "too_fast"], "too_fast: kv"),
        (["run", "nowhere.toml"], "nowhere.toml"),
        (["run", "nowhere"], "nowhere"),
        (["run", file, "--seed", "x"], "--seed"),
        (["run", file, "--seed", "-1"], "seed"),
        (["run", file, "--plot", "run.txt"], "--plot"),
        (["run", file, "--magic"], "--magic"),
        (["compare"], "SOURCE"),
    ):
        assert main(arguments) == 2, arguments
        said = capsys.readouterr().err.splitlines()[-1]
        assert said.startswith("steadyarm: ") and words in said, said


def test_compare_prints_and_writes_the_table(file: str, tmp_path: Path, capsys: Out) -> None:
    paths = {end: tmp_path / f"table.{end}" for end in ("csv", "json", "html")}
    options = [part for end, path in paths.items() for part in (f"--{end}", str(path))]
    assert main(["compare", file, "--seeds", "2", "--workers", "2", *options]) == 0
    out = capsys.readouterr().out
    assert all(name in out for name in ("plain", "pid", "too_fast")) and "refused" in out
    assert all(f"written     {path}" in out for path in paths.values())
    table = sa.compare(file, seeds=2)
    assert comparison.Comparison.from_json(paths["json"]) == table
    assert comparison.Comparison.from_csv(paths["csv"]).rows == table.rows
    json.loads(paths["json"].read_text(encoding="utf-8"))
    page = paths["html"].read_text(encoding="utf-8")
    assert page.startswith("<!DOCTYPE html>") and "Short" in page
    assert not re.search(r"(src|href)=.https?:", page), "a page of one file"


def test_compare_takes_some_and_prints_markdown(file: str, capsys: Out) -> None:
    assert main(["compare", file, "--only", "pid,plain", "--markdown"]) == 0
    out = capsys.readouterr().out
    assert out.count("|") > 20 and "| ---" in out.replace("|---", "| ---") and "too_fast" not in out
    assert main(["compare", file, "--only", "pid"]) == 0
    assert "plain" not in capsys.readouterr().out


def test_compare_refuses_in_one_line(file: str, tmp_path: Path, capsys: Out) -> None:
    for arguments, words in (
        (["compare", file, "--only", "nobody"], "only: got 'nobody', wants some of"),
        (["compare", file, "--seeds", "0"], "seeds"),
        (["compare", file, "--seeds", "many"], "--seeds"),
        (["compare", file, "--workers", "0"], "workers"),
        (["compare", "nowhere.toml"], "cannot read nowhere.toml"),
        (["compare", "nowhere.urdf"], "nowhere.urdf"),
        (["compare", "nobody"], "nobody"),
        (["compare", str(tmp_path)], str(tmp_path)),
        (["compare", "panda", "--payload", "-1"], "mass"),
        (["compare", "panda", "--payload", "heavy"], "--payload"),
        (["compare", "panda", "--payload", "nan"], "mass"),
        (["compare", "panda", "--bandwidth", "x"], "--bandwidth"),
        (["compare", str(EXAMPLES / "04_arm.urdf"), "--tip", "nobody"], "nobody"),
    ):
        assert main(arguments) == 2, arguments
        said = capsys.readouterr().err.splitlines()[-1]
        assert said.startswith("steadyarm: ") and words in said, said
    broken = tmp_path / "broken.toml"
    broken.write_text(text(SCENE | {"run": {"duration": -1.0}}), encoding="utf-8")
    assert main(["compare", str(broken)]) == 2
    assert "broken.toml: run.duration: got -1" in capsys.readouterr().err


def test_a_file_that_cannot_be_written_is_told_before_the_work(file: str, capsys: Out) -> None:
    assert main(["compare", file, "--csv", "/nowhere/table.csv"]) == 1
    streams = capsys.readouterr()
    assert streams.out == "" and "no such directory" in streams.err


@pytest.mark.parametrize("robot", [str(EXAMPLES / "04_arm.urdf"), "ur5e"])
def test_compare_takes_a_robot(
    robot: str, capsys: Out, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    made = sa.Scenario.of_robot
    short = staticmethod(lambda *args, **named: made(*args, duration=0.2, **named))
    monkeypatch.setattr(sa.Scenario, "of_robot", short)
    page = tmp_path / "page.html"
    assert (
        main(["compare", robot, "--payload", "0.5", "--bandwidth", "8", "--html", str(page)]) == 0
    )
    out = capsys.readouterr().out
    assert "0.5 kg" in out and "momentum_observer" in out and page.stat().st_size > 10_000
    assert main(["run", robot, "--payload", "0.5", "--controller", "pid"]) == 0
    assert "controller  pid" in capsys.readouterr().out


def test_scenario_prints_files_that_can_be_run(tmp_path: Path, capsys: Out) -> None:
    for name in scenario_names():
        assert main(["scenario", name]) == 0
        (tmp_path / f"{name}.toml").write_text(capsys.readouterr().out, encoding="utf-8")
        mine, shipped = sa.Scenario.read(tmp_path / f"{name}.toml"), sa.Scenario.read(name)
        assert mine.controllers == shipped.controllers and mine.options == shipped.options
        assert mine.title == shipped.title and mine.reference == shipped.reference
    assert main(["scenario", "nobody"]) == 2
    said = capsys.readouterr().err
    assert "nobody" in said and "paper_sensors" in said


def test_help_lists_the_library(capsys: Out) -> None:
    for name in ("run", "compare"):
        assert main([name, "--help"]) == 0
        out = capsys.readouterr().out
        assert all(scenario in out for scenario in scenario_names())


@pytest.mark.skipif(os.name != "posix", reason="signals are sent as on Unix")
def test_ctrl_c_prints_the_rows_that_there_are_and_ends_with_130(tmp_path: Path) -> None:
    # Gears that give take many short steps: minutes of work.
    gears = {"joint_stiffness": 1e6, "rotor_inertia": 1e-3}
    long = {key: value for key, value in SCENE.items() if key not in ("two_link", "actual")} | {
        "robot": {"file": "ur5e"},
        "reference": {"sines": {"frequency": 2.0, "sin": [0.3] * 6}},
        "run": {"duration": 600.0, "control_period": 0.001},
        "effects": gears,
    }
    (tmp_path / "long.toml").write_text(text(long), encoding="utf-8")
    command = [sys.executable, "-m", "steadyarm", "compare", str(tmp_path / "long.toml")]
    with subprocess.Popen(
        [*command, "--only", "too_fast,pid", "--csv", str(tmp_path / "table.csv")],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as child:
        try:
            time.sleep(1.5)
            child.send_signal(signal.SIGINT)
            out, err = child.communicate(timeout=60)
        finally:
            child.kill()
    assert child.returncode == 130, err
    assert "interrupted" in out and "Traceback" not in err
    rows = comparison.Comparison.from_csv(tmp_path / "table.csv").rows
    assert [row.status for row in rows] == ["refused", "interrupted"]


def test_the_example_of_a_controller_of_ones_own_runs(capsys: Out) -> None:
    runpy.run_path(str(EXAMPLES / "own_controller.py"), run_name="__main__")
    out = capsys.readouterr().out
    assert all(name in out for name in ("springs", "computed_torque", "pid"))
    assert "raised" not in out and "refused" not in out

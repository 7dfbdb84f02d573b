"""The command sweep: values, folders, rows once more, refusals."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import steadyarm as sa
from steadyarm._sweep import _values
from steadyarm.cli import main
from test_sweep import SCENE, rows_of, same

Out = pytest.CaptureFixture[str]


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "short.toml").write_text(SCENE, encoding="utf-8")
    return "short.toml"


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("payload=0:3:4", [0.0, 1.0, 2.0, 3.0]),
        ("payload=-1:1:1", [-1.0]),
        ("delay=0,1,2", [0, 1, 2]),
        ("noise=0,1e-5", [0.0, 1e-5]),
        ("controller=pid, rise", ["pid", "rise"]),
        ("front.bumpless=true,false", [True, False]),
    ],
)
def test_values_are_a_range_or_a_list(text: str, values: list[object]) -> None:
    name, found = _values(text)
    assert name == text.partition("=")[0]
    assert list(found) == values
    plain = found if isinstance(found, list) else found.tolist()
    assert [type(it) for it in plain] == [type(it) for it in values]


def test_a_sweep_is_kept_resumed_shown_and_drawn(file: str, tmp_path: Path, capsys: Out) -> None:
    command = ["sweep", file, "--over", "payload=0:2:3", "--over", "controller=pid", "--seeds", "2"]
    assert main([*command, "--plot", "map.png"]) == 0
    out = capsys.readouterr().out
    assert out.startswith("6 rows: 6 finished; inputs payload, controller, seed; in results")
    assert "worst by rms_e:" in out and "steadyarm sweep results --only " in out
    assert (tmp_path / "map.png").stat().st_size > 10_000
    assert rows_of(tmp_path / "results") == [*range(6)]
    over = {"payload": [0.0, 1.0, 2.0], "controller": ["pid"]}
    python = sa.sweep(file, over, seeds=2, out=tmp_path / "python").table()
    assert same(sa.Sweep.read("results").table(), python)
    next((tmp_path / "results").glob("rows-*.parquet")).unlink()
    assert main([*command, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["missing"] == 0 and found["status"] == {"finished": 6}
    assert found["figures"]["rms_e"]["worst"] == found["worst"][0]["value"]
    assert main(["sweep", "results", "--by", "max_abs_tau_2"]) == 0
    assert "worst by max_abs_tau_2:" in capsys.readouterr().out


def test_a_row_is_computed_once_more(file: str, capsys: Out) -> None:
    command = ["sweep", file, "--over", "noise=1e-5,1e-3", "--seeds", "2"]
    assert main(command) == 0
    capsys.readouterr()
    assert main(["sweep", "results", "--only", "3", "--json"]) == 0
    row = json.loads(capsys.readouterr().out)
    assert row.pop("same_bits") is True
    assert (row["noise"], row["seed"], row["status"]) == (1e-3, 1, "finished")
    assert main([*command, "--only", "3", "--json", "--out", "nowhere"]) == 0
    assert json.loads(capsys.readouterr().out) == row
    assert not Path("nowhere").exists()


def one_over(divisor: float) -> dict[str, float]:
    return {"one_over": 1.0 / divisor}


def test_a_row_that_raised_is_no_success(capsys: Out, tmp_path: Path) -> None:
    results = str(tmp_path / "results")
    sa.sweep(one_over, over={"divisor": [1.0, 0.0]}, out=results, progress=False)
    assert main(["sweep", results]) == 1
    assert "ZeroDivisionError" in capsys.readouterr().out


def test_a_robot_is_made_a_scenario(capsys: Out, file: str) -> None:
    command = ["sweep", "ur5e", "--armature", "0.1", "--over", "duration=0.2", "--only", "0"]
    assert main([*command, "--payload", "1.5", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    arm = sa.Serial.shipped("ur5e")
    scene = sa.Scenario.of_robot(arm, armature=0.1, payload=1.5, duration=0.2)
    metrics = scene.simulate("recommended").metrics(window=(0.1, 0.2))
    assert [found[f"rms_e_{n}"] for n in range(1, 7)] == metrics.rms_e.tolist()


def test_it_refuses_in_one_line(file: str, tmp_path: Path, capsys: Out) -> None:
    over = ["--over", "noise=0,1"]
    assert main(["sweep", file, "--over", "noise=0"]) == 0
    capsys.readouterr()
    for arguments, words in (
        (["sweep"], "SOURCE: is missing"),
        (["sweep", file], "--over: is missing"),
        (["sweep", file, "--over", "noise"], "wants name=0:3:50 or name=a,b,c"),
        (["sweep", file, "--over", "noise=0:1"], "wants name=0:3:50 or name=a,b,c"),
        (["sweep", file, "--over", "noise=0:x:3"], "wants name=0:3:50 or name=a,b,c"),
        (["sweep", file, "--over", "noise=0:3:0"], "wants at least one value, as in 0:3:1"),
        (["sweep", file, *over, *over], "--over: got an input twice, noise, wants each once"),
        (["sweep", file, "--over", "noize=0"], "over['noize']: wants"),
        (["sweep", file, *over], "out: results has another sweep; rows: there 1, here 2"),
        (["sweep", file, *over, "--seeds", "0"], "seeds"),
        (["sweep", file, *over, "--only", "2"], "--only: got 2, wants one of 2, from 0"),
        (["sweep", file, *over, "--executor", "mpi"], "executor: got 'mpi'"),
        (["sweep", file, *over, "--payload", "1"], "--payload: for a robot alone"),
        (["sweep", "results", "--retry"], "--retry: wants a robot or a scenario as SOURCE"),
        (["sweep", "results", *over], "--over: wants a robot or a scenario as SOURCE"),
        (["sweep", "results", "--only", "7"], "wants a row that is there, from 0 to"),
        (["sweep", "results", "--by", "nobody"], "by: got 'nobody', wants one of rms_e"),
        (["sweep", "nowhere.toml", *over], "nowhere.toml"),
        (["sweep", "nowhere"], "SOURCE: got 'nowhere', wants a file"),
        (["sweep", str(tmp_path), *over], str(tmp_path)),
    ):
        assert main(arguments) == 2, arguments
        said = capsys.readouterr().err.splitlines()[-1]
        assert said.startswith("steadyarm: ") and words in said, said

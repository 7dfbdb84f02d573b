"""The commands ``play``, ``export``, ``robots`` and ``completion``."""

from __future__ import annotations

import json
import shutil
import subprocess
import webbrowser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import steadyarm as sa
from steadyarm import _extras, bench, cli, laws
from steadyarm._sections import arm_names
from steadyarm.bench import scenario_names
from test_cli import run_command
from test_cli_robot import LIFTER, NAMES, SHORT

Out = pytest.CaptureFixture[str]


@pytest.fixture(autouse=True)
def opened(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """A folder with a robot and a run to be in; the addresses that a browser is asked for."""
    monkeypatch.chdir(tmp_path)
    shutil.copy(LIFTER, "robot.urdf")
    sa.paper.simulation(2, duration=0.1).run().save("run.npz")
    addresses: list[str] = []
    monkeypatch.setattr(webbrowser, "open", lambda url: addresses.append(url) or True)
    return addresses


@pytest.fixture
def pages(monkeypatch: pytest.MonkeyPatch) -> list[dict[str, Any]]:
    """What pages are asked for; a page says no more than that it is one."""
    asked: list[dict[str, Any]] = []

    def to_html(run: sa.Run, path: Path, *, arm: Any = None, against: Any = None) -> None:
        asked.append({"run": run, "path": Path(path), "against": against})
        Path(path).write_text("<!DOCTYPE html>")

    monkeypatch.setattr(sa.Run, "to_html", to_html, raising=False)
    return asked


def test_play_shows_the_page_of_a_run(
    capsys: Out, opened: list[str], pages: list[dict[str, Any]]
) -> None:
    shutil.copy("run.npz", "other.npz")
    code, out, err = run_command(capsys, "play", "run.npz", "--against", "other.npz")
    assert (code, out, err) == (0, "page        run.html\n", "")
    assert opened == [Path("run.html").resolve().as_uri()]
    (page,) = pages
    assert page["path"] == Path("run.html")
    assert np.array_equal(page["run"].q, page["against"].q)


def test_play_runs_a_robot_first(
    capsys: Out, opened: list[str], pages: list[dict[str, Any]]
) -> None:
    options = ("--payload", 1, "--controller", "pid", "--out", "x.html", "--no-open", *SHORT)
    code, out, _ = run_command(capsys, "play", "robot.urdf", *options)
    assert (code, out, opened) == (0, "page        x.html\n", [])
    arm = sa.Serial.from_urdf("robot.urdf")
    scene = sa.Scenario.of_robot(arm, payload=1.0, duration=0.2)
    assert np.array_equal(pages[0]["run"].q, scene.simulate("pid").q)


def test_play_writes_films(capsys: Out, opened: list[str]) -> None:
    code, out, _ = run_command(capsys, "play", "run.npz", "--out", "run.gif", "--speed", 2)
    assert (code, out) == (0, "film        run.gif\n")
    assert Path("run.gif").read_bytes().startswith(b"GIF") and len(opened) == 1


def test_play_without_a_browser_says_where_the_page_is(
    capsys: Out, pages: list[dict[str, Any]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(webbrowser, "open", lambda _: False)
    code, _, err = run_command(capsys, "play", "run.npz")
    assert (code, err) == (0, "steadyarm: no browser was found; open run.html in one\n")
    assert len(pages) == 1


def test_simulate_writes_the_page_and_the_table_of_a_run(
    capsys: Out, pages: list[dict[str, Any]], monkeypatch: pytest.MonkeyPatch
) -> None:
    table = lambda run, path: Path(path).write_text("t\n")  # noqa: E731
    monkeypatch.setattr(sa.Run, "to_csv", table, raising=False)
    options = ("--html", "x.html", "--csv", "x.csv", *SHORT)
    code, out, _ = run_command(capsys, "simulate", "robot.urdf", *options)
    assert code == 0 and out.endswith("table       x.csv\npage        x.html\n")
    assert len(pages) == 1 and Path("x.csv").read_text() == "t\n"


def test_export_writes_a_robot_with_its_load_and_rotors(capsys: Out) -> None:
    options = ("--payload", 1, "--armature", "0.1,0.2,0.3", "--out", "robot.toml")
    code, out, _ = run_command(capsys, "export", "robot.urdf", *options)
    assert (code, out) == (0, "robot       robot.toml\n")
    arm = sa.Serial.from_urdf("robot.urdf").with_armature([0.1, 0.2, 0.3])
    assert sa.Serial.from_toml("robot.toml") == arm.with_payload(1.0, (0.0, 0.0, 0.05))
    assert run_command(capsys, "simulate", "robot.toml", *SHORT)[0] == 0
    run_command(capsys, "export", "robot.urdf", "--out", "bare.toml")
    assert sa.Serial.from_toml("bare.toml") == sa.Serial.from_urdf("robot.urdf")


def test_export_writes_a_scenario_that_is_the_same(capsys: Out) -> None:
    code, _, _ = run_command(capsys, "export", "paper_sensors", "--out", "mine.toml")
    mine, shipped = sa.Scenario.read("mine.toml"), sa.Scenario.read("paper_sensors")
    assert code == 0 and mine.controllers.keys() == shipped.controllers.keys()
    run, same = (scene.simulate("pid", duration=0.1) for scene in (mine, shipped))
    assert np.array_equal(run.q, same.q)


def test_export_writes_a_run_as_a_table(capsys: Out, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Path] = []
    monkeypatch.setattr(sa.Run, "to_csv", lambda run, path: asked.append(path), raising=False)
    code, _, _ = run_command(capsys, "export", "run.npz", "--out", "run.csv")
    assert code == 0 and asked == [Path("run.csv")]


def test_export_to_parquet_reads_back(capsys: Out) -> None:
    pandas = pytest.importorskip("pandas")
    pytest.importorskip("pyarrow")
    code, _, _ = run_command(capsys, "export", "run.npz", "--out", "run.parquet")
    frame, run = pandas.read_parquet("run.parquet"), sa.Run.load("run.npz")
    assert code == 0 and np.array_equal(frame["q_1"], run.q[:, 0])
    assert np.array_equal(frame["t"], run.t)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ("play run.npz --out run.bmp", "wants a name that ends in .html or .gif or .mp4"),
        ("play run.npz --out run.gif --against run.npz", "--against: wants a page"),
        ("play run.npz --speed 2", "--speed: wants a film"),
        ("play run.npz --out run.gif --speed -1", "speed: got -1"),
        ("play run.npz --payload 2", "--payload: is for a robot or a scenario"),
        ("play run.npz --against none.npz", "cannot read none.npz"),
        ("play broken.npz", "broken.npz: "),
        ("play", "the following arguments are required: SOURCE"),
        ("export run.npz --out run.toml", "wants a name that ends in .csv or .parquet, for a run"),
        ("export panda --out panda.csv", "wants a name that ends in .toml, for a robot"),
        ("export panda", "the following arguments are required: --out"),
        ("export paper_3 --payload 2 --out x.toml", "--payload: is for a robot alone"),
        ("export robot.urdf --payload -1 --out x.toml", "mass: got -1"),
        ("completion tcsh", "invalid choice: 'tcsh'"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(capsys: Out, arguments: str, words: str) -> None:
    Path("broken.npz").write_bytes(b"PK\x03\x04 and no more")
    code, out, err = run_command(capsys, *arguments.split())
    assert (code, out) == (2, "")
    last = err.splitlines()[-1]
    assert last.startswith("steadyarm: ") and words in last
    assert not Path("x.toml").exists()


@pytest.mark.parametrize(
    ("package", "arguments", "extra"),
    [
        ("pandas", "export run.npz --out run.parquet", "data"),
        ("pyarrow", "export run.npz --out run.parquet", "data"),
        ("shtab", "completion bash", "completion"),
        ("matplotlib", "simulate --plot run.png", "plot"),
    ],
)
def test_what_brings_a_missing_package_is_said(
    capsys: Out, monkeypatch: pytest.MonkeyPatch, package: str, arguments: str, extra: str
) -> None:
    plain = _extras.import_module

    def without(name: str) -> Any:
        if name == package:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)
        return object() if name == "pandas" else plain(name)

    monkeypatch.setattr(_extras, "import_module", without)
    code, out, err = run_command(capsys, *arguments.split())
    assert (code, out) == (1, "")
    assert f'needs {package}; pip install "steadyarm[{extra}]"' in err


def test_robots_lists_what_comes_with_it_with_its_sources(capsys: Out) -> None:
    code, out, _ = run_command(capsys, "robots")
    assert code == 0 and all(f"\n{name}" in f"\n{out}" for name in arm_names())
    _, text, _ = run_command(capsys, "robots", "--json")
    robots = json.loads(text)["robots"]
    assert [robot["name"] for robot in robots] == arm_names()
    for robot in robots:
        arm = sa.Serial.shipped(robot["name"])
        assert [joint["name"] for joint in robot["joints"]] == arm.joint_names
        assert len(robot["sources"]) > 100 and robot["sources"] in " ".join(out.split())
    assert arm_names() == ["panda", "puma560", "ur5e"], "those that the core has"


def test_robots_has_the_joints_of_ones_own(capsys: Out) -> None:
    _, text, _ = run_command(capsys, "robots", "robot.urdf", "--json")
    found, arm = json.loads(text), sa.Serial.from_urdf("robot.urdf")
    masses = [joint["mass"] for joint in found["joints"]]
    assert masses == arm.inertial_parameters()[::10].tolist()
    assert [joint["kind"] for joint in found["joints"]] == list(arm.joint_kinds)
    lower = [joint["lower"] for joint in found["joints"]]
    assert lower == [x if np.isfinite(x) else None for x in arm.limits["lower"]]
    assert found["notes"] == arm.notes
    _, out, _ = run_command(capsys, "robots", "robot.urdf")
    words = " ".join(out.split())
    for part in ("slide prismatic 0 to 0.8 m 0.5 m/s 200 N", "elbow continuous no limit 3 rad/s"):
        assert part in words
    assert all(" ".join(note.split()) in words for note in arm.notes)


@pytest.fixture(scope="module")
def scripts() -> dict[str, str]:
    """The scripts of all shells."""
    pytest.importorskip("shtab")
    texts = {}
    for shell in ("bash", "zsh", "fish"):
        lines: list[str] = []
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr("steadyarm._completion.say", lines.append)
            assert cli.main(["completion", shell]) == 0
        (texts[shell],) = lines
    return texts


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_scripts_are_those_of_their_shells(
    shell: str, scripts: dict[str, str], tmp_path: Path
) -> None:
    if shutil.which(shell) is None:
        pytest.skip(f"needs {shell}")
    (tmp_path / "script").write_text(scripts[shell], encoding="utf-8")
    done = subprocess.run([shell, "-n", "script"], cwd=tmp_path, capture_output=True, check=False)
    assert (done.returncode, done.stderr) == (0, b"")
    for name in (*NAMES, *arm_names(), *scenario_names(), *laws.__all__, "--light-joints"):
        assert name.removeprefix("--") in scripts[shell]


@pytest.mark.parametrize(
    ("line", "wanted"),
    [
        ("steadyarm de", {"design"}),
        ("steadyarm simulate pan", {name for name in scenario_names() if "pan" in name[:3]}),
        ("steadyarm design rob", {"robot.urdf"}),
        ("steadyarm run --payload 2 ur5e_", {"ur5e_payload", "ur5e_pickup"}),
        ("steadyarm simulate panda --controller time", {"time_delay"}),
        ("steadyarm simulate panda --save ru", {"run.npz"}),
        ("steadyarm compare panda --only recom", {"recommended"}),
        ("steadyarm robots panda --t", {"--tip"}),
        ("steadyarm design --preset ", {"printed", "claimed", "recommended"}),
        ("steadyarm completion ", {"bash", "zsh", "fish"}),
    ],
)
def test_bash_completes(line: str, wanted: set[str], scripts: dict[str, str]) -> None:
    if shutil.which("bash") is None:
        pytest.skip("needs bash")
    words = [*line.split(), ""] if line.endswith(" ") else line.split()
    ask = f"COMP_WORDS=({' '.join(f'{word!r}' for word in words)}); COMP_CWORD={len(words) - 1}"
    script = f'{scripts["bash"]}\n{ask}\n_shtab_steadyarm\nprintf "%s\\n" "${{COMPREPLY[@]}}"'
    done = subprocess.run(["bash", "-c", script], capture_output=True, text=True, check=False)
    wanted = wanted | {"panda"} if line.endswith("pan") else wanted
    assert set(done.stdout.split()) == wanted


@pytest.mark.parametrize(
    "arguments",
    [
        "simulate S --csv S",
        "compare S --only pid --csv S",
        "design S --json S",
        "simulate S --html {0}.html --plot {0}.png --csv {0}.html",
        "export S --out S",
    ],
)
def test_no_output_takes_the_place_of_what_is_read_or_of_another(
    arguments: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source = tmp_path / "s.json" if "--json" in arguments else tmp_path / "s.toml"
    source.write_text((bench.LIBRARY / "paper_sensors.toml").read_text(encoding="utf-8"))
    before = source.read_bytes()
    words = [word.format(tmp_path / "x").replace("S", str(source)) for word in arguments.split()]
    assert cli.main(words) == 2
    assert "wants another file" in capsys.readouterr().err
    assert source.read_bytes() == before and not [*tmp_path.glob("x.*")]


def test_json_is_an_object_where_the_arguments_are_refused(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert cli.main(["simulate", "nowhere.urdf", "--json"]) == 2
    said = capsys.readouterr()
    assert json.loads(said.out)["status"] == "refused" and "nowhere.urdf" in said.err


def test_json_is_one_object_where_a_command_stops_after_it_has_answered(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def stop(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(sa.Run, "save", stop)
    file = str(tmp_path / "run.npz")
    assert cli.main(["simulate", "--duration", "0.1", "--save", file, "--json"]) == 130
    assert json.loads(capsys.readouterr().out)["status"] == "finished"


@pytest.mark.parametrize("command", ["design", "simulate", "play"])
def test_a_period_that_is_none_is_refused_by_its_option(
    command: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main([command, "panda", "--control-period", "-1"]) == 2
    assert "--control-period: got '-1', wants a number > 0" in capsys.readouterr().err


def test_design_says_a_load_beyond_what_it_reckons_with_and_rotors_that_nobody_states(
    capsys: pytest.CaptureFixture[str],
) -> None:
    for load, rotors, beyond, unstated in (("12", "0.5", True, False), ("2", "0", False, True)):
        assert cli.main(["design", "panda", "--payload", load, "--armature", rotors]) == 0
        said = " ".join(capsys.readouterr().out.split())
        assert ("is more than it reckons with" in said) == beyond
        assert ("the model states no rotors" in said) == unstated


def test_a_mistyped_option_is_told_the_nearest(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["simulate", "panda", "--paylod", "2"]) == 2
    said = capsys.readouterr().err.splitlines()
    assert said[0].startswith("steadyarm simulate --help")
    assert said[-1] == "steadyarm: unrecognized arguments: --paylod 2; near: --payload"

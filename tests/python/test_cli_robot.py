"""The command line for a robot of one's own: SOURCE, runs, designs, JSON, errors in words."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import steadyarm as sa
from steadyarm import _source, cli
from steadyarm._report import MUCH
from steadyarm.bench import scenario_names
from test_cli import run_command

LIFTER = Path(__file__).parents[2] / "examples" / "04_arm.urdf"
"""Three joints, one of them prismatic."""

NAMES = [
    "robots", "design", "simulate", "compare", "play", "export", "scenario", "reproduce",
    "approximate", "completion", "sweep",
]  # fmt: skip
"""The commands."""

SHORT = ("--duration", "0.2")

Out = pytest.CaptureFixture[str]


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder with a robot in it, which the command is called from."""
    monkeypatch.chdir(tmp_path)
    shutil.copy(LIFTER, "robot.urdf")
    return tmp_path


def one_link(inside: str = "", limit: str = 'effort="10"') -> str:
    """A URDF of one joint."""
    return (
        f'<robot name="one"><link name="a"/><link name="b">{inside}</link>'
        '<joint name="turn" type="revolute"><parent link="a"/><child link="b"/>'
        f'<axis xyz="0 1 0"/><limit lower="-1" upper="1" velocity="2" {limit}/></joint></robot>'
    )


def body(mass: float, moment: float) -> str:
    moments = f'ixx="{moment}" iyy="{moment}" izz="{moment}" ixy="0" ixz="0" iyz="0"'
    return f'<inertial><origin xyz="0 0 0.2"/><mass value="{mass}"/><inertia {moments}/></inertial>'


LIGHT = one_link(body(0.01, 1e-6))
"""A joint whose torque accelerates it by more than any motor does."""


def robot_scene(**given: object) -> sa.Scenario:
    """What the command makes of the robot, as the Python API does."""
    arm = sa.Serial.from_urdf("robot.urdf")
    made = sa.Scenario.of_robot(arm, name="robot", **{"payload": 1.0, **given})
    return made


def test_a_source_is_told_by_its_content(folder: Path) -> None:
    Path("bare").write_bytes(Path("robot.urdf").read_bytes())
    Path("marked.xml").write_bytes(b"\xef\xbb\xbf\n" + Path("robot.urdf").read_bytes())
    Path("arm.toml").write_text(sa.Serial.shipped("ur5e").to_toml(), encoding="utf-8")
    Path("scene.toml").write_text('title = "x"\n', encoding="utf-8")
    sa.paper.simulation(2, duration=0.1).run().save("run.npz")
    kinds = {
        "robot": ("bare", "marked.xml", "robot.urdf", "arm.toml", "panda", "ur5e"),
        "scenario": ("scene.toml", *scenario_names()),
        "run": ("run.npz",),
    }
    for kind, sources in kinds.items():
        assert {source: _source.kind_of(source) for source in sources} == dict.fromkeys(
            sources, kind
        )


def test_simulate_runs_the_recommended_controller_on_ones_own_robot(capsys: Out) -> None:
    options = ("--payload", 1, "--save", "run.npz", "--plot", "run.png", *SHORT)
    code, out, err = run_command(capsys, "simulate", "robot.urdf", *options)
    assert (code, err) == (0, "")
    scene = robot_scene(duration=0.2)
    run = sa.Run.load("run.npz")
    assert np.array_equal(run.q, scene.simulate("recommended").q)
    for words in (scene.title, "controller  recommended", "1 ms, torques 1 sample late"):
        assert words in out
    rms = 1e3 * run.metrics((0.1, 0.2)).rms_e
    assert all(
        name in out and f"{e:.4g}" in out for name, e in zip(run.joint_names, rms, strict=True)
    )
    assert "learnt      a load of" in out and Path("run.png").stat().st_size > 10_000


@pytest.mark.parametrize("command", ["simulate", "run"])
def test_options_of_a_robot_are_those_of_python(capsys: Out, command: str) -> None:
    options = "--payload 0.5 --bandwidth 8 --armature 0.1,0.2,0.3 --effort-limit 300,60,30"
    options += " --controller pid --seed 3 --control-period 0.002 --save run.npz"
    code, _, err = run_command(capsys, command, "robot.urdf", *options.split(), *SHORT)
    assert (code, err) == (0, "")
    scene = robot_scene(
        payload=0.5, bandwidth=8.0, armature=[0.1, 0.2, 0.3], effort_limit=[300.0, 60.0, 30.0],
        duration=0.2,
    )  # fmt: skip
    assert scene.plant.effort_limit.tolist() == [300.0, 60.0, 30.0]
    scene = _source.in_loop(scene, 0.002)
    assert np.array_equal(sa.Run.load("run.npz").q, scene.simulate("pid", seed=3).q)


def test_base_and_tip_choose_the_chain(capsys: Out) -> None:
    chain = sa.Serial.from_urdf("robot.urdf")
    options = ("--tip", chain.link_names[1], "--json")
    code, out, _ = run_command(capsys, "robots", "robot.urdf", *options)
    assert code == 0 and len(json.loads(out)["joints"]) == 2
    options = ("--base", chain.link_names[0], "--json")
    code, out, _ = run_command(capsys, "robots", "robot.urdf", *options)
    assert code == 0 and [it["name"] for it in json.loads(out)["joints"]] == chain.joint_names[1:]


def test_a_loop_of_any_rate_is_run_to_a_whole_number_of_its_steps() -> None:
    scene = robot_scene(bandwidth=2.0)
    for rate in (30.0, 300.0, 1000.0, 1300.0, 4000.0):
        options = _source.in_loop(scene, 1.0 / rate, duration=0.5).options
        steps, held = options["duration"] / options["dt"], options["control_period"] / options["dt"]
        assert options["dt"] <= 1e-3 and options["control_period"] == 1.0 / rate
        assert abs(steps - round(steps)) < 1e-6 and abs(held - round(held)) < 1e-9
        assert 0.5 - 1e-9 <= options["duration"] < 0.5 + options["dt"]
        assert _source.in_loop(scene, 1.0 / rate, duration=0.5).simulate("pid").status.finished


def test_a_load_that_nobody_states_fits_the_arm() -> None:
    assert _source.payload_for(sa.Serial.shipped("panda")) == 2.0
    light = sa.Serial.from_urdf(one_link(body(0.6, 0.01)))
    assert _source.payload_for(light) == 0.1


@pytest.mark.parametrize(
    "options", ["", "--payload 0", "--payload 1 --armature 0.1,0.2,0.3 --effort-limit 90"]
)
def test_scenario_of_a_robot_is_the_one_that_runs(capsys: Out, options: str) -> None:
    code, text, _ = run_command(capsys, "scenario", "robot.urdf", *options.split())
    assert code == 0
    Path("mine.toml").write_text(text, encoding="utf-8")
    run_command(capsys, "simulate", "mine.toml", "--save", "mine.npz", *SHORT)
    made = ("--save", "made.npz", *SHORT)
    code, _, _ = run_command(capsys, "simulate", "robot.urdf", *options.split(), *made)
    mine, made_of = sa.Run.load("mine.npz"), sa.Run.load("made.npz")
    assert code == 0 and np.array_equal(mine.q, made_of.q)
    (title,) = [line for line in text.splitlines() if line.startswith("title")]
    assert sa.Scenario.read("mine.toml").title in title


def test_too_heavy_a_load_is_said_to_be_at_the_limit(capsys: Out) -> None:
    _, out, _ = run_command(capsys, "simulate", "robot.urdf", "--payload", 60, *SHORT)
    assert "limit       slide" in out and f"over {100 * MUCH:g} % of the time" in out
    _, out, _ = run_command(capsys, "simulate", "robot.urdf", "--payload", 1, *SHORT)
    assert "limit  " not in out


def test_another_length_moves_the_window_to_its_second_half(capsys: Out) -> None:
    _, out, _ = run_command(capsys, "simulate", "paper_sensors", "--duration", 1, "--json")
    assert json.loads(out)["window"] == [0.5, 1.0]


def test_simulate_says_why_without_a_scenario_too(capsys: Out) -> None:
    options = ("--preset", "claimed", "--duration", 1, "--why", "--why-plot", "why.png")
    code, out, _ = run_command(capsys, "simulate", *options)
    run = sa.paper.simulation(3, "claimed", duration=1.0).run()
    assert code == 0 and str(sa.attribution(run, window=(0.5, 1.0))) in out
    assert Path("why.png").stat().st_size > 10_000


def test_design_of_a_robot_says_what_the_rule_chose_and_how_slow_a_loop_may_be(capsys: Out) -> None:
    code, out, err = run_command(capsys, "design", "robot.urdf", "--json")
    assert (code, err) == (0, "")
    found = json.loads(out)
    scene = robot_scene()
    chosen = sa.learned(scene.controller(scene.controllers["recommended"]))
    assert found["recommended"]["bandwidth"] == chosen.bandwidth.tolist()
    assert found["recommended"]["condition"] == chosen.condition
    for row in found["controllers"]:
        longest, name = row["longest_period"], row["controller"]
        _source.in_loop(scene, longest).controller(scene.controllers[name])
        with pytest.raises(ValueError):
            _source.in_loop(scene, 1.12 * longest).controller(scene.controllers[name])
        assert (row["status"] == "accepted") == (longest >= 1e-3)
    teaches = sa.learnable(scene.nominal, scene.reference, payload=1.5)
    assert found["learnable"]["payload_mass"] == pytest.approx(teaches.payload_mass)
    _, words, _ = run_command(capsys, "design", "robot.urdf")
    assert "Verdict: take the recommended controller" in words
    assert all(f"{p:.3g}" in words for p in chosen.bandwidth)
    assert all(len(line) <= 100 for line in words.splitlines())
    assert " ".join(teaches.sentences[0].split()) in " ".join(words.split())


def test_design_of_a_robot_fails_where_the_recommended_controller_is_refused(capsys: Out) -> None:
    code, out, _ = run_command(capsys, "design", "robot.urdf", "--control-period", 0.02)
    assert code == 1
    words = " ".join(out.split())
    assert "Verdict: the recommended controller cannot be used so." in words
    assert "; accepted up to" in words and "next: a shorter --control-period" in words
    Path("light.urdf").write_text(LIGHT)
    code, out, _ = run_command(capsys, "design", "light.urdf")
    assert code == 1 and "next: --armature J" in " ".join(out.split())
    code, out, _ = run_command(capsys, "design", "light.urdf", "--light-joints")
    assert code == 0


NOT_A_NUMBER = ("NaN", "Infinity")


@pytest.mark.parametrize(
    "arguments",
    [
        "simulate robot.urdf --duration 0.2",
        "simulate robot.urdf --duration 0.2 --controller pid --why",
        "simulate --preset claimed --duration 1 --why",
        "simulate --form concat --raw --gain 70 --control-period 0.04",
        "simulate --kp 1e308",
        "design robot.urdf",
        "design paper_3",
        "design",
        "compare robot.urdf --only pid,momentum_observer",
        "robots",
        "robots puma560",
        "robots robot.urdf",
    ],
)
def test_json_is_one_object_of_finite_numbers_and_all_of_the_output(
    capsys: Out, arguments: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = sa.Scenario.of_robot
    short = staticmethod(lambda *args, **named: made(*args, duration=0.2, **named))
    monkeypatch.setattr(sa.Scenario, "of_robot", short)
    plain_code, words, _ = run_command(capsys, *arguments.split())
    code, out, err = run_command(capsys, *arguments.split(), "--json")
    assert code == plain_code and "Traceback" not in err
    found = json.loads(out, parse_constant=lambda name: pytest.fail(name))
    assert isinstance(found, dict) and words != out
    assert not any(name in out for name in NOT_A_NUMBER)


def test_json_has_the_names_and_units_of_python(capsys: Out) -> None:
    _, out, _ = run_command(capsys, "simulate", "robot.urdf", "--json", *SHORT)
    found = json.loads(out)
    run = robot_scene(duration=0.2, payload=1.5).simulate("recommended")
    assert found["status"] == "finished" and found["joint_names"] == run.joint_names
    assert found["rms_e"] == run.metrics().rms_e.tolist() and found["units"]["rms_e"] == "rad"
    steady = run.metrics((0.1, 0.2))
    assert found["steady_rms_e"] == steady.rms_e.tolist()
    assert found["torque_variation"] == steady.torque_variation.tolist()
    assert found["learned"]["payload"] == sa.learned(run.tracker).payload


def test_a_stopped_run_is_told_and_asked_no_more(
    capsys: Out, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = robot_scene(duration=0.2).simulate("pid")
    vars(run)["status"] = sa.Status("interrupted", 0.2, "it was stopped from the keyboard")
    monkeypatch.setattr(sa.Scenario, "simulate", lambda *_, **__: run)
    options = ("--json", "--why", "--why-plot", "why.png", "--save", "run.npz")
    code, out, _ = run_command(capsys, "simulate", "robot.urdf", *options)
    found = json.loads(out)
    assert (code, found["status"], found["rms_e"]) == (130, "interrupted", None)
    assert "why" not in found and not Path("why.png").exists() and Path("run.npz").exists()
    code, out, err = run_command(capsys, "play", "robot.urdf")
    assert (code, out, err) == (130, "", "steadyarm: stopped; nothing was written\n")


def test_what_a_run_says_of_itself_is_a_note_without_a_place_in_the_code() -> None:
    Path("late.toml").write_text(
        '[robot]\nfile = "robot.urdf"\n[reference.sines]\nfrequency = 1.0\nsin = [0.1, 0.2, 0.3]\n'
        "[effects]\ndelay = 2\n[front]\ndelay = 1\n[run]\ncontrol_period = 0.001\nduration = 0.1\n"
        '[controllers.pid]\nlaw = "pid"\nbandwidth = 15.0\n'
    )
    command = [sys.executable, "-m", "steadyarm", "simulate", "late.toml", "--json"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    (note,) = json.loads(done.stdout)["notes"]
    assert done.stderr == f"steadyarm: note: {note}\n" and note.startswith("delay: ")


def test_json_of_a_run_that_blew_up_has_null_and_the_reason(capsys: Out) -> None:
    options = "--form concat --raw --gain 70 --control-period 0.04 --json"
    code, out, _ = run_command(capsys, "simulate", *options.split())
    found = json.loads(out)
    assert code == 1 and found["status"] == "diverged" and found["reason"]
    assert found["rms_e"] is None and 0 < found["t"] < 40


def test_json_goes_to_a_file_beside_the_words_or_before_a_source(capsys: Out) -> None:
    options = ("--json", "found.json", *SHORT)
    code, out, _ = run_command(capsys, "simulate", "robot.urdf", *options)
    assert code == 0 and "status      finished" in out and "written     found.json" in out
    beside = json.loads(Path("found.json").read_text(encoding="utf-8"))
    _, out, _ = run_command(capsys, "simulate", "--json", "robot.urdf", *SHORT)
    assert json.loads(out) == beside


def test_files_beside_json_are_told_on_standard_error(capsys: Out) -> None:
    options = ("--json", "--save", "run.npz", *SHORT)
    code, out, err = run_command(capsys, "simulate", "robot.urdf", *options)
    assert (code, err) == (0, "steadyarm: record run.npz\n")
    json.loads(out)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ("simulate robto.urdf", "cannot read robto.urdf: no such file"),
        ("simulate panad", "SOURCE: got 'panad', wants a file, panda, or another name"),
        ("simulate nobody", "wants a file, a robot (panda"),
        ("simulate .", "cannot read .: "),
        ("simulate picture.png", "picture.png: wants a robot (URDF, TOML), a scenario"),
        ("simulate notes.txt", "notes.txt: wants a robot (URDF, TOML), a scenario"),
        ("simulate run.npz", "is the file of a run, which steadyarm play and export take"),
        ("simulate empty.urdf", "without a single element"),
        ("simulate no_masses.urdf", "next: masses in the file, or from_urdf(…, masses={"),
        ("simulate macros.urdf", "it has macros, expand them first: pip install xacrodoc"),
        ("simulate odd.urdf", "next: a mended file, or from_urdf(…, unphysical="),
        ("simulate two_tips.urdf", 'choose one of "b" (1 joints), "c" (1 joints)'),
        ("simulate two_tips.urdf", "next: --tip with one of these, such as --tip b"),
        ("simulate robot.urdf --tip nobody", "nobody"),
        ("simulate panda --tip x", "--tip: for a URDF alone"),
        ("simulate light.urdf", "next: --armature J (gear² · rotor inertia"),
        ("simulate no_limit.urdf", "next: --effort-limit TAU"),
        ("simulate robot.urdf --control-period 0.05", "next: a shorter --control-period"),
        ("simulate robot.urdf --controller pdi", "--controller: got 'pdi', wants one of"),
        ("simulate robot.urdf --payload -1", "next: --payload with a number of kg"),
        ("simulate robot.urdf --armature 1,2", "armature: got shape (2,), wants a scalar or (3,)"),
        ("simulate robot.urdf --effort-limit 1,2", "effort_limit: got 2 entries, wants 3"),
        ("simulate robot.urdf --seed -1", "--seed: got '-1', wants a whole number from 0 on"),
        ("simulate robot.urdf --gain 7", "--gain: wants no SOURCE beside it"),
        ("simulate --payload 2", "--payload: wants a SOURCE: a robot, or a scenario"),
        ("simulate paper_sensors --payload 2", "--payload: for a robot alone"),
        ("simulate two_links.toml", "armature in [robot]"),
        ("design robot.urdf --kp 3", "--kp: wants no SOURCE beside it"),
        ("design --payload 3", "--payload: for a robot: give one as SOURCE"),
        ("compare --seeds 2", "SOURCE: is missing, wants a robot or a scenario"),
        ("robots paper_3", "paper_3: wants a robot"),
        ("scenario robot.urdf --base slider", "--base: a scenario's file does not say it"),
        ("scenario paper_3 --payload 2", "--payload: for a robot alone; edit the file"),
        ("scenario two_links.toml", "two_links.toml: wants a robot, or one of"),
    ],
)
def test_what_a_newcomer_does_wrong_is_said_in_one_line(
    capsys: Out, arguments: str, words: str
) -> None:
    Path("picture.png").write_bytes(b"\x89PNG\r\n\x1a\n\0\0\0")
    Path("notes.txt").write_text("the robot is in the other room\n")
    Path("empty.urdf").touch()
    Path("no_masses.urdf").write_text(one_link())
    Path("macros.urdf").write_text(one_link('<xacro:inertia m="${mass}"/>'))
    Path("odd.urdf").write_text(one_link(body(1.0, 1.0).replace('iyy="1.0"', 'iyy="9.0"')))
    Path("light.urdf").write_text(LIGHT)
    Path("no_limit.urdf").write_text(one_link(body(1.0, 0.1), limit=""))
    other = one_link(body(1.0, 0.1)).replace("</robot>", "") + (
        f'<link name="c">{body(1.0, 0.1)}</link><joint name="other" type="revolute"><parent '
        'link="a"/><child link="c"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
        "</robot>"
    )
    Path("two_tips.urdf").write_text(other)
    Path("two_links.toml").write_text(
        '[robot]\nfile = "light.urdf"\n[reference.sines]\nfrequency = 1.0\nsin = [0.1]\n'
        '[run]\ncontrol_period = 0.001\nduration = 0.1\n[controllers.x]\nlaw = "recommended"\n'
    )
    sa.paper.simulation(2, duration=0.1).run().save("run.npz")
    code, out, err = run_command(capsys, *arguments.split())
    assert (code, out) == (2, "")
    last = err.splitlines()[-1]
    assert last.startswith("steadyarm: ") and words in last


def test_a_name_that_comes_with_it_is_no_folder_of_that_name(capsys: Out) -> None:
    Path("panda").mkdir()
    code, out, _ = run_command(capsys, "robots", "panda")
    assert code == 0 and "Franka Emika Panda, 7 joints" in out


def test_every_line_of_the_help_is_one_that_can_be_typed(capsys: Out) -> None:
    """The commands of the epilog and of all examples: known commands and options."""
    _, out, _ = run_command(capsys, "--help")
    helps = [out] + [run_command(capsys, name, "--help")[1] for name in NAMES]
    parser, lines = cli._parser(), []
    for text in helps:
        lines += [line.strip() for line in text.splitlines() if line.startswith("  ")]
    typed = [line for line in lines if line.startswith("steadyarm ") and "<" not in line]
    assert len(typed) > 30
    for line in typed:
        words = line.split("  ")[0].split(" > ")[0].split(" | ")[0].split()[1:]
        assert parser.parse_args(words).run is not None, line


@pytest.mark.parametrize("name", NAMES)
def test_every_help_has_an_example_within_the_page(
    capsys: Out, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "100")
    code, out, _ = run_command(capsys, name, "--help")
    assert code == 0 and f"\n  steadyarm {name}" in out.partition("examples:")[2]
    assert all(len(line) <= 100 for line in out.splitlines())


def test_all_commands_are_in_these_tests() -> None:
    (commands,) = [action for action in cli._parser()._actions if action.dest == "==SUPPRESS=="]
    assert commands.choices is not None
    assert sorted({*NAMES, "run"}) == sorted(commands.choices)

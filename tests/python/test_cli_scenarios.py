"""The command line: what rivals show, and designs of scenarios."""

import re

import pytest
import steadyarm as sa
from steadyarm import _rivals, bench, cli, reproduction
from steadyarm.comparison import Row
from test_cli import run_command


def rival(controller, scenario, error, peak=10.0, variation=100.0, **figures):
    """A row of a rival with a steady error [mrad]."""
    figures |= {"max_abs_tau": peak, "torque_variation": variation}
    return Row(controller, scenario, steady_rms_e=1e-3 * error, **figures)


def test_what_rivals_show_follows_from_their_figures():
    rows = [
        rival("computed_torque", "paper_rivals", 100),
        rival("fuzzy_printed", "paper_rivals", 97),
        rival("pd", "paper_rivals", 30, 60.0),
        rival("pid", "paper_rivals", 2),
        rival("computed_torque", "paper_sensors", 100),
        rival("pid", "paper_sensors", 2, 12.0, 1500.0),
        rival("slotine_li", "paper_sensors", 3, frozen_rms_e=0.004),
        rival("fuzzy_claimed", "paper_sensors", 3, 70.0, frozen_rms_e=0.09),
        Row("pd", "paper_sensors", status="refused", reason="too fast"),
    ]
    ideal, sensors, printed, starts, chatter, learnt, refused = _rivals.sentences(rows)
    assert ideal.endswith("to 1/5 and less it does with pid (10.0 N·m).")
    assert "slotine_li (10.0 N·m), pid (12.0 N·m); at peaks far above those, fuzzy" in sensors
    assert "is inert: 97.0 mrad at 10.0 N·m. A PD without a model beats it: 30.0 mrad" in printed
    assert "60.0 at the most. With hand-over the median is 11.0 N·m." in starts
    assert chatter.endswith("by 10 times that and more with pid (1500).")
    assert (
        learnt
        == "Of the 2 that adapt these still work when learning stops: slotine_li (4.00 mrad)."
    )
    assert refused.endswith(": pd in paper_sensors.")
    rows[1] = rival("fuzzy_printed", "paper_rivals", 20)
    _, _, printed, *_ = _rivals.sentences(rows)
    assert "changes the error by -80 %" in printed
    assert "does not beat it" in printed
    assert _rivals.sentences([]) == []


def test_ctrl_c_among_the_rivals_keeps_the_pictures(capsys, tmp_path, monkeypatch):
    monkeypatch.setattr(reproduction, "cases", lambda: iter([reproduction.Case(2)]))
    figures = {"simulation 2": cli.FIGURES["simulation 2"]}
    monkeypatch.setattr(cli, "FIGURES", figures)
    row = Row("pid", "paper_rivals", status="interrupted", reason="it was stopped")
    monkeypatch.setattr(_rivals, "rivals", lambda: sa.Comparison([row]))
    code, _, err = run_command(capsys, "reproduce", "--out", tmp_path)
    assert code == 130
    assert (
        f"kept in {tmp_path}: errors.png, figure2.png, results.json; compare.md was not written"
        in err
    )


def test_design_of_a_scenario_says_which_controllers_suit_its_loop(capsys):
    code, out, err = run_command(capsys, "design", "paper_slow_loop")
    assert (code, err) == (1, "")
    scene = sa.Scenario.read("paper_slow_loop")
    said = dict(
        re.findall(r"^(\w+) {2,}(accepted|refused: .+?)(?:; | up to |$)", out, re.MULTILINE)
    )
    assert list(said) == list(scene.controllers)
    for name, law in scene.controllers.items():
        try:
            scene.controller(law)
        except ValueError as error:
            assert said[name] == f"refused: {error}"
        else:
            assert said[name] == "accepted"
    assert "loop        10 ms, torques 1 sample late" in out
    assert {"pid", "momentum_observer"} < {name for name in said if said[name] != "accepted"}


def test_design_of_a_scenario_reports_on_what_learns_along_its_path(capsys):
    _, out, _ = run_command(capsys, "design", "paper_sensors")
    scene = sa.Scenario.read("paper_sensors")
    law = scene.controllers["fuzzy_claimed"]
    settings = dict(law["compensator"])
    basis = sa.FuzzyBasis(**settings.pop("basis"))
    compensator = sa.FuzzyCompensator(basis, **settings)
    cut_off = scene.front["velocity_filter"]
    tracker = sa.ComputedTorque(
        scene.nominal, law["kp"], law["kv"], compensator, velocity_filter=cut_off
    )
    loop = {"path": scene.reference, "plant": scene.plant, "effects": scene.effects}
    report = sa.design(tracker, 1e-3, 1, **loop)
    assert f"fuzzy_claimed, along the path of the scenario, without hand-over\n{report}" in out
    assert out.count("along the path") == 4
    assert "the compensator is inert" in out


@pytest.mark.parametrize(
    ("law", "code", "words"),
    [
        ('law = "pid"\nbandwidth = 15.0', 0, "x                           accepted"),
        ('law = "pid"\nbandwidth = 150.0', 1, "refused: kv[0]: got 450"),
        ('law = "pid"\nkp = -1.0\nkv = 5.0\nki = 1.0', 1, "refused: kp[0]: got -1"),
    ],
)
def test_design_of_a_scenario_ends_with_1_if_one_is_refused(capsys, tmp_path, law, code, words):
    text = (bench.LIBRARY / "paper_sensors.toml").read_text(encoding="utf-8")
    file = tmp_path / "mine.toml"
    file.write_text(text[: text.index("[controllers.")] + f"[controllers.x]\n{law}\n")
    assert run_command(capsys, "design", file)[0] == code
    assert words in run_command(capsys, "design", file)[1]


def test_an_unsound_compensator_of_a_scenario_ends_with_1(capsys, tmp_path):
    text = (bench.LIBRARY / "paper_3.toml").read_text(encoding="utf-8")
    file = tmp_path / "mine.toml"
    file.write_text(text.replace("gain = 7.0", "gain = 7e4"))
    assert run_command(capsys, "design", "paper_3")[0] == 0
    code, out, _ = run_command(capsys, "design", file)
    assert code == 1
    assert "Verdict: do not run this" in out


def test_design_of_a_scenario_takes_another_period_and_delay(capsys):
    options = ("--control-period", 0.02, "--delay", 2)
    code, out, _ = run_command(capsys, "design", "paper_sensors", *options)
    assert code == 1
    assert "loop        20 ms, torques 2 samples late" in out
    assert re.search(r"^pid +refused: kv", out, re.MULTILINE)


def test_what_a_scenario_says_is_not_said_beside_it(capsys):
    for option, value in (("--kp", 3), ("--gain", 7), ("--disturbance", "1@1")):
        code, out, err = run_command(capsys, "design", "paper_sensors", option, value)
        assert (code, out) == (2, "")
        assert f"{option}: wants no SOURCE beside it" in err
    code, _, err = run_command(capsys, "design", "none.toml")
    assert code == 2
    assert "cannot read none.toml" in err

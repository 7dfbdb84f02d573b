"""Scenario files and `compare`: the library runs, broken keys are named, bad rivals lose a row."""

from __future__ import annotations

import math
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import steadyarm as sa
from scenario_files import ALL, example, least, resolved, text, within
from steadyarm import bench
from steadyarm._core import canonical_scenario, read_scenario
from steadyarm.bench import Scenario, compare, scenario_names

PATIENCE = 60
DIVERGES = ("paper_half", "time_delay")
"""Time delay with the inertia M̄ of an arm that has half of it: |1 - M̄/M| = 1, and it wants < 1."""


def short(name: str, duration: float = 0.2, **changes: Any) -> Scenario:
    """A shipped scenario that ends soon."""
    scene = Scenario.read(name)
    options = {**scene.options, "duration": duration}
    return replace(scene, options=options, window=None, **changes)


@pytest.mark.parametrize("name", scenario_names())
def test_a_shipped_scenario_runs_and_says_why_a_row_is_refused(name: str) -> None:
    table = compare(short(name), workers=2)
    assert len(table.rows) == len(Scenario.read(name).controllers) and table.scenario
    for row in table.rows:
        if (name, row.controller) == DIVERGES:
            assert row.status == "diverged" and row.reason
            continue
        assert row.status in ("finished", "refused"), row
        if row.status == "refused":
            assert "wants" in row.reason and ": got " in row.reason
            continue
        assert row.rms_e is not None and row.rms_tau is not None and row.step_time
    # A scenario where nearly nothing is left would compare nothing.
    assert sum(row.finished for row in table.rows) >= min(len(table.rows), 6)


@pytest.mark.parametrize("name", scenario_names())
def test_a_shipped_scenario_has_a_title_and_is_sampled_where_it_has_effects(name: str) -> None:
    scene = Scenario.read(name)
    assert scene.title != name and scene.name == name
    if scene.effects is not None:
        assert scene.options["control_period"] and scene.front["delay"] == scene.effects.delay
    for law in scene.controllers.values():
        assert law["law"] in (*sa.laws.__all__, "recommended")


def test_files_are_read_by_path_too(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text(
        (bench.LIBRARY / "paper_1.toml").read_text(encoding="utf-8"), encoding="utf-8"
    )
    scene = Scenario.read(tmp_path / "mine.toml")
    assert scene.name == "mine" and scene.controllers == Scenario.read("paper_1").controllers
    (tmp_path / "bad.toml").write_text("[robot]\nfile = 3\n")
    with pytest.raises(ValueError, match=r"bad\.toml: line 2: robot\.file"):
        Scenario.read(tmp_path / "bad.toml")
    with pytest.raises(OSError, match="nowhere"):
        Scenario.read(tmp_path / "nowhere.toml")


def numbers(schema: dict[str, Any]) -> dict[str, Any] | None:
    """The schema of one number of a key, or None where it has none."""
    found = schema["anyOf"][0] if "anyOf" in schema else schema
    while found.get("type") == "array":
        found = found["items"]
    return found if found.get("type") in ("number", "integer") else None


def broken() -> list[Any]:
    """Every key of a whole file with a value that it cannot have."""
    cases = []
    for path, schema in ALL:
        for key, part in schema["properties"].items():
            part = resolved(part)
            one = numbers(part)
            bad: list[Any] = [{"no": "table"}]
            if one is None:
                bad += [3, True, -1.0] if "properties" in part or "enum" in part else [3]
            else:
                bad += ["text", math.nan]
                bad += [-1.0 if one["type"] == "number" else -1] if "minimum" in one else []
                bad += [["text"]] if part.get("type") == "array" or "anyOf" in part else [[1.0]]
            if "properties" in part or key in ("controllers", "inputs", "disturbance"):
                bad = bad[1:]
            cases += [(path, schema, key, value) for value in bad]
    return cases


def refused(path: tuple[str, ...], schema: dict[str, Any], key: str, value: Any) -> str | None:
    content = {key: value} if "minProperties" in schema else least(schema, key) | {key: value}
    try:
        Scenario.of(read_scenario(text(within(path, content))))
    except (ValueError, TypeError) as error:
        return str(error)
    return None


OF_A_LAW = [case for case in broken() if case[0][:1] == ("controllers",)]
OF_THE_FILE = [case for case in broken() if case[0][:1] != ("controllers",)]
UNUSED = [("run", "q0"), ("run", "dq0"), ("run", "rtol"), ("run", "atol")]
"""Keys of a run that may be of no use in it, and are looked at all the same."""


def test_every_broken_key_is_refused_by_its_path() -> None:
    assert len(OF_THE_FILE) > 300
    wrong = []
    for path, schema, key, value in OF_THE_FILE:
        words = refused(path, schema, key, value)
        # Of a list of changes the reader does not tell which one.
        wanted = ".".join((*path, key)).replace("[0]", "" if isinstance(value, float) else "[0]")
        if words is None or wanted not in words:
            wrong.append((wanted, value, words))
    assert wrong == []


@pytest.mark.xfail(strict=True, reason="of a list of changes the reader does not tell which one")
def test_a_number_in_a_list_of_changes_is_refused_by_its_place() -> None:
    changes = [{"at": 1.0}, {"at": 2.0, "viscous": -1.0}]
    with pytest.raises(ValueError, match=r"actual\.changes\[1\]\.viscous"):
        read_scenario(text({"actual": {"changes": changes}}))


@pytest.mark.parametrize("path", UNUSED, ids=".".join)
def test_a_number_that_is_not_used_is_refused_too(path: tuple[str, str]) -> None:
    with pytest.raises(ValueError, match=path[1]):
        read_scenario(text(within(path[:1], {path[1]: math.nan})))


@pytest.mark.xfail(strict=True, reason="paths of keys end at the controller's name")
def test_every_broken_key_of_a_law_is_refused_by_its_path() -> None:
    wrong = []
    for path, schema, key, value in OF_A_LAW:
        words = refused(path, schema, key, value)
        if words is None or ".".join((*path, key)) not in words:
            wrong.append((".".join((*path, key)), value, words))
    assert wrong == []


def test_a_broken_type_in_a_law_is_refused_by_its_name_at_least() -> None:
    for path, schema, key, value in OF_A_LAW:
        if isinstance(value, str | dict):
            words = refused(path, schema, key, value)
            assert words is not None and "controllers." + path[1] in words


PARTS: list[tuple[dict[str, Any], str]] = [
    ({"two_link": None}, "two_link"), ({"robot": {"file": "ur5e"}}, "two_link"),
    ({"reference": None}, "reference"), ({"controllers": None}, "controllers"),
    ({"actual": {"payload": {"mass": 1.0}}}, "actual.payload"),
    ({"actual": {"friction_share": 0.1, "viscous": 1.0}}, "actual.friction_share"),
    ({"actual": {"inertia_scale": [1.0, 2.0, 3.0]}}, "actual.inertia_scale"),
    ({"actual": {"viscous": [1.0, 2.0, 3.0]}}, "actual.viscous"),
    ({"actual": {"effort_limit": [1.0, 2.0, 3.0]}}, "actual.effort_limit"),
    ({"plant": {"mass": 1, "length": 1, "inertia": 1},
      "actual": {"two_link": {"mass": 1, "length": 1, "inertia": 1}}}, "actual.two_link"),
    ({"robot": {"file": "nobody"}, "two_link": None}, "robot.file"),
    ({"metrics": {"from": 2.0, "to": 1.0}}, "metrics.to"),
    ({"robot": {"file": "nowhere.urdf"}, "two_link": None}, "robot.file"),
    ({"robot": {"file": "ur5e", "armature": [1.0]}, "two_link": None}, "robot.armature"),
    ({"reference": {"sines": {"frequency": 1.0, "sin": [0.1] * 6}}}, "reference"),
    ({"transfer": {"sines": {"frequency": 1.0, "sin": [0.1] * 6}}}, "transfer"),
    ({"disturbance": {"noise": {"deviation": [1.0] * 3, "cutoff": 1.0}}}, "disturbance"),
    ({"run": {"q0": [0.0] * 3}}, "run.q0"), ({"run": {"dq0": [0.0] * 3}}, "run.dq0"),
    ({"run": {"control_period": 0.001}, "effects": {"noise": [1.0] * 3}}, "effects.noise"),
    ({"metrics": {"from": 50.0}}, "metrics.from"),
    ({"effects": {"delay": 1}}, "run.control_period"),
    ({"front": {"hand_over": 3.0}}, "run.control_period"),
    ({"actual": {"changes": [{"at": 1.0, "viscous": 0.3}]}}, "run.control_period"),
    ({"actual": {"changes": [{"at": 1.0, "viscous": [1.0] * 3}]}}, "actual.changes.0..viscous"),
    ({"controller": {"kp": 1.0, "kv": 1.0}}, "controller"),
    ({"compensator": {"basis": {"form": "grid", "centers": [0.0], "width": 1.0}}}, "compensator"),
]  # fmt: skip
WHOLE = {
    "two_link": {"mass": 4.0, "length": 0.5, "inertia": 0.2},
    "reference": {"sines": {"frequency": 1.0, "sin": [0.3, 0.2]}},
    "controllers": {"pid": {"law": "pid", "bandwidth": 5.0}},
}


@pytest.mark.parametrize(("changes", "path"), PARTS, ids=[path for _, path in PARTS])
def test_parts_that_do_not_fit_are_refused_by_path(changes: dict[str, Any], path: str) -> None:
    Scenario.of(read_scenario(text(WHOLE)))
    file = {key: value for key, value in (WHOLE | changes).items() if value is not None}
    with pytest.raises(ValueError, match=rf"^{path}"):
        Scenario.of(read_scenario(text(file)))


def test_the_section_controller_is_one_with_its_limits() -> None:
    file = {key: value for key, value in WHOLE.items() if key != "controllers"}
    sections = file | {
        "controller": {"kp": 64.0, "kv": 16.0, "effort_limit": 2.0},
        "run": {"duration": 0.1, "control_period": 0.001, "q0": [0.3, 0.0]},
        "front": {"hand_over": 50.0},
    }
    scene = Scenario.of(read_scenario(text(sections)))
    tracker = scene.controllers["controller"]
    assert "hand_over=50.0" in repr(tracker)
    run = scene.simulate("controller")
    assert abs(run.tau).max() == 2.0 and compare(scene).rows[0].max_abs_tau == 2.0


@pytest.mark.parametrize("name", scenario_names())
def test_written_canonically_a_scenario_is_the_same(name: str) -> None:
    file = (bench.LIBRARY / f"{name}.toml").read_text(encoding="utf-8")
    canonical = canonical_scenario(file)
    assert canonical_scenario(canonical) == canonical
    first, again = read_scenario(file), read_scenario(canonical)
    assert first["controllers"] == again["controllers"]
    for section in ("two_link", "reference", "transfer", "disturbance", "effects"):
        assert first[section] == again[section], section
    assert Scenario.of(first).plant == Scenario.of(again).plant


def test_only_seeds_and_workers() -> None:
    scene = short("paper_noisy", 0.1)
    names = ["computed_torque", "pid", "slotine_li"]
    tables = [compare(scene, only=names, seeds=3, workers=workers) for workers in (1, 4)]
    assert tables[0] == tables[1] and len(tables[0].rows) == 9
    assert [row.seed for row in tables[0].rows] == [0, 0, 0, 1, 1, 1, 2, 2, 2]
    assert [row.controller for row in tables[0].rows[:3]] == names
    again = compare(scene, only=names, seeds=[2])
    assert list(again.rows) == list(tables[0].rows[6:])
    first, other = tables[0].rows[0], tables[0].rows[3]
    assert first.rms_e != other.rms_e, "another seed is other noise"
    reverse = compare(scene, only=names[::-1], seeds=[2]).rows
    assert [row.controller for row in reverse] == names[::-1]


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"only": ["nobody"]}, "only: got 'nobody', wants some of"), ({"seeds": 0}, "seeds"),
        ({"seeds": []}, "seeds"), ({"seeds": -1}, "seeds"), ({"seeds": [-1]}, "seed"),
        ({"workers": 0}, "workers"), ({"seeds": [1.5]}, "seeds"), ({"seeds": "ab"}, "seeds"),
        ({"only": "pid"}, "only"), ({"seeds": [2**64]}, "seed"), ({"only": []}, "only"),
        ({"seeds": True}, "seeds"), ({"seeds": 1.0}, "seeds"),
    ],
)  # fmt: skip
def test_arguments_that_make_no_sense_are_refused(given: dict[str, Any], words: str) -> None:
    with pytest.raises((ValueError, TypeError), match=words):
        compare(short("paper_noisy", 0.05), **given)


class Own:
    """PD; ``after`` s it does ``what``."""

    def __init__(self, what: Any = None, after: float = 0.02) -> None:
        self.what, self.after, self.t = what, after, 0.0

    def step(self, q: Any, dq: Any, q_d: Any, dq_d: Any, ddq_d: Any, dt: float) -> Any:
        self.t += dt
        if self.what is not None and self.t > self.after:
            if isinstance(self.what, BaseException):
                raise self.what
            return self.what
        return -300.0 * (q - q_d) - 40.0 * (dq - dq_d)


def test_a_controller_that_raises_in_row_7_of_12_loses_its_row_only() -> None:
    scene = short("paper_rivals", 0.1)
    own = {f"own {k}": Own() for k in range(12)}
    good = compare(scene, own, only=list(own), workers=2)
    own["own 6"] = Own(RuntimeError("no more"))
    table = compare(scene, own, only=list(own), workers=2)
    assert table.rows[6].status == "raised" and "no more" in table.rows[6].reason
    assert "t = 0.019 s" in table.rows[6].reason
    assert [row for k, row in enumerate(table.rows) if k != 6] == [
        row for k, row in enumerate(good.rows) if k != 6
    ]
    assert all(row.finished for k, row in enumerate(table.rows) if k != 6)


@pytest.mark.parametrize("what", [np.full(2, np.nan), np.zeros(3), "ab", None, SystemExit(2)])
def test_nonsense_from_a_law_loses_its_row_only(what: Any) -> None:
    class Nothing(Own):
        def step(self, *sample: Any) -> Any:
            tau = super().step(*sample)
            return None if what is None and self.t > self.after else tau

    table = compare(short("paper_rivals", 0.1), {"bad": Nothing(what)}, only=["bad", "pid"])
    assert table.rows[1].finished
    bad = table.rows[0]
    assert bad.status in ("raised", "diverged") and bad.reason and bad.rms_e is None


def test_controllers_of_every_kind_stand_in_one_table() -> None:
    scene = short("paper_sensors", 0.1)
    law = {"law": "pid", "bandwidth": 12.0}
    made = scene.controller(law)
    controllers = {
        "object": Own(), "class": lambda arm: Own(), "dict": law, "controller": made,
        "tracker": sa.ComputedTorque(scene.nominal, 64.0, 16.0),
        "function": lambda arm: sa.laws.pid(arm, bandwidth=12.0, control_period=1e-3),
        "no dict": {"law": "magic"}, "no controller": 3, "raises": lambda arm: 1 / 0,
    }  # fmt: skip
    table = compare(scene, controllers, only=list(controllers))
    status = {row.controller: row.status for row in table.rows}
    assert all(status[name] == "finished" for name in list(controllers)[:6]), table
    assert status["no dict"] == "refused" and status["no controller"] in ("refused", "raised")
    assert status["raises"] == "raised" and made.steps == 0
    figures = {row.controller: row.rms_e for row in table.rows}
    assert figures["dict"] == figures["controller"] and figures["object"] == figures["class"]


def test_what_learns_is_frozen_and_transferred_and_observers_are_not() -> None:
    scene = short("paper_sensors", 0.3)
    names = ["slotine_li", "fuzzy_concat_7", "rbf_network", "pid", "momentum_observer"]
    rows = {row.controller: row for row in compare(scene, only=names).rows}
    for name in names[:3]:
        assert rows[name].frozen_rms_e is not None and rows[name].transfer_rms_e is not None
    for name in names[3:]:
        assert rows[name].frozen_rms_e is None and rows[name].transfer_rms_e is None
    off = compare(scene, only=names, freeze=False).rows
    assert all(row.frozen_rms_e is None and row.transfer_rms_e is None for row in off)
    bare = compare(replace(scene, transfer=None), only=names[:1]).rows[0]
    assert bare.frozen_rms_e == rows["slotine_li"].frozen_rms_e and bare.transfer_rms_e is None


@pytest.mark.parametrize("name", ["", "\udcff", 3])
def test_names_that_no_row_can_have_are_refused_before_a_thread_waits_for_them(name: Any) -> None:
    with pytest.raises((ValueError, TypeError), match="controller: got"):
        compare(short("paper_rivals", 0.05), {name: Own()}, only=[name])


def test_one_controller_of_a_scenario_is_its_row() -> None:
    scene = short("paper_noisy", 0.1)
    run = scene.simulate("pid", seed=3)
    (row,) = compare(scene, only=["pid"], seeds=[3]).rows
    mine = sa.comparison.Row.of(run, controller="pid", scenario=scene.name, seed=3)
    assert (mine.rms_e, mine.torque_variation) == (row.rms_e, row.torque_variation)


@pytest.mark.parametrize("robot", ["panda", "puma560", "ur5e"])
def test_a_scenario_is_made_of_any_robot(robot: str) -> None:
    scene = Scenario.of_robot(sa.Serial.shipped(robot), payload=1.0, duration=0.1, name=robot)
    rows = compare(scene, freeze=False).rows
    assert {row.status for row in rows} <= {"finished", "refused"}
    assert sum(row.finished for row in rows) >= 8 and scene.effects.delay == 1


CHILD = """
import steadyarm as sa, threading
from dataclasses import replace
scene = sa.Scenario.read("paper_rivals")
quick = replace(scene, options={**scene.options, "duration": 90000.0, "record_every": 1000})
class Quits:
    def step(self, *sample):
        raise RuntimeError("quick")
class Tells:
    said = False
    def step(self, q, dq, *rest):
        if not Tells.said:
            Tells.said = True
            print("ready", flush=True)
        return 0 * q - 50 * q - 20 * dq
table = sa.compare(quick, {"quits": Quits(), "tells": Tells()}, only=["quits", "tells", "pid"],
                   workers=1)
for row in table.rows:
    print(row.controller, row.status)
"""


@pytest.mark.skipif(os.name != "posix", reason="signals are sent as on Unix")
def test_ctrl_c_keeps_the_rows_that_there_are() -> None:
    with subprocess.Popen(
        [sys.executable, "-u", "-c", CHILD], stdout=subprocess.PIPE, text=True
    ) as child:
        try:
            assert child.stdout is not None and child.stdout.readline() == "ready\n"
            time.sleep(0.2)
            child.send_signal(signal.SIGINT)
            rest, _ = child.communicate(timeout=PATIENCE)
        finally:
            child.kill()
    assert rest.split("\n")[:3] == ["quits raised", "tells interrupted", "pid interrupted"]


def test_the_example_of_the_least_file_runs() -> None:
    scene = Scenario.of(read_scenario(text(WHOLE | {"run": {"duration": 0.1}})))
    (row,) = compare(scene).rows
    assert row.finished and example(resolved({"$ref": "#/definitions/front"})) == {}

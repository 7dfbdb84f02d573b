"""The page of a run: what is embedded is what the run did, for runs of every kind."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import steadyarm as sa
from comparisons import HOSTILE, diverged
from steadyarm import _view_data
from test_comparison_page import Page, unpacked

PANDA = sa.Serial.shipped("panda")
START = np.array((0.0, -0.6, 0.0, -2.0, 0.0, 1.6, 0.8))
CURVES = ("e", "tau")


def panda_run(arm: sa.Serial = PANDA, duration: float = 1.0, **options: Any) -> sa.Run:
    """A run whose controller does not know of the load of 2 kg."""
    path = sa.Quintic(START, START + 0.3, 0.8 * duration)
    tracker = sa.ComputedTorque(PANDA.without_friction(), 100, 20)
    options = {"control_period": 1e-3, "q0": START} | options
    return sa.simulate(sa.Plant(arm), tracker, path, duration, **options)


LOADED = panda_run(PANDA.with_payload(2.0, com=(0.0, 0.0, 0.1)))
PAPER = sa.paper.simulation(3, preset="claimed").run(duration=4.0)


def written(run: sa.Run, folder: Path, **options: Any) -> str:
    run.to_html(folder / "run.html", **options)
    return (folder / "run.html").read_text(encoding="utf-8")


def data_of(text: str) -> dict[str, Any]:
    page = Page(text)
    data: dict[str, Any] = json.loads(
        next(words for tag, words in page.texts if tag == "script" and words[0] == "{")
    )
    return data


def side(packed: Any, count: int) -> np.ndarray:
    """A column of places: a number stands for one that does not move."""
    return np.full(count, packed) if isinstance(packed, float) else unpacked(packed)


def places(points: list[list[Any]], count: int) -> np.ndarray:
    return np.array([[side(one, count) for one in point] for point in points]).transpose(2, 0, 1)


def chain(arm: Any, q: np.ndarray) -> np.ndarray:
    joints = np.asarray(arm.link_poses(q))[:, :3, 3]
    return np.vstack([np.zeros(3), joints, np.asarray(arm.pose(q))[:3, 3]])


def test_the_page_is_one_file_that_asks_nobody(tmp_path: Path) -> None:
    text = written(LOADED, tmp_path, against=panda_run())
    page = Page(text)
    for word in ("http", "src=", "href", "@import", "url(", "fetch(", "XMLHttpRequest", "import("):
        assert word not in text
    assert "innerHTML" not in text and not page.of("link") and not page.of("img")
    assert not [n for _, each in page.elements for n in each if n.startswith("on")]
    assert [each["id"] for each in page.of("section") if "hidden" in each] == ["view"]
    assert page.of("noscript") and page.of("html")[0]["lang"] == "en"


@pytest.mark.parametrize(("run", "arm"), [(LOADED, PANDA), (PAPER, sa.paper.nominal())])
def test_places_of_arm_and_ghost_are_those_of_the_run(
    run: sa.Run, arm: Any, tmp_path: Path
) -> None:
    data = data_of(written(run, tmp_path))
    (packed,) = (each["arm"] for each in data["runs"])
    t = unpacked(packed["t"])
    assert len(t) == round(25 * run.t[-1]) + 2 and t[0] == 0.0 and t[-1] == run.t[-1]
    actual, root = (places(packed[name], len(t)) for name in ("actual", "off"))
    sides = actual.shape[2]
    assert data["flat"] == (sides == 2) == (arm.joints == 2)
    rows = np.searchsorted(run.t, np.linspace(0.0, run.t[-1], len(t)))
    for frame, k in enumerate(rows):
        true = chain(arm, run.q[k])[:, :sides]
        off = chain(arm, run.q_d[k])[:, :sides] - true
        assert np.abs(actual[frame] - true).max() < 2.0 / 4094 / 2 + 1e-6
        # The signed root keeps the digits of small errors: within 0.1 % of the largest, and 1 µm.
        assert np.abs(root[frame] * np.abs(root[frame]) - off).max() < 1e-3 * 0.8
    small = np.abs(root * np.abs(root)) < 1e-4
    assert small.any()
    assert np.abs(t - run.t[rows]).max() < run.t[-1] / 4094


def test_curves_keep_the_values_and_the_peaks(tmp_path: Path) -> None:
    run = panda_run(duration=0.5)  # fewer rows than a curve may have
    curves = data_of(written(run, tmp_path))["runs"][0]["curves"]
    for name in CURVES:
        for joint, packed in enumerate(curves[name]):
            true = getattr(run, name)[:, joint]
            quantum = np.ptp(true) / 4094
            assert np.abs(unpacked(packed) - true).max() <= 0.51 * quantum + 1e-7
    thinned = data_of(written(LOADED, tmp_path))["runs"][0]["curves"]
    assert len(unpacked(thinned["t"])) == _view_data.POINTS < len(LOADED.t)
    for name in CURVES:
        for joint, packed in enumerate(thinned[name]):
            true = getattr(LOADED, name)[:, joint]
            values = unpacked(packed)
            ends = pytest.approx([true.min(), true.max()], rel=1e-8)
            assert packed[:2] == ends and [values.min(), values.max()] == ends


def test_what_the_arm_carries_unknown_to_its_controller_is_where_it_is(tmp_path: Path) -> None:
    packed = data_of(written(LOADED, tmp_path))["runs"][0]["arm"]
    assert packed["masses"] == [[0.0, pytest.approx(2.0)]]
    load = places(packed["load"], len(unpacked(packed["t"])))[:, 0]
    for spot, q in ((load[0], LOADED.q[0]), (load[-1], LOADED.q[-1])):
        assert spot == pytest.approx((PANDA.pose(q) @ (0.0, 0.0, 0.1, 1.0))[:3], abs=1e-3)
    assert data_of(written(panda_run(), tmp_path))["runs"][0]["arm"]["load"] is None


def test_a_load_that_is_put_down_is_gone(tmp_path: Path) -> None:
    plant = sa.Plant(PANDA.with_payload(1.5), changes=[(0.4, PANDA)])
    tracker = sa.ComputedTorque(PANDA, 100, 20)
    run = sa.simulate(plant, tracker, sa.Quintic(START, START + 0.1, 0.5), 1.0, control_period=1e-3,
                      q0=START)  # fmt: skip
    packed = data_of(written(run, tmp_path))["runs"][0]["arm"]
    assert packed["masses"] == [[0.0, pytest.approx(1.5)], [pytest.approx(0.4), 0.0]]
    t = unpacked(packed["t"])
    there = np.isfinite(places(packed["load"], len(t))[:, 0]).all(axis=1)
    assert np.array_equal(there, t < 0.4 - 1e-3)


def test_runs_side_by_side_have_names_and_one_scale(tmp_path: Path) -> None:
    bare = panda_run()
    data = data_of(written(LOADED, tmp_path, against={"bare": bare, "again": bare}))
    assert [run["name"] for run in data["runs"]] == ["computed torque", "bare", "again"]
    data = data_of(written(LOADED, tmp_path, against=bare))
    assert [run["name"] for run in data["runs"]] == ["computed torque", "computed torque (2)"]
    low, high = data["room"]
    for run in (LOADED, bare):
        tips = np.array([chain(PANDA, q) for q in run.q[::40]]).reshape(-1, 3)
        assert (tips >= np.array(low) - 1e-3).all() and (tips <= np.array(high) + 1e-3).all()


def without_scene(run: sa.Run) -> sa.Run:
    return replace(run, status=run.status)


def one_row() -> sa.Run:
    run = panda_run(duration=0.01)
    return replace(run, **{name: array[:1] for name, array in run.to_dict().items()})


def twelve() -> sa.Run:
    arm = sa.Serial.from_dh(
        a=[0.1] * 12, alpha=[0.0, 1.57] * 6, d=[0.05] * 12, mass=1.0, inertia=0.01,
        kind=[*["revolute"] * 11, "prismatic"],
    )  # fmt: skip
    rest = (np.full(12, 0.1), np.zeros(12), np.zeros(12))
    return sa.simulate(sa.Plant(arm), sa.ComputedTorque(arm, 100, 20), lambda t: rest, 0.1)


def interrupted() -> sa.Run:
    run = panda_run(duration=0.1)
    status = sa.Status("interrupted", 0.1, "Ctrl-C was pressed")
    return replace(run, status=status)


def unresolved() -> sa.Run:
    run = panda_run(duration=0.1)
    vars(run)["status"] = sa.Status("unresolved", 0.1, "dt is too long")
    return run


ODD: dict[str, tuple[Callable[[], sa.Run], tuple[str, ...]]] = {
    "diverged": (diverged, ("diverged at t = 0.6 s", "look swapped")),
    "interrupted": (interrupted, ("interrupted at t = 0.1 s because Ctrl-C was pressed",)),
    "unresolved": (unresolved, ("finished, but not resolved: dt is too long",)),
    "motion": (lambda: panda_run(record="motion"), ("the motion alone was recorded",)),
    "one row": (one_row, ("1 row of 7 joints", "give arm= to see it")),
    "without a scene": (lambda: without_scene(PAPER), ("give arm= to see it",)),
    "twelve joints": (twelve, ("101 rows of 12 joints",)),
    "few rows": (lambda: panda_run(record_every=300), ("5 rows of 7 joints",)),
    "error control": (
        lambda: panda_run(method="dp54", control_period=None, dt=1e-2),
        ("101 rows of 7 joints",),
    ),
}


@pytest.mark.parametrize("kind", ODD)
def test_a_run_of_any_kind_makes_a_page_that_says_what_it_is(kind: str, tmp_path: Path) -> None:
    make, words = ODD[kind]
    run = make()
    text = written(run, tmp_path)
    told = "".join(words for tag, words in Page(text).texts if tag not in ("script", "style"))
    for word in words:
        assert word in told
    (packed,) = data_of(text)["runs"]
    assert len(packed["curves"]["e"]) == run.joints
    assert len(packed["curves"]["tau"]) == (run.joints if len(run.tau) else 0)
    assert (packed["arm"] is None) == (run.scene is None)
    assert packed["status"] == run.status.kind
    Page(run._repr_html_())


def test_an_arm_that_is_given_moves_a_run_that_does_not_know_its_own(tmp_path: Path) -> None:
    data = data_of(written(one_row(), tmp_path, arm=PANDA))
    packed = data["runs"][0]["arm"]
    assert places(packed["actual"], 1)[0] == pytest.approx(chain(PANDA, START), abs=1e-5)
    assert [joint["name"] for joint in data["joints"]] == PANDA.joint_names


def test_prismatic_joints_are_in_millimetres(tmp_path: Path) -> None:
    text = written(twelve(), tmp_path)
    assert [joint["length"] for joint in data_of(text)["joints"]] == ["rad"] * 11 + ["m"]
    assert "[mrad or mm]" in text and "[N·m or N]" in text


def test_a_wild_run_leaves_room_for_the_other(tmp_path: Path) -> None:
    wild, sane = diverged(), sa.paper.simulation(2).run(duration=1.0)
    first, second = data_of(written(wild, tmp_path, against={"sane": sane}))["runs"]
    for name in CURVES:
        for joint in range(2):
            most = np.abs(getattr(sane, name)[:, joint]).max()
            assert max(map(abs, first["curves"][name][joint][:2])) <= 3.001 * most
            assert max(map(abs, second["curves"][name][joint][:2])) == pytest.approx(most, rel=1e-5)


def test_the_figures_are_those_of_the_run_and_need_no_script(tmp_path: Path) -> None:
    page = Page(written(LOADED, tmp_path))
    cells = [float(str(each["title"])) for each in page.of("td")]
    metrics = LOADED.metrics()
    assert cells[:7] == pytest.approx(1e3 * metrics.rms_e, rel=1e-5)
    assert cells[-7:] == pytest.approx(metrics.torque_variation, rel=1e-5)
    assert len(cells) == 7 * 7 and {each.get("scope") for each in page.of("th")} == {"col", "row"}


def test_names_and_notes_are_text_and_nothing_else(tmp_path: Path) -> None:
    run = replace(PAPER, notes=HOSTILE)
    bare = without_scene(panda_run(duration=0.01))
    text = written(bare, tmp_path, against={name: bare for name in HOSTILE})
    names = [each["name"] for each in data_of(text)["runs"]]
    assert len(set(names)) == len(HOSTILE) + 1 and HOSTILE[0] in names
    for content in (text, written(run, tmp_path), run._repr_html_()):
        page = Page(content)
        assert not [each for each in page.elements if each[0] in ("b", "x", "img")]
        assert not {"\x00", "\x1b", "\u202e"} & set(content)
    assert len(Page(text).of("script")) == 2


def test_joint_names_are_text_and_nothing_else(tmp_path: Path) -> None:
    class Hostile:
        """Kinematics of the Panda with joints that somebody named."""

        joints, joint_kinds = 7, PANDA.joint_kinds
        name = HOSTILE[0]
        pose, link_poses = PANDA.pose, PANDA.link_poses

    run = panda_run(duration=0.01)
    parts = run._made.parts | {"joint_names": list(HOSTILE[:7])}  # type: ignore[union-attr]
    vars(run)["_scene"] = replace(run._made, parts=parts)  # type: ignore[type-var]
    text = written(run, tmp_path, arm=Hostile())
    assert data_of(text)["joints"][0]["name"] == HOSTILE[0]
    page = Page(text)
    assert len(page.of("script")) == 2
    assert not [each for each in page.elements if each[0] in ("b", "x", "img")]


def test_a_notebook_gets_the_page_in_a_frame_of_its_own() -> None:
    for run in (LOADED, without_scene(PAPER)):
        outer = Page(run._repr_html_())
        (frame,) = outer.of("iframe")
        assert frame["sandbox"] == "allow-scripts" and not outer.of("script")
        assert not [each for _, each in outer.elements if "id" in each]
        inner = str(frame["srcdoc"])
        assert data_of(inner)["runs"][0]["status"] == "finished"
        assert len(outer.of("table")) == 1 and not Page(inner).of("table")


def test_the_page_is_small() -> None:
    rows, joints = 12_001, 7
    random = np.random.default_rng(0)
    run = panda_run(duration=0.01)
    columns = {name: random.normal(size=(rows, joints)) for name in ("q", "q_d", "e", "tau")}
    vars(run).update(columns, t=np.linspace(0.0, 12.0, rows))
    data = _view_data.collected({"a": run, "b": run}, [PANDA, PANDA])
    assert len(json.dumps(data)) < 240_000
    many = _view_data.collected({str(k): run for k in range(12)}, [PANDA] * 12)
    assert len(json.dumps(many)) < 280_000


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"arm": 3}, TypeError, "arm: got int, wants a TwoLink or a Serial"),
        ({"arm": sa.paper.nominal()}, ValueError, "arm: got 2 joints, wants 7"),
        ({"against": 3}, TypeError, "against: got int, wants a Run, or Runs by name"),
        ({"against": {"x": 3}}, TypeError, "against\\['x'\\]: got int, wants a Run"),
        ({"against": PAPER}, ValueError, "against: got a run of 2 joints, wants 7"),
    ],
)
def test_what_makes_no_page_is_refused_and_the_old_one_stays(
    options: dict[str, Any], error: type[Exception], words: str, tmp_path: Path
) -> None:
    before = written(LOADED, tmp_path)
    with pytest.raises(error, match=f"^{words}"):
        LOADED.to_html(tmp_path / "run.html", **options)
    assert (tmp_path / "run.html").read_text(encoding="utf-8") == before
    assert [file.name for file in tmp_path.iterdir()] == ["run.html"]


def test_a_run_from_its_file_makes_the_same_page(tmp_path: Path) -> None:
    LOADED.save(tmp_path / "run.npz")
    loaded = sa.Run.load(tmp_path / "run.npz")
    assert written(loaded, tmp_path) == written(LOADED, tmp_path)


def test_the_page_needs_numpy_alone(tmp_path: Path) -> None:
    code = (
        "import sys; sys.modules['matplotlib'] = None\n"
        "import steadyarm as sa\n"
        "run = sa.paper.simulation(1).run(duration=0.1)\n"
        f"run.to_html({str(tmp_path / 'run.html')!r}); run._repr_html_()"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.skipif(shutil.which("node") is None, reason="node reads the script")
def test_the_script_is_a_script(tmp_path: Path) -> None:
    parts = [Path(sa.__file__).with_name(f"_{name}.js") for name in ("page", "view")]
    source = "".join(part.read_text(encoding="utf-8") for part in parts)
    (tmp_path / "script.js").write_text(source, encoding="utf-8")
    subprocess.run(["node", "--check", tmp_path / "script.js"], check=True)

"""A run is made again from its file, to the bit; and a scene in a file is hostile until known."""

from __future__ import annotations

import io
import json
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import steadyarm as sa
from run_files import RECORD, members, npy, pack, refused
from scenes import nominal, plant, run, tracker


def same(one: sa.Run, other: sa.Run) -> None:
    assert list(one.channels) == list(other.channels)
    for name in one.channels:
        assert np.array_equal(getattr(one, name), getattr(other, name)), name
    assert (one.status, one.certificate) == (other.status, other.certificate)
    for weights in ("weights", "dictionary"):
        np.testing.assert_equal(getattr(one, weights), getattr(other, weights))


def trained() -> sa.ComputedTorque:
    """One that does not start from nothing: weights, a prior, the last torque."""
    controller = tracker(limits={"effort_limit": (60, 40), "effort_rate_limit": 4e3}, leak_rate=0.1)
    random = np.random.default_rng(3)
    controller.warm_start(random.normal(size=(2, 625)))
    for _ in range(20):
        controller.step(*random.normal(size=(5, 2)), 1e-3)
    return controller


def table() -> sa.Table:
    t = np.linspace(0.0, 0.3, 40)
    return sa.Table(t, np.stack([np.sin(t), np.cos(t) - 1.0], axis=1))


def serial() -> sa.Run:
    arm = sa.Serial.shipped("ur5e")
    basis = sa.FuzzyBasis("per_joint", [-1.0, 0.0, 1.0], 0.5, inputs={"e": 2.0}, joints=6)
    controller = sa.ComputedTorque(arm, 20.0, 9.0, sa.FuzzyCompensator(basis, gain=50.0))
    loaded = arm.with_payload(2.0)
    goal = sa.Quintic(np.zeros(6), 0.3 * np.ones(6), 0.2)
    return sa.simulate(sa.Plant(loaded), controller, goal, 0.2, control_period=2e-3)


def kernel() -> sa.Run:
    basis = sa.FuzzyBasis("grid", [-1.0, 0.0, 1.0], 0.5)
    compensator = sa.FuzzyCompensator(basis, gain=7.0, dictionary=4, merge_tolerance=0.2)
    return run(sa.ComputedTorque(nominal(), 8, 5.5, compensator), duration=0.1, q0=(0.5, -0.5))


def runs() -> dict[str, sa.Run]:
    return {
        "continuous": run(tracker(), duration=0.1, q0=np.array([0.5, -0.5]), record_every=3),
        "sampled, from what was learnt": run(trained(), duration=0.1, control_period=2e-3),
        "error control": run(tracker(), duration=0.1, dt=1e-2, method="dp54", rtol=1e-6),
        "motion": run(tracker(), duration=0.1, record="motion"),
        "table": sa.simulate(plant(), tracker(), table(), 0.3),
        "alone": run(sa.ComputedTorque(nominal(), 8, 5.5), duration=0.1),
        "serial": serial(),
        "dictionary": kernel(),
    }


@pytest.mark.parametrize("name", runs())
def test_a_run_is_replayed_from_its_file_to_the_bit(name: str, tmp_path: Path) -> None:
    record, path = runs()[name], tmp_path / "run.npz"
    record.save(path)
    loaded = sa.Run.load(path)
    same(loaded, record)
    same(sa.replay(path), record)
    same(record.replay(), record)
    assert loaded.scene == record.scene
    again = tmp_path / "again.npz"
    loaded.save(again)
    same(sa.replay(again), record)
    same(pickle.loads(pickle.dumps(record)).replay(), record)


def test_a_file_says_what_the_run_was_made_with(tmp_path: Path) -> None:
    record, path = serial(), tmp_path / "run.npz"
    record.save(path)
    loaded = sa.Run.load(path)
    scene = loaded.scene
    assert scene is not None
    assert scene["steadyarm"] == sa.__version__
    assert loaded.joint_names == sa.Serial.shipped("ur5e").joint_names == scene["joint_names"]
    controller = scene["tracker"]["ComputedTorque"]
    assert (controller["kp"], controller["kv"]) == ([20.0] * 6, [9.0] * 6)
    arm = sa.Serial.from_toml(controller["arm"]["Serial"])
    assert arm.to_toml() == sa.Serial.shipped("ur5e").to_toml()
    assert scene["plant"]["Plant"]["arm"] != controller["arm"]
    assert scene["options"]["control_period"] == 2e-3 and scene["options"]["dt"] == 1e-3
    assert RECORD.joint_names == ["1", "2"]


def circle(t: float) -> tuple[np.ndarray, ...]:
    s, c = np.sin(t), np.cos(t)
    return np.array([s, c]), np.array([c, -s]), np.array([-s, -c])


def drag(q: np.ndarray, dq: np.ndarray, t: float) -> np.ndarray:
    return 0.5 * dq


def test_callables_are_asked_for(tmp_path: Path) -> None:
    path = tmp_path / "run.npz"
    dragged = sa.Plant(sa.paper.actual(), drag)
    record = sa.simulate(dragged, tracker(), circle, 0.05)
    record.save(path)
    scene = sa.Run.load(path).scene
    assert scene is not None and scene["reference"] == {"callable": "circle"}
    for given, name in (({}, "disturbance"), ({"disturbance": drag}, "reference")):
        why = rf"^{name}: it was a callable, \w+, which no file keeps; give {name}="
        with pytest.raises(ValueError, match=why):
            sa.replay(path, **given)
    same(sa.replay(path, reference=circle, disturbance=drag), record)
    same(record.replay(), record)
    same(pickle.loads(pickle.dumps(record)).replay(reference=circle, disturbance=drag), record)


def test_a_run_without_a_scene_is_not_replayed(tmp_path: Path) -> None:
    path = tmp_path / "run.npz"
    parts = members(path)
    del parts["scene.npy"], parts["start.npy"]
    pack(path, list(parts.items()))
    loaded = sa.Run.load(path)
    assert loaded.scene is None and loaded.joint_names == ["1", "2"]
    with pytest.raises(ValueError, match=r"^run: got one without its scene"):
        loaded.replay()


def scene_of(parts: dict[str, bytes]) -> dict[str, Any]:
    text: dict[str, Any] = json.loads(bytes(np.load(io.BytesIO(parts["scene.npy"]))))
    return text


def packed(path: Path, change: dict[str, Any]) -> None:
    parts = members(path)
    text = json.dumps(scene_of(parts) | change).encode()
    parts["scene.npy"] = npy(np.frombuffer(text, np.uint8))
    pack(path, list(parts.items()))


SCENES: list[tuple[str, dict[str, Any], str]] = [
    ("a key more", {"surplus": 1}, "scene: got"),
    ("a joint more", {"joint_names": ["1", "2", "3"]}, "joint_names: got"),
    ("names that are none", {"joint_names": 2}, "joint_names: got 2"),
    ("a name that moves the cursor", {"joint_names": ["\x1b[2J", "2"]}, "scene: got"),
    ("a version that is none", {"steadyarm": 3}, "scene: got 3"),
    ("no plant", {"plant": None}, "plant: got None"),
    ("options of others", {"options": {"duration": 1.0}}, "options: got"),
    ("NaN", {"reference": {"Sines": float("nan")}}, "scene: got NaN"),
]


@pytest.mark.parametrize(("change", "why"), [row[1:] for row in SCENES], ids=[r[0] for r in SCENES])
def test_wrong_scene_is_refused(change: dict[str, Any], why: str, tmp_path: Path) -> None:
    path = tmp_path / "run.npz"
    packed(path, change)
    refused(path, why)


@pytest.mark.parametrize(
    "content",
    [
        np.zeros(3), np.zeros((2, 2), np.uint8), np.frombuffer(b"[" * 100_000, np.uint8),
        np.frombuffer(b"\xff\xfe", np.uint8), np.frombuffer(b'{"a": {}, "a": {}}', np.uint8),
        np.array("x"), np.zeros(0, np.uint8),
    ],
)  # fmt: skip
def test_scene_that_is_no_text_is_refused(content: np.ndarray, tmp_path: Path) -> None:
    path = tmp_path / "run.npz"
    pack(path, list((members(path) | {"scene.npy": npy(content)}).items()))
    refused(path, "")


@pytest.mark.parametrize("name", ["scene", "start"])
def test_half_a_scene_is_refused(name: str, tmp_path: Path) -> None:
    path = tmp_path / "run.npz"
    parts = members(path)
    del parts[f"{name}.npy"]
    pack(path, list(parts.items()))
    refused(path, "scene: got one of scene and start")


ARM = {"TwoLink": {"mass": [4, 4], "length": [0.5, 0.5], "inertia": [0.2, 0.2]}}
BUILT: list[tuple[str, dict[str, Any]]] = [
    ("a file for TOML", {"plant": {"Plant": {"arm": {"Serial": "/dev/zero"}}}}),
    ("another class", {"plant": {"Popen": {"args": "true"}}}),
    ("a class that is no plant", {"plant": ARM}),
    ("a negative mass", {"plant": {"Plant": {"arm": {"TwoLink": ARM["TwoLink"] | {"mass": -1}}}}}),
    ("an unknown argument", {"plant": {"Plant": {"arm": ARM, "x": 1}}}),
    ("an object for a number", {"plant": {"Plant": {"arm": ARM, "effort_limit": ARM}}}),
    ("another tracker", {"tracker": {"ComputedTorque": {"arm": ARM, "kp": 8, "kv": 5}}}),
    ("no reference", {"reference": {"TwoLink": ARM["TwoLink"]}}),
    ("a mapping as reference", {"reference": {"a": 1, "b": 2}}),
]


@pytest.mark.parametrize("change", [row[1] for row in BUILT], ids=[row[0] for row in BUILT])
def test_scene_that_cannot_be_built_is_refused(change: dict[str, Any], tmp_path: Path) -> None:
    """The record is whole, so the run loads; its scene is built when it is replayed."""
    path = tmp_path / "run.npz"
    packed(path, change)
    loaded = sa.Run.load(path)
    with pytest.raises(ValueError, match=r"got|wants"):
        loaded.replay()


def test_state_of_another_controller_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "run.npz"
    other = members(tmp_path / "other.npz", run(tracker("shared"), duration=0.01))
    parts = members(path) | {"start.npy": other["start.npy"]}
    pack(path, list(parts.items()))
    with pytest.raises(ValueError, match="rules: got 5 entries, wants 625"):
        sa.replay(path)


OWN: list[tuple[str, dict[str, Any], dict[str, Any], str]] = [
    ("one that is missing", {}, {"seen": {"unit": "1", "shape": [], "doc": "x"}}, "own: got"),
    ("one that is not told of", {"own.x": np.zeros(11)}, {}, "own: got"),
    ("a name that is taken", {"own.q": np.zeros(11)}, {"q": {}}, "own"),
    ("the name of a method", {"own.save": np.zeros(11)}, {"save": {}}, "own"),
    ("a hidden name", {"own._x": np.zeros(11)}, {"_x": {}}, "own"),
    ("rows too few", {"own.x": np.zeros(10)}, {"x": {}}, r"own\.x: got shape \(10,\)"),
    ("joints too many", {"own.x": np.zeros((11, 3))}, {"x": {}}, r"own\.x: got shape \(11, 3\)"),
    ("a cube", {"own.x": np.zeros((11, 2, 1))}, {"x": {}}, r"own\.x: got float64"),
    ("NaN", {"own.x": np.full(11, np.nan)}, {"x": {}}, r"own\.x\[0\]: got nan"),
    ("no unit", {"own.x": np.zeros(11)}, {"x": {"unit": 3}}, "unit: got 3"),
    ("another shape", {"own.x": np.zeros(11)}, {"x": {"shape": [2]}}, "shape: got"),
    ("no shape", {"own.x": np.zeros(11)}, {"x": {"shape": 3}}, ""),
    ("words that move the cursor", {"own.x": np.zeros(11)}, {"x": {"doc": "\x1b[2J"}}, "doc: got"),
]


@pytest.mark.parametrize(
    ("arrays", "told", "why"), [row[1:] for row in OWN], ids=[row[0] for row in OWN]
)
def test_wrong_signal_of_its_own_is_refused(
    arrays: dict[str, Any], told: dict[str, Any], why: str, tmp_path: Path
) -> None:
    """One that is right loads; each of the others has one thing that is not."""
    path = tmp_path / "run.npz"
    right = {"unit": "1", "shape": [], "doc": "x"}
    for parts_of, words, wanted in (
        ({"own.x": np.zeros(11)}, {"x": {}}, None),
        (arrays, told, why),
    ):
        parts = members(path)
        meta = json.loads(str(np.load(io.BytesIO(parts["meta.npy"]))))
        meta["own"] = {name: right | change for name, change in words.items()}
        parts["meta.npy"] = npy(json.dumps(meta))
        parts |= {f"{name}.npy": npy(array) for name, array in parts_of.items()}
        pack(path, list(parts.items()))
        if wanted is None:
            assert np.array_equal(sa.Run.load(path).x, np.zeros(11))  # type: ignore[attr-defined]
        else:
            refused(path, wanted)


def test_what_is_done_to_an_argument_later_changes_no_replay() -> None:
    start = np.array([0.5, -0.5])
    controller = tracker()
    record = run(controller, duration=0.05, q0=start)
    start[:] = 7.0
    controller.warm_start(np.ones((2, 625)))
    same(record.replay(), record)


def test_options_of_every_kind_of_number_are_kept(tmp_path: Path) -> None:
    path = tmp_path / "run.npz"
    options: dict[str, Any] = {"q0": 0.1, "dq0": (0, 1), "record_every": np.int64(2)}
    record = run(tracker(), duration=np.float32(0.25), dt=np.array(1 / 1024), **options)
    record.save(path)
    same(sa.replay(path), record)

"""Choices that do nothing or ruin a run are said by `design`, and once by `simulate`."""

from __future__ import annotations

import pickle
import warnings
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import steadyarm as sa
from friction_scenes import arm as arm_of


@dataclass
class Scene:
    """A sound design of a chain; a test breaks one thing of it."""

    joints: int = 2
    inputs: Any = "reference"
    form: str = "grid"
    centers: Any = None
    width: float = 0.6
    offset: float = 0.2
    kp: Any = 60.0
    kv: Any = 15.0
    fuzzy: dict[str, Any] = field(default_factory=dict)
    limit: Any = None
    plant_limit: Any = None
    q0: Any = None
    callable_: bool = False

    def parts(self) -> tuple[sa.Plant, sa.ComputedTorque, Any]:
        n = np.arange(1, self.joints + 1)
        arm = sa.Serial.from_dh(
            a=0.4, alpha=np.pi / 2 * (n % 2), d=0.1, mass=4.0 / n,
            com=np.tile([-0.2, 0.0, 0.0], (self.joints, 1)),
            inertia=np.tile([0.01, 0.05, 0.05], (self.joints, 1)), armature=0.2,
        )  # fmt: skip
        centers = [-0.8, 0.0, 0.8] if self.centers is None else self.centers
        basis = sa.FuzzyBasis(self.form, centers, self.width, True, self.inputs)
        fuzzy = sa.FuzzyCompensator(basis, **{"gain": 200.0} | self.fuzzy)
        tracker = sa.ComputedTorque(arm, self.kp, self.kv, fuzzy, effort_limit=self.limit)
        there = sa.Plant(arm.perturb(3, mass=0.3), None, self.plant_limit)
        sines = sa.Sines(1.0, 0.3 / n, 0.2 / n, np.full(self.joints, self.offset))
        return there, tracker, (lambda t: sines(t)) if self.callable_ else sines

    def start(self) -> Any:
        *_, path = self.parts()
        return path(0.0)[0] if self.q0 is None else self.q0

    def findings(self) -> tuple[str, ...]:
        plant, tracker, path = self.parts()
        duration = 2 * np.pi if self.callable_ else None
        report = sa.design(tracker, path=path, plant=plant, duration=duration)
        return report.findings

    def run(self, **options: Any) -> tuple[sa.Run, list[str]]:
        """A run, and the warnings that it gave."""
        plant, tracker, path = self.parts()
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            options = {
                "duration": 2.0,
                "dt": 2e-3,
                "control_period": 2e-3,
                "q0": self.start(),
            } | options
            run = sa.simulate(plant, tracker, path, **options)
        assert all(w.category is sa.DesignWarning for w in caught)
        return run, [str(w.message) for w in caught]


KERNEL = {"dictionary": 12, "merge_tolerance": 0.01, "gain": 200.0}

# What is broken, and what must be said of it; and the nearest choice that is not broken.
BROKEN = {
    "dead_zone": ({"fuzzy": {"dead_zone": 50.0}}, "dead_zone: 50 is above the signal"),
    "dead_zone_of_error": (
        {"fuzzy": {"dead_zone": 9.0}, "inputs": "error", "joints": 1},
        "dead_zone: 9 is above the signal",
    ),
    "projection": (
        {"fuzzy": {"projection_radius": 0.05}},
        "projection_radius: 0.05 is below what is to be learnt",
    ),
    "dictionary": ({"fuzzy": KERNEL, "width": 0.05}, "dictionary: 12 states are too few"),
    "dictionary_of_error": (
        {"inputs": "error", "kp": 5.0, "kv": 4.5, "fuzzy": KERNEL | {"dictionary": 1, "q": 0.5}},
        "dictionary: 1 states are too few",
    ),
    "centers": ({"offset": 6.0}, "centers: the input q_d of joint"),
    "centers_apart": (
        {"centers": [-3.0, -2.5, 2.5, 3.0], "width": 0.3},
        "centers: the input q_d of joint",
    ),
    "narrow_sets": (
        {"centers": [-3.0, -1.4, 1.4, 3.0], "width": 0.1, "inputs": "trajectory"},
        "centers: the input q_d of joint",
    ),
    "centers_of_error": (
        {"inputs": "error", "centers": [3.0, 4.0, 5.0]},
        "centers: the input e of joint",
    ),
    "centers_of_three_joints": (
        {"joints": 3, "form": "per_joint", "inputs": "trajectory", "offset": -7.0},
        "centers: the input q_d of joint",
    ),
    "start": ({"q0": [2.0, 0.0]}, "q0: joint 1 starts"),
    "effort": ({"limit": [0.05, 100.0]}, "effort_limit: joint 1 has 0.05"),
    "effort_of_plant": ({"plant_limit": [500.0, 0.1]}, "effort_limit: joint 2 has 0.1"),
    "swapped": ({"kp": 15.0, "kv": 60.0, "fuzzy": {"q": 0.1}}, "kp = 15 and kv = 60 look swapped"),
    "swapped_in_one": (
        {"kp": [60.0, 12.0], "kv": [15.0, 60.0], "fuzzy": {"q": 0.1}},
        "joint 2: kp = 12 and kv = 60 look swapped",
    ),
}
SOUND = {
    "defaults": {},
    "error": {"inputs": "error"},
    "three_joints": {"joints": 3, "form": "per_joint", "inputs": "trajectory"},
    "one_joint": {"joints": 1},
    "small_dead_zone": {"fuzzy": {"dead_zone": 1e-3}},
    "wide_ball": {"fuzzy": {"projection_radius": 1e3}},
    "wide_dictionary": {"fuzzy": KERNEL | {"dictionary": 400}},
    "dictionary_of_error": {"inputs": "error", "fuzzy": KERNEL | {"dictionary": 40}},
    "coarse_dictionary": {"fuzzy": KERNEL | {"dictionary": 60, "merge_tolerance": 0.1}},
    "near_start": {"q0": [0.0, 0.0]},
    "strong": {"limit": 200.0, "plant_limit": 200.0},
    "critical": {"kp": 100.0, "kv": 20.0},
    "overdamped": {"kp": 25.0, "kv": 25.0, "fuzzy": {"q": 0.1}},
}


@pytest.mark.parametrize("name", [name for name in BROKEN if name != "start"])
def test_a_choice_that_ruins_it_is_said_by_the_report(name: str) -> None:
    changes, words = BROKEN[name]
    assert any(words in finding for finding in Scene(**changes).findings())


@pytest.mark.parametrize("callable_", [False, True], ids=["built-in", "callable"])
@pytest.mark.parametrize("period", [None, 2e-3], ids=["continuous", "sampled"])
@pytest.mark.parametrize("name", BROKEN)
def test_a_choice_that_ruins_it_is_said_once_by_a_run(
    name: str, period: float | None, callable_: bool
) -> None:
    changes, words = BROKEN[name]
    run, caught = Scene(**changes, callable_=callable_).run(
        control_period=period, duration=8.0 if callable_ else 1.0
    )
    assert len(caught) == 1 and words in caught[0], caught
    assert any(words in note for note in run.notes) and len(set(run.notes)) == len(run.notes)


@pytest.mark.parametrize("name", SOUND)
def test_nothing_is_said_of_sound_choices(name: str) -> None:
    scene = Scene(**SOUND[name])
    run, caught = scene.run()
    assert not caught and not run.notes
    assert not any(": " in f and f.split(":")[0] in NAMES for f in scene.findings())


NAMES = ("dead_zone", "projection_radius", "dictionary", "centers", "q0", "effort_limit")


def test_notes_stay_with_a_run_in_files_and_pickles(tmp_path: Path) -> None:
    run, _ = Scene(offset=6.0).run()
    assert run.notes
    run.save(tmp_path / "run.npz")
    assert sa.Run.load(tmp_path / "run.npz").notes == run.notes
    assert pickle.loads(pickle.dumps(run)).notes == run.notes


def test_a_callable_is_called_no_more_often_than_the_run_needs() -> None:
    plant, tracker, path = Scene().parts()
    calls: dict[bool, int] = {}
    for noted in (False, True):
        count = [0]

        def counted(t: float, count: list[int] = count) -> Any:
            count[0] += 1
            return path(t)

        q0 = path(0.0)[0] + (2.0 if noted else 0.0)
        with warnings.catch_warnings(record=True):
            warnings.simplefilter("always")
            run = sa.simulate(plant, tracker, counted, 0.1, control_period=1e-3, q0=q0)
        assert bool(run.notes) == noted
        calls[noted] = count[0]
    assert calls[False] == calls[True] == 101


def test_a_signal_below_the_dead_zone_learns_nothing_and_one_above_it_does() -> None:
    """The signal that the report gives is the edge: dead zones at 1.3 and 0.5 times it."""
    report = Scene(fuzzy={"dead_zone": 50.0}).findings()
    (said,) = (finding for finding in report if finding.startswith("dead_zone"))
    signal = float(said.split("stays below ")[1].split(" ")[0])
    norms = {}
    for times in (1.3, 0.5):
        scene = Scene(fuzzy={"dead_zone": times * signal})
        plant, tracker, path = scene.parts()
        # From what computed torque alone settles at, so that no start is learnt from.
        alone = sa.ComputedTorque(tracker.arm, tracker.kp, tracker.kv)
        settled = sa.simulate(plant, alone, path, 2 * np.pi // 2e-3 * 2e-3, 2e-3, q0=scene.start())
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            run = sa.simulate(plant, tracker, path, 6.0, 2e-3, q0=settled.q[-1], dq0=settled.dq[-1])
        assert run.weights is not None
        norms[times] = np.abs(run.weights).max()
    assert norms[1.3] < 1e-3 * norms[0.5], norms


def test_gravity_above_the_limit_is_told_from_a_path_that_is_too_fast() -> None:
    plant, _, path = Scene().parts()
    held = max(abs(plant.arm.gravity(path(t)[0])[1]) for t in np.linspace(0.0, 6.3, 64))
    weak = Scene(limit=[1e3, 0.9 * held]).findings()
    assert any("joint 2" in f and "gravity alone takes" in f for f in weak)
    # The first axis is vertical: what it takes is the motion's.
    moved = Scene(limit=[0.05, 1e3]).findings()
    assert any("joint 1" in f and "the path takes" in f for f in moved)
    assert not any("effort_limit" in f for f in Scene(limit=[1e3, 3.0 * held]).findings())


def test_without_a_path_gravity_is_held_against_the_limit_over_poses() -> None:
    panda = sa.Serial.shipped("panda")
    most = np.full(7, 87.0)
    for limit in (None, most, np.array([87.0] * 4 + [12.0] * 3)):
        assert not sa.design(sa.ComputedTorque(panda, 100.0, 20.0, effort_limit=limit)).findings
    most[1] = 5.0
    (said,) = sa.design(sa.ComputedTorque(panda, 100.0, 20.0, effort_limit=most)).findings
    assert said.startswith("effort_limit: joint 2 has 5.0000 N·m, and gravity in some poses takes")


@pytest.mark.parametrize("capacity", [8, 30, 120, 400])
def test_a_dictionary_that_is_called_too_small_drops_states_in_a_run(capacity: int) -> None:
    scene = Scene(fuzzy=KERNEL | {"dictionary": capacity})
    run, caught = scene.run(duration=2 * np.pi // 2e-3 * 2e-3)
    assert run.dictionary is not None
    said = any("dictionary:" in words for words in caught)
    assert said == (run.dictionary["dropped"] > 0), run.dictionary


def test_a_dead_wrist_is_said_by_the_report_with_its_stiffness() -> None:
    """The UR10 of example-robot-data: 0.0005 kg m² at kp = 400 are 0.2 N·m/rad."""
    arm = arm_of("ur10").without_friction()
    for chosen in (None, sa.FuzzyCompensator(sa.FuzzyBasis("per_joint", [-1.0, 0.0, 1.0], 0.5))):
        report = sa.design(sa.ComputedTorque(arm, 400.0, 40.0, chosen))
        wrist = report.stiffness[5]
        assert np.isclose(wrist, 400.0 * arm.mass_matrix(np.zeros(6))[5, 5], rtol=1e-6)
        assert 0.1 < wrist < 0.4
        assert any("joint 6: it is hardly held" in f for f in report.findings)
        assert not any("joint 1: it is hardly held" in f for f in report.findings)
    rotors = arm.with_armature(0.4)
    report = sa.design(sa.ComputedTorque(rotors, 400.0, 40.0))
    assert not any("hardly held" in f for f in report.findings)

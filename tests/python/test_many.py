"""Many runs in one call: each is that of `simulate`, to the bit."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
import steadyarm as sa
from law_scenes import TWO, H, made, nominal, plant
from many_scenes import (
    LATE,
    NOISY,
    T,
    alone,
    assert_same,
    bits,
    called,
    fuzzy,
    guarded,
    heavier,
    many,
    path,
)
from test_effects import EVERYTHING
from test_own_controllers import Springs

TABLE = sa.Table([0.0, T], [[0.2, 0.2], [0.3, 0.1]], [[1.0, 0.0], [1.0, 0.0]], [[0, 0], [0, 0]])
OTHER: dict[str, list[Any]] = {
    "plant": [heavier(5.0), plant(TWO), sa.Plant(nominal(TWO), sa.Noise((1.0, 2.0), 40.0, 3))],
    "tracker": [fuzzy(), made("pid", TWO), made("slotine_li", TWO), guarded(), Springs()],
    "reference": [called, sa.Quintic((0, 0), (0.1, 0.2), 0.05), TABLE],
    "q0": [[0.1, 0.2], [0.2, 0.2], [0.3, -0.1]],
    "dq0": [(0.0, 0.0), (0.5, 0.2)],
    "effects": [
        None,
        NOISY,
        sa.Effects(delay=2, noise=1e-4),
        sa.Effects(velocity="kalman", noise=1e-4),
    ],
}


@pytest.mark.filterwarnings("ignore::steadyarm.DesignWarning")
@pytest.mark.parametrize("name", OTHER)
def test_each_run_is_that_of_simulate(name: str) -> None:
    values = OTHER[name]
    runs = many(**{name: values}, window=LATE, band=0.02)
    assert_same(runs, [alone(**{name: value}) for value in values], LATE, 0.02)
    assert len({tuple(row) for row in runs.rms_e}) == len(values)


@pytest.mark.filterwarnings("ignore::steadyarm.DesignWarning")
@pytest.mark.parametrize("effect", [name for name in EVERYTHING if name != "seed"])
def test_each_effect_is_that_of_simulate(effect: str) -> None:
    gears = {"joint_stiffness": 2e4, "joint_damping": 5.0, "rotor_inertia": 0.1}
    needs = gears if effect in {*gears, "backlash"} else {}
    needs = needs | ({"velocity": "difference"} if effect == "velocity_cutoff" else {})
    effects = sa.Effects(**(needs | {effect: EVERYTHING[effect], "seed": 4}))
    assert_same(many(effects=effects), [alone(effects=effects)])
    assert (many(effects=effects).rms_tau != many().rms_tau).any()


@pytest.mark.filterwarnings("ignore::steadyarm.DesignWarning")
@pytest.mark.parametrize(
    "options",
    [
        {"control_period": None},
        {"control_period": None, "method": "dp54", "rtol": 1e-5, "atol": 1e-7},
        {"control_period": 2e-3, "record_every": 3},
    ],
    ids=["continuous", "error control", "sampled"],
)
def test_methods_are_those_of_simulate(options: dict[str, Any]) -> None:
    runs = many(**options, plant=[heavier(4.5), heavier(7.0)])
    assert_same(runs, [alone(**options, plant=heavier(mass)) for mass in (4.5, 7.0)])


def test_a_chain_with_names_of_joints_is_that_of_simulate() -> None:
    arm = sa.Serial.shipped("panda").with_armature(0.1)
    q = np.array([0.1, 0.2, 0.0, -1.8, 0.1, 1.6, 0.2])
    parts: dict[str, Any] = {"plant": sa.Plant(arm), "reference": sa.Quintic(q, q + 0.2, 0.05)}
    tracker = sa.laws.computed_torque(arm, bandwidth=10.0, control_period=H)
    runs = many(**parts, tracker=tracker, q0=[q, q + 0.01])
    assert_same(runs, [alone(**parts, tracker=tracker, q0=start) for start in (q, q + 0.01)])
    assert runs.joints == 7 and runs.joint_names[3] == "panda_joint4"


def test_names_of_joints_that_differ_are_their_numbers() -> None:
    arm = sa.Serial.from_dh([0.5, 0.5], 0.0, 0.0, mass=4.0, inertia=0.1)
    runs = many(plant=[sa.Plant(arm), plant(TWO)])
    assert runs.joint_names == ("1", "2")
    assert runs.metrics(0).joint_names == tuple(arm.joint_names) != ("1", "2")
    assert runs.metrics(1).joint_names == ("1", "2")


def test_seeds_are_those_of_the_effects_of_each_run() -> None:
    tracker, seeds = made("pid", TWO, delay=1, velocity_filter=60.0), np.array([5, 0, 2**40])
    runs = many(tracker=tracker, effects=NOISY, seeds=seeds)
    effects = [sa.Effects(**(EVERYTHING | {"seed": int(seed)})) for seed in seeds]
    assert_same(runs, [alone(tracker=tracker, effects=it) for it in effects])
    assert len(set(runs.rms_e[:, 0])) == 3


def changed_tracker(**more: Any) -> sa.ComputedTorque:
    compensator = fuzzy().compensator
    return fuzzy().__replace__(compensator=compensator.__replace__(**more))


def test_changes_are_of_the_objects_that_their_names_lead_to() -> None:
    mild = sa.Effects(delay=0)
    basis = sa.FuzzyBasis("grid", (-1.0, 0.0, 1.0), 0.9)
    changes: list[dict[str, Any]] = [
        {},
        {"plant.arm.mass": (7, 7), "q0": (0.1, 0.0), "dq0": np.array([0.3, 0.0])},
        {"tracker.compensator.gain": 50.0, "tracker.compensator.basis.width": 0.9},
        {"effects.noise": 1e-4, "effects.seed": 3, "effects.encoder_bits": 12},
        {"plant.arm.mass": (8, 8), "plant": heavier(3.0), "plant.arm.gravity": 9.0},
        {"reference": called, "tracker": made("pid", TWO), "tracker.law.bandwidth": 9.0},
        {"effects": None, "reference.offset": (0.1, 0.2)},
    ]
    pid = made("pid", TWO)
    late = plant(TWO).arm.__replace__(mass=(8, 8), gravity=9.0)
    others: list[dict[str, Any]] = [
        {},
        {"plant": heavier(7.0), "q0": (0.1, 0.0), "dq0": (0.3, 0.0)},
        {"tracker": changed_tracker(gain=50.0, basis=basis)},
        {"effects": sa.Effects(noise=1e-4, seed=3, encoder_bits=12)},
        {"plant": heavier(3.0).__replace__(arm=late)},
        {"reference": called, "tracker": pid.__replace__(law={**pid.law, "bandwidth": 9.0})},
        {"effects": None, "reference": path().__replace__(offset=(0.1, 0.2))},
    ]
    runs = many(effects=mild, changes=changes)
    assert_same(runs, [alone(**({"effects": mild} | other)) for other in others])
    assert len({tuple(row) for row in runs.rms_e}) == len(changes)


@dataclasses.dataclass
class Spring:
    """A controller of one's own with an argument."""

    stiffness: float = 100.0

    def step(self, q: Any, dq: Any, q_d: Any, dq_d: Any, ddq_d: Any, dt: float) -> np.ndarray:
        return -self.stiffness * (q - q_d) - 20.0 * (dq - dq_d)


def test_changes_reach_into_a_controller_of_ones_own() -> None:
    runs = many(tracker=Spring(), changes=[{"tracker.stiffness": k} for k in (50.0, 150.0)])
    assert_same(runs, [alone(tracker=Spring(k)) for k in (50.0, 150.0)])


def test_a_controller_of_ones_own_is_given_the_arm_of_each_plant() -> None:
    plants = [heavier(5.0), heavier(6.0)]
    runs = many(tracker=Springs(), plant=plants, record="motion")
    assert [run.tracker.arm for run in runs if run.tracker] == [it.arm for it in plants]


def test_changes_of_lists_are_of_the_object_of_their_run() -> None:
    plants = [heavier(5.0), heavier(6.0)]
    runs = many(plant=plants, changes=[{"plant.arm.gravity": 9.0}, {}])
    arm = plants[0].arm.__replace__(gravity=9.0)
    assert_same(runs, [alone(plant=it) for it in (plants[0].__replace__(arm=arm), plants[1])])


MIXED: dict[str, Any] = {
    "plant": [heavier(mass) for mass in (4.2, 5.0, 6.5, 4.2, 8.0)],
    "reference": [path(), called, path(), called, path()],
    "tracker": [fuzzy(), Springs(), guarded(), made("pid", TWO), fuzzy(delay=0)],
    "effects": sa.Effects(noise=1e-4, drop=0.1),
    "seeds": [3, 1, 4, 1, 5],
}


@pytest.mark.parametrize("start", [0.1, [0.1, 0.2], np.array([0.1, 0.2])], ids=repr)
def test_a_start_may_be_that_of_all_runs(start: Any) -> None:
    runs = many(q0=start, dq0=start, plant=[heavier(5.0), heavier(6.0), heavier(7.0)])
    singles = [alone(q0=start, dq0=start, plant=heavier(mass)) for mass in (5.0, 6.0, 7.0)]
    assert_same(runs, singles)
    assert len(many(q0=start)) == 1


@pytest.mark.parametrize("threads", [1, 2, 3, None])
def test_the_bits_are_the_same_for_any_threads_and_order(threads: int | None) -> None:
    wanted = many(**MIXED, threads=1)
    order = [3, 0, 4, 2, 1]
    mixed = {
        name: [it[n] for n in order] if isinstance(it, list) else it for name, it in MIXED.items()
    }
    runs = many(**mixed, threads=threads)
    assert [bits(runs.metrics(k)) for k in range(5)] == [bits(wanted.metrics(n)) for n in order]


@pytest.mark.parametrize("record", ["all", "motion"])
def test_records_are_the_runs_of_simulate(record: Any) -> None:
    options: dict[str, Any] = {"record": record, "effects": sa.Effects(delay=1), "record_every": 2}
    runs = many(**options, q0=[(0.2, 0.2), (0.4, 0.1)], tracker=[fuzzy(), Springs()])
    for index, (q0, tracker) in enumerate([((0.2, 0.2), fuzzy()), ((0.4, 0.1), Springs())]):
        with pytest.warns(sa.DesignWarning, match="delay"):
            single = alone(**options, q0=q0, tracker=tracker)
        run = runs[index]
        assert list(run.channels) == list(single.channels)
        for name in run.channels:
            assert getattr(run, name).tobytes() == getattr(single, name).tobytes(), name
        assert (run.status, run.notes, run.scene) == (single.status, single.notes, single.scene)
    assert [len(run.t) for run in runs] == [31, 31] and runs[-1] is runs[1]
    with pytest.raises(IndexError, match=r"run: got 2, wants 0 to 1"):
        runs[2]


def test_figures_of_a_record_of_the_motion_are_those_of_all_signals() -> None:
    kept, bare = many(record="motion"), many()
    assert bits(kept.metrics(0)) == bits(bare.metrics(0)) == bits(alone().metrics())


def test_without_a_record_there_are_figures_alone() -> None:
    runs = many()
    for look in (lambda: runs[0], lambda: list(runs)):
        with pytest.raises(ValueError, match=r"record: got None.* wants record='motion' or 'all'"):
            look()
    with pytest.raises(IndexError, match=r"run: got -2, wants 0 to 0"):
        runs.metrics(-2)


def test_what_is_given_stays_as_it_was_and_runs_begin_with_what_was_learnt() -> None:
    taught, own = alone().tracker, Springs()
    assert isinstance(taught, sa.ComputedTorque) and taught.weights is not None
    before = taught.weights.copy()
    runs = many(tracker=[taught, own, own, taught])
    assert_same(
        runs, [alone(tracker=taught), *([alone(tracker=Springs())] * 2), alone(tracker=taught)]
    )
    assert (taught.weights == before).all() and own.told == []
    assert (runs.rms_e[0] != many().rms_e[0]).any()


def test_a_run_ends_when_that_of_simulate_does_to_the_bit() -> None:
    assert 700 * 1e-3 != 0.7
    runs, run = many(duration=0.7, changes=[{}] * 9), alone(duration=0.7)
    assert {status.t for status in runs.status} == {run.status.t} == {run.t[-1]}

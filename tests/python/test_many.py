"""Many runs in one call: each is that of `simulate`, to the bit, and ends alone."""

from __future__ import annotations

import dataclasses
import math
import os
import pickle
import re
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import steadyarm as sa
from law_scenes import TWO, H, made, nominal, plant, reference
from steadyarm._stopping import stopped_by
from steadyarm.metrics import NAMES
from steadyarm.record import Status
from test_effects import EVERYTHING
from test_own_controllers import Breaks, Springs

PATIENCE = 60
"""Far more than a child needs to notice a signal [s]."""

T = 0.06
LATE = (0.02, 0.05)
LOOP: dict[str, Any] = {"duration": T, "dt": H, "control_period": H}


def path() -> sa.Sines:
    return reference(TWO)  # type: ignore[return-value]


def called(t: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    return path()(t)


def heavier(mass: float) -> sa.Plant:
    return plant(TWO).__replace__(arm=plant(TWO).arm.__replace__(mass=(mass, mass)))


def fuzzy(**more: Any) -> sa.ComputedTorque:
    basis = sa.FuzzyBasis("grid", (-1.0, 0.0, 1.0), 0.7)
    compensator = sa.FuzzyCompensator(basis, gain=7.0)
    return sa.ComputedTorque(nominal(TWO), 64.0, 16.0, compensator, **more)


def guarded() -> sa.Guard:
    return sa.Guard(fuzzy(), H, velocity_limit=8.0, effort_limit=60.0, deceleration=10.0)


def many(**options: Any) -> sa.Runs:
    given = {"plant": plant(TWO), "tracker": fuzzy(), "reference": path()} | LOOP | options
    return sa.simulate_many(**given)


def alone(**options: Any) -> sa.Run:
    given = {"plant": plant(TWO), "tracker": fuzzy(), "reference": path()} | LOOP | options
    return sa.simulate(**given)


def bits(figures: sa.Metrics) -> list[bytes]:
    return [getattr(figures, name).tobytes() for name in NAMES]


def assert_same(
    runs: sa.Runs, singles: list[sa.Run], window: Any = None, band: float = 0.01
) -> None:
    """Figures, words and ends of many runs are those of as many calls of `simulate`."""
    assert len(runs) == len(singles)
    for index, single in enumerate(singles):
        found, wanted = runs.metrics(index), single.metrics(window, band)
        assert bits(found) == bits(wanted), index
        assert (found.joint_names, found.units) == (wanted.joint_names, wanted.units)
        assert runs.status[index] == single.status
    for name in NAMES:
        values = getattr(runs, name)
        assert values.shape == (len(singles), runs.joints) and values.dtype == np.float64


NOISY = sa.Effects(**EVERYTHING)
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
    assert runs.metrics(0).joint_names == tuple(arm.joint_names)


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


def wild() -> sa.ComputedTorque:
    """It samples far too slowly for this damping."""
    return sa.ComputedTorque(nominal(TWO), 64.0, 4000.0)


def test_a_run_that_diverges_ends_alone() -> None:
    trackers = [fuzzy(), wild(), fuzzy()]
    runs = many(tracker=trackers, duration=0.5, record="all")
    single = alone(tracker=wild(), duration=0.5)
    assert single.status.kind == "diverged" and 0 < single.status.t < 0.5
    assert_same(runs, [alone(duration=0.5), single, alone(duration=0.5)])
    assert runs.finished.tolist() == [True, False, True]
    assert runs[1].tau.tobytes() == single.tau.tobytes()
    late = many(tracker=trackers, duration=0.5, window=(0.4, 0.5))
    assert np.isnan(late.rms_e[1]).all() and np.isnan(late.max_abs_tau[1]).all()
    assert bits(late.metrics(2)) == bits(alone(duration=0.5).metrics((0.4, 0.5)))


def test_a_run_that_is_not_resolved_has_figures_and_is_not_finished() -> None:
    scene = sa.paper.simulation(2)
    runs = sa.simulate_many(scene.plant, scene.tracker, scene.reference, 40.0, 1.0)
    assert_same(runs, [scene.run(duration=40.0, dt=1.0)])
    assert runs.status[0].kind == "unresolved" and not runs.finished[0]


def test_a_callable_that_raises_loses_its_run_alone() -> None:
    def reference_of(limit: float) -> Callable[[float], Any]:
        def reference(t: float) -> Any:
            if t > limit:
                raise ZeroDivisionError("no more")
            return called(t)

        return reference

    references = [reference_of(1.0), reference_of(0.03), reference_of(1.0)]
    runs = many(reference=references, record="all")
    assert [it.kind for it in runs.status] == ["finished", "raised", "finished"]
    assert runs.status[1].reason == "ZeroDivisionError: no more"
    assert 0.02 < runs.status[1].t < 0.04
    assert all(np.isnan(getattr(runs, name)[1]).all() for name in NAMES)
    assert bits(runs.metrics(2)) == bits(alone(reference=called).metrics())
    assert runs[1].status == runs.status[1] and 20 < len(runs[1].t) < 40
    assert "raised at t = " in str(runs.status[1])


@pytest.mark.parametrize("error", [SystemExit(3), MemoryError()], ids=repr)
def test_whatever_a_controller_raises_is_its_reason(error: BaseException) -> None:
    runs = many(tracker=[Springs(), Breaks(5, error)])
    said = f"{type(error).__name__}: {error}".removesuffix(": ")
    assert [(it.kind, it.reason) for it in runs.status] == [("finished", ""), ("raised", said)]
    assert_same(many(tracker=[Springs()]), [alone(tracker=Springs())])


def test_keyboard_interrupt_of_a_callback_interrupts_its_run() -> None:
    runs = many(tracker=[Springs(), Breaks(5, KeyboardInterrupt())], record="all", threads=1)
    assert [it.kind for it in runs.status] == ["finished", "interrupted"]
    assert np.isnan(runs.rms_e[1]).all() and runs.status[1].t == pytest.approx(5 * H)
    assert runs[1].tau.tobytes() == alone(tracker=Breaks(5, KeyboardInterrupt())).tau.tobytes()


def test_a_job_that_is_stopped_interrupts_its_runs() -> None:
    stop = threading.Event()
    stop.set()
    with stopped_by(stop):
        runs = many(duration=9000.0, changes=[{}] * 20, threads=2)
    assert {it.kind for it in runs.status} == {"interrupted"}
    assert runs.status[-1] == Status(
        "interrupted", 0.0, "it was stopped from the keyboard before it began"
    )


ONE: dict[str, tuple[Any, str]] = {
    "threads of 0": ({"threads": 0}, r"threads: got 0, wants a whole number >= 1"),
    "threads of 1.5": ({"threads": 1.5}, r"threads: got 1.5, wants a whole number >= 1"),
    "record": ({"record": "some"}, r"record: got 'some', wants 'motion', 'all' or None"),
    "band": ({"band": 0.0}, r"band: got 0.0, wants a number > 0"),
    "window behind": ({"window": (1, 2)}, r"window: got \(1, 2\), wants \(from, to\) within 0 to"),
    "window turned": ({"window": (0.05, 0.01)}, r"window: got .*, wants \(from, to\) within"),
    "window of NaN": ({"window": (math.nan, 1.0)}, r"window: got .*, wants \(from, to\) within"),
    "no runs": ({"changes": []}, r"changes: got no runs, wants at least 1"),
    "no plants": ({"plant": []}, r"plant: got no runs, wants at least 1"),
    "two lengths": (
        {"plant": [plant(TWO)] * 3, "q0": np.zeros((2, 2))},
        r"q0: got 2 runs, wants 3, as plant has",
    ),
    "seeds and changes": (
        {"seeds": [1, 2], "effects": sa.Effects(), "changes": [{}]},
        r"seeds: got 2 runs, wants 1, as changes has",
    ),
    "seeds twice": (
        {"seeds": [1], "effects": sa.Effects(), "changes": [{"effects.seed": 3}]},
        r"seeds: got changes of 'effects.seed' beside them",
    ),
    "seeds of nothing": ({"seeds": [1]}, r"seeds: got effects=None, wants Effects"),
    "a seed below 0": (
        {"seeds": [1, -1], "effects": sa.Effects()},
        r"seeds: got -1 for run 1, wants whole numbers",
    ),
    "a seed of half": (
        {"seeds": [0.5], "effects": sa.Effects()},
        r"seeds: got 0.5 for run 0, wants whole numbers",
    ),
    "changes of what is the same": (
        {"changes": [{}, {"dt": 1e-4}]},
        r"changes: got 'dt' for run 1, wants one of plant, tracker, reference, effects, q0, dq0",
    ),
    "changes of no argument": (
        {"changes": [{"plant.arm.weight": 3.0}]},
        r"changes: got 'plant.arm.weight' for run 0; plant.arm is a TwoLink, which has mass, len",
    ),
    "changes of no law": (
        {"tracker": made("pid", TWO), "changes": [{"tracker.law.kq": 3.0}]},
        r"law: unknown field `kq`, .*\nsteadyarm: for run 0, changes of tracker: law",
    ),
    "changes of None": (
        {"changes": [{"effects.noise": 3.0}]},
        r"changes: got 'effects.noise' for run 0; effects is None, wants all of it",
    ),
    "changes within a guard": (
        {"tracker": guarded(), "changes": [{"tracker.slack": 3.0}]},
        r"changes: got 'tracker.slack' for run 0; tracker is a Guard, wants all of it",
    ),
    "changes within a chain": (
        {
            "plant": sa.Plant(sa.Serial.shipped("panda")),
            "changes": [{"plant.arm.mass": 3.0}],
        },
        r"changes: got 'plant.arm.mass' for run 0; plant.arm is a Serial, wants all of it",
    ),
    "changes to what cannot be": (
        {"changes": [{"plant.arm.mass": -3.0}]},
        r"mass\[0\]: got -3, wants a number > 0\nsteadyarm: for run 0, changes of plant.arm: mass",
    ),
    "joints of plants": (
        {"plant": [plant(TWO), sa.Plant(sa.Serial.shipped("panda"))]},
        r"plant: got one of 7 joints for run 1, wants 2, as run 0 has",
    ),
    "joints of the tracker": (
        {"plant": sa.Plant(sa.Serial.shipped("panda"))},
        r"plant: got one of 7 joints, wants 2, as the tracker has",
    ),
    "a start of three": ({"q0": np.zeros((4, 3))}, r"q0: got shape \(3,\), wants a scalar or \(2,"),
    "starts of three": ({"q0": np.zeros((1, 1, 2))}, r"q0: got shape .*, wants \(n,\) or \(M, n\)"),
    "dt": ({"dt": -1e-3}, r"dt: got "),
    "effects without a period": (
        {"effects": sa.Effects(delay=1), "control_period": None},
        r"control_period: got 0, wants a period",
    ),
}


def told(caught: pytest.ExceptionInfo[BaseException]) -> str:
    return "\n".join([str(caught.value), *getattr(caught.value, "__notes__", ())])


@pytest.mark.parametrize(("options", "message"), ONE.values(), ids=ONE)
def test_what_makes_no_sense_is_refused(options: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError) as caught:
        many(**options)
    assert re.match(message, told(caught)), told(caught)


OF_TYPE: dict[str, tuple[Any, str]] = {
    "plant": ({"plant": [plant(TWO), nominal(TWO)]}, r"plant: got TwoLink for run 1, wants a Plan"),
    "tracker": ({"tracker": [fuzzy(), 3]}, r"tracker: got int, wants a Controller"),
    "reference": ({"reference": "sines"}, r"reference: got str"),
    "effects": ({"effects": [{}]}, r"effects: got dict"),
    "changes": ({"changes": {"q0": 1}}, r"changes: got .*, wants a list with one a run"),
    "changes of a run": ({"changes": [3]}, r"changes: got 3 for run 0, wants a dict"),
    "seeds": ({"seeds": 3, "effects": NOISY}, r"seeds: got 3, wants a list with one a run"),
    "window": ({"window": 3.0}, r"window: got 3.0, wants \(from, to\)"),
    "band": ({"band": "wide"}, r"band: got str, wants real numbers"),
    "duration": ({"duration": "long"}, r"duration: got str, wants real numbers"),
    "q0": ({"q0": "home"}, r"q0: got str, wants real numbers"),
    "q0 of other lengths": ({"q0": [[1.0, 2.0], [3.0]]}, r"q0: got list, wants real numbers"),
}


@pytest.mark.parametrize(("options", "message"), OF_TYPE.values(), ids=OF_TYPE)
def test_what_is_of_another_type_is_refused(options: dict[str, Any], message: str) -> None:
    with pytest.raises(TypeError, match=f"^{message}"):
        many(**options)


def some() -> sa.Runs:
    trackers = [fuzzy(), Breaks(5, RuntimeError("<no> more")), wild(), made("pid", TWO)]
    return many(tracker=trackers, duration=0.5, record="motion")


def test_the_table_has_a_row_a_run_in_columns() -> None:
    runs = some()
    table = runs.table()
    assert list(table)[:5] == ["status", "t_end", "reason", "rms_e_1", "rms_e_2"]
    assert len(table) == 3 + 2 * len(NAMES) and {it.shape for it in table.values()} == {(4,)}
    assert table["status"].tolist() == ["finished", "raised", "diverged", "finished"]
    assert table["reason"][1] == "RuntimeError: <no> more"
    assert table["t_end"].tolist() == [it.t for it in runs.status]
    for name in NAMES:
        for joint in (0, 1):
            assert table[f"{name}_{joint + 1}"].tobytes() == getattr(runs, name)[:, joint].tobytes()
    table["rms_e_1"][0] = 7.0
    assert runs.rms_e[0, 0] != 7.0


def test_pandas_has_the_same_table() -> None:
    pytest.importorskip("pandas")
    runs = some()
    frame, table = runs.to_pandas(), runs.table()
    assert list(frame.columns) == list(table) and frame.index.name == "run"
    assert (frame["itae_2"].to_numpy()[[0, 3]] == table["itae_2"][[0, 3]]).all()
    assert frame.attrs["units"]["itae_2"] == "rad·s²"


def test_printed_it_counts_the_ends_and_has_median_and_worst_of_what_finished() -> None:
    runs = some()
    lines = str(runs).splitlines()
    assert lines[0] == "4 runs of 2 joints: 2 finished, 1 raised, 1 diverged"
    assert repr(runs) == f"Runs({lines[0]})"
    finished = runs.rms_e[[0, 3]]
    said = [line.split()[-2:] for line in lines if line.split()[0] == "rms_e"]
    wanted = [[f"{x:.6g}" for x in row] for row in (finished.mean(axis=0), finished.max(axis=0))]
    assert said == wanted
    page = runs._repr_html_()
    assert "1 × raised: RuntimeError: &lt;no&gt; more" in page and "RMS error, worst" in page


def test_without_a_run_that_finished_it_prints_the_ends() -> None:
    runs = many(tracker=Breaks(0, RuntimeError("no")))
    assert str(runs) == "1 runs of 2 joints: 1 raised"
    assert "RuntimeError: no" in runs._repr_html_()


def test_runs_pickle_with_their_records() -> None:
    runs = some()
    twin = pickle.loads(pickle.dumps(runs))
    assert twin.status == runs.status and bits(twin.metrics(0)) == bits(runs.metrics(0))
    assert twin[0].q.tobytes() == runs[0].q.tobytes()


def test_the_bar_counts_the_runs(capsys: pytest.CaptureFixture[str]) -> None:
    many(changes=[{}] * 3, progress=True)
    assert "3 of 3 runs" in capsys.readouterr().err
    many(changes=[{}] * 3)
    assert capsys.readouterr().err == ""


START = """
import threading, time
import steadyarm as sa
scene = sa.paper.simulation(2)
def slow(t):
    if t > 0 and not told.is_set():
        told.set()
        print("ready", flush=True)
    time.sleep(PAUSE)
    return scene.reference(t)
told = threading.Event()
runs = sa.simulate_many(
    scene.plant, scene.tracker, REFERENCES, DURATION, threads=THREADS, record="motion",
    record_every=100, progress=True,
)
for n, status in enumerate(runs.status):
    print(status.kind, runs.rms_e[n, 0] > 0, runs.rms_e[n, 0] != runs.rms_e[n, 0], status.reason)
kept = [run for run in runs._records if run is not None]
print(len(kept), all(len(run.t) for run in kept))
print(scene.run(duration=0.1).status)
"""


def stopped(**values: Any) -> list[str]:
    """What a child prints that is stopped from the keyboard while a slow run is on its way."""
    code = START
    for name, value in values.items():
        code = code.replace(name, str(value))
    with subprocess.Popen(
        [sys.executable, "-u", "-W", "error", "-c", code],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as child:
        assert child.stdout is not None
        try:
            assert child.stdout.readline() == "ready\n"
            child.send_signal(signal.SIGINT)
            out, errors = child.communicate(timeout=PATIENCE)
        finally:
            child.kill()
    assert child.returncode == 0, errors
    assert out.endswith("\nfinished\n")
    return out.splitlines()[:-1]


BEFORE = "interrupted False True it was stopped from the keyboard before it began"
AMID = BEFORE.removesuffix(" before it began")


@pytest.mark.skipif(os.name != "posix", reason="signals are sent as on Unix")
def test_interrupt_keeps_the_runs_that_are_finished() -> None:
    references = "[scene.reference, scene.reference, slow, scene.reference]"
    lines = stopped(REFERENCES=references, DURATION=0.2, PAUSE=0.2, THREADS=1)
    assert lines == ["finished True False "] * 2 + [AMID, BEFORE, "3 True"]


@pytest.mark.skipif(os.name != "posix", reason="signals are sent as on Unix")
def test_interrupt_ends_all_runs_that_are_on_their_way() -> None:
    references = "[slow, scene.reference, scene.reference, scene.reference]"
    lines = stopped(REFERENCES=references, DURATION=90000.0, PAUSE=0.0, THREADS=2)
    assert lines == [AMID, AMID, BEFORE, BEFORE, "2 True"]

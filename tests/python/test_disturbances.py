"""Disturbances beyond curves: pulses, noise, a wrench at the tip, and their sums."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import steadyarm as sa

PULSES = sa.Pulses([1.0, 1.5], [[1, 2], [3, 4]], [0.25, np.inf])
NOISE = sa.Noise((0.5, 0.2), cutoff=5.0, seed=3)
WRENCH = sa.Wrench(force=(5, -20, 0), moment=(0, 0, 0.5))
HIT = sa.Wrench(curve=sa.Pulses(1.0, (0, -20, 0, 0, 0, 0), 0.5, "half_sine"))
ALL = [PULSES, NOISE, WRENCH, HIT]


def torque(disturbance: Any, t: float, arm: sa.Arm | None = None) -> np.ndarray:
    """τ_d, from what a short step does to an arm at rest under no torque."""
    arm, h = arm or sa.paper.nominal(), 1e-6
    q = np.linspace(0.4, -0.9, arm.joints)
    _, dq = sa.Plant(arm, disturbance).step(q, 0 * q, arm.gravity(q), t, h)
    return -arm.mass_matrix(q) @ dq / h


@pytest.mark.parametrize("disturbance", ALL, ids=lambda it: type(it).__name__)
def test_each_is_its_arguments(disturbance: Any) -> None:
    copy = pickle.loads(pickle.dumps(disturbance))
    assert copy == disturbance
    assert hash(copy) == hash(disturbance)
    names = {"sa": sa, "inf": np.inf, **{name: getattr(sa, name) for name in sa.__all__}}
    assert eval(repr(disturbance), names) == disturbance
    assert disturbance not in [other for other in ALL if other is not disturbance]


def test_pulses_begin_and_end() -> None:
    for t, wanted in [(0.9, (0, 0)), (1.1, (1, 2)), (1.3, (0, 0)), (2.0, (3, 4)), (50.0, (3, 4))]:
        assert torque(PULSES, t) == pytest.approx(wanted, abs=1e-4)


def test_noise_is_the_same_for_one_seed_and_another_for_another() -> None:
    times = (0.0, 0.37, 12.0)
    first = [torque(NOISE, t) for t in times]
    assert np.array_equal(first, [torque(sa.Noise((0.5, 0.2), 5.0, 3), t) for t in times])
    other = [torque(sa.Noise((0.5, 0.2), 5.0, 4), t) for t in times]
    assert np.abs(np.subtract(first, other)).min() > 1e-3


def test_a_push_downwards_is_the_torque_of_its_lever() -> None:
    arm = sa.paper.nominal()
    q = np.linspace(0.4, -0.9, 2)
    # 20 N downwards at the tip: 20 N times the horizontal distance of each joint, with the arm.
    levers = arm.pose(q)[0, 3] - arm.link_poses(q)[:, 0, 3]
    assert torque(sa.Wrench((0, -20, 0)), 0.0) == pytest.approx(20 * levers, abs=1e-3)
    assert torque(sa.Wrench(moment=(3, 2, 0.5)), 0.0) == pytest.approx([-0.5, -0.5], abs=1e-4)
    assert torque(HIT, 1.25) == pytest.approx(20 * levers, abs=1e-3)


def test_a_list_adds_up_and_a_callable_may_be_in_it() -> None:
    def own(q: np.ndarray, dq: np.ndarray, t: float) -> np.ndarray:
        return np.array([0.25, -t])

    several = [*ALL, own, sa.paper.disturbance()]
    for t in (0.5, 1.1):
        wanted = np.sum([torque(it, t) for it in several], axis=0)
        assert torque(several, t) == pytest.approx(wanted, abs=1e-3)
    assert torque([], 1.0) == pytest.approx((0, 0))


def test_what_a_callable_in_a_list_raises_comes_out() -> None:
    def fails(q: np.ndarray, dq: np.ndarray, t: float) -> np.ndarray:
        raise KeyError("lost")

    arm = sa.paper.nominal()
    plant = sa.Plant(arm, [NOISE, fails])
    with pytest.raises(KeyError, match="lost"):
        sa.simulate(plant, sa.ComputedTorque(arm, 8, 5.5), sa.paper.reference(), duration=0.1)


def test_a_run_under_several_is_saved_and_made_again(tmp_path: Path) -> None:
    arm = sa.paper.nominal()
    plant = sa.Plant(arm, ALL)
    tracker = sa.ComputedTorque(arm, 8, 5.5)
    run = sa.simulate(plant, tracker, sa.paper.reference(), duration=2.0, control_period=2e-3)
    run.save(tmp_path / "run.npz")
    assert np.array_equal(sa.replay(tmp_path / "run.npz").q, run.q)
    assert pickle.loads(pickle.dumps(plant)) == plant


def test_they_come_from_a_scenario() -> None:
    one = sa.read_scenario("[disturbance.noise]\ndeviation = [0.5, 0.2]\ncutoff = 5\nseed = 3")
    assert one["disturbance"] == NOISE
    several = sa.read_scenario("""
        [[disturbance]]
        [disturbance.pulses]
        time = [1.0, 1.5]
        torque = [[1, 2], [3, 4]]
        duration = [0.25, inf]
        [[disturbance]]
        [disturbance.wrench.curve.pulses]
        time = 1.0
        torque = [0, -20, 0, 0, 0, 0]
        duration = 0.5
        shape = "half_sine"
    """)
    assert several["disturbance"] == [PULSES, HIT]
    with pytest.raises(ValueError, match=r"disturbance\.noise: missing field `cutoff`"):
        sa.read_scenario("[disturbance.noise]\ndeviation = 1")


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: sa.Pulses(1, (1, 2), 0), r"duration\[0\]: got 0, wants a number > 0"),
        (lambda: sa.Pulses(np.nan, 1), r"time\[0\]: got NaN, wants a finite number"),
        (lambda: sa.Pulses((1, 2), (1, 2)), r"torque: got shape \(2,\), wants \(2, n\)"),
        (lambda: sa.Pulses(1, 1, (1, 2)), "duration: got 2 entries, wants 1"),
        (lambda: sa.Pulses(1, 1, np.inf, "half_sine"), r"duration\[0\]: got inf, wants an end"),
        (lambda: sa.Pulses(1, 1, 1, "saw"), 'shape: got "saw", wants "rectangle" or "half_sine"'),
        (lambda: sa.Noise((1, -1), 1), r"deviation\[1\]: got -1, wants a number >= 0"),
        (lambda: sa.Noise(1, 0), "cutoff: got 0, wants a number > 0"),
        (lambda: sa.Noise(1, 1, -1), "seed: got -1, wants a whole number"),
        (lambda: sa.Wrench((1, 2)), r"force: got shape \(2,\), wants \(3,\)"),
        (lambda: sa.Wrench((1, 2, np.nan)), r"force\[2\]: got NaN, wants a finite number"),
        (lambda: sa.Wrench((1, 2, 3), curve=NOISE), "curve: got 1, wants none beside force"),
        (lambda: sa.Wrench(curve=NOISE), "deviation: got 2 entries, wants 6"),
        (lambda: sa.Plant(sa.paper.nominal(), sa.Noise((1, 2, 3), 1)), "disturbance: got one of 3"),
        (lambda: sa.Plant(sa.paper.nominal(), [PULSES, sa.Noise((1, 2, 3), 1)]), "of 3 joints"),
    ],
)
def test_what_cannot_be_is_refused(make: Any, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        make()


def test_what_is_no_disturbance_is_refused() -> None:
    arm = sa.paper.nominal()
    for wrong in (3, [3], "push", [[NOISE]]):
        with pytest.raises(TypeError, match="disturbance: got"):
            sa.Plant(arm, wrong)
    with pytest.raises(TypeError, match="curve: got Wrench, wants"):
        sa.Wrench(curve=WRENCH)
    with pytest.raises(TypeError, match="reference: got Noise, wants"):
        sa.simulate(sa.Plant(arm), sa.ComputedTorque(arm, 8, 5.5), NOISE, duration=1.0)

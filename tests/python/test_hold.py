"""The hold rule: what acted in a period is told by the next step; take-over; what is pending."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest
import steadyarm as sa
from scenes import ZERO, drive, nominal, samples, tracker
from steadyarm._scene import arguments


@pytest.mark.parametrize("period", [None, 1e-3, 5e-3])
def test_nothing_is_learnt_while_the_plants_actuators_saturate(period: float | None) -> None:
    scene = sa.paper.simulation(3, "claimed")
    plant = sa.Plant(sa.paper.actual(), disturbance=sa.paper.disturbance(), effort_limit=0.01)
    options: dict[str, Any] = {"control_period": period, "q0": (0.5, -0.5)}
    run = sa.simulate(plant, scene.tracker, scene.reference, 2.0, 1e-3, **options)
    assert run.weights_norm is not None and not run.weights_norm.any()
    assert run.tracker is not None and run.tracker.weights is not None
    assert not run.tracker.weights.any()


def test_a_loop_of_ones_own_that_tells_learns_nothing_from_a_torque_that_was_cut() -> None:
    for told in (True, False):
        controller, applied = tracker(gain=7000.0), None
        for sample in samples(50):
            tau = controller.step(*sample, 1e-3, applied=applied)
            # To look at the weights ends nothing: what acted can still be told.
            assert controller.weights is not None
            applied = np.clip(tau, -0.01, 0.01) if told else None
        controller.step(*samples(1)[0], 1e-3, applied=applied)
        learnt = np.linalg.norm(controller.weights)
        # The last period is as commanded until it is told.
        last = tracker(gain=7000.0)
        last.step(*samples(1)[0], 1e-3)
        assert (learnt == pytest.approx(np.linalg.norm(last.weights))) == told


def test_reading_changes_no_bit() -> None:
    controller = tracker("shared")
    drive(controller, samples(10))
    before = controller.__getstate__()
    assert controller.weights is not None and controller.dictionary is None
    assert (controller.frozen, controller.limited, controller.steps) == (False, False, 10)
    assert controller.__getstate__() == before


def test_what_is_pending_survives_a_pickle_and_can_be_told_there() -> None:
    for form in ("grid", "shared", "concat", "per_joint"):
        controller = tracker(form)
        drive(controller, samples(10))
        copy = pickle.loads(pickle.dumps(controller))
        for applied in (None, ZERO):
            one, other = pickle.loads(pickle.dumps(controller)), pickle.loads(pickle.dumps(copy))
            a, b = (it.step(*samples(1)[0], 1e-3, applied=applied) for it in (one, other))
            assert a.tobytes() == b.tobytes() and one.__getstate__() == other.__getstate__()


def test_a_frozen_controller_learns_the_period_before_and_no_other() -> None:
    frozen, free = tracker("shared"), tracker("shared")
    for controller in (frozen, free):
        drive(controller, samples(10))
    frozen.freeze()
    np.testing.assert_array_equal(frozen.weights, free.weights)
    drive(frozen, samples(10, seed=3))
    np.testing.assert_array_equal(frozen.weights, free.weights)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf], ids=str)
def test_an_impossible_applied_torque_is_refused_and_changes_nothing(bad: float) -> None:
    controller = tracker("shared")
    drive(controller, samples(3))
    before = controller.__getstate__()
    with pytest.raises(ValueError, match=r"^applied\[1\]: got"):
        controller.step(*[ZERO] * 5, 1e-3, applied=[0.0, bad])
    with pytest.raises(ValueError, match=r"^applied"):
        controller.step(*[ZERO] * 5, 1e-3, applied=np.zeros(3))
    with pytest.raises(TypeError, match=r"^applied"):
        controller.step(*[ZERO] * 5, 1e-3, applied="0")
    assert controller.__getstate__() == before


def panda(**options: Any) -> tuple[sa.ComputedTorque, sa.Serial, np.ndarray]:
    arm, q = sa.Serial.shipped("panda"), np.array([0, -0.6, 0, -2, 0, 1.6, 0.8])
    return sa.ComputedTorque(arm, kp=400, kv=40, effort_rate_limit=1000.0, **options), arm, q


def test_the_rate_limit_holds_for_the_first_sample() -> None:
    """From what holds the arm at rest, or from what is said to be on the robot."""
    zeros = np.zeros(7)
    for stated in (None, 5.0, np.linspace(-20, 20, 7)):
        controller, arm, q = panda(last_tau=stated)
        wanted = arm.gravity(q) if stated is None else stated * np.ones(7)
        for life in (controller, pickle.loads(pickle.dumps(controller)), controller):
            tau = life.step(q, zeros, q + 0.5, zeros, zeros, 1e-3)
            assert life.limited
            assert np.abs(tau - wanted).max() == pytest.approx(1.0, abs=1e-9)
            life.reset()
        controller.reset(last_tau=-3.0)
        tau = controller.step(q, zeros, q + 0.5, zeros, zeros, 1e-3)
        assert np.abs(tau + 3.0).max() == pytest.approx(1.0, abs=1e-9)


def test_what_a_tracker_was_built_with_is_part_of_new() -> None:
    made, fresh = (panda(last_tau=5.0)[0] for _ in range(2))
    q = np.zeros(7)
    made.step(q, q, q, q, q, 1e-3)
    made.reset(last_tau=9.0)
    made.reset()
    assert made.__getstate__() == fresh.__getstate__()
    assert list(arguments(made)["last_tau"]) == [5.0] * 7


@pytest.mark.parametrize("bad", [np.nan, np.inf, 1.1e10, [1.0, 2.0, 3.0]], ids=str)
def test_an_impossible_torque_at_take_over_is_refused(bad: Any) -> None:
    with pytest.raises(ValueError, match=r"^last_tau"):
        sa.ComputedTorque(nominal(), 8, 5.5, last_tau=bad)
    controller = tracker("shared")
    drive(controller, samples(3))
    before = controller.__getstate__()
    with pytest.raises(ValueError, match=r"^last_tau"):
        controller.reset(last_tau=bad)
    assert controller.__getstate__() == before


def test_freezing_ends_the_period_before_with_the_torque_that_is_told() -> None:
    controller, sample = tracker(gain=7000.0), samples(1)[0]
    tau = controller.step(*sample, 1e-3)
    before = controller.__getstate__()
    with pytest.raises(ValueError, match=r"^applied\[0\]: got NaN"):
        controller.freeze(applied=[np.nan, 0.0])
    assert controller.__getstate__() == before
    controller.freeze(applied=tau / 2)
    assert controller.frozen
    controller.step(*sample, 1e-3)
    assert not controller.weights.any()


def test_a_torque_that_a_step_gave_may_be_told() -> None:
    """However large: without limits the law may ask for more than any arm can have."""
    controller = tracker()
    tau = controller.step(ZERO, [1e10, 0], ZERO, ZERO, ZERO, 1e-3)
    assert np.abs(tau).max() > 1e10
    controller.step(ZERO, ZERO, ZERO, ZERO, ZERO, 1e-3, applied=tau)
    assert controller.steps == 2

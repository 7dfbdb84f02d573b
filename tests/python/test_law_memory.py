"""What laws remember: saved, loaded, reset, pickled and replayed to the bit, whatever happened."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import steadyarm as sa
from law_scenes import (
    CHAIN,
    EVERY,
    GAINS,
    LEARNING,
    OBSERVING,
    TWO,
    H,
    by_gains,
    driven,
    made,
    nominal,
    rows,
    simulated,
)  # fmt: skip
from steadyarm import laws

each = pytest.mark.parametrize(("name", "arm"), EVERY)
remembering = pytest.mark.parametrize(
    ("name", "arm"), [pair for pair in EVERY if pair[0] in LEARNING + OBSERVING]
)
FRONT = {"hand_over": 3.0, "velocity_filter": 80.0, "bumpless": 20.0, "delay": 2}
LIMITS = {"effort_limit": 5.0, "effort_rate_limit": 2000.0}


def plain(controller: sa.Controller, arm: str) -> None:
    driven(controller, rows(arm, 9))


def nothing(controller: sa.Controller, arm: str) -> None:
    """Before its first step."""


def cut(controller: sa.Controller, arm: str) -> None:
    """Drives let less through, and periods are as long as they come."""
    tau = np.zeros(controller.arm.joints)
    for k, sample in enumerate(rows(arm, 9)):
        elapsed = H * (1 + 0.2 * np.sin(k)) if k else None
        tau = controller.step(*sample, H, applied=np.clip(tau, -3, 3), elapsed=elapsed)


def frozen(controller: sa.Controller, arm: str) -> None:
    driven(controller, rows(arm, 5))
    try:
        controller.freeze()
    except TypeError:
        assert not controller.learns
    driven(controller, rows(arm, 4))


def again(controller: sa.Controller, arm: str) -> None:
    driven(controller, rows(arm, 5))
    controller.start_hand_over()


def refused(controller: sa.Controller, arm: str) -> None:
    driven(controller, rows(arm, 5))
    bad = [np.full(controller.arm.joints, np.nan), *rows(arm, 1)[0][1:]]
    with pytest.raises(ValueError, match="q"):
        controller.step(*bad, H)


HISTORIES: list[tuple[Callable[[sa.Controller, str], None], dict[str, Any]]] = [
    (nothing, FRONT), (plain, {}), (plain, FRONT), (plain, LIMITS), (cut, FRONT | LIMITS),
    (cut, {}), (frozen, {}), (again, FRONT), (refused, LIMITS),
]  # fmt: skip


@each
def test_saved_and_loaded_the_next_torques_are_the_same_to_the_bit(
    name: str, arm: str, tmp_path: Path
) -> None:
    for history, options in HISTORIES:
        options = options | {"control_period": H / 4} if "delay" in options else options
        controller, other = made(name, arm, **options), made(name, arm, **options)
        history(controller, arm)
        controller.save(tmp_path / "state")
        driven(other, rows(arm, 3, seed=5))  # what was there before is forgotten
        other.load(tmp_path / "state")
        assert other.steps == controller.steps and other.frozen == controller.frozen
        tau = driven(controller, rows(arm, 6, seed=1))
        assert (driven(other, rows(arm, 6, seed=1)) == tau).all(), history.__name__
        assert controller.__getstate__() == other.__getstate__()


@each
def test_a_reset_law_is_a_new_one_to_the_bit(name: str, arm: str) -> None:
    for history, options in HISTORIES:
        options = options | {"control_period": H / 4} if "delay" in options else options
        controller, new = made(name, arm, **options), made(name, arm, **options)
        history(controller, arm)
        controller.reset()
        assert controller.steps == 0 and not controller.frozen and not controller.limited
        assert controller.__getstate__() == new.__getstate__(), history.__name__
        assert (driven(controller, rows(arm, 6)) == driven(new, rows(arm, 6))).all()


@remembering
def test_what_a_law_remembers_matters(name: str, arm: str) -> None:
    """Or the tests above would say nothing."""
    controller, other = made(name, arm), made(name, arm)
    driven(controller, rows(arm, 9))
    driven(other, rows(arm, 9, seed=5))
    assert not (driven(controller, rows(arm, 4)) == driven(other, rows(arm, 4))).all()


@pytest.mark.parametrize(("name", "arm"), [pair for pair in EVERY if pair[0] in LEARNING])
def test_a_frozen_law_gives_the_same_torque_for_the_same_sample(name: str, arm: str) -> None:
    controller = made(name, arm)
    driven(controller, rows(arm, 9))
    controller.freeze()
    assert controller.frozen
    first = driven(controller, rows(arm, 9))
    same = driven(controller, rows(arm, 9)) == first
    # Adaptive computed torque goes on filtering the acceleration, which is no learning.
    assert same.all()
    controller.unfreeze()
    driven(controller, rows(arm, 9))
    assert not (driven(controller, rows(arm, 9)) == first).all()


@each
def test_half_way_through_a_run_it_can_be_saved(name: str, arm: str, tmp_path: Path) -> None:
    half = simulated(made(name, arm, **LIMITS), arm, steps=20)
    tracker = half.tracker
    tracker.save(tmp_path / "half")
    other = made(name, arm, **LIMITS)
    other.load(tmp_path / "half")
    rest = [simulated(it, arm, steps=20) for it in (tracker, other)]
    assert (rest[0].tau == rest[1].tau).all() and (rest[0].q == rest[1].q).all()


@pytest.mark.parametrize("name", laws.__all__)
def test_the_state_of_another_controller_is_refused(name: str, tmp_path: Path) -> None:
    controller = made(name, CHAIN)
    driven(controller, rows(CHAIN, 3))
    controller.save(tmp_path / "state")
    others = [made(name, CHAIN, bandwidth=11.0), by_gains(name, CHAIN)]
    others += [made(other, CHAIN) for other in laws.__all__ if other != name]
    # Where nothing is remembered a last torque is all there is: it has the size of any other's.
    for other in others:
        before = other.__getstate__()
        with pytest.raises(ValueError, match="state"):
            other.load(tmp_path / "state")
        assert other.__getstate__() == before


@pytest.mark.parametrize("name", laws.__all__)
def test_damaged_states_are_refused(name: str) -> None:
    controller = made(name, TWO if name != "natural_slotine_li" else CHAIN)
    state = controller.__getstate__()
    random = np.random.default_rng(0)
    for _ in range(20):
        damaged = bytearray(state)
        damaged[random.integers(len(state))] ^= 1 << random.integers(8)
        for bad in (bytes(damaged), state[: random.integers(len(state))], state + b"0"):
            with pytest.raises(ValueError):
                controller.__setstate__(bad)
    assert controller.__getstate__() == state


EFFECTS = sa.Effects(
    encoder_bits=16, noise=1e-5, velocity="difference", delay=1, jitter=0.2, drop=0.1, seed=3
)


@each
def test_a_run_is_saved_loaded_and_replayed_with_its_effects(
    name: str, arm: str, tmp_path: Path
) -> None:
    run = simulated(made(name, arm, delay=1), arm, steps=40, effects=EFFECTS)
    run.save(tmp_path / "run.npz")
    loaded = sa.Run.load(tmp_path / "run.npz")
    assert loaded.scene == run.scene
    assert loaded.scene["tracker"]["Controller"]["law"]["law"] == name
    for again in (run.replay(), loaded.replay(), pickle.loads(pickle.dumps(run)).replay()):
        for channel in run.channels:
            assert np.array_equal(getattr(again, channel), getattr(run, channel)), channel
        assert again.tracker.__getstate__() == run.tracker.__getstate__()


@each
def test_a_run_of_a_tracker_half_way_is_replayed_from_there(name: str, arm: str) -> None:
    tracker = simulated(made(name, arm), arm, steps=20).tracker
    run = simulated(tracker, arm, steps=20)
    assert (run.replay().tau == run.tau).all()


def test_law_and_gains_are_kept_apart_from_the_caller() -> None:
    law = {"law": "computed_torque", **GAINS["computed_torque"]}
    controller = sa.Controller(nominal(TWO), law)
    tau = driven(controller, rows(TWO, 3))
    law["kp"] = 1.0
    assert (driven(sa.Controller(nominal(TWO), controller.law), rows(TWO, 3)) == tau).all()
    again = pickle.loads(pickle.dumps(controller))
    again.reset()
    assert (driven(again, rows(TWO, 3)) == tau).all()


def test_computed_torque_has_a_law_too() -> None:
    tracker = sa.ComputedTorque(nominal(TWO), 64.0, 16.0)
    assert tracker.law["law"] == "computed_torque"

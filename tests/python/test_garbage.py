"""Cycles through objects of the extension are found: what holds a Python object shows it.

Without that, ``self.plant = Plant(arm, self.push)`` keeps itself alive for ever.
"""

from __future__ import annotations

import functools
import gc
import weakref
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import steadyarm as sa
from scenes import ZERO, actual, basis, nominal, tracker


class Rig:
    """An owner that can be watched, in a cycle with what it owns."""

    plant: Any
    record: Any

    def push(self, q: Any, dq: Any, t: float) -> Any:
        return ZERO

    def fail(self, q: Any, dq: Any, t: float) -> Any:
        raise RuntimeError("push")

    def desired(self, t: float) -> Any:
        return ZERO, ZERO, ZERO


def method(rig: Rig) -> Any:
    return sa.Plant(actual(), rig.push)


def closure(rig: Rig) -> Any:
    return sa.Plant(actual(), lambda q, dq, t: rig.push(q, dq, t))


def partial(rig: Rig) -> Any:
    return sa.Plant(actual(), functools.partial(Rig.push, rig))


def stepped(rig: Rig) -> Any:
    plant = sa.Plant(actual(), rig.push)
    plant.step(ZERO, ZERO, ZERO, 0.0, 1e-3)
    return plant


def raised(rig: Rig) -> Any:
    plant = sa.Plant(actual(), rig.fail)
    for _ in range(2):
        with pytest.raises(RuntimeError, match="push"):
            plant.step(ZERO, ZERO, ZERO, 0.0, 1e-3)
    return plant


def simulated(rig: Rig) -> Any:
    plant = sa.Plant(actual(), rig.push)
    rig.record = sa.simulate(plant, tracker("shared"), rig.desired, duration=0.01, dt=1e-3)
    return plant


def failed(rig: Rig) -> Any:
    plant = sa.Plant(actual(), rig.fail)
    with pytest.raises(RuntimeError, match="push"):
        sa.simulate(plant, tracker("shared"), rig.desired, duration=0.01, dt=1e-3)
    return plant


def shown(rig: Rig) -> Any:
    """A run that reports its progress to the rig."""
    plant = sa.Plant(actual(), rig.push)
    sa.simulate(plant, tracker("shared"), rig.desired, duration=0.01, dt=1e-3, progress=False)
    return plant


MAKERS = (
    method,
    closure,
    partial,
    stepped,
    raised,
    simulated,
    failed,
    shown,
)


@pytest.mark.parametrize("make", MAKERS, ids=lambda make: make.__name__)
def test_a_cycle_is_collected(make: Callable[[Rig], Any]) -> None:
    rig = Rig()
    rig.plant = make(rig)
    watched = weakref.ref(rig)
    del rig
    gc.collect()
    assert watched() is None


def test_every_class_that_holds_a_python_object_is_tracked() -> None:
    """The others hold numbers alone, and no cycle can lead through them."""
    x = np.zeros((5, 4))
    numbers = [
        nominal(),
        sa.Serial.shipped("ur5e"),
        sa.Sines((1.0,)),
        sa.Quintic([0, 0], [1, 1], 1.0),
        sa.Table([0, 1], np.zeros((2, 2))),
        basis(),
        sa.FuzzyCompensator(basis()),
        sa.FuzzyApproximator.fit(basis("shared"), x, x),
        sa.care([[0.0]], [[1.0]], [[1.0]], [[1.0]]),
    ]
    for held in numbers:
        assert gc.get_referents(held) in ([], [type(held)]), held
    for holder in (sa.Plant(actual(), Rig().push), tracker("shared")):
        assert gc.is_tracked(holder)
        assert any(isinstance(held, tuple) for held in gc.get_referents(holder)), holder


def test_a_plant_that_is_in_use_keeps_its_callable() -> None:
    rig = Rig()
    plant = sa.Plant(actual(), rig.push)
    watched = weakref.ref(rig)
    del rig
    gc.collect()
    assert watched() is not None
    plant.step(ZERO, ZERO, ZERO, 0.0, 1e-3)
    del plant
    gc.collect()
    assert watched() is None

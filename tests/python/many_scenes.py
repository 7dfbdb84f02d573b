"""What the tests of `simulate_many` share: one loop, run in one call and alone."""

from __future__ import annotations

from typing import Any

import numpy as np
import steadyarm as sa
from law_scenes import TWO, H, nominal, plant, reference
from steadyarm.metrics import NAMES
from test_effects import EVERYTHING

T = 0.06
LATE = (0.02, 0.05)
LOOP: dict[str, Any] = {"duration": T, "dt": H, "control_period": H}
NOISY = sa.Effects(**EVERYTHING)


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


def wild() -> sa.ComputedTorque:
    """It samples far too slowly for this damping."""
    return sa.ComputedTorque(nominal(TWO), 64.0, 4000.0)


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

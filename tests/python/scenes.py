"""What the tests share: the paper's arms and controllers, and a few ways to build them."""

from __future__ import annotations

from typing import Any

import numpy as np
import steadyarm as sa

CENTERS = (-1.5, -0.5, 0.0, 0.5, 1.5)
WIDTH = 0.5**0.5
ZERO = np.zeros(2)


def nominal(**friction: Any) -> sa.TwoLink:
    return sa.TwoLink(mass=(4, 4), length=(0.5, 0.5), inertia=(0.2, 0.2), **friction)


def actual() -> sa.TwoLink:
    return sa.TwoLink(mass=(8, 8), length=(0.5, 0.5), inertia=(0.4, 0.4))


def plant() -> sa.Plant:
    return sa.Plant(actual(), disturbance=sa.paper.disturbance())


def basis(form: str = "grid", normalized: bool = True, inputs: Any = "error") -> sa.FuzzyBasis:
    return sa.FuzzyBasis(form, CENTERS, WIDTH, normalized, inputs)


def tracker(
    form: str = "grid",
    normalized: bool = True,
    inputs: Any = "error",
    limits: dict[str, Any] | None = None,
    **law: Any,
) -> sa.ComputedTorque:
    law = {"q": 10, "gain": 7.0, "gamma": 1.0} | law
    compensator = sa.FuzzyCompensator(basis(form, normalized, inputs), **law)
    return sa.ComputedTorque(nominal(), 8, 5.5, compensator, **(limits or {}))


def run(controller: sa.ComputedTorque, **options: Any) -> sa.Run:
    options = {"duration": 1.0, "dt": 1e-3} | options
    return sa.simulate(plant(), controller, sa.paper.reference(), **options)


def samples(count: int, seed: int = 0) -> list[list[np.ndarray]]:
    """Random samples (q, dq, q_d, dq_d, ddq_d) of moderate size."""
    random = np.random.default_rng(seed)
    return [list(random.normal(size=(5, 2))) for _ in range(count)]


def drive(controller: sa.ComputedTorque, steps: list[list[np.ndarray]]) -> np.ndarray:
    """The torques of a controller for samples."""
    return np.array([controller.step(*sample, 1e-3) for sample in steps])

"""A loop of a controller, bare or guarded, and a plant, whose samples a test may change."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import steadyarm as sa
from scenes import CENTERS, WIDTH, ZERO, actual, nominal

Call = Callable[[Any, list[np.ndarray]], np.ndarray]

H = 1e-3
EFFORT, RATE = np.array([200.0, 100.0]), np.array([10_000.0, 6000.0])


def stiff(**limits: Any) -> sa.ComputedTorque:
    """A loop that settles within a second, of an arm under gravity, with 5 rules."""
    basis = sa.FuzzyBasis("shared", CENTERS, WIDTH, False)
    compensator = sa.FuzzyCompensator(basis, q=10, gain=70.0)
    return sa.ComputedTorque(nominal(gravity=9.81), 100, 20, compensator, **limits)


def guarded(**limits: Any) -> sa.Guard:
    limits = {"velocity_limit": 6.0, "effort_limit": EFFORT, "effort_rate_limit": RATE} | limits
    return sa.Guard(stiff(), H, slack=1e-3, deceleration=10.0, **limits)


def controller_of(controller: sa.ComputedTorque | sa.Guard) -> sa.ComputedTorque:
    return controller.tracker if isinstance(controller, sa.Guard) else controller


class Rig:
    """A guard or a tracker with its plant, whose samples may be changed on the way."""

    def __init__(self, controller: Any, limit: float | None = None) -> None:
        self.controller, self.k, self.limit = controller, 0, limit
        arm = actual().with_gravity(controller_of(controller).arm.parameters[3])
        self.plant, self.reference = sa.Plant(arm, sa.paper.disturbance()), sa.paper.reference()
        self.applied: np.ndarray | None = None
        self.q, self.dq, _ = self.reference(0.0)
        self.tau, self.torques, self.errors = ZERO, [], []

    def sample(self) -> list[np.ndarray]:
        return [self.q.copy(), self.dq.copy(), *self.reference(self.k * H)]

    def period(self, call: Call | None = None) -> np.ndarray:
        """One period; ``call`` gives the torque for controller and sample; None: a usual step."""
        sample = self.sample()
        self.errors.append(float(np.abs(self.q - sample[2]).max()))
        tau = self.usual(sample) if call is None else call(self.controller, sample)
        self.move(tau)
        return tau

    def usual(self, sample: list[np.ndarray]) -> np.ndarray:
        if isinstance(self.controller, sa.Guard):
            return self.controller.step(*sample, applied=self.applied)
        return self.controller.step(*sample, H, applied=self.applied)

    def move(self, tau: np.ndarray) -> None:
        assert np.isfinite(tau).all()
        if isinstance(self.controller, sa.Guard) and self.torques:
            assert (abs(tau) <= EFFORT).all()
            assert (abs(tau - self.tau) <= RATE * H * (1 + 1e-12)).all()
        self.torques.append(tau)
        self.tau = tau
        self.applied = None if self.limit is None else np.clip(tau, -self.limit, self.limit)
        acting = tau if self.applied is None else self.applied
        self.q, self.dq = self.plant.step(self.q, self.dq, acting, self.k * H, H)
        self.k += 1

    def periods(self, count: int) -> Rig:
        for _ in range(count):
            self.period()
        return self

    def rms(self, since: int = 0) -> float:
        return float(np.sqrt(np.mean(np.square(self.errors[since:]))))


def calm(count: int) -> Rig:
    """A guarded loop to which nothing happens."""
    return Rig(guarded()).periods(count)


def weights(guard: sa.Guard) -> bytes:
    found = guard.tracker.weights
    assert found is not None and np.isfinite(found).all()
    return found.tobytes()

"""What became of a torque between the law and the joints, from the record of a run."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._scene import arguments

if TYPE_CHECKING:
    from .run import Run

Array = NDArray[np.float64]

SAME = 1e-6
"""Times that are nearer than this share of a step are the same."""


class Line:
    """The torque at its stations [N·m], (T, n) each: told, acting, arrived; and the cogging.

    ``told`` is what the limits of controller and drives let through, ``acting`` what is the drives'
    aim after the delay, ``arrived`` what the joints get of it, cogging aside.
    """

    def __init__(self, run: Run, plant: _core.Plant, options: Mapping[str, Any]) -> None:
        self._run, self._options = run, options
        self.told = self.acting = self.arrived = run.tau
        self.cogging = np.zeros_like(run.tau)
        if "tau_commanded" not in run.channels:
            return  # what is decided acts
        effects = options["effects"]
        said = arguments(_core.Effects() if effects is None else effects)
        self.cogging = np.asarray(run.tau_cogging)  # type: ignore[attr-defined]
        self.arrived = self._at_links(said)
        told = np.clip(run.tau_commanded, -plant.effort_limit, plant.effort_limit)  # type: ignore[attr-defined]
        acting = run.tau / _or(said["gain"], 1.0)
        self._begun = acting[0]  # what was on the joints before the first torque arrived
        late, lags = bool(said["delay"]), np.any(_or(said["lag"], 0.0) > 0.0)
        limits_rate = np.isfinite(_or(said["effort_rate_limit"], np.inf)).any()
        if limits_rate:
            told = acting if not (late or lags) else self._followed(told, said)
        if lags:
            acting = self._delayed(told, said["delay"])
        self.told, self.acting = told, acting

    def at_samples(self, columns: Array) -> Array:
        """What ``columns`` (T, n) were at the sample from which the torque of each row comes."""
        seen = self._seen()
        if seen is None:
            return columns
        return np.array([np.interp(seen, self._run.t, column) for column in columns.T]).T

    def _seen(self) -> Array | None:
        """The time of that sample [s], (T,); None in continuous time."""
        run, period, dt = self._run, self._options["control_period"], self._options["dt"]
        if period is None:
            return None
        if "sample_age" in run.channels:
            return np.asarray(run.t - run.sample_age)  # type: ignore[attr-defined]
        hold, steps = round(period / dt), round(self._options["duration"] / dt)
        # No sample is taken at the end of a run.
        samples = np.minimum(np.rint(run.t / dt) // hold, (steps - 1) // hold)
        seen: Array = samples * hold * dt
        return seen

    @property
    def notes(self) -> tuple[str, ...]:
        """What to know of the stations."""
        seen = self._seen()
        if seen is None:
            return ()
        t, tiny = self._run.t, SAME * self._options["dt"]
        rows = np.minimum(np.searchsorted(t, seen - tiny), len(t) - 1)
        if (np.abs(t[rows] - seen) <= tiny).all():
            return ()
        return (
            "samples fall between the rows: sampling and measurement, and the limits, delay and "
            "lag of drives, are told apart roughly; their sum is exact",
        )

    def _at_links(self, said: Mapping[str, Any]) -> Array:
        """What arrives at the links; through gears that give, what the gears give."""
        run = self._run
        if said["joint_stiffness"] is None:
            return run.tau
        motors: Array = run.q_motor  # type: ignore[attr-defined]
        twist, half = motors - run.q, 0.5 * _or(said["backlash"], 0.0)
        bent = twist - np.clip(twist, -half, half)
        damping = _or(said["joint_damping"], 0.0)
        rate = np.zeros_like(bent)
        if damping.any():
            # The motors' velocity is not recorded.
            rate = np.gradient(motors, run.t, axis=0, edge_order=2) - run.dq
            rate = np.where((bent != 0.0) | (half == 0.0), rate, 0.0)
        torque: Array = _or(said["joint_stiffness"], 0.0) * bent + damping * rate
        return torque

    def _delayed(self, told: Array, delay: int | None) -> Array:
        """What was told so many samples before; at the start what acted then."""
        if not delay:
            return told
        seen = self._seen()
        assert seen is not None
        since = seen - delay * self._options["control_period"]
        tiny = SAME * self._options["dt"]
        rows = np.minimum(np.searchsorted(self._run.t, since - tiny), len(since) - 1)
        delayed: Array = np.where((since < -tiny)[:, None], self._begun, told[rows])
        return delayed

    def _followed(self, asked: Array, said: Mapping[str, Any]) -> Array:
        """What drives that follow a torque at a limited rate let through."""
        change = _or(said["effort_rate_limit"], np.inf) * self._options["control_period"]
        seen = self._seen()
        assert seen is not None
        told, last = np.empty_like(asked), self._begun
        for row, torque in enumerate(asked):
            if row == 0 or seen[row] != seen[row - 1]:
                last = np.clip(torque, last - change, last + change)
            told[row] = last
        return told


def _or(value: Any, default: float) -> Array:
    """A setting of each joint, or of all."""
    return np.asarray(default if value is None else value, dtype=float)

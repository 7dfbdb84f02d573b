"""A path, sampled so finely that its peaks are seen: ranges, speeds, accelerations, jerk."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from numbers import Real
from typing import Any, TypedDict

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._documented import documented
from .simulation import Reference

Array = NDArray[np.float64]

Path = Reference | tuple[ArrayLike, ...] | Array
"""A path: a reference, the arguments of a `Table`, (t, q) or (t, q, dq, ddq), or positions."""

LEAST, MOST = 512, 200_000
"""Steps of a sampled path, at least and at most."""

PER_PERIOD = 64
"""Steps in a period of the fastest sine, and in the shortest move of other curves, times four."""

GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)
"""A callable is sampled in steps this much finer, which share no multiple with those before …"""

AGREE = 0.01
"""… until its peaks change by less than this part."""


class PathFigures(TypedDict):
    """What a path asks of each of n joints; for a prismatic joint read m for rad.

    Attributes
    ----------
    q: the smallest and the largest position [rad], (2, n).
    dq: the smallest and the largest velocity [rad/s], (2, n).
    ddq: the smallest and the largest acceleration [rad/s²], (2, n).
    speed: the largest speed, either way [rad/s], (n,).
    acceleration: the largest acceleration, either way [rad/s²], (n,).
    jerk: the largest change of ddq from sample to sample, over their distance [rad/s³], (n,).
    """

    q: Array
    dq: Array
    ddq: Array
    speed: Array
    acceleration: Array
    jerk: Array


@documented
@dataclass(frozen=True, eq=False)
class Course:
    """A path at evenly spaced times, both ends included."""

    t: Array
    """[s], (T,)."""
    q: Array
    """[rad], (T, n), as ``dq`` [rad/s] and ``ddq`` [rad/s²]."""
    dq: Array
    ddq: Array


Evaluate = Callable[[Array], tuple[Array, Array, Array]]


def reference_of(path: Path, duration: float | None) -> tuple[Reference, float]:
    """Return a path as a reference that `simulate` takes, and its length [s].

    ``duration`` [s]: None for the path's own. Raises ValueError where it has none.
    """
    if isinstance(path, np.ndarray | list):
        if duration is None:
            raise ValueError("duration: got None, wants the length of a path of positions [s]")
        path = np.linspace(0.0, duration, len(path)), path
    if isinstance(path, tuple):
        columns: Any = path
        path = _core.Table(*columns)
    if not callable(path):
        wants = "a reference, (t, q), (t, q, dq, ddq) or positions (T, n)"
        raise TypeError(f"path: got {type(path).__name__}, wants {wants}")
    length = _length(path) if duration is None else duration
    if not (isinstance(length, Real) and 0.0 < length < math.inf):
        raise ValueError(f"duration: got {length!r}, wants a number > 0")
    return path, float(length)


def path_figures(
    path: Path, duration: float | None = None, arm: _core.Arm | None = None
) -> PathFigures:
    """Return the ranges, speeds, accelerations and jerk of a path, with its peaks.

    Parameters
    ----------
    path: a reference; (t, q) or (t, q, dq, ddq) as a `Table` takes them; or positions (T, n),
        evenly spaced over ``duration``.
    duration: how much of it [s]; None: `Table`, `Quintic`, `Waypoints` to their ends, `Sines` over
        a period of the slowest; a callable needs it.
    arm: whose joints they are, for a path that was given scalars; None: two joints.

    Raises
    ------
    ValueError, TypeError
        Naming the argument.
    """
    reference, duration = reference_of(path, duration)
    evaluate = _evaluator(reference, arm)
    course = _sampled(reference, duration, evaluate)
    q, dq, ddq = _ranges(course, evaluate)
    jerk = np.abs(np.diff(course.ddq, axis=0)).max(axis=0) / course.t[1]
    speed, acceleration = np.abs(dq).max(axis=0), np.abs(ddq).max(axis=0)
    return {
        "q": q, "dq": dq, "ddq": ddq, "speed": speed, "acceleration": acceleration, "jerk": jerk,
    }  # fmt: skip


def sample(path: Path, duration: float | None = None, arm: _core.Arm | None = None) -> Course:
    """Return a path at times so close that nothing happens between them; see `path_figures`."""
    reference, duration = reference_of(path, duration)
    return _sampled(reference, duration, _evaluator(reference, arm))


def _evaluator(path: Reference, arm: _core.Arm | None) -> Evaluate:
    def of_arm(t: Array) -> tuple[Array, Array, Array]:
        still = np.zeros((len(t), arm.joints))  # type: ignore[union-attr]
        try:
            q, dq, ddq, *_ = _core.desired_motion(path, arm, t, still, still)  # type: ignore[arg-type]
        except (ValueError, TypeError) as error:
            if str(error).startswith("reference"):
                raise type(error)(f"path{str(error).removeprefix('reference')}") from None
            raise
        return q, dq, ddq

    def alone(t: Array) -> tuple[Array, Array, Array]:
        if isinstance(path, _core.Curve):
            return path(t)
        points = np.array([_setpoint(path(x), x) for x in t.tolist()])
        return points[:, 0], points[:, 1], points[:, 2]

    return alone if arm is None else of_arm


def _setpoint(point: Any, t: float) -> Array:
    """What a callable gave, as (3, n)."""
    try:
        rows = np.array(point, dtype=float)
    except (TypeError, ValueError):
        rows = np.empty(0)
    if rows.ndim != 2 or len(rows) != 3 or not np.isfinite(rows).all():
        raise ValueError(f"path: at t = {t:g} s it gives no (q_d, dq_d, ddq_d) of finite (n,)")
    return rows


def _sampled(path: Reference, duration: float, evaluate: Evaluate) -> Course:
    def at(step: float) -> Course:
        steps = math.ceil(duration / step * (1.0 - 1e-9))
        t = np.linspace(0.0, duration, min(max(steps, LEAST), MOST) + 1)
        return Course(t, *evaluate(t))

    step = _step(path)
    if step is not None:
        return at(step)
    step = duration / LEAST
    course = at(step)
    while len(course.t) <= MOST:
        step *= GOLDEN
        finer = at(step)
        peaks, before = _peaks(finer), _peaks(course)
        course = finer
        if (np.abs(peaks - before) <= AGREE * np.maximum(peaks, before)).all():
            break
    return course


def _peaks(course: Course) -> Array:
    return np.abs([np.ptp(course.q, axis=0), *np.abs([course.dq, course.ddq]).max(axis=1)])


def _step(path: Reference) -> float | None:
    """The spacing [s] that shows all that a curve does; None for a callable."""
    move: float
    if isinstance(path, _core.Sines):
        frequency = np.abs(np.atleast_1d(np.asarray(path.__reduce__()[1][0], float)))
        return 2.0 * math.pi / max(float(frequency.max()), 1e-9) / PER_PERIOD
    if isinstance(path, _core.Table):
        return float(np.diff(path.__reduce__()[1][0]).min()) / 4.0
    if isinstance(path, _core.Quintic):
        move = path.__reduce__()[1][2]
    elif isinstance(path, _core.Waypoints):
        move = float(np.diff(path.arrivals).min())
    else:
        return None
    return move / (4.0 * PER_PERIOD)


def _ranges(course: Course, evaluate: Evaluate) -> tuple[Array, Array, Array]:
    """The smallest and the largest of each signal, (2, n) each, looked for between the samples."""
    n = course.q.shape[1]
    values = np.hstack([course.q, course.dq, course.ddq])
    ends = np.array([values.min(axis=0), values.max(axis=0)])
    at = course.t[np.concatenate([values.argmin(axis=0), values.argmax(axis=0)])]
    column, step = np.tile(np.arange(3 * n), 2), course.t[1]
    sign = np.repeat([-1.0, 1.0], 3 * n)
    for _ in range(4):
        times = np.clip(at[:, None] + step * np.linspace(-1.0, 1.0, 9), 0.0, course.t[-1])
        near = np.hstack(evaluate(times.ravel())).reshape(6 * n, 9, 3 * n)
        own = sign[:, None] * near[np.arange(6 * n), :, column]
        best = own.argmax(axis=1)
        at, step = times[np.arange(6 * n), best], step / 4.0
        found = (sign * own.max(axis=1)).reshape(2, 3 * n)
        ends = np.array([np.minimum(ends[0], found[0]), np.maximum(ends[1], found[1])])
    return ends[:, :n], ends[:, n : 2 * n], ends[:, 2 * n :]


def _length(path: Reference) -> float:
    """How long a path is [s]."""
    if isinstance(path, _core.Table):
        times, _, _, _, start = path.__reduce__()[1]
        return float(times[-1] if start is None else times[-1] - times[0] + start)
    if isinstance(path, _core.Quintic):
        _, _, duration, start = path.__reduce__()[1]
        return float(duration + start)
    if isinstance(path, _core.Waypoints):
        return float(path.arrivals[-1])
    if isinstance(path, _core.Sines):
        frequency, *_, start = path.__reduce__()[1]
        frequency = np.abs(np.atleast_1d(np.asarray(frequency, float)))
        moving = frequency[frequency > 0.0]
        period = 2.0 * math.pi / float(moving.min()) if len(moving) else 1.0
        return period + max(start or 0.0, 0.0)
    raise ValueError("duration: got None, wants the length of a path that is a callable [s]")

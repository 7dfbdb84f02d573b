"""Sets of a fuzzy basis from the path that is to be learnt."""

from __future__ import annotations

import math
from collections.abc import Sequence
from numbers import Integral, Real
from typing import Any, NamedTuple, TypedDict

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._documented import documented
from .paths import Course, Path, PathFigures, path_figures
from .run import Run

Array = NDArray[np.float64]

STILL = 0.01
"""An input that moves by less than this part of what the most moved joint does stands still."""


HALF = math.sqrt(2.0 * math.log(2.0))
"""A set fires by half this many σ from its centre."""


@documented
class Outside(NamedTuple):
    """An input that a path takes out of its sets."""

    signal: str
    """"q_d", "dq_d", …"""
    joint: int
    """From 0."""
    by: float
    """How far beyond where the outermost set fires by half, at most [of the signal]."""


class Sets(TypedDict):
    """Arguments of `FuzzyBasis`.

    Attributes
    ----------
    centers: centres, a list for each input.
    width: σ of the sets of each input.
    inputs: as they were given.
    """

    centers: list[list[float]]
    width: list[float]
    inputs: Any


def centers_for(
    path: Path,
    inputs: Any = "reference",
    sets: int | Sequence[int] = 9,
    *,
    duration: float | None = None,
    error: Run | tuple[ArrayLike, ArrayLike] | None = None,
    margin: float = 0.1,
    crossing: float = 0.5,
) -> Sets:
    """Return the sets that a path needs, as arguments of `FuzzyBasis`.

    ``sa.FuzzyBasis(form="per_joint", **sa.centers_for(path, "reference", sets=9))``. Each input of
    each joint has evenly spaced centres over what it does along the path. Neighbouring sets cross
    at half height: wherever the path is, one set fires by half or more, and halfway between two
    centres both do by half (Lee, "Fuzzy logic in control systems", IEEE Trans. SMC 20(2), 1990,
    completeness ε = 0.5). Wider sets are smoother and learn what is fine more slowly; the paper's
    cross at 0.78. Few sets learn within one pass, many learn better what comes back.

    An input that does not move gets sets about where it stands, as wide as those of the joint that
    moves most (1 where none moves): it then tells the rules nothing, and an error takes it nowhere.
    ``q`` and ``q_d`` of a continuous joint are taken as they come, turns included, as a basis does.

    Parameters
    ----------
    path: a reference; (t, q) or (t, q, dq, ddq) as a `Table` takes them; or positions (T, n),
        evenly spaced over ``duration``.
    inputs: signals of the basis, as `FuzzyBasis` takes them.
    sets: how many for each input, or one number a signal: (9, 15) for 9 of q_d and 15 of dq_d. The
        form "shared" wants the same everywhere.
    duration: length of the path [s]; None: `Table`, `Quintic`, `Waypoints` to their ends, `Sines`
        over a period of the slowest; a callable needs it.
    error: what the error will be, which does not follow from the path; the inputs ``e`` and ``de``
        need it. A `Run` of the controller without a compensator, whose errors are the largest that
        the rules will see, or how large at most, (e [rad], de [rad/s]), scalars or (n,). Ranges are
        symmetric, so that an odd number of sets has one where there is no error. With it, ``q`` and
        ``dq`` reach that much beyond the path too.
    margin: room at both ends, as a part of the range, >= 0.
    crossing: height at which neighbouring sets cross, 0 to 1.

    Raises
    ------
    ValueError, TypeError
        Naming the argument.
    """
    signals = _core.FuzzyBasis("shared", [0.0], 1.0, inputs=inputs).inputs
    counts = _counts(sets, len(signals))
    if not (isinstance(margin, Real) and 0.0 <= margin < math.inf):
        raise ValueError(f"margin: got {margin!r}, wants a number >= 0")
    if not (isinstance(crossing, Real) and 0.0 < crossing < 1.0):
        raise ValueError(f"crossing: got {crossing!r}, wants a number between 0 and 1")
    figures = path_figures(path, duration)
    errors = None if error is None else _errors(error, figures["q"].shape[1])
    over = 0.5 / math.sqrt(-2.0 * math.log(crossing))
    centers, width = [], []
    for (signal, scale), count in zip(signals, counts, strict=True):
        low, high = np.sort(scale * _range(signal, figures, errors), axis=0)
        middle, half = 0.5 * (low + high), (0.5 + margin) * _spans(high - low)
        reach = half if count > 1 else np.zeros_like(half)
        centers += np.linspace(middle - reach, middle + reach, count, axis=1).tolist()
        width += (over * 2.0 * half / max(count - 1, 1)).tolist()
    return {"centers": centers, "width": width, "inputs": inputs}


def _counts(sets: int | Sequence[int], signals: int) -> list[int]:
    counts = np.ravel(sets).tolist() * (signals if np.ndim(sets) == 0 else 1)
    if len(counts) != signals:
        raise ValueError(f"sets: got {len(counts)} entries, wants one a signal, {signals}")
    for count in counts:
        if not isinstance(count, Integral) or isinstance(count, bool) or count < 1:
            raise ValueError(f"sets: got {count!r}, wants a whole number >= 1")
    return counts


def _errors(error: Run | tuple[ArrayLike, ArrayLike], joints: int) -> Array:
    """The largest |e| and |de| of each joint, (2, n)."""
    if isinstance(error, Run):
        pair: Sequence[Any] = [np.abs(error.e).max(axis=0), np.abs(error.de).max(axis=0)]
    elif isinstance(error, tuple) and len(error) == 2:
        pair = error
    else:
        raise TypeError(f"error: got {type(error).__name__}, wants a Run or a pair (e, de)")
    try:
        sizes = np.array([np.broadcast_to(np.asarray(x, float), (joints,)) for x in pair])
    except ValueError as wrong:
        raise ValueError(f"error: wants numbers, scalars or ({joints},): {wrong}") from None
    if not (np.isfinite(sizes) & (sizes >= 0.0)).all():
        raise ValueError(f"error: got {sizes.tolist()}, wants numbers >= 0")
    return sizes


def _range(signal: str, figures: PathFigures, errors: Array | None) -> Array:
    """The smallest and the largest of a signal along the path, (2, n)."""
    if signal in ("e", "de"):
        if errors is None:
            raise ValueError(
                "error: got None, wants a run without a compensator, or the largest (e, de), for "
                f"the input {signal}"
            )
        return np.outer([-1.0, 1.0], errors[int(signal == "de")])
    ranges = {"q": figures["q"], "dq": figures["dq"], "ddq": figures["ddq"]}
    if signal in ranges and errors is not None:
        return ranges[signal] + np.outer([-1.0, 1.0], errors[int(signal == "dq")])
    return ranges[signal.removesuffix("_d")]


def _spans(spans: Array) -> Array:
    """Ranges of a signal, (n,), with room where a joint stands still."""
    most = float(spans.max())
    if most == 0.0:
        return np.ones_like(spans)
    return np.where(spans < STILL * most, most, spans)


def coverage(basis: _core.FuzzyBasis, course: Course) -> tuple[float, tuple[Outside, ...]]:
    """Return the share of a path's time in which every input is in a set by half or more.

    And the inputs that leave the sets, each where it does so most. The arm is on the path: e and de
    are zero.
    """
    none = np.zeros_like(course.q)
    of = {"e": none, "de": none, "q": course.q, "dq": course.dq}
    of |= {"q_d": course.q, "dq_d": course.dq, "ddq_d": course.ddq}
    columns = [
        (signal, joint, scale, scale * of[signal][:, joint])
        for signal, scale in basis.inputs
        for joint in range(course.q.shape[1])
    ]
    covered, outside = np.ones(len(course.t), bool), []
    for (signal, joint, scale, x), sets in zip(columns, _sets(basis, len(columns)), strict=True):
        centers, width = sets
        reach = HALF * width
        away = np.abs(x[:, None] - centers) - reach * (1.0 + 1e-9)
        covered &= (away <= 0.0).any(axis=1)
        over = np.maximum(x - (centers + reach).max(), (centers - reach).min() - x).max()
        if over > 1e-9 * np.ptp(x):
            outside.append(Outside(signal, joint, float(over / abs(scale))))
    return float(covered.mean()), tuple(outside)


def _sets(basis: _core.FuzzyBasis, inputs: int) -> list[tuple[Array, Array]]:
    """Centres and widths of every input, (sets,) each."""
    own = isinstance(basis.centers[0], list)
    centers = basis.centers if own else [basis.centers] * inputs
    width = basis.width
    if np.ndim(width) == 0 or not own:
        width = [width] * inputs
    return [
        (np.array(c, float), np.broadcast_to(np.asarray(w, float), (len(c),)))
        for c, w in zip(centers, width, strict=True)
    ]

"""Curves of a run, thinned for a page: few samples, and every peak is still there."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from .run import Run

Array = NDArray[np.float64]

POINTS = 400
"""So many samples of a curve at the most."""

DIGITS = 6
"""Significant digits of a thinned curve."""

SIGNALS = ("e", "tau", "q")


@dataclass(frozen=True, eq=False)
class Curves:
    """A run in at most 400 samples, time first, for pictures only.

    Of ``e`` and ``tau`` each stretch of time has its smallest and its largest value, in the order
    in which they came: peaks survive, times are right to one stretch, 1/200 of the run. ``t`` and
    ``q`` are the first and the last sample of every stretch.
    """

    t: Array
    """Time [s], (P,)."""
    e: Array
    """Size of the error |e| of each joint [rad], (P, n)."""
    tau: Array
    """Torque [N·m], (P, n); (0, n) if it was not recorded."""
    q: Array
    """Position [rad], (P, n)."""

    @classmethod
    def of(cls, run: Run) -> Curves:
        """Thin a run."""
        whole = cls(run.t, np.abs(run.e), np.asarray(run.tau), run.q).thinned(POINTS)
        return cls(*map(_short, (whole.t, whole.e, whole.tau, whole.q)))

    def thinned(self, points: int) -> Curves:
        """The same in at most so many samples."""
        if len(self.t) <= points:
            return self
        edges = np.linspace(0, len(self.t), points // 2 + 1).astype(np.intp)
        rows = np.stack([edges[:-1], edges[1:] - 1], axis=1).ravel()
        torque = envelope(self.tau, edges) if len(self.tau) else self.tau
        return Curves(self.t[rows], envelope(self.e, edges), torque, self.q[rows])

    @property
    def joints(self) -> int:
        """Number of joints n."""
        return int(self.e.shape[1])

    def plain(self) -> dict[str, Any]:
        """Lists of numbers, for a file; None for one that is not finite."""
        columns: dict[str, Any] = {"t": _listed(self.t)}
        for name in SIGNALS:
            columns[name] = [_listed(column) for column in getattr(self, name).T]
        return columns

    @classmethod
    def from_plain(cls, plain: Any) -> Curves:
        """What `plain` gave; ValueError for anything else."""
        try:
            t = np.array(plain["t"], dtype=float)
            parts = {name: np.array(plain[name], dtype=float) for name in SIGNALS}
        except (KeyError, TypeError, ValueError) as error:
            raise ValueError(f"curves: got {error}, wants t, e, tau and q") from error
        shape = (len(parts["e"]), len(t))
        for name, part in parts.items():
            empty = name == "tau" and part.shape == (shape[0], 0)
            if t.ndim != 1 or (part.shape != shape and not empty):
                raise ValueError(f"curves.{name}: got the shape {part.shape}, wants {shape}")
        return cls(t, *(parts[name].T for name in SIGNALS))


def outline(t: Array, values: Array, points: int) -> tuple[Array, Array]:
    """A curve in at most so many samples: ends and peaks, each where it is.

    A page cannot show more than the smallest and the largest value of a stretch as narrow as a dot.
    """
    if len(t) <= points:
        return t, values
    edges = np.linspace(0, len(t), max(points // 2, 2)).astype(np.intp)
    rows = np.unique([0, *_extremes(values[:, None], edges)[:, 0], len(t) - 1])
    return t[rows], values[rows]


def envelope(signal: Array, edges: NDArray[np.intp]) -> Array:
    """The smallest and the largest value of every stretch, in the order in which they came."""
    thinned: Array = np.take_along_axis(signal, _extremes(signal, edges), axis=0)
    return thinned


def _extremes(signal: Array, edges: NDArray[np.intp]) -> NDArray[np.intp]:
    """Their rows, two a stretch."""
    rows = np.empty((2 * (len(edges) - 1), signal.shape[1]), np.intp)
    for k, (start, end) in enumerate(pairwise(edges)):
        part = signal[start:end]
        ends = [part.argmin(axis=0), part.argmax(axis=0)]
        rows[2 * k : 2 * k + 2] = start + np.sort(ends, axis=0)
    return rows


def _short(values: Array) -> Array:
    """The values with few digits, as a file has them."""
    flat = [float(f"{value:.{DIGITS}g}") for value in values.ravel().tolist()]
    return np.array(flat).reshape(values.shape)


def _listed(values: Array) -> list[float | None]:
    return [value if np.isfinite(value) else None for value in values.tolist()]

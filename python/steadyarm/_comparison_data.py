"""Curves for the page of a comparison, thinned and packed until they fit one file."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ._comparison_words import plain
from ._packed import ALPHABET, packed
from ._places import is_flat, joint_points

if TYPE_CHECKING:
    from ._curves import Curves
    from .comparison import Line

Array = NDArray[np.float64]

BUDGET = 200_000
"""So many characters of curves at the most."""

FRAMES_BUDGET = 60_000
"""So many characters of arms."""

LEAST = 1e-12
"""An error below it is drawn as it [rad]."""

ROOM = 3.0
"""A torque of a run that did not finish is cut at so many times the largest of one that did."""

VIEW = np.array([[-0.6, 0.8, 0.0], [-0.32, -0.24, 0.917]])
"""How a page sees an arm that does not lie in a plane: from before, from the side, from above."""


def collected(groups: Mapping[str, Sequence[Line]], arm: Any) -> dict[str, Any]:
    """What the script draws: for each scenario the curves of each controller that has some."""
    scenes = {name: [line for line in group if line.shown.curves] for name, group in groups.items()}
    curves = [line.shown.curves for group in scenes.values() for line in group]
    numbers = sum(1 + 2 * part.joints for part in curves if part) or 1
    points = max(40, min(400, BUDGET // (2 * numbers)))
    frames = _Frames(arm, [part for part in curves if part])
    return {
        "alphabet": ALPHABET,
        "scenes": [
            {"name": plain(name), "curves": _scene(group, points, frames)}
            for name, group in scenes.items()
        ],
    }


def _scene(lines: Sequence[Line], points: int, frames: _Frames) -> list[dict[str, Any]]:
    finished = [line.shown for line in lines if line.shown.status in ("finished", "unresolved")]
    known = [np.abs(row.curves.tau) for row in finished if row.curves and row.curves.tau.size]
    limit = ROOM * max((float(part.max()) for part in known), default=math.inf)
    scene = []
    for line in lines:
        curves = line.shown.curves
        if curves is None:
            continue
        few = curves.thinned(points)
        error = np.log10(np.maximum(few.e, LEAST))
        tau = np.clip(few.tau, -limit, limit) if limit > 0 else few.tau
        scene.append(
            {
                "name": plain(line.controller),
                "seed": line.shown.seed,
                "status": line.shown.status,
                "t": packed(few.t),
                "e": [packed(column) for column in error.T],
                "tau": [packed(column) for column in tau.T] if tau.size else [],
                "arm": frames.of(curves),
            }
        )
    return scene


class _Frames:
    """Places of an arm's joints over time, as the page sees them."""

    def __init__(self, arm: Any, curves: Sequence[Curves]) -> None:
        self.points: Any = None
        if arm is None or not curves:
            return
        self.points, self.joints = joint_points(arm), arm.joints
        joints = self.joints + 2
        self.count = max(20, min(200, FRAMES_BUDGET // (4 * joints * len(curves))))

    def of(self, curves: Curves) -> dict[str, Any] | None:
        """Packed times and places; None for a run of another arm."""
        if self.points is None or curves.joints != self.joints:
            return None
        rows = np.unique(np.linspace(0, len(curves.t) - 1, self.count).astype(int))
        rows = rows[np.isfinite(curves.q[rows]).all(axis=1)]
        if not len(rows):
            return None
        places = np.array([self.points(q) for q in curves.q[rows]])
        flat = is_flat(places)
        seen = places[..., :2] if flat else places @ VIEW.T
        sides = [packed(seen[:, k, side]) for k in range(seen.shape[1]) for side in (0, 1)]
        return {"t": packed(curves.t[rows]), "places": sides}

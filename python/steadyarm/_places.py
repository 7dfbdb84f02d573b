"""Where an arm is: the places of its base, its joints and its tip."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Points = Callable[[Array], Array]

FLAT = 1e-9
"""An arm whose heights differ by less lies flat [m]."""


def joint_points(arm: Any) -> Points:
    """Return the function from q to the places of the base, every joint and the tip [m], (…, 3)."""
    if not (hasattr(arm, "link_poses") and hasattr(arm, "pose")):
        raise TypeError(f"arm: got {type(arm).__name__}, wants a TwoLink or a Serial")

    def points(q: Array) -> Array:
        joints = np.asarray(arm.link_poses(q))[:, :3, 3]
        return np.vstack([np.zeros(3), joints, np.asarray(arm.pose(q))[:3, 3]])

    return points


def is_flat(places: Array) -> bool:
    """Whether all places (…, 3) are at one height."""
    return bool(np.ptp(places[..., 2]) < FLAT)

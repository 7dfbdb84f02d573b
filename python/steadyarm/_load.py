"""What an arm carries: a body that it has at its last link, and another arm like it has not."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from . import _core

Array = NDArray[np.float64]

SAME = 1e-9
"""Parameters that differ by less are the same, relative to the largest of their links."""


def without_load(arm: _core.Arm, others: Iterable[_core.Arm]) -> _core.Arm:
    """The arm without what it carries; the arm itself if it carries nothing.

    It carries what one of the ``others`` lacks at the last link, if that is a possible body and all
    other links are the same. Of several the heaviest counts.
    """
    bare, heaviest = arm, 0.0
    if not isinstance(arm, _core.Serial):
        return bare
    own = arm.inertial_parameters().reshape(-1, 10)
    for other in others:
        if not isinstance(other, _core.Serial) or other.joints != arm.joints:
            continue
        theirs = other.inertial_parameters().reshape(-1, 10)
        scale = np.abs(own).max(axis=0)
        same = (np.abs(own - theirs)[:-1] <= SAME * scale).all()
        load = own[-1] - theirs[-1]
        if same and load[0] > heaviest + SAME * scale[0] and _is_body(load):
            bare, heaviest = arm.with_parameters(np.concatenate([*own[:-1], theirs[-1]])), load[0]
    return bare


def _is_body(parameters: Array) -> bool:
    """Whether a rigid body can have these (10,): its pseudo-inertia has no negative eigenvalue."""
    mass, *first, xx, xy, yy, xz, yz, zz = parameters
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    pseudo = np.empty((4, 4))
    pseudo[:3, :3] = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    pseudo[:3, 3] = pseudo[3, :3] = first
    pseudo[3, 3] = mass
    return bool(np.linalg.eigvalsh(pseudo)[0] >= -SAME * np.trace(pseudo))

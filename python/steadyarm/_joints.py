"""Which joints and which part of a run are meant, and what their numbers are called."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from operator import index
from typing import TYPE_CHECKING, Any, SupportsIndex

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from .run import Run

Joints = int | str | Sequence[int | str] | None
"""Joints by number, from 1 as all words count them, or by name; None: all."""

Window = tuple[float, float] | None
"""From when to when [s]; None: all of it."""

LONGEST = 24
"""Letters of a name in a title, at most."""


def chosen(joints: Joints, names: Sequence[str]) -> list[int]:
    """The places of these joints among the names, from 0."""
    if joints is None:
        return list(range(len(names)))
    several = isinstance(joints, Iterable) and not isinstance(joints, str)
    given: list[Any] = list(joints) if several else [joints]  # type: ignore[arg-type]
    if not given:
        raise ValueError(f"joints: got none, wants {_wanted(names)}")
    return list(dict.fromkeys(chosen_one(joint, names, "joints") for joint in given))


def chosen_one(joint: Any, names: Sequence[str], argument: str = "joint") -> int:
    """The place of this joint among the names, from 0."""
    if isinstance(joint, str):
        if joint in names:
            return names.index(joint)
    elif isinstance(joint, bool) or not isinstance(joint, SupportsIndex):
        raise TypeError(f"{argument}: got {joint!r:.80}, wants {_wanted(names)}")
    elif 1 <= index(joint) <= len(names):
        return index(joint) - 1
    raise ValueError(f"{argument}: got {joint!r:.80}, wants {_wanted(names)}")


def _wanted(names: Sequence[str]) -> str:
    named = [name for name in names if not name.isdigit()]
    return f"1 to {len(names)}" + (f", or a name: {', '.join(named)}" if named else "")


def rows_in(t: NDArray[np.float64], window: Window) -> slice:
    """The rows within a window."""
    if window is None:
        return slice(0, len(t))
    wants = f"one with a row of the run in it: (from, to) within {t[0]:g} to {t[-1]:g} s"
    try:
        start, end = map(float, window)
    except (TypeError, ValueError):
        raise TypeError(f"window: got {window!r:.80}, wants {wants}") from None
    first, last = np.searchsorted(t, start), np.searchsorted(t, end, side="right")
    if not first < last:
        raise ValueError(f"window: got {window!r:.80}, wants {wants}")
    return slice(int(first), int(last))


def lengths(kinds: Iterable[str]) -> tuple[str, ...]:
    """What each joint moves in: "m" of a prismatic one, "rad" of any other."""
    return tuple("m" if kind == "prismatic" else "rad" for kind in kinds)


def lengths_of(run: Run) -> tuple[str, ...]:
    """The same of the joints of a run; "rad" where it does not say what it was made with."""
    kinds = () if run._made is None else run._made.joint_kinds
    return lengths(kinds) if len(kinds) == run.joints else ("rad",) * run.joints


def in_length(unit: str, length: str) -> str:
    """A unit of joints that turn, for one that moves in ``length``."""
    return unit.replace("N·m", "N").replace("rad", "m") if length == "m" else unit


def numbered(joints: int) -> tuple[str, ...]:
    """The names of joints that have none: their numbers."""
    return tuple(map(str, range(1, joints + 1)))


def title(name: str) -> str:
    """What a picture or a table calls a joint of this name: its number says little alone."""
    if name.isdigit():
        return f"joint {name}"
    return name if len(name) <= LONGEST else f"…{name[1 - LONGEST :]}"

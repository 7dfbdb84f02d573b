"""Runs for a page: places of arms, errors and torques, thinned and packed until they fit one file.

Curves keep the least and the largest value of every stretch of time, places a frame every 40 ms.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._comparison_words import plain
from ._curves import envelope
from ._joints import lengths
from ._load import without_load
from ._mismatch import segments
from ._packed import ALPHABET, packed
from ._places import is_flat, joint_points
from ._scene import joint_names
from .run import Run

Array = NDArray[np.float64]

POINTS, BUDGET = 800, 100_000
"""So many samples of a curve at the most, and characters of all curves."""

FRAMES_PER_SECOND, FRAMES_BUDGET = 25, 100_000
"""So many frames at the most, and characters of all of them."""

ROOM = 3.0
"""A run that did not finish is cut at so many times what is else to be seen."""

SOUND = ("finished", "unresolved")


@dataclass(frozen=True, eq=False)
class Moving:
    """The places of an arm in the frames of a run [m]."""

    t: Array
    """Time [s], (F,)."""
    actual: Array
    """Base, joints and tip, (F, n + 2, 3)."""
    desired: Array
    """The same where they should be."""
    load: Array
    """The middle of what the arm carries and its controller does not know of; NaN for nothing."""
    masses: list[tuple[float, float]]
    """From when on [s] it weighs how much [kg]."""

    @classmethod
    def of(cls, run: Run, arm: Any, frames: int) -> Moving:
        """Take so many frames of a run at the most."""
        rows = _frames(run, frames)
        points = joint_points(arm)
        load, masses = _load(run, rows)
        return cls(
            run.t[rows],
            np.array([points(q) for q in run.q[rows]]),
            np.array([points(q) for q in run.q_d[rows]]),
            load,
            masses,
        )


def collected(runs: Mapping[str, Run], arms: Sequence[Any]) -> dict[str, Any]:
    """What the script draws: of every run its curves and, with an arm, its places."""
    first, arm = next(iter(runs.values())), next((one for one in arms if one is not None), None)
    names = joint_names(arm, first.joints) if first._made is None else first.joint_names
    kinds = ("revolute",) * first.joints if arm is None else arm.joint_kinds
    points = max(40, min(POINTS, BUDGET // (2 * len(runs) * (1 + 2 * first.joints))))
    frames = max(20, FRAMES_BUDGET // (12 * len(runs) * (first.joints + 2)))
    moving = [
        None if one is None else Moving.of(run, one, frames)
        for run, one in zip(runs.values(), arms, strict=True)
    ]
    seen = [part for part in moving if part is not None]
    everything = [places.reshape(-1, 3) for part in seen for places in (part.actual, part.desired)]
    flat = bool(seen) and is_flat(np.concatenate(everything))
    room = _room([run for run, part in zip(runs.values(), moving, strict=True) if part], seen)
    curves = _curves(list(runs.values()), points)
    return {
        "alphabet": ALPHABET,
        "flat": flat,
        "room": [side[: 2 if flat else 3].tolist() for side in room],
        "joints": [
            {"name": plain(name), "length": length}
            for name, length in zip(names, lengths(kinds), strict=True)
        ],
        "runs": [
            {
                "name": plain(name),
                "status": run.status.kind,
                "curves": part,
                "arm": None if places is None else _places(places, room, flat),
            }
            for (name, run), part, places in zip(runs.items(), curves, moving, strict=True)
        ],
    }


def _frames(run: Run, most: int) -> NDArray[np.intp]:
    """The rows nearest to the times of the frames, the first and the last among them."""
    rows = np.flatnonzero(np.isfinite(run.q).all(axis=1) & np.isfinite(run.q_d).all(axis=1))
    t = run.t[rows]
    count = min(most, int((t[-1] - t[0]) * FRAMES_PER_SECOND) + 2) if len(t) else 0
    if len(t) <= count:
        return rows
    return rows[np.unique(np.searchsorted(t, np.linspace(t[0], t[-1], count)))]


def _load(run: Run, rows: NDArray[np.intp]) -> tuple[Array, list[tuple[float, float]]]:
    """Where in the base what the plant's arm carries is, (F, 3), and from when on what it weighs.

    It carries what the controller's arm, or the plant's at another time, has not.
    """
    places, masses = np.full((len(rows), 3), np.nan), []
    if run._made is None:
        return places, []
    plant = run._made.plant(disturbance=[])
    arms = [run._made.believed, plant.arm, *(arm for _, arm in plant.changes or ())]
    for part, arm in segments(plant, run.t):
        bare = without_load(arm, arms)
        mass = 0.0
        if isinstance(arm, _core.Serial) and isinstance(bare, _core.Serial):
            mass, *first = (arm.inertial_parameters() - bare.inertial_parameters())[-10:][:4]
        masses.append((float(run.t[part.start]), float(mass)))
        if mass > 0.0:
            middle = np.append(np.array(first) / mass, 1.0)
            inside = (rows >= part.start) & (rows < part.stop)
            places[inside] = [(arm.link_poses(run.q[k])[-1] @ middle)[:3] for k in rows[inside]]
    return places, masses if any(mass for _, mass in masses) else []


def _room(runs: Sequence[Run], moving: Sequence[Moving]) -> tuple[Array, Array]:
    """The corners of what is to be seen: the places of all arms, as far as they are not wild."""
    sure = [np.zeros((1, 3))]
    rest: list[Array] = []
    for run, part in zip(runs, moving, strict=True):
        sure.append(part.desired.reshape(-1, 3))
        (sure if run.status.kind in SOUND else rest).append(part.actual.reshape(-1, 3))
    places = np.concatenate(sure)
    low, high = places.min(axis=0), places.max(axis=0)
    if rest:
        spare, wild = (high - low).max(), np.concatenate(rest)
        inside = ((wild >= low - spare) & (wild <= high + spare)).all(axis=1)
        places = np.concatenate([places, wild[inside]])
    return places.min(axis=0), places.max(axis=0)


def _places(moving: Moving, room: tuple[Array, Array], flat: bool) -> dict[str, Any]:
    """An arm's places, packed: where it is, and how far off it should be.

    Of how far off the signed root is packed: small errors keep their digits beside large ones.
    """
    low, high = room
    spare = ROOM * (high - low).max()
    actual = np.clip(moving.actual, low - spare, high + spare)
    off = moving.desired - actual
    off = np.sign(off) * np.sqrt(np.abs(off))
    return {
        "t": packed(moving.t),
        "actual": _columns(actual, flat),
        "off": _columns(off, flat),
        "load": _columns(moving.load[:, None], flat) if moving.masses else None,
        "masses": moving.masses,
    }


def _columns(places: Array, flat: bool) -> list[list[Any]]:
    """The sides of every point over time; one that does not move as a number."""
    sides = 2 if flat else 3
    return [[_side(places[:, point, k]) for k in range(sides)] for point in range(places.shape[1])]


def _side(values: Array) -> Any:
    return float(f"{values[0]:.6g}") if (values == values[0]).all() else packed(values)


def _curves(runs: Sequence[Run], points: int) -> list[dict[str, Any]]:
    """Errors and torques of every run, packed."""
    limits = {name: _limit(runs, name) for name in ("e", "tau")}
    found = []
    for run in runs:
        t, e, tau = run.t, np.asarray(run.e), np.asarray(run.tau)
        if len(t) > points:
            edges = np.linspace(0, len(t), points // 2 + 1).astype(np.intp)
            t = t[np.stack([edges[:-1], edges[1:] - 1], axis=1).ravel()]
            e, tau = envelope(e, edges), envelope(tau, edges) if len(tau) else tau
        signals = {}
        for name, values in (("e", e), ("tau", tau)):
            cut = np.clip(values, -limits[name], limits[name])
            signals[name] = [packed(column) for column in cut.T] if len(cut) else []
        found.append({"t": packed(t), **signals})
    return found


def _limit(runs: Sequence[Run], name: str) -> Array:
    """Where a signal of runs that did not finish is cut, a joint each; inf where all did."""
    sizes = [(run.status.kind in SOUND, np.abs(np.asarray(getattr(run, name)))) for run in runs]
    sound = [size for went_well, size in sizes if went_well and len(size)]
    wild = [size for went_well, size in sizes if not went_well and len(size)]
    if not wild:
        return np.full(runs[0].joints, np.inf)
    if sound:
        limit = np.max([size.max(axis=0) for size in sound], axis=0)
    else:
        limit = np.max([np.quantile(size, 0.9, axis=0) for size in wild], axis=0)
    return np.where(limit > 0.0, ROOM * limit, np.inf)

"""The figures of a controller on a scenario: declared once, and computed from its runs."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

if TYPE_CHECKING:
    from .run import Run

Array = NDArray[np.float64]
Value = float | None
Window = tuple[float, float]


Joined = Literal["root", "length", "largest", "sum", "any", "none"]
"""How the number over all joints comes of those of the joints.

"root" of the sum of squares, which is the RMS of the length of the error; "length", the largest one
of the error; the "largest" of all joints; their "sum"; "any", the share of samples in which it is
so of any joint; "none" has no joints.
"""


@dataclass(frozen=True)
class Figure:
    """A number that says how good a run was; the less, the better."""

    name: str
    """Its attribute of a row."""
    unit: str
    """Its unit; m and N instead of rad and N·m for a prismatic joint."""
    joined: Joined
    head: str
    """What a table calls it."""
    shown: str
    """Unit in tables for people."""
    scale: float
    """How many of ``shown`` are one ``unit``."""
    doc: str


_ERROR, _TORQUE, _TIME = ("mrad", 1e3), ("N·m", 1.0), ("s", 1.0)
_SETTLES = "until the error stays in the band, inf if it does not"

_DECLARED = (
    Figure("rms_e", "rad", "root", "RMS error", *_ERROR, "RMS of the error, whole run"),
    Figure("max_abs_e", "rad", "length", "max error", *_ERROR, "largest error, whole run"),
    Figure("steady_rms_e", "rad", "root", "steady RMS", *_ERROR, "RMS of the error in the window"),
    Figure("settling_time", "s", "largest", "settling", *_TIME, f"from the start {_SETTLES}"),
    Figure("itae", "rad·s²", "sum", "ITAE", "rad·s²", 1.0, "∫ t |e| dt, whole run"),
    Figure("max_abs_tau", "N·m", "largest", "peak torque", *_TORQUE, "largest torque, whole run"),
    Figure("rms_tau", "N·m", "largest", "RMS torque", *_TORQUE, "RMS of the torque in the window"),
    Figure("torque_variation", "N·m/s", "sum", "variation", "N·m/s", 1.0, "Σ|Δτ|/s in the window"),
    Figure("saturated", "1", "any", "saturated", "%", 1e2, "share of samples at the effort limit"),
    Figure("recovery", "s", "largest", "recovery", *_TIME, f"from the last event {_SETTLES}"),
    Figure("frozen_rms_e", "rad", "root", "frozen", *_ERROR, "steady RMS when learning stops"),
    Figure("transfer_rms_e", "rad", "root", "transfer", *_ERROR, "the same on another motion"),
    Figure("step_time", "s", "none", "step", "µs", 1e6, "time of the processor for one step"),
)

FIGURES: dict[str, Figure] = {figure.name: figure for figure in _DECLARED}
"""All figures of a row, by name, in the order of the tables.

An event is a sample at the limit of effort, or one that the scenario tells. The figures with
learning stopped are inf if the run diverged.
"""

JOINTED = tuple(figure.name for figure in _DECLARED if figure.joined != "none")
"""Those of which there is one a joint."""

TOUCHES = 1e-9
"""A torque this close to its limit (relative) is at it."""


def figures(
    run: Run,
    window: Window | None,
    band: float,
    effort_limit: ArrayLike | None,
    events: Iterable[float],
) -> dict[str, Array]:
    """The figures of a run, one a joint, as far as its record has them."""
    whole, steady = run.metrics(band=band), run.metrics(steady_window(run, window), band)
    found = {name: getattr(whole, name) for name in ("rms_e", "max_abs_e", "itae")}
    found |= {"settling_time": whole.settling_time, "max_abs_tau": whole.max_abs_tau}
    found |= {name: getattr(steady, name) for name in ("rms_tau", "torque_variation")}
    found["steady_rms_e"] = steady.rms_e
    limited = _limited(run, effort_limit)
    if limited is not None:
        found["saturated"] = limited.mean(axis=0)
    recovery = _recovery(run, band, limited, events)
    if recovery is not None:
        found["recovery"] = recovery
    return found


def over_all(name: str, joints: Array, run: Run, effort_limit: ArrayLike | None) -> float:
    """The one number over all joints."""
    joined = FIGURES[name].joined
    if joined == "any":
        limited = _limited(run, effort_limit)
        return 0.0 if limited is None else float(limited.any(axis=1).mean())
    if joined == "length":
        return float(np.hypot.reduce(run.e, axis=1).max())
    if joined == "root":
        return float(np.hypot.reduce(joints))
    return float(joints.sum() if joined == "sum" else joints.max())


def survives(run: Run, window: Window | None) -> Array | None:
    """Steady RMS of each joint of a run with learning stopped; inf if it diverged."""
    if run.status.kind == "diverged":
        return np.full(run.joints, math.inf)
    if run.status.kind == "interrupted":
        return None
    return run.metrics(steady_window(run, window)).rms_e


def steady_window(run: Run, window: Window | None) -> Window:
    """The window; the second half of the run by default."""
    if window is not None:
        return window
    return (0.5 * float(run.t[0] + run.t[-1]), float(run.t[-1]))


def _limited(run: Run, effort_limit: ArrayLike | None) -> NDArray[np.bool_] | None:
    """Which torques are at their limit, (T, n); None without a limit, or without torques."""
    if effort_limit is None or not len(run.tau):
        return None
    limit = np.asarray(effort_limit, dtype=float)
    if limit.shape not in ((), (run.joints,)) or not (limit > 0).all():
        wants = f"a number > 0, or {run.joints} of them [N·m]"
        raise ValueError(f"effort_limit: got {effort_limit!r}, wants {wants}")
    at: NDArray[np.bool_] = np.abs(run.tau) >= limit * (1.0 - TOUCHES)
    return at


def _recovery(
    run: Run, band: float, limited: NDArray[np.bool_] | None, events: Iterable[float]
) -> Array | None:
    """From the last event, or sample at the limit, until each error stays in the band [s]."""
    starts = [float(event) for event in events if run.t[0] <= event <= run.t[-1]]
    if limited is not None and limited.any():
        starts.append(float(run.t[np.flatnonzero(limited.any(axis=1))[-1]]))
    if not starts:
        return None
    start = max(starts)
    outside = np.abs(run.e) > band
    recovered = np.empty(run.joints)
    for joint in range(run.joints):
        last = np.flatnonzero(outside[:, joint])
        if not len(last) or run.t[last[-1]] < start:
            recovered[joint] = 0.0
        elif last[-1] + 1 == len(run.t):
            recovered[joint] = math.inf
        else:
            recovered[joint] = run.t[last[-1] + 1] - start
    return recovered


def median(values: Sequence[float]) -> Value:
    """The median, infinities included; None of none."""
    if not values:
        return None
    ordered, half = sorted(values), len(values) // 2
    if len(values) % 2 or ordered[half - 1] == ordered[half]:
        return ordered[half]
    return 0.5 * ordered[half - 1] + 0.5 * ordered[half]


def number(name: str, value: object) -> Value:
    """A figure as a float; None where it does not apply, which is what NaN means too."""
    if value is None:
        return None
    if isinstance(value, bool | np.bool_ | str) or not isinstance(
        value, float | int | np.floating | np.integer
    ):
        raise TypeError(f"{name}: got {value!r}, wants a number or None")
    number = float(value)
    return None if math.isnan(number) else number


def joints_of(by_joint: Mapping[str, Sequence[object]]) -> dict[str, tuple[Value, ...]]:
    """Figures by joint, checked, in the order of `FIGURES`, without what does not apply."""
    unknown = [name for name in by_joint if name not in JOINTED]
    if unknown:
        raise ValueError(f"by_joint: got {unknown[0]!r}, wants {', '.join(JOINTED)}")
    checked = {}
    for name in (name for name in FIGURES if name in by_joint):
        values = [number(f"by_joint[{name!r}]", value) for value in by_joint[name]]
        while values and values[-1] is None:
            values.pop()
        if values:
            checked[name] = tuple(values)
    return checked

"""The work of a sweep: points to rows. A worker needs this module, numpy and the core alone."""

from __future__ import annotations

import math
import signal
import threading
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from types import FrameType
from typing import Any, Protocol

import numpy as np

from ._figures import FIGURES
from ._joints import in_length, lengths
from ._scene import VERSION
from ._sweep_folder import RAISED
from ._sweep_plan import TAKEN, is_text
from .compare_runner import _words
from .many import simulate_many
from .metrics import NAMES, UNITS

Row = dict[str, Any]
Together = dict[str, list[tuple[Row, Mapping[str, Any]]]]
"""Runs that share their options."""

PARTS = ("plant", "tracker", "reference")
"""What tells arguments of `simulate` from figures."""

EACH = (*PARTS, "q0", "dq0", "effects")
"""Arguments of which every run of a call has its own."""

ENDS = ("status", "t_end", "reason")
"""Columns that say how a row ended."""

OVERALL = ("rms_e", "itae", "settling_time", "rms_tau", "max_abs_tau", "torque_variation")
"""Figures that those of the joints make one of: the length of the error needs the whole run."""

SHARED = ("duration", "dt", "method", "control_period", "rtol", "atol", "window", "band")
"""Arguments that all runs of a call share."""


class Refused(Exception):
    """A point that a condition said no to, before anything ran."""


class Source(Protocol):
    """What a sweep computes of a point. It is sent to the workers."""

    def made(self, point: Row) -> Mapping[str, Any]:
        """Figures, or arguments of `simulate`."""

    def check(self, points: Iterable[Row]) -> None:
        """Refuse what no point can be computed with. ``points``: the two ends of the plan."""

    def said(self) -> dict[str, Any]:
        """What there is to tell two sources apart, for a file."""


@dataclass(frozen=True)
class Chunk:
    """What a worker sends back."""

    columns: dict[str, list[Any]]
    """The rows by name, without their inputs."""
    units: dict[str, str]
    """Of the figures, by name."""
    seconds: float
    """How long they took, all together."""
    version: str = VERSION
    """Of the package there."""


def computed(source: Source, points: Sequence[Row], threads: int | None) -> Chunk:
    """Compute rows; those that are arguments of `simulate` go into `simulate_many` together."""
    begun = time.perf_counter()
    rows: list[Row] = [ended("interrupted") for _ in points]
    together: Together = {}
    with _noticed() as pressed:
        for row, point in zip(rows, points, strict=True):
            _begin(source, point, row, together)
            if pressed:  # simulations of the function ended then, and its figures are not whole
                row.update(ended("interrupted"))
                break
        else:
            for runs in together.values():
                _simulate(runs, threads)
    units: dict[str, str] = {}
    for (_, made), *_ in together.values():
        units |= _units(getattr(made["plant"], "arm", None))
    return Chunk(_columns(rows), units, time.perf_counter() - begun)


def _begin(source: Source, point: Row, row: Row, together: Together) -> None:
    """Fill a row, or put it to those that are simulated together."""
    try:
        made = source.made(point)
        if isinstance(made, Mapping) and all(name in made for name in PARTS):
            _check_names(point)
            together.setdefault(_shared(made), []).append((row, made))
        else:
            row |= _figures(made, point)
    except Refused as error:
        row |= ended("refused", str(error))
    # Of the user's function: it loses its own row alone, also where it wants to leave.
    except (Exception, SystemExit) as error:
        row |= ended(RAISED, _words(error))


@contextmanager
def _noticed() -> Iterator[list[int]]:
    """What tells whether Ctrl-C was pressed, also where a simulation took it for itself."""
    pressed: list[int] = []
    usual = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or not callable(usual):
        yield pressed
        return

    def notice(number: int, frame: FrameType | None) -> None:
        pressed.append(number)
        usual(number, frame)

    signal.signal(signal.SIGINT, notice)
    try:
        yield pressed
    finally:
        signal.signal(signal.SIGINT, usual)


def _check_names(point: Row) -> None:
    """Refuse inputs with the names of figures: one of both would be lost."""
    for name in point:
        figure, _, joint = name.rpartition("_")
        if name in OVERALL or (figure in NAMES and joint.isdigit()):
            raise ValueError(f"over: got the name {name!r}, which a figure of the runs has")


def ended(status: str, reason: str = "") -> Row:
    """How a row without figures ended."""
    return {"status": status, "reason": reason}


def _shared(made: Mapping[str, Any]) -> str:
    """What runs of one call have in common."""
    known = (*EACH, *SHARED)
    for name in made:
        if name not in known:
            raise ValueError(f"{name}: is no argument of a sweep's run, wants {', '.join(known)}")
    # As lists, whose numbers are written with all digits.
    shared = {name: np.asarray(made[name]).tolist() for name in SHARED if name in made}
    return repr((shared, getattr(getattr(made["plant"], "arm", None), "joints", None)))


def _simulate(runs: Sequence[tuple[Row, Mapping[str, Any]]], threads: int | None) -> None:
    """Fill the rows of runs that share their options."""
    made = [arguments for _, arguments in runs]
    shared: dict[str, Any] = {name: value for name, value in made[0].items() if name in SHARED}
    try:
        starts = {name: _starts(name, made) for name in ("q0", "dq0")}
        each: dict[str, Any] = {name: [it.get(name) for it in made] for name in (*PARTS, "effects")}
        found = simulate_many(**each, **starts, **shared, threads=threads, progress=False).table()
    except Exception as error:
        if len(runs) > 1:  # one of them is wrong: which one shows when they are alone
            for run in runs:
                _simulate([run], threads)
        else:
            runs[0][0].update(ended(RAISED, _words(error)))
        return
    columns = {name: values.tolist() for name, values in found.items()}
    joints = range(1, made[0]["plant"].arm.joints + 1)
    for name in OVERALL:
        of_joints = zip(*(columns[f"{name}_{n}"] for n in joints), strict=True)
        columns[name] = [_over_all(name, values) for values in of_joints]
    ordered = sorted(columns, key=lambda name: (*ENDS, *OVERALL, name).index(name))
    for place, (row, _) in enumerate(runs):
        row |= {name: columns[name][place] for name in ordered}


def _over_all(name: str, values: tuple[float, ...]) -> float:
    """The figure of all joints together, as a comparison has it."""
    if any(map(math.isnan, values)):
        return math.nan
    joined = FIGURES[name].joined
    if joined == "root":
        return math.hypot(*values)
    return math.fsum(values) if joined == "sum" else max(values)


def _units(arm: Any) -> dict[str, str]:
    """The units of the figures of runs with such an arm."""
    moves = list(enumerate(lengths(getattr(arm, "joint_kinds", ())), start=1))
    of_joints = {f"{name}_{n}": in_length(UNITS[name], it) for name in NAMES for n, it in moves}
    joined = "m" if {it for _, it in moves} == {"m"} else "rad"
    all_of = {name: in_length(UNITS[name], joined) for name in OVERALL}
    return {"t_end": "s", **all_of, **of_joints}


def _starts(name: str, made: Sequence[Mapping[str, Any]]) -> Any:
    """Where each run starts, at zero if it does not say."""
    given = [it.get(name) for it in made]
    if all(start is None for start in given):
        return None
    joints = made[0]["plant"].arm.joints
    zero = np.zeros(joints)
    return np.array([np.broadcast_to(zero if it is None else it, joints) for it in given], float)


def _figures(made: Any, point: Row) -> Row:
    """A row of figures as a function gives it: numbers and words by name."""
    if not isinstance(made, Mapping):
        wants = f"figures by name, or arguments of simulate ({', '.join(PARTS)}, …)"
        raise TypeError(f"the function returned {type(made).__name__}, wants {wants}")
    row = ended("finished")
    for name, value in made.items():
        own = name in ("status", "reason")
        if not isinstance(name, str) or name in point or (name in TAKEN and not own):
            raise ValueError(f"the function returned {name!r:.80}, which is no name of a figure")
        if isinstance(value, str):
            if not is_text(value) or (name == "status" and value == "interrupted"):
                raise ValueError(f"the function returned {name} = {value!r:.80}, wants other words")
            row[name] = str(value)
        elif own or np.ndim(value) or np.asarray(value).dtype.kind not in "fiub":
            wants = "words" if own else "a number or words"
            raise TypeError(f"the function returned {name} = {value!r:.80}, wants {wants}")
        else:
            row[name] = float(value)
    return row


def _columns(rows: Iterable[Row]) -> dict[str, list[Any]]:
    """Rows by name. A figure that a row does not have is NaN, or no words."""
    rows = list(rows)
    names = dict.fromkeys(name for row in rows for name in row)
    columns = {}
    for name in names:
        words = any(isinstance(row.get(name), str) for row in rows)
        columns[name] = [row.get(name, "" if words else math.nan) for row in rows]
        if words:
            columns[name] = [it if isinstance(it, str) else repr(it) for it in columns[name]]
    return columns

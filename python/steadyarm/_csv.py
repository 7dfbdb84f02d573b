"""Signals over time in CSV: a column a joint, `q_1`, `q_2` and so on, after the column `t`."""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from .run import Run

MEASURED, DESIRED = ("q", "dq", "ddq"), ("q_d", "dq_d", "ddq_d")
"""Columns of a motion, without the number of the joint."""

PART = 10_000
"""Rows that are made into text at once."""

Columns = dict[str, list[str]]
Rows = list[list[float]]


def table(run: Run, names: Sequence[str] | None = None) -> dict[str, Any]:
    """The columns of a run by name: t, then those of all its signals, or of those named."""
    if isinstance(names, str):
        raise TypeError(f"names: got the text {names!r}, wants a list of signals")
    known = run.channels
    for name in names or ():
        if name not in known:
            raise ValueError(f"names: got {name!r}, wants some of {', '.join(known)}")
    columns = {"t": run.t}
    for name in known if names is None else names:
        array = getattr(run, name)
        if array.ndim == 1:
            columns[name] = array
        else:
            columns |= {_column(name, joint): array[:, joint - 1] for joint in _counted(array)}
    return columns


def text(columns: dict[str, Any]) -> Iterator[str]:
    """A file of these columns, part by part."""
    yield ",".join(columns) + "\n"
    for start in range(0, len(columns["t"]), PART):
        parts = [column[start : start + PART] for column in columns.values()]
        rows = np.stack(parts, axis=1).tolist()
        yield "".join(f"{','.join(map(repr, row))}\n" for row in rows)


def _counted(array: Any) -> range:
    return range(1, array.shape[1] + 1)


def _column(name: str, joint: int) -> str:
    """The name of a joint's column."""
    return f"{name}_{joint}"


def motion(path: str | Path, desired: bool) -> tuple[list[float], Rows, Rows | None, Rows | None]:
    """Read times, positions, velocities and accelerations of `Table` from a file.

    Velocities count where there are accelerations too. Raises ValueError that names the file, and
    the line or the column.
    """
    columns = _columns(path)
    if "t" not in columns:
        raise ValueError(f"{path}: got the columns {', '.join(columns)}; wants one named t [s]")
    position, *rates = DESIRED if desired else MEASURED
    joints = len(_numbers(columns, position))
    if not joints:
        got = ", ".join(columns)
        other = "; desired=True reads q_d_1" if not desired and "q_d_1" in columns else ""
        raise ValueError(f"{path}: got the columns {got}; wants {position}_1 and so on{other}")
    q = _signal(path, columns, position, joints)
    dq, ddq = (_signal(path, columns, name, joints) for name in rates)
    t = [row[0] for row in _read(path, columns, ["t"])]
    return t, q or [], *((dq, ddq) if dq and ddq else (None, None))


def _numbers(columns: Columns, name: str) -> list[int]:
    """The joints that a signal has columns of."""
    found = (re.fullmatch(rf"{name}_(\d+)", column) for column in columns)
    return sorted(int(match[1]) for match in found if match)


def _signal(path: str | Path, columns: Columns, name: str, joints: int) -> Rows | None:
    """The rows of a signal; None if it has no column. One that lacks a joint is refused."""
    numbers = _numbers(columns, name)
    if not numbers:
        return None
    if numbers != list(range(1, joints + 1)):
        got = ", ".join(_column(name, number) for number in numbers)
        wants = f"{_column(name, 1)} to {_column(name, joints)}, a column a joint"
        raise ValueError(f"{path}: got the columns {got}; wants {wants}")
    return _read(path, columns, [_column(name, number) for number in numbers])


def _read(path: str | Path, columns: Columns, names: Sequence[str]) -> Rows:
    """The rows of some columns, as finite numbers."""
    lines = zip(*(columns[name] for name in names), strict=True)
    return [
        [
            _number(cell, f"{path}: row {row}: {name}")
            for name, cell in zip(names, cells, strict=True)
        ]
        for row, cells in enumerate(lines, start=1)
    ]


def _columns(path: str | Path) -> Columns:
    """The cells of a file by the name of their column."""
    try:
        text = Path(path).read_text(encoding="utf-8-sig")
        lines = [line for line in csv.reader(io.StringIO(text, newline=""), strict=True) if line]
    except (csv.Error, UnicodeDecodeError) as error:
        raise ValueError(f"{path}: got {error}, wants a CSV file in UTF-8") from error
    if not lines:
        raise ValueError(f"{path}: got nothing, wants a CSV file with a line of names")
    names = [name.strip() for name in lines[0]]
    if len(names) == 1 and ";" in names[0]:
        raise ValueError(f"{path}: got columns parted by ';', wants commas")
    twice = [name for name in names if names.count(name) > 1]
    if twice:
        raise ValueError(f"{path}: got two columns {twice[0]!r}")
    for number, cells in enumerate(lines[1:], start=1):
        if len(cells) != len(names):
            raise ValueError(f"{path}: row {number}: got {len(cells)} cells, wants {len(names)}")
    return {name: [cells[place] for cells in lines[1:]] for place, name in enumerate(names)}


def _number(cell: str, place: str) -> float:
    """The number in a cell."""
    try:
        number = float(cell)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise ValueError(f"{place}: got {cell!r}, wants a finite number")
    return number

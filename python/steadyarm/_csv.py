"""Signals over time in CSV: a column a joint, `q_1`, `q_2` and so on, after the column `t`."""

from __future__ import annotations

import csv
import io
import math
from pathlib import Path

MEASURED, DESIRED = ("q", "dq", "ddq"), ("q_d", "dq_d", "ddq_d")
"""Columns of a motion, without the number of the joint."""

Columns = dict[str, list[float]]
Rows = list[list[float]]


def motion(path: str | Path, desired: bool) -> tuple[list[float], Rows, Rows | None, Rows | None]:
    """Read times, positions, velocities and accelerations of `Table` from a file.

    Velocities count where there are accelerations too. Raises ValueError that names the file, and
    the line or the column.
    """
    columns = _columns(path)
    names = DESIRED if desired else MEASURED
    if "t" not in columns:
        raise ValueError(f"{path}: got the columns {', '.join(columns)}; wants one named t [s]")
    joints = 0
    while f"{names[0]}_{joints + 1}" in columns:
        joints += 1
    if not joints:
        got = ", ".join(columns)
        other = "; desired=True reads q_d_1" if not desired and "q_d_1" in columns else ""
        raise ValueError(f"{path}: got the columns {got}; wants {names[0]}_1 and so on{other}")
    q, dq, ddq = (_signal(columns, name, joints, len(columns["t"])) for name in names)
    assert q is not None
    return columns["t"], q, *((dq, ddq) if dq and ddq else (None, None))


def _signal(columns: Columns, name: str, joints: int, rows: int) -> Rows | None:
    """The rows of a signal; None if a joint has none."""
    wanted = [f"{name}_{joint + 1}" for joint in range(joints)]
    if not all(column in columns for column in wanted):
        return None
    return [[columns[column][row] for column in wanted] for row in range(rows)]


def _columns(path: str | Path) -> Columns:
    """The columns of a file by name."""
    text = Path(path).read_text(encoding="utf-8-sig")
    try:
        lines = list(csv.reader(io.StringIO(text, newline=""), strict=True))
    except csv.Error as error:
        raise ValueError(f"{path}: got {error}, wants a CSV file") from error
    if not lines:
        raise ValueError(f"{path}: got nothing, wants a CSV file with a line of names")
    names = [name.strip() for name in lines[0]]
    twice = [name for name in names if names.count(name) > 1]
    if twice:
        raise ValueError(f"{path}: got two columns {twice[0]!r}")
    columns: Columns = {name: [] for name in names}
    for number, cells in enumerate(lines[1:], start=2):
        if not cells:
            continue
        if len(cells) != len(names):
            raise ValueError(f"{path}: line {number}: got {len(cells)} cells, wants {len(names)}")
        for name, cell in zip(names, cells, strict=True):
            columns[name].append(_number(cell, f"{path}: line {number}: {name}"))
    return columns


def _number(cell: str, place: str) -> float:
    """The number in a cell; NaN for what is empty or text, which a motion refuses by its place."""
    try:
        return float(cell) if cell.strip() else math.nan
    except ValueError:
        raise ValueError(f"{place}: got {cell!r}, wants a number") from None

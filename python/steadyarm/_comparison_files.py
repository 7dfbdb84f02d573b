"""Comparisons in files: rows as CSV, everything as JSON, the same bytes for the same rows."""

from __future__ import annotations

import csv
import io
import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import _files
from ._curves import Curves
from ._figures import FIGURES, Value
from .comparison import Row

if TYPE_CHECKING:
    from .comparison import Comparison

FORMAT = "steadyarm comparison"
VERSION = 1

LIMIT = 1 << 30
"""A larger file is refused [bytes]."""

TEXTS = ("controller", "scenario", "status", "reason")


def to_csv(comparison: Comparison, path: str | Path) -> None:
    """Write the file of `Comparison.to_csv`: texts in quotes, numbers as Python prints them."""
    names, lines = comparison.columns()
    sink = io.StringIO(newline="")
    writer = csv.writer(sink, quoting=csv.QUOTE_NONNUMERIC, lineterminator="\n")
    writer.writerow(names)
    writer.writerows(lines)
    _files.content(path, sink.getvalue().encode())


def from_csv(path: str | Path) -> list[Row]:
    """Read the rows that `to_csv` wrote."""
    text = _text(path)
    try:
        head, *lines = csv.reader(io.StringIO(text, newline=""), strict=True)
    except (csv.Error, ValueError) as error:
        raise ValueError(f"{path}: got {error}, wants a CSV file of a comparison") from error
    missing = [name for name in (*TEXTS, "seed") if name not in head]
    if missing:
        raise ValueError(f"{path}: wants a column {missing[0]!r}")
    rows = []
    for number, cells in enumerate(lines, start=2):
        try:
            if len(cells) != len(head):
                raise ValueError(f"got {len(cells)} cells, wants {len(head)}")
            rows.append(_row(dict(zip(head, cells, strict=True))))
        except (TypeError, ValueError) as error:
            raise ValueError(f"{path}: row {number}: {error}") from error
    return rows


def _row(cells: dict[str, str]) -> Row:
    """The row of a line of a CSV file."""
    arguments: dict[str, Any] = {name: cells.pop(name) for name in TEXTS}
    arguments["seed"] = _whole(cells.pop("seed"))
    values = {name: _number(name, cell) for name, cell in cells.items()}
    by_joint: dict[str, dict[int, Value]] = {}
    for name, value in values.items():
        figure, _, joint = name.rpartition("_")
        if name in FIGURES:
            arguments[name] = value
        elif figure in FIGURES and joint.isdecimal():
            if value is not None:
                by_joint.setdefault(figure, {})[int(joint)] = value
        else:
            raise ValueError(f"got a column {name!r}, wants one of {', '.join(FIGURES)}")
    joints = {
        name: tuple(known.get(joint) for joint in range(1, max(known) + 1))
        for name, known in by_joint.items()
    }
    return Row(**arguments, by_joint=joints)


def _whole(cell: str) -> int:
    try:
        return int(cell)
    except ValueError as error:
        raise ValueError(f"seed: got {cell!r}, wants a whole number") from error


def _number(name: str, cell: object) -> Value:
    """A figure from a file; "inf" and "-inf" are text in JSON."""
    if cell is None or cell == "":
        return None
    try:
        value = float(cell) if isinstance(cell, str | int | float) else math.nan
    except (ValueError, OverflowError):
        value = math.nan
    if math.isnan(value) or isinstance(cell, bool):
        raise ValueError(f"{name}: got {cell!r}, wants a number")
    return value


def to_json(comparison: Comparison, path: str | Path) -> None:
    """Write the file of `Comparison.to_json`."""
    _files.content(path, f"{json_of(comparison)}\n".encode())


def json_of(comparison: Comparison) -> str:
    """The text of it, a row a line."""
    head = {
        "format": FORMAT,
        "version": VERSION,
        "scenario": comparison.scenario,
        "notes": list(comparison.notes),
        "units": {name: figure.unit for name, figure in FIGURES.items()},
    }
    lines = ",\n".join(_dumped(_plain(row)) for row in comparison.rows)
    return f'{_dumped(head)[:-1]}, "rows": [\n{lines}\n]}}'


def _plain(row: Row) -> dict[str, Any]:
    plain: dict[str, Any] = {name: getattr(row, name) for name in (*TEXTS, "seed")}
    plain |= {name: _written(getattr(row, name)) for name in FIGURES}
    plain["by_joint"] = {
        name: [_written(value) for value in values] for name, values in row.by_joint.items()
    }
    plain["curves"] = None if row.curves is None else row.curves.plain()
    return plain


def _written(value: Value) -> float | str | None:
    return str(value) if value is not None and math.isinf(value) else value


def _dumped(plain: object) -> str:
    return json.dumps(plain, ensure_ascii=False, allow_nan=False)


def from_json(path: str | Path) -> dict[str, Any]:
    """Read the arguments of the comparison that `to_json` wrote."""
    try:
        plain = json.loads(_text(path))
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{path}: got {error}, wants a JSON file of a comparison") from error
    if not isinstance(plain, dict) or plain.get("format") != FORMAT:
        raise ValueError(f"{path}: wants a file with the format {FORMAT!r}")
    if plain.get("version") != VERSION:
        got = plain.get("version")
        raise ValueError(f"{path}: version: got {got!r}, wants {VERSION}; update steadyarm")
    for name in ("rows", "notes"):
        if not isinstance(plain.get(name), list):
            raise ValueError(f"{path}: {name}: got {plain.get(name)!r:.40}, wants a list")
    built = []
    for index, row in enumerate(plain["rows"]):
        try:
            built.append(_from_plain(row))
        except (TypeError, ValueError) as error:
            raise ValueError(f"{path}: rows[{index}]: {error}") from error
    return {"rows": built, "scenario": plain.get("scenario", ""), "notes": plain["notes"]}


def _from_plain(plain: Any) -> Row:
    if not isinstance(plain, dict) or "controller" not in plain:
        raise ValueError("wants an object with a controller")
    known = {*TEXTS, "seed", *FIGURES, "by_joint", "curves"}
    unknown = [name for name in plain if name not in known]
    if unknown:
        raise ValueError(f"got a key {unknown[0]!r}, wants some of {', '.join(sorted(known))}")
    arguments = {name: plain[name] for name in (*TEXTS, "seed") if name in plain}
    arguments |= {name: _number(name, plain.get(name)) for name in FIGURES}
    joints = plain.get("by_joint", {})
    if not isinstance(joints, dict) or not all(isinstance(part, list) for part in joints.values()):
        raise ValueError("by_joint: wants an object of lists")
    arguments["by_joint"] = {
        name: tuple(_number(f"by_joint.{name}", value) for value in values)
        for name, values in joints.items()
    }
    curves = plain.get("curves")
    return Row(**arguments, curves=None if curves is None else Curves.from_plain(curves))


def _text(path: str | Path) -> str:
    try:
        return _files.read(path, LIMIT).decode()
    except UnicodeDecodeError as error:
        raise ValueError(f"{path}: wants UTF-8 text") from error
